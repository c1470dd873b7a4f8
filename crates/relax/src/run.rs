//! The driver: one method, one state, until it is done.

use std::ops::ControlFlow;

use crate::{Bounds, Divergence, Landscape, Observer, RelaxError};

/// A run counts as diverged when its energy is this many times [`State::energy_scale`]. A stable scheme started
/// from rest stays far below: the strongest transient, that of the stiffest mode under optimal damping, gains about
/// k_max / (7 k_min).
const GROWTH: f64 = 1e8;

/// A way to relax: parameters only, no memory.
pub trait Method {
    /// What the method remembers from step to step, besides what every [`State`] holds.
    type Memory;

    /// Begins at the allowed point nearest to `u`, at rest. Costs one evaluation of the force.
    fn start(&self, problem: &mut dyn Landscape, u: Vec<f64>) -> Result<State<Self::Memory>, RelaxError>;

    /// One step, in place, without allocation. After an error the state holds what caused it.
    fn step(&self, problem: &mut dyn Landscape, state: &mut State<Self::Memory>) -> Result<(), RelaxError>;

    /// Largest stiffness per mass for which the method is stable, in 1/time².
    fn stiffness_limit(&self) -> f64;
}

/// All that changes from step to step: a checkpoint is exactly this, and a run resumed from it continues bit by bit.
#[derive(Clone, Debug, PartialEq)]
pub struct State<Memory> {
    /// The point, allowed by the bounds.
    pub u: Vec<f64>,
    /// −∂U/∂u there.
    pub force: Vec<f64>,
    /// U there.
    pub energy: f64,
    /// Steps done.
    pub step: u64,
    /// Steps since an entry last reached or left its bound.
    pub settled: u64,
    /// Evaluations of [`Landscape::force`] so far.
    pub evaluations: u64,
    /// What counts as much energy: |U| at the start plus the work of the forces over a first step.
    pub energy_scale: f64,
    /// What the method remembers.
    pub memory: Memory,
}

impl<Memory> State<Memory> {
    /// At rest at the allowed point nearest to `u`; `tau` is the squared time step over the mass.
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
        // The work tells where U itself happens to be zero.
        let energy_scale = energy.abs() + tau * gfmd_vector::dot(&force, &force);
        Ok(Self { u, force, energy, step: 0, settled: 0, evaluations: 1, energy_scale, memory })
    }

    /// Where the run stands. Costs one [`Landscape::residual`], no force.
    pub fn status(&self, problem: &dyn Landscape) -> Status {
        Status {
            step: self.step,
            energy: self.energy,
            residual: problem.residual(&self.u, &self.force),
            settled: self.settled,
            evaluations: self.evaluations,
        }
    }

    /// The force at the present u, counted.
    pub(crate) fn evaluate(&mut self, problem: &mut dyn Landscape) {
        self.energy = problem.force(&self.u, &mut self.force);
        self.evaluations += 1;
    }

    /// An error unless state and bounds fit the problem.
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

/// Where a run stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Status {
    /// Steps done.
    pub step: u64,
    /// U.
    pub energy: f64,
    /// [`Landscape::residual`]: dimensionless distance from the solution.
    pub residual: f64,
    /// Steps since an entry last reached or left its bound.
    pub settled: u64,
    /// Evaluations of [`Landscape::force`] so far.
    pub evaluations: u64,
}

/// When a run ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Converged when the residual is at most this …
    pub residual: f64,
    /// … and for this many steps no entry has reached or left its bound (theory.md, section 6.6: 20). Without bounds it
    /// does not matter.
    pub settled: u64,
    /// Not converged if the state has done this many steps (all of them, those before a restart too).
    pub max_steps: u64,
}

/// How a run ended well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// [`Stop`] is satisfied.
    Converged(Status),
    /// An observer asked to stop.
    Interrupted(Status),
}

/// Steps until `stop` is satisfied. Whatever the result, `state` stays with the caller: to save, to inspect, to resume.
///
/// The residual is judged from the force that the next step uses, so it costs no evaluation.
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
