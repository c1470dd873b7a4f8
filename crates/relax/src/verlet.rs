//! Damped position Verlet, with equal mass, damping and time step for all entries.

use gfmd_vector::pass;

use crate::{
    Damping, Landscape, Method, RelaxError, State, Variables, Visit,
    bounds::{Wall, within},
};

/// Relative energy increase that may be due to rounding.
const RISE: f64 = 1e-12;

/// Damped position Verlet, u₊ = Π(u + β (u − u₋) + τ f), with Π the projection on the bounds and u₋ the previous
/// *projected* u, so that entries at a bound are at rest (theory.md, sections 6.1 and 6.5). Also known as the heavy
/// ball method.
///
/// The mass is equal for all entries. With a mass matrix close to the stiffness matrix, the motion would converge in a
/// few steps without bounds, but to a wrong point with bounds (theory.md, section 6.3).
///
/// The constructors check stability; a struct literal does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verlet {
    /// Parameters β and τ.
    pub damping: Damping,
    /// Action after a step that increases the energy.
    pub on_rise: OnRise,
}

/// Action of [`Verlet`] after a step that increases the energy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnRise {
    /// No action, since the energy may increase in an oscillation. The rates of [`Damping`] are valid for this choice.
    #[default]
    Continue,
    /// Undo the step, u ← u₋, and continue from rest. A safeguard for landscapes that are not convex; it costs one more
    /// force evaluation.
    ///
    /// Resting at the end of the step, u₋ ← u (theory.md, section 6.5), would not suffice: the increase would be kept,
    /// and a mode with 1 < τ k < 2 grows if it rests after every second step. From u₋, the next step is a gradient
    /// descent, which decreases the energy if τ k_max < 2 ([`Verlet::guarded`] checks it; optimal damping has nearly
    /// 4). The energy of the accepted points thus never increases by more than rounding.
    StepBack,
}

/// [`State`] of [`Verlet`].
pub type VerletState = State<Trail>;

/// Variables of [`Verlet`].
#[derive(Clone, Debug, PartialEq)]
pub struct Trail {
    /// u₋, the previous u; equal to u at rest.
    pub previous: Vec<f64>,
    /// True at rest, u₋ = u.
    pub at_rest: bool,
}

impl Variables for Trail {
    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.field(&mut self.previous);
        visitor.flag(&mut self.at_rest);
    }
}

impl Verlet {
    /// Creates the method with a damping that is stable for all stiffnesses (per mass) up to `k_max`: |β| < 1, τ k_max
    /// < 2 (1 + β) (theory.md, section 6.1).
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

    /// Creates the method with critical damping of the softest mode at a given time step (unit mass). The error
    /// decreases by the factor 1 − √k_min Δt per step. The optimal time step is Δt = 2 / (√k_min + √k_max), which gives
    /// [`Verlet::optimal`]; the method is unstable at and above [`Damping::critical_dt_limit`].
    pub fn critical(k_min: f64, k_max: f64, dt: f64) -> Result<Self, RelaxError> {
        check_band(k_min, k_max)?;
        RelaxError::check_parameter("the time step", dt, positive(dt), "positive and finite")?;
        let allowed = Damping::critical_dt_limit(k_min, k_max);
        if dt >= allowed {
            return Err(RelaxError::TimeStep { found: dt, allowed });
        }
        Self::new(Damping::critical(k_min, dt), k_max)
    }

    /// Creates the method with optimal damping and time step for the band [`k_min`, `k_max`] (theory.md, section 6.2).
    pub fn optimal(k_min: f64, k_max: f64) -> Result<Self, RelaxError> {
        check_band(k_min, k_max)?;
        Self::new(Damping::optimal(k_min, k_max), k_max)
    }

    /// Returns this method with [`OnRise::StepBack`], if the time step is short enough: τ k_max < 2.
    pub fn guarded(self, k_max: f64) -> Result<Self, RelaxError> {
        let checked = Self::new(self.damping, k_max)?;
        let (found, allowed) = (checked.damping.tau.sqrt(), (2.0 / k_max).sqrt());
        if found >= allowed {
            return Err(RelaxError::TimeStep { found, allowed });
        }
        Ok(Self { on_rise: OnRise::StepBack, ..checked })
    }
}

/// Replaces each entry t of `trail` by u₊ = Π(u + motion(u, t) + τ f), in one sweep. Returns the number of entries that
/// reached or left their bound.
pub(crate) fn advance(
    wall: impl Wall,
    tau: f64,
    u: &[f64],
    force: &[f64],
    trail: &mut [f64],
    motion: impl Fn(f64, f64) -> f64 + Sync,
) -> u64 {
    let leaf = |start: usize, [next]: [&mut [f64]; 1]| {
        let range = start..start + next.len();
        let (wall, u, force) = (wall.stretch(range.clone()), &u[range.clone()], &force[range]);
        let mut changes = 0;
        for (k, ((next, &u), &f)) in next.iter_mut().zip(u).zip(force).enumerate() {
            *next = wall.clip(k, u + motion(u, *next) + tau * f);
            changes += u64::from(wall.touches(k, *next) != wall.touches(k, u));
        }
        changes
    };
    pass([trail], &leaf, &|a, b| a + b)
}

impl Method for Verlet {
    type Memory = Trail;

    fn start(&self, problem: &mut dyn Landscape, u: Vec<f64>) -> Result<VerletState, RelaxError> {
        let mut state = State::at_rest(problem, u, self.damping.tau, Trail { previous: Vec::new(), at_rest: true })?;
        state.memory.previous.clone_from(&state.u);
        Ok(state)
    }

    fn step(&self, problem: &mut dyn Landscape, state: &mut VerletState) -> Result<(), RelaxError> {
        state.check(problem)?;
        RelaxError::check_length("previous displacements", state.memory.previous.len(), problem.len())?;
        let (u, force, previous) = (&state.u, &state.force, &mut state.memory.previous);
        let Damping { beta, tau } = self.damping;
        let motion = |u: f64, previous: f64| beta * (u - previous);
        let changes = within!(problem.bounds(), wall => advance(wall, tau, u, force, previous, motion));
        std::mem::swap(&mut state.u, &mut state.memory.previous);
        state.step += 1;
        state.settled = if changes == 0 { state.settled + 1 } else { 0 };
        let before = state.energy;
        state.evaluate(problem);
        let tolerance = RISE * state.energy_scale.max(before.abs());
        // A step from rest is a gradient descent; if undone, it would only be repeated.
        let back = self.on_rise == OnRise::StepBack && !state.memory.at_rest && state.energy > before + tolerance;
        if back {
            std::mem::swap(&mut state.u, &mut state.memory.previous);
            state.memory.previous.copy_from_slice(&state.u);
            state.evaluate(problem);
        }
        state.memory.at_rest = back;
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
