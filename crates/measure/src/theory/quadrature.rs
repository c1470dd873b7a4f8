//! Numerical integration.

use std::f64::consts::PI;

/// Returns nodes and weights of the Gauss–Legendre rule with `count` nodes on an interval, ascending.
pub(super) fn gauss_legendre(count: usize, interval: [f64; 2]) -> Vec<(f64, f64)> {
    scaled(&unit_rule(count).collect::<Vec<_>>(), interval).collect()
}

/// Maps the nodes and weights of a rule on [-1, 1] to an interval.
pub(super) fn scaled(rule: &[(f64, f64)], [low, high]: [f64; 2]) -> impl Iterator<Item = (f64, f64)> {
    let half = 0.5 * (high - low);
    rule.iter().map(move |(x, weight)| (low + half * (1.0 + x), half * weight))
}

/// Returns the Gauss–Legendre rule on [-1, 1].
pub(super) fn unit_rule(count: usize) -> impl Iterator<Item = (f64, f64)> {
    (0..count).rev().map(move |k| {
        let mut x = (PI * (k as f64 + 0.75) / (count as f64 + 0.5)).cos();
        let mut slope = 1.0;
        // Newton's iteration on the polynomial; ten steps suffice for any count.
        for _ in 0..10 {
            let [mut value, mut before] = [1.0, 0.0];
            for n in 0..count {
                let n = n as f64;
                [value, before] = [((2.0 * n + 1.0) * x * value - n * before) / (n + 1.0), value];
            }
            slope = count as f64 * (x * value - before) / (x * x - 1.0);
            x -= value / slope;
        }
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_up_to_twice_the_count_are_exact() {
        for count in [1, 2, 5, 24, 80] {
            for degree in [0, 1, 2 * count as i32 - 1] {
                let sum: f64 = gauss_legendre(count, [0.0, 1.0]).iter().map(|(x, w)| w * x.powi(degree)).sum();
                assert!((sum * f64::from(degree + 1) - 1.0).abs() < 1e-12, "{count} {degree}: {sum}");
            }
        }
    }
}
