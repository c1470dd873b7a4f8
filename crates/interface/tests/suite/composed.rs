//! Contacts made of several parts, against dense solutions for all unknowns at once
//! (`data/reference/composed_contacts.json`).

use std::collections::BTreeMap;

use gfmd_contact::{Boundary, Budget, Drive, Equilibrium as _, Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Parts, QuasistaticContact, QuasistaticState, Wear};
use gfmd_law::{Exponential, Law as _, Limit, Morse};
use gfmd_medium::{Prony, Relaxes};
use ndarray::Array2;
use serde_json::Value;

const N: usize = 16;

/// Largest difference of a number, relative to its largest magnitude along the path.
const TOLERANCE: f64 = 2e-7;

fn heights(kind: &str) -> Array2<f64> {
    let at = |i: usize| (i as f64 + 0.5) / N as f64;
    let turn = std::f64::consts::TAU;
    Array2::from_shape_fn((N, N), |(i, j)| {
        let (x, y) = (at(i), at(j));
        if kind == "waves" {
            0.02 * (turn * x + 0.3).cos() * (turn * y - 0.7).cos()
                + 0.008 * (turn * (2.0 * x + y) + 1.1).cos()
                + 0.004 * (turn * (x - 3.0 * y) + 2.0).cos()
        } else {
            -((x - 0.51).powi(2) + (y - 0.47).powi(2)) / 2.0
                + 0.004 * (turn * (2.0 * x + y) + 1.1).cos()
                + 0.002 * (turn * (3.0 * x - 2.0 * y)).cos()
        }
    })
}

/// Returns the contact of the parts of a case.
fn contact(case: &Value) -> Result<QuasistaticContact, String> {
    let number = |name: &str| case.get(name).and_then(Value::as_f64);
    let grid = Grid::square(N, 1.0).unwrap();
    let material = Material::from_contact_modulus(number("e_star").unwrap(), number("nu").unwrap()).unwrap();
    let (body, heights) = (Body::half_space(material), heights(case["surface"].as_str().unwrap()));
    let branches: Vec<(f64, f64)> = case.get("prony").and_then(Value::as_array).map_or_else(Vec::new, |branches| {
        branches.iter().map(|b| (b["time"].as_f64().unwrap(), b["weight"].as_f64().unwrap())).collect()
    });
    let all = 1.0 + branches.iter().map(|(_, weight)| weight).sum::<f64>();
    let fractions: Vec<(f64, f64)> = branches.iter().map(|(time, weight)| (*time, weight / all)).collect();
    let prony = (!fractions.is_empty()).then(|| Prony::from_fractions(&fractions).unwrap());
    let law = case.get("law").map(|law| {
        let [gamma, range] = ["gamma", "range"].map(|name| law[name].as_f64().unwrap());
        match law["kind"].as_str().unwrap() {
            "exponential" => Exponential::new(gamma, range).unwrap().into_shared(),
            _ => Morse::new(gamma, range).unwrap().into_shared(),
        }
    });
    let limit = match (number("friction"), number("tresca")) {
        (None, None) => None,
        (Some(coefficient), None) => Some(Limit::Coulomb(coefficient)),
        (None, Some(strength)) => Some(Limit::Tresca(strength)),
        (Some(coefficient), Some(strength)) => Some(Limit::Orowan { coefficient, strength }),
    };
    let wear = match (number("wear"), number("wear_by_slip")) {
        (None, None) => None,
        (by_distance, by_slip) => {
            Some(Wear { by_distance: by_distance.unwrap_or(0.0), by_slip: by_slip.unwrap_or(0.0) })
        }
    };
    let boundary = if case["boundary"] == "free" { Boundary::Free } else { Boundary::Periodic };
    let parts = Parts {
        boundary,
        law,
        hardness: number("hardness").map(Into::into),
        shear: limit.map(Into::into),
        relaxation: prony.as_ref().map(|prony| (prony, Relaxes::Both)),
        wear,
        ..Parts::new(&body, &grid, &heights)
    };
    QuasistaticContact::new(&parts).map_err(|refusal| refusal.to_string())
}

