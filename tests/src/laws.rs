//! Laws point by point, and adhesive and frictional contacts with a closed form.

use std::f64::consts::{PI, TAU};

use gfmd_contact::{Boundary, Drive, Equilibrium, Fields, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Interface, State};
use gfmd_law::{Dugdale, Exponential, Friction, Law, LawKind, Limit, Rate};
use gfmd_measure::theory::{AdhesiveSphere, Westergaard};
use ndarray::Array2;

use crate::check::{Worst, order};
use crate::friction::rubbing;
use crate::{Check, Reference, ValidationError, unit_half_space};

/// Wave of [`ripple`].
const WAVE: Westergaard = Westergaard { modulus: 1.0, amplitude: 0.01, period: 1.0 };

/// Sphere of [`sphere`], for any work of adhesion.
const SPHERE: AdhesiveSphere = AdhesiveSphere { modulus: 1.0, curvature_radius: 1.0, work: f64::NAN };

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

/// Compares to 1e-12 of the value, or to 1e-13 where it is small: the terms of the reference cancel there.
fn near(worst: &mut Worst, found: f64, wanted: f64) {
    worst.compare_to(found, wanted, wanted.abs().max(0.1));
}

fn cohesive(reference: &Reference) -> Result<Check, ValidationError> {
    let mut worst = Worst::new();
    for row in reference.table("cohesive_laws.json")? {
        let kind: LawKind = row.name.parse()?;
        let given: Vec<_> =
            kind.parameters().iter().map(|parameter| (parameter.name, row.get(parameter.name))).collect();
        let law = kind.with(&given)?;
        let (opening, sliding) = (row.get("Dn"), row.get("Dt"));
        let response = law.response(opening, sliding);
        let found = response.traction.iter().chain(response.jacobian.as_flattened());
        for (found, column) in found.zip(["Tn", "Tt", "Jnn", "Jnt", "Jtn", "Jtt"]) {
            near(&mut worst, *found, row.get(column));
        }
        // A law without a potential has no energy, here and in the reference. The reference counts energy from the
        // closed interface, a law from infinite distance, where it is φ_n higher.
        match law.energy(opening, sliding) {
            Some(energy) => near(&mut worst, energy, row.get("potential") - row.get("phi_n")),
            None => near(&mut worst, f64::from(row.get("potential").is_finite()), 0.0),
        }
    }
    Ok(worst.check("five cohesive laws: tractions, Jacobians, energies", CLOSED_FORMS, 1e-12))
}

fn adhesive(reference: &Reference) -> Result<Check, ValidationError> {
    let mut worst = Worst::new();
    for row in reference.table("normal_potentials.json")? {
        let kind: LawKind = row.name.parse()?;
        let values = ["gamma", "parameter (rho or curvature)"].map(|column| row.get(column));
        let given: Vec<_> = kind.parameters().iter().map(|parameter| parameter.name).zip(values).collect();
        let law = kind.with(&given)?;
        let response = law.response(row.get("g"), 0.0);
        near(&mut worst, law.opening_energy(row.get("g")), row.get("V"));
        near(&mut worst, law.energy(row.get("g"), 0.0).unwrap_or(f64::NAN), row.get("V"));
        near(&mut worst, response.traction[0], row.get("T"));
        near(&mut worst, response.jacobian[0][0], row.get("Tp"));
    }
    Ok(worst.check("three adhesive laws: energies, tractions, slopes", CLOSED_FORMS, 1e-12))
}

