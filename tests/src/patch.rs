//! Contacts on a patch that does not repeat, with friction, on slabs, or with a law: dense solutions of small problems.

use gfmd_contact::{Boundary, Contact, Equilibrium, Fields, Load, Solver};
use gfmd_green::{BaseKind, Body, Material};
use gfmd_interface::Interface;
use gfmd_law::{LawKind, Limit};
use serde_json::Value;

use crate::bounded::{compare, numbers, surface};
use crate::check::Worst;
use crate::friction::{self, follow};
use crate::{Check, Reference, ValidationError};

const DENSE: &str = "dense Newton solutions, chord integrals of kernels";

pub(crate) fn checks(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let file = reference.json("free_contacts.json")?;
    let cases = |name: &str| file[name].as_array().into_iter().flatten();
    let mut checks = Vec::new();
    for case in cases("friction") {
        let (grid, heights) = surface(case)?;
        let limit = Limit::Coulomb(number(&case["coefficient"]));
        let contact = friction::rubbing(Boundary::Free, &friction::body(case)?, &grid, &heights, limit)?;
        let name = format!("friction on a patch, {}", case["name"].as_str().unwrap_or_default());
        checks.push(follow(&contact, case, name, DENSE)?);
    }
    for case in cases("slabs") {
        let (grid, heights) = surface(case)?;
        let contact = Contact::with_boundary(Boundary::Free, &body(case)?, &grid, &heights)?;
        let solvers = [Solver::PreconditionedCg, Solver::ProjectedCg];
        checks.push(compare(&contact, case, &solvers, &format!("patch on a slab, {}", words(case)), DENSE)?);
    }
    for case in cases("laws") {
        checks.push(law(case)?);
    }
    Ok(checks)
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn words(case: &Value) -> String {
    let [poisson, height] = ["poisson", "height"].map(|key| case[key].as_f64());
    match height {
        Some(height) => {
            let base = case["base"].as_str().unwrap_or_default();
            format!("nu {}, height {height}, {base}", poisson.unwrap_or(f64::NAN))
        }
        None => "half-space".into(),
    }
}

fn body(case: &Value) -> Result<Body, ValidationError> {
    let material = Material::from_contact_modulus(1.0, number(&case["poisson"]))?;
    let base = case["base"].as_str().and_then(|name| name.parse::<BaseKind>().ok()).unwrap_or_default();
    Ok(match case["height"].as_f64() {
        Some(height) => Body::slab(material, height)?.on(base.with(None)?)?,
        None => Body::half_space(material),
    })
}

/// Checks a contact with a law, by load or by approach.
fn law(case: &Value) -> Result<Check, ValidationError> {
    let (grid, heights) = surface(case)?;
    let name = case["law"].as_str().unwrap_or_default();
    let kind: LawKind = name.parse().map_err(|_| ValidationError::Reference {
        file: "free_contacts.json".into(),
        reason: format!("it has a law {name:?}; it must be one of gfmd"),
    })?;
    let law = kind.with(&["gamma", "range"].map(|key| (key, number(&case[key]))))?;
    let interface = Interface::with_boundary(Boundary::Free, &body(case)?, &grid, &heights, law)?;
    let [mean, approach] = ["mean_pressure", "approach"].map(|key| number(&case[key]));
    let is_approach = case["control"].as_str() == Some("approach");
    let load = if is_approach { Load::Approach(approach) } else { Load::MeanPressure(mean) };
    let state = interface.press(load).tolerance(1e-11).solve()?;
    let (pressure, gap) = (numbers(&case["pressure"]), numbers(&case["gap"]));
    let largest = |values: &[f64]| values.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let mut worst = Worst::new();
    for (found, exact) in state.pressure().iter().zip(&pressure) {
        worst.compare_to(*found, *exact, largest(&pressure));
    }
    for (found, exact) in state.gap().iter().zip(&gap) {
        worst.compare_to(*found, *exact, largest(&gap));
    }
    worst.compare(state.mean_pressure, mean);
    worst.compare(state.approach, approach);
    worst.compare(state.interface_energy, number(&case["interface_energy"]));
    worst.compare(state.elastic_energy, number(&case["elastic_energy"]));
    let control = if is_approach { "to" } else { "by" };
    Ok(worst.check(format!("{name} on a patch, {}, {control} {load:?}", words(case)), DENSE, 1e-8))
}
