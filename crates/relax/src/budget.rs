use std::ops::RangeInclusive;

/// Required accuracy and maximum effort of an iterative search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Largest allowed residual.
    pub tolerance: f64,
    /// Largest number of iterations or time steps.
    pub max_iterations: u64,
}

impl Default for Budget {
    /// Returns a tolerance of 1e-8 and at most 100 000 iterations.
    fn default() -> Self {
        Self { tolerance: 1e-8, max_iterations: 100_000 }
    }
}

impl Budget {
    /// Allowed tolerances. Smaller ones are below the rounding error; larger ones do not solve the problem.
    pub const TOLERANCES: RangeInclusive<f64> = 1e-15..=0.1;

    /// Checks the tolerance.
    ///
    /// # Errors
    /// Returns an error if the tolerance is outside [`TOLERANCES`](Self::TOLERANCES).
    pub fn check(&self) -> Result<(), ToleranceError> {
        let found = self.tolerance;
        if Self::TOLERANCES.contains(&found) { Ok(()) } else { Err(ToleranceError { found }) }
    }
}

/// Error of a tolerance outside [`Budget::TOLERANCES`].
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the tolerance is {found:e}; it must be between {:e} and {}",
    Budget::TOLERANCES.start(), Budget::TOLERANCES.end()
)]
pub struct ToleranceError {
    /// Tolerance found.
    pub found: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tolerances_beyond_the_range_and_nan_are_refused() {
        let check = |tolerance| Budget { tolerance, ..Budget::default() }.check();
        assert!([1e-15, 1e-8, 0.1].into_iter().all(|tolerance| check(tolerance).is_ok()));
        assert!([0.0, -1.0, 9e-16, 0.2, f64::NAN].into_iter().all(|tolerance| check(tolerance).is_err()));
        assert_eq!(check(1e-20).unwrap_err().to_string(), "the tolerance is 1e-20; it must be between 1e-15 and 0.1");
    }
}
