use crate::Refusal;

/// Load that presses two surfaces together or pulls them apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// Mean pressure over the whole surface, in stress; tension is negative.
    MeanPressure(f64),
    /// Rigid approach beyond first touch of the undeformed surfaces, in length; negative before first touch. On a
    /// half-space it is measured against the mean level of the elastic surface, on a slab against its rigid base.
    Approach(f64),
}

impl Load {
    /// Returns true for a load at which a hard wall leaves an elastic surface: no mean pressure, or an approach that
    /// does not go beyond first touch.
    pub fn is_lifted(self) -> bool {
        matches!(self, Self::MeanPressure(0.0) | Self::Approach(..=0.0))
    }

    /// Returns the name and the value of the prescribed quantity.
    pub(crate) fn named(self) -> (&'static str, f64) {
        match self {
            Self::MeanPressure(mean) => ("mean pressure", mean),
            Self::Approach(approach) => ("approach", approach),
        }
    }

    /// Returns the mean pressure, if it is prescribed.
    pub(crate) fn mean_pressure(self) -> Option<f64> {
        match self {
            Self::MeanPressure(mean) => Some(mean),
            Self::Approach(_) => None,
        }
    }
}

/// Prescribed motion of the rigid surface: its load and its lateral displacement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Load towards the body.
    pub load: Load,
    /// Displacement of the rigid surface along x and y, in length. It affects only problems with lateral components. On
    /// a half-space it is measured against the mean of the elastic surface, on a slab against its base.
    pub lateral: [f64; 2],
    /// Time at which load and displacement are reached, measured from first touch of the undeformed surfaces. It
    /// affects only viscoelastic bodies.
    pub time: f64,
    /// Sliding distance at which they are reached, in length, measured from first touch of the undeformed surfaces. It
    /// affects only surfaces that wear.
    pub distance: f64,
}

impl From<Load> for Drive {
    /// Makes a drive without lateral displacement, at time 0 and distance 0.
    fn from(load: Load) -> Self {
        Self { load, lateral: [0.0; 2], time: 0.0, distance: 0.0 }
    }
}

impl Drive {
    /// Sets the time at which the drive is reached.
    #[must_use]
    pub fn at(self, time: f64) -> Self {
        Self { time, ..self }
    }

    /// Sets the sliding distance at which the drive is reached.
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
