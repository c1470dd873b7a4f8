use std::sync::Arc;

use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_relax::Factors;
use gfmd_response::FullResponse;

use crate::{MixedError, Prescribed};

/// Solution methods. All find the same solution and differ in cost (docs/solvers.md).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Method {
    /// Conjugate gradients for the traction on the held entries, preconditioned by the stiffness restricted to them.
    #[default]
    ConjugateGradients,
    /// Damped position Verlet for the free displacement, with the optimal scalar damping and time step for the range of
    /// stiffnesses.
    Verlet,
    /// Damped position Verlet with the softest mode critically damped, as in the original method, and a quarter of the
    /// stable time step: [`Method::Damped`] with [`TIME_STEP`](Self::TIME_STEP) and the factor 1.
    VerletCritical,
    /// Damped position Verlet with a given time step and damping.
    Damped {
        /// Time step divided by the stability limit without damping, 2/√k_max.
        time_step: f64,
        /// Damping.
        damping: Factors,
    },
    /// Position Verlet with critical damping of every mode of the free surface (theory.md, section 6.2).
    VerletModes {
        /// Time step divided by the stability limit without damping; by default the best one for the range of
        /// stiffnesses.
        time_step: Option<f64>,
    },
    /// The fast inertial relaxation engine (Bitzek et al. 2006).
    Fire,
}

impl Method {
    /// Time step of [`Method::VerletCritical`] divided by the stability limit. The thesis gives Δt = 0.25 without a
    /// unit (docs/solvers.md).
    pub const TIME_STEP: f64 = 0.25;
}

/// Elastic body with the boundary conditions on its surface. A clone shares the response of the body.
#[derive(Clone, Debug)]
pub struct MixedProblem {
    pub(crate) response: Arc<FullResponse>,
    pub(crate) prescribed: Prescribed,
}

impl MixedProblem {
    /// Poses the problem on the surface of `body`.
    ///
    /// # Errors
    /// Prescribed values that do not fit the grid, hold nothing, or leave a mean traction undetermined.
    pub fn new(body: &Body, grid: &Grid, prescribed: Prescribed) -> Result<Self, MixedError> {
        Self::with_response(FullResponse::new(*grid, body), prescribed)
    }

    /// Poses the problem on an existing response, which many problems may share.
    ///
    /// # Errors
    /// Prescribed values that do not fit the grid, hold nothing, or leave a mean traction undetermined.
    pub fn with_response(response: impl Into<Arc<FullResponse>>, prescribed: Prescribed) -> Result<Self, MixedError> {
        let response = response.into();
        let [nx, ny] = response.grid().points();
        let (found, expected) = (prescribed.shape(), [response.components().len(), nx, ny]);
        if found != expected {
            return Err(MixedError::Shape { what: "prescribed values", found, expected });
        }
        let points = response.grid().len();
        let problem = Self { response, prescribed };
        if !problem.prescribed.held().contains(&true) {
            return Err(MixedError::NothingHeld);
        }
        for (component, held) in problem.prescribed.held().chunks_exact(points).enumerate() {
            if problem.floats(component) && !held.contains(&false) {
                return Err(MixedError::Undetermined { component });
            }
        }
        Ok(problem)
    }

    /// Returns the boundary conditions.
    pub fn prescribed(&self) -> &Prescribed {
        &self.prescribed
    }

    /// Returns true if the mean displacement of a component does not depend on its mean traction.
    pub(crate) fn floats(&self, component: usize) -> bool {
        self.response.uniform_compliance()[self.response.components().axes()[component]] == 0.0
    }
}
