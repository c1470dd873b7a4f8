//! Laws point by point, and adhesive and frictional contacts with a closed form.

use std::f64::consts::{PI, TAU};

use gfmd_contact::{Drive, Equilibrium, Fields, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{FrictionalContact, Interface, State};
use gfmd_law::{Dugdale, Exponential, Friction, Kind, Law, Limit, Rate};
use gfmd_measure::theory::{AdhesiveSphere, Westergaard};
use ndarray::{Array2, Axis};
use serde_json::Value;

use crate::check::{Worst, order};
use crate::{Check, Reference, ValidationError, unit_half_space};

const CLOSED_FORMS: &str = "closed forms, evaluated in Python";

pub(crate) fn checks(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let mut checks = vec![cohesive(reference)?, adhesive(reference)?, friction(reference)?];
    checks.push(wave()?);
    checks.extend(maugis_sphere()?);
    checks.push(jkr_sphere()?);
    checks.push(sheared_wave()?);
    checks.push(sheared_sphere()?);
    Ok(checks)
}

/// The rows of a table of laws: a name, or nothing, and numbers.
fn rows(reference: &Reference, file: &str) -> Result<Vec<(String, Vec<f64>)>, ValidationError> {
    let json = reference.json(file)?;
    let row = |row: &Value| -> Option<(String, Vec<f64>)> {
        let row = row.as_array()?;
        let name = row[0].as_str().unwrap_or_default().to_owned();
        // Yes and no count as one and zero.
        let number = |value: &Value| value.as_f64().or(value.as_bool().map(f64::from)).unwrap_or(f64::NAN);
        Some((name, row.iter().map(number).collect()))
    };
    let refused = || ValidationError::Reference { file: file.into(), reason: "no rows".into() };
    json["rows"].as_array().ok_or_else(refused)?.iter().map(|r| row(r).ok_or_else(refused)).collect()
}

fn cohesive(reference: &Reference) -> Result<Check, ValidationError> {
    let mut worst = Worst::new();
    for (name, row) in rows(reference, "cohesive_laws.json")? {
        let kind = match name.as_str() {
            "XN" => Kind::XuNeedleman,
            "BSG" => Kind::BoschSchreursGeers,
            "C3D" => Kind::CoupledExponential,
            "NPB" => Kind::Npb,
            _ => Kind::Npc,
        };
        let mut given = vec![("phi_n", row[3]), ("phi_t", row[4]), ("delta_n", row[5]), ("delta_t", row[6])];
        given.extend((kind == Kind::XuNeedleman).then_some(("r", row[8])));
        let law = kind.with(&given)?;
        let response = law.response(row[1], row[2]);
        let [strength, stiffness] = [row[3] / row[5], row[3] / row[5].powi(2)];
        response.traction.iter().zip(&row[9..]).for_each(|(t, wanted)| worst.compare_to(*t, *wanted, strength));
        let jacobian = response.jacobian.as_flattened().iter().zip(&row[11..]);
        jacobian.for_each(|(j, wanted)| worst.compare_to(*j, *wanted, stiffness));
        if row[15].is_finite() {
            worst.compare_to(law.energy(row[1], row[2]).unwrap_or(f64::NAN), row[15], row[3]);
        }
    }
    Ok(worst.check("five cohesive laws: tractions, Jacobians, energies", CLOSED_FORMS, 1e-12))
}

fn adhesive(reference: &Reference) -> Result<Check, ValidationError> {
    let mut worst = Worst::new();
    for (name, row) in rows(reference, "normal_potentials.json")? {
        let (kind, parameter) = match name.as_str() {
            "morse" => (Kind::Morse, "range"),
            "exp_adhesion" => (Kind::Exponential, "range"),
            _ => (Kind::HarmonicCosine, "curvature"),
        };
        let law = kind.with(&[("gamma", row[2]), (parameter, row[3])])?;
        let response = law.response(row[1], 0.0);
        worst.compare_to(law.opening_energy(row[1]), row[4], row[2]);
        worst.compare_to(response.traction[0], row[5], row[2]);
        worst.compare_to(response.jacobian[0][0], row[6], law.stiffness_bound(row[1]));
    }
    Ok(worst.check("three adhesive laws: energies, tractions, slopes", CLOSED_FORMS, 1e-12))
}

fn friction(reference: &Reference) -> Result<Check, ValidationError> {
    let mut worst = Worst::new();
    for (_, row) in rows(reference, "friction_laws.json")? {
        let [slip, foot, stiffness, coefficient, pressure] = [0, 1, 2, 3, 4].map(|k| row[k]);
        for (limit, column) in [(Limit::Coulomb(coefficient), 5), (Limit::Tresca(0.5), 8)] {
            let step = Friction::new(limit, stiffness)?.slide([slip, 0.0], [foot, 0.0], pressure);
            let found = [step.traction[0], step.foot[0], f64::from(step.sticks)];
            found.iter().zip(&row[column..]).for_each(|(found, wanted)| worst.compare_to(*found, *wanted, 1.0));
        }
        let limit = coefficient * pressure;
        worst.compare_to(Rate::Arctangent { velocity: 0.01 }.traction(limit, [slip, 0.0])[0], row[11], 1.0);
        worst.compare_to(Rate::Root { velocity: 0.01 }.traction(limit, [slip, 0.0])[0], row[12], 1.0);
    }
    Ok(worst.check("Coulomb and Tresca: return map, smoothed over a velocity", CLOSED_FORMS, 1e-12))
}

fn rest(interface: &Interface, approach: f64, start: Option<&State>) -> Result<State, ValidationError> {
    Ok(interface.press(Load::Approach(approach)).starting_from(start).solve()?)
}

fn ripple(n: usize) -> Array2<f64> {
    Array2::from_shape_fn((n, 1), |(i, _)| 0.01 * (TAU * i as f64 / n as f64).cos())
}

fn sphere(n: usize) -> Array2<f64> {
    let at = |i: usize| (i as f64 / n as f64 - 0.5).powi(2);
    Array2::from_shape_fn((n, n), |(i, j)| -0.5 * (at(i) + at(j)))
}

fn wave() -> Result<Check, ValidationError> {
    let (work, closed_form) = (5e-5, Westergaard { modulus: 1.0, amplitude: 0.01, period: 1.0 });
    let errors = [(512, 1.2e-3), (1024, 6e-4), (2048, 3e-4)].map(|(n, range)| -> Result<_, ValidationError> {
        let law = Exponential::new(work, range)?;
        let interface = Interface::new(&unit_half_space(), &Grid::line(n, 1.0)?, &ripple(n), law)?;
        let pressed = rest(&interface, 0.004, None)?;
        let mut worst = 0.0_f64;
        for approach in [0.002, 0.0, -0.002] {
            let state = rest(&interface, approach, Some(&pressed))?;
            let exact = closed_form.adhesive_pressure(work, state.contact_fraction);
            worst = worst.max((state.mean_pressure - exact).abs());
        }
        Ok((n, [worst]))
    });
    let errors = errors.into_iter().collect::<Result<Vec<_>, _>>()?;
    let [falls] = order(&errors);
    Ok(Check::order("adhesive wave: order of the pressure in the range, spacing ∝ range", "Johnson 1995", falls, 1.2))
}

/// The pull-off load of a sphere along a path of approaches.
fn pull_off(n: usize, law: impl Law + 'static) -> Result<f64, ValidationError> {
    let interface = Interface::new(&unit_half_space(), &Grid::square(n, 1.0)?, &sphere(n), law)?;
    let (mut last, mut lowest) = (rest(&interface, 0.002, None)?, f64::INFINITY);
    for step in 0..14 {
        last = rest(&interface, 0.001 - 0.0005 * f64::from(step), Some(&last))?;
        lowest = lowest.min(last.mean_pressure);
    }
    Ok(lowest)
}

fn maugis_sphere() -> Result<[Check; 2], ValidationError> {
    let sphere = AdhesiveSphere { modulus: 1.0, curvature_radius: 1.0, work: 2.17e-4 };
    let law = Dugdale::new(sphere.work, sphere.work / sphere.strength(1.0))?;
    let exact = sphere.maugis_pull_off(1.0);
    let mut errors = Vec::new();
    for n in [64, 128, 256] {
        errors.push((n, [(pull_off(n, law)? / exact - 1.0).abs()]));
    }
    let [falls] = order(&errors);
    let last = errors[2].1[0];
    let name = "sphere with a Dugdale zone: pull-off load";
    Ok([
        Check::error(format!("{name}, 256² points"), "Maugis 1992", last, 0.05),
        Check::order(format!("{name}, order"), "Maugis 1992", falls, 0.8),
    ])
}

fn jkr_sphere() -> Result<Check, ValidationError> {
    let sphere = AdhesiveSphere { modulus: 1.0, curvature_radius: 1.0, work: 4e-4 };
    let found = pull_off(256, Exponential::new(sphere.work, 1.6e-3)?)?;
    let error = (found / sphere.jkr_pull_off() - 1.0).abs();
    Ok(Check::error("sphere of short range: pull-off load, 256² points", "Johnson, Kendall, Roberts 1971", error, 0.03))
}

fn incompressible() -> Result<Body, ValidationError> {
    Ok(Body::half_space(Material::from_contact_modulus(1.0, 0.5)?))
}

fn sheared_wave() -> Result<Check, ValidationError> {
    let contact =
        FrictionalContact::new(&incompressible()?, &Grid::line(256, 1.0)?, &ripple(256), Limit::Coulomb(0.4))?;
    let solve = |load: f64, x: f64, start| {
        let drive = Drive { load: Load::MeanPressure(load), lateral: [x, 0.0] };
        contact.press(drive).tolerance(1e-11).starting_from(start).solve()
    };
    let load = 0.3 * PI * 0.01;
    let rest = solve(load, 0.0, None)?;
    let sheared = solve(load, 1e-3, Some(&rest))?;
    let core = solve(load - sheared.mean_shear[0] / 0.4, 0.0, None)?;
    let mut worst = Worst::new();
    let pressures = &rest.pressure() - &core.pressure();
    for (shear, pressure) in sheared.traction.index_axis(Axis(0), 0).iter().zip(&pressures) {
        worst.compare_to(*shear, 0.4 * pressure, 0.4 * load);
    }
    Ok(worst.check("wave under shear, plane strain, ν = ½: shear at every point", "Ciavarella 1998, Jäger 1998", 1e-6))
}

fn sheared_sphere() -> Result<Check, ValidationError> {
    let (n, a, coefficient) = (128, 0.15_f64, 0.3);
    let limit = Limit::Coulomb(coefficient);
    let contact = FrictionalContact::new(&incompressible()?, &Grid::square(n, 1.0)?, &sphere(n), limit)?;
    let load = 4.0 / 3.0 * a.powi(3);
    let solve = |x: f64, start| {
        let drive = Drive { load: Load::MeanPressure(load), lateral: [x, 0.0] };
        contact.press(drive).starting_from(start).solve()
    };
    let rest = solve(0.0, None)?;
    let mut worst = Worst::new();
    for lateral in [2e-3, 3e-3, 4e-3] {
        let state = solve(lateral, Some(&rest))?;
        let exact = a * (1.0 - state.mean_shear[0] / (coefficient * load)).cbrt();
        worst.compare_to((state.stick_fraction / PI).sqrt(), exact, a);
    }
    let name = "sphere under shear, ν = ½: stick radius over a, 128² points";
    Ok(worst.check(name, "Cattaneo 1938, Mindlin 1949: slip taken along x", 0.01))
}
