//! Springs between the surfaces: limits, comparison with dense matrices, and bad input.

use gfmd_contact::{Boundary, Contact, Cotangents, Equilibrium, Load, Refusal, Solution, SolveError, Solver, Springs};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_surface::{Discretisation, SelfAffine};
use ndarray::{Array2, Axis};

const LOADS: [Load; 2] = [Load::MeanPressure(0.02), Load::Approach(0.015)];

fn material() -> Material {
    Material::from_contact_modulus(1.0, 0.0).unwrap()
}

fn bodies() -> [Body; 2] {
    [Body::half_space(material()), Body::slab(Material::from_contact_modulus(1.0, 0.3).unwrap(), 0.3).unwrap()]
}

fn rough([nx, ny]: [usize; 2]) -> Array2<f64> {
    let grid = Grid::new([nx, ny], [1.0, ny as f64 / nx as f64]).unwrap();
    let numbers = Discretisation { eps_t_inv: 1.0, eps_f_inv: ny as f64 / 4.0, eps_c_inv: 4.0 };
    let family = SelfAffine { hurst: 0.8, ..SelfAffine::with_rms_gradient(0.1) };
    numbers.self_affine(grid.lengths()[0].max(grid.lengths()[1]), family).heights(&grid, 3).unwrap()
}

fn contact(boundary: Boundary, body: &Body, n: usize) -> Contact {
    Contact::with_boundary(boundary, body, &Grid::square(n, 1.0).unwrap(), &rough([n, n])).unwrap()
}

/// Returns springs in stripes, some without compliance.
fn stripes(n: usize, compliance: f64) -> Array2<f64> {
    Array2::from_shape_fn((n, n), |(i, j)| compliance * [0.0, 1.0, 0.3][(i / 5 + j / 7) % 3])
}

/// Returns the same compliance at all points but the lowest one, which has none and does not touch.
fn but_one(contact: &Contact, compliance: f64) -> Array2<f64> {
    let clearance = contact.surface().clearance();
    let mut springs = Array2::from_elem(contact.surface().grid().points(), compliance);
    let lowest = (0..clearance.len()).max_by(|a, b| clearance.at(*a).total_cmp(&clearance.at(*b))).unwrap();
    *springs.iter_mut().nth(lowest).unwrap() = 0.0;
    springs
}

fn largest(field: &Array2<f64>) -> f64 {
    field.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
}

fn solve(contact: &Contact, load: Load) -> Solution {
    contact.press(load).tolerance(1e-12).solve().unwrap_or_else(|error| panic!("{load:?}: {error}"))
}

#[test]
fn a_field_of_one_compliance_is_that_compliance() {
    for boundary in Boundary::ALL {
        for body in bodies() {
            let bare = contact(boundary, &body, 48);
            for hardness in [None, Some(0.08)] {
                let bare = hardness.map_or_else(|| bare.clone(), |hard| bare.clone().with_hardness(hard).unwrap());
                for (load, compliance) in LOADS.into_iter().flat_map(|load| [0.01, 0.3].map(|k| (load, k))) {
                    let one = solve(&bare.softened(compliance).unwrap(), load);
                    let same = bare.softened(Array2::from_elem((48, 48), compliance)).unwrap();
                    assert!(solve(&same, load) == one);
                    let field = solve(&bare.softened(but_one(&bare, compliance)).unwrap(), load);
                    let what = format!("{boundary} {hardness:?} {load:?} {compliance}");
                    let off = largest(&(&one.pressure - &field.pressure));
                    assert!(off < 1e-9, "{what}: {off}");
                    let off = largest(&(&one.displacement - &field.displacement));
                    assert!(off < 1e-9, "{what}: {off}");
                    assert!((one.approach - field.approach).abs() < 1e-9, "{what}");
                    assert!(one.pressure.iter().any(|p| *p > 0.0) && one.pressure.iter().any(|p| *p == 0.0));
                    if let (Some(one), Some(field)) = (&one.plastic, &field.plastic) {
                        assert!(one.fraction == field.fraction, "{what}");
                    }
                }
            }
        }
    }
}

