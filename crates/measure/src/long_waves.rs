//! Contact of an infinitely large self-affine surface, from contacts of surfaces with a longest wave.

use std::f64::consts::{PI, SQRT_2};

use statrs::function::erf::{erf, erf_inv, erfc};

use crate::theory::persson_area;

/// Composition with the waves longer than the longest one of a simulated surface, by Persson's theory (theory.md,
/// section 11).
///
/// The long waves spread the pressure p̄ into a distribution P(σ) with absorption at σ = 0. Under a local pressure σ,
/// the simulated short waves have the contact area a(σ). Hence a_∞(p̄) = ∫ P(σ) a(σ) dσ. The long waves have the
/// spectrum of the full surface at another scale, so that P has the contact area a_∞ itself and, with
/// [`LongWaves::with_moments`], the second moment of the infinite surface. No parameter is fitted.
///
/// The result is linear in the simulated κ. The value stores the weights, which apply to means and to single surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct LongWaves {
    weights: Vec<Vec<f64>>,
    full: Vec<f64>,
}

/// Lower bound of the largest p*. There the contact is nearly full; P extends beyond p̄.
pub const LEAST_LARGEST_LOAD: f64 = 1.0;

/// Largest ratio of neighbouring loads for the interpolation of κ.
const WIDEST: f64 = 3.0;

/// Half the range of the integral in widths of P, and the number of intervals.
const REACH: f64 = 8.0;
const INTERVALS: usize = 512;

/// Contact area fraction above which its distance from one is too small to measure.
const FULL: f64 = 0.98;

/// Relative change of κ at which the width is consistent.
const CONSISTENT: f64 = 1e-12;

/// Contact area fraction beyond which area and mean square pressure do not determine two widths. Above it the spread is
/// kept, and the mean square pressure gives the width.
const HALF: f64 = 0.5;

/// Largest δ of two widths w (1 ± δ); contacts have about 1/4.
const LARGEST_SPREAD: f64 = 0.5;

/// Largest number of steps to a root, and the value that counts as zero.
const MOST_STEPS: usize = 100;
const VANISHES: f64 = 1e-15;

impl LongWaves {
    /// Computes the weights for contacts at the reduced pressures `p_star` with the mean coefficients `kappa`, if the
    /// missing waves have `missing` times the mean square gradient of the surfaces. P is Persson's distribution, a
    /// Gaussian minus its mirror image, with the width that gives the contact area a_∞.
    ///
    /// Returns `None` if `p_star` has fewer than four loads, does not ascend, ends below [`LEAST_LARGEST_LOAD`] or has
    /// gaps of more than a factor of 3; if a κ is not positive; if `missing` is negative or not finite.
    pub fn new(p_star: &[f64], kappa: &[f64], missing: f64) -> Option<Self> {
        Self::consistent(p_star, kappa, None, missing)
    }

    /// Computes the weights as [`LongWaves::new`], with a measured shape of P: `moments` are the mean square pressures
    /// ⟨p²⟩/(E* g)² of the contacts. P is the mean of two of Persson's distributions, of widths w (1 ± δ), with the
    /// contact area and the mean square pressure of the infinite surface. A single one of Persson's distributions has a
    /// smaller mean square pressure.
    ///
    /// Returns `None` as [`LongWaves::new`], and if a moment is not above p*².
    pub fn with_moments(p_star: &[f64], kappa: &[f64], moments: &[f64], missing: f64) -> Option<Self> {
        let good =
            moments.len() == p_star.len() && moments.iter().zip(p_star).all(|(m, p)| m.is_finite() && *m > p * p);
        if good { Self::consistent(p_star, kappa, Some(moments), missing) } else { None }
    }

