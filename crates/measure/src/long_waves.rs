//! The contact of a self-affine surface without end, from contacts of surfaces whose spectrum ends at a longest wave.

use std::f64::consts::{PI, SQRT_2};

use statrs::function::erf::{erf_inv, erfc};

use crate::theory::persson_area;

/// Waves longer than the longest one of a simulated surface, added by Persson's theory (theory.md, section 11).
///
/// They spread the pressure p̄ into a distribution P(σ) with absorption at σ = 0; where they press with σ, the simulated
/// short waves have the contact area a(σ). Hence a_∞(p̄) = ∫ P(σ) a(σ) dσ. The width of P is that with which the long waves
/// have the contact area a_∞ themselves, since they have the spectrum of the whole: V/q², where V = (E* g_l/2)² and
/// a_∞(p*) = erf(√2 q p*). No parameter is fitted.
///
/// The result is linear in the simulated κ, with weights that this value holds, so that it applies to means and to single
/// surfaces alike.
#[derive(Clone, Debug, PartialEq)]
pub struct LongWaves {
    weights: Vec<Vec<f64>>,
    full: Vec<f64>,
}

/// The largest p* must be at least this, where the contact is nearly full: P reaches beyond p̄.
pub const LEAST_LARGEST_LOAD: f64 = 1.0;

/// The largest ratio of neighbouring loads between which κ is interpolated.
const WIDEST: f64 = 3.0;

/// Half the range of the integral over the width of P, and the number of intervals.
const REACH: f64 = 8.0;
const INTERVALS: usize = 512;

/// The contact area fraction above which its distance from one is too small to measure.
const FULL: f64 = 0.98;

/// The relative change of κ at which the width is consistent.
const CONSISTENT: f64 = 1e-12;

impl LongWaves {
    /// The weights for contacts at the reduced pressures `p_star` with the mean coefficients `kappa`, if the waves that the
    /// surfaces lack have `missing` times the mean square gradient that the surfaces have.
    ///
    /// `None` if `p_star` has fewer than four loads, does not ascend, ends below [`LEAST_LARGEST_LOAD`] or has gaps of more
    /// than a factor of 3; if a κ is not positive; if `missing` is negative or not finite.
    pub fn new(p_star: &[f64], kappa: &[f64], missing: f64) -> Option<Self> {
        let positive = |values: &[f64]| values.iter().all(|x| x.is_finite() && *x > 0.0);
        let good = Self::suits(p_star) && kappa.len() == p_star.len() && positive(kappa);
        if !(good && missing >= 0.0 && missing.is_finite()) {
            return None;
        }
        let mut limit = kappa.to_vec();
        let mut found = Self { weights: Vec::new(), full: Vec::new() };
        for _ in 0..100 {
            found = Self::with_widths(p_star, missing, &limit);
            let next: Vec<f64> = (0..p_star.len()).map(|load| found.compose(load, |j| kappa[j])).collect();
            let change = next.iter().zip(&limit).fold(0.0_f64, |far, (a, b)| far.max((a / b - 1.0).abs()));
            limit = next;
            if change <= CONSISTENT {
                break;
            }
        }
        Some(found)
    }

    /// True if the loads reach far and lie close enough.
    pub fn suits(p_star: &[f64]) -> bool {
        let ascends = p_star.windows(2).all(|pair| pair[0] > 0.0 && pair[0] < pair[1] && pair[1] <= WIDEST * pair[0]);
        p_star.len() >= 4
            && ascends
            && p_star.last().is_some_and(|last| *last >= LEAST_LARGEST_LOAD && last.is_finite())
    }

    /// κ of the surface without end at load number `load`, from κ of the simulated surface at all loads.
    pub fn compose(&self, load: usize, kappa: impl Fn(usize) -> f64) -> f64 {
        self.full[load] + self.compose_difference(load, kappa)
    }

    /// As [`LongWaves::compose`], for a difference of two κ.
    pub fn compose_difference(&self, load: usize, difference: impl Fn(usize) -> f64) -> f64 {
        self.weights[load].iter().enumerate().map(|(j, weight)| weight * difference(j)).sum()
    }

