//! Contact problems with exact solutions by independent programs: active sets, and two public codes that agree.

use std::f64::consts::TAU;

use gfmd_contact::{Load, Solution};
use gfmd_field::Grid;
use gfmd_green::{Body, Height, Material};
use gfmd_measure::{Boundary, contact_area, elastic_energy_density};
use gfmd_response::NormalResponse;
use ndarray::{Array2, Ix2};
use serde_json::Value;

use crate::check::Worst;
use crate::{Check, Reference, SOLVERS, ValidationError, press, press_on_half_space};

pub(crate) fn checks(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let mut checks = active_sets(reference)?;
    checks.push(rough_surface(reference)?);
    checks.push(four_waves()?);
    Ok(checks)
}

fn get(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or(f64::NAN)
}

/// Returns the heights −(h − min h): the reference has the lower face of the punch, measured from its lowest point.
fn heights(problem: &Value) -> Array2<f64> {
    let [nx, ny] = ["nx", "ny"].map(|key| get(problem, key) as usize);
    Array2::from_shape_fn((nx, ny), |(i, j)| {
        let wave = |c: &Value| {
            let [a, m, n, phase] = [0, 1, 2, 3].map(|k| c[k].as_f64().unwrap_or(f64::NAN));
            a * (TAU * (m * i as f64 / nx as f64 + n * j as f64 / ny as f64) + phase).cos()
        };
        -problem["height_components"].as_array().into_iter().flatten().map(wave).sum::<f64>()
    })
}

fn response(problem: &Value) -> Result<NormalResponse, ValidationError> {
    let get = |key| get(problem, key);
    let grid = Grid::new([get("nx") as usize, get("ny") as usize], [get("Lx"), get("Ly")])?;
    let height = problem["zm"].as_f64().map_or(Height::Infinite, Height::Finite);
    let body = Body::new(Material::from_young(get("E"), get("nu"))?, height)?;
    Ok(match problem["kernel"].as_str() {
        Some("restricted") => NormalResponse::held_sideways(grid, &body),
        _ => NormalResponse::new(grid, &body),
    })
}

/// Solves each problem by every solver, with prescribed load and with prescribed approach.
fn active_sets(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let file = reference.json("contact_problems.json")?;
    let mut checks = Vec::new();
    for problem in file["problems"].as_array().into_iter().flatten() {
        let [delta, mean] = ["delta", "mean_pressure"].map(|key| get(problem, key));
        let (response, heights) = (response(problem)?.into(), heights(problem));
        let rows = problem["pressure_row_major"].as_array().into_iter().flatten();
        let values = rows.flat_map(|row| row.as_array().cloned().unwrap_or_else(|| vec![row.clone()]));
        let pressures: Vec<f64> = values.map(|p| p.as_f64().unwrap_or(f64::NAN)).collect();
        let mut worst = Worst::new();
        for control in [Load::MeanPressure(mean), Load::Approach(delta)] {
            for solver in SOLVERS {
                let solution = press(&response, &heights, control, solver, 1e-12)?;
                compare(&mut worst, &solution, problem, &pressures);
                worst.compare(solution.approach, delta);
                worst.compare(solution.mean_pressure, mean);
                worst.compare_to(average(&solution.displacement), get(problem, "mean_displacement"), delta);
            }
        }
        let name = problem["name"].as_str().unwrap_or("unnamed").replace('_', " ");
        checks.push(worst.check(format!("{name}: every solver, both controls"), "primal-dual active sets", 1e-9));
    }
    Ok(checks)
}

/// Compares pressure (relative to its largest value), mean gap and energy; infinite error if the contact nodes differ.
fn compare(worst: &mut Worst, solution: &Solution, expected: &Value, pressures: &[f64]) {
    let area = contact_area(solution.pressure.view(), Boundary::Periodic);
    if area.nodes as f64 != get(expected, "contact_nodes") {
        worst.compare(f64::INFINITY, 0.0);
    }
    let peak = pressures.iter().copied().fold(0.0, f64::max);
    for (found, wanted) in solution.pressure.iter().zip(pressures) {
        worst.compare_to(*found, *wanted, peak);
    }
    worst.compare(average(&solution.gap), get(expected, "mean_gap"));
    let energy = elastic_energy_density(solution.pressure.view(), solution.displacement.view());
    worst.compare(energy.unwrap_or(f64::NAN), get(expected, "elastic_energy_per_area"));
}

fn average(field: &Array2<f64>) -> f64 {
    field.mean().unwrap_or(f64::NAN)
}

fn rough_surface(reference: &Reference) -> Result<Check, ValidationError> {
    let heights = reference.array::<Ix2>("rough_H08_n256/h.npy")?;
    let pressures: Vec<f64> = reference.array::<Ix2>("rough_H08_n256/p.npy")?.into_iter().collect();
    let summary = reference.json("rough_H08_n256/summary.json")?;
    let solution = press_on_half_space(&heights, get(&summary, "p0"), 1e-12)?;
    let mut worst = Worst::new();
    compare(&mut worst, &solution, &summary, &pressures);
    let links = contact_area(solution.pressure.view(), Boundary::Periodic).boundary_links as f64;
    worst.compare(links, get(&summary, "boundary_links"));
    Ok(worst.check("rough surface, 256 x 256: node by node", "Polonsky-Keer to 1e-13, active sets", 1e-9))
}

fn four_waves() -> Result<Check, ValidationError> {
    let n = 64;
    let heights = Array2::from_shape_fn((n, n), |(i, j)| {
        let [x, y] = [i, j].map(|k| TAU * k as f64 / n as f64);
        let waves = x.cos() + 0.5 * (2.0 * y + 0.3).cos() + 0.25 * (3.0 * x - 2.0 * y + 1.1).cos();
        0.01 * (waves + 0.125 * (5.0 * x + 4.0 * y + 2.0).cos())
    });
    let mut worst = Worst::new();
    for (pressure, nodes, peak, gap) in [
        (0.005, 570, 0.097_119_164_4, 0.007_581_884_52),
        (0.02, 1742, 0.127_922_891_2, 0.002_135_958_89),
        (0.05, 3344, 0.161_929_049_1, 0.000_247_824_448),
    ] {
        let solution = press_on_half_space(&heights, pressure, 1e-12)?;
        worst.compare(contact_area(solution.pressure.view(), Boundary::Periodic).nodes as f64, f64::from(nodes));
        worst.compare(solution.pressure.iter().copied().fold(0.0, f64::max), peak);
        worst.compare(average(&solution.gap), gap);
    }
    Ok(worst.check("four waves, 64 x 64, three loads", "two public codes that agree to ten digits", 5e-9))
}
