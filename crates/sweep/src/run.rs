//! Computation of the runs of a sweep. Runs on small grids are computed in parallel.

use std::error::Error;
use std::ops::ControlFlow;
use std::sync::Arc;

use gfmd_contact::{Contact, Equilibrium, Heights, Load, Progress, Solution, SolveError};
use gfmd_measure::Scales;
use gfmd_response::NormalResponse;
use ndarray::Array2;
use rayon::prelude::*;

use crate::config::{Control, refusal};
use crate::{Plan, Point, Pressed, Run, Shard, SweepError};

/// Store of finished runs, to continue a sweep; it may also ask to stop. Every method is called from several threads.
/// `()` stores nothing and never stops.
pub trait Keep: Sync {
    /// Returns the loads of a run that finished earlier; `None` if the run must be computed. Called once for each run.
    /// Runs with equal point and realisation are the same in every plan.
    fn recall(&self, _run: &Run) -> Option<Vec<Pressed>> {
        None
    }

    /// Stores a finished run.
    ///
    /// # Errors
    /// Returns an error if the run cannot be stored; the sweep then ends.
    fn keep(&self, _run: &Run, _loads: &[Pressed]) -> Result<(), Box<dyn Error + Send + Sync>> {
        Ok(())
    }

    /// Announces a round of further surfaces, with the plan that contains them and the error so far
    /// ([`SweepPrecision::relative`]).
    ///
    /// [`SweepPrecision::relative`]: crate::SweepPrecision::relative
    fn more(&self, _plan: &Plan, _reached: f64) {}

    /// Returns true if the sweep must end now.
    fn is_interrupted(&self) -> bool {
        false
    }
}

impl Keep for () {}

/// Computes the runs that `keep` does not recall, point by point. Returns the loads of every run, in the order of
/// [`Plan::runs`].
///
/// # Errors
/// Returns an error if a contact does not converge, if a run cannot be kept, or after an interruption.
pub fn run(plan: &Plan, keep: &dyn Keep) -> Result<Vec<Vec<Pressed>>, SweepError> {
    run_all(plan, &(0..plan.runs.len()).collect::<Vec<_>>(), keep)
}

/// Computes the runs of one shard that `keep` does not recall, so that a sweep can be distributed over many processes.
/// Returns the loads of each run, in the order of [`Plan::runs_of_shard`].
///
/// # Errors
/// Returns an error if a contact does not converge, if a run cannot be kept, or after an interruption.
pub fn run_shard(plan: &Plan, shard: Shard, keep: &dyn Keep) -> Result<Vec<Vec<Pressed>>, SweepError> {
    run_all(plan, &plan.runs_of_shard(shard), keep)
}

/// Computes the runs of these ascending indices.
fn run_all(plan: &Plan, runs: &[usize], keep: &dyn Keep) -> Result<Vec<Vec<Pressed>>, SweepError> {
    let mut all = Vec::with_capacity(runs.len());
    for runs in runs.chunk_by(|a, b| plan.runs[*a].point == plan.runs[*b].point) {
        let point = &plan.points[plan.runs[runs[0]].point];
        let (recalled, open): (Vec<_>, Vec<_>) =
            runs.iter().map(|run| (*run, keep.recall(&plan.runs[*run]))).partition(|(_, loads)| loads.is_some());
        let mut loads = recalled;
        if !open.is_empty() {
            let bench = Bench::new(plan, point)?;
            let one = |(run, _): (usize, Option<_>)| {
                let loads = bench.press(&plan.runs[run], keep)?;
                keep.keep(&plan.runs[run], &loads).map_err(SweepError::Keep)?;
                Ok((run, Some(loads)))
            };
            let computed: Result<Vec<_>, SweepError> = if point.is_small() {
                open.into_par_iter().map(one).collect()
            } else {
                open.into_iter().map(one).collect()
            };
            loads.extend(computed?);
            loads.sort_by_key(|(run, _)| *run);
        }
        all.extend(loads.into_iter().filter_map(|(_, loads)| loads));
    }
    Ok(all)
}

/// Computes one run without recalling it.
///
/// # Errors
/// Returns an error if the run is not in the plan, if a contact does not converge, or after an interruption.
pub fn run_one(plan: &Plan, run: usize, keep: &dyn Keep) -> Result<Vec<Pressed>, SweepError> {
    let allowed = || refusal("run", &run, format!("below {}", plan.runs.len()));
    let run = plan.runs.get(run).ok_or_else(allowed)?;
    Bench::new(plan, &plan.points[run.point])?.press(run, keep)
}

/// Contact with its fields: the first realisation at the load of the result, on the largest grid of moderate size.
#[derive(Clone, Debug)]
pub struct Example {
    /// Point of the example.
    pub point: Point,
    /// Seed of the example.
    pub seed: u64,
    /// Pressure.
    pub pressure: Array2<f64>,
    /// Heights of the surface.
    pub heights: Array2<f64>,
}

/// Largest number of points along one axis of a square for the example.
const EXAMPLE_POINTS: usize = 1024;

