use crate::HeatError;

/// The thermal properties of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thermal {
    conductivity: f64,
    diffusivity: f64,
}

impl Thermal {
    /// A body of this conductivity, heat flux over gradient of the temperature, and this diffusivity, length²/time.
    ///
    /// # Errors
    /// A number that is not positive and finite.
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

    /// The conductivity.
    pub fn conductivity(&self) -> f64 {
        self.conductivity
    }

    /// The diffusivity.
    pub fn diffusivity(&self) -> f64 {
        self.diffusivity
    }
}
