//! Stiffness of a contact: difference quotients, dense solutions, limits, cost.

use gfmd_contact::{Boundary, Contact, Equilibrium, Load, Solution, Stiffness};
use gfmd_field::Grid;
use gfmd_green::{Base, Body, Material};
use gfmd_response::{NormalResponse, NormalTransforms};
use gfmd_surface::{Discretisation, SelfAffine};
use ndarray::Array2;

fn material(poisson: f64) -> Material {
    Material::from_contact_modulus(1.0, poisson).unwrap()
}

fn half_space() -> Body {
    Body::half_space(material(0.0))
}

fn rough(grid: &Grid) -> Array2<f64> {
    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: grid.points()[0] as f64 / 8.0, eps_c_inv: 4.0 };
    numbers.self_affine(1.0, SelfAffine { hurst: 0.8, ..SelfAffine::with_rms_gradient(0.1) }).heights(grid, 1).unwrap()
}

fn value(contact: &Contact, state: &Solution) -> f64 {
    let found = contact.stiffness(state, 1e-9).unwrap();
    assert!(found.error <= 1e-9, "{found:?}");
    is_as_exact_as_stated(contact.stiffness(state, Stiffness::TOLERANCE).unwrap(), found);
    found.value
}

fn is_as_exact_as_stated(usual: Stiffness, found: Stiffness) {
    let differ = (usual.value - found.value).abs();
    let is_within = differ <= (usual.error + 1e-9) * found.value;
    assert!(is_within || usual.value == found.value, "{usual:?} {found:?}");
    assert!(usual.error <= Stiffness::TOLERANCE, "{usual:?}");
}

/// Computes mean pressure divided by displacement for a uniform displacement of the contact, by Gaussian elimination.
fn dense(grid: Grid, body: &Body, state: &Solution) -> f64 {
    let response = std::sync::Arc::new(NormalResponse::new(grid, body));
    let mut transforms = NormalTransforms::of(&response);
    let inside: Vec<usize> = state.pressure.iter().enumerate().filter(|(_, p)| **p > 0.0).map(|(i, _)| i).collect();
    let mut rows: Vec<Vec<f64>> = vec![];
    for &i in &inside {
        let (mut one, mut image) = (vec![0.0; grid.len()], vec![0.0; grid.len()]);
        one[i] = 1.0;
        transforms.convolve(response.compliance(), &one, &mut image);
        let uniform = response.uniform_compliance() / grid.len() as f64;
        rows.push(inside.iter().map(|&j| image[j] + uniform).chain([1.0]).collect());
    }
    let m = inside.len();
    for k in 0..m {
        let (above, below) = rows.split_at_mut(k + 1);
        for row in below {
            let factor = row[k] / above[k][k];
            row.iter_mut().zip(&above[k]).skip(k).for_each(|(a, b)| *a -= factor * b);
        }
    }
    let mut pressure = vec![0.0; m];
    for k in (0..m).rev() {
        let known: f64 = (k + 1..m).map(|j| rows[k][j] * pressure[j]).sum();
        pressure[k] = (rows[k][m] - known) / rows[k][k];
    }
    pressure.iter().sum::<f64>() / grid.len() as f64
}

#[test]
fn layers_have_the_stiffness_of_a_dense_solution() {
    let grid = Grid::new([24, 20], [1.0, 0.9]).unwrap();
    let heights =
        Array2::from_shape_fn((24, 20), |(i, j)| 0.01 * ((0.9 * i as f64).sin() + (1.1 * j as f64 + 0.3).cos()));
    for (poisson, height) in [(0.3, 0.5), (0.45, 0.05), (0.5, 0.3)] {
        let body = Body::slab(material(poisson), height).unwrap();
        let contact = Contact::new(&body, &grid, &heights).unwrap();
        for mean in [0.002, 0.02] {
            let state = contact.press(Load::MeanPressure(mean)).tolerance(1e-11).solve().unwrap();
            let exact = dense(grid, &body, &state);
            approx::assert_relative_eq!(value(&contact, &state), exact, max_relative = 1e-9);
        }
    }
}

