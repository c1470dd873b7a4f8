/// Shift of relaxation times with temperature by the equation of Williams, Landel and Ferry (Journal of the American
/// Chemical Society 77, 3701, 1955): log₁₀ a_T = −C₁ (T − T₀)/(C₂ + T − T₀).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wlf {
    c1: f64,
    c2: f64,
    reference: f64,
}

/// Error: a shift that the equation does not have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum WlfError {
    /// Constant that is not positive.
    #[error("{name} is {found}; it must be positive and finite")]
    Constant {
        /// C1 or C2.
        name: &'static str,
        /// Value found.
        found: f64,
    },
    /// Reference temperature that is no number.
    #[error("T0 is {0}; it must be finite")]
    Reference(f64),
    /// Temperature at which no relaxation ends.
    #[error(
        "the temperature is {found}; it must be above T0 - C2 = {lowest}, where the equation of Williams, Landel and \
         Ferry ends"
    )]
    Temperature {
        /// Temperature found.
        found: f64,
        /// T₀ − C₂.
        lowest: f64,
    },
}

impl Wlf {
    /// Creates the equation from C₁, without unit, C₂, a temperature difference, and the reference temperature T₀. All
    /// temperatures are in one unit, K or °C.
    ///
    /// # Errors
    /// Returns an error if a constant is not positive or a number is not finite.
    pub fn new(c1: f64, c2: f64, reference: f64) -> Result<Self, WlfError> {
        for (name, found) in [("C1", c1), ("C2", c2)] {
            if !(found > 0.0 && found.is_finite()) {
                return Err(WlfError::Constant { name, found });
            }
        }
        if !reference.is_finite() {
            return Err(WlfError::Reference(reference));
        }
        Ok(Self { c1, c2, reference })
    }

    /// Returns the reference temperature T₀.
    pub fn reference(&self) -> f64 {
        self.reference
    }

    /// Returns log₁₀ a_T at a temperature: relaxation times there, divided by the ones at T₀. A frequency measured at
    /// the temperature acts like a_T times the frequency at T₀.
    ///
    /// # Errors
    /// Returns an error for a temperature that is not above T₀ − C₂.
    pub fn log_shift(&self, temperature: f64) -> Result<f64, WlfError> {
        let above = temperature - self.reference;
        let lowest = self.reference - self.c2;
        if !(temperature > lowest && self.c2 + above > 0.0 && above.is_finite()) {
            return Err(WlfError::Temperature { found: temperature, lowest });
        }
        // No negative zero.
        Ok(0.0 - self.c1 * above / (self.c2 + above))
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    #[test]
    fn relaxation_is_faster_when_it_is_warm() {
        let wlf = Wlf::new(17.44, 51.6, -60.0).unwrap();
        assert_eq!(wlf.log_shift(-60.0), Ok(0.0));
        assert_relative_eq!(wlf.log_shift(-8.4).unwrap(), -8.72, max_relative = 1e-14);
        assert!(wlf.log_shift(-70.0).unwrap() > 0.0);
        for cold in [-111.6, -200.0, f64::NAN, f64::NEG_INFINITY] {
            assert!(wlf.log_shift(cold).unwrap_err().to_string().contains("above T0 - C2 = -111.6"));
        }
        assert!(Wlf::new(0.0, 1.0, 0.0).unwrap_err().to_string().starts_with("C1 is 0; it must be positive"));
        assert!(Wlf::new(1.0, f64::NAN, 0.0).unwrap_err().to_string().starts_with("C2 is NaN"));
        assert!(Wlf::new(1.0, 1.0, f64::INFINITY).unwrap_err().to_string().starts_with("T0 is inf"));
    }
}
