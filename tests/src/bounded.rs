//! Contacts with free boundaries, a hardness, or both: dense solutions of small problems, and closed forms on a patch
//! with errors that must fall with the grid spacing at an order measured here.

use std::f64::consts::PI;

use gfmd_contact::{Boundary, Contact, Equilibrium, Load, Solution, Solver};
use gfmd_field::Grid;
use ndarray::Array2;
use serde_json::Value;

use crate::check::{Worst, order};
use crate::{Check, Reference, ValidationError, unit_half_space};

pub(crate) fn checks(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let mut checks = dense(reference)?;
    checks.extend(shapes()?);
    checks.push(line()?);
    Ok(checks)
}

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().into_iter().flatten().map(|number| number.as_f64().unwrap_or(f64::NAN)).collect()
}

/// Solves every problem by every solver.
fn dense(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let file = reference.json("bounded_contacts.json")?;
    let mut checks = Vec::new();
    for problem in file["problems"].as_array().into_iter().flatten() {
        let text = |key: &str| problem[key].as_str().unwrap_or_default();
        let (grid, heights) = surface(&file["surfaces"][text("surface")])?;
        let boundary = if text("boundary") == "free" { Boundary::Free } else { Boundary::Periodic };
        let mut contact = Contact::with_boundary(boundary, &unit_half_space(), &grid, &heights)?;
        let hardness = problem["hardness"].as_f64();
        if let Some(hardness) = hardness {
            contact = contact.with_hardness(hardness)?;
        }
        let solvers = [Solver::PreconditionedCg, Solver::ProjectedCg, Solver::PolonskyKeer];
        let solvers = &solvers[..if hardness.is_some() { 1 } else { 3 }];
        let name = format!("{} {boundary}", text("surface"));
        checks.push(compare(&contact, problem, solvers, &name, "dense active sets")?);
    }
    Ok(checks)
}

/// Reads a surface from a file, with its grid.
pub(crate) fn surface(surface: &Value) -> Result<(Grid, Array2<f64>), ValidationError> {
    let (points, lengths) = (numbers(&surface["points"]), numbers(&surface["lengths"]));
    let grid = Grid::new([points[0] as usize, points[1] as usize], [lengths[0], lengths[1]])?;
    let heights = numbers(&surface["heights"]);
    Ok((grid, Array2::from_shape_fn(grid.points(), |(i, j)| heights[i * grid.points()[1] + j])))
}

/// Compares a contact by some solvers with the dense solution of a problem.
pub(crate) fn compare(
    contact: &Contact,
    problem: &Value,
    solvers: &[Solver],
    name: &str,
    reference: &'static str,
) -> Result<Check, ValidationError> {
    let [mean, approach, nodes, volume, full, stiffness] =
        ["mean_pressure", "approach", "contact_nodes", "plastic_volume", "plastic_nodes", "stiffness"]
            .map(|key| problem[key].as_f64().unwrap_or(f64::NAN));
    let is_approach = problem["control"].as_str() == Some("approach");
    let load = if is_approach { Load::Approach(approach) } else { Load::MeanPressure(mean) };
    let pressure = numbers(&problem["pressure"]);
    let peak = pressure.iter().copied().fold(0.0, f64::max);
    let mut worst = Worst::new();
    for solver in solvers {
        let solution = contact.press(load).solver(*solver).tolerance(1e-12).solve()?;
        solution.pressure.iter().zip(&pressure).for_each(|(found, exact)| worst.compare_to(*found, *exact, peak));
        worst.compare(solution.approach, approach);
        worst.compare(solution.mean_pressure, mean);
        worst.compare(contact.stiffness(&solution, 1e-9).map_or(f64::NAN, |found| found.value), stiffness);
        worst.compare(solution.pressure.iter().filter(|p| **p > 0.0).count() as f64, nodes);
        if let Some(plastic) = &solution.plastic {
            worst.compare(plastic.volume, volume);
            worst.compare(plastic.fraction, full / pressure.len() as f64);
        }
    }
    Ok(worst.check(format!("{name}, {} {load:?}", if is_approach { "to" } else { "by" }), reference, 1e-8))
}

/// Returns heights over a square patch of side 2 as a function of the distance from its centre, between the points.
fn round(n: usize, height: impl Fn(f64) -> f64) -> Array2<f64> {
    let at = |i: usize| (i as f64 + 0.5) * 2.0 / n as f64 - 1.0;
    Array2::from_shape_fn((n, n), |(i, j)| height(at(i).hypot(at(j))))
}

