use std::ops::{Add, Mul};

use crate::GreenError;

/// Isotropic linear elastic material with E > 0, −1 < ν ≤ 1/2. ν = 1/2 (incompressible) is exact.
///
/// Combinations that vanish or diverge at ν = 1/2 are computed from closed expressions in ν, never by subtraction, and
/// C11 enters no formula (theory.md, section 0).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    young: f64,
    poisson: f64,
    contact_modulus: f64,
}

impl Material {
    /// Creates a material from Young's modulus E (stress) and Poisson's ratio ν.
    ///
    /// # Errors
    /// Returns an error if E is not positive and finite, or ν is outside −1 < ν ≤ 1/2.
    pub fn from_young(young: f64, poisson: f64) -> Result<Self, GreenError> {
        if !(young.is_finite() && young > 0.0) {
            return Err(GreenError::Young(young));
        }
        let one_minus_square = one_minus_square(poisson)?;
        Ok(Self { young, poisson, contact_modulus: young / one_minus_square })
    }

    /// Creates a material from the contact modulus E* = E/(1 − ν²) (stress) and Poisson's ratio ν.
    ///
    /// # Errors
    /// Returns an error if E* is not positive and finite, or ν is outside −1 < ν ≤ 1/2.
    pub fn from_contact_modulus(contact_modulus: f64, poisson: f64) -> Result<Self, GreenError> {
        if !(contact_modulus.is_finite() && contact_modulus > 0.0) {
            return Err(GreenError::ContactModulus(contact_modulus));
        }
        Ok(Self { young: contact_modulus * one_minus_square(poisson)?, poisson, contact_modulus })
    }

    /// Converts the material to another unit of stress, given in the current unit.
    pub(crate) fn in_units(self, stress: f64) -> Self {
        let Self { young, poisson, contact_modulus } = self;
        Self { young: young / stress, poisson, contact_modulus: contact_modulus / stress }
    }

    /// Returns Young's modulus E, in stress.
    pub fn young(&self) -> f64 {
        self.young
    }

    /// Returns Poisson's ratio ν.
    pub fn poisson(&self) -> f64 {
        self.poisson
    }

    /// Returns the contact modulus E* = E/(1 − ν²) = 2 C44/(1 − ν), in stress.
    pub fn contact_modulus(&self) -> f64 {
        self.contact_modulus
    }

    /// Returns the shear modulus C44 = E/(2(1 + ν)), in stress.
    pub fn shear_modulus(&self) -> f64 {
        self.young / (2.0 * (1.0 + self.poisson))
    }

    /// Returns the P-wave modulus C11 = C44/s, in stress; `None` for an incompressible material.
    pub fn p_wave_modulus(&self) -> Option<f64> {
        (self.s() > 0.0).then(|| self.shear_modulus() / self.s())
    }

    /// Returns the P-wave compliance 1/C11 = s/C44, in 1/stress; 0 for an incompressible material.
    pub fn p_wave_compliance(&self) -> f64 {
        self.s() / self.shear_modulus()
    }

    /// Returns the ratio s = C44/C11 = (1 − 2ν)/(2(1 − ν)): 0 at ν = 1/2, below 3/4.
    pub fn s(&self) -> f64 {
        (1.0 - 2.0 * self.poisson) / (2.0 * (1.0 - self.poisson))
    }

    /// Returns the ratio r = (1 − s)/(1 + s) = 1/(3 − 4ν): 1 at ν = 1/2.
    pub fn r(&self) -> f64 {
        1.0 / (3.0 - 4.0 * self.poisson)
    }

    /// Returns the normal strain ε_zz = (s/C44) σ_zz − (1 − 2s)(ε_xx + ε_yy) from the lateral strains (ε_xx, ε_yy) and
    /// the stress σ_zz, or from their amplitudes (theory.md, section 5). The lateral stresses are then σ_xx = σ_zz + 2
    /// C44 (ε_xx − ε_zz), and similarly σ_yy.
    pub fn normal_strain<T>(&self, lateral: [T; 2], normal_stress: T) -> T
    where
        T: Copy + Add<Output = T> + Mul<f64, Output = T>,
    {
        let narrowing = (lateral[0] + lateral[1]) * (2.0 * self.s() - 1.0);
        // The stress on an incompressible material may be infinite, and zero times infinity would be NaN.
        if self.s() > 0.0 { normal_stress * self.p_wave_compliance() + narrowing } else { narrowing }
    }