/// Constants continued to very few points resist only by rounding errors, which must not steer the search.
#[test]
fn layers_near_full_contact_have_the_stiffness_of_a_dense_solution() {
    let ([line, square], poisson) = ([Grid::line(35, 1.0), Grid::new([11, 9], [1.0, 0.9])].map(Result::unwrap), 0.3);
    for grid in [line, square] {
        let points = grid.points();
        let heights = Array2::from_shape_fn(points, |(i, j)| 0.01 * (0.9 * i as f64 + 2.0 * j as f64).sin());
        for (base, height) in [(Base::SLIDING, 0.13), (Base::SLIDING, 0.4), (Base::BONDED, 0.05), (Base::BONDED, 0.3)] {
            let body = Body::slab(material(poisson), height).unwrap().on(base).unwrap();
            let contact = Contact::new(&body, &grid, &heights).unwrap();
            for apart in [&[3][..], &[3, 4], &[3, 20], &[3, 4, 5], &[1, 3, 17, 24], &[3, 4, 5, 6, 7, 8, 9]] {
                let place = |i: usize, j: usize| i * points[1] + j;
                let pressure =
                    Array2::from_shape_fn(points, |(i, j)| if apart.contains(&place(i, j)) { 0.0 } else { 1.0 });
                let state = contact.certify(&pressure, Load::MeanPressure(1.0)).unwrap();
                let exact = dense(grid, &body, &state);
                approx::assert_relative_eq!(value(&contact, &state), exact, max_relative = 1e-9);
            }
        }
    }
}

#[test]
fn it_is_the_slope_of_the_mean_pressure_over_the_approach() {
    let grid = Grid::square(64, 1.0).unwrap();
    let heights = rough(&grid);
    let slab = Body::slab(material(0.4), 0.3).unwrap();
    for (boundary, body, hardness) in [
        (Boundary::Periodic, half_space(), None),
        (Boundary::Periodic, slab, None),
        (Boundary::Free, half_space(), None),
        (Boundary::Free, half_space(), Some(0.08)),
    ] {
        let mut contact = Contact::with_boundary(boundary, &body, &grid, &heights).unwrap();
        if let Some(hardness) = hardness {
            contact = contact.with_hardness(hardness).unwrap();
        }
        let press = |load| contact.press(load).tolerance(1e-12).solve().unwrap();
        let middle = press(Load::MeanPressure(0.01));
        // Points that enter or leave between the two states change the quotient by the square of the step.
        let step = 1e-5;
        let [low, high] = [-step, step].map(|part| press(Load::Approach(middle.approach * (1.0 + part))));
        let quotient = (high.mean_pressure - low.mean_pressure) / (high.approach - low.approach);
        approx::assert_relative_eq!(value(&contact, &middle), quotient, max_relative = 1e-4);
    }
}

#[test]
fn limits_have_their_values() {
    let grid = Grid::square(32, 1.0).unwrap();
    let heights = rough(&grid);
    let full = Load::MeanPressure(1.0);
    // A fixed mean level.
    let contact = Contact::new(&half_space(), &grid, &heights).unwrap();
    let state = contact.press(full).solve().unwrap();
    assert_eq!(value(&contact, &state), f64::INFINITY);
    // A slab that moves as a whole.
    let body = Body::slab(material(0.25), 0.4).unwrap();
    let contact = Contact::new(&body, &grid, &heights).unwrap();
    let state = contact.press(full).solve().unwrap();
    approx::assert_relative_eq!(value(&contact, &state), 1.0 / body.normal_compliance(0.0), max_relative = 1e-14);
    // A profile with free boundaries: the slope of the pressure against the approach.
    let line = Grid::line(32, 1.0).unwrap();
    let profile = Array2::from_shape_fn((32, 1), |(i, _)| heights[[i, 3]]);
    let contact = Contact::with_boundary(Boundary::Free, &half_space(), &line, &profile).unwrap();
    let [below, state, above] = [-1e-7, 0.0, 1e-7].map(|more| {
        let approach = contact.press(Load::MeanPressure(0.01)).tolerance(1e-12).solve().unwrap().approach + more;
        contact.press(Load::Approach(approach)).tolerance(1e-12).solve().unwrap()
    });
    let slope = (above.mean_pressure - below.mean_pressure) / (above.approach - below.approach);
    approx::assert_relative_eq!(contact.stiffness(&state, 1e-9).unwrap().value, slope, max_relative = 1e-4);
    // Every point at the hardness or apart.
    let contact = Contact::new(&half_space(), &grid, &heights).unwrap().with_hardness(0.01).unwrap();
    let pressure = heights.mapv(|h| if h > 0.0 { 0.01 } else { 0.0 });
    let state = contact.certify(&pressure, Load::Approach(0.01)).unwrap();
    assert_eq!(value(&contact, &state), 0.0);
}