    fn consistent(p_star: &[f64], kappa: &[f64], moments: Option<&[f64]>, missing: f64) -> Option<Self> {
        let positive = |values: &[f64]| values.iter().all(|x| x.is_finite() && *x > 0.0);
        let good = Self::suits(p_star) && kappa.len() == p_star.len() && positive(kappa);
        if !(good && missing >= 0.0 && missing.is_finite()) {
            return None;
        }
        let mut limit = Limit { kappa: kappa.to_vec(), moments: moments.map(<[f64]>::to_vec) };
        let mut found = Self { weights: Vec::new(), full: Vec::new() };
        for _ in 0..100 {
            let integrals = Integrals::new(p_star, missing, &limit);
            found = integrals.of(p_star, &AREA);
            let next: Vec<f64> = (0..p_star.len()).map(|load| found.compose(load, |j| kappa[j])).collect();
            let change = next.iter().zip(&limit.kappa).fold(0.0_f64, |far, (a, b)| far.max((a / b - 1.0).abs()));
            limit.kappa = next;
            if let (Some(moments), Some(limit)) = (moments, &mut limit.moments) {
                let squares = integrals.of(p_star, &SQUARE);
                *limit = (0..p_star.len()).map(|load| squares.compose(load, |j| moments[j])).collect();
            }
            if change <= CONSISTENT {
                break;
            }
        }
        Some(found)
    }

    /// Returns true if the loads ascend, reach far enough and lie close enough together.
    pub fn suits(p_star: &[f64]) -> bool {
        let ascends = p_star.windows(2).all(|pair| pair[0] > 0.0 && pair[0] < pair[1] && pair[1] <= WIDEST * pair[0]);
        p_star.len() >= 4
            && ascends
            && p_star.last().is_some_and(|last| *last >= LEAST_LARGEST_LOAD && last.is_finite())
    }

    /// Returns κ of the infinite surface at load number `load`, from κ of the simulated surface at all loads.
    pub fn compose(&self, load: usize, kappa: impl Fn(usize) -> f64) -> f64 {
        self.full[load] + self.compose_difference(load, kappa)
    }

    /// Composes a difference of two κ; see [`LongWaves::compose`].
    pub fn compose_difference(&self, load: usize, difference: impl Fn(usize) -> f64) -> f64 {
        self.weights[load].iter().enumerate().map(|(j, weight)| weight * difference(j)).sum()
    }
}

/// Results for the infinite surface at the given loads.
struct Limit {
    kappa: Vec<f64>,
    moments: Option<Vec<f64>>,
}

/// Contact quantity in Persson's theory. The ratio of the contact to the theory is interpolated.
struct Reference {
    /// Value at p* in Persson's theory.
    value: fn(f64) -> f64,
    /// Scale of the datum: value divided by datum at p*.
    scale: fn(f64) -> f64,
    /// Unit in terms of the gradient of all waves, for a mean square gradient of the simulated waves that is smaller by
    /// the factor 1 + missing.
    unit: fn(f64) -> f64,
}

/// Contact area, given as κ = a/p*.
const AREA: Reference = Reference { value: persson_area, scale: |p_star| p_star, unit: |_| 1.0 };

/// Mean square pressure divided by (E* g)².
const SQUARE: Reference = Reference { value: persson_square, scale: |_| 1.0, unit: |missing| 1.0 / (1.0 + missing) };

/// Returns ⟨p²⟩/(E* g)² of Persson's distribution, of width 1/2.
fn persson_square(p_star: f64) -> f64 {
    square(p_star, 0.5)
}

/// Returns the second moment, over positive pressures, of a Gaussian about `pressure` minus its mirror image.
fn square(pressure: f64, width: f64) -> f64 {
    let ratio = pressure / width;
    (pressure * pressure + width * width) * erf(ratio / SQRT_2)
        + pressure * width * (2.0 / PI).sqrt() * (-0.5 * ratio * ratio).exp()
}

/// P(σ) dσ at nodes, load by load.
struct Integrals {
    missing: f64,
    nodes: Vec<Vec<(f64, f64)>>,
}

