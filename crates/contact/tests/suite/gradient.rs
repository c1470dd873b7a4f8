//! Derivatives of contacts: difference quotients, limits, refusals.

use approx::assert_relative_eq;
use gfmd_contact::{Boundary, Contact, Cotangents, Equilibrium, GradientError, Load, Solution};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_surface::{Discretisation, SelfAffine};
use ndarray::Array2;

fn rough(grid: &Grid) -> Array2<f64> {
    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: grid.points()[0] as f64 / 8.0, eps_c_inv: 4.0 };
    numbers.self_affine(1.0, SelfAffine { hurst: 0.8, ..SelfAffine::with_rms_gradient(0.1) }).heights(grid, 1).unwrap()
}

/// Returns a body with all moduli multiplied by `factor`.
fn body(height: Option<f64>, factor: f64) -> Body {
    let material = Material::from_contact_modulus(factor, 0.3).unwrap();
    height.map_or_else(|| Body::half_space(material), |height| Body::slab(material, height).unwrap())
}

/// Boundary, height of the slab, and load of a case.
#[derive(Clone, Copy, Debug)]
struct Case {
    boundary: Boundary,
    height: Option<f64>,
    load: Load,
}

impl Case {
    fn solve(self, grid: &Grid, heights: &Array2<f64>, factor: f64) -> (Contact, Solution) {
        let contact = Contact::with_boundary(self.boundary, &body(self.height, factor), grid, heights).unwrap();
        let solution = contact.press(self.load).tolerance(1e-13).solve().unwrap();
        (contact, solution)
    }

    fn with_load(self, change: f64) -> Self {
        let load = match self.load {
            Load::MeanPressure(load) => Load::MeanPressure(load + change),
            Load::Approach(load) => Load::Approach(load + change),
        };
        Self { load, ..self }
    }
}

/// Returns a smooth field without symmetries.
fn field(grid: &Grid, phase: f64) -> Array2<f64> {
    Array2::from_shape_fn(grid.points(), |(i, j)| (1.3 * i as f64 + phase).sin() * (0.7 * j as f64 - phase).cos() + 0.3)
}

fn cotangents(grid: &Grid) -> Cotangents {
    Cotangents {
        pressure: Some(field(grid, 0.4)),
        gap: Some(field(grid, 1.9)),
        approach: 3.0,
        mean_pressure: -2.0,
        mean_gap: 5.0,
        elastic_energy: 70.0,
        ..Cotangents::default()
    }
}

fn value(of: &Cotangents, solution: &Solution) -> f64 {
    let n = solution.pressure.len() as f64;
    let product = |a: &Option<Array2<f64>>, b: &Array2<f64>| a.as_ref().map_or(0.0, |a| (a * b).sum());
    let energy = -0.5 * (&solution.pressure * &solution.displacement).sum() / n;
    let open = solution.gap.iter().zip(&solution.pressure).filter(|(_, p)| **p == 0.0).map(|(g, _)| *g).sum::<f64>();
    product(&of.pressure, &solution.pressure)
        + product(&of.gap, &solution.gap.clone())
        + of.approach * solution.approach
        + of.mean_pressure * solution.mean_pressure
        + of.mean_gap * open / n
        + of.elastic_energy * energy
}

/// Returns half the difference of the number at two states, if the same points touch.
fn difference(of: &Cotangents, [a, b]: [&Solution; 2]) -> Option<f64> {
    let alike = a.pressure.iter().zip(&b.pressure).all(|(a, b)| (*a > 0.0) == (*b > 0.0));
    alike.then(|| 0.5 * (value(of, b) - value(of, a)))
}

