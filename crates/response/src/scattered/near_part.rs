//! Short-range part of the kernel 1/r, which vanishes beyond a radius.

use std::sync::LazyLock;

/// β of the window: a larger β leaves less of the long-range part beyond a wavenumber, but increases this wavenumber.
const BETA: f64 = 6.5;

/// Spacing of the table, and its last k, which exceeds the wavenumber of the shortest waves.
const STEP: f64 = 0.25;
const LAST: f64 = 48.0;

/// Number of terms of the window's series.
const TERMS: i32 = 24;

/// Number of intervals of the integration.
const STRETCHES: usize = 24;

/// Transforms the part (1 − Φ(r))/r of the kernel 1/r, which vanishes beyond r = 1: ∫₀¹ (1 − Φ(t)) J₀(k t) dt. Φ(t) is
/// the normalised integral from 0 to t of the Kaiser-Bessel window I₀(β √(1 − t²)).
pub(super) fn near_part(k: f64) -> f64 {
    static TABLE: LazyLock<Vec<f64>> = LazyLock::new(|| {
        let terms = terms();
        (-1..=(LAST / STEP) as i32 + 2).map(|i| transform(&terms, STEP * f64::from(i))).collect()
    });
    let place = k / STEP;
    let first = (place as usize).min((LAST / STEP) as usize);
    let t = place - first as f64;
    // Cubic Lagrange polynomial through the four values around k.
    let [a, b, c, d] = [0, 1, 2, 3].map(|i| TABLE[first + i]);
    let (below, above) = (1.0 + t, 2.0 - t);
    let outer = (a * above + d * below) * t * (1.0 - t) / -6.0;
    outer + (b * (1.0 - t) + c * t) * below * above / 2.0
}

/// Returns the points t of a three-point Gauss rule in each interval, and their weights times 1 − Φ.
fn terms() -> Vec<[f64; 2]> {
    let rule = [(-0.6_f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6_f64.sqrt(), 5.0 / 18.0)];
    let (width, all) = (1.0 / STRETCHES as f64, window_up_to(1.0));
    let points = (0..STRETCHES).flat_map(|i| rule.map(|(x, weight)| ((i as f64 + 0.5 * (1.0 + x)) * width, weight)));
    points.map(|(t, weight)| [t, width * weight * (1.0 - window_up_to(t) / all)]).collect()
}

fn transform(terms: &[[f64; 2]], k: f64) -> f64 {
    terms.iter().map(|[t, weight]| weight * libm::j0(k * t)).sum()
}

/// Computes ∫₀ᵗ I₀(β √(1 − u²)) du by the series of I₀.
fn window_up_to(t: f64) -> f64 {
    let (mut power, mut integral, mut factor, mut sum) = (1.0, t, 1.0, t);
    for n in 1..=TERMS {
        let n = f64::from(n);
        power *= 1.0 - t * t;
        integral = (t * power + 2.0 * n * integral) / (2.0 * n + 1.0);
        factor *= (BETA / (2.0 * n)).powi(2);
        sum += factor * integral;
    }
    sum
}