impl Example {
    /// Returns the index of the point of a plan's example.
    pub fn point(plan: &Plan) -> usize {
        let moderate = |point: &Point| point.grid.is_line() || point.n() <= EXAMPLE_POINTS;
        let candidates = (0..plan.points.len()).filter(|index| moderate(&plan.points[*index]));
        candidates.max_by_key(|index| plan.points[*index].n()).unwrap_or(0)
    }

    /// Computes the example of a plan.
    ///
    /// # Errors
    /// Returns an error if the contact does not converge, or after an interruption.
    pub fn new(plan: &Plan, keep: &dyn Keep) -> Result<Self, SweepError> {
        let index = Self::point(plan);
        let (point, run) = (plan.points[index], plan.runs[plan.runs_of(index).start]);
        let bench = Bench::new(plan, &point)?;
        let heights = bench.heights(&run)?;
        let contact = bench.contact(&run, (&heights).into())?;
        let pressure = bench.solve(&run, &contact, plan.config.fit.p_star, None, keep)?.pressure;
        Ok(Self { point, seed: run.seed, pressure, heights })
    }
}

/// Response on the grid of one point, shared by its realisations, and the scales of their results.
struct Bench<'a> {
    plan: &'a Plan,
    response: Arc<NormalResponse>,
    scales: Scales,
}

impl<'a> Bench<'a> {
    fn new(plan: &'a Plan, point: &Point) -> Result<Self, SweepError> {
        let response = Arc::new(NormalResponse::new(point.grid, &plan.config.body()?));
        let rms_gradient = plan.config.surface.rms_gradient;
        let scales = Scales { contact_modulus: response.contact_modulus(), rms_gradient };
        Ok(Self { plan, response, scales })
    }

    fn heights(&self, run: &Run) -> Result<Array2<f64>, SweepError> {
        let heights = self.plan.config.surface.heights(&self.plan.points[run.point], run.seed);
        heights.map_err(|source| SweepError::Surface { place: self.plan.place(run, None), source })
    }

    /// Presses one realisation with all loads; each load starts from the solution of the load before.
    fn press(&self, run: &Run, keep: &dyn Keep) -> Result<Vec<Pressed>, SweepError> {
        let contact = self.contact(run, (&self.heights(run)?.into_shared()).into())?;
        let p_star = &self.plan.config.loads.p_star;
        if let (Control::Approach, [first, .., last]) = (self.plan.config.loads.control, &p_star[..]) {
            return self.press_in_steps(run, &contact, [*first, *last], p_star.len(), keep);
        }
        let mut last: Option<Solution> = None;
        let mut loads = Vec::new();
        for &p_star in p_star {
            let solution = self.solve(run, &contact, p_star, last.as_ref(), keep)?;
            loads.push(Pressed::of(&solution, &self.scales));
            last = Some(solution);
        }
        Ok(loads)
    }

    /// Presses one realisation with `count` approaches in equal steps, between the approaches of the first and the last
    /// reduced pressure.
    fn press_in_steps(
        &self,
        run: &Run,
        contact: &Contact,
        [first, last]: [f64; 2],
        count: usize,
        keep: &dyn Keep,
    ) -> Result<Vec<Pressed>, SweepError> {
        let start = self.solve(run, contact, first, None, keep)?;
        let end = self.solve(run, contact, last, Some(&start), keep)?;
        let step = (end.approach - start.approach) / (count - 1) as f64;
        let mut loads = vec![Pressed::of(&start, &self.scales)];
        let mut state = start;
        for k in 1..count - 1 {
            let load = Load::Approach(loads[0].approach + k as f64 * step);
            state = self.equilibrate(run, contact, load, None, Some(&state), keep)?;
            loads.push(Pressed::of(&state, &self.scales));
        }
        loads.push(Pressed::of(&end, &self.scales));
        Ok(loads)
    }

    fn solve(
        &self,
        run: &Run,
        contact: &Contact,
        p_star: f64,
        last: Option<&Solution>,
        keep: &dyn Keep,
    ) -> Result<Solution, SweepError> {
        let pressure = p_star * self.scales.contact_modulus * self.scales.rms_gradient;
        self.equilibrate(run, contact, Load::MeanPressure(pressure), Some(p_star), last, keep)
    }

    /// Solves for one load; `p_star` is its name in messages.
    fn equilibrate(
        &self,
        run: &Run,
        contact: &Contact,
        load: Load,
        p_star: Option<f64>,
        last: Option<&Solution>,
        keep: &dyn Keep,
    ) -> Result<Solution, SweepError> {
        let mut watch = |_: &Progress| match keep.is_interrupted() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let solver = &self.plan.config.solver;
        let press = contact.press(load).solver(solver.method).budget(solver.budget());
        press.starting_from(last).watch(&mut watch).solve().map_err(|error| self.failed(run, p_star, error))
    }

    fn contact(&self, run: &Run, heights: Heights) -> Result<Contact, SweepError> {
        Contact::with_response(Arc::clone(&self.response), heights)
            .map_err(|refusal| self.failed(run, None, refusal.into()))
    }

    fn failed(&self, run: &Run, p_star: Option<f64>, error: SolveError<Solution>) -> SweepError {
        let place = self.plan.place(run, p_star);
        match error {
            SolveError::Interrupted { .. } => SweepError::Interrupted(place),
            error => SweepError::Contact { place, source: Box::new(error) },
        }
    }
}
