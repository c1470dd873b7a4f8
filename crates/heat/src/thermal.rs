use crate::HeatError;

/// Thermal properties of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermal {
    conductivity: f64,
    diffusivity: f64,
}

impl Thermal {
    /// Creates a body with a conductivity (heat flux divided by temperature gradient) and a diffusivity (length²/time).
    ///
    /// # Errors
    /// Returns an error if a value is not positive and finite.
    pub fn new(conductivity: f64, diffusivity: f64) -> Result<Self, HeatError> {
        let is_usable = |value: f64| value.is_finite() && value > 0.0;
        if !is_usable(conductivity) {
            return Err(HeatError::Conductivity(conductivity));
        }
        if !is_usable(diffusivity) {
            return Err(HeatError::Diffusivity(diffusivity));
        }
        Ok(Self { conductivity, diffusivity })
    }

    /// Returns the conductivity.
    pub fn conductivity(&self) -> f64 {
        self.conductivity
    }

    /// Returns the diffusivity.
    pub fn diffusivity(&self) -> f64 {
        self.diffusivity
    }
}
