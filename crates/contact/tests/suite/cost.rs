//! Tests of the cost of an equilibration in transform pairs and in bytes, which do not depend on the machine. The
//! bounds are about a fifth above the numbers when they were set.
#![allow(clippy::print_stdout, reason = "a test that counts nothing says so")]

use std::path::Path;
use std::process::Command;

use gfmd_contact::{Contact, Equilibrium, Load, Solution, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_surface::{Discretisation, SelfAffine};
use ndarray::Array2;

use super::long;

const RMS_GRADIENT: f64 = 0.1;

fn heights(grid: &Grid, hurst: f64) -> Array2<f64> {
    let n = grid.points()[0] as f64;
    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: n / 8.0, eps_c_inv: 4.0 };
    numbers
        .self_affine(1.0, SelfAffine { hurst, ..SelfAffine::with_rms_gradient(RMS_GRADIENT) })
        .heights(grid, 1)
        .unwrap()
}

fn half_space() -> Body {
    Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap())
}

fn press(grid: Grid, body: &Body, hurst: f64, load: Load, solver: Solver) -> Solution {
    let contact = Contact::new(body, &grid, &heights(&grid, hurst)).unwrap();
    contact.press(load).solver(solver).solve().unwrap()
}

fn load(reduced_pressure: f64) -> Load {
    Load::MeanPressure(reduced_pressure * RMS_GRADIENT)
}

fn pairs(points: usize, hurst: f64, reduced_pressure: f64) -> f64 {
    let grid = Grid::square(points, 1.0).unwrap();
    press(grid, &half_space(), hurst, load(reduced_pressure), Solver::Auto).effort.transform_pairs
}

#[test]
fn rough_surfaces_on_a_half_space() {
    for hurst in [0.0, 0.3, 0.8] {
        for (reduced_pressure, bound) in
            [(1e-3, 8.0), (0.01, 29.0), (0.05, 29.0), (0.2, 27.0), (0.6, 27.0), (2.0, 18.0)]
        {
            let pairs = pairs(128, hurst, reduced_pressure);
            assert!(pairs <= bound, "H {hurst}, p* {reduced_pressure}: {pairs} > {bound}");
        }
    }
}

#[test]
fn the_cost_hardly_grows_with_the_grid() {
    for (hurst, reduced_pressure) in [(0.0, 0.01), (0.0, 0.2), (0.8, 0.05)] {
        let [coarse, fine] = [64, 512].map(|points| pairs(points, hurst, reduced_pressure));
        assert!(fine <= 1.5 * coarse, "H {hurst}, p* {reduced_pressure}: {coarse} to {fine}");
    }
}

#[test]
fn layers_of_any_height() {
    let grid = Grid::square(128, 1.0).unwrap();
    for (poisson, height, bound) in [(0.3, 0.125, 28.0), (0.3, 0.02, 28.0), (0.45, 0.125, 28.0), (0.5, 0.125, 32.0)] {
        let body = Body::slab(Material::from_contact_modulus(1.0, poisson).unwrap(), height).unwrap();
        for reduced_pressure in [0.01, 0.2] {
            let pairs = press(grid, &body, 0.8, load(reduced_pressure), Solver::Auto).effort.transform_pairs;
            assert!(pairs <= bound, "nu {poisson}, height {height}, p* {reduced_pressure}: {pairs} > {bound}");
        }
    }
}

#[test]
fn thin_rubber_is_left_to_the_plain_method() {
    // Most waves are longer than the thickness of the layer and conserve its volume, so that points do not move
    // independently.
    let grid = Grid::square(256, 1.0).unwrap();
    let rubber = Body::slab(Material::from_contact_modulus(1.0, 0.5).unwrap(), 0.004).unwrap();
    let auto = press(grid, &rubber, 0.0, load(20.0), Solver::Auto);
    let plain = press(grid, &rubber, 0.0, load(20.0), Solver::ProjectedCg);
    assert!(auto.effort.iterations > 100, "the preconditioner must fail for this test");
    assert!(auto.effort.transform_pairs <= 350.0 && auto.residual.worst() <= 1e-8);
    let differing = auto.pressure.iter().zip(&plain.pressure).filter(|(a, b)| (**a > 0.0) != (**b > 0.0));
    assert_eq!(differing.count(), 0);
}

#[test]
fn prescribed_approach() {
    let grid = Grid::square(128, 1.0).unwrap();
    let heights = heights(&grid, 0.8);
    let depth = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max) - heights.mean().unwrap();
    let slab = Body::slab(Material::from_contact_modulus(1.0, 0.3).unwrap(), 0.125).unwrap();
    for (body, part, bound) in [
        (&slab, 0.1, 20.0),
        (&slab, 0.9, 30.0),
        (&half_space(), 0.1, 20.0),
        (&half_space(), 0.5, 40.0),
        (&half_space(), 0.9, 50.0),
    ] {
        let pairs = press(grid, body, 0.8, Load::Approach(part * depth), Solver::Auto).effort.transform_pairs;
        assert!(pairs <= bound, "{part} of {depth}: {pairs} > {bound}");
    }
}

#[test]
fn line_contacts() {
    for (points, bound) in [(1000, 32.0), (16384, 48.0)] {
        let grid = Grid::line(points, 1.0).unwrap();
        for reduced_pressure in [0.01, 0.2] {
            let pairs = press(grid, &half_space(), 0.8, load(reduced_pressure), Solver::Auto).effort.transform_pairs;
            assert!(pairs <= bound, "{points} points, p* {reduced_pressure}: {pairs} > {bound}");
        }
    }
}

