//! Limits of the parts: a part without an effect gives the path without the part.

use std::path::Path;

use gfmd_files::Reader;

use super::super::draw::{Control, Law};
use super::super::found::Found;
use super::super::numbers::{gradient, largest};
use super::{Parts, Wear, program};

/// Pressures at all waypoints, as a field of each.
fn pressures(parts: &Parts, folder: &Path, name: &str, found: &mut Found) -> Option<Vec<Vec<f64>>> {
    let out = format!("{name}{}.h5", parts.index);
    let (status, _, reported) = program(folder, &parts.command(), &["-q", "--threads", "1", "--out", &out]);
    match status {
        Some(0) => {}
        Some(1) => {
            found.note(format!("limit of {name}: not converged"));
            return None;
        }
        // The other path may have bounds of its own: of the approach, the load, or the range of its law.
        Some(2)
            if ["full contact", "at most", "less than", "process zone"].iter().any(|word| reported.contains(word)) =>
        {
            found.note(format!("limit of {name}: refused"));
            return None;
        }
        _ => {
            found.complain(format!("limit of {name}: status {status:?} of {}: {reported}", parts.command().join(" ")));
            return None;
        }
    }
    let file = Reader::open(folder.join(&out)).unwrap();
    let count = file.shape("/fields/pressure").unwrap()[0];
    Some((0..count).map(|k| file.slab("/fields/pressure", k).unwrap()).collect())
}

/// Solves both paths and compares their pressures.
fn compare(name: &str, tolerance: f64, [a, b]: [&Parts; 2], folder: &Path, found: &mut Found) {
    let (Some(p), Some(q)) = (pressures(a, folder, name, found), pressures(b, folder, &format!("no {name}"), found))
    else {
        return;
    };
    found.note(format!("limit of {name}: compared"));
    found.must(p.len() == q.len(), || format!("limit of {name}: {} and {} waypoints", p.len(), q.len()));
    // Surfaces that part have rounding errors alone.
    let most = p.iter().chain(&q).map(|field| largest(field)).fold(0.0, f64::max);
    for (k, (p, q)) in p.iter().zip(&q).enumerate() {
        let apart = p.iter().zip(q).map(|(p, q)| (p - q).abs()).fold(0.0, f64::max);
        if apart > tolerance * most {
            found.complain(format!(
                "limit of {name}, waypoint {k}: {apart:e} of {most:e}\n        gfmd {}\n        gfmd {}",
                a.command().join(" "),
                b.command().join(" ")
            ));
            return;
        }
        found.compared += 1;
    }
}

/// Compares all limits that a path has.
pub(super) fn check(parts: &Parts, folder: &Path, found: &mut Found) {
    let mut fine = Parts { steps: 1, energy_solves: Some(0), tolerance: 1e-8, ..parts.clone() };
    // The other lists may be left out.
    let lists = [&fine.loads, &fine.lateral, &fine.lateral_y, &fine.times, &fine.distances];
    let count = lists.iter().map(|list| list.len()).max().unwrap_or(1);
    if let [only] = fine.loads[..] {
        fine.loads = vec![only; count];
    }
    if fine.rubs() && fine.wear.as_ref().is_none_or(|wear| !wear.by_slip) {
        let without = Parts {
            friction: None,
            shear_strength: None,
            of_net: false,
            lateral: Vec::new(),
            lateral_y: Vec::new(),
            direction: 0.0,
            ..fine.clone()
        };
        let with = Parts { friction: Some(0.0), shear_strength: None, ..fine.clone() };
        // An even number of points has a shortest wave, whose stiffness differs between one component and all.
        let is_odd = fine.plane.n.iter().all(|n| n % 2 == 1);
        if fine.is_free || fine.is_uncoupled() || is_odd {
            compare("friction", 1e-6, [&with, &without], folder, found);
        }
    }
    if fine.hardness.is_some() {
        let without = Parts { hardness: None, ..fine.clone() };
        let most = 1e6 * fine.body.contact_modulus();
        let with =
            Parts { hardness: Some(vec![most; fine.plane.len()]), hardness_text: format!("{most}"), ..fine.clone() };
        compare("hardness", 1e-6, [&with, &without], folder, found);
    }
    if let Some(wear) = &fine.wear {
        let without = Parts { wear: None, distances: Vec::new(), ..fine.clone() };
        let tiny = Wear { coefficient: 1e-12 * wear.coefficient, ..wear.clone() };
        compare("wear", 1e-6, [&Parts { wear: Some(tiny), ..fine.clone() }, &without], folder, found);
    }
    if let Some(yielding) = &fine.yielding {
        // Only a body that yields takes a load of zero.
        let loads = fine.loads.iter().filter(|load| **load > 0.0).map(|load| 0.01 * load).collect();
        let small = Parts { loads, ..fine.clone() };
        let with = Parts { yielding: Some(yielding.hard(&fine.body)), ..small.clone() };
        compare("yield stress", 1e-6, [&with, &Parts { yielding: None, ..small }], folder, found);
    }
    if let Some(relaxation) = &fine.relaxation {
        let at_once = super::Relaxation { instantaneous: true, ..relaxation.clone() };
        let mut with = Parts { relaxation: Some(at_once), times: vec![0.0; fine.times.len()], ..fine.clone() };
        if with.control == Control::PStar {
            // The reduced pressure refers to the long-term modulus.
            let unit = with.body.contact_modulus() * gradient(with.plane, &with.heights, with.is_free);
            with.loads.iter_mut().for_each(|load| *load *= unit);
            with.control = Control::Pressure;
        }
        let without = Parts { relaxation: None, times: Vec::new(), ..with.clone() };
        compare("relaxation", 1e-6, [&with, &without], folder, found);
    }
    if let Some(law) = fine.law.as_ref().filter(|law| law.has_wall()) {
        let weak = 1e-9;
        let law = match law.clone() {
            Law::Exponential { gamma, range } => Law::Exponential { gamma: weak * gamma, range },
            Law::Dugdale { gamma, range } => Law::Dugdale { gamma: weak * gamma, range },
            Law::Table { first, step, tractions } => Law::Table { first, step, tractions: tractions.map(|t| weak * t) },
            law => law,
        };
        // Surfaces that part have no pressure to compare.
        if fine.loads.iter().all(|load| *load > 0.0) {
            let without = Parts { law: None, of_net: false, ..fine.clone() };
            compare("law", 1e-5, [&Parts { law: Some(law), of_net: false, ..fine.clone() }, &without], folder, found);
        }
    }
}
