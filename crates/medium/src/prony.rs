use gfmd_green::{GreenError, Material};
use num_complex::Complex64;

use crate::bulk::bulk;
use crate::poles::poles;
use crate::{Branch, Relaxes};

/// Relaxation of a modulus by a Prony series: ψ(t) = 1 + Σ c_i exp(−t/τ_i), relative to the long-term modulus
/// (theory.md, section 7.7).
#[derive(Clone, Debug, PartialEq)]
pub struct Prony {
    branches: Vec<Branch>,
}

/// Error: an invalid Prony series.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PronyError {
    /// No branches.
    #[error("the Prony series has no branch; it must have at least one")]
    Empty,
    /// Relaxation time that is not positive.
    #[error("a relaxation time is {0}; it must be positive and finite")]
    Time(f64),
    /// Modulus fraction outside the range from 0 to 1.
    #[error("a fraction of the modulus is {0}; it must be above 0 and below 1")]
    Fraction(f64),
    /// Fractions that leave no long-term modulus.
    #[error(
        "the fractions of the modulus add up to {0}; they must leave a long-term modulus, and add up to less than 1"
    )]
    Sum(f64),
    /// Two branches with the same relaxation time.
    #[error("two branches have the relaxation time {0}; their times must differ")]
    Equal(f64),
}

impl Prony {
    /// Creates the series from pairs (τ, g) of relaxation time and fraction of the instantaneous modulus.
    ///
    /// # Errors
    /// Returns an error if a time is repeated or not positive and finite, a fraction is not positive, or Σ g ≥ 1.
    pub fn from_fractions(pairs: &[(f64, f64)]) -> Result<Self, PronyError> {
        if pairs.is_empty() {
            return Err(PronyError::Empty);
        }
        for (index, (time, fraction)) in pairs.iter().enumerate() {
            if !(time.is_finite() && *time > 0.0) {
                return Err(PronyError::Time(*time));
            }
            if !(*fraction > 0.0 && *fraction < 1.0) {
                return Err(PronyError::Fraction(*fraction));
            }
            if pairs[..index].iter().any(|(other, _)| other == time) {
                return Err(PronyError::Equal(*time));
            }
        }
        let sum: f64 = pairs.iter().map(|(_, fraction)| fraction).sum();
        if sum >= 1.0 {
            return Err(PronyError::Sum(sum));
        }
        let branch = |(time, fraction): &(f64, f64)| Branch { time: *time, weight: fraction / (1.0 - sum) };
        Ok(Self { branches: pairs.iter().map(branch).collect() })
    }

    /// Returns the branches.
    pub fn branches(&self) -> &[Branch] {
        &self.branches
    }

    /// Returns the instantaneous modulus divided by the long-term modulus, ψ(0) = 1/(1 − Σ g).
    pub fn instantaneous(&self) -> f64 {
        1.0 + self.branches.iter().map(|branch| branch.weight).sum::<f64>()
    }

    /// Converts a material with `instantaneous` moduli to its long-term moduli.
    ///
    /// # Errors
    /// Returns an error if the moduli are out of range.
    pub fn long_term(&self, instantaneous: &Material, relaxes: Relaxes) -> Result<Material, GreenError> {
        scaled(instantaneous, 1.0 / self.instantaneous(), relaxes)
    }

    /// Converts a material with `long_term` moduli to its instantaneous moduli.
    ///
    /// # Errors
    /// Returns an error if the moduli are out of range.
    pub fn at_once(&self, long_term: &Material, relaxes: Relaxes) -> Result<Material, GreenError> {
        scaled(long_term, self.instantaneous(), relaxes)
    }

    /// Returns the relaxation function ψ(t), relative to the long-term modulus, at a time t ≥ 0.
    pub fn relaxation(&self, time: f64) -> f64 {
        1.0 + self.branches.iter().map(|branch| branch.weight * (-time / branch.time).exp()).sum::<f64>()
    }

    /// Returns the complex modulus divided by the long-term modulus at the angular frequency ω, for e^{+iωt}: 1 + Σ c_i
    /// iωτ_i/(1 + iωτ_i).
    pub fn modulus(&self, frequency: f64) -> Complex64 {
        Self::modulus_of(self.branches.iter().copied(), frequency)
    }

    /// Returns the complex modulus of the given branches.
    pub(crate) fn modulus_of(branches: impl Iterator<Item = Branch>, frequency: f64) -> Complex64 {
        let of = |branch: Branch| {
            let x = frequency * branch.time;
            // ix/(1 + ix), without overflow of x².
            let real = if x.abs() > 1.0 { 1.0 / (1.0 + x.powi(-2)) } else { x * x / (1.0 + x * x) };
            let imaginary = if x == 0.0 { 0.0 } else { 1.0 / (x + 1.0 / x) };
            branch.weight * Complex64::new(real, imaginary)
        };
        1.0 + branches.map(of).sum::<Complex64>()
    }