#[test]
fn springs_on_springs_are_in_series() {
    let bare = contact(Boundary::Periodic, &bodies()[1], 48);
    let (field, load) = (stripes(48, 0.05), LOADS[0]);
    let sum = solve(&bare.softened(&field + &(2.0 * but_one(&bare, 0.1)) + 0.1).unwrap(), load);
    let series = bare.softened(but_one(&bare, 0.2)).unwrap().softened(0.1).unwrap().softened(field).unwrap();
    assert!(largest(&(&sum.pressure - &solve(&series, load).pressure)) < 1e-9);
}

/// Computes the minimum of ½⟨p, A p⟩ + ⟨b, p⟩ between zero and `upper` by projected Gauss-Seidel sweeps.
fn relaxed(matrix: &Array2<f64>, linear: &[f64], upper: f64) -> Vec<f64> {
    let mut p = vec![0.0; linear.len()];
    for _ in 0..200_000 {
        let mut change: f64 = 0.0;
        for i in 0..p.len() {
            let g: f64 = linear[i] + matrix.row(i).iter().zip(&p).map(|(a, p)| a * p).sum::<f64>();
            let next = (p[i] - g / matrix[[i, i]]).clamp(0.0, upper);
            change = change.max((next - p[i]).abs());
            p[i] = next;
        }
        if change < 1e-15 {
            return p;
        }
    }
    panic!("the sweeps do not converge");
}

#[test]
fn a_jump_agrees_with_dense_matrices() {
    const N: usize = 12;
    for boundary in Boundary::ALL {
        for (body, hardness) in bodies().into_iter().zip([None, Some(0.1)]).chain([(bodies()[0].clone(), Some(0.1))]) {
            let bare = contact(boundary, &body, N);
            let bare = hardness.map_or_else(|| bare.clone(), |hard| bare.clone().with_hardness(hard).unwrap());
            // The compliance 2/(E* q) of the shortest waves along an axis is about the same.
            let springs = Array2::from_shape_fn((N, N), |(i, _)| if i < N / 2 { 0.0 } else { 0.05 });
            let soft = bare.softened(springs.clone()).unwrap();
            let unit = |i: usize| Array2::from_shape_fn((N, N), |(a, b)| f64::from(u8::from(a * N + b == i)));
            let columns: Vec<Array2<f64>> = (0..N * N)
                .map(|i| {
                    let [soft, bare] = [&soft, &bare]
                        .map(|contact| contact.certify(&unit(i), Load::Approach(0.1)).unwrap().displacement);
                    let difference = &bare - &soft - &springs * &unit(i);
                    assert!(largest(&difference) < 1e-14, "the springs at {i}");
                    -soft.into_shape_with_order((N * N, 1)).unwrap()
                })
                .collect();
            let views: Vec<_> = columns.iter().map(|column| column.view()).collect();
            let matrix = ndarray::concatenate(Axis(1), &views).unwrap();
            let approach = 0.03;
            let linear: Vec<f64> = soft.surface().clearance().iter().map(|c| c - approach).collect();
            let dense = relaxed(&matrix, &linear, hardness.unwrap_or(f64::INFINITY));
            let mean = dense.iter().sum::<f64>() / (N * N) as f64;
            for load in [Load::Approach(approach), Load::MeanPressure(mean)] {
                for solver in soft.solvers() {
                    let found = soft.press(load).solver(*solver).tolerance(1e-12).solve().unwrap();
                    let off = found.pressure.iter().zip(&dense).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
                    assert!(off < 1e-8, "{boundary} {hardness:?} {load:?} {solver}: {off}");
                    assert!((found.approach - approach).abs() < 1e-9);
                }
            }
        }
    }
}

