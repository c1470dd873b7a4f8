use std::ops::ControlFlow;

use gfmd_response::FullResponse;

use crate::{MixedError, Prescribed};

/// The methods. All find the same state; they differ in cost. (docs/solvers.md)
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// Conjugate gradients on the traction of what is held, preconditioned by the stiffness restricted to it.
    #[default]
    ConjugateGradients,
    /// Damped position Verlet of the free displacement, with the scalar damping and time step that suit the range of
    /// stiffnesses best.
    Verlet,
    /// Damped position Verlet with the softest mode critically damped and a quarter of the stable time step, as in the
    /// original method.
    VerletCritical,
    /// The fast inertial relaxation engine (Bitzek et al. 2006).
    Fire,
}

/// How to solve, and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The method.
    pub method: Method,
    /// [`MixedSolution::residual`] must fall to this.
    pub tolerance: f64,
    /// Iterations, or time steps, after which the search is given up.
    pub max_iterations: u64,
}

impl Default for Settings {
    /// [`Method::ConjugateGradients`] to 1e-8.
    fn default() -> Self {
        Self { method: Method::default(), tolerance: 1e-8, max_iterations: 100_000 }
    }
}

/// Where a running solver stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Iterations, or time steps, done.
    pub iteration: u64,
    /// The solver's own estimate of the distance from the solution, comparable with the tolerance.
    pub residual: f64,
}

/// Sees every iteration; may ask to stop.
pub type Watch<'a> = &'a mut dyn FnMut(&Progress) -> ControlFlow<()>;

/// An elastic body with its surface held here and loaded there.
#[derive(Debug)]
pub struct MixedProblem<'a> {
    pub(crate) response: &'a FullResponse,
    pub(crate) prescribed: Prescribed,
}

impl<'a> MixedProblem<'a> {
    /// Poses the problem.
    ///
    /// # Errors
    /// What is prescribed does not fit the grid, holds nothing, or leaves a mean traction undetermined.
    pub fn new(response: &'a FullResponse, prescribed: Prescribed) -> Result<Self, MixedError> {
        let [nx, ny] = response.grid().points();
        let (found, expected) = (prescribed.shape(), [response.components().len(), nx, ny]);
        if found != expected {
            return Err(MixedError::Shape { what: "prescribed values", found, expected });
        }
        let problem = Self { response, prescribed };
        if !problem.prescribed.held().contains(&true) {
            return Err(MixedError::NothingHeld);
        }
        let points = response.grid().len();
        for (component, held) in problem.prescribed.held().chunks_exact(points).enumerate() {
            if problem.floats(component) && !held.contains(&false) {
                return Err(MixedError::Undetermined { component });
            }
        }
        Ok(problem)
    }

    /// What is prescribed.
    pub fn prescribed(&self) -> &Prescribed {
        &self.prescribed
    }

    /// Whether the mean displacement of a component does not answer to its mean traction.
    pub(crate) fn floats(&self, component: usize) -> bool {
        self.response.uniform_compliance()[self.response.components().axes()[component]] == 0.0
    }
}
