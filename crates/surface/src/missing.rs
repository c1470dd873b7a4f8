//! Waves of an infinitely large self-affine surface that are longer than the longest wave of a simulated surface.

use crate::{Discretisation, SurfaceError};

/// Relative tolerance of a wave number at the ends of the ring.
const AT_THE_END: f64 = 1e-9;

impl Discretisation {
    /// Returns the mean square gradient of all waves longer than the longest one, down to wave number zero, divided by
    /// the mean square gradient of the waves from the longest to the shortest, for the surface spectrum ⟨|h̃|²⟩ ∝
    /// q^{−2(1+H)}. The ratio tends to ε_f^{2−2H} for ε_t, ε_f → 0 (theory.md, section 11).
    ///
    /// Both are sums over the integer wave numbers m of the cell. The sum of |m|^{−2H} over all m ≠ 0 below M grows as
    /// the integral π M^{2−2H}/(1−H) minus 4ζ(H)β(H) = ζ_E, Epstein's zeta function. The cell around m = 0 therefore
    /// contributes −ζ_E.
    ///
    /// # Errors
    /// A Hurst exponent below 0 or above 0.99 (at 1 the gradient of infinitely long waves diverges); discretisation
    /// numbers out of range.
    pub fn missing_long_waves(&self, hurst: f64) -> Result<f64, SurfaceError> {
        self.points()?;
        if !(0.0..=0.99).contains(&hurst) {
            return Err(SurfaceError::Hurst(hurst));
        }
        let first = (self.eps_t_inv * (1.0 - AT_THE_END)).powi(2);
        let last = (self.eps_t_inv * self.eps_f_inv * (1.0 + AT_THE_END)).powi(2);
        let side = last.sqrt() as u64;
        let (mut missing, mut present) = (0.0, 0.0);
        // A quarter of the plane: m from 1, n from 0.
        for m in 1..=side {
            let (mut below, mut within) = (0.0, 0.0);
            for n in 0..=side {
                let square = (m * m + n * n) as f64;
                if square > last {
                    break;
                }
                let sum = if square < first { &mut below } else { &mut within };
                *sum += square.powf(-hurst);
            }
            missing += 4.0 * below;
            present += 4.0 * within;
        }
        Ok((missing - epstein(hurst)) / present)
    }
}

/// Returns the sum of |m|^{−2s} over all pairs of integers m ≠ 0, continued to 0 <= s < 1: 4ζ(s)β(s).
fn epstein(s: f64) -> f64 {
    let zeta = alternating(|k| (k + 1.0).powf(-s)) / (1.0 - (1.0 - s).exp2());
    4.0 * zeta * alternating(|k| (2.0 * k + 1.0).powf(-s))
}

/// Returns the sum of (−1)^k f(k) over k >= 0, convergent or not, for a completely monotonic f, to 16 digits (algorithm
/// 1 of Cohen, Rodriguez Villegas and Zagier, Exp. Math. 9, 3, 2000).
fn alternating(f: impl Fn(f64) -> f64) -> f64 {
    const TERMS: i32 = 24;
    let power = (3.0 + 8.0_f64.sqrt()).powi(TERMS);
    let size = 0.5 * (power + power.recip());
    let (mut b, mut c, mut sum) = (-1.0, -size, 0.0);
    for k in 0..TERMS {
        let (n, k) = (f64::from(TERMS), f64::from(k));
        c = b - c;
        sum += c * f(k);
        b *= (k + n) * (k - n) / ((k + 0.5) * (k + 1.0));
    }
    sum / size
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(eps_t_inv: f64, eps_f_inv: f64) -> Discretisation {
        Discretisation { eps_t_inv, eps_f_inv, eps_c_inv: 2.0 }
    }

    #[test]
    fn the_zeta_function_has_its_known_values() {
        // zeta(0) = -1/2 and beta(0) = 1/2; zeta(1/2) = -1.4603545088, beta(1/2) = 0.6676914572 (DLMF 25.2, 25.15).
        assert!((epstein(0.0) + 1.0).abs() < 1e-13);
        assert!((epstein(0.5) + 4.0 * 1.460_354_508_8 * 0.667_691_457_2).abs() < 1e-8);
    }

    #[test]
    fn missing_and_present_waves_together_are_the_integral() {
        for hurst in [0.0, 0.3, 0.5, 0.8] {
            let numbers = at(1.0, 512.0);
            let exact = std::f64::consts::PI * 512.0_f64.powf(2.0 - 2.0 * hurst) / (1.0 - hurst);
            let missing = -epstein(hurst);
            let found = numbers.missing_long_waves(hurst).unwrap();
            assert!((found / (missing / (exact - missing)) - 1.0).abs() < 1e-3, "{hurst}: {found}");
        }
    }

    #[test]
    fn large_cells_and_long_ladders_approach_the_power_of_eps_f() {
        for hurst in [0.0, 0.3, 0.5, 0.8] {
            let power = 16.0_f64.powf(2.0 - 2.0 * hurst);
            let found = at(64.0, 16.0).missing_long_waves(hurst).unwrap();
            assert!((found * (power - 1.0) - 1.0).abs() < 0.02, "{hurst}: {found}");
        }
    }

    #[test]
    fn what_has_no_limit_is_refused() {
        for hurst in [-0.1, 1.0, f64::NAN] {
            assert!(matches!(at(1.0, 8.0).missing_long_waves(hurst), Err(SurfaceError::Hurst(_))));
        }
        assert!(at(0.5, 8.0).missing_long_waves(0.5).is_err());
    }
}