fn press(heights: &Array2<f64>, load: Load) -> Result<Solution, ValidationError> {
    let grid = Grid::square(heights.nrows(), 2.0)?;
    let contact = Contact::with_boundary(Boundary::Free, &unit_half_space(), &grid, heights)?;
    Ok(contact.press(load).tolerance(1e-10).solve()?)
}

/// Checks sphere, cone and flat punch of contact radius a = 1/2 on a patch of side 2: the errors of the approach.
fn shapes() -> Result<Vec<Check>, ValidationError> {
    let a = 0.5_f64;
    let grids = [32_u16, 64, 128, 256];
    let mut errors: [Vec<(usize, [f64; 2])>; 3] = Default::default();
    for n in grids.map(usize::from) {
        // The highest points lie half a diagonal from the centre, where the approach begins.
        let first = 2.0_f64.sqrt() / n as f64;
        // Paraboloid of radius 1: F = 4/3 a³, δ = a², p(0) = 2 a/π.
        let sphere = press(&round(n, |r| -0.5 * r * r), Load::MeanPressure(a.powi(3) / 3.0))?;
        let peak = sphere.pressure.iter().copied().fold(0.0, f64::max);
        errors[0].push((n, [(sphere.approach + 0.5 * first * first - a * a).abs(), (peak - 2.0 * a / PI).abs()]));
        // Cone of slope 1: F = π a²/2, δ = π a/2; by the approach, the error of the force.
        let cone = press(&round(n, |r| -r), Load::Approach(0.5 * PI * a - first))?;
        let force = 4.0 * cone.mean_pressure;
        errors[1].push((n, [(force - 0.5 * PI * a * a).abs(), 0.0]));
        // Flat punch: F = 2 a δ, with the radius of a circle with the area of the covered cells.
        let punch = press(&round(n, |r| if r < a { 0.0 } else { -1.0 }), Load::MeanPressure(0.025))?;
        let cells = punch.pressure.iter().filter(|p| **p > 0.0).count() as f64;
        let radius = (4.0 * cells / PI).sqrt() / n as f64;
        errors[2].push((n, [(punch.approach - 0.1 / (2.0 * radius)).abs(), 0.0]));
    }
    let [sphere, cone, punch] = &errors;
    let last = |errors: &[(usize, [f64; 2])], scale: f64| errors.last().map_or(f64::NAN, |(_, e)| e[0] / scale);
    let of = "closed form";
    let [by_approach, by_peak] = order(sphere);
    Ok(vec![
        Check::error("sphere on a patch, 256 x 256: approach", "Hertz", last(sphere, a * a), 2e-5),
        Check::at_least("sphere on a patch: order of the approach", "Hertz", by_approach, 1.9),
        Check::at_least("sphere on a patch: order of the largest pressure", "Hertz", by_peak, 1.8),
        Check::error("cone on a patch, 256 x 256: force", of, last(cone, 0.5 * PI * a * a), 2e-5),
        Check::at_least("cone on a patch: order of the force", of, order(cone)[0], 1.9),
        Check::error("flat punch on a patch, 256 x 256: approach", of, last(punch, 0.1), 2.5e-3),
        Check::at_least("flat punch on a patch: order of the approach", of, order(punch)[0], 0.9),
    ])
}

/// Checks a cylinder on a line: a² = 4 F R/π, p(0) = 2 F/(π a).
fn line() -> Result<Check, ValidationError> {
    let (n, a) = (1024, 0.5_f64);
    let grid = Grid::line(n, 2.0)?;
    let heights = Array2::from_shape_fn((n, 1), |(i, _)| -0.5 * ((i as f64 + 0.5) * 2.0 / n as f64 - 1.0).powi(2));
    let contact = Contact::with_boundary(Boundary::Free, &unit_half_space(), &grid, &heights)?;
    let force = 0.25 * PI * a * a;
    let solution = contact.press(Load::MeanPressure(force / 2.0)).tolerance(1e-10).solve()?;
    let peak = solution.pressure.iter().copied().fold(0.0, f64::max);
    let width = solution.pressure.iter().filter(|p| **p > 0.0).count() as f64 * 2.0 / n as f64;
    let mut worst = Worst::new();
    worst.compare(peak, 2.0 * force / (PI * a));
    worst.compare(width, 2.0 * a);
    Ok(worst.check("cylinder on a line of 1024 points: largest pressure and width", "Hertz", 4e-3))
}