#[test]
fn a_flat_punch_and_units_far_from_one() {
    // Many times smaller than its distance from its images: 2 E* a/(Lx Ly).
    let n = 128;
    let grid = Grid::square(n, 1.0).unwrap();
    let disc = |a: f64| {
        Array2::from_shape_fn((n, n), |(i, j)| {
            let [x, y] = [i, j].map(|k| (k as f64 + 0.5) / n as f64 - 0.5);
            if x.hypot(y) < a { 0.0 } else { -1.0 }
        })
    };
    let contact = Contact::with_boundary(Boundary::Free, &half_space(), &grid, &disc(0.25)).unwrap();
    let state = contact.press(Load::MeanPressure(1e-3)).tolerance(1e-12).solve().unwrap();
    let stiffness = value(&contact, &state);
    assert!((stiffness - 0.5).abs() < 0.01, "{stiffness}");
    // A linear contact: the secant is the tangent.
    approx::assert_relative_eq!(stiffness, state.mean_pressure / state.approach, max_relative = 1e-8);
    let far = Grid::square(n, 1e40).unwrap();
    let stiff = Body::half_space(Material::from_contact_modulus(1e-60, 0.0).unwrap());
    let contact = Contact::with_boundary(Boundary::Free, &stiff, &far, &(1e-30 * disc(0.25))).unwrap();
    let state = contact.press(Load::MeanPressure(1e-140)).tolerance(1e-12).solve().unwrap();
    approx::assert_relative_eq!(value(&contact, &state), stiffness * 1e-100, max_relative = 1e-8);
}

#[test]
fn it_costs_a_third_of_the_contact_from_first_touch_to_nearly_full_contact() {
    for points in [64, 256] {
        let grid = Grid::square(points, 1.0).unwrap();
        let heights = rough(&grid);
        for boundary in [Boundary::Periodic, Boundary::Free] {
            let contact = Contact::with_boundary(boundary, &half_space(), &grid, &heights).unwrap();
            let mut last = 0.0;
            for p_star in [1e-4, 0.01, 0.2, 1.0, 2.0] {
                let mean = p_star * contact.reduced_pressure_unit();
                let state = contact.press(Load::MeanPressure(mean)).solve().unwrap();
                let found = contact.stiffness(&state, 1e-9).unwrap();
                assert!(found.effort.transform_pairs <= 16.0, "{points} {boundary} {p_star}: {found:?}");
                let usual = contact.stiffness(&state, Stiffness::TOLERANCE).unwrap();
                assert!(usual.effort.transform_pairs <= 9.0, "{points} {boundary} {p_star}: {usual:?}");
                is_as_exact_as_stated(usual, found);
                assert!(found.value > last, "{points} {boundary} {p_star}: {found:?}");
                last = found.value;
            }
        }
    }
}

/// A hardness that is not reached changes nothing, but it excludes the corrections on few points.
#[test]
fn few_points_have_the_stiffness_of_the_whole_surface_for_few_transforms() {
    let grid = Grid::new([256, 320], [1.0, 1.25]).unwrap();
    let slab = Body::slab(material(0.3), 0.1).unwrap();
    for body in [half_space(), slab] {
        let contact = Contact::new(&body, &grid, &rough(&grid)).unwrap();
        for p_star in [1e-6, 1e-4, 1e-3, 3e-3, 0.01] {
            let load = Load::MeanPressure(p_star * contact.reduced_pressure_unit());
            let state = contact.press(load).solve().unwrap();
            let few = contact.stiffness(&state, 1e-9).unwrap();
            let all = contact.clone().with_hardness(1e6).unwrap().stiffness(&state, 1e-9).unwrap();
            assert!(few.error <= 1e-9, "{p_star}: {few:?}");
            approx::assert_relative_eq!(few.value, all.value, max_relative = 1e-9);
            assert!(few.effort.transform_pairs <= 7.0, "{p_star}: {few:?}");
            let usual = contact.stiffness(&state, Stiffness::TOLERANCE).unwrap();
            assert!(usual.effort.transform_pairs <= 4.5, "{p_star}: {usual:?}");
            is_as_exact_as_stated(usual, all);
        }
    }
}

#[test]
fn threads_change_no_bit() {
    let grid = Grid::square(96, 1.0).unwrap();
    let contact = Contact::new(&half_space(), &grid, &rough(&grid)).unwrap();
    let state = contact.press(Load::MeanPressure(0.02)).solve().unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| value(&contact, &state)).to_bits()
    };
    assert_eq!(on(1), on(3));
}
