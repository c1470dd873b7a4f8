//! Contacts of few enough points for a search on these alone: [`Solver::Auto`] against [`Solver::PreconditionedCg`],
//! which transforms the whole surface in every iteration.

use gfmd_contact::{Contact, Equilibrium as _, Load, Solution, SolveError, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_surface::{Discretisation, SelfAffine};
use ndarray::Array2;

use super::long;

const RMS_GRADIENT: f64 = 0.1;
const TOLERANCE: f64 = 1e-10;

fn half_space() -> Body {
    Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap())
}

fn slab(poisson: f64, height: f64) -> Body {
    Body::slab(Material::from_contact_modulus(1.0, poisson).unwrap(), height).unwrap()
}

fn rough(grid: &Grid, hurst: f64) -> Array2<f64> {
    let n = grid.points().into_iter().min().unwrap() as f64;
    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: n / 8.0, eps_c_inv: 4.0 };
    let surface = SelfAffine { hurst, ..SelfAffine::with_rms_gradient(RMS_GRADIENT) };
    let shortest = grid.lengths().into_iter().fold(f64::INFINITY, f64::min);
    numbers.self_affine(shortest, surface).heights(grid, 7).unwrap()
}

fn press(contact: &Contact, load: Load, solver: Solver) -> Solution {
    contact.press(load).solver(solver).tolerance(TOLERANCE).solve().unwrap()
}

/// Checks that both methods find the same pressure at the same points. Returns their transform pairs.
fn compare(contact: &Contact, load: Load) -> [f64; 2] {
    let [few, all] = [Solver::Auto, Solver::PreconditionedCg].map(|solver| press(contact, load, solver));
    let highest = all.pressure.iter().copied().fold(0.0, f64::max);
    for (few, all) in few.pressure.iter().zip(&all.pressure) {
        assert!((few - all).abs() < 1e-5 * highest, "{load:?}: {few} {all}");
        assert!((*few > 0.0) == (*all > 0.0) || few.max(*all) < 1e-5 * highest, "{load:?}: {few} {all}");
    }
    assert!(few.residual.worst() <= TOLERANCE && few.pressure.iter().all(|p| *p >= 0.0));
    // A new certificate of the pressure equals the one requested by the search.
    let mut certificate = contact.certify(&few.pressure, load).unwrap();
    certificate.effort = few.effort;
    assert!(certificate == few, "{load:?}: {:?} {:?}", certificate.residual, few.residual);
    [few, all].map(|solution| solution.effort.transform_pairs)
}

#[test]
fn the_pressure_on_few_points_is_that_of_the_whole_surface() {
    let grids = [([256, 256], [1.0, 1.0]), ([192, 512], [0.5, 1.0]), ([500, 400], [1.0, 1.0])];
    for (shape, (points, lengths)) in grids.into_iter().enumerate() {
        let grid = Grid::new(points, lengths).unwrap();
        let bodies = [
            (half_space(), 0.0),
            (half_space(), 0.8),
            (slab(0.3, 0.1), 0.8),
            (slab(0.5, 0.05), 0.3),
            (slab(0.0, 0.05), 0.8),
        ];
        // Each body on one of the grids; the long tests use all grids.
        for (_, (body, hurst)) in bodies.into_iter().enumerate().filter(|(body, _)| long() || body % 3 == shape) {
            let contact = Contact::new(&body, &grid, &rough(&grid, hurst)).unwrap();
            for reduced_pressure in [1e-6, 1e-4, 1e-3, 4e-3, 8e-3] {
                let load = Load::MeanPressure(reduced_pressure * RMS_GRADIENT);
                let [few, all] = compare(&contact, load);
                assert!(few < 0.6 * all, "{points:?} H {hurst}, p* {reduced_pressure}: {few} against {all} pairs");
            }
        }
    }
}

#[test]
fn prescribed_approaches_at_which_little_touches() {
    let grid = Grid::square(256, 1.0).unwrap();
    for body in [half_space(), slab(0.3, 0.1), slab(0.5, 0.05)] {
        let contact = Contact::new(&body, &grid, &rough(&grid, 0.8)).unwrap();
        for part in [0.05, 0.2, 0.3] {
            let load = Load::Approach(part * contact.surface().mean_clearance());
            compare(&contact, load);
        }
    }
}

#[test]
fn contact_that_begins_at_few_points_and_ends_at_many_is_found_as_well() {
    // Roughness of small slope below a few needles, which seem to carry the load. They carry almost nothing.
    let grid = Grid::square(256, 1.0).unwrap();
    let mut heights = 0.02 * rough(&grid, 0.8);
    let highest = heights.iter().copied().fold(0.0, f64::max);
    for (i, j) in [(3, 5), (100, 30), (40, 200), (250, 251)] {
        heights[[i, j]] = highest + 0.002;
    }
    let contact = Contact::new(&half_space(), &grid, &heights).unwrap();
    for pressure in [1e-5, 2e-4, 2e-3] {
        compare(&contact, Load::MeanPressure(pressure));
    }
}

#[test]
fn the_cost_at_small_loads_hardly_grows_with_the_grid() {
    for points in [128, 256, 512, 1024] {
        let grid = Grid::square(points, 1.0).unwrap();
        for hurst in [0.0, 0.8] {
            let contact = Contact::new(&half_space(), &grid, &rough(&grid, hurst)).unwrap();
            for (reduced_pressure, bound) in [(1e-4, 5.5), (1e-3, 7.0)] {
                let load = Load::MeanPressure(reduced_pressure * RMS_GRADIENT);
                let pairs = contact.press(load).solve().unwrap().effort.transform_pairs;
                assert!(pairs <= bound, "{points}, H {hurst}, p* {reduced_pressure}: {pairs} > {bound}");
            }
        }
    }
}

#[test]
fn a_start_saves_the_more_iterations_the_nearer_its_load() {
    let grid = Grid::square(512, 1.0).unwrap();
    for hurst in [0.0, 0.8] {
        let contact = Contact::new(&half_space(), &grid, &rough(&grid, hurst)).unwrap();
        let load = |part: f64| Load::MeanPressure(part * 1e-3 * RMS_GRADIENT);
        let cold = contact.press(load(1.0)).solve().unwrap().effort.iterations;
        let [far, near, same] = [0.8, 0.95, 1.0].map(|part| {
            let before = contact.press(load(part)).solve().unwrap();
            contact.press(load(1.0)).starting_from(Some(&before)).solve().unwrap().effort.iterations
        });
        assert!(far <= cold, "H {hurst}: {cold}, {far}, {near}, {same}");
        assert!(near < far, "H {hurst}: {cold}, {far}, {near}, {same}");
        assert!(same == 0, "H {hurst}: {cold}, {far}, {near}, {same}");
    }
}

#[test]
fn a_search_without_success_has_the_pressure_reached() {
    let grid = Grid::square(256, 1.0).unwrap();
    let contact = Contact::new(&half_space(), &grid, &rough(&grid, 0.8)).unwrap();
    let load = Load::MeanPressure(1e-3 * RMS_GRADIENT);
    for max_iterations in [0, 1, 5, 8] {
        let Err(SolveError::NotConverged { state, .. }) = contact.press(load).max_iterations(max_iterations).solve()
        else {
            panic!("{max_iterations} iterations cannot be enough")
        };
        assert!(state.effort.iterations <= max_iterations && state.residual.worst() > 1e-8);
        assert!((state.mean_pressure / (1e-3 * RMS_GRADIENT) - 1.0).abs() < 1e-9);
    }
}
