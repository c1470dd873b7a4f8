//! `kappa-sweep`: many contacts, one kappa in the thermodynamic, fractal and continuum limit.

pub mod config;
mod figures;
mod journal;
mod plan;
mod record;
mod report;

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::Instant;

use clap::Args as ClapArgs;
use gfmd_contact::{Budget, Contact, Equilibrium, Load, Solution, SolveError};
use gfmd_files::Output;
use gfmd_response::NormalResponse;
use gfmd_surface::SelfAffine;
use ndarray::Array2;
use rayon::prelude::*;

pub use config::{Config, Preset};
pub use plan::{Plan, Point, Run};
pub use report::{Analysis, Area, Extrapolation, Report};

use crate::failure::Failure;
use crate::load::LoadRecord;
use crate::memory::peak_bytes;
use crate::progress::Progress;
use crate::session::Session;
use journal::{Finished, Journal, Size};

/// Flags of `kappa-sweep`.
#[derive(ClapArgs, Clone, Debug)]
#[command(after_help = "Examples:
  gfmd kappa-sweep
  gfmd kappa-sweep --preset smoke --out smoke.h5
  gfmd kappa-sweep --preset thesis --dry-run
  gfmd kappa-sweep --config sweep.toml --out sweep.h5 --resume")]
pub struct Args {
    /// A sweep with a name
    #[arg(long, value_enum, default_value_t = Preset::Default, conflicts_with = "config")]
    pub preset: Preset,
    /// A sweep of your own, in TOML (docs/interface.md); what it leaves out is as in the preset "default"
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// The file to write; plots go beside it
    #[arg(long, default_value = "kappa.h5", value_name = "FILE.h5")]
    pub out: PathBuf,
    /// Continue a sweep that was interrupted or killed
    #[arg(long)]
    pub resume: bool,
    /// Print every point, its memory and the expected time, and compute nothing
    #[arg(long)]
    pub dry_run: bool,
    /// Print the configuration as TOML, to start a file of your own from, and compute nothing
    #[arg(long, conflicts_with = "dry_run")]
    pub show_config: bool,
}

/// What the command prints.
pub enum Outcome {
    /// The result of a sweep.
    Done(Box<Report>),
    /// The plan of one.
    Planned(report::PlanReport),
    /// A configuration.
    Config(String),
}

/// Runs the command.
///
/// # Errors
/// An unusable configuration; a contact that did not converge; a file that could not be written; an interruption. Finished
/// runs are kept in the journal beside the output, which the message names.
pub fn run(args: &Args, session: &Session) -> Result<Outcome, Failure> {
    let config = match &args.config {
        Some(path) => Config::read(path)?,
        None => args.preset.config(),
    };
    let plan = Plan::new(&config)?;
    let text = config.to_toml()?;
    if args.show_config {
        return Ok(Outcome::Config(text));
    }
    if args.dry_run {
        return Ok(Outcome::Planned(report::PlanReport::new(&config, &plan)?));
    }
    let output = Output::claim(&args.out).map_err(|error| Failure::input("--out", error))?;
    let size = Size { runs: plan.runs.len(), loads: config.loads.p_star.len() };
    let (journal, finished) = Journal::open(&output.beside(".journal"), &text, size, args.resume)?;
    let started = Instant::now();
    let records = compute(&config, &plan, &journal, finished, session)?;
    let analysis = report::Analysis::new(&config, &plan, &records)?;
    let seconds = started.elapsed().as_secs_f64();
    let example = example(&config, &plan)?;
    let path = record::write(&output, &config, &plan, &records, &analysis, &example, session, seconds)?;
    let plots = figures::draw(&args.out, &config, &plan, &analysis, &example)?;
    journal.remove();
    Ok(Outcome::Done(Box::new(Report::new(&config, &plan, analysis, path, plots, seconds, peak_bytes()))))
}

/// Computes what is not finished yet, point by point.
fn compute(
    config: &Config,
    plan: &Plan,
    journal: &Journal,
    finished: Finished,
    session: &Session,
) -> Result<Vec<Vec<LoadRecord>>, Failure> {
    let body = config.body()?;
    let total = plan.runs.iter().map(|run| plan.cost(&plan.points[run.point], 1.0)).sum();
    let progress = Progress::new(&session.common, "kappa sweep", total);
    let records = Mutex::new(finished);
    for (index, point) in plan.points.iter().enumerate() {
        let is_done = |run: usize| records.lock().is_ok_and(|records| records.contains_key(&run));
        let runs = plan.runs.iter().enumerate().filter(|(_, run)| run.point == index);
        let (done, open): (Vec<_>, Vec<_>) = runs.partition(|(number, _)| is_done(*number));
        let cost = plan.cost(point, 1.0);
        let note = format!("H = {}, n = {}", point.hurst, point.n);
        done.iter().for_each(|_| progress.advance(cost, &note));
        if open.is_empty() {
            continue;
        }
        let response = Arc::new(NormalResponse::new(plan.grid(point)?, &body));
        let one = |(number, run): &(usize, &Run)| {
            let loads = press(config, plan, point, run.seed, &response, session)?;
            journal.record(*number, &loads)?;
            progress.advance(cost, &note);
            if let Ok(mut records) = records.lock() {
                records.insert(*number, loads);
            }
            Ok(())
        };
        let outcome: Result<(), Failure> = if point.n <= plan::SIDE_BY_SIDE || config.surface.dim == 2 {
            open.par_iter().try_for_each(one)
        } else {
            open.iter().try_for_each(one)
        };
        if let Err(failure) = outcome {
            progress.finish();
            let kept = format!("; finished runs are in {}, --resume continues", journal.path().display());
            return Err(failure.with(&kept));
        }
    }
    progress.finish();
    Ok(records.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner).into_values().collect())
}

