//! Flat punches against independent solutions (dense sticking punches, the hard-wall solver, the closed form of the
//! strip), and both families of methods against each other.

use std::sync::Arc;

use approx::assert_relative_eq;
use gfmd_contact::{Contact, Equilibrium, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_mixed::{Edge, FlatPunch, Method, MixedProblem, MixedSolution, Prescribed};
use gfmd_relax::Budget;
use gfmd_response::FullResponse;
use ndarray::{Array2, Axis, s};
use serde_json::Value;

const METHODS: [Method; 4] = [Method::ConjugateGradients, Method::Verlet, Method::VerletCritical, Method::Fire];

fn material(poisson: f64) -> Material {
    Material::from_young(70.0, poisson).unwrap()
}

fn solve(response: &Arc<FullResponse>, prescribed: Prescribed, method: Method, tolerance: f64) -> MixedSolution {
    let budget = Budget { tolerance, ..Budget::default() };
    MixedProblem::with_response(Arc::clone(response), prescribed).unwrap().solve(method, &budget, &mut ()).unwrap()
}

/// Returns the points within `half` points of the middle of the cell.
fn middle(grid: &Grid, half: f64) -> Array2<bool> {
    let [nx, ny] = grid.points();
    let near = |i: usize, n: usize| n == 1 || (i as f64 - 0.5 * n as f64).abs() <= half;
    Array2::from_shape_fn((nx, ny), |(i, j)| near(i, nx) && near(j, ny))
}

fn reference(name: &str) -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/reference/");
    serde_json::from_str(&std::fs::read_to_string(format!("{path}{name}")).unwrap()).unwrap()
}

#[test]
fn sticking_punches_are_those_of_a_dense_solution() {
    for case in reference("sticking_punch.json")["problems"].as_array().unwrap() {
        let number = |key: &str| case[key].as_f64().unwrap();
        let (n, depth) = (case["n"].as_u64().unwrap() as usize, number("u0"));
        let grid = Grid::square(n, number("L")).unwrap();
        let slab = Body::slab(Material::from_young(number("E"), number("nu")).unwrap(), number("zm")).unwrap();
        let response = Arc::new(FullResponse::new(grid, &slab));
        let points = FlatPunch::new(number("punch_fraction"), Edge::Strict).unwrap().points(&grid);
        assert_eq!(points.iter().filter(|under| **under).count() as u64, case["contact_nodes"].as_u64().unwrap());
        let held = Prescribed::sticking(&grid, points.view(), [0.0, 0.0, -depth]).unwrap();
        let solution = solve(&response, held, Method::ConjugateGradients, 1e-13);
        for probe in case["probes"].as_array().unwrap() {
            let [i, j] = [0, 1].map(|axis| probe[axis].as_u64().unwrap() as usize);
            for component in 0..3 {
                let expected = probe[2 + component].as_f64().unwrap();
                assert_relative_eq!(solution.displacement[[component, i, j]], expected, epsilon = 1e-10 * depth);
            }
        }
        for (mean, expected) in solution.mean_traction().iter().zip(case["mean_traction"].as_array().unwrap()) {
            assert_relative_eq!(*mean, expected.as_f64().unwrap(), epsilon = 1e-11);
        }
        let largest = |component: usize| {
            solution.traction.index_axis(Axis(0), component).iter().fold(0.0_f64, |most, t| most.max(t.abs()))
        };
        assert_relative_eq!(largest(0), number("max_abs_tx"), max_relative = 1e-9);
        assert_relative_eq!(largest(2), -number("min_tz"), max_relative = 1e-9);
        assert_relative_eq!(solution.elastic_energy(), number("elastic_energy_per_area"), max_relative = 1e-10);
    }
}

#[test]
fn every_method_finds_the_same_state() {
    let bodies = [
        Body::slab(material(0.33), 1.0).unwrap(),
        Body::slab(material(0.5), 0.2).unwrap(),
        Body::half_space(material(0.3)),
    ];
    for grid in [Grid::square(20, 1.0).unwrap(), Grid::new([15, 12], [1.0, 0.9]).unwrap(), Grid::line(33, 1.0).unwrap()]
    {
        for body in &bodies {
            let response = Arc::new(FullResponse::new(grid, body));
            let points = middle(&grid, 3.0);
            let sticking = Prescribed::sticking(&grid, points.view(), [2e-3, 1e-3, -5e-3]).unwrap();
            let frictionless = Prescribed::frictionless(&grid, points.view(), -5e-3).unwrap();
            for prescribed in [sticking, frictionless] {
                let [first, others @ ..] = METHODS;
                let expected = solve(&response, prescribed.clone(), first, 1e-11);
                for method in others {
                    let found = solve(&response, prescribed.clone(), method, 1e-11);
                    let largest = expected.traction.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
                    for (found, expected) in found.traction.iter().zip(&expected.traction) {
                        assert_relative_eq!(found, expected, epsilon = 1e-8 * largest);
                    }
                    for (found, expected) in found.displacement.iter().zip(&expected.displacement) {
                        assert_relative_eq!(found, expected, epsilon = 1e-10 * 5e-3);
                    }
                }
            }
        }
    }
}

