//! Hardness and springs of an interface.

use gfmd_contact::{Hardness, Load, Refusal, Springs};
use gfmd_relax::Upper;
use ndarray::Array2;

use crate::Interface;
use crate::frame::Frame;
use crate::kinks::{Kinks, is_rigid};

/// Reason why a [`Refusal`] names all components.
const ALL_COMPONENTS: &str = "all components of the displacement";
/// Reason why a [`Refusal`] names the law.
const NO_WALL: &str = "a law without a hard wall";

impl Interface {
    /// Sets the `hardness`, the largest pressure that the body feels, in stress: a number or a field `[x, y]`. Beside a
    /// law, the repulsion of the wall may exceed it by the attraction in contact. Where it is reached, the surfaces are
    /// [pressed into each other](crate::State::pressed_in). A repulsive law is not bounded.
    ///
    /// # Errors
    /// Returns an error for a hardness that is not positive and finite or differs in shape from the heights, for a law
    /// without a hard wall, and for an interface in all components.
    pub fn with_hardness(self, hardness: impl Into<Hardness>) -> Result<Self, Refusal> {
        self.check_wall("a hardness is")?;
        let hardness = Some(hardness.into().in_units(&self.given, &self.units)?);
        Ok(Self { hardness, ..self })
    }

    /// Sets the compliance of `springs` in series with the wall, in length/stress, a number or a field `[x, y]`: in
    /// contact, the surfaces overlap by the compliance times the [pressure of the wall](crate::State::wall_pressure).
    /// At a compliance of 0 the wall is hard. Archard's law in one step of sliding is such a compliance, the
    /// coefficient times the distance.
    ///
    /// # Errors
    /// Returns an error for a compliance that is negative or not finite or differs in shape from the heights, for a law
    /// without a hard wall, and for an interface in all components.
    pub fn with_springs(self, springs: impl Into<Springs>) -> Result<Self, Refusal> {
        self.check_wall("a compliance of springs is")?;
        let [nx, ny] = self.given.shape();
        let check = |found: f64| {
            if found >= 0.0 && found.is_finite() { Ok(found) } else { Err(Refusal::Springs { found }) }
        };
        let values: Vec<f64> = match springs.into() {
            Springs::Uniform(compliance) => vec![check(compliance)?; nx * ny],
            Springs::Field(field) => {
                let (found, expected) = (field.dim().into(), [nx, ny]);
                if found != expected {
                    return Err(Refusal::SpringsShape { found, expected });
                }
                field.iter().map(|compliance| check(*compliance)).collect::<Result<_, _>>()?
            }
        };
        let unit = self.units.stiffness();
        let is_rigid = !self.share.any(values.iter().any(|compliance| *compliance != 0.0));
        let springs = (!is_rigid).then(|| values.iter().map(|compliance| compliance * unit).collect());
        Ok(Self { springs, ..self })
    }

    /// Returns the hardness, in stress.
    pub fn hardness(&self) -> Option<Hardness> {
        self.hardness_in(self.units.stress())
    }

    /// Returns the hardness multiplied by `unit`.
    pub(crate) fn hardness_in(&self, unit: f64) -> Option<Hardness> {
        Some(match self.hardness.as_ref()?.times(unit) {
            Upper::All(hardness) => Hardness::Uniform(hardness),
            Upper::Each(values) => {
                let [nx, ny] = self.given.shape();
                Hardness::Field(Array2::from_shape_fn([nx, ny], |(i, j)| values[i * ny + j]))
            }
        })
    }

    fn check_wall(&self, part: &'static str) -> Result<(), Refusal> {
        match (self.elastic.components(), self.law.has_wall()) {
            (1, true) => Ok(()),
            (1, false) => Err(Refusal::NoWall { part, with: NO_WALL }),
            _ => Err(Refusal::NoWall { part, with: ALL_COMPONENTS }),
        }
    }

    /// Checks that the mean pressure of a load, in input units, is below the mean hardness.
    pub(crate) fn check_hardness(&self, load: Load) -> Result<(), Refusal> {
        let (Some(hardness), Load::MeanPressure(found)) = (&self.hardness, load) else { return Ok(()) };
        let what = if let Upper::Each(_) = hardness { "mean hardness" } else { "hardness" };
        let hardness = hardness.mean_over(self.surface.share()) * self.units.stress();
        if found < hardness { Ok(()) } else { Err(Refusal::BeyondHardness { found, what, hardness }) }
    }

    /// Returns true if the wall gives way at some points, so that a body with a fixed mean level may be pressed beyond
    /// full contact.
    pub(crate) fn gives_way(&self) -> bool {
        self.hardness.is_some() || self.has_springs()
    }

    /// Returns true if the springs at some points are not walls for the search.
    pub(crate) fn has_springs(&self) -> bool {
        let [_, stiffest] = self.elastic.stiffness_range();
        let given = self.springs.as_ref();
        given.is_some_and(|all| self.share.any(all.iter().any(|k| !is_rigid(*k, stiffest))))
    }

    /// Returns the wall in a frame; `None` if it gives way nowhere.
    pub(crate) fn kinks(&self, frame: &Frame) -> Option<Kinks> {
        let touch = self.law.opening(0.0);
        let range = self.elastic.stiffness_range();
        self.gives_way().then(|| Kinks::new(frame, self.hardness.as_ref(), self.springs.as_deref(), touch, range))
    }
}
