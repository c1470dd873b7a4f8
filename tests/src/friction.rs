//! Contacts with friction and with coupled pressure and shear, on slabs and for ν < ½: dense solutions of small
//! problems. Also the tangential stiffness of rough contacts.

use std::sync::Arc;

use gfmd_contact::{Boundary, Contact, Drive, Equilibrium, Fields, Load};
use gfmd_field::Grid;
use gfmd_green::{Base, BaseKind, Body, Material};
use gfmd_interface::{Parts, QuasistaticContact};
use gfmd_law::Limit;
use gfmd_mixed::{Method, MixedProblem, Prescribed};
use gfmd_relax::Budget;
use gfmd_response::FullResponse;
use gfmd_surface::SelfAffine;
use ndarray::{Array2, Array3};
use serde_json::Value;

use crate::check::Worst;
use crate::{Check, Reference, ValidationError};

const DENSE: &str = "dense complementarity problems of all components, waves by boundary-value problems with 40 digits";

pub(crate) fn checks(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let file = reference.json("friction_contacts.json")?;
    let mut checks = file["cases"].as_array().into_iter().flatten().map(case).collect::<Result<Vec<_>, _>>()?;
    checks.push(tangential_stiffness()?);
    Ok(checks)
}

pub(crate) fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().into_iter().flatten().map(|number| number.as_f64().unwrap_or(f64::NAN)).collect()
}

pub(crate) fn body(case: &Value) -> Result<Body, ValidationError> {
    let base = case["base"].as_str().and_then(|name| name.parse::<BaseKind>().ok()).unwrap_or_default();
    let mut layers = Vec::new();
    for row in case["layers"].as_array().into_iter().flatten() {
        let [young, poisson, height] = [0, 1, 2].map(|k| row[k].as_f64());
        let material = Material::from_young(young.unwrap_or(f64::NAN), poisson.unwrap_or(f64::NAN))?;
        match height {
            Some(height) => layers.push((material, height)),
            None if layers.is_empty() => return Ok(Body::half_space(material)),
            None => return Ok(Body::stack(&layers, Base::Elastic(Body::half_space(material).into()))?),
        }
    }
    let base: Base = base.with(None)?;
    Ok(Body::stack(&layers, base)?)
}

/// Returns the contact with friction at a hard wall.
pub(crate) fn rubbing(
    boundary: Boundary,
    body: &Body,
    grid: &Grid,
    heights: &Array2<f64>,
    limit: Limit,
) -> Result<QuasistaticContact, ValidationError> {
    let shear = Some(limit.into());
    Ok(QuasistaticContact::new(&Parts { boundary, shear, ..Parts::new(body, grid, heights) })?)
}

/// Checks every increment of a case, each from the state before.
fn case(case: &Value) -> Result<Check, ValidationError> {
    let name = case["name"].as_str().unwrap_or_default();
    let get = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let (points, lengths) = (numbers(&case["points"]), numbers(&case["lengths"]));
    let (points, lengths) = ([points[0] as usize, points[1] as usize], [lengths[0], lengths[1]]);
    let grid = if points[1] == 1 { Grid::line(points[0], lengths[0])? } else { Grid::new(points, lengths)? };
    let heights = numbers(&case["heights"]);
    let heights = Array2::from_shape_fn((points[0], points[1]), |(i, j)| heights[i * points[1] + j]);
    let limit = Limit::Coulomb(get(&case["coefficient"]));
    let contact = rubbing(Boundary::Periodic, &body(case)?, &grid, &heights, limit)?;
    follow(&contact, case, format!("friction, {name}"), DENSE)
}

/// Returns the states of a case by `contact`, each increment from the state before.
pub(crate) fn follow(
    contact: &QuasistaticContact,
    case: &Value,
    name: String,
    source: &'static str,
) -> Result<Check, ValidationError> {
    let get = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let (mut worst, mut last) = (Worst::new(), None);
    for wanted in case["states"].as_array().into_iter().flatten() {
        let lateral = numbers(&wanted["lateral"]);
        let load = Load::MeanPressure(get(&wanted["mean_pressure"]));
        let drive = Drive { load, lateral: [lateral[0], lateral[1]], time: 0.0, distance: 0.0 };
        let state = contact.press(drive).tolerance(1e-10).starting_from(last.as_ref()).solve()?;
        let (pressure, shear) = (numbers(&wanted["pressure"]), numbers(&wanted["shear"]));
        let peak = pressure.iter().copied().fold(0.0, f64::max);
        state.pressure().iter().zip(&pressure).for_each(|(found, exact)| worst.compare_to(*found, *exact, peak));
        let lateral = (0..2).filter_map(|axis| state.shear(axis)).flat_map(|shear| shear.into_iter().copied());
        let found: Vec<f64> = lateral.collect();
        worst.compare(found.len() as f64, shear.len() as f64);
        found.iter().zip(&shear).for_each(|(found, exact)| worst.compare_to(*found, *exact, peak));
        worst.compare(state.approach(), get(&wanted["approach"]));
        worst.compare(state.summary().area_fraction * pressure.len() as f64, get(&wanted["contact_nodes"]));
        worst.compare(
            state.stick_fraction().unwrap_or(f64::NAN) * pressure.len() as f64,
            get(&wanted["sticking_nodes"]),
        );
        last = Some(state);
    }
    Ok(worst.check(format!("{name}: pressure and shear of all increments"), source, 1e-8))
}

/// Checks the ratio of tangential to normal stiffness of a rough contact against the ratio of a circle. The points in
/// contact stick, and the pressure does not change.
fn tangential_stiffness() -> Result<Check, ValidationError> {
    let mut worst = Worst::new();
    for poisson in [0.0, 0.3, 0.5] {
        worst.compare(stiffness_ratio(poisson)?, 2.0 * (1.0 - poisson) / (2.0 - poisson));
    }
    let name =
        "rough contact, 128² points, p* = 0.02, ν = 0, 0.3, 0.5: tangential over normal stiffness, mean over x and y";
    Ok(worst.check(name, "Mindlin 1949: 2(1 − ν)/(2 − ν)", 0.02))
}

fn stiffness_ratio(poisson: f64) -> Result<f64, ValidationError> {
    let grid = Grid::square(128, 1.0)?;
    let rough = SelfAffine {
        hurst: 0.8,
        longest_wavelength: 0.5,
        shortest_wavelength: 1.0 / 16.0,
        ..SelfAffine::with_rms_gradient(0.1)
    };
    let heights = rough.heights(&grid, 1)?;
    let body = Body::half_space(Material::from_contact_modulus(1.0, poisson)?);
    let contact = Contact::new(&body, &grid, &heights)?;
    let solution = contact.press(Load::MeanPressure(0.02 * contact.reduced_pressure_unit())).solve()?;
    let normal = contact.stiffness(&solution, 1e-9).map_or(f64::NAN, |stiffness| stiffness.value);
    let response = Arc::new(FullResponse::new(grid, &body));
    let mut sum = 0.0;
    for axis in 0..2 {
        let touching = |(_, i, j): (usize, usize, usize)| solution.pressure[[i, j]] > 0.0;
        let held = Array3::from_shape_fn((3, 128, 128), |at| at.0 < 2 && touching(at));
        let unit = Array3::from_shape_fn((3, 128, 128), |at| f64::from(u8::from(at.0 == axis && touching(at))));
        let problem = MixedProblem::with_response(Arc::clone(&response), Prescribed::new(held.view(), unit.view())?)?;
        sum += problem.solve(Method::default(), &Budget::default(), &mut ())?.mean_traction()[axis];
    }
    Ok(0.5 * sum / normal)
}