    /// The weights if the long waves have the contact area of `limit`.
    fn with_widths(p_star: &[f64], missing: f64, limit: &[f64]) -> Self {
        let rows = p_star.iter().map(|&load| {
            // In units of E* times the gradient of the simulated waves.
            let pressure = load * (1.0 + missing).sqrt();
            let of_long_waves = pressure / missing.sqrt();
            let width = 0.5 * missing.sqrt() / sharpness(p_star, limit, of_long_waves);
            let mut weights = vec![0.0; p_star.len()];
            let mut full = 0.0;
            for (sigma, chance) in distribution(pressure, width) {
                full += share(p_star, sigma, chance / load, &mut weights);
            }
            (weights, full)
        });
        let (weights, full) = rows.unzip();
        Self { weights, full }
    }
}

/// P(σ) dσ at the nodes of the trapezoidal rule; Gaussian less its mirror image at σ = 0.
fn distribution(pressure: f64, width: f64) -> Vec<(f64, f64)> {
    if width < 1e-9 * pressure {
        return vec![(pressure, 1.0)];
    }
    let low = (pressure - REACH * width).max(0.0);
    let step = (pressure + REACH * width - low) / INTERVALS as f64;
    let normal = |x: f64| (-0.5 * (x / width).powi(2)).exp() / ((2.0 * PI).sqrt() * width);
    let node = |k: usize| {
        let sigma = low + step * k as f64;
        (sigma, step * (normal(sigma - pressure) - normal(sigma + pressure)))
    };
    // Both ends carry nothing: P vanishes at σ = 0, and is below 1e-14 of its height at the others.
    (1..INTERVALS).map(node).collect()
}

/// Adds `factor` times the contact area at `sigma` to the weights of the κ of all loads and returns the part without κ. The
/// ratio to Persson's area is interpolated, a cubic in the logarithm; it tends to one beyond the last load.
fn share(p_star: &[f64], sigma: f64, factor: f64, weights: &mut [f64]) -> f64 {
    let (last, persson) = (p_star.len() - 1, factor * persson_area(sigma));
    let of_kappa = |j: usize| p_star[j] / persson_area(p_star[j]);
    if sigma >= p_star[last] {
        let fades = erfc(SQRT_2 * sigma) / erfc(SQRT_2 * p_star[last]);
        weights[last] += persson * fades * of_kappa(last);
        return persson * (1.0 - fades);
    }
    if sigma <= p_star[0] {
        weights[0] += persson * of_kappa(0);
        return 0.0;
    }
    let above = p_star.partition_point(|p| *p < sigma);
    let first = above.saturating_sub(2).min(p_star.len() - 4);
    for j in first..first + 4 {
        let others = (first..first + 4).filter(|k| *k != j);
        let basis: f64 = others.map(|k| (sigma / p_star[k]).ln() / (p_star[j] / p_star[k]).ln()).product();
        weights[j] += persson * basis * of_kappa(j);
    }
    0.0
}

