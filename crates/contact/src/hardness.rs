use std::sync::Arc;

use gfmd_relax::Upper;
use ndarray::Array2;

use crate::{Refusal, Units};

/// The largest pressure that the surfaces can carry, in stress, positive.
#[derive(Clone, Debug, PartialEq)]
pub enum Hardness {
    /// One for the whole surface.
    Uniform(f64),
    /// One for each point `[x, y]`, as of grains or coatings.
    Field(Array2<f64>),
}

impl Hardness {
    /// The mean over the surface, which the mean pressure cannot reach.
    pub fn mean(&self) -> f64 {
        match self {
            Self::Uniform(hardness) => *hardness,
            Self::Field(field) => Upper::Each(field.iter().copied().collect()).mean(),
        }
    }

    /// The bounds of the pressure on a grid of so many `points`, in `units`.
    pub(crate) fn in_units(&self, points: [usize; 2], units: &Units) -> Result<Upper, Refusal> {
        let check = |found: f64| {
            if !(found > 0.0 && found.is_finite()) {
                return Err(Refusal::Hardness { found });
            }
            Units::check_pressure(found)
        };
        let stress = units.stress();
        match self {
            Self::Uniform(hardness) => {
                check(*hardness)?;
                Ok(Upper::All(hardness / stress))
            }
            Self::Field(field) => {
                let found = field.dim().into();
                if found != points {
                    return Err(Refusal::HardnessShape { found, expected: points });
                }
                field.iter().try_for_each(|hardness| check(*hardness))?;
                Ok(Upper::Each(field.iter().map(|hardness| hardness / stress).collect::<Arc<[f64]>>()))
            }
        }
    }
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
