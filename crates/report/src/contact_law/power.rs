//! Power law of the conductance.

use gfmd_fit::student_975;

/// Power law h = c p^m by least squares of the logarithms, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PowerLaw {
    /// Factor c, and the ends of its interval (95 %); without an interval for two loads.
    pub factor: f64,
    /// Interval of the factor.
    pub factor_ci95: Option<[f64; 2]>,
    /// Exponent m.
    pub exponent: f64,
    /// Interval of the exponent (95 %).
    pub exponent_ci95: Option<[f64; 2]>,
}

impl PowerLaw {
    /// Fits pairs of positive pressure and conductance.
    ///
    /// # Errors
    /// Returns the reason if there are fewer than two.
    pub(super) fn fit(points: &[(f64, f64)]) -> Result<Self, String> {
        let count = points.len();
        if count < 2 {
            return Err(format!("{count} load has a conductance; a power law needs two"));
        }
        let number = count as f64;
        let logarithms: Vec<[f64; 2]> = points.iter().map(|(p, h)| [p.ln(), h.ln()]).collect();
        let [x, y] = [0, 1].map(|k| logarithms.iter().map(|pair| pair[k]).sum::<f64>() / number);
        let sum = |a: usize, b: usize| -> f64 {
            logarithms.iter().map(|pair| (pair[a] - [x, y][a]) * (pair[b] - [x, y][b])).sum()
        };
        let (spread, exponent) = (sum(0, 0), sum(0, 1) / sum(0, 0));
        let constant = y - exponent * x;
        let misfit: f64 = logarithms.iter().map(|pair| (pair[1] - constant - exponent * pair[0]).powi(2)).sum();
        let freedom = number - 2.0;
        let half = (count > 2).then(|| {
            let variance = misfit / freedom;
            [(1.0 / number + x * x / spread), 1.0 / spread].map(|part| student_975(freedom) * (variance * part).sqrt())
        });
        Ok(Self {
            factor: constant.exp(),
            factor_ci95: half.map(|[half, _]| [(constant - half).exp(), (constant + half).exp()]),
            exponent,
            exponent_ci95: half.map(|[_, half]| [exponent - half, exponent + half]),
        })
    }
}