#[test]
fn a_frictionless_punch_is_the_contact_of_a_flat_surface() {
    // The number of points is odd: without Nyquist modes, u_z alone and all components agree (theory.md, section 0).
    let grid = Grid::new([45, 33], [1.0, 0.8]).unwrap();
    let points = middle(&grid, 5.0);
    let heights = points.mapv(|under| if under { 0.0 } else { -1.0 });
    for body in [Body::slab(material(0.33), 0.3).unwrap(), Body::slab(material(0.5), 0.3).unwrap()] {
        let full = Arc::new(FullResponse::new(grid, &body));
        let depth = 0.01;
        let held = Prescribed::frictionless(&grid, points.view(), -depth).unwrap();
        let solution = solve(&full, held, Method::ConjugateGradients, 1e-12);
        let contact = Contact::new(&body, &grid, &heights).unwrap();
        let expected = contact.press(Load::Approach(depth)).tolerance(1e-12).solve().unwrap();
        let pressures = solution.traction.slice(s![2, .., ..]).mapv(|t| -t);
        let most = expected.pressure.iter().copied().fold(0.0, f64::max);
        for (found, expected) in pressures.iter().zip(&expected.pressure) {
            assert_relative_eq!(found, expected, epsilon = 1e-9 * most);
        }
        for (found, expected) in solution.displacement.slice(s![2, .., ..]).iter().zip(&expected.displacement) {
            assert_relative_eq!(found, expected, epsilon = 1e-10 * depth);
        }
        assert!(solution.traction.slice(s![..2, .., ..]).iter().all(|t| *t == 0.0));
    }
}

#[test]
fn a_frictionless_strip_tends_to_its_closed_form() {
    let strip = &reference("analytic/analytic.json")["periodic_strip_punch_frictionless"];
    let half_space = Body::half_space(Material::from_contact_modulus(1.0, 0.33).unwrap());
    for case in strip["cases"].as_array().unwrap() {
        let fraction = case["contact_fraction"].as_f64().unwrap();
        // Mean pressure 1 presses the strip this far below the mean level of the surface.
        let depth = -2.0 / std::f64::consts::PI * (0.5 * std::f64::consts::PI * fraction).sin().ln();
        let punch = FlatPunch::new(fraction, Edge::Inclusive).unwrap();
        let pressure = |n: usize| {
            let grid = Grid::line(n, 1.0).unwrap();
            let held = Prescribed::frictionless(&grid, punch.points(&grid).view(), -depth);
            let solution =
                solve(&FullResponse::new(grid, &half_space).into(), held.unwrap(), Method::ConjugateGradients, 1e-10);
            assert!(solution.displacement.slice(s![1, .., ..]).mean().unwrap().abs() < 1e-12);
            -solution.mean_traction()[1]
        };
        // The number of points is a multiple of 40, so that points lie on the edges.
        let [coarse, middle, fine] = [320, 640, 1280].map(|n| pressure(n) - 1.0);
        for (coarse, fine) in [(coarse, middle), (middle, fine)] {
            let order = (coarse / fine).log2();
            assert!((order - 1.0).abs() < 0.1, "fraction {fraction}: order {order}, errors {coarse} {fine}");
        }
        let extrapolated = (8.0 * fine - 6.0 * middle + coarse) / 3.0;
        assert!(extrapolated.abs() < 1e-5, "fraction {fraction}: {extrapolated}");
    }
}

#[test]
fn the_cost_hardly_grows_with_the_grid() {
    let body = Body::slab(material(0.33), 1.27).unwrap();
    let punch = FlatPunch::new(0.25, Edge::Inclusive).unwrap();
    let pairs = |n: usize| {
        let grid = Grid::square(n, 1.27).unwrap();
        let held = Prescribed::sticking(&grid, punch.points(&grid).view(), [0.0, 0.0, -0.005]).unwrap();
        solve(&FullResponse::new(grid, &body).into(), held, Method::ConjugateGradients, 1e-8).transform_pairs / 3.0
    };
    let [coarse, fine] = [32, 256].map(pairs);
    assert!(fine <= coarse + 10.0 && fine <= 26.0, "{coarse} {fine}");
}

#[test]
fn a_few_iterations_are_enough_whatever_is_held_and_whatever_the_body() {
    let n = 64;
    let grid = Grid::square(n, 1.0).unwrap();
    let wave = |i: usize, j: usize| {
        let [x, y] = [i, j].map(|k| std::f64::consts::TAU * k as f64 / n as f64);
        (3.0 * x).cos() * (4.0 * y + 1.0).cos() + 0.7 * (7.0 * x + 5.0 * y).cos() + 0.5 * (9.0 * y - 11.0 * x).sin()
    };
    let square = middle(&grid, 8.0);
    let hole = square.mapv(|inside| !inside);
    let patches = Array2::from_shape_fn((n, n), |(i, j)| wave(i, j) > 1.2);
    let scattered = Array2::from_shape_fn((n, n), |(i, j)| ((i * n + j) as f64 * 0.618_033_988).fract() < 0.1);
    for poisson in [-0.5, 0.33, 0.499, 0.5] {
        let [thin, thick] = [0.02, 0.3].map(|height| Body::slab(material(poisson), height).unwrap());
        for body in [thin, thick, Body::half_space(material(poisson))] {
            let response = Arc::new(FullResponse::new(grid, &body));
            for points in [&square, &hole, &patches, &scattered] {
                let sticking = Prescribed::sticking(&grid, points.view(), [0.3, 0.0, -1.0]).unwrap();
                let frictionless = Prescribed::frictionless(&grid, points.view(), -1.0).unwrap();
                for prescribed in [sticking, frictionless] {
                    let solution = solve(&response, prescribed, Method::ConjugateGradients, 1e-8);
                    assert!(solution.iterations <= 30, "{} iterations, {body:?}", solution.iterations);
                }
            }
        }
    }
}