fn friction(reference: &Reference) -> Result<Check, ValidationError> {
    // A direction off the axes.
    const ALONG: [f64; 2] = [0.6, -0.8];
    let mut worst = Worst::new();
    for row in reference.table("friction_laws.json")? {
        let [slip, foot, stiffness, coefficient, pressure] = ["s", "sp", "kt", "mu", "p"].map(|column| row.get(column));
        for (limit, columns) in [
            (Limit::Coulomb(coefficient), ["tau_coulomb", "sp_new", "stick"]),
            (Limit::Tresca(0.5), ["tau_tresca", "sp_new_tresca", "stick_tresca"]),
        ] {
            let step =
                Friction::new(limit, stiffness)?.slide(ALONG.map(|c| c * slip), ALONG.map(|c| c * foot), pressure);
            let along = |vector: [f64; 2]| ALONG[0] * vector[0] + ALONG[1] * vector[1];
            let found = [along(step.traction), along(step.foot), f64::from(step.sticks)];
            found.iter().zip(columns).for_each(|(found, column)| near(&mut worst, *found, row.get(column)));
        }
        let limit = coefficient * pressure;
        let smooth = [Rate::Arctangent { velocity: 0.01 }, Rate::Root { velocity: 0.01 }];
        for (rate, column) in smooth.into_iter().zip(["tau_atan", "tau_sqrt"]) {
            near(&mut worst, rate.traction(limit, [slip, 0.0])[0], row.get(column));
            near(&mut worst, rate.traction(limit, [0.0, slip])[1], row.get(column));
        }
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
    let work = 5e-5;
    let errors = [(512, 1.2e-3), (1024, 6e-4), (2048, 3e-4)].map(|(n, range)| -> Result<_, ValidationError> {
        let law = Exponential::new(work, range)?;
        let interface = Interface::new(&unit_half_space(), &Grid::line(n, 1.0)?, &ripple(n), law)?;
        let pressed = rest(&interface, 0.004, None)?;
        let mut worst = 0.0_f64;
        for approach in [0.002, 0.0, -0.002] {
            let state = rest(&interface, approach, Some(&pressed))?;
            let exact = WAVE.adhesive_pressure(work, state.contact_fraction);
            worst = worst.max((state.mean_pressure - exact).abs());
        }
        Ok((n, [worst]))
    });
    let errors = errors.into_iter().collect::<Result<Vec<_>, _>>()?;
    let [falls] = order(&errors);
    Ok(Check::at_least(
        "adhesive wave: order of the pressure in the range, spacing ∝ range",
        "Johnson 1995",
        falls,
        1.2,
    ))
}

/// Returns the pull-off load of a sphere along a path of approaches.
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
    let sphere = AdhesiveSphere { work: 2.17e-4, ..SPHERE };
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
        Check::at_least(format!("{name}, order"), "Maugis 1992", falls, 0.8),
    ])
}

fn jkr_sphere() -> Result<Check, ValidationError> {
    let sphere = AdhesiveSphere { work: 4e-4, ..SPHERE };
    let found = pull_off(256, Exponential::new(sphere.work, 1.6e-3)?)?;
    let error = (found / sphere.jkr_pull_off() - 1.0).abs();
    Ok(Check::error("sphere of short range: pull-off load, 256² points", "Johnson, Kendall, Roberts 1971", error, 0.03))
}

fn incompressible() -> Result<Body, ValidationError> {
    Ok(Body::half_space(Material::from_contact_modulus(1.0, 0.5)?))
}

fn sheared_wave() -> Result<Check, ValidationError> {
    let contact =
        rubbing(Boundary::Periodic, &incompressible()?, &Grid::line(256, 1.0)?, &ripple(256), Limit::Coulomb(0.4))?;
    let solve = |load: f64, x: f64, start| {
        let drive = Drive { load: Load::MeanPressure(load), lateral: [x, 0.0], time: 0.0, distance: 0.0 };
        contact.press(drive).tolerance(1e-11).starting_from(start).solve()
    };
    let load = 0.3 * PI * 0.01;
    let rest = solve(load, 0.0, None)?;
    let sheared = solve(load, 1e-3, Some(&rest))?;
    let core = solve(load - sheared.mean_shear[0] / 0.4, 0.0, None)?;
    let mut worst = Worst::new();
    let pressures = &rest.pressure() - &core.pressure();
    for (shear, pressure) in sheared.shear(0).iter().flatten().zip(&pressures) {
        worst.compare_to(*shear, 0.4 * pressure, 0.4 * load);
    }
    Ok(worst.check("wave under shear, plane strain, ν = ½: shear at every point", "Ciavarella 1998, Jäger 1998", 1e-6))
}

fn sheared_sphere() -> Result<Check, ValidationError> {
    let (n, a, coefficient) = (128, 0.15_f64, 0.3);
    let limit = Limit::Coulomb(coefficient);
    let contact = rubbing(Boundary::Periodic, &incompressible()?, &Grid::square(n, 1.0)?, &sphere(n), limit)?;
    let load = 4.0 / 3.0 * a.powi(3);
    let solve = |x: f64, start| {
        let drive = Drive { load: Load::MeanPressure(load), lateral: [x, 0.0], time: 0.0, distance: 0.0 };
        contact.press(drive).starting_from(start).solve()
    };
    let rest = solve(0.0, None)?;
    let mut worst = Worst::new();
    for lateral in [2e-3, 3e-3, 4e-3] {
        let state = solve(lateral, Some(&rest))?;
        let exact = a * (1.0 - state.mean_shear[0] / (coefficient * load)).cbrt();
        worst.compare_to((state.stick_fraction().unwrap_or(f64::NAN) / PI).sqrt(), exact, a);
    }
    let name = "sphere under shear, ν = ½: stick radius over a, 128² points";
    Ok(worst.check(name, "Cattaneo 1938, Mindlin 1949: slip taken along x", 0.01))
}
