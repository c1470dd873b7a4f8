//! Flat punches that stick: node by node against an independent solution of the same discrete problem, and against
//! finite elements of the continuum.

use std::ops::ControlFlow;

use approx::assert_relative_eq;
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_mixed::{Edge, FlatPunch, Method, MixedProblem, MixedSolution, Prescribed, Settings};
use gfmd_response::FullResponse;
use gfmd_tests::{number, reference, reference_path};
use ndarray::{Array2, Array3, Axis};

const LENGTH: f64 = 1.27;
const DEPTH: f64 = 0.005;

/// The rms error of the source's u_x over the depth at 128², by its own formula and its own finite elements.
const SOURCE_ERROR: f64 = 0.00196;

fn press(grid: Grid, edge: Edge, method: Method, tolerance: f64) -> MixedSolution {
    let slab = Body::slab(Material::from_young(70.0, 0.33).unwrap(), LENGTH).unwrap();
    let response = FullResponse::new(grid, &slab);
    let points = FlatPunch::new(0.25, edge).unwrap().points(&grid);
    let held = Prescribed::sticking(&grid, points.view(), [0.0, 0.0, -DEPTH]).unwrap();
    let settings = Settings { method, tolerance, ..Settings::default() };
    MixedProblem::new(&response, held).unwrap().solve(&settings, &mut |_| ControlFlow::Continue(())).unwrap()
}

fn square(n: usize, edge: Edge) -> MixedSolution {
    press(Grid::square(n, LENGTH).unwrap(), edge, Method::ConjugateGradients, 1e-10)
}

fn strip(n: usize, edge: Edge) -> MixedSolution {
    press(Grid::line(n, LENGTH).unwrap(), edge, Method::ConjugateGradients, 1e-10)
}

/// `[x, y, component]` as `[component, x, y]`.
fn square_reference(name: &str) -> Array3<f64> {
    let path = reference_path("punch3d_sticking_zm1_nu033").join(name);
    let field: Array3<f64> = ndarray_npy::read_npy(path).expect(name);
    field.permuted_axes([2, 0, 1])
}

/// `[x, component]` as `[component, x, 1]`.
fn strip_reference(name: &str) -> Array3<f64> {
    let path = reference_path("punch2d_sticking_zm1_nu033").join(name);
    let field: Array2<f64> = ndarray_npy::read_npy(path).expect(name);
    field.reversed_axes().insert_axis(Axis(2))
}

/// √⟨(u_ref − u)²⟩ / depth of each component, on the points that both grids have.
fn errors(solution: &MixedSolution, reference: &Array3<f64>) -> Vec<f64> {
    let [ours, theirs] = [solution.displacement.len_of(Axis(1)), reference.len_of(Axis(1))];
    let every = |field: &Array3<f64>, step: usize| {
        let along = |axis: ndarray::AxisDescription| if axis.axis == Axis(0) { 1 } else { step as isize };
        field.slice_each_axis(|axis| ndarray::Slice::new(0, None, along(axis))).to_owned()
    };
    let difference = every(&solution.displacement, ours.div_ceil(theirs)) - every(reference, theirs.div_ceil(ours));
    let squares = difference.mapv(|difference| difference * difference);
    squares.outer_iter().map(|component| component.mean().unwrap().sqrt() / DEPTH).collect()
}

fn assert_same(solution: &MixedSolution, expected: &Array3<f64>, tolerance: f64) {
    assert_eq!(solution.displacement.dim(), expected.dim());
    for (found, expected) in solution.displacement.iter().zip(expected) {
        assert_relative_eq!(*found, *expected, epsilon = tolerance * DEPTH);
    }
}

/// The mean σ_zz of the discrete problem in a summary.
fn discrete_pressure(folder: &str, n: usize, edge: Edge) -> f64 {
    let convention = match edge {
        Edge::Strict => "strict",
        Edge::Inclusive => "inclusive",
    };
    let summary = reference(&format!("{folder}/summary.json"));
    let all = summary["discrete"].as_array().unwrap();
    let case = all.iter().find(|case| case["n"] == n && case["convention"] == convention).unwrap();
    -number(case, "mean_sigma_zz_GPa")
}

fn pressure(solution: &MixedSolution) -> f64 {
    -solution.mean_traction().last().unwrap()
}