fn drive(given: &Value) -> Drive {
    let number = |value: &Value| value.as_f64().unwrap();
    let value = number(&given["load"][1]);
    let load = if given["load"][0] == "pressure" { Load::MeanPressure(value) } else { Load::Approach(value) };
    Drive {
        load,
        lateral: [number(&given["lateral"][0]), number(&given["lateral"][1])],
        time: number(&given["time"]),
        distance: number(&given["distance"]),
    }
}

/// Returns the numbers of a state under the names of the reference.
fn numbers(state: &QuasistaticState) -> BTreeMap<&'static str, f64> {
    let (pressure, repulsion) = (state.pressure(), state.repulsion());
    let largest = |field: &dyn Fn(usize) -> f64| (0..N * N).map(field).fold(f64::NEG_INFINITY, f64::max);
    let p: Vec<f64> = pressure.iter().copied().collect();
    let r: Vec<f64> = repulsion.iter().copied().collect();
    let shear = |axis: usize| state.shear(axis).map_or_else(|| vec![0.0; N * N], |t| t.iter().copied().collect());
    let (x, y): (Vec<f64>, Vec<f64>) = (shear(0), shear(1));
    let points = (N * N) as f64;
    BTreeMap::from([
        ("mean_pressure", state.mean_pressure()),
        ("approach", state.approach()),
        ("shear_x", state.mean_shear[0]),
        ("shear_y", state.mean_shear[1]),
        ("contact", r.iter().filter(|r| **r > 0.0).count() as f64),
        ("stick", state.stick_fraction().unwrap_or(0.0) * points),
        ("max_repulsion", largest(&|i| r[i])),
        ("max_pressure", largest(&|i| p[i])),
        ("min_pressure", -largest(&|i| -p[i])),
        ("max_shear", largest(&|i| x[i].hypot(y[i]))),
        ("elastic", state.elastic_energy()),
        ("interface", state.interface_energy()),
        ("wear_volume", state.wear_volume_and_depth().map_or(0.0, |(volume, _)| volume)),
        ("plastic_volume", state.plastic_volume().unwrap_or(0.0)),
        ("loss_visc", state.losses.relaxation),
        ("loss_friction_mean_limits", state.losses.friction),
        ("loss_wear", state.losses.wear),
        ("loss_plastic", state.losses.plastic),
    ])
}

/// Follows a case; returns the worst difference of a number, and the name of the number.
fn follow(case: &Value) -> Result<(f64, String), String> {
    let contact = contact(&case["parts"])?;
    let budget = Budget { tolerance: 1e-10, ..Budget::default() };
    let (mut states, mut found): (Vec<QuasistaticState>, Vec<BTreeMap<&str, f64>>) = Default::default();
    for (index, given) in case["drives"].as_array().unwrap().iter().enumerate() {
        let press = contact.press(drive(given)).budget(budget).starting_from(states.last());
        let state = press.solve().map_err(|error| format!("step {index}: {error}"))?;
        found.push(numbers(&state));
        states.push(state);
    }
    let steps = case["steps"].as_array().unwrap();
    assert_eq!(steps.len(), found.len());
    let mut worst = (0.0, String::new());
    for name in found[0].keys() {
        let known = |step: &Value| step[*name].as_f64().unwrap();
        // Pressures at a wall are positive up to rounding errors.
        let name_of_scale = if *name == "min_pressure" { "max_pressure" } else { name };
        let scale = steps.iter().map(|step| step[name_of_scale].as_f64().unwrap().abs()).fold(1e-300, f64::max);
        for (index, (step, found)) in steps.iter().zip(&found).enumerate() {
            let apart = (found[name] - known(step)).abs() / scale;
            let is_within = apart <= worst.0;
            if !is_within {
                worst = (apart, format!("{name} of step {index}: {} not {}", found[name], known(step)));
            }
        }
    }
    Ok(worst)
}

