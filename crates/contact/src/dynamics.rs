//! The contact problem in terms of the surface displacement, equilibrated by damped dynamics: the surface layer moves
//! under the elastic force −K u and stops at the rigid wall, u ≤ clearance − approach (theory.md, section 6).
//!
//! Under a prescribed mean pressure p̄ the rigid surface is fixed at first touch and the body is pushed against it: the
//! uniform mode has no stiffness and is driven by the force p̄, so that at rest the wall carries exactly p̄. Under a
//! prescribed approach the wall is fixed and the uniform mode has the stiffness of the slab. If this is zero or
//! infinite (half-space, incompressible slab), a search finds the load that gives the prescribed approach.
//!
//! With the augmented Lagrangian the wall acts by a force instead of clipping, so that the inertia may be close to the
//! stiffness (theory.md, section 6.3).

use gfmd_relax::{
    AugmentedLagrangian, Damping, Ending, Factors, Fire, Method, ModeDamped, Nesterov, RelaxError, Variables, Verlet,
    Why, damped_by_parts, relax_until,
};

use crate::Load;
use crate::attempt::{Attempt, SolverResult};
use crate::layer::{Layer, Pressed, Sprung};
use crate::load_search::LoadSearch;

/// Time step of [`Motion::VerletCritical`], relative to its stability limit 2/√k_max. The thesis gives Δt = 0.25
/// without a unit (docs/solvers.md).
const SOURCE_TIME_STEP: f64 = 0.25;

/// Time step and damping of the damped dynamics.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dynamics {
    /// Time step relative to its stability limit without damping, 2/√k_max, between 0 and 1. The default is a quarter
    /// with [`Solver::VerletCritical`](crate::Solver::VerletCritical), and the best one for the range of stiffnesses
    /// with [`Solver::VerletModes`](crate::Solver::VerletModes).
    pub time_step: Option<f64>,
    /// Damping of [`Solver::VerletCritical`](crate::Solver::VerletCritical).
    pub damping: Factors,
}

impl Default for Dynamics {
    fn default() -> Self {
        Self { time_step: None, damping: Factors::Softest(1.0) }
    }
}

impl Dynamics {
    /// Returns the time step for damping by scalar factors.
    pub(crate) fn step(&self, stiffest: f64) -> Result<f64, RelaxError> {
        Damping::time_step(self.time_step.unwrap_or(SOURCE_TIME_STEP), stiffest)
    }

    /// Returns the time step for damping of every mode.
    pub(crate) fn step_of_modes(&self, [softest, stiffest]: [f64; 2]) -> Result<f64, RelaxError> {
        match self.time_step {
            Some(time_step) => Damping::time_step(time_step, stiffest),
            None => Ok(Damping::optimal(softest, stiffest).tau.sqrt()),
        }
    }
}

/// Step length of the augmented Lagrangian; the stability limit is 2.
const RELAXATION: f64 = 1.2;

/// Methods of the dynamics.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Motion {
    Verlet,
    VerletCritical,
    VerletModes,
    Fire,
    Fire2,
    AugmentedLagrangian,
}

pub(crate) fn solve(mut attempt: Attempt, motion: Motion) -> Result<SolverResult, RelaxError> {
    let start = attempt.start.take();
    let (pressure, ending) = match attempt.load {
        Load::Approach(approach) if attempt.contact.response.uniform_compliance() == 0.0 => {
            search_load(&mut attempt, motion, approach, start)?
        }
        load => equilibrate(&mut attempt, motion, load, start, None)?,
    };
    Ok(SolverResult { reached: pressure.into(), effort: attempt.effort, ending })
}

