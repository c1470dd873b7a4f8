use std::error::Error;
use std::fmt;

use gfmd_contact::{Solution, SolveError};
use gfmd_field::GridError;
use gfmd_fit::FitError;
use gfmd_surface::{Discretisation, SurfaceError};

/// Reasons why a sweep ends without a result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SweepError {
    /// Field of the configuration out of its range.
    #[error("{field} is {found}; it must be {allowed}")]
    Field {
        /// Name of the field: `surface.hurst`, `loads.p_star`, ...
        field: &'static str,
        /// Value found.
        found: String,
        /// Allowed values.
        allowed: String,
    },
    /// Property that no elastic body can have.
    #[error("{0}")]
    Body(String),
    /// Discretisation numbers without a whole number of points.
    #[error("points: {0}")]
    Points(#[source] SurfaceError),
    /// Number of points that no grid can have.
    #[error("points: {0}")]
    Grid(#[source] GridError),
    /// Surface that cannot be generated.
    #[error("{place}: {source}")]
    Surface {
        /// Realisation.
        place: Place,
        /// Reason.
        source: SurfaceError,
    },
    /// Contact that did not converge.
    #[error("{place}: {source}")]
    Contact {
        /// Realisation and load.
        place: Place,
        /// Reason.
        source: Box<SolveError<Solution>>,
    },
    /// Request of the caller to stop. Runs finished before are stored.
    #[error("interrupted at {0}")]
    Interrupted(Place),
    /// Finished run that could not be stored.
    #[error("{0}")]
    Keep(#[source] Box<dyn Error + Send + Sync>),
    /// Values of kappa without its edge, at the loads of one point, that do not allow composition with long waves.
    #[error(
        "H = {hurst}, 1/eps = ({}, {}, {}): kappa without its edge is {kappa:?}; it must be positive at all loads, or \
         fit.long_waves \"none\"",
        discretisation.eps_t_inv, discretisation.eps_f_inv, discretisation.eps_c_inv
    )]
    Composition {
        /// Hurst exponent.
        hurst: f64,
        /// Discretisation.
        discretisation: Discretisation,
        /// kappa at each load.
        kappa: Vec<f64>,
    },
    /// Points that do not determine the extrapolation model.
    #[error("fit: {0}")]
    Fit(#[source] FitError),
}

/// Contact of a sweep that a message refers to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Hurst exponent of the surface.
    pub hurst: f64,
    /// Discretisation of the surface.
    pub discretisation: Discretisation,
    /// Seed of the surface.
    pub seed: u64,
    /// Reduced pressure, if there is one yet.
    pub p_star: Option<f64>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Discretisation { eps_t_inv, eps_f_inv, eps_c_inv } = self.discretisation;
        write!(f, "H = {}, 1/eps = ({eps_t_inv}, {eps_f_inv}, {eps_c_inv}), seed {}", self.hurst, self.seed)?;
        self.p_star.map_or(Ok(()), |p_star| write!(f, ", p* = {p_star}"))
    }
}
