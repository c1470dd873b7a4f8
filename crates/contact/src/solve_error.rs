use std::error::Error;
use std::fmt;

use gfmd_relax::{Ending, RelaxError, ToleranceError, Why};

use crate::{Fields, Refusal};

/// Reason why a contact was not brought to rest, with the state reached, if any.
///
/// `Debug` prints the same message as `Display`: `main` and `unwrap` show it, and the fields of a state are long.
pub enum SolveError<S> {
    /// The input is invalid; no solve was started.
    Refused(Refusal),
    /// The residuals exceed the tolerance.
    NotConverged {
        /// State reached, with its residuals.
        state: Box<S>,
        /// Tolerance.
        asked: f64,
        /// Reason why the search ended.
        why: Why,
    },
    /// The watcher asked to stop.
    Interrupted {
        /// State reached, with its residuals.
        state: Box<S>,
    },
    /// The surfaces separate, because the attraction cannot balance the tensile load.
    Detached {
        /// State of the separation.
        state: Box<S>,
        /// Mean pressure, negative.
        mean_pressure: f64,
    },
}

impl<S> SolveError<S> {
    /// Returns the state reached, if there is one.
    pub fn state(&self) -> Option<&S> {
        match self {
            Self::Refused(_) => None,
            Self::NotConverged { state, .. } | Self::Interrupted { state } | Self::Detached { state, .. } => {
                Some(state)
            }
        }
    }

    /// Converts the error into the state reached, if there is one.
    pub fn into_state(self) -> Option<S> {
        match self {
            Self::Refused(_) => None,
            Self::NotConverged { state, .. } | Self::Interrupted { state } | Self::Detached { state, .. } => {
                Some(*state)
            }
        }
    }
}

impl<S> SolveError<S> {
    /// Applies `convert` to the state of the error.
    pub fn map<T>(self, convert: impl FnOnce(S) -> T) -> SolveError<T> {
        match self {
            Self::Refused(refusal) => SolveError::Refused(refusal),
            Self::NotConverged { state, asked, why } => {
                SolveError::NotConverged { state: convert(*state).into(), asked, why }
            }
            Self::Interrupted { state } => SolveError::Interrupted { state: convert(*state).into() },
            Self::Detached { state, mean_pressure } => {
                SolveError::Detached { state: convert(*state).into(), mean_pressure }
            }
        }
    }
}

impl<S> From<Refusal> for SolveError<S> {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

impl<S> From<RelaxError> for SolveError<S> {
    fn from(error: RelaxError) -> Self {
        Self::Refused(error.into())
    }
}

impl<S> From<ToleranceError> for SolveError<S> {
    fn from(error: ToleranceError) -> Self {
        Self::Refused(error.into())
    }
}

impl<S: Fields> SolveError<S> {
    /// Returns the error in words, with a mean pressure as `stress` writes it.
    pub fn words(&self, stress: impl FnOnce(f64) -> String) -> String {
        match self {
            Self::Refused(refusal) => refusal.to_string(),
            Self::NotConverged { state, asked, why } => {
                let iterations = state.effort().iterations;
                let left = residuals(&**state);
                format!("did not converge to {asked:e} in {iterations} iterations ({why}): {left}")
            }
            Self::Interrupted { state } => {
                format!("interrupted after {} iterations: {}", state.effort().iterations, residuals(&**state))
            }
            Self::Detached { mean_pressure, .. } => {
                let pressure = stress(*mean_pressure);
                format!("the surfaces part under a mean pressure of {pressure}: the attraction cannot balance the pull")
            }
        }
    }
}

impl<S: Fields> fmt::Display for SolveError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.words(|stress| stress.to_string()))
    }
}

impl<S: Fields> fmt::Debug for SolveError<S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl<S: Fields> Error for SolveError<S> {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        match self {
            Self::Refused(refusal) => refusal.source(),
            Self::NotConverged { .. } | Self::Interrupted { .. } | Self::Detached { .. } => None,
        }
    }
}

/// Lists the residuals in the form "complementarity 1.00e-9, penetration 0.00e0, …".
fn residuals(state: &impl Fields) -> String {
    let part = |(name, value): (&str, f64)| format!("{} {value:.2e}", name.replace('_', " "));
    state.residuals().into_iter().map(part).collect::<Vec<_>>().join(", ")
}

/// Returns the result of a search that ended at `state` with certified residuals. The residuals decide on convergence,
/// except that a search that diverged never counts as converged.
///
/// # Errors
/// A search that was interrupted, or a state that does not meet the tolerance.
pub fn judge<S: Fields>(state: S, ending: Ending, tolerance: f64) -> Result<S, SolveError<S>> {
    let met = state.worst() <= tolerance;
    match ending {
        Ending::Interrupted => Err(SolveError::Interrupted { state: Box::new(state) }),
        Ending::GaveUp(why @ Why::Diverged(_)) => {
            Err(SolveError::NotConverged { state: Box::new(state), asked: tolerance, why })
        }
        Ending::Converged | Ending::GaveUp(_) if met => Ok(state),
        Ending::Converged => {
            Err(SolveError::NotConverged { state: Box::new(state), asked: tolerance, why: Why::Certificate })
        }
        Ending::GaveUp(why) => Err(SolveError::NotConverged { state: Box::new(state), asked: tolerance, why }),
    }
}

#[cfg(test)]
mod tests {
    use gfmd_field::Grid;
    use gfmd_green::{Body, Material};
    use gfmd_relax::Divergence;
    use ndarray::Array2;

    use super::*;
    use crate::{Contact, Equilibrium, Load, Solution};

    /// Returns a solution that meets a tolerance of 1e-8.
    fn solved() -> Solution {
        let grid = Grid::square(8, 1.0).unwrap();
        let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap());
        let heights = Array2::from_shape_fn((8, 8), |(i, j)| 0.01 * ((3 * i + 5 * j) % 8) as f64);
        Contact::new(&body, &grid, &heights).unwrap().press(Load::MeanPressure(0.01)).solve().unwrap()
    }

    #[test]
    fn the_certificate_decides_but_not_over_a_divergence() {
        assert!(judge(solved(), Ending::Converged, 1e-8).is_ok());
        assert!(judge(solved(), Ending::GaveUp(Why::Iterations), 1e-8).is_ok());
        let diverged = Ending::GaveUp(Why::Diverged(Divergence::NotFinite));
        assert!(matches!(judge(solved(), diverged, 1e-8), Err(SolveError::NotConverged { why: Why::Diverged(_), .. })));
        assert!(matches!(judge(solved(), Ending::Interrupted, 1e-8), Err(SolveError::Interrupted { .. })));
        let unmet = judge(solved(), Ending::Converged, 0.0).unwrap_err();
        assert!(matches!(unmet, SolveError::NotConverged { why: Why::Certificate, .. }));
        assert!(unmet.to_string().starts_with("did not converge to 0e0 in"), "{unmet}");
        assert!(unmet.state().is_some() && unmet.into_state().is_some());
    }
}
