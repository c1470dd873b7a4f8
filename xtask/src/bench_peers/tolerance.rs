//! The loosest tolerance of a program at which its result is certified: what each asks of itself differs in meaning.

/// A solve that was certified.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Found<T> {
    /// What the program was asked for.
    pub(super) tolerance: f64,
    /// The certified residual.
    pub(super) residual: f64,
    /// What the solve returned.
    pub(super) solve: T,
}

/// A residual between this part of the target and the target is close enough: one order less costs these methods about a
/// tenth of their iterations.
const CLOSE: f64 = 0.3;

/// Next guesses aim at this part of the target.
const AIM: f64 = 0.7;

/// A tolerance that passes and one that fails this near to each other end the search.
const NARROW: f64 = 1.3;

/// A method that stops at whole iterations may leave the same residual for many tolerances: after a second failure the
/// next guess is at most this part of the last one.
const STRIDE: f64 = 0.2;

/// Solves after which the loosest tolerance that passed is taken.
const TRIALS: usize = 12;

/// Searches from `first`. `solve` maps a tolerance to the certified residual and what else is wanted; residuals grow with
/// tolerances, roughly in proportion. `None` if no tolerance tried was enough.
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
            // `min` also takes care of a residual that is not a number.
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
