use std::sync::Arc;

use gfmd_contact::{Effort, Load, RigidSurface};
use gfmd_vector::{add, dot, reduce};
use ndarray::{Array2, Array3};

use super::FITS;
use super::increment::Increment;
use super::state::{FrictionResidual, FrictionState};
use crate::numbers::{higher_each, mean};

/// Computes the state of an increment from new transforms of its tractions.
pub(super) fn certify(increment: &mut Increment) -> FrictionState {
    let lateral = increment.lateral();
    let traction = increment.traction(&increment.shear[..lateral]);
    let mut displacement = vec![0.0; traction.len()];
    increment.transforms.compliance(&traction, &mut displacement);
    let [lowest, highest] = reduce(
        traction.len() - lateral,
        &|range| {
            range.fold([f64::NEG_INFINITY; 2], |worst, i| {
                let u = displacement[lateral + i];
                higher_each(worst, [-u, u])
            })
        },
        &higher_each,
    );
    let coarsest = increment.contact.surface.length_scale(increment.drive.load);
    let length_scale = RigidSurface::finer_scale(coarsest, highest + lowest);
    increment.length_scale = length_scale;
    let Increment { contact, drive, stuck, pressure, limits_before, .. } = &*increment;
    let n = pressure.len();
    let clearance = contact.surface.clearance();
    let components = lateral / n;
    let uz = &displacement[lateral..];

    let mean_pressure = mean(pressure);
    let [touching, distance] = reduce(
        n,
        &|range| range.filter(|i| pressure[*i] > 0.0).fold([0.0; 2], |sums, i| add(sums, [1.0, clearance[i] - uz[i]])),
        &add,
    );
    let (approach, load) = match drive.load {
        Load::MeanPressure(asked) => (distance / touching, (mean_pressure - asked).abs() / asked),
        Load::Approach(approach) => (approach, 0.0),
    };
    let gap: Vec<f64> = clearance.iter().zip(uz).map(|(c, u)| c - u - approach).collect();
    let slip: Vec<f64> = displacement.iter().zip(stuck).map(|(u, stuck)| u - stuck).collect();

    let limits = increment.limits();
    let magnitude = |i: usize| (0..components).map(|c| traction[c * n + i].powi(2)).sum::<f64>().sqrt();
    let [sticking, dissipated, closed] = reduce(
        n,
        &|range| {
            range.fold([0.0; 3], |sums, i| {
                let sticks = limits.values[i] > 0.0 && magnitude(i) < limits.values[i] * (1.0 - 1e-9);
                // The shear is at its limit while a point slips, and the limit changes during the increment.
                let mean = 0.5 * (limits_before[i] + limits.values[i]) / limits.values[i];
                let work: f64 = (0..components).map(|c| -traction[c * n + i] * slip[c * n + i]).sum();
                let work = if limits.values[i] > 0.0 { mean * work } else { 0.0 };
                add(sums, [f64::from(sticks), work, pressure[i] * gap[i]])
            })
        },
        &add,
    );
    let [below, excess] = reduce(
        n,
        &|range| range.fold([0.0; 2], |worst, i| higher_each(worst, [-gap[i], magnitude(i) - limits.values[i]])),
        &higher_each,
    );
    let residual = FrictionResidual {
        complementarity: match drive.load {
            _ if mean_pressure > 0.0 => (closed / (mean_pressure * n as f64 * length_scale)).abs(),
            // An approach beyond first touch needs a pressure, however small.
            Load::Approach(approach) => f64::from(approach > 0.0),
            Load::MeanPressure(_) => 0.0,
        },
        penetration: below / length_scale,
        load,
        friction: limits.mismatch(&traction[..lateral], &slip),
        excess: if limits.strongest > 0.0 { excess / limits.strongest } else { 0.0 },
    };

    let mut mean_shear = [0.0; 2];
    mean_shear.iter_mut().zip(traction[..lateral].chunks_exact(n)).for_each(|(shear, field)| *shear = mean(field));
    let elastic_energy = 0.5 * dot(&traction, &displacement) / n as f64;
    let [nx, ny] = contact.response.grid().points();
    let vectors = |values: Vec<f64>| Array3::from_shape_vec((values.len() / n, nx, ny), values).expect(FITS);
    FrictionState {
        gap: Array2::from_shape_vec((nx, ny), gap).expect(FITS),
        slip: vectors(slip),
        displacement: vectors(displacement),
        traction: vectors(traction),
        mean_pressure,
        mean_shear,
        approach,
        lateral: drive.lateral,
        contact_fraction: touching / n as f64,
        stick_fraction: sticking / n as f64,
        elastic_energy,
        dissipated: dissipated / n as f64,
        residual,
        effort: Effort { iterations: 0, transform_pairs: increment.pairs() },
        surface: Arc::clone(&contact.given),
        contact_modulus: contact.contact_modulus,
    }
}