/// q of a_∞ = erf(√2 q p*) at any load, from κ at the given ones; linear in the logarithm between them. Areas above
/// [`FULL`] do not determine q; the load before them gives it.
fn sharpness(p_star: &[f64], kappa: &[f64], load: f64) -> f64 {
    let count = (0..p_star.len()).take_while(|&j| kappa[j] * p_star[j] < FULL).count().max(1);
    let q = |j: usize| erf_inv((kappa[j] * p_star[j]).min(FULL)) / (SQRT_2 * p_star[j]);
    match p_star[..count].partition_point(|p| *p < load) {
        0 => q(0),
        j if j == count => q(j - 1),
        j => {
            let part = (load / p_star[j - 1]).ln() / (p_star[j] / p_star[j - 1]).ln();
            q(j - 1) + part * (q(j) - q(j - 1))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOADS: [f64; 7] = [0.01, 0.02, 0.05, 0.12, 0.3, 0.7, 1.5];

    fn composed(loads: &[f64], area: impl Fn(f64) -> f64, missing: f64) -> Vec<f64> {
        let kappa: Vec<f64> = loads.iter().map(|p| area(*p) / p).collect();
        let waves = LongWaves::new(loads, &kappa, missing).unwrap();
        (0..loads.len()).map(|load| waves.compose(load, |j| kappa[j])).collect()
    }

    #[test]
    fn the_area_of_persson_does_not_change() {
        for missing in [0.0, 1e-6, 0.01, 0.1, 0.5, 1.0] {
            let limit = composed(&LOADS, persson_area, missing);
            for (found, p) in limit.iter().zip(LOADS) {
                let expected = persson_area(p) / p;
                assert!((found / expected - 1.0).abs() < 1e-9, "{missing} {p}: {found} {expected}");
            }
        }
    }

    /// A narrower distribution at all scales is Persson's with a smaller width: it is a fixed point, too.
    #[test]
    fn any_constant_sharpness_is_a_fixed_point() {
        for sharpness in [0.8, 1.1, 1.3] {
            for missing in [0.01, 0.1, 0.5] {
                let area = |p: f64| libm::erf(SQRT_2 * sharpness * p);
                let loads: Vec<f64> = (0..13).map(|k| 0.01 * 1.6_f64.powi(k)).collect();
                let limit = composed(&loads, area, missing);
                for (found, p) in limit.iter().zip(loads).take(9) {
                    let expected = area(p) / p;
                    assert!((found / expected - 1.0).abs() < 1e-3, "{sharpness} {missing} {p}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn nothing_missing_changes_nothing() {
        let kappa = [2.4, 2.3, 2.1, 2.0, 1.7, 1.2, 0.66];
        let waves = LongWaves::new(&LOADS, &kappa, 0.0).unwrap();
        for (load, expected) in kappa.iter().enumerate() {
            assert!((waves.compose(load, |j| kappa[j]) - expected).abs() < 1e-12);
        }
    }

    /// Long waves far shorter than the load asks for are in full contact: a_∞ = a + V a''/2, in units of all waves.
    #[test]
    fn full_contact_of_the_long_waves_smooths_by_their_variance() {
        let area = |p: f64| libm::erf(SQRT_2 * p) * (1.0 + 0.3 * (-8.0 * p * p).exp());
        let dense: Vec<f64> = (0..60).map(|k| 0.01 * 1.1_f64.powi(k)).collect();
        let (load, missing, h) = (30, 1e-4, 1e-3);
        let p = dense[load];
        let kappa: Vec<f64> = dense.iter().map(|p| area(*p) / p).collect();
        let waves = LongWaves::new(&dense, &kappa, missing).unwrap();
        let change = waves.compose(load, |j| kappa[j]) * p - area(p);
        let q = sharpness(&dense, &kappa, p / missing.sqrt());
        let curvature = (area(p + h) - 2.0 * area(p) + area(p - h)) / (h * h);
        let slope = (area(p + h) - area(p - h)) / (2.0 * h);
        let expected = missing * (0.5 * p * slope + 0.125 * curvature / (q * q));
        assert!((change / expected - 1.0).abs() < 0.02, "{change:e} {expected:e}");
    }

    #[test]
    fn sparse_loads_give_what_dense_loads_give() {
        let area = |p: f64| libm::erf(SQRT_2 * p) * (1.0 + 0.4 / (1.0 + 6.0 * p) * (-p * p).exp());
        let dense: Vec<f64> = (0..=100).map(|k| 0.01 * 150.0_f64.powf(f64::from(k) / 100.0)).collect();
        for missing in [0.01, 0.1, 0.4] {
            let [few, many] = [composed(&LOADS, area, missing), composed(&dense, area, missing)];
            assert!((few[0] / many[0] - 1.0).abs() < 2e-3, "{missing}: {} {}", few[0], many[0]);
        }
    }

    #[test]
    fn unsuitable_loads_are_refused() {
        let kappa = [2.0; 7];
        assert!(LongWaves::new(&LOADS[..6], &kappa[..6], 0.1).is_none(), "ends below one");
        assert!(LongWaves::new(&[0.01, 0.02, 0.5, 1.5], &kappa[..4], 0.1).is_none(), "a gap");
        assert!(LongWaves::new(&[0.5, 1.0, 1.5], &kappa[..3], 0.1).is_none(), "too few");
        for missing in [-0.1, f64::NAN, f64::INFINITY] {
            assert!(LongWaves::new(&LOADS, &kappa, missing).is_none(), "{missing}");
        }
        assert!(LongWaves::new(&LOADS, &[2.0, f64::NAN, 2.0, 2.0, 2.0, 2.0, 2.0], 0.1).is_none());
    }
}