fn equilibrate(
    attempt: &mut Attempt,
    motion: Motion,
    load: Load,
    start: Option<Vec<f64>>,
    search: Option<&mut LoadSearch>,
) -> Result<(Vec<f64>, Ending), RelaxError> {
    if let (None, Some(kept)) = (&search, attempt.watch.recall()) {
        attempt.effort.visit(kept);
    }
    let layer = Layer::new(attempt.contact, load, attempt.length_scale);
    let [softest, stiffest] = layer.band();
    match motion {
        Motion::Fire => run(attempt, load, layer, &Fire::bitzek(Fire::largest_dt(stiffest)), start, search),
        Motion::Fire2 => run(attempt, load, layer, &Fire::v2(Fire::largest_dt(stiffest)), start, search),
        Motion::AugmentedLagrangian => {
            let problem = AugmentedLagrangian::new(Sprung::new(layer));
            run(attempt, load, problem, &Nesterov { tau: RELAXATION }, start, search)
        }
        Motion::VerletCritical => {
            let dynamics = attempt.contact.dynamics;
            let dt = dynamics.step(stiffest)?;
            match dynamics.damping {
                Factors::Softest(factor) => {
                    let damping = Damping::times_critical(factor, softest, stiffest, dt)?;
                    run(attempt, load, layer, &Verlet::new(damping, stiffest)?, start, search)
                }
                Factors::Components([_, _, factor]) => {
                    let stiffness = attempt.contact.response.uniform_compliance().recip();
                    let method = damped_by_parts(&[factor], &[stiffness], stiffest, dt)?;
                    run(attempt, load, layer, &method, start, search)
                }
            }
        }
        Motion::VerletModes => {
            let dt = attempt.contact.dynamics.step_of_modes(layer.band())?;
            let method = ModeDamped::critical(dt * dt, layer.critically_damped(dt));
            let before = attempt.effort.iterations;
            let ended = run(attempt, load, layer, &method, start, search)?;
            attempt.effort.transform_pairs += (attempt.effort.iterations - before) as f64;
            Ok(ended)
        }
        Motion::Verlet => run(attempt, load, layer, &Verlet::optimal(softest, stiffest)?, start, search),
    }
}

/// Relaxes until the residuals of both the layer and the pressure on the wall are at most the tolerance.
fn run<'a, M: Method>(
    attempt: &mut Attempt,
    load: Load,
    mut surface: impl Pressed<'a>,
    method: &M,
    start: Option<Vec<f64>>,
    mut search: Option<&mut LoadSearch>,
) -> Result<(Vec<f64>, Ending), RelaxError> {
    let u = match &start {
        Some(pressure) => surface.layer().displacement(pressure),
        None => vec![0.0; surface.len()],
    };
    let u = surface.begin(u, start.as_deref());
    let mut state = method.start(&mut surface, u)?;
    let (contact, budget, is_shifted) = (attempt.contact, attempt.budget_left(), surface.is_shifted());
    let ending = relax_until(
        &mut surface,
        method,
        &mut state,
        &budget,
        &mut |surface, state| {
            let solution = contact.certified(surface.pressure(&state.u, &state.force), load);
            surface.layer().count_certificate(solution.effort.transform_pairs);
            solution.residual.worst()
        },
        &mut attempt.part_watch(is_shifted, |visitor| {
            if let Some(search) = &mut search {
                search.visit(visitor);
            }
        }),
    )?;
    attempt.effort.iterations += state.step;
    attempt.effort.transform_pairs += surface.layer().pairs();
    Ok((surface.pressure(&state.u, &state.force), ending))
}

/// Searches for the load that gives the approach; each run starts from the result of the last.
fn search_load(
    attempt: &mut Attempt,
    motion: Motion,
    approach: f64,
    start: Option<Vec<f64>>,
) -> Result<(Vec<f64>, Ending), RelaxError> {
    let contact = attempt.contact;
    let [softest, _] = contact.response.stiffness_range();
    let mut search = LoadSearch::from(match &start {
        Some(pressure) => pressure.iter().sum::<f64>() / pressure.len() as f64,
        None => 0.1 * softest * approach,
    });
    if let Some(kept) = attempt.watch.recall() {
        attempt.effort.visit(kept);
        search.visit(kept);
    }
    let mut pressure = start;
    loop {
        let load = Load::MeanPressure(search.load());
        let (found, ending) = equilibrate(attempt, motion, load, pressure.take(), Some(&mut search))?;
        if ending != Ending::Converged {
            return Ok((found, ending));
        }
        let solution = contact.certified(found.clone(), load);
        attempt.effort.transform_pairs += solution.effort.transform_pairs;
        let excess = solution.approach - approach;
        if excess.abs() <= 0.1 * attempt.budget.tolerance * attempt.length_scale {
            return Ok((found, ending));
        }
        if !search.learn(excess) {
            return Ok((found, Ending::GaveUp(Why::Rounding)));
        }
        pressure = Some(found);
    }
}