#[test]
fn derivatives_are_difference_quotients() {
    let grid = Grid::new([16, 12], [1.0, 0.8]).unwrap();
    let heights = rough(&grid);
    let of = cotangents(&grid);
    let pressures = [0.004, 0.05].map(Load::MeanPressure);
    let loads = pressures.into_iter().chain([Load::Approach(0.004)]);
    for load in loads {
        for (boundary, height) in [
            (Boundary::Periodic, None),
            (Boundary::Periodic, Some(0.2)),
            (Boundary::Free, None),
            (Boundary::Free, Some(0.5)),
        ] {
            let case = Case { boundary, height, load };
            let (contact, solution) = case.solve(&grid, &heights, 1.0);
            let found = contact.gradient(&solution, load, &of).unwrap();
            assert!(found.error <= 1e-9 && found.effort.iterations < 60, "{case:?}: {:?}", found.effort);
            let near = |found: f64, wanted: f64, name: &str| {
                assert!(
                    (found - wanted).abs() <= 1e-5 * (wanted.abs() + 1e-3 * value(&of, &solution).abs()),
                    "{case:?}, {name}: {found} {wanted}"
                );
            };
            let mut checked = 0;
            for index in 0..24 {
                let (i, j) = (index * 7 % 16, index * 5 % 12);
                let step = 1e-7;
                let [low, high] = [-step, step].map(|change| {
                    let mut moved = heights.clone();
                    moved[[i, j]] += change;
                    case.solve(&grid, &moved, 1.0).1
                });
                if let Some(difference) = difference(&of, [&low, &high]) {
                    checked += 1;
                    near(found.heights[[i, j]], difference / step, "height");
                }
            }
            assert!(checked >= 20, "{case:?}: {checked}");
            let step = 1e-6
                * match load {
                    Load::MeanPressure(load) | Load::Approach(load) => load,
                };
            let [low, high] = [-step, step].map(|change| case.with_load(change).solve(&grid, &heights, 1.0).1);
            near(found.load, difference(&of, [&low, &high]).unwrap() / step, "load");
            let step = 1e-6;
            let [low, high] = [-step, step].map(|change| case.solve(&grid, &heights, 1.0 + change).1);
            near(found.modulus, difference(&of, [&low, &high]).unwrap() / step, "modulus");
        }
    }
}

#[test]
fn the_derivative_of_the_mean_pressure_by_the_approach_is_the_stiffness() {
    let grid = Grid::square(64, 1.0).unwrap();
    let contact = Contact::new(&body(None, 1.0), &grid, &rough(&grid)).unwrap();
    let solution = contact.press(Load::MeanPressure(0.01)).tolerance(1e-12).solve().unwrap();
    let stiffness = contact.stiffness(&solution, 1e-9).unwrap().value;
    let of = Cotangents { mean_pressure: 1.0, ..Cotangents::default() };
    let driven = contact.gradient(&solution, Load::Approach(solution.approach), &of).unwrap();
    assert_relative_eq!(driven.load, stiffness, max_relative = 1e-8);
    let of = Cotangents { approach: 1.0, ..Cotangents::default() };
    let pressed = contact.gradient(&solution, Load::MeanPressure(0.01), &of).unwrap();
    assert_relative_eq!(pressed.load, 1.0 / stiffness, max_relative = 1e-8);
    // A constant in the heights has no effect, and the approach is proportional to all lengths together.
    assert!(pressed.heights.sum().abs() < 1e-8, "{}", pressed.heights.sum());
    let scaled = (&pressed.heights * &rough(&grid)).sum() + 0.01 * pressed.load;
    assert_relative_eq!(scaled, solution.approach, max_relative = 1e-6);
    assert_relative_eq!(pressed.modulus, -0.01 * pressed.load, max_relative = 1e-6);
}

#[test]
fn units_and_full_contact_change_nothing() {
    let grid = Grid::square(16, 1.0).unwrap();
    let heights = rough(&grid);
    let of = Cotangents { pressure: Some(field(&grid, 0.4)), elastic_energy: 1e-3, ..Cotangents::default() };
    let (case, factor) =
        (Case { boundary: Boundary::Periodic, height: None, load: Load::MeanPressure(0.01) }, 2.0_f64.powi(120));
    let (contact, solution) = case.solve(&grid, &heights, 1.0);
    let plain = contact.gradient(&solution, case.load, &of).unwrap();
    let large = Case { load: Load::MeanPressure(0.01 * factor), ..case };
    let (contact, solution) = large.solve(&grid, &heights, factor);
    let scaled = contact.gradient(&solution, large.load, &of).unwrap();
    let near = |a: f64, b: f64| assert_relative_eq!(a, b, max_relative = 1e-8, epsilon = 1e-10);
    plain.heights.iter().zip(&scaled.heights).for_each(|(a, b)| near(*a, b / factor));
    near(plain.load, scaled.load);
    near(plain.modulus, scaled.modulus);
    // In full contact the pressure is linear in the heights.
    let full = Case { load: Load::MeanPressure(5.0), ..case };
    let (contact, solution) = full.solve(&grid, &heights, 1.0);
    assert!(solution.pressure.iter().all(|p| *p > 0.0));
    let found = contact.gradient(&solution, full.load, &of).unwrap();
    assert_relative_eq!(found.load, field(&grid, 0.4).sum(), max_relative = 1e-8);
    let undetermined = contact.gradient(&solution, Load::Approach(1.0), &of).unwrap_err();
    assert!(matches!(undetermined, GradientError::Undetermined(_)), "{undetermined}");
}

