//! kappa of one surface, from its contact areas at all loads.

use crate::config::Estimator;
use crate::{Config, Pressed};

impl Estimator {
    /// Returns kappa at load `load`, or over all loads, from `kappa` at each load.
    pub(crate) fn kappa(self, loads: &[Pressed], load: usize, kappa: &dyn Fn(&Pressed) -> f64) -> f64 {
        match self {
            Self::Ratio => kappa(&loads[load]),
            Self::Slope => slope(loads.iter().map(|load| {
                let p_star = load.summary.p_star;
                // The kappa of a pair is a_r/p*.
                (p_star, kappa(load) * p_star)
            })),
        }
    }
}

impl Config {
    /// Returns the fitted loads; the slope over all loads is fitted once, under the load of the result.
    pub(crate) fn fitted_loads(&self) -> Vec<usize> {
        let all = 0..self.loads.p_star.len();
        match self.fit.estimator {
            Estimator::Ratio => all.collect(),
            Estimator::Slope => all.filter(|load| self.loads.p_star[*load] == self.fit.p_star).collect(),
        }
    }
}

/// Returns the slope of the least-squares line through pairs (x, y); NaN for fewer than two different x.
fn slope(pairs: impl Iterator<Item = (f64, f64)> + Clone) -> f64 {
    let count = pairs.clone().count() as f64;
    let mean = |of: fn((f64, f64)) -> f64| pairs.clone().map(of).sum::<f64>() / count;
    let [x0, y0] = [mean(|(x, _)| x), mean(|(_, y)| y)];
    let (mut xx, mut xy) = (0.0, 0.0);
    for (x, y) in pairs {
        xx += (x - x0) * (x - x0);
        xy += (x - x0) * (y - y0);
    }
    if xx > 0.0 { xy / xx } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_is_that_of_a_line_and_of_the_normal_equations() {
        let line = (0..5).map(|i| (0.001 * f64::from(i), 0.3 + 2.5 * 0.001 * f64::from(i)));
        approx::assert_relative_eq!(slope(line), 2.5, max_relative = 1e-12);
        // y = x² at 0, 1, 2, 3: slope 3 (normal equations by hand).
        approx::assert_relative_eq!(slope((0..4).map(|i| (f64::from(i), f64::from(i * i)))), 3.0, max_relative = 1e-14);
        assert!(slope([(1.0, 2.0), (1.0, 3.0)].into_iter()).is_nan());
    }
}
