use crate::Refusal;

/// The load that presses two surfaces together, or pulls them apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// Mean pressure over the whole surface, in stress; tension is negative.
    MeanPressure(f64),
    /// Rigid approach beyond first touch of the undeformed surfaces, in length; negative before first touch. On a
    /// half-space it is measured against the mean level of the elastic surface, on a slab against its rigid base.
    Approach(f64),
}

impl Load {
    /// The name of what is prescribed, with its value.
    pub(crate) fn named(self) -> (&'static str, f64) {
        match self {
            Self::MeanPressure(mean) => ("mean pressure", mean),
            Self::Approach(approach) => ("approach", approach),
        }
    }

    /// The mean pressure, if it is prescribed.
    pub(crate) fn mean_pressure(self) -> Option<f64> {
        match self {
            Self::MeanPressure(mean) => Some(mean),
            Self::Approach(_) => None,
        }
    }
}

/// The prescribed motion of the rigid surface: its load, and its lateral displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Load towards the body.
    pub load: Load,
    /// Displacement of the rigid surface along x and y, in length. It has an effect only in problems with lateral
    /// components. On a half-space it is measured against the mean of the elastic surface, on a slab against its base.
    pub lateral: [f64; 2],
    /// Time at which load and displacement are reached, since the first touch of the undeformed surfaces. It has an
    /// effect only on viscoelastic bodies.
    pub time: f64,
    /// Sliding distance at which they are reached, since the first touch of the undeformed surfaces, in length. It has
    /// an effect only on surfaces that wear.
    pub distance: f64,
}

impl From<Load> for Drive {
    /// A drive without lateral displacement, in no time and over no distance.
    fn from(load: Load) -> Self {
        Self { load, lateral: [0.0; 2], time: 0.0, distance: 0.0 }
    }
}

impl Drive {
    /// The drive reached at this `time`.
    #[must_use]
    pub fn at(self, time: f64) -> Self {
        Self { time, ..self }
    }

    /// The drive reached after this sliding `distance`.
    #[must_use]
    pub fn after(self, distance: f64) -> Self {
        Self { distance, ..self }
    }

    /// Checks that every number is finite.
    ///
    /// # Errors
    /// The first number that is not finite.
    pub fn check(&self) -> Result<(), Refusal> {
        let [x, y] = self.lateral.map(|lateral| ("lateral displacement", lateral));
        let all = [self.load.named(), x, y, ("time", self.time), ("distance", self.distance)];
        match all.into_iter().find(|(_, found)| !found.is_finite()) {
            Some((what, found)) => Err(Refusal::NotFinite { what, found }),
            None => Ok(()),
        }
    }
}
