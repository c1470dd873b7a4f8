//! Search for the loosest tolerance of a program with a certified result, since its meaning differs between programs.

/// Solve that was certified.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Found<T> {
    /// Tolerance given to the program.
    pub(super) tolerance: f64,
    /// Certified residual.
    pub(super) residual: f64,
    /// Result of the solve.
    pub(super) solve: T,
}

/// Factor on the bound in the search for the tolerance of a peer: residuals of repeated solves differ by rounding.
pub(super) const MARGIN: f64 = 0.98;

/// Smallest accepted residual as a fraction of the target: one order of magnitude costs these methods about a tenth of
/// their iterations.
const CLOSE: f64 = 0.3;

/// Fraction of the target at which the next guess aims.
const AIM: f64 = 0.7;

/// Ratio of the smallest failing to the largest passing tolerance at which the search ends.
const NARROW: f64 = 1.3;

/// Largest ratio of the next guess to the last one after a second failure: since iterations are discrete, many
/// tolerances may give the same residual.
const STRIDE: f64 = 0.2;

/// Largest number of solves, after which the loosest passing tolerance is taken.
const TRIALS: usize = 12;

/// Searches from `first`. `solve` maps a tolerance to the certified residual and a result; residuals are roughly
/// proportional to tolerances. Returns `None` if no result was certified.
pub(super) fn loosest<T, E>(
    target: f64,
    first: f64,
    mut solve: impl FnMut(f64) -> Result<(f64, T), E>,
) -> Result<Option<Found<T>>, E> {
    let mut passed: Option<Found<T>> = None;
    let mut failed: Option<f64> = None;
    let mut tolerance = first;
    for _ in 0..TRIALS {
        let (residual, solve) = solve(tolerance)?;
        let factor = (AIM * target / residual).clamp(1e-3, 1e3);
        if residual <= target {
            passed = Some(Found { tolerance, residual, solve });
            if residual >= CLOSE * target {
                break;
            }
            tolerance *= factor;
        } else {
            let again = failed.replace(tolerance).is_some();
            // `min` also handles a NaN residual.
            tolerance *= factor.min(if again { STRIDE } else { 1.0 });
        }
        if let (Some(passed), Some(failed)) = (&passed, failed) {
            if failed <= NARROW * passed.tolerance {
                break;
            }
            if !(passed.tolerance < tolerance && tolerance < failed) {
                tolerance = (passed.tolerance * failed).sqrt();
            }
        }
    }
    Ok(passed)
}
