//! FIRE (Bitzek et al. 2006): molecular dynamics with an adaptive time step and a reset of the velocity when P = F·v is
//! negative.

use std::ops::Range;

use gfmd_vector::{add, pass, reduce};

use crate::{
    Landscape, Method, RelaxError, State, Variables, Visit,
    bounds::{Wall, within},
};

/// Fast inertial relaxation engine (theory.md, section 6.4). It does not need the stiffness of the softest mode, only a
/// time step for which the stiffest mode is stable. The damping is adaptive: velocities are mixed with the direction of
/// the force, the time step grows while the motion goes downhill, and the velocity is set to zero when it goes uphill.
///
/// Entries held by their bound have zero force and zero velocity. An entry that has just reached its bound still has
/// the velocity of the *projected* motion; stepping back with this velocity would take it off its bound again,
/// endlessly if no other entry moves. The mass is 1 for all entries, as for [`Verlet`](crate::Verlet). Both published
/// versions are integrated as FIRE 2.0: semi-implicit Euler, with velocities mixed after the force has acted on them.
///
/// Every parameter is public: `Fire { delay: 10, ..Fire::v2(dt_max) }`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fire {
    /// Initial time step Δt₀. Both versions: Δt_max / 10.
    pub dt_start: f64,
    /// Largest time step Δt_max; at most [`Fire::largest_dt`].
    pub dt_max: f64,
    /// Smallest time step Δt_min. 2006: 0; 2.0: 0.02 Δt₀.
    pub dt_min: f64,
    /// Number of steps downhill before the time step grows, N_delay. 2006: 5; 2.0: 20.
    pub delay: u32,
    /// Number of initial steps in which a step uphill does not shorten the time step. 2006: 0; 2.0: N_delay.
    pub grace: u64,
    /// Growth factor of the time step, f_inc. Both versions: 1.1.
    pub dt_grow: f64,
    /// Reduction factor of the time step after a step uphill, f_dec. Both versions: 0.5.
    pub dt_shrink: f64,
    /// Initial fraction of the velocity that is turned towards the force per step, α₀. 2006: 0.1; 2.0: 0.25.
    pub alpha_start: f64,
    /// Reduction factor of α per step downhill, f_α. Both versions: 0.99.
    pub alpha_shrink: f64,
    /// Further action after a step uphill. 2006: [`Uphill::Halt`]; 2.0: [`Uphill::StepBack`].
    pub uphill: Uphill,
    /// Largest number of steps uphill in a row. 2006: no limit; 2.0: 2000.
    pub max_uphill: u32,
}

/// Action of [`Fire`] after a step uphill.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Uphill {
    /// v ← 0 without a change of position.
    Halt,
    /// u ← Π(u − ½ Δt v) with the shortened time step, then v ← 0. Costs one more force evaluation.
    StepBack,
}

/// [`State`] of [`Fire`].
pub type FireState = State<Flight>;

/// Variables of [`Fire`].
#[derive(Clone, Debug, PartialEq)]
pub struct Flight {
    /// Velocities after projection, in displacement per time.
    pub velocity: Vec<f64>,
    /// Time step Δt.
    pub dt: f64,
    /// Fraction α of the velocity that is turned towards the force.
    pub alpha: f64,
    /// Number of steps downhill since the last step uphill.
    pub downhill: u32,
    /// Number of steps uphill since the last step downhill.
    pub uphill: u32,
}

impl Variables for Flight {
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let Self { velocity, dt, alpha, downhill, uphill } = self;
        visitor.field(velocity);
        visitor.number(dt);
        visitor.number(alpha);
        visitor.small(downhill);
        visitor.small(uphill);
    }
}

impl Fire {
    /// Returns FIRE as published in 2006 (Bitzek, Koskinen, Gähler, Moseler, Gumbsch, Phys. Rev. Lett. 97, 170201),
    /// with unit mass.
    pub fn bitzek(dt_max: f64) -> Self {
        Self {
            dt_start: 0.1 * dt_max,
            dt_max,
            dt_min: 0.0,
            delay: 5,
            grace: 0,
            dt_grow: 1.1,
            dt_shrink: 0.5,
            alpha_start: 0.1,
            alpha_shrink: 0.99,
            uphill: Uphill::Halt,
            max_uphill: u32::MAX,
        }
    }

    /// Returns FIRE 2.0 of 2020 (Guénolé, Nöhring, Vaid, Houllé, Xie, Prakash, Bitzek, Comput. Mater. Sci. 175,
    /// 109584), with unit mass.
    pub fn v2(dt_max: f64) -> Self {
        Self {
            dt_start: 0.1 * dt_max,
            dt_max,
            dt_min: 0.002 * dt_max,
            delay: 20,
            grace: 20,
            alpha_start: 0.25,
            uphill: Uphill::StepBack,
            max_uphill: 2000,
            ..Self::bitzek(dt_max)
        }
    }

    /// Returns the largest recommended time step, 1.9/√k_max at unit mass. Undamped motion is stable below 2/√k_max.
    pub fn largest_dt(k_max: f64) -> f64 {
        1.9 / k_max.sqrt()
    }

    fn check(&self) -> Result<(), RelaxError> {
        let check = RelaxError::check_parameter;
        check("dt_max", self.dt_max, self.dt_max > 0.0 && self.dt_max.is_finite(), "positive and finite")?;
        let start = self.dt_start > 0.0 && self.dt_start <= self.dt_max;
        check("dt_start", self.dt_start, start, "positive and at most dt_max")?;
        let min = self.dt_min >= 0.0 && self.dt_min <= self.dt_start;
        check("dt_min", self.dt_min, min, "between 0 and dt_start")?;
        check("dt_grow", self.dt_grow, self.dt_grow >= 1.0 && self.dt_grow.is_finite(), "finite and at least 1")?;
        check("dt_shrink", self.dt_shrink, 0.0 < self.dt_shrink && self.dt_shrink < 1.0, "between 0 and 1")?;
        check("alpha_start", self.alpha_start, (0.0..=1.0).contains(&self.alpha_start), "between 0 and 1")?;
        check("alpha_shrink", self.alpha_shrink, (0.0..=1.0).contains(&self.alpha_shrink), "between 0 and 1")
    }
}

