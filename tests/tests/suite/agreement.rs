//! All solvers find the same contact, on random problems of every kind.

use gfmd_contact::{Load, Solution, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_response::NormalResponse;
use gfmd_surface::{Discretisation, SelfAffine};
use gfmd_tests::{SOLVERS, press};

const TOLERANCE: f64 = 1e-10;

/// Returns a pseudo-random number in [0, 1) that depends only on the problem.
fn spread(seed: u64, salt: u32) -> f64 {
    (seed as f64 * 0.618_034 + f64::from(salt) * 0.414_214).fract()
}

#[test]
fn all_methods_agree_on_random_problems() {
    let grids = [("line", Grid::line(128, 1.0).unwrap()), ("surface", Grid::square(32, 1.0).unwrap())];
    let seeds = if std::env::var_os("GFMD_LONG").is_some() { 10 } else { 3 };
    for (dimension, grid) in grids {
        for slab in [false, true] {
            for pressed in [true, false] {
                for seed in 1..=seeds {
                    let case = format!("{dimension}, slab {slab}, load {pressed}, seed {seed}");
                    let material = Material::from_contact_modulus(1.0, 0.49 * spread(seed, 1)).unwrap();
                    let height = 0.1 + spread(seed, 2);
                    let body = if slab { Body::slab(material, height).unwrap() } else { Body::half_space(material) };
                    let eps_f_inv = grid.points()[0] as f64 / 8.0;
                    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv, eps_c_inv: 4.0 };
                    let heights = numbers
                        .self_affine(1.0, SelfAffine { hurst: spread(seed, 3), ..SelfAffine::with_rms_gradient(0.1) })
                        .heights(&grid, seed)
                        .unwrap();
                    let response = NormalResponse::new(grid, &body).into();
                    let mean = 0.1 * 10f64.powf(-2.0 * spread(seed, 4));
                    let mut control = Load::MeanPressure(mean * 0.1);
                    let solve = |control, solver| {
                        press(&response, &heights, control, solver, TOLERANCE)
                            .unwrap_or_else(|error| panic!("{case}, {solver:?}: {error}"))
                    };
                    let reference = solve(control, Solver::Auto);
                    if !pressed {
                        control = Load::Approach(reference.approach);
                    }
                    for solver in SOLVERS {
                        let found = solve(control, solver);
                        let worst = worst_difference(&found, &reference);
                        // The tolerance bounds residuals. The fields differ by more, up to 11 times over all cases
                        // (measured on x86-64), since a small residual constrains soft modes less than stiff ones.
                        assert!(worst < 30.0 * TOLERANCE, "{case}, {solver:?}: {worst:e}");
                    }
                }
            }
        }
    }
}

/// Returns the larger of the relative pressure difference and the relative difference of the approaches.
fn worst_difference(a: &Solution, b: &Solution) -> f64 {
    let peak = b.pressure.iter().copied().fold(0.0, f64::max);
    let pressure = a.pressure.iter().zip(&b.pressure).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / peak;
    pressure.max((a.approach - b.approach).abs() / b.approach)
}
