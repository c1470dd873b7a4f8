//! Driver: makes steps of a method until an end criterion is met.

use std::ops::ControlFlow;

use crate::{Bounds, Divergence, Landscape, Observer, RelaxError, Variables, Visit};

/// Ratio of energy to [`State::energy_scale`] above which a run counts as diverged. A stable scheme started from rest
/// stays far below: the strongest transient, in the stiffest mode under optimal damping, reaches about k_max / (7
/// k_min).
const GROWTH: f64 = 1e8;

/// Relaxation method. It contains parameters only, no memory.
pub trait Method {
    /// Variables of the method in addition to the common variables of a [`State`].
    type Memory: Variables;

    /// Returns a state at rest at the allowed point nearest to `u`. Costs one force evaluation.
    fn start(&self, problem: &mut dyn Landscape, u: Vec<f64>) -> Result<State<Self::Memory>, RelaxError>;

    /// Makes one step in place, without allocation. After an error, `state` is the state that caused it.
    fn step(&self, problem: &mut dyn Landscape, state: &mut State<Self::Memory>) -> Result<(), RelaxError>;

    /// Returns the largest stiffness per mass for which the method is stable, in 1/time².
    fn stiffness_limit(&self) -> f64;
}

/// All variables of a run. It is the content of a checkpoint; a resumed run continues bit for bit.
#[derive(Clone, Debug, PartialEq)]
pub struct State<Memory> {
    /// Current point, within the bounds.
    pub u: Vec<f64>,
    /// Force −∂U/∂u at `u`.
    pub force: Vec<f64>,
    /// Energy U at `u`.
    pub energy: f64,
    /// Number of steps.
    pub step: u64,
    /// Number of steps since an entry last reached or left its bound.
    pub settled: u64,
    /// Number of evaluations of [`Landscape::force`].
    pub evaluations: u64,
    /// Scale of the energy: |U| at the start plus the work of the forces over a first step.
    pub energy_scale: f64,
    /// Variables of the method.
    pub memory: Memory,
}

impl<Memory: Variables> Variables for State<Memory> {
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let Self { u, force, energy, step, settled, evaluations, energy_scale, memory } = self;
        visitor.field(u);
        visitor.field(force);
        visitor.number(energy);
        visitor.count(step);
        visitor.count(settled);
        visitor.count(evaluations);
        visitor.number(energy_scale);
        memory.visit(visitor);
    }
}

impl<Memory> State<Memory> {
    /// Returns a state at rest at the allowed point nearest to `u`. `tau` is the squared time step divided by the mass.
    pub(crate) fn at_rest(
        problem: &mut dyn Landscape,
        mut u: Vec<f64>,
        tau: f64,
        memory: Memory,
    ) -> Result<Self, RelaxError> {
        RelaxError::check_length("displacements", u.len(), problem.len())?;
        problem.bounds().check(u.len())?;
        problem.bounds().project(&mut u);
        let mut force = vec![0.0; u.len()];
        let energy = problem.force(&u, &mut force);
        // The work gives a scale even if U is zero.
        let energy_scale = energy.abs() + tau * gfmd_vector::dot(&force, &force);
        Ok(Self { u, force, energy, step: 0, settled: 0, evaluations: 1, energy_scale, memory })
    }

    /// Returns the status of the run. Costs one [`Landscape::residual`], but no force evaluation.
    pub fn status(&self, problem: &dyn Landscape) -> Status {
        Status {
            step: self.step,
            energy: self.energy,
            residual: problem.residual(&self.u, &self.force),
            settled: self.settled,
            evaluations: self.evaluations,
        }
    }

    /// Evaluates the force at the current u and counts the evaluation.
    pub(crate) fn evaluate(&mut self, problem: &mut dyn Landscape) {
        self.energy = problem.force(&self.u, &mut self.force);
        self.evaluations += 1;
    }

    /// Checks that the state and the bounds have the length of the problem.
    pub(crate) fn check(&self, problem: &dyn Landscape) -> Result<(), RelaxError> {
        RelaxError::check_length("displacements", self.u.len(), problem.len())?;
        RelaxError::check_length("forces", self.force.len(), problem.len())?;
        problem.bounds().check_length(problem.len())
    }

    fn divergence(&self) -> Option<Divergence> {
        let allowed = GROWTH * self.energy_scale;
        if !self.energy.is_finite() {
            Some(Divergence::NotFinite)
        } else if self.energy > allowed {
            Some(Divergence::Energy { found: self.energy, allowed })
        } else {
            None
        }
    }
}

/// Status of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status {
    /// Number of steps.
    pub step: u64,
    /// Energy U.
    pub energy: f64,
    /// [`Landscape::residual`]: dimensionless distance from the solution.
    pub residual: f64,
    /// Number of steps since an entry last reached or left its bound.
    pub settled: u64,
    /// Number of evaluations of [`Landscape::force`].
    pub evaluations: u64,
}

/// End criteria of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Largest residual of a converged run.
    pub residual: f64,
    /// Number of steps without an entry reaching or leaving its bound that a converged run requires (theory.md, section
    /// 6.6: 20). It has no effect without bounds.
    pub settled: u64,
    /// Largest number of steps of the state, including the steps before a restart.
    pub max_steps: u64,
}

/// Outcome of a run without error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// [`Stop`] is satisfied.
    Converged(Status),
    /// An observer asked to stop.
    Interrupted(Status),
}

/// Makes steps until `stop` is satisfied. The caller keeps `state` in every case and can save, inspect or resume it.
///
/// The residual is computed from the force of the next step and costs no evaluation.
pub fn relax<M: Method>(
    problem: &mut dyn Landscape,
    method: &M,
    state: &mut State<M::Memory>,
    stop: &Stop,
    watch: &mut dyn Observer<State<M::Memory>>,
) -> Result<Outcome, RelaxError> {
    state.check(problem)?;
    problem.bounds().check(state.u.len())?;
    loop {
        watch.checkpoint(&mut |visitor| {
            state.visit(visitor);
            problem.visit(visitor);
        });
        let now = state.status(problem);
        let divergence = state.divergence().or((!now.residual.is_finite()).then_some(Divergence::NotFinite));
        if let Some(reason) = divergence {
            return Err(RelaxError::Diverged { reached: now, reason, stable_up_to: method.stiffness_limit() });
        }
        if let ControlFlow::Break(()) = watch.observe(&now, state)? {
            return Ok(Outcome::Interrupted(now));
        }
        let settled = now.settled >= stop.settled || matches!(problem.bounds(), Bounds::Free);
        if now.residual <= stop.residual && settled {
            return Ok(Outcome::Converged(now));
        }
        if stop.max_steps <= now.step {
            return Err(RelaxError::NotConverged { reached: now, asked: *stop });
        }
        method.step(problem, state)?;
    }
}
