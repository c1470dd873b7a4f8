//! Contacts over a base that moves: dense solutions of small problems.

use gfmd_body::BaseField;
use gfmd_contact::{Contact, Equilibrium, Load};
use gfmd_field::Grid;
use ndarray::Array2;
use serde_json::Value;

use crate::check::Worst;
use crate::friction::{body, numbers};
use crate::{Check, Reference, ValidationError};

const DENSE: &str = "dense active sets, waves by boundary-value problems with 40 digits";

pub(crate) fn checks(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let file = reference.json("moving_base.json")?;
    file["cases"].as_array().into_iter().flatten().map(|case| check(&file, case)).collect()
}

fn check(file: &Value, case: &Value) -> Result<Check, ValidationError> {
    let get = |key: &str| case[key].as_f64().unwrap_or(f64::NAN);
    let (points, lengths) = (numbers(&file["points"]), numbers(&file["lengths"]));
    let grid = Grid::new([points[0] as usize, points[1] as usize], [lengths[0], lengths[1]])?;
    let shape = grid.points();
    let (given, components) = (numbers(&case["field"]), get("components") as usize);
    let mut field = vec![0.0; 3 * grid.len()];
    for (index, value) in given.iter().enumerate() {
        let component = if components == 1 { 2 } else { index % components };
        field[component * grid.len() + index / components] = *value;
    }
    let is_traction = case["kind"] == "traction";
    let base = if is_traction { BaseField::Traction(field) } else { BaseField::Displacement(field) };
    let body = body(case)?;
    let lift = base.surface_displacement(&body, grid)?.split_off(2 * grid.len());
    let heights = numbers(&file["heights"]);
    let under = Array2::from_shape_fn(shape, |(i, j)| heights[i * shape[1] + j] + lift[i * shape[1] + j]);
    let load = match case["control"].as_str() {
        Some("approach") => Load::Approach(get("approach")),
        _ => Load::MeanPressure(get("mean_pressure")),
    };
    let solution = Contact::new(&body, &grid, &under)?.press(load).tolerance(1e-12).solve()?;
    let mut worst = Worst::new();
    let pressure = numbers(&case["pressure"]);
    let peak = pressure.iter().copied().fold(0.0, f64::max);
    solution.pressure.iter().zip(&pressure).for_each(|(found, exact)| worst.compare_to(*found, *exact, peak));
    let displacement = numbers(&case["displacement_z"]);
    let deepest = displacement.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    let found = solution.displacement.iter().zip(&lift).map(|(u, lift)| u + lift);
    found.zip(&displacement).for_each(|(found, exact)| worst.compare_to(found, *exact, deepest));
    worst.compare(solution.approach, get("approach"));
    worst.compare(solution.mean_pressure, get("mean_pressure"));
    worst.compare(solution.pressure.iter().filter(|p| **p > 0.0).count() as f64, get("contact_nodes"));
    let layers = case["layers"].as_array().map_or(0, Vec::len);
    let words = case["base"].as_str().unwrap_or_default();
    let what = if is_traction { "traction on the lower face" } else { "displacement of the base" };
    Ok(worst.check(format!("contact of {layers} layer(s), base {words}, {what}"), DENSE, 1e-8))
}
