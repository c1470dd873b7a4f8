//! Quantiles for intervals.

use statrs::distribution::{ContinuousCDF, StudentsT};

/// Quantile 97.5 % of the standard normal distribution.
pub(crate) const NORMAL_975: f64 = 1.959_963_984_540_054;

/// Returns the 97.5 % quantile of Student's t. The degrees of freedom (at least one) need not be an integer.
pub fn student_975(freedom: f64) -> f64 {
    if freedom > 100.0 {
        // Fisher's expansion about the normal quantile is accurate to 2e-6 here; `statrs` does not terminate for large
        // degrees of freedom.
        let z = NORMAL_975;
        let cube = z * z * z;
        return z
            + (cube + z) / (4.0 * freedom)
            + (5.0 * cube * z * z + 16.0 * cube + 3.0 * z) / (96.0 * freedom * freedom);
    }
    StudentsT::new(0.0, 1.0, freedom.max(1.0)).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

/// Returns the factor on deviations with `freedom` degrees of freedom: Student's t divided by the normal quantile.
pub(crate) fn stretch(freedom: f64) -> f64 {
    student_975(freedom) / NORMAL_975
}

/// Returns the `level` quantile of sorted values, linear between neighbours.
pub(crate) fn quantile(sorted: &[f64], level: f64) -> f64 {
    let position = level * (sorted.len() - 1) as f64;
    let below = position.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (position - below as f64) * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_tables() {
        let tabulated = [(1.0, 12.706_205), (2.0, 4.302_653), (3.0, 3.182_446), (10.0, 2.228_139), (30.0, 2.042_272)];
        for (freedom, value) in tabulated {
            approx::assert_relative_eq!(student_975(freedom), value, max_relative = 1e-6);
        }
        approx::assert_relative_eq!(student_975(200.0), 1.971_896, max_relative = 1e-6);
        approx::assert_relative_eq!(student_975(100.000_1), student_975(99.999_9), max_relative = 2e-6);
        approx::assert_relative_eq!(student_975(1e9), NORMAL_975, max_relative = 1e-6);
        assert!(student_975(2.5) < student_975(2.0) && student_975(2.5) > student_975(3.0));
        assert_eq!([0.0, 0.25, 0.5, 1.0].map(|level| quantile(&[1.0, 2.0, 4.0], level)), [1.0, 1.5, 2.0, 4.0]);
    }
}