impl Integrals {
    /// Computes the distributions that give the long waves the contact area and the mean square pressure of `limit`.
    fn new(p_star: &[f64], missing: f64, limit: &Limit) -> Self {
        let nodes = p_star.iter().map(|&load| {
            // In units of E* times the gradient of the simulated waves.
            let pressure = load * (1.0 + missing).sqrt();
            let of_long_waves = pressure / missing.sqrt();
            let widths = limit.widths(p_star, of_long_waves).map(|width| width * missing.sqrt());
            match widths {
                [one, other] if one == other => distribution(pressure, one, 1.0),
                [one, other] => {
                    let mut both = distribution(pressure, one, 0.5);
                    both.extend(distribution(pressure, other, 0.5));
                    both
                }
            }
        });
        Self { missing, nodes: nodes.collect() }
    }

    /// Returns the weights of a contact quantity.
    fn of(&self, p_star: &[f64], reference: &Reference) -> LongWaves {
        let rows = p_star.iter().zip(&self.nodes).map(|(&load, nodes)| {
            let mut weights = vec![0.0; p_star.len()];
            let mut full = 0.0;
            let unit = (reference.unit)(self.missing) / (reference.scale)(load);
            for &(sigma, chance) in nodes {
                full += share(p_star, sigma, chance * unit, reference, &mut weights);
            }
            (weights, full)
        });
        let (weights, full) = rows.unzip();
        LongWaves { weights, full }
    }
}

impl Limit {
    /// Returns the widths of the two pressure distributions of the long waves at their reduced pressure `load`, in
    /// units of E* times their gradient.
    fn widths(&self, p_star: &[f64], load: f64) -> [f64; 2] {
        let width = |load: f64| 0.5 / sharpness(p_star, &self.kappa, load);
        let Some(moments) = self.moments.as_ref().filter(|_| load.is_finite()) else { return [width(load); 2] };
        let wanted = |load: f64| persson_square(load) * ratio(p_star, moments, load);
        let pair = |mean: f64, spread: f64| [mean * (1.0 - spread), mean * (1.0 + spread)];
        let mean_of = |pair: [f64; 2], of: &dyn Fn(f64) -> f64| 0.5 * (of(pair[0]) + of(pair[1]));
        // Returns two widths of this spread with the area of `width`.
        let of_area = |load: f64, spread: f64| {
            let (area, width) = (|width: f64| erf(load / (SQRT_2 * width)), width(load));
            let ends = [width * (1.0 - spread), width / (1.0 - spread * spread)];
            pair(root(ends, |mean| mean_of(pair(mean, spread), &area) - area(width)), spread)
        };
        let half = root([p_star[0], p_star[p_star.len() - 1]], |load| HALF - erf(load / (SQRT_2 * width(load))));
        let at = load.min(half);
        let lacks = |pair: [f64; 2]| wanted(at) - mean_of(pair, &|width| square(at, width));
        let spread = root([0.0, LARGEST_SPREAD], |spread| lacks(of_area(at, spread)));
        if load <= half {
            return of_area(load, spread);
        }
        let ends = [1e-3 * width(load), 10.0 * width(load)];
        let lacks = |mean: f64| wanted(load) - mean_of(pair(mean, spread), &|width| square(load, width));
        pair(root(ends, lacks), spread)
    }
}

/// Returns the root of a falling function between two ends by false position (Illinois), or the end nearest to it.
fn root([mut low, mut high]: [f64; 2], falls: impl Fn(f64) -> f64) -> f64 {
    let (mut at_low, mut at_high) = (falls(low), falls(high));
    if at_low <= 0.0 {
        return low;
    } else if at_high >= 0.0 {
        return high;
    }
    let mut middle = low;
    for _ in 0..MOST_STEPS {
        middle = (low * at_high - high * at_low) / (at_high - at_low);
        let value = falls(middle);
        if value.abs() <= VANISHES {
            break;
        } else if value > 0.0 {
            (low, at_low, at_high) = (middle, value, 0.5 * at_high);
        } else {
            (high, at_high, at_low) = (middle, value, 0.5 * at_low);
        }
    }
    middle
}