#[test]
fn every_combination_has_the_values_of_dense_solutions() {
    let text = include_str!("../../../../data/reference/composed_contacts.json");
    let all: Value = serde_json::from_str(text).unwrap();
    let only = std::env::var("GFMD_CASE").ok();
    let mut wrong = Vec::new();
    for (name, case) in all["cases"].as_object().unwrap() {
        if only.as_ref().is_some_and(|only| only != name) {
            continue;
        }
        match follow(case) {
            Ok((apart, _)) if apart <= TOLERANCE => {}
            Ok((apart, what)) => wrong.push(format!("{name}: {apart:.1e}, {what}")),
            Err(error) => wrong.push(format!("{name}: {error}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Returns the work of the rigid surface along a case divided into `parts` increments a drive, by the trapezoidal rule,
/// less the energies gained and lost, divided by the work.
fn missing(case: &Value, parts: u32) -> f64 {
    let contact = contact(&case["parts"]).unwrap();
    let budget = Budget { tolerance: 1e-9, ..Budget::default() };
    let rest = Drive::from(Load::MeanPressure(0.0));
    let value = |drive: &Drive| match drive.load {
        Load::MeanPressure(value) | Load::Approach(value) => value,
    };
    let (mut before, mut state): (Drive, Option<QuasistaticState>) = (rest, None);
    let (mut balance, mut exchanged) = (0.0, 0.0);
    for (leg, given) in case["drives"].as_array().unwrap().iter().enumerate() {
        let end = drive(given);
        // At first touch the approach is not a smooth function of the load.
        let parts = if leg == 0 { 1 } else { parts };
        for part in 1..=parts {
            let share = f64::from(part) / f64::from(parts);
            let at = |from: f64, to: f64| from + share * (to - from);
            let pressure = at(value(&before), value(&end));
            let next = Drive {
                load: Load::MeanPressure(pressure),
                lateral: [0, 1].map(|c| at(before.lateral[c], end.lateral[c])),
                time: at(before.time, end.time),
                distance: at(before.distance, end.distance),
            };
            let reached = contact.press(next).budget(budget).starting_from(state.as_ref()).solve().unwrap();
            let energy = |state: &QuasistaticState| state.elastic_energy() + state.interface_energy();
            let start = state.as_ref();
            let number = |of: &dyn Fn(&QuasistaticState) -> f64| start.map_or(0.0, of);
            let mut work = 0.5
                * (number(&|state| state.mean_pressure()) + reached.mean_pressure())
                * (reached.approach() - number(&|state| state.approach()));
            for c in 0..2 {
                work += 0.5
                    * (number(&|state| state.mean_shear[c]) + reached.mean_shear[c])
                    * (reached.lateral[c] - number(&|state| state.lateral[c]));
            }
            if leg > 0 {
                balance += work - (energy(&reached) - number(&energy)) - reached.losses.total();
                exchanged += work.abs();
            }
            state = Some(reached);
        }
        before = end;
    }
    balance.abs() / exchanged
}

#[test]
fn the_balance_of_energy_closes_as_increments_become_shorter() {
    let text = include_str!("../../../../data/reference/composed_contacts.json");
    let all: Value = serde_json::from_str(text).unwrap();
    // Largest relative error with eight increments a leg, and the factor by which it falls from one increment. Wear and
    // slip are of first order, and errors of either sign may cancel.
    for (name, most, factor) in [
        ("coulomb", 3e-4, 8.0),
        ("visco+coulomb", 1e-3, 8.0),
        ("hardness+coulomb", 2e-4, 4.0),
        ("fretting-wear+coulomb", 1e-3, 1.0),
        ("wear+visco", 5e-3, 6.0),
        ("wear+law", 8e-3, 5.0),
        ("hardness+law", 2e-4, 8.0),
    ] {
        let [coarse, fine] = [1, 8].map(|parts| missing(&all["cases"][name], parts));
        assert!(fine <= most && fine * factor <= coarse, "{name}: {coarse:e} {fine:e}");
    }
}
