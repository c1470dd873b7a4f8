//! Damping with different coefficients for entries or modes.

use gfmd_vector::for_each;

use crate::{Landscape, Method, RelaxError, State, Trail, bounds::within, verlet::advance};

/// Position Verlet with a matrix B in place of the number β, u₊ = Π(u + B (u − u₋) + τ f), for damping coefficients
/// η(q) that depend on the mode: B = 1 − τ η.
///
/// The damping force vanishes at rest, so that no B changes the solution, with or without bounds. Critical damping of
/// every mode, β(q) = (1 − √(τ k(q)))², prevents all oscillation, but the softest mode decays no faster than with
/// [`Verlet::critical`](crate::Verlet::critical) (theory.md, section 6.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeDamped<B> {
    /// τ = Δt²/m, in displacement per force.
    pub tau: f64,
    /// Largest stiffness for which the method is stable, 4/τ if every mode is critically damped.
    pub stiffness_limit: f64,
    /// Function d ← B d, in place.
    pub retain: B,
}

impl<B: Fn(&mut [f64])> ModeDamped<B> {
    /// Critical damping of every mode: `retain` must multiply each mode by (1 − √(τ k))², see
    /// [`Damping::critical`](crate::Damping::critical).
    pub fn critical(tau: f64, retain: B) -> Self {
        Self { tau, stiffness_limit: 4.0 / tau, retain }
    }
}

impl<B: Fn(&mut [f64])> Method for ModeDamped<B> {
    type Memory = Trail;

    fn start(&self, problem: &mut dyn Landscape, u: Vec<f64>) -> Result<State<Trail>, RelaxError> {
        let ok = self.tau > 0.0 && self.tau.is_finite();
        RelaxError::check_parameter("tau", self.tau, ok, "positive and finite")?;
        let mut state = State::at_rest(problem, u, self.tau, Trail { previous: Vec::new(), at_rest: true })?;
        state.memory.previous.clone_from(&state.u);
        Ok(state)
    }

    fn step(&self, problem: &mut dyn Landscape, state: &mut State<Trail>) -> Result<(), RelaxError> {
        state.check(problem)?;
        let State { u, force, memory, .. } = state;
        let motion = &mut memory.previous;
        RelaxError::check_length("previous displacements", motion.len(), u.len())?;
        for_each([&mut motion[..]], &|start, [d]| d.iter_mut().zip(&u[start..]).for_each(|(d, u)| *d = u - *d));
        (self.retain)(motion);
        let changes = within!(problem.bounds(), wall => advance(wall, self.tau, u, force, motion, |_, d| d));
        std::mem::swap(u, motion);
        memory.at_rest = false;
        state.step += 1;
        state.settled = if changes == 0 { state.settled + 1 } else { 0 };
        state.evaluate(problem);
        Ok(())
    }

    fn stiffness_limit(&self) -> f64 {
        self.stiffness_limit
    }
}
