use std::ops::ControlFlow;

use gfmd_field::Workspace;
use gfmd_response::NormalResponse;
use gfmd_vector::for_each;
use ndarray::ArrayView2;

use crate::wall::Wall;
use crate::{ContactError, Solution, Solver, dual, dynamics};

/// What presses the bodies together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Control {
    /// Mean pressure over the whole surface, in stress.
    MeanPressure(f64),
    /// Rigid approach beyond first touch, in length. On a half-space it is measured against the mean level of the elastic
    /// surface, on a slab against its rigid base.
    Approach(f64),
}

/// How to solve, and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The method.
    pub solver: Solver,
    /// Every part of [`Residual`](crate::Residual) must fall to this.
    pub tolerance: f64,
    /// Iterations, or time steps, after which the search is given up.
    pub max_iterations: u64,
}

impl Default for Settings {
    /// [`Solver::Auto`] to 1e-8.
    fn default() -> Self {
        Self { solver: Solver::Auto, tolerance: 1e-8, max_iterations: 100_000 }
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

/// A rigid rough surface above an elastic one, without friction or adhesion (hard wall).
pub struct Contact<'a> {
    pub(crate) response: &'a NormalResponse,
    pub(crate) wall: Wall,
}

impl<'a> Contact<'a> {
    /// `heights` is the rigid profile, peaks pointing at the body, in length; only differences matter.
    ///
    /// # Errors
    /// Heights of another shape than the grid, not finite, or all equal.
    pub fn new(response: &'a NormalResponse, heights: ArrayView2<f64>) -> Result<Self, ContactError> {
        Ok(Self { response, wall: Wall::new(response.grid().points(), heights)? })
    }

    /// Root mean square of the heights about their mean.
    pub fn rms_height(&self) -> f64 {
        self.wall.rms_height
    }

    /// Equilibrates the contact. `start` is a pressure to start from, such as that of a smaller load (it is scaled to
    /// the asked one); without it the start is uniform.
    ///
    /// # Errors
    /// Unusable control, settings or start; or [`ContactError::NotConverged`] and [`ContactError::Interrupted`], which
    /// carry the state reached.
    pub fn solve(
        &self,
        control: Control,
        settings: &Settings,
        start: Option<ArrayView2<f64>>,
        watch: Watch,
    ) -> Result<Solution, ContactError> {
        self.check(control, settings)?;
        let start = start.map(|start| self.check_start(start)).transpose()?;
        let ended = match settings.solver {
            Solver::Auto | Solver::PreconditionedCg | Solver::ProjectedCg | Solver::PolonskyKeer => {
                dual::solve(self, control, settings, start, watch)?
            }
            Solver::Verlet | Solver::VerletCritical | Solver::Fire | Solver::Fire2 | Solver::AugmentedLagrangian => {
                dynamics::solve(self, control, settings, start, watch)?
            }
        };
        let mut solution = self.certify(ended.pressure, control)?;
        solution.iterations = ended.iterations;
        solution.transform_pairs += ended.transform_pairs;
        let solution = Box::new(solution);
        match ended.end {
            End::Interrupted => Err(ContactError::Interrupted { solution }),
            _ if solution.residual.worst() <= settings.tolerance => Ok(*solution),
            End::Converged => {
                let reason = "the recomputed residuals are larger than the solver's".into();
                Err(ContactError::NotConverged { solution, asked: settings.tolerance, reason })
            }
            End::GaveUp(reason) => Err(ContactError::NotConverged { solution, asked: settings.tolerance, reason }),
        }
    }

    /// The state that belongs to `pressure`, with its residuals, from fresh transforms.
    ///
    /// # Errors
    /// A pressure of the wrong length.
    pub fn certify(&self, pressure: Vec<f64>, control: Control) -> Result<Solution, ContactError> {
        let response = self.response;
        let n = pressure.len();
        let mut workspace = response.transform().workspace();
        let mut displacement = vec![0.0; n];
        response.transform().convolve(response.compliance(), &pressure, &mut displacement, &mut workspace)?;
        let uniform =
            response.uniform_compliance() * gfmd_vector::sum(n, &|range| pressure[range].iter().sum()) / n as f64;
        // u_z = −G p.
        for_each([&mut displacement], &|_, [u]| u.iter_mut().for_each(|u| *u = -(*u + uniform)));
        self.wall.certify(pressure, displacement, control)
    }

    fn check(&self, control: Control, settings: &Settings) -> Result<(), ContactError> {
        if !(1e-15..=0.1).contains(&settings.tolerance) {
            return Err(ContactError::Tolerance { found: settings.tolerance });
        }
        match control {
            Control::MeanPressure(found) if !(found > 0.0 && found.is_finite()) => {
                Err(ContactError::MeanPressure { found })
            }
            Control::Approach(found) => {
                let limit = (self.response.uniform_compliance() == 0.0).then_some(self.wall.mean_clearance);
                let reachable = found > 0.0 && found < limit.unwrap_or(f64::INFINITY);
                if reachable { Ok(()) } else { Err(ContactError::Approach { found, limit }) }
            }
            Control::MeanPressure(_) => Ok(()),
        }
    }

    fn check_start(&self, start: ArrayView2<f64>) -> Result<Vec<f64>, ContactError> {
        let expected = self.response.grid().points();
        if <[usize; 2]>::from(start.dim()) != expected {
            return Err(ContactError::Start { reason: format!("{:?} points, {expected:?} are needed", start.dim()) });
        }
        if let Some(((i, j), p)) = start.indexed_iter().find(|(_, p)| !(p.is_finite() && **p >= 0.0)) {
            return Err(ContactError::Start {
                reason: format!("{p} at [{i}, {j}]; it must be finite and not negative"),
            });
        }
        if start.iter().all(|p| *p == 0.0) {
            return Err(ContactError::Start { reason: "it is zero everywhere".into() });
        }
        Ok(start.iter().copied().collect())
    }
}

/// What a solver hands back: the pressure speaks for itself, everything else is derived from it.
pub(crate) struct Ended {
    pub(crate) pressure: Vec<f64>,
    pub(crate) iterations: u64,
    pub(crate) transform_pairs: f64,
    pub(crate) end: End,
}

pub(crate) enum End {
    Converged,
    Interrupted,
    GaveUp(String),
}

/// Transforms of one solve: the workspace, and the count of single transforms.
pub(crate) struct Transforms {
    pub(crate) workspace: Workspace,
    pub(crate) singles: u64,
}

impl Transforms {
    pub(crate) fn new(response: &NormalResponse) -> Self {
        Self { workspace: response.transform().workspace(), singles: 0 }
    }

    pub(crate) fn pairs(&self) -> f64 {
        self.singles as f64 / 2.0
    }
}
