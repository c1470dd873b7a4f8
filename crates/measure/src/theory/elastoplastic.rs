//! Persson's theory with a hardness (theory.md, section 10).

use std::f64::consts::PI;

/// Contact area of Persson's theory with a hardness, as fractions of the surface (Persson, J. Chem. Phys. 115 (2001)
/// 3840; Xu, Li and Mulvihill, arXiv:2208.02665).
///
/// Waves are added from long to short. The pressure of a point performs a random walk with the variance of the pressure
/// in full contact. At zero pressure the point leaves the contact; at the hardness it stays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ElastoplasticArea {
    /// Points with a pressure between zero and the hardness.
    pub elastic: f64,
    /// Points with a pressure equal to the hardness.
    pub plastic: f64,
}

/// Largest number of terms of either series, far more than needed.
const TERMS: i32 = 64;

impl ElastoplasticArea {
    /// Computes the area under a mean pressure below the `hardness`, with the `variance` of the pressure in full
    /// contact (E*² ḡ²/4 on a half-space). All in stress; the mean pressure and the variance must not be negative, and
    /// the hardness must be positive.
    pub fn new(mean_pressure: f64, variance: f64, hardness: f64) -> Self {
        let share = mean_pressure / hardness;
        let spread = variance / (hardness * hardness);
        // The series of images converges fast for small variances, the series of sines for large ones.
        let (plastic, apart) = if spread < 0.5 {
            (hits(share, spread), hits(1.0 - share, spread))
        } else {
            (sines(share, spread), sines(1.0 - share, spread))
        };
        Self { elastic: 1.0 - plastic - apart, plastic }
    }

    /// Returns the fraction of all points in contact.
    pub fn total(&self) -> f64 {
        self.elastic + self.plastic
    }
}

/// Returns the probability that a walk of variance `spread` from `start` between 0 and 1 has reached 1 and not 0
/// before, by images of the start beyond both ends.
fn hits(start: f64, spread: f64) -> f64 {
    let width = (2.0 * spread).sqrt();
    let beyond = |distance: f64| if width > 0.0 { libm::erfc(distance / width) } else { 0.0 };
    let term = |k: i32| {
        let odd = f64::from(2 * k + 1);
        beyond(odd - start) - beyond(odd + start)
    };
    (0..TERMS).map(term).sum()
}

/// Returns the probability of [`hits`] as a sine series on the interval.
fn sines(start: f64, spread: f64) -> f64 {
    let term = |n: i32| {
        let wave = f64::from(n) * PI;
        let sign = if n % 2 == 0 { -1.0 } else { 1.0 };
        sign * (2.0 / wave) * (wave * start).sin() * (-0.5 * wave * wave * spread).exp()
    };
    start - (1..TERMS).map(term).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::super::{persson_area, quadrature::gauss_legendre};
    use super::*;

    /// Returns the pressure density between the ends as a sine series (Persson 2001, eq. 22), an independent form.
    fn density(pressure: f64, mean: f64, variance: f64, hardness: f64) -> f64 {
        let term = |n: i32| {
            let wave = f64::from(n) * PI / hardness;
            (wave * mean).sin() * (wave * pressure).sin() * (-0.5 * wave * wave * variance).exp()
        };
        2.0 / hardness * (1..400).map(term).sum::<f64>()
    }

    #[test]
    fn the_areas_are_integrals_of_the_density_and_of_its_flux() {
        let hardness = 0.7;
        for (mean, variance) in [(0.05, 0.01), (0.2, 0.02), (0.2, 0.3), (0.5, 0.1), (0.65, 2.0), (0.01, 0.5)] {
            let found = ElastoplasticArea::new(mean, variance, hardness);
            let nodes = gauss_legendre(200, [0.0, hardness]);
            let elastic: f64 = nodes.iter().map(|(p, w)| w * density(*p, mean, variance, hardness)).sum();
            assert_relative_eq!(found.elastic, elastic, epsilon = 1e-12, max_relative = 1e-10);
            // The flux into the hardness is half the slope there; it begins slowly.
            let flux = |v: f64| {
                let term = |n: i32| {
                    let wave = f64::from(n) * PI / hardness;
                    wave * (wave * mean).sin() * (wave * hardness).cos() * (-0.5 * wave * wave * v).exp()
                };
                -1.0 / hardness * (1..400).map(term).sum::<f64>()
            };
            let start = 0.015 * (hardness - mean).powi(2);
            let ends = (0..20).map(|k| (start * 4_f64.powi(k)).min(variance)).collect::<Vec<_>>();
            let piece = |ends: &[f64]| -> f64 {
                gauss_legendre(60, [ends[0], ends[1]]).iter().map(|(v, w)| w * flux(*v)).sum()
            };
            let plastic: f64 = ends.windows(2).map(piece).sum();
            assert_relative_eq!(found.plastic, plastic, epsilon = 1e-10, max_relative = 1e-9);
            // Elastic and plastic points bear the load together.
            let load: f64 = nodes.iter().map(|(p, w)| w * p * density(*p, mean, variance, hardness)).sum();
            assert_relative_eq!(load + hardness * found.plastic, mean, max_relative = 1e-10);
        }
    }

    #[test]
    fn both_series_agree_and_end_in_the_limits() {
        for share in [0.01, 0.3, 0.9] {
            for spread in [0.1, 0.5, 2.0] {
                assert_relative_eq!(hits(share, spread), sines(share, spread), epsilon = 1e-14);
            }
        }
        // Hard: Persson's elastic area. Rough: the whole contact is plastic and bears the load.
        for p_star in [0.01, 0.1, 0.5] {
            let hard = ElastoplasticArea::new(p_star, 0.25, 100.0);
            assert_relative_eq!(hard.total(), persson_area(p_star), epsilon = 1e-14);
            assert!(hard.plastic == 0.0);
            let soft = ElastoplasticArea::new(0.01 * p_star, 0.25, 0.01);
            assert_relative_eq!(soft.plastic, p_star, max_relative = 1e-12);
            assert!(soft.elastic.abs() < 1e-12);
        }
        let smooth = ElastoplasticArea::new(0.1, 0.0, 1.0);
        assert_eq!((smooth.elastic, smooth.plastic), (1.0, 0.0));
    }
}