#[test]
fn every_number_of_threads_gives_the_same_bits() {
    let bare = contact(Boundary::Periodic, &bodies()[0], 128);
    let soft = bare.softened(stripes(128, 0.01)).unwrap();
    for load in LOADS {
        let [one, two] = [1, 2].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| soft.press(load).solve().unwrap())
        });
        assert!(one == two);
    }
}

#[test]
fn springs_up_to_ten_times_softer_than_the_shortest_waves_take_few_iterations() {
    const N: usize = 64;
    // The compliance 2/(E* q) of the shortest waves along an axis.
    let shortest = 2.0 / (std::f64::consts::PI * N as f64);
    for boundary in Boundary::ALL {
        let bare = contact(boundary, &bodies()[0], N);
        for (softer, most) in [(0.1, 25), (1.0, 30), (10.0, 70)] {
            let soft = bare.softened(stripes(N, softer * shortest)).unwrap();
            for load in [Load::MeanPressure(1e-3), Load::MeanPressure(0.02), Load::MeanPressure(0.2), LOADS[1]] {
                let found = soft.press(load).solve().unwrap_or_else(|error| panic!("{softer} {load:?}: {error}"));
                // Chosen above the 10, 21 and 50 that are needed.
                let needed = found.effort.iterations;
                assert!(needed <= most, "{boundary} {softer} {load:?}: {needed}");
            }
        }
    }
}

#[test]
fn stiffness_and_derivative_are_quotients_of_differences() {
    let bare = contact(Boundary::Periodic, &bodies()[0], 48);
    let soft = bare.softened(stripes(48, 0.02)).unwrap();
    let at = |mean: f64| soft.press(Load::MeanPressure(mean)).tolerance(1e-12).solve().unwrap();
    for mean in [0.02, 10.0] {
        let state = at(mean);
        let stiffness = soft.stiffness(&state, 1e-8).unwrap().value;
        let step = 1e-5 * mean;
        let slope = 2.0 * step / (at(mean + step).approach - at(mean - step).approach);
        assert!((stiffness / slope - 1.0).abs() < 1e-4, "{mean}: {stiffness} {slope}");
        let of = Cotangents { approach: 1.0, ..Cotangents::default() };
        let gradient = soft.gradient(&state, Load::MeanPressure(mean), &of).unwrap();
        assert!((gradient.load * stiffness - 1.0).abs() < 1e-7, "{mean}: {}", gradient.load);
        let of = Cotangents { mean_pressure: 1.0, ..Cotangents::default() };
        let gradient = soft.gradient(&state, Load::Approach(state.approach), &of).unwrap();
        assert!((gradient.load / stiffness - 1.0).abs() < 1e-7, "{mean}: {}", gradient.load);
    }
}

#[test]
fn what_cannot_be_done_is_refused() {
    let bare = contact(Boundary::Periodic, &bodies()[0], 16);
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(bare.softened(bad), Err(Refusal::Springs { .. })), "{bad}");
        let mut field = stripes(16, 0.1);
        field[[3, 4]] = bad;
        assert!(matches!(bare.softened(field), Err(Refusal::Springs { .. })), "{bad}");
    }
    let refused = bare.softened(Array2::ones((16, 15))).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "the shape of the springs is [16, 15]; it must be [16, 16], the shape of the heights"
    );
    let soft = bare.softened(Springs::from(stripes(16, 0.1))).unwrap();
    assert_eq!(soft.solvers(), Contact::FREE_SOLVERS);
    let error = soft.press(LOADS[0]).solver(Solver::Verlet).solve().unwrap_err();
    assert!(matches!(error, SolveError::Refused(Refusal::Solver { .. })), "{error}");
    // With springs any approach can be reached on a half-space, even beyond the mean clearance.
    let deep = Load::Approach(2.0 * bare.surface().mean_clearance());
    assert!(bare.press(deep).solve().is_err());
    assert!(solve(&soft, deep).pressure.iter().all(|p| *p > 0.0));
}