#[test]
fn every_point_is_where_an_independent_solution_has_it() {
    for (n, edge, name) in [
        (64, Edge::Strict, "discrete_strict_u_n64.npy"),
        (64, Edge::Inclusive, "discrete_inclusive_u_n64.npy"),
        (128, Edge::Strict, "discrete_strict_u_n128.npy"),
        (128, Edge::Inclusive, "discrete_inclusive_u_n128.npy"),
    ] {
        let solution = square(n, edge);
        assert_same(&solution, &square_reference(name), 1e-9);
        let expected = discrete_pressure("punch3d_sticking_zm1_nu033", n, edge);
        assert_relative_eq!(pressure(&solution), expected, max_relative = 1e-9);
    }
    for (n, edge, name) in
        [(128, Edge::Strict, "discrete_strict_u_n128.npy"), (512, Edge::Inclusive, "discrete_inclusive_u_n512.npy")]
    {
        let solution = strip(n, edge);
        assert_same(&solution, &strip_reference(name), 1e-9);
        let expected = discrete_pressure("punch2d_sticking_zm1_nu033", n, edge);
        assert_relative_eq!(pressure(&solution), expected, max_relative = 1e-9);
    }
}

#[test]
fn dynamics_ends_where_an_independent_solution_is() {
    let expected = square_reference("discrete_strict_u_n64.npy");
    for method in [Method::Verlet, Method::VerletCritical, Method::Fire] {
        let solution = press(Grid::square(64, LENGTH).unwrap(), Edge::Strict, method, 1e-10);
        assert_same(&solution, &expected, 1e-8);
    }
}

#[test]
fn finite_elements_of_the_continuum_are_nearer_than_the_source_came() {
    let continuum = square_reference("continuum_u_n128.npy");
    let [x, y, z] = errors(&square(128, Edge::Inclusive), &continuum)[..] else { panic!("three components") };
    assert!(x < 0.00064 && y < 0.00064 && x < SOURCE_ERROR / 3.0, "{x} {y}");
    assert!(z < 0.0079, "{z}");
    let [coarser, finer] = [64, 256].map(|n| errors(&square(n, Edge::Inclusive), &continuum)[0]);
    let orders = [(coarser / x).log2(), (x / finer).log2()];
    assert!(orders.iter().all(|order| (order - 0.95).abs() < 0.1) && orders[1] > orders[0], "{orders:?}");
    // With its own strict inequality the source cannot have come so near.
    assert!(errors(&square(128, Edge::Strict), &continuum)[0] > 2.0 * SOURCE_ERROR);
    let [x, z] = errors(&strip(128, Edge::Inclusive), &strip_reference("continuum_u_n128.npy"))[..] else {
        panic!("two components")
    };
    assert!(x < 0.00065 && z < 0.0064, "{x} {z}");
}

/// Error of the grid `[n, 2 n, 4 n]`, measured order of the last two, and the error of the limit without the first and
/// second power of the spacing; all relative to the pressure of the continuum.
fn refine(pressure: impl Fn(usize) -> f64, n: usize, continuum: f64) -> (f64, f64, f64) {
    let [a, b, c] = [n, 2 * n, 4 * n].map(|n| pressure(n) / continuum - 1.0);
    (c, (b / c).log2(), (8.0 * c - 6.0 * b + a) / 3.0)
}

#[test]
fn the_force_converges_to_that_of_finite_elements() {
    let continuum = |folder: &str| {
        let summary = reference(&format!("{folder}/summary.json"));
        -number(&summary, "continuum_mean_sigma_zz_GPa")
    };
    let expected = continuum("punch3d_sticking_zm1_nu033");
    for edge in [Edge::Strict, Edge::Inclusive] {
        let (finest, order, limit) = refine(|n| pressure(&square(n, edge)), 64, expected);
        assert!(finest.abs() < 0.025 && (order - 1.0).abs() < 0.05, "{edge:?}: {finest} {order}");
        assert!(limit.abs() < 1e-4, "{edge:?}: {limit}");
    }
    let expected = continuum("punch2d_sticking_zm1_nu033");
    for edge in [Edge::Strict, Edge::Inclusive] {
        let (_, order, limit) = refine(|n| pressure(&strip(n, edge)), 256, expected);
        assert!((order - 1.0).abs() < 0.01 && limit.abs() < 1e-6, "{edge:?}: {order} {limit}");
    }
}

#[test]
fn the_points_of_either_edge_stand_for_one_effective_width() {
    // Interpolated to the true width; each alone errs by 2 or 5 %.
    let grid = Grid::square(128, LENGTH).unwrap();
    let [inner, outer] = [Edge::Strict, Edge::Inclusive]
        .map(|edge| [FlatPunch::new(0.25, edge).unwrap().effective_width(&grid), pressure(&square(128, edge))]);
    let part = (0.25 * LENGTH - inner[0]) / (outer[0] - inner[0]);
    let between = inner[1] + part * (outer[1] - inner[1]);
    let summary = reference("punch3d_sticking_zm1_nu033/summary.json");
    let expected = -number(&summary, "continuum_mean_sigma_zz_GPa");
    assert_relative_eq!(between, expected, max_relative = 2e-3);
}
