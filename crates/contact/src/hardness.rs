use std::sync::Arc;

use gfmd_relax::Upper;
use ndarray::Array2;

use crate::{Refusal, RigidSurface, Units};

/// Largest pressure that the surfaces can carry, in stress, positive.
#[derive(Clone, Debug, PartialEq)]
pub enum Hardness {
    /// One value for the whole surface.
    Uniform(f64),
    /// One value for each point `[x, y]`, for example of grains or coatings.
    Field(Array2<f64>),
}

impl Hardness {
    /// Returns the mean over the surface, which the mean pressure cannot reach.
    pub fn mean(&self) -> f64 {
        match self {
            Self::Uniform(hardness) => *hardness,
            Self::Field(field) => Upper::Each(field.iter().copied().collect()).mean(),
        }
    }

    /// Checks that the surfaces can carry the mean pressure `found`, in stress.
    ///
    /// # Errors
    /// A pressure that is not below the mean hardness.
    pub fn check_mean(&self, found: f64) -> Result<(), Refusal> {
        let hardness = self.mean();
        if found < hardness {
            return Ok(());
        }
        let what = if let Self::Field(_) = self { "mean hardness" } else { "hardness" };
        Err(Refusal::BeyondHardness { found, what, hardness })
    }

    /// Checks a mean pressure as [`check_mean`](Self::check_mean), for the points of all processes on a `surface`.
    pub(crate) fn check_mean_over(&self, surface: &RigidSurface, found: f64) -> Result<(), Refusal> {
        let Self::Field(field) = self else { return self.check_mean(found) };
        let share = surface.share();
        let hardness = share.total_of(&gfmd_vector::contiguous(field)) / share.total() as f64;
        if found < hardness { Ok(()) } else { Err(Refusal::BeyondHardness { found, what: "mean hardness", hardness }) }
    }

    /// Multiplies the hardness by a factor.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        match self {
            Self::Uniform(hardness) => Self::Uniform(hardness * factor),
            Self::Field(field) => Self::Field(field * factor),
        }
    }

    /// Returns the bounds of the pressure on a surface, in `units`; each of several processes gives its rows.
    ///
    /// # Errors
    /// A hardness that is not positive and finite, or differs in shape from the surface.
    pub fn in_units(&self, surface: &RigidSurface, units: &Units) -> Result<Upper, Refusal> {
        let (stress, share) = (units.stress(), surface.share());
        match self {
            Self::Uniform(hardness) => {
                check(*hardness)?;
                Ok(Upper::All(hardness / stress))
            }
            Self::Field(field) => {
                let (found, expected) = (field.dim().into(), surface.shape());
                if share.any(found != expected) {
                    return Err(Refusal::HardnessShape { found, expected });
                }
                let wrong = field.iter().copied().find(|hardness| check(*hardness).is_err());
                share.first(wrong).map_or(Ok(()), check)?;
                Ok(Upper::Each(field.iter().map(|hardness| hardness / stress).collect::<Arc<[f64]>>()))
            }
        }
    }
}

/// Checks that a hardness is positive, finite and in the range of full precision.
fn check(found: f64) -> Result<(), Refusal> {
    if !(found > 0.0 && found.is_finite()) {
        return Err(Refusal::Hardness { found });
    }
    Units::check_pressure(found)
}

impl From<f64> for Hardness {
    fn from(hardness: f64) -> Self {
        Self::Uniform(hardness)
    }
}

impl From<Array2<f64>> for Hardness {
    fn from(field: Array2<f64>) -> Self {
        Self::Field(field)
    }
}