/// All loads of one realisation, each started from the one before.
fn press(
    config: &Config,
    plan: &Plan,
    point: &Point,
    seed: u64,
    response: &Arc<NormalResponse>,
    session: &Session,
) -> Result<Vec<LoadRecord>, Failure> {
    let heights = heights(config, plan, point, seed)?;
    let contact = Contact::on(Arc::clone(response), &heights).map_err(|error| Failure::input("surface", error))?;
    let mut last: Option<Solution> = None;
    let mut records = Vec::new();
    for &p_star in &config.loads.p_star {
        let started = Instant::now();
        let solution = solve(config, &contact, p_star, last.as_ref(), session).map_err(|error| {
            let d = point.discretisation;
            let place = format!(
                "H = {}, 1/eps = ({}, {}, {}), seed {seed}, p* = {p_star}",
                point.hurst, d.eps_t_inv, d.eps_f_inv, d.eps_c_inv
            );
            match error {
                SolveError::Interrupted { .. } => Failure::Interrupted(format!("interrupted at {place}")),
                error => Failure::Computation(format!("{place}: {error}")),
            }
        })?;
        records.push(LoadRecord::measure(
            &solution,
            response.contact_modulus(),
            config.surface.rms_gradient,
            config.solver.tol,
            started.elapsed().as_secs_f64(),
        ));
        last = Some(solution);
    }
    Ok(records)
}

fn solve(
    config: &Config,
    contact: &Contact,
    p_star: f64,
    last: Option<&Solution>,
    session: &Session,
) -> Result<Solution, SolveError<Solution>> {
    let budget = Budget { tolerance: config.solver.tol, max_iterations: config.solver.max_iter };
    let pressure = p_star * contact.response().contact_modulus() * config.surface.rms_gradient;
    let mut watch = |_: &gfmd_contact::Progress| match session.is_interrupted() {
        true => ControlFlow::Break(()),
        false => ControlFlow::Continue(()),
    };
    let press = contact.press(Load::MeanPressure(pressure)).budget(budget).solver(config.solver.method);
    press.starting_from(last).watch(&mut watch).solve()
}

fn heights(config: &Config, plan: &Plan, point: &Point, seed: u64) -> Result<Array2<f64>, Failure> {
    let spectrum = point.discretisation.self_affine(
        1.0,
        SelfAffine { hurst: point.hurst, ..SelfAffine::with_rms_gradient(config.surface.rms_gradient) },
    );
    spectrum.heights(&plan.grid(point)?, seed).map_err(|error| Failure::input("surface", error))
}

/// A contact to look at: the first realisation at the load of the result, on the largest grid of moderate size.
pub struct Example {
    /// Its point.
    pub point: Point,
    /// Its seed.
    pub seed: u64,
    /// The pressure field.
    pub pressure: Array2<f64>,
    /// The surface.
    pub heights: Array2<f64>,
}

/// Points along one axis up to which a contact map is computed once more for the picture.
const EXAMPLE_POINTS: usize = 1024;

fn example(config: &Config, plan: &Plan) -> Result<Example, Failure> {
    let moderate = plan.points.iter().filter(|point| point.n <= EXAMPLE_POINTS || config.surface.dim == 2);
    let point = *moderate.max_by_key(|point| point.n).unwrap_or(&plan.points[0]);
    let response = NormalResponse::new(plan.grid(&point)?, &config.body()?);
    let heights = heights(config, plan, &point, point.first_seed)?;
    let contact = Contact::on(response, &heights).map_err(|error| Failure::input("surface", error))?;
    let silent = Session::silent(crate::session::Common { json: false, threads: 0, quiet: true, verbose: 0 });
    let solution = solve(config, &contact, config.fit.p_star, None, &silent)
        .map_err(|error| Failure::Computation(error.to_string()))?;
    Ok(Example { point, seed: point.first_seed, pressure: solution.pressure, heights })
}
