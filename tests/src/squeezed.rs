//! A slab between two rough surfaces: dense solutions of small problems, and its waves.

use gfmd_contact::{Equilibrium, Load, SqueezedContact};
use gfmd_field::Grid;
use gfmd_green::Plate;
use ndarray::Array2;
use serde_json::Value;

use crate::check::Worst;
use crate::friction::{body, numbers};
use crate::{Check, Reference, ValidationError};

const DENSE: &str = "dense active sets on both faces, waves by matrix exponentials with 50 digits";
const WAVES: &str = "matrix exponentials with 50 digits";

pub(crate) fn checks(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let file = reference.json("squeezed_slabs.json")?;
    let mut checks = vec![waves(&file)?];
    for case in file["cases"].as_array().into_iter().flatten() {
        checks.push(contact(case)?);
    }
    Ok(checks)
}

/// Compares the compliances of both faces, relative to the largest.
fn waves(file: &Value) -> Result<Check, ValidationError> {
    let mut worst = Worst::new();
    for wave in file["waves"].as_array().into_iter().flatten() {
        let found = Plate::of(&body(wave)?)?.compliance(wave["q"].as_f64().unwrap_or(f64::NAN));
        let exact = numbers(&wave["compliance"]);
        let mean = 0.5 * (found.squeezing + found.bending);
        let entries = [mean + found.mixed, 0.5 * (found.squeezing - found.bending), mean - found.mixed];
        entries.iter().zip(&exact).for_each(|(entry, exact)| worst.compare_to(*entry, *exact, found.bending));
    }
    Ok(worst.check("compliance of slabs and layers pressed on both faces", WAVES, 1e-11))
}

/// Compares both pressures and gaps, the load, and the parts of the approach.
fn contact(case: &Value) -> Result<Check, ValidationError> {
    let get = |key: &str| case[key].as_f64().unwrap_or(f64::NAN);
    let (points, lengths) = (numbers(&case["points"]), numbers(&case["lengths"]));
    let (points, lengths) = ([points[0] as usize, points[1] as usize], [lengths[0], lengths[1]]);
    let grid = if points[1] == 1 { Grid::line(points[0], lengths[0])? } else { Grid::new(points, lengths)? };
    let [upper, lower] = ["upper", "lower"].map(|key| {
        let heights = numbers(&case[key]);
        Array2::from_shape_fn(points, |(i, j)| heights[i * points[1] + j])
    });
    let load = match case["control"].as_str() {
        Some("approach") => Load::Approach(get("approach")),
        _ => Load::MeanPressure(get("mean_pressure")),
    };
    let contact = SqueezedContact::new(&body(case)?, &grid, &upper, &lower)?;
    let state = contact.press(load).tolerance(1e-11).solve()?;
    let mut worst = Worst::new();
    for (face, name) in [(&state.upper, "upper"), (&state.lower, "lower")] {
        for (field, key) in [(&face.pressure, "pressure"), (&face.gap, "gap")] {
            let exact = numbers(&case[format!("{name}_{key}")]);
            let largest = exact.iter().copied().fold(0.0, f64::max);
            field.iter().zip(&exact).for_each(|(found, exact)| worst.compare_to(*found, *exact, largest));
        }
        worst.compare(face.mean_pressure, get("mean_pressure"));
    }
    let parts = numbers(&case["approaches"]);
    worst.compare(state.approach, get("approach"));
    worst.compare_to(state.upper.approach, parts[0], get("approach"));
    worst.compare_to(state.lower.approach, parts[1], get("approach"));
    let name = case["name"].as_str().unwrap_or_default();
    let [nx, ny] = points;
    Ok(worst.check(format!("between two surfaces: {name}, {nx} x {ny}"), DENSE, 1e-8))
}
