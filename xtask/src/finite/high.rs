//! Pressure distribution: fractions of a surface with high pressure.

use gfmd_contact::{Contact, Equilibrium as _, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_input::failure::Failure;
use gfmd_surface::{Discretisation, SelfAffine};

use super::{EPS_T_INV, REDUCED, RMS_GRADIENT};

/// Pressures divided by E* ḡ.
pub const PRESSURES: [f64; 5] = [0.25, 0.5, 0.75, 1.0, 1.5];

/// Fractions of a surface above each of the pressures, divided by p/(E* ḡ).
pub(super) type Parts = [f64; PRESSURES.len()];

/// Computes the fractions of a surface for each reduced pressure.
pub(super) fn parts(hurst: f64, (eps_f_inv, points): (usize, usize), seed: u64) -> Result<Vec<Parts>, Failure> {
    let fail = |error: &dyn std::fmt::Display| Failure::computation(error.to_string());
    let grid = Grid::square(points * EPS_T_INV * eps_f_inv, 1.0).map_err(|error| fail(&error))?;
    let material = Material::from_contact_modulus(1.0, 0.0).map_err(|error| fail(&error))?;
    let numbers = Discretisation { eps_t_inv: EPS_T_INV as f64, eps_f_inv: eps_f_inv as f64, eps_c_inv: points as f64 };
    let spectrum = numbers.self_affine(1.0, SelfAffine { hurst, ..SelfAffine::with_rms_gradient(RMS_GRADIENT) });
    let heights = spectrum.heights(&grid, seed).map_err(|error| fail(&error))?;
    let contact = Contact::new(&Body::half_space(material), &grid, &heights).map_err(|error| fail(&error))?;
    let mut last = None;
    let of_load = |reduced: f64| {
        let press = contact.press(Load::MeanPressure(reduced * RMS_GRADIENT));
        let state = press.starting_from(last.as_ref()).solve().map_err(|error| fail(&error))?;
        let part = |least: f64| {
            let count = state.pressure.iter().filter(|pressure| **pressure > least * RMS_GRADIENT).count();
            count as f64 / grid.len() as f64 / reduced
        };
        let parts = PRESSURES.map(part);
        last = Some(state);
        Ok(parts)
    };
    REDUCED.into_iter().map(of_load).collect()
}