    /// Returns 1 − s = 1/(2(1 − ν)).
    pub(crate) fn one_minus_s(&self) -> f64 {
        0.5 / (1.0 - self.poisson)
    }

    /// Returns 1 − s² = (3 − 4ν)/(4(1 − ν)²).
    pub(crate) fn one_minus_s_squared(&self) -> f64 {
        let complement = 1.0 - self.poisson;
        (3.0 - 4.0 * self.poisson) / (4.0 * complement * complement)
    }

    /// Returns 1 − r = 2(1 − 2ν)/(3 − 4ν).
    pub(crate) fn one_minus_r(&self) -> f64 {
        2.0 * (1.0 - 2.0 * self.poisson) * self.r()
    }

    /// Returns 1 + r = 4(1 − ν)/(3 − 4ν).
    pub(crate) fn one_plus_r(&self) -> f64 {
        4.0 * (1.0 - self.poisson) * self.r()
    }

    /// Returns P(q)/(C44 q) = 2/(1 + s) = 4(1 − ν)/(3 − 4ν), the unit of the sagittal kernels.
    pub(crate) fn sagittal_unit(&self) -> f64 {
        self.one_plus_r()
    }
}

/// Returns 1 − ν², or an error if ν is out of range.
fn one_minus_square(poisson: f64) -> Result<f64, GreenError> {
    if poisson > -1.0 && poisson <= 0.5 {
        Ok((1.0 - poisson) * (1.0 + poisson))
    } else {
        Err(GreenError::Poisson(poisson))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unusable_constants_are_refused_with_what_was_found() {
        for young in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(matches!(Material::from_young(young, 0.3), Err(GreenError::Young(_))), "{young}");
            assert!(matches!(Material::from_contact_modulus(young, 0.3), Err(GreenError::ContactModulus(_))));
        }
        for poisson in [-1.0, 0.500_000_1, f64::NAN, f64::INFINITY] {
            assert!(matches!(Material::from_young(1.0, poisson), Err(GreenError::Poisson(_))), "{poisson}");
        }
        let message = Material::from_young(1.0, 0.7).unwrap_err().to_string();
        assert_eq!(message, "Poisson's ratio is 0.7; it must be above -1 and at most 0.5");
    }

    #[test]
    fn both_constructors_keep_what_they_were_given() {
        for poisson in [-0.95, -0.2, 0.0, 0.33, 0.5] {
            let material = Material::from_contact_modulus(0.7, poisson).unwrap();
            assert_eq!(material.contact_modulus(), 0.7);
            let again = Material::from_young(material.young(), poisson).unwrap();
            approx::assert_relative_eq!(again.contact_modulus(), 0.7, max_relative = 4e-16);
        }
    }

    #[test]
    fn an_incompressible_material_is_exact() {
        let rubber = Material::from_young(3.0, 0.5).unwrap();
        assert_eq!((rubber.s(), rubber.r(), rubber.one_minus_r()), (0.0, 1.0, 0.0));
        assert_eq!((rubber.shear_modulus(), rubber.contact_modulus()), (1.0, 4.0));
        assert_eq!((rubber.p_wave_modulus(), rubber.p_wave_compliance()), (None, 0.0));
    }

    #[test]
    fn the_closed_forms_agree_with_their_definitions() {
        for i in 0..200 {
            let poisson = 0.5 - 1.49 * (0.618_034 * f64::from(i)).fract();
            let m = Material::from_young(1.3, poisson).unwrap();
            let (s, r) = (m.s(), m.r());
            let same = |found: f64, wanted: f64| approx::assert_abs_diff_eq!(found, wanted, epsilon = 4e-15);
            same(r, (1.0 - s) / (1.0 + s));
            same(m.one_minus_s(), 1.0 - s);
            same(m.one_minus_s_squared(), 1.0 - s * s);
            same(m.one_minus_r(), 1.0 - r);
            same(m.one_plus_r(), 1.0 + r);
            same(m.sagittal_unit(), 2.0 / (1.0 + s));
            same(m.contact_modulus() * (1.0 - poisson) / (2.0 * m.shear_modulus()), 1.0);
        }
    }
}
