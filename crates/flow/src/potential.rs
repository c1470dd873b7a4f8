//! Potentials in twice the precision.

/// Deviation of the potential from its mean gradient at a cell, as the sum of a number and a small correction.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Potential([f64; 2]);

impl Potential {
    pub(crate) fn add(&mut self, correction: f64) {
        let Self([high, low]) = *self;
        let low = low + correction;
        let sum = high + low;
        *self = Self([sum, low - (sum - high)]);
    }

    /// Returns the difference from another potential plus `drop`, where both may nearly cancel.
    pub(crate) fn over(self, Self([high, low]): Self, drop: f64) -> f64 {
        let Self([here, rest]) = self;
        let difference = here - high;
        // The rounding error of the difference (Knuth).
        let part = difference - here;
        let lost = (here - (difference - part)) - (high + part);
        (difference + drop) + ((rest - low) + lost)
    }

    /// Returns the sum of both parts.
    pub(crate) fn value(self) -> f64 {
        let Self([high, low]) = self;
        high + low
    }
}
