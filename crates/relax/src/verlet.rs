//! Damped position Verlet: every entry with the same mass, the same damping, the same time step.

use gfmd_vector::pass;

use crate::{
    Bounds, Damping, Landscape, Method, RelaxError, State,
    bounds::{Inside, Open, Under, Wall},
};

/// Damped position Verlet, u₊ = Π(u + β (u − u₋) + τ f), with Π the projection on the bounds and u₋ the previous
/// *projected* u: entries at a bound are at rest (theory.md, sections 6.1 and 6.5). Also known as heavy ball.
///
/// The mass is one number. A mass that follows the stiffness would converge in a few steps without bounds, and to a
/// wrong point with them (theory.md, section 6.3).
///
/// The constructors check stability; a struct literal does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verlet {
    /// β and τ.
    pub damping: Damping,
    /// What to do when a step ends higher than it began.
    pub on_rise: OnRise,
}

/// What [`Verlet`] does when the energy rises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnRise {
    /// Nothing: a rising energy is part of an oscillation. The rates of [`Damping`] hold for this.
    #[default]
    Continue,
    /// Stop all entries, u₋ ← u (theory.md, section 6.5). A safeguard for landscapes that are not convex.
    Rest,
}

/// [`State`] of [`Verlet`].
pub type VerletState = State<Trail>;

/// What [`Verlet`] remembers.
#[derive(Clone, Debug, PartialEq)]
pub struct Trail {
    /// u₋: u one step earlier, or u itself at rest.
    pub previous: Vec<f64>,
}

impl Verlet {
    /// Any damping that is stable for all stiffnesses (per mass) up to `k_max`: |β| < 1, τ k_max < 2 (1 + β)
    /// (theory.md, section 6.1).
    pub fn new(damping: Damping, k_max: f64) -> Result<Self, RelaxError> {
        let Damping { beta, tau } = damping;
        RelaxError::check_parameter("beta", beta, beta.abs() < 1.0, "between -1 and 1")?;
        RelaxError::check_parameter("tau", tau, positive(tau), "positive and finite")?;
        RelaxError::check_parameter("the largest stiffness", k_max, positive(k_max), "positive and finite")?;
        if k_max >= damping.stiffness_limit() {
            let allowed = (2.0 * (1.0 + beta) / k_max).sqrt();
            return Err(RelaxError::TimeStep { found: tau.sqrt(), allowed });
        }
        Ok(Self { damping, on_rise: OnRise::default() })
    }

    /// Critical damping of the softest mode at a given time step (unit mass). The error shrinks by 1 − √k_min Δt per
    /// step. Best, and equal to [`Verlet::optimal`], at Δt = 2 / (√k_min + √k_max); unstable from
    /// [`Damping::critical_dt_limit`] on.
    pub fn critical(k_min: f64, k_max: f64, dt: f64) -> Result<Self, RelaxError> {
        check_band(k_min, k_max)?;
        RelaxError::check_parameter("the time step", dt, positive(dt), "positive and finite")?;
        let allowed = Damping::critical_dt_limit(k_min, k_max);
        if dt >= allowed {
            return Err(RelaxError::TimeStep { found: dt, allowed });
        }
        Self::new(Damping::critical(k_min, dt), k_max)
    }

    /// The best single damping and time step for all stiffnesses in [`k_min`, `k_max`] (theory.md, section 6.2).
    pub fn optimal(k_min: f64, k_max: f64) -> Result<Self, RelaxError> {
        check_band(k_min, k_max)?;
        Self::new(Damping::optimal(k_min, k_max), k_max)
    }

    /// u₊ in place of u₋, and how many entries reached or left their bound: one sweep.
    fn advance(&self, wall: impl Wall, u: &[f64], force: &[f64], previous: &mut [f64]) -> u64 {
        let Damping { beta, tau } = self.damping;
        pass(
            [previous],
            &|start, [next]| {
                let range = start..start + next.len();
                let (wall, u, force) = (wall.stretch(range.clone()), &u[range.clone()], &force[range]);
                let mut changes = 0;
                for (k, ((next, &u), &f)) in next.iter_mut().zip(u).zip(force).enumerate() {
                    *next = wall.clip(k, u + beta * (u - *next) + tau * f);
                    changes += u64::from(wall.touches(k, *next) != wall.touches(k, u));
                }
                changes
            },
            &|a, b| a + b,
        )
    }
}

impl Method for Verlet {
    type Memory = Trail;

    fn start(&self, problem: &mut dyn Landscape, u: Vec<f64>) -> Result<VerletState, RelaxError> {
        let mut state = State::at_rest(problem, u, self.damping.tau, Trail { previous: Vec::new() })?;
        state.memory.previous.clone_from(&state.u);
        Ok(state)
    }

    fn step(&self, problem: &mut dyn Landscape, state: &mut VerletState) -> Result<(), RelaxError> {
        state.check(problem)?;
        RelaxError::check_length("previous displacements", state.memory.previous.len(), problem.len())?;
        let (u, force, previous) = (&state.u, &state.force, &mut state.memory.previous);
        let changes = match problem.bounds() {
            Bounds::Free => self.advance(Open, u, force, previous),
            Bounds::Upper(upper) => self.advance(Under(upper), u, force, previous),
            Bounds::Between { lower, upper } => self.advance(Inside(lower, upper), u, force, previous),
        };
        std::mem::swap(&mut state.u, &mut state.memory.previous);
        state.step += 1;
        state.settled = if changes == 0 { state.settled + 1 } else { 0 };
        let before = state.energy;
        state.evaluate(problem);
        if self.on_rise == OnRise::Rest && state.energy > before {
            state.memory.previous.copy_from_slice(&state.u);
        }
        Ok(())
    }

    fn stiffness_limit(&self) -> f64 {
        self.damping.stiffness_limit()
    }
}

fn positive(x: f64) -> bool {
    x > 0.0 && x.is_finite()
}

fn check_band(k_min: f64, k_max: f64) -> Result<(), RelaxError> {
    RelaxError::check_parameter("the smallest stiffness", k_min, positive(k_min), "positive and finite")?;
    let ok = k_max >= k_min && k_max.is_finite();
    RelaxError::check_parameter("the largest stiffness", k_max, ok, "finite and at least the smallest one")
}