/// Points at the hardness keep their pressure, and are pressed in more or less.
#[test]
fn a_hardness_has_derivatives_of_its_own() {
    let grid = Grid::new([16, 12], [1.0, 0.8]).unwrap();
    let heights = rough(&grid);
    let of = Cotangents { plastic_depth: Some(100.0 * field(&grid, 2.7)), ..cotangents(&grid) };
    for load in [Load::MeanPressure(0.03), Load::Approach(0.02)] {
        for (boundary, hardness) in [(Boundary::Periodic, 0.06), (Boundary::Free, 0.06)] {
            let solve = |heights: &Array2<f64>, hardness: f64, load: Load| {
                let contact = Contact::with_boundary(boundary, &body(None, 1.0), &grid, heights).unwrap();
                let contact = contact.with_hardness(hardness).unwrap();
                let solution = contact.press(load).tolerance(1e-13).solve().unwrap();
                (contact, solution)
            };
            let total = |solution: &Solution| {
                let depth = &solution.plastic.as_ref().unwrap().depth;
                value(&of, solution) + (of.plastic_depth.as_ref().unwrap() * depth).sum()
            };
            let (contact, solution) = solve(&heights, hardness, load);
            let plastic = solution.pressure.iter().filter(|p| **p >= hardness).count();
            let elastic = solution.pressure.iter().filter(|p| **p > 0.0 && **p < hardness).count();
            assert!(plastic > 2 && elastic > 2, "{plastic} {elastic}");
            let found = contact.gradient(&solution, load, &of).unwrap();
            let near = |found: f64, moved: &dyn Fn(f64) -> Solution, step: f64, size: f64| {
                let wanted = (total(&moved(step)) - total(&moved(-step))) / (2.0 * step);
                assert!((found - wanted).abs() <= 1e-5 * (wanted.abs() + size), "{load:?}: {found} {wanted}");
            };
            let most = found.heights.iter().fold(0.0, |most: f64, by| most.max(by.abs()));
            for index in 0..12 {
                let place = [index * 7 % 16, index * 5 % 12];
                let moved = |change: f64| {
                    let mut moved = heights.clone();
                    moved[place] += change;
                    solve(&moved, hardness, load).1
                };
                near(found.heights[place], &moved, 1e-8, 0.01 * most);
            }
            let by_hardness = found.hardness.unwrap().sum();
            near(by_hardness, &|change| solve(&heights, hardness + change, load).1, 1e-7, 0.0);
            let by_load = |change: f64| match load {
                Load::MeanPressure(mean) => solve(&heights, hardness, Load::MeanPressure(mean + change)).1,
                Load::Approach(approach) => solve(&heights, hardness, Load::Approach(approach + change)).1,
            };
            near(found.load, &by_load, 1e-8, 0.0);
        }
    }
}

#[test]
fn unusable_derivatives_are_refused() {
    let grid = Grid::square(16, 1.0).unwrap();
    let case = Case { boundary: Boundary::Periodic, height: None, load: Load::MeanPressure(0.01) };
    let (contact, solution) = case.solve(&grid, &rough(&grid), 1.0);
    let refused = |of: &Cotangents| contact.gradient(&solution, case.load, of).unwrap_err().to_string();
    let none = Cotangents::default;
    assert!(
        refused(&Cotangents { gap: Some(Array2::zeros((3, 4))), ..none() }).contains("[3, 4]; it must be [16, 16]")
    );
    let bad = Array2::from_elem((16, 16), f64::NAN);
    assert!(refused(&Cotangents { pressure: Some(bad), ..none() }).contains("by the pressure has NaN"));
    assert!(refused(&Cotangents { mean_gap: f64::INFINITY, ..none() }).contains("by the mean gap has inf"));
    let depth = Cotangents { plastic_depth: Some(Array2::zeros((16, 16))), ..none() };
    assert!(refused(&depth).starts_with("the derivative by the plastic depth is given; it must be left out"));
    assert!(contact.with_hardness(0.05).unwrap().gradient(&solution, case.load, &depth).is_ok());
    let line = Grid::line(32, 1.0).unwrap();
    let wave = Array2::from_shape_fn((32, 1), |(i, _)| 0.01 * (0.2 * i as f64).cos());
    let contact = Contact::with_boundary(Boundary::Free, &body(None, 1.0), &line, &wave).unwrap();
    let solution = contact.press(Load::MeanPressure(0.01)).solve().unwrap();
    let by_load = contact.gradient(&solution, case.load, &Cotangents { approach: 1.0, ..none() }).unwrap().load;
    let stiffness = contact.stiffness(&solution, 1e-10).unwrap().value;
    assert!((by_load * stiffness - 1.0).abs() < 1e-8, "{by_load} {stiffness}");
    // Without derivatives of the number there is no gradient.
    let zero = contact.gradient(&solution, case.load, &none()).unwrap();
    assert_eq!((zero.load, zero.modulus, zero.heights.sum()), (0.0, 0.0, 0.0));
}
