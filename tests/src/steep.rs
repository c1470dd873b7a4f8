//! Contacts with finite slopes: dense solutions of small problems.

use gfmd_contact::{Equilibrium, Load, SteepContact};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use ndarray::Array2;
use serde_json::Value;

use crate::check::Worst;
use crate::friction::numbers;
use crate::{Check, Reference, ValidationError};

const DENSE: &str = "dense Newton solutions with the spline of SciPy";

pub(crate) fn checks(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let file = reference.json("steep_contacts.json")?;
    file["cases"].as_array().into_iter().flatten().map(check).collect()
}

fn check(case: &Value) -> Result<Check, ValidationError> {
    let get = |key: &str| case[key].as_f64().unwrap_or(f64::NAN);
    let (points, lengths) = (numbers(&case["points"]), numbers(&case["lengths"]));
    let grid = Grid::new([points[0] as usize, points[1] as usize], [lengths[0], lengths[1]])?;
    let heights = numbers(&case["heights"]);
    let heights = Array2::from_shape_fn(grid.points(), |(i, j)| heights[i * grid.points()[1] + j]);
    let nu = get("poisson");
    let body = Body::half_space(Material::from_contact_modulus(1.0, nu)?);
    let load = match case["load"]["approach"].as_f64() {
        Some(approach) => Load::Approach(approach),
        None => Load::MeanPressure(case["load"]["mean_pressure"].as_f64().unwrap_or(f64::NAN)),
    };
    let contact = SteepContact::new(&body, &grid, &heights)?;
    let solution = contact.press(load).tolerance(1e-11).solve()?;
    let mut worst = Worst::new();
    let pressure = numbers(&case["pressure"]);
    let peak = pressure.iter().copied().fold(0.0, f64::max);
    solution.normal.pressure.iter().zip(&pressure).for_each(|(found, exact)| worst.compare_to(*found, *exact, peak));
    let fields = solution.lateral.iter().chain([&solution.normal.displacement, &solution.normal.gap]);
    let displacement = case["displacement"].as_array().cloned().unwrap_or_default();
    let [x, y, z] = [0, 1, 2].map(|axis| displacement.get(axis).map(numbers).unwrap_or_default());
    let exact = if grid.is_line() { vec![x, z] } else { vec![x, y, z] };
    let scale = contact.surface().rms_height();
    for (field, exact) in fields.zip(exact.into_iter().chain([numbers(&case["gap"])])) {
        field.iter().zip(&exact).for_each(|(found, exact)| worst.compare_to(*found, *exact, scale));
    }
    worst.compare(solution.normal.approach, get("approach"));
    let gradient = contact.surface().rms_gradient();
    let what = if grid.is_line() { "profile" } else { "surface" };
    Ok(worst.check(format!("{what} of rms gradient {gradient:.2}, finite slopes, nu = {nu}"), DENSE, 1e-8))
}
