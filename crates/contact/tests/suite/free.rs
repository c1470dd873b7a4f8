//! Contacts with free boundaries: identities, independence of the position, and refusals.

use gfmd_contact::{Boundary, Contact, Equilibrium, Fields, Load, Refusal, Solution, SolveError, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use ndarray::{Array2, Axis};

fn half_space() -> Body {
    Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap())
}

/// Returns a rough surface that does not repeat.
fn rough([nx, ny]: [usize; 2]) -> Array2<f64> {
    Array2::from_shape_fn((nx, ny), |(i, j)| {
        let [x, y] = [i as f64 / nx as f64, j as f64 / ny as f64];
        0.02 * (5.3 * x + 1.0).sin() * (4.1 * y).cos() + 0.005 * (31.0 * x - 17.0 * y).sin() + 0.01 * x
    })
}

fn press(grid: &Grid, heights: &Array2<f64>, load: Load) -> Solution {
    let contact = Contact::with_boundary(Boundary::Free, &half_space(), grid, heights).unwrap();
    contact.press(load).tolerance(1e-11).solve().unwrap()
}

#[test]
fn load_and_approach_find_one_state_and_every_solver_does() {
    for points in [[24, 24], [17, 30], [40, 1], [1, 33]] {
        let grid = Grid::new(points, [1.0, 1.3]).unwrap();
        let heights = rough(points);
        let contact = Contact::with_boundary(Boundary::Free, &half_space(), &grid, &heights).unwrap();
        for mean in [1e-4, 0.01, 0.3] {
            let first = press(&grid, &heights, Load::MeanPressure(mean));
            let mut others = vec![];
            for solver in Contact::FREE_SOLVERS {
                others.push(contact.press(Load::MeanPressure(mean)).solver(solver).tolerance(1e-11).solve().unwrap());
                if !grid.is_line() {
                    let load = Load::Approach(first.approach);
                    others.push(contact.press(load).solver(solver).tolerance(1e-11).solve().unwrap());
                }
            }
            let peak = first.pressure.iter().copied().fold(0.0, f64::max);
            for other in others {
                assert!((other.mean_pressure / mean - 1.0).abs() < 1e-8, "{points:?} {mean}");
                assert!((&other.pressure - &first.pressure).iter().all(|d| d.abs() < 1e-7 * peak), "{points:?} {mean}");
            }
            let again = contact.certify(&first.pressure, Load::MeanPressure(mean)).unwrap();
            assert_eq!(again.residual, first.residual);
        }
    }
}

#[test]
fn a_patch_may_be_turned_over_and_its_margin_cut_off() {
    let grid = Grid::square(32, 1.0).unwrap();
    // A bump away from the edges.
    let bump = Array2::from_shape_fn((32, 32), |(i, j)| {
        -((i as f64 - 13.2).powi(2) + 1.3 * (j as f64 - 12.0).powi(2)) / 900.0
    });
    let load = 0.002;
    let whole = press(&grid, &bump, Load::MeanPressure(load));
    let mut turned = bump.clone();
    turned.invert_axis(Axis(0));
    let turned = press(&grid, &turned.as_standard_layout().to_owned(), Load::MeanPressure(load));
    assert!((turned.approach / whole.approach - 1.0).abs() < 1e-9);
    // An equal force on a patch without the margin: the margin has no effect.
    let part = bump.slice(ndarray::s![..24, ..26]).to_owned();
    let grid = Grid::new([24, 26], [24.0 / 32.0, 26.0 / 32.0]).unwrap();
    let share = 24.0 * 26.0 / 1024.0;
    let part = press(&grid, &part, Load::MeanPressure(load / share));
    assert!((part.approach / whole.approach - 1.0).abs() < 1e-8, "{} {}", part.approach, whole.approach);
    for ((i, j), p) in part.pressure.indexed_iter() {
        assert!((p - whole.pressure[[i, j]]).abs() < 1e-6 * whole.pressure.iter().copied().fold(0.0, f64::max));
    }
}

#[test]
fn far_from_a_small_contact_the_displacement_is_that_of_a_force() {
    let n = 64;
    let grid = Grid::square(n, 1.0).unwrap();
    let tip =
        Array2::from_shape_fn((n, n), |(i, j)| -0.5 * ((i as f64 - 5.0).powi(2) + (j as f64 - 6.0).powi(2)) / 4096.0);
    let solution = press(&grid, &tip, Load::MeanPressure(1e-6));
    // Boussinesq: u = F/(π E* r).
    let r = (58.0_f64).hypot(57.0) / 64.0;
    let point = 1e-6 / (std::f64::consts::PI * r);
    assert!((-solution.displacement[[63, 63]] / point - 1.0).abs() < 2e-3);
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let grid = Grid::square(200, 1.0).unwrap();
    let heights = rough([200, 200]);
    let solved = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| press(&grid, &heights, Load::MeanPressure(0.01)))
    });
    assert_eq!(solved[0], solved[1]);
}

#[test]
fn units_do_not_matter() {
    let heights = rough([16, 16]);
    let small = press(&Grid::square(16, 1.0).unwrap(), &heights, Load::MeanPressure(0.01));
    let body = Body::half_space(Material::from_contact_modulus(1e30, 0.0).unwrap());
    let grid = Grid::square(16, 1e-40).unwrap();
    let contact = Contact::with_boundary(Boundary::Free, &body, &grid, &(&heights * 1e-40)).unwrap();
    let other = contact.press(Load::MeanPressure(1e28)).tolerance(1e-11).solve().unwrap();
    assert!((other.approach / (small.approach * 1e-40) - 1.0).abs() < 1e-9);
    assert!((other.summary().area_fraction - small.summary().area_fraction).abs() < 1e-15);
    assert!((contact.surface().rms_gradient() / small.scales().rms_gradient - 1.0).abs() < 1e-12);
}

#[test]
fn what_cannot_be_done_is_refused() {
    let grid = Grid::square(16, 1.0).unwrap();
    let slab = Body::slab(Material::from_contact_modulus(1.0, 0.3).unwrap(), 0.5).unwrap();
    let plate = slab.on(gfmd_green::Base::FREE).unwrap();
    let refused = Contact::with_boundary(Boundary::Free, &plate, &grid, &rough([16, 16])).unwrap_err();
    assert!(refused.to_string().starts_with("nothing holds the plate"), "{refused}");
    let contact = Contact::with_boundary(Boundary::Free, &half_space(), &grid, &rough([16, 16])).unwrap();
    for solver in [Solver::Verlet, Solver::Fire, Solver::AugmentedLagrangian, Solver::Newton] {
        let error = contact.press(Load::MeanPressure(0.01)).solver(solver).solve().unwrap_err();
        assert!(matches!(error, SolveError::Refused(Refusal::Solver { .. })), "{solver}");
        assert!(error.to_string().contains("auto, cg, projected-cg or preconditioned-cg"), "{error}");
    }
    let line = Grid::line(16, 1.0).unwrap();
    let contact = Contact::with_boundary(Boundary::Free, &half_space(), &line, &rough([16, 1])).unwrap();
    let error = contact.press(Load::Approach(-0.01)).solve().unwrap_err();
    assert!(matches!(error, SolveError::Refused(Refusal::Approach { .. })), "{error}");
    assert!("endless".parse::<Boundary>().is_err() && Boundary::ALL.map(|b| b.name().parse()) == Boundary::ALL.map(Ok));
}
