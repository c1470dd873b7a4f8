//! Contact problems that independent programs solved exactly: active sets, and two public codes that agree.

use std::f64::consts::TAU;

use approx::assert_relative_eq;
use gfmd_contact::{Control, Settings};
use gfmd_field::Grid;
use gfmd_green::{Body, Height, Material};
use gfmd_measure::{contact_area, elastic_energy_density};
use gfmd_response::NormalResponse;
use gfmd_tests::{SOLVERS, number, press, press_on_half_space, reference, reference_array};
use ndarray::Array2;
use serde_json::Value;

/// −(h − min h): the reference describes the punch by its lower face, lowest point first.
fn heights(problem: &Value) -> Array2<f64> {
    let [nx, ny] = ["nx", "ny"].map(|key| number(problem, key) as usize);
    let components = problem["height_components"].as_array().expect("components");
    Array2::from_shape_fn((nx, ny), |(i, j)| {
        let wave = |c: &Value| {
            let [a, m, n, phase] = [0, 1, 2, 3].map(|k| c[k].as_f64().expect("a number"));
            a * (TAU * (m * i as f64 / nx as f64 + n * j as f64 / ny as f64) + phase).cos()
        };
        -components.iter().map(wave).sum::<f64>()
    })
}

fn response(problem: &Value) -> NormalResponse {
    let number = |key| number(problem, key);
    let grid = Grid::new([number("nx") as usize, number("ny") as usize], [number("Lx"), number("Ly")]).unwrap();
    let height = problem["zm"].as_f64().map_or(Height::Infinite, Height::Finite);
    let body = Body::new(Material::from_young(number("E"), number("nu")).unwrap(), height).unwrap();
    match problem["kernel"].as_str() {
        Some("restricted") => NormalResponse::held_sideways(grid, &body),
        _ => NormalResponse::new(grid, &body),
    }
}

#[test]
fn every_solver_finds_the_active_set_solution() {
    let file = reference("contact_problems.json");
    for problem in file["problems"].as_array().unwrap() {
        let [delta, mean] = ["delta", "mean_pressure"].map(|key| number(problem, key));
        let response = response(problem);
        let heights = heights(problem);
        let expected: Vec<f64> = problem["pressure_row_major"]
            .as_array()
            .unwrap()
            .iter()
            .flat_map(|row| row.as_array().cloned().unwrap_or_else(|| vec![row.clone()]))
            .map(|p| p.as_f64().unwrap())
            .collect();
        let peak = number(problem, "max_pressure");
        // Both controls, whatever the reference used.
        for control in [Control::MeanPressure(mean), Control::Approach(delta)] {
            for solver in SOLVERS {
                let case = format!("{} {control:?} {solver:?}", problem["name"]);
                let settings = Settings { solver, tolerance: 1e-12, max_iterations: 100_000 };
                let solution = press(&response, heights.view(), control, &settings)
                    .unwrap_or_else(|error| panic!("{case}: {error}"));
                assert!(solution.residual.worst() <= 1e-12, "{case}: {}", solution.residual);
                let area = contact_area(solution.pressure.view());
                assert_eq!(area.nodes as f64, number(problem, "contact_nodes"), "{case}");
                assert_relative_eq!(solution.mean_pressure, mean, max_relative = 1e-9);
                assert_relative_eq!(solution.approach, delta, max_relative = 1e-9);
                for (p, expected) in solution.pressure.iter().zip(&expected) {
                    assert!((p - expected).abs() < 1e-9 * peak, "{case}: {p} instead of {expected}");
                }
                let gap = solution.gap.mean().unwrap();
                assert_relative_eq!(gap, number(problem, "mean_gap"), max_relative = 1e-9);
                let mean_displacement = solution.displacement.mean().unwrap();
                assert!((mean_displacement - number(problem, "mean_displacement")).abs() < 1e-9 * delta, "{case}");
                let energy = elastic_energy_density(solution.pressure.view(), solution.displacement.view());
                assert_relative_eq!(energy, number(problem, "elastic_energy_per_area"), max_relative = 1e-9);
            }
        }
    }
}

#[test]
fn rough_surface_matches_the_reference_node_by_node() {
    let heights = reference_array("rough_H08_n256/h.npy");
    let expected = reference_array("rough_H08_n256/p.npy");
    let summary = reference("rough_H08_n256/summary.json");
    let solution = press_on_half_space(heights.view(), number(&summary, "p0"), 1e-12);
    let area = contact_area(solution.pressure.view());
    assert_eq!(area.nodes as f64, number(&summary, "contact_nodes"));
    assert_eq!(area.boundary_links as f64, number(&summary, "boundary_links"));
    let worst = solution.pressure.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-9 * number(&summary, "p0"), "{worst:e}");
    assert_relative_eq!(solution.gap.mean().unwrap(), number(&summary, "mean_gap"), max_relative = 1e-9);
    let peak = solution.pressure.iter().copied().fold(0.0, f64::max);
    assert_relative_eq!(peak, number(&summary, "p_max"), max_relative = 1e-9);
    let energy = elastic_energy_density(solution.pressure.view(), solution.displacement.view());
    assert_relative_eq!(energy, number(&summary, "elastic_energy_per_area"), max_relative = 1e-9);
}

#[test]
fn four_waves_match_two_public_codes() {
    let n = 64;
    let heights = Array2::from_shape_fn((n, n), |(i, j)| {
        let [x, y] = [i, j].map(|k| TAU * k as f64 / n as f64);
        let waves = x.cos()
            + 0.5 * (2.0 * y + 0.3).cos()
            + 0.25 * (3.0 * x - 2.0 * y + 1.1).cos()
            + 0.125 * (5.0 * x + 4.0 * y + 2.0).cos();
        0.01 * waves
    });
    for (pressure, nodes, peak, gap) in [
        (0.005, 570, 0.097_119_164_4, 0.007_581_884_52),
        (0.02, 1742, 0.127_922_891_2, 0.002_135_958_89),
        (0.05, 3344, 0.161_929_049_1, 0.000_247_824_448),
    ] {
        let solution = press_on_half_space(heights.view(), pressure, 1e-12);
        assert_eq!(contact_area(solution.pressure.view()).nodes, nodes);
        let found = solution.pressure.iter().copied().fold(0.0, f64::max);
        assert_relative_eq!(found, peak, max_relative = 1e-9);
        assert_relative_eq!(solution.gap.mean().unwrap(), gap, max_relative = 5e-9);
    }
}
