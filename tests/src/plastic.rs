//! Hardness per point, on half-spaces and layers, and plastic depth along a path: dense solutions of small problems.

use gfmd_contact::{Boundary, Budget, Contact, Fields, Hardness, Load, Solver};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_interface::{Parts, Path, QuasistaticContact, Refinement};
use ndarray::Array2;
use serde_json::Value;

use crate::bounded::{compare, numbers, surface};
use crate::check::Worst;
use crate::layered::File;
use crate::{Check, Reference, ValidationError, unit_half_space};

const DENSE: &str = "dense active sets";

pub(crate) fn checks(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let file = File(reference.json("plastic_contacts.json")?);
    let mut checks = Vec::new();
    for problem in file.rows("problems") {
        let posed = Posed::new(&file, problem)?;
        let Posed { boundary, body, grid, heights, .. } = &posed;
        let contact = Contact::with_boundary(*boundary, body, grid, heights)?.with_hardness(posed.hardness)?;
        checks.push(compare(&contact, problem, &[Solver::PreconditionedCg], &posed.name, DENSE)?);
    }
    for path in file.rows("paths") {
        checks.push(along(&file, path)?);
    }
    Ok(checks)
}

/// Parts of a problem, and its name.
struct Posed {
    boundary: Boundary,
    body: Body,
    grid: Grid,
    heights: Array2<f64>,
    hardness: Hardness,
    name: String,
}

impl Posed {
    fn new(file: &File, problem: &Value) -> Result<Self, ValidationError> {
        let [rough, name] = ["surface", "body"].map(|key| problem[key].as_str().unwrap_or_default());
        let (grid, heights) = surface(&file.0["surfaces"][rough])?;
        let (boundary, body) = match name.parse::<Boundary>() {
            Ok(boundary) => (boundary, unit_half_space()),
            Err(_) => (Boundary::Periodic, file.one(name)?),
        };
        let (hardness, kind) = match problem["hardness"].as_f64() {
            Some(hardness) => (Hardness::Uniform(hardness), "a hardness"),
            None => (field(&grid, &problem["hardness"])?.into(), "grains"),
        };
        Ok(Self { boundary, body, grid, heights, hardness, name: format!("{rough} {name}, {kind}") })
    }
}

fn field(grid: &Grid, values: &Value) -> Result<Array2<f64>, ValidationError> {
    let values = numbers(values);
    Ok(Array2::from_shape_fn(grid.points(), |(i, j)| values.get(i * grid.points()[1] + j).copied().unwrap_or(f64::NAN)))
}

/// Follows a path step by step and checks its fields at the end.
fn along(file: &File, path: &Value) -> Result<Check, ValidationError> {
    let Posed { boundary, body, grid, heights, hardness, name } = Posed::new(file, path)?;
    let hardness = Some(hardness);
    let plastic = QuasistaticContact::new(&Parts { boundary, hardness, ..Parts::new(&body, &grid, &heights) })?;
    let budget = Budget { tolerance: 1e-12, ..Budget::default() };
    let mut walk = Path::new(&plastic, budget, Refinement::default());
    let mut worst = Worst::new();
    let is_approach = path["control"].as_str() == Some("approach");
    let steps = path["steps"].as_array().into_iter().flatten();
    for (value, exact) in numbers(&path["values"]).into_iter().zip(steps) {
        let load = if is_approach { Load::Approach(value) } else { Load::MeanPressure(value) };
        let step = walk.step(load.into(), &mut ())?;
        let Some(state) = walk.state() else { continue };
        let expected = |key: &str| exact[key].as_f64().unwrap_or(f64::NAN);
        // Lengths and energies are relative to the whole path.
        let [depth, work] = ["plastic_volume", "energy"].map(expected);
        worst.compare(state.mean_pressure(), expected("mean_pressure"));
        worst.compare(state.approach(), expected("approach"));
        worst.compare(state.plastic_volume().unwrap_or(f64::NAN), depth);
        worst.compare(state.elastic_energy(), work);
        worst.compare_to(step.dissipated.unwrap_or(f64::NAN), expected("work"), work);
        worst.compare(state.pressure().iter().filter(|p| **p > 0.0).count() as f64, expected("contact_nodes"));
    }
    if let Some(state) = walk.state() {
        let depth = state.plastic_depth().map(|depth| depth.view());
        for (found, exact) in [(Some(state.pressure().view()), "pressure"), (depth, "plastic_depth")] {
            let exact = field(&grid, &path[exact])?;
            let most = exact.iter().copied().fold(0.0, f64::max);
            worst.compare(found.map_or(0, |found| found.len()) as f64, exact.len() as f64);
            found.iter().flatten().zip(&exact).for_each(|(found, exact)| worst.compare_to(*found, *exact, most));
        }
    }
    let kind = if is_approach { "approaches" } else { "loads" };
    Ok(worst.check(format!("{name}, a path of {kind}: every step, fields at the end"), DENSE, 1e-8))
}
