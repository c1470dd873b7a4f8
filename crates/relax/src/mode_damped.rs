//! Damping with different coefficients for entries or modes.

use gfmd_vector::for_each;

use crate::{Damping, Landscape, Method, RelaxError, State, Trail, bounds::within, verlet::advance};

/// Position Verlet with a matrix B in place of the number β, u₊ = Π(u + B (u − u₋) + τ f), for damping coefficients
/// η(q) that depend on the mode: B = 1 − τ η.
///
/// The damping force vanishes at rest, so B does not change the solution, with or without bounds. Critical damping of
/// every mode, β(q) = (1 − √(τ k(q)))², prevents all oscillation, but the softest mode decays no faster than with
/// [`Verlet::critical`](crate::Verlet::critical) (theory.md, section 6.2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModeDamped<B> {
    /// τ = Δt²/m, in displacement per force.
    pub tau: f64,
    /// Largest stiffness for which the method is stable, 4/τ if every mode is critically damped.
    pub stiffness_limit: f64,
    /// Function that replaces d by B d, in place.
    pub retain: B,
}

impl<B: Fn(&mut [f64])> ModeDamped<B> {
    /// Creates the method with critical damping of every mode. `retain` must multiply each mode by (1 − √(τ k))², see
    /// [`Damping::critical`](crate::Damping::critical).
    pub fn critical(tau: f64, retain: B) -> Self {
        Self { tau, stiffness_limit: 4.0 / tau, retain }
    }
}

/// Creates a damping with one coefficient for each of several equally long parts of the entries: `factors` times the
/// critical η of the `stiffnesses`, at one time step `dt`, if modes up to `k_max` are stable. The inertia is a scalar,
/// so all parts together are stable if each part alone is stable.
///
/// # Errors
/// Returns an error if a stiffness is not positive and finite, and the errors of [`Damping::times_critical`].
pub fn damped_by_parts(
    factors: &[f64],
    stiffnesses: &[f64],
    k_max: f64,
    dt: f64,
) -> Result<ModeDamped<impl Fn(&mut [f64]) + use<>>, RelaxError> {
    let mut retained = Vec::new();
    for (&factor, &stiffness) in factors.iter().zip(stiffnesses) {
        let known = stiffness > 0.0 && stiffness.is_finite();
        let name = "the stiffness of a uniform displacement";
        RelaxError::check_parameter(name, stiffness, known, "finite and above zero, as of a compressible slab")?;
        retained.push(Damping::times_critical(factor, stiffness, k_max, dt)?.beta);
    }
    let tau = dt * dt;
    let least = retained.iter().copied().fold(1.0, f64::min);
    let retain = move |motion: &mut [f64]| {
        let length = motion.len() / retained.len().max(1);
        for (motion, beta) in motion.chunks_mut(length.max(1)).zip(&retained) {
            for_each([motion], &|_, [motion]| motion.iter_mut().for_each(|d| *d *= beta));
        }
    };
    Ok(ModeDamped { tau, stiffness_limit: 2.0 * (1.0 + least) / tau, retain })
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