    /// Returns the creep function J(t) times the long-term modulus: the strain under constant stress at a time t ≥ 0.
    pub fn creep(&self, time: f64) -> f64 {
        let delayed = |[rate, residue]: [f64; 2]| -(residue / rate) * (-rate * time).exp_m1();
        1.0 / self.instantaneous() + poles(&self.branches, 0.0).into_iter().map(delayed).sum::<f64>()
    }
}

/// Scales the shear modulus by `factor`; the bulk modulus scales with it or stays constant.
fn scaled(material: &Material, factor: f64, relaxes: Relaxes) -> Result<Material, GreenError> {
    if relaxes == Relaxes::Both || material.poisson() == 0.5 {
        return Material::from_young(material.young() * factor, material.poisson());
    }
    let (shear, k) = (material.shear_modulus() * factor, bulk(material) / factor);
    Material::from_young(9.0 * k * shear / (3.0 * k + 1.0), (3.0 * k - 2.0) / (2.0 * (3.0 * k + 1.0)))
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    fn three() -> Prony {
        Prony::from_fractions(&[(0.05, 0.3), (0.7, 0.25), (6.0, 0.2)]).unwrap()
    }

    #[test]
    fn functions_have_known_values() {
        let prony = three();
        let weights: Vec<f64> = prony.branches().iter().map(|branch| branch.weight).collect();
        weights
            .iter()
            .zip([1.2, 1.0, 0.8])
            .for_each(|(found, known)| assert_relative_eq!(*found, known, max_relative = 1e-15));
        assert_relative_eq!(prony.instantaneous(), 4.0, max_relative = 1e-15);
        assert_relative_eq!(prony.relaxation(1.0), 1.916836418828, max_relative = 1e-12);
        let modulus = prony.modulus(2.0);
        assert_relative_eq!(modulus.re, 2.468526108902, max_relative = 1e-12);
        assert_relative_eq!(modulus.im, 0.657991750713, max_relative = 1e-12);
        assert_eq!(prony.modulus(-2.0), modulus.conj());
    }

    #[test]
    fn creep_is_the_inverse_of_relaxation() {
        // ψ(0) J(t) + ∫ ψ'(t') J(t − t') dt' = 1, by a fine trapezoidal rule on the slow time scale of one branch.
        let prony = Prony::from_fractions(&[(1.0, 0.6)]).unwrap();
        let (t, steps) = (2.0, 20_000);
        let h = t / f64::from(steps);
        let slope = |time: f64| -1.5 * (-time).exp();
        let sum: f64 = (0..=steps)
            .map(|k| {
                let weight = if k == 0 || k == steps { 0.5 } else { 1.0 };
                let time = f64::from(k) * h;
                weight * slope(time) * prony.creep(t - time)
            })
            .sum();
        assert_relative_eq!(prony.instantaneous() * prony.creep(t) + h * sum, 1.0, max_relative = 1e-8);
        assert_relative_eq!(three().creep(0.0), 0.25, max_relative = 1e-14);
        assert_relative_eq!(three().creep(1e9), 1.0, max_relative = 1e-12);
    }

    #[test]
    fn moduli_follow_from_one_another() {
        let given = Material::from_young(10.0, 0.3).unwrap();
        for relaxes in Relaxes::ALL {
            let soft = three().long_term(&given, relaxes).unwrap();
            assert_relative_eq!(soft.shear_modulus(), 0.25 * given.shear_modulus(), max_relative = 1e-14);
            let back = three().at_once(&soft, relaxes).unwrap();
            assert_relative_eq!(back.young(), given.young(), max_relative = 1e-13);
            assert_relative_eq!(back.poisson(), given.poisson(), max_relative = 1e-13);
        }
        let bulk = |material: &Material| material.young() / (3.0 * (1.0 - 2.0 * material.poisson()));
        let soft = three().long_term(&given, Relaxes::Shear).unwrap();
        assert_relative_eq!(bulk(&soft), bulk(&given), max_relative = 1e-13);
    }

    #[test]
    fn no_material_has_such_a_series() {
        let refused = |pairs: &[(f64, f64)]| Prony::from_fractions(pairs).unwrap_err().to_string();
        assert!(refused(&[]).contains("at least one"));
        for time in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(refused(&[(time, 0.5)]).starts_with("a relaxation time is"));
        }
        for fraction in [0.0, -0.1, 1.0, f64::NAN] {
            assert!(refused(&[(1.0, fraction)]).starts_with("a fraction of the modulus is"));
        }
        assert!(refused(&[(1.0, 0.5), (2.0, 0.5)]).contains("add up to 1"));
        assert!(refused(&[(1.0, 0.5), (1.0, 0.1)]).contains("the relaxation time 1"));
    }
}
