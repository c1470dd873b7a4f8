use std::sync::Arc;

use gfmd_vector::for_each;
use multiversion::multiversion;
use ndarray::Array2;

use crate::{Refusal, RigidSurface, Units};

/// Compliance of springs that act point by point between the surfaces, in length/stress, not negative: the distance by
/// which a pressure shortens the spring at its point, divided by the pressure.
#[derive(Clone, Debug, PartialEq)]
pub enum Springs {
    /// One value for the whole surface.
    Uniform(f64),
    /// One value for each point `[x, y]`, for example of a thin coating or of surfaces that wear differently.
    Field(Array2<f64>),
}

/// Springs in the units of a solve.
pub(crate) struct SpringsInUnits {
    /// Compliance that all points have, which is added to every mode of the body.
    pub(crate) common: f64,
    /// Compliance of each point beyond the common one, unless all points are equal.
    pub(crate) rest: Option<Arc<[f64]>>,
}

impl Springs {
    /// Returns the springs of a surface, in `units`; rows of this process.
    pub(crate) fn in_units(&self, surface: &RigidSurface, units: &Units) -> Result<SpringsInUnits, Refusal> {
        let (unit, share) = (units.stiffness(), surface.share());
        match self {
            Self::Uniform(compliance) => {
                check(*compliance)?;
                Ok(SpringsInUnits { common: compliance * unit, rest: None })
            }
            Self::Field(field) => {
                let (found, expected) = (field.dim().into(), surface.shape());
                if share.any(found != expected) {
                    return Err(Refusal::SpringsShape { found, expected });
                }
                let wrong = field.iter().copied().find(|compliance| check(*compliance).is_err());
                share.first(wrong).map_or(Ok(()), check)?;
                let least = field.iter().fold(f64::INFINITY, |least, compliance| least.min(*compliance));
                let common = share.each(least).into_iter().fold(f64::INFINITY, f64::min);
                let is_uniform = !share.any(field.iter().any(|compliance| *compliance != common));
                let rest = || field.iter().map(|compliance| (compliance - common) * unit).collect();
                Ok(SpringsInUnits { common: common * unit, rest: (!is_uniform).then(rest) })
            }
        }
    }
}

/// Adds the shortening of springs with a `compliance` under a `pressure` to `out`.
pub(crate) fn add(compliance: &[f64], pressure: &[f64], out: &mut [f64]) {
    for_each((out, compliance, pressure), &|_, (out, compliance, pressure)| add_row(compliance, pressure, out));
}

/// Adds the shortening of springs in one row.
#[multiversion(targets = "simd")]
pub(crate) fn add_row(compliance: &[f64], pressure: &[f64], out: &mut [f64]) {
    out.iter_mut().zip(compliance.iter().zip(pressure)).for_each(|(out, (k, p))| *out += k * p);
}

/// Checks that a compliance is finite and not negative.
fn check(found: f64) -> Result<(), Refusal> {
    if found >= 0.0 && found.is_finite() { Ok(()) } else { Err(Refusal::Springs { found }) }
}

impl From<f64> for Springs {
    fn from(compliance: f64) -> Self {
        Self::Uniform(compliance)
    }
}

impl From<Array2<f64>> for Springs {
    fn from(field: Array2<f64>) -> Self {
        Self::Field(field)
    }
}
