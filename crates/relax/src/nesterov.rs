//! Nesterov's accelerated gradient method with adaptive restart.

use gfmd_vector::{pass, reduce};

use crate::{
    Landscape, Method, RelaxError, State, Variables, Visit,
    bounds::{Wall, within},
};

/// Accelerated gradient steps x₊ = Π(y + τ f(y)), y₊ = Π(x₊ + β (x₊ − x)), with β growing from 0 as (t − 1)/t₊,
/// t₊ = (1 + √(1 + 4 t²))/2 (Nesterov 1983), restarted whenever a step x₊ − y is longer than the previous one
/// (adaptive restart, O'Donoghue and Candès 2015). Restarts replace damping, so the softest mode need not be known.
///
/// The method is also suitable for [`AugmentedLagrangian`](crate::AugmentedLagrangian), which has a force but no
/// energy. Without momentum, its steps never become longer, so a longer step indicates too much momentum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nesterov {
    /// τ = Δt²/m, in displacement per force.
    pub tau: f64,
}

/// Variables of [`Nesterov`].
#[derive(Clone, Debug, PartialEq)]
pub struct Momentum {
    /// x after the last step; [`State::u`] is y.
    pub previous: Vec<f64>,
    /// Age t; 1 after a restart.
    pub age: f64,
    /// Length of the last step x₊ − y.
    pub length: f64,
}

impl Variables for Momentum {
    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.field(&mut self.previous);
        visitor.number(&mut self.age);
        visitor.number(&mut self.length);
    }
}

impl Nesterov {
    /// Creates the method for stiffnesses up to `k_max`: τ = 1/k_max.
    ///
    /// # Errors
    /// Returns an error if the stiffness is not positive and finite.
    pub fn new(k_max: f64) -> Result<Self, RelaxError> {
        let ok = k_max > 0.0 && k_max.is_finite();
        RelaxError::check_parameter("the largest stiffness", k_max, ok, "positive and finite")?;
        Ok(Self { tau: 1.0 / k_max })
    }

    /// Returns |x₊ − y|.
    fn length(&self, wall: impl Wall, y: &[f64], force: &[f64]) -> f64 {
        let leaf = |range: std::ops::Range<usize>| {
            let (wall, y, force) = (wall.stretch(range.clone()), &y[range.clone()], &force[range]);
            let entries = y.iter().zip(force).enumerate();
            entries.map(|(k, (&y, &f))| (wall.clip(k, y + self.tau * f) - y).powi(2)).sum::<f64>()
        };
        reduce(y.len(), &leaf, &|a, b| a + b).sqrt()
    }

    /// Replaces x by x₊ and y by y₊. Returns the number of entries that reached or left their bound.
    fn advance(&self, wall: impl Wall, beta: f64, force: &[f64], y: &mut [f64], x: &mut [f64]) -> u64 {
        let leaf = |start: usize, [y, x]: [&mut [f64]; 2]| {
            let range = start..start + y.len();
            let (wall, force) = (wall.stretch(range.clone()), &force[range]);
            let mut changes = 0;
            for (k, ((y, x), &f)) in y.iter_mut().zip(x).zip(force).enumerate() {
                let next = wall.clip(k, *y + self.tau * f);
                let ahead = wall.clip(k, next + beta * (next - *x));
                changes += u64::from(wall.touches(k, ahead) != wall.touches(k, *y));
                (*x, *y) = (next, ahead);
            }
            changes
        };
        pass([y, x], &leaf, &|a, b| a + b)
    }
}

impl Method for Nesterov {
    type Memory = Momentum;

    fn start(&self, problem: &mut dyn Landscape, u: Vec<f64>) -> Result<State<Momentum>, RelaxError> {
        let ok = self.tau > 0.0 && self.tau.is_finite();
        RelaxError::check_parameter("tau", self.tau, ok, "positive and finite")?;
        let memory = Momentum { previous: Vec::new(), age: 1.0, length: f64::INFINITY };
        let mut state = State::at_rest(problem, u, self.tau, memory)?;
        state.memory.previous.clone_from(&state.u);
        Ok(state)
    }

    fn step(&self, problem: &mut dyn Landscape, state: &mut State<Momentum>) -> Result<(), RelaxError> {
        state.check(problem)?;
        RelaxError::check_length("previous displacements", state.memory.previous.len(), problem.len())?;
        let State { u, force, memory, .. } = state;
        let length = within!(problem.bounds(), wall => self.length(wall, u, force));
        let age = if length > memory.length { 1.0 } else { memory.age };
        memory.length = length;
        memory.age = 0.5 * (1.0 + (1.0 + 4.0 * age * age).sqrt());
        let beta = (age - 1.0) / memory.age;
        let changes = within!(problem.bounds(), wall => self.advance(wall, beta, force, u, &mut memory.previous));
        state.step += 1;
        state.settled = if changes == 0 { state.settled + 1 } else { 0 };
        state.evaluate(problem);
        Ok(())
    }

    /// Returns 4/(3 τ): steps are stable up to τ k = 2 without momentum, and up to 4/3 with any momentum.
    fn stiffness_limit(&self) -> f64 {
        4.0 / (3.0 * self.tau)
    }
}