/// Returns P(σ) dσ times `part` at the nodes of the trapezoidal rule: a Gaussian minus its mirror image at σ = 0.
fn distribution(pressure: f64, width: f64, part: f64) -> Vec<(f64, f64)> {
    if width < 1e-9 * pressure {
        return vec![(pressure, part)];
    }
    let low = (pressure - REACH * width).max(0.0);
    let step = (pressure + REACH * width - low) / INTERVALS as f64;
    let normal = |x: f64| (-0.5 * (x / width).powi(2)).exp() / ((2.0 * PI).sqrt() * width);
    let node = |k: usize| {
        let sigma = low + step * k as f64;
        (sigma, part * step * (normal(sigma - pressure) - normal(sigma + pressure)))
    };
    // The ends contribute nothing: P vanishes at σ = 0 and is below 1e-14 of its height at the other ends.
    (1..INTERVALS).map(node).collect()
}

/// Adds `factor` times a contact quantity at `sigma` to the weights of the data of all loads and returns the part
/// without data. The ratio to Persson's theory is interpolated by a cubic in the logarithm. Below the first load it
/// follows the parabola through the first three loads, linear at first touch; beyond the last load it tends to one.
fn share(p_star: &[f64], sigma: f64, factor: f64, reference: &Reference, weights: &mut [f64]) -> f64 {
    let (last, persson) = (p_star.len() - 1, factor * (reference.value)(sigma));
    let of_datum = |j: usize| (reference.scale)(p_star[j]) / (reference.value)(p_star[j]);
    if sigma >= p_star[last] {
        let fades = erfc(SQRT_2 * sigma) / erfc(SQRT_2 * p_star[last]);
        weights[last] += persson * fades * of_datum(last);
        return persson * (1.0 - fades);
    }
    let light = sigma < p_star[0];
    let along = |p: f64| if light { p } else { p.ln() };
    let nodes = if light {
        0..3
    } else {
        let first = p_star.partition_point(|p| *p < sigma).saturating_sub(2).min(p_star.len() - 4);
        first..first + 4
    };
    for j in nodes.clone() {
        let others = nodes.clone().filter(|k| *k != j);
        let part = |k: usize| (along(sigma) - along(p_star[k])) / (along(p_star[j]) - along(p_star[k]));
        weights[j] += persson * others.map(part).product::<f64>() * of_datum(j);
    }
    0.0
}

/// Returns the ratio of the mean square pressure to Persson's at any load, from the given loads: linear in the
/// logarithm between them, constant below, and tending to one beyond.
fn ratio(p_star: &[f64], moments: &[f64], load: f64) -> f64 {
    let at = |j: usize| moments[j] / persson_square(p_star[j]);
    match p_star.partition_point(|p| *p < load) {
        0 => at(0),
        j if j == p_star.len() => 1.0 + (at(j - 1) - 1.0) * erfc(SQRT_2 * load) / erfc(SQRT_2 * p_star[j - 1]),
        j => {
            let part = (load / p_star[j - 1]).ln() / (p_star[j] / p_star[j - 1]).ln();
            at(j - 1) + part * (at(j) - at(j - 1))
        }
    }
}