/// Sums over the entries that are not held by a bound.
#[derive(Clone, Copy)]
struct Balance {
    /// Σ f v.
    power: f64,
    /// Σ f².
    force: f64,
    /// Σ v².
    speed: f64,
}

fn weigh(wall: impl Wall, u: &[f64], force: &[f64], velocity: &[f64]) -> Balance {
    let leaf = |range: Range<usize>| {
        let wall = wall.stretch(range.clone());
        let entries = u[range.clone()].iter().zip(&force[range.clone()]).zip(&velocity[range]);
        entries.enumerate().fold([0.0; 3], |sums, (k, ((&u, &f), &v))| {
            let [f, v] = if wall.holds(k, u, f) { [0.0; 2] } else { [f, v] };
            add(sums, [f * v, f * f, v * v])
        })
    };
    let [power, force, speed] = reduce(u.len(), &leaf, &add);
    Balance { power, force, speed }
}

/// Sets v ← `keep` v + `turn` f (0 for held entries), u ← Π(u + Δt v), and v to the velocity of the projected motion,
/// in one sweep. Returns the number of entries that reached or left their bound.
fn glide(wall: impl Wall, [keep, turn, dt]: [f64; 3], force: &[f64], u: &mut [f64], velocity: &mut [f64]) -> u64 {
    let per_dt = 1.0 / dt;
    let leaf = |start: usize, [u, v]: [&mut [f64]; 2]| {
        let range = start..start + u.len();
        let (wall, force) = (wall.stretch(range.clone()), &force[range]);
        let mut changes = 0;
        for (k, ((u, v), &f)) in u.iter_mut().zip(v).zip(force).enumerate() {
            let speed = if wall.holds(k, *u, f) { 0.0 } else { keep * *v + turn * f };
            let aim = *u + dt * speed;
            let next = wall.clip(k, aim);
            changes += u64::from(wall.touches(k, next) != wall.touches(k, *u));
            // Off the bounds, (u₊ − u)/Δt equals the speed, but the difference would lose digits.
            *v = if next == aim { speed } else { (next - *u) * per_dt };
            *u = next;
        }
        changes
    };
    pass([u, velocity], &leaf, &|a, b| a + b)
}

impl Method for Fire {
    type Memory = Flight;

    fn start(&self, problem: &mut dyn Landscape, u: Vec<f64>) -> Result<FireState, RelaxError> {
        self.check()?;
        let velocity = vec![0.0; u.len()];
        let memory = Flight { velocity, dt: self.dt_start, alpha: self.alpha_start, downhill: 0, uphill: 0 };
        State::at_rest(problem, u, self.dt_max * self.dt_max, memory)
    }

    fn step(&self, problem: &mut dyn Landscape, state: &mut FireState) -> Result<(), RelaxError> {
        state.check(problem)?;
        RelaxError::check_length("velocities", state.memory.velocity.len(), problem.len())?;
        let glided = |problem: &dyn Landscape, state: &mut FireState, coefficients| {
            let State { u, force, memory, .. } = state;
            within!(problem.bounds(), wall => glide(wall, coefficients, force, u, &mut memory.velocity))
        };
        let mut changes = 0;
        let Balance { power, force, speed } = {
            let State { u, force, memory, .. } = &*state;
            within!(problem.bounds(), wall => weigh(wall, u, force, &memory.velocity))
        };
        let flight = &mut state.memory;
        let [keep, turn] = if speed > 0.0 && power <= 0.0 {
            flight.downhill = 0;
            flight.uphill = flight.uphill.saturating_add(1);
            if flight.uphill > self.max_uphill {
                let (found, allowed) = (flight.uphill, self.max_uphill);
                return Err(RelaxError::Uphill { reached: state.status(problem), found, allowed });
            }
            if state.step >= self.grace {
                flight.dt = self.dt_min.max(flight.dt * self.dt_shrink);
                flight.alpha = self.alpha_start;
            }
            if self.uphill == Uphill::StepBack {
                let back = [1.0, 0.0, -0.5 * flight.dt];
                changes += glided(problem, state, back);
                state.evaluate(problem);
            }
            // At rest there is no velocity to turn.
            [0.0, state.memory.dt]
        } else {
            if power > 0.0 {
                flight.uphill = 0;
                flight.downhill = flight.downhill.saturating_add(1);
                if flight.downhill > self.delay {
                    flight.dt = self.dt_max.min(flight.dt * self.dt_grow);
                    flight.alpha *= self.alpha_shrink;
                }
            }
            let Flight { dt, alpha, .. } = *flight;
            // |v + Δt f|², with the velocity after the force has acted and before it turns.
            let speed = speed + dt * (2.0 * power + dt * force);
            let speed_per_force = if force > 0.0 { (speed / force).sqrt() } else { 0.0 };
            [1.0 - alpha, (1.0 - alpha) * dt + alpha * speed_per_force]
        };
        let dt = state.memory.dt;
        changes += glided(problem, state, [keep, turn, dt]);
        state.step += 1;
        state.settled = if changes == 0 { state.settled + 1 } else { 0 };
        state.evaluate(problem);
        Ok(())
    }

    fn stiffness_limit(&self) -> f64 {
        4.0 / (self.dt_max * self.dt_max)
    }
}