#[test]
fn other_methods_find_the_same_contact_at_a_higher_cost() {
    let grid = Grid::square(128, 1.0).unwrap();
    for hurst in [0.0, 0.8] {
        let fast = press(grid, &half_space(), hurst, load(0.2), Solver::Auto);
        for (solver, dearer) in [(Solver::ProjectedCg, 2.5), (Solver::PolonskyKeer, 5.0)] {
            let slow = press(grid, &half_space(), hurst, load(0.2), solver);
            assert!(
                slow.effort.transform_pairs > dearer * fast.effort.transform_pairs,
                "{solver:?}: {}",
                slow.effort.transform_pairs
            );
            let differing = fast.pressure.iter().zip(&slow.pressure).filter(|(a, b)| (**a > 0.0) != (**b > 0.0));
            assert_eq!(differing.count(), 0, "{solver:?}");
        }
    }
}

#[test]
fn dynamics_with_inertia_like_the_stiffness_hardly_feels_the_grid() {
    let cost = |points, hurst, reduced_pressure, solver| {
        let grid = Grid::square(points, 1.0).unwrap();
        press(grid, &half_space(), hurst, load(reduced_pressure), solver).effort.transform_pairs
    };
    for hurst in [0.0, 0.8] {
        for points in [64, 256] {
            for (reduced_pressure, bound) in [(0.01, 170.0), (0.05, 165.0), (0.2, 110.0)] {
                let pairs = cost(points, hurst, reduced_pressure, Solver::AugmentedLagrangian);
                assert!(pairs <= bound, "{points}, H {hurst}, p* {reduced_pressure}: {pairs} > {bound}");
            }
        }
        let gradients = cost(256, hurst, 0.2, Solver::PolonskyKeer);
        let dynamics = cost(256, hurst, 0.2, Solver::AugmentedLagrangian);
        assert!(dynamics < 0.6 * gradients, "H {hurst}: {dynamics}, conjugate gradients {gradients}");
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let grid = Grid::square(150, 1.0).unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            [Solver::Auto, Solver::AugmentedLagrangian, Solver::Fire2]
                .map(|solver| press(grid, &half_space(), 0.8, load(0.05), solver).pressure)
        })
    };
    let one = on(1);
    assert!([2, 3, 8].into_iter().all(|threads| on(threads) == one));
}

/// Variable with the load that [`bytes_moved`] solves for in the process with counted bytes.
const COUNTED: &str = "GFMD_COUNTED_LOAD";

/// Value of [`COUNTED`] for a contact that is only prepared.
const UNLOADED: &str = "none";

/// A simulated cache counts the lines of 64 bytes fetched by a solution. It holds a quarter of a field, so that each
/// pass over a vector counts, as on large grids.
#[test]
fn bytes_moved() {
    const POINTS: usize = 256;
    if let Ok(reduced_pressure) = std::env::var(COUNTED) {
        let grid = Grid::square(POINTS, 1.0).unwrap();
        let contact = Contact::new(&half_space(), &grid, &heights(&grid, 0.8)).unwrap();
        if reduced_pressure != UNLOADED {
            contact.press(load(reduced_pressure.parse().unwrap())).solve().unwrap();
        }
        return;
    }
    if Command::new("valgrind").arg("--version").output().is_err() {
        println!("valgrind is not installed, so that bytes are not counted");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let fetched = |case: &str| lines_fetched(case, folder.path());
    let prepared = fetched(UNLOADED);
    let cases = [("0.01", 96.0), ("0.6", 305.0), ("0.001", 62.0), ("0.05", 325.0)];
    let cases = cases.into_iter().take(if long() { 4 } else { 2 });
    let found = cases.map(|(case, bound)| {
        let doubles = 64.0 / 8.0 * (fetched(case) - prepared) / (POINTS * POINTS) as f64;
        (case, doubles, bound)
    });
    let found: Vec<_> = found.collect();
    // Far below the bound, nothing was counted.
    let within = |(_, doubles, bound): &(&str, f64, f64)| (0.5 * bound..=*bound).contains(doubles);
    assert!(found.iter().all(within), "p*, doubles for each point, bound: {found:?}");
}

/// Returns the number of lines fetched by this program, on one thread, while it solves for a load.
fn lines_fetched(case: &str, folder: &Path) -> f64 {
    let file = folder.join(case);
    let mut command = Command::new("valgrind");
    command.args(["--tool=cachegrind", "--cache-sim=yes", "--D1=32768,8,64", "--LL=131072,16,64"]);
    command.arg(format!("--cachegrind-out-file={}", file.display()));
    command.arg(std::env::current_exe().unwrap()).args(["--exact", "cost::bytes_moved"]);
    let output = command.env(COUNTED, case).env("RAYON_NUM_THREADS", "1").output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let counts = std::fs::read_to_string(file).unwrap();
    let line = |name: &str| counts.lines().find_map(|line| line.strip_prefix(name)).unwrap().split_whitespace();
    let events = line("events:").zip(line("summary:"));
    events.filter(|(event, _)| ["DLmr", "DLmw"].contains(event)).map(|(_, count)| count.parse::<f64>().unwrap()).sum()
}