/// Returns q of a_∞ = erf(√2 q p*) at any load, from κ at the given loads, linear in the logarithm between them. Areas
/// above [`FULL`] do not determine q; the last load below gives it.
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

    /// A distribution that is narrower at all scales is Persson's with a smaller width, also a fixed point.
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

    /// If the long waves are far too small for this load, they are in full contact: a_∞ = a + V a''/2, for all waves.
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
    fn two_widths_have_the_area_and_the_mean_square_pressure_of_the_limit() {
        let kappa: Vec<f64> = LOADS.iter().map(|p| libm::erf(SQRT_2 * 1.15 * p) / p).collect();
        for (load, excess) in [(0.02, 0.0), (0.05, 0.066), (0.25, 0.04), (0.7, 0.01), (1.4, 0.001)] {
            let squares: Vec<f64> = LOADS.iter().map(|p| square(*p, 0.5 / 1.15) * (1.0 + excess)).collect();
            let limit = Limit { kappa: kappa.clone(), moments: Some(squares.clone()) };
            let [low, high] = limit.widths(&LOADS, load);
            let mean = |of: &dyn Fn(f64) -> f64| 0.5 * (of(low) + of(high));
            let area = mean(&|width| libm::erf(load / (SQRT_2 * width)));
            let allowed = if load < 0.3 { 1e-6 } else { 0.05 };
            assert!((area / libm::erf(SQRT_2 * 1.15 * load) - 1.0).abs() < allowed, "{load}: {low} {high} {area}");
            let wanted = persson_square(load) * ratio(&LOADS, &squares, load);
            assert!((mean(&|width| square(load, width)) / wanted - 1.0).abs() < 1e-6, "{load}: {low} {high}");
            assert!((high > 1.05 * low) == (excess > 0.0), "{load}: {low} {high}");
        }
    }

    /// The moments of Persson's distribution keep its area; a larger mean square pressure lowers the area.
    #[test]
    fn a_wider_distribution_of_the_pressure_has_less_area() {
        let area = |p: f64| libm::erf(SQRT_2 * p) * (1.0 + 0.3 * (-3.0 * p).exp());
        for missing in [1e-4, 0.01, 0.1, 0.5] {
            let of = |area: &dyn Fn(f64) -> f64, excess: f64| -> Vec<f64> {
                let kappa: Vec<f64> = LOADS.iter().map(|p| area(*p) / p).collect();
                let squares: Vec<f64> =
                    LOADS.iter().map(|p| persson_square(*p) * (1.0 + excess * (-2.0 * p * p).exp())).collect();
                let waves = LongWaves::with_moments(&LOADS, &kappa, &squares, missing).unwrap();
                (0..LOADS.len()).map(|load| waves.compose(load, |j| kappa[j])).collect()
            };
            for (found, p) in of(&persson_area, 0.0).iter().zip(LOADS) {
                assert!((found * p / persson_area(p) - 1.0).abs() < 1e-6, "{missing} {p}");
            }
            let mirror = composed(&LOADS, area, missing);
            let [wide, wider] = [0.15, 0.3].map(|excess| of(&area, excess));
            assert!(
                missing < 0.01 || (wide[0] < mirror[0] && wider[0] < wide[0]),
                "{missing}: {mirror:?} {wide:?} {wider:?}"
            );
        }
        let kappa = [2.0; 7];
        assert!(LongWaves::with_moments(&LOADS, &kappa, &[0.0; 7], 0.1).is_none());
    }

    /// The curve continues below the first load.
    #[test]
    fn loads_below_the_first_are_not_those_of_the_first() {
        let area = |p: f64| libm::erf(SQRT_2 * p) * (1.0 + 0.4 / (1.0 + 8.0 * p) * (-p * p).exp());
        let dense: Vec<f64> = (0..=140).map(|k| 0.0005 * 3000.0_f64.powf(f64::from(k) / 140.0)).collect();
        let few = [0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.2];
        for missing in [1e-4, 1e-3, 0.01] {
            let near = dense.iter().position(|p| *p >= 0.02).unwrap();
            let [from_few, from_many] = [composed(&few, area, missing)[0], composed(&dense, area, missing)[near]];
            let apart = from_few / from_many - 1.0 - (area(0.02) / 0.02 / (area(dense[near]) / dense[near]) - 1.0);
            assert!(apart.abs() < 1e-3, "{missing}: {from_few} {from_many}");
        }
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
