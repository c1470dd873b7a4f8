//! `kappa-sweep`: kappa in the thermodynamic, fractal and continuum limit, from many contacts.

mod calibration;
mod check;
mod config;
mod file;
mod protocol;
mod report;
mod stored;

use std::error::Error;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use clap::Args as ClapArgs;
use gfmd_files::{Output, target};
use gfmd_problem::options::Options;
use gfmd_problem::{MemoryNeed, Words, key, words};
use gfmd_sweep::{Example, Extrapolation, Keep, Plan, Preset, Pressed, Run, Shard, Study, run_shard};
use serde::Deserialize;

pub(crate) use check::check;
pub use check::report_of;
pub use config::Configured;
pub use protocol::ProtocolReport;
pub use report::{PlanReport, Report, ShardReport};

use crate::progress::Progress;
use gfmd_input::failure::Failure;
use gfmd_input::memory::{self, peak_bytes};
use gfmd_input::session::Session;
use gfmd_problem::options::values::parsed;
use gfmd_problem::options::{named, parse_choice};
use gfmd_report::figures::check_names;
use gfmd_run::parts::{self, Gathered, Journal, Merge, Work, remark};

/// Finished runs by number.
type Finished = parts::Finished<Vec<Pressed>>;

/// Flags of `kappa-sweep`.
#[derive(ClapArgs, Options, Clone, Debug, Deserialize)]
#[serde(default)]
#[command(after_help = "Examples:
  gfmd kappa-sweep
  gfmd kappa-sweep --preset smoke --out smoke.h5
  gfmd kappa-sweep --preset thesis --dry-run
  gfmd kappa-sweep --config sweep.toml --out sweep.h5 --resume
  gfmd kappa-sweep --config other-fit.toml --runs-of sweep.h5 --out other-fit.h5
  gfmd kappa-sweep --config sweep.toml --out sweep.h5 --resume --shard 3/64
  gfmd kappa-sweep --config sweep.toml --out sweep.h5 --merge")]
pub struct Args {
    /// Named sweep to compute
    #[arg(
        long,
        default_value_t = Preset::Default,
        value_parser = parse_choice::<Preset>(),
        conflicts_with = "config"
    )]
    #[serde(with = "named")]
    pub preset: Preset,
    /// Sweep configuration in TOML (docs/interface.md); missing fields come from the preset "default"
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<Configured>,
    /// Write the results to this file, and plots beside it
    #[arg(long, default_value = "kappa.h5", value_name = "FILE.h5")]
    #[option(default = "kappa.h5".into())]
    pub out: PathBuf,
    /// Continue an interrupted or killed sweep
    #[arg(long)]
    pub resume: bool,
    /// Reanalyse the contacts of this result, whose configuration may differ only in the fit
    #[arg(long, value_name = "FILE.h5", conflicts_with = "resume")]
    pub runs_of: Option<PathBuf>,
    /// Compute only shard K (from 0) of M, of about equal work, into a journal beside --out, without a result: any
    /// scheduler can start shards (docs/cluster.md)
    #[arg(long, value_name = "K/M", conflicts_with_all = ["runs_of", "merge", "show_config"])]
    #[serde(deserialize_with = "parsed")]
    pub shard: Option<Shard>,
    /// Merge all journals of this sweep beside --out, compute missing runs, and write the result
    #[arg(long, conflicts_with_all = ["runs_of", "show_config"])]
    pub merge: bool,
    /// Add surfaces where they help most until the relative statistical error of kappa_TFC (half of its 95 % interval
    /// divided by its value) is at most this: 0.005 for half a percent
    #[arg(
        long,
        value_name = "ERROR",
        conflicts_with_all = ["runs_of", "shard", "merge"],
        allow_negative_numbers = true
    )]
    pub target: Option<f64>,
    /// Print every point, its memory and the expected time; compute nothing
    #[arg(long)]
    pub dry_run: bool,
    /// Print the configuration in TOML, as a template for --config; compute nothing
    #[arg(long, conflicts_with = "dry_run")]
    pub show_config: bool,
}

/// The bytes of a finished contact: in the journal, in the result and in the file.
const CONTACT_BYTES: u64 = 1024;

/// The numbers of the runs of a point in the journal of a sweep with a target, whose points grow.
const REALISATIONS: usize = 1_000_000;

/// The bytes of the program itself, with its threads and the libraries.
const PROGRAM_BYTES: u64 = 64 << 20;

/// The output of the command.
pub enum Outcome {
    /// The result of a sweep.
    Done(Box<Report>),
    /// The runs of a shard, in its journal.
    Shard(ShardReport),
    /// The plan of a sweep.
    Planned(PlanReport),
    /// A configuration as TOML.
    Config(String),
}

/// Runs the command.
///
/// # Errors
/// An unusable configuration; a contact that did not converge; a file that could not be written; an interruption.
/// Finished runs are kept in the journal beside the output, which the message names.
pub fn run(args: &Args, session: &Session) -> Result<Outcome, Failure> {
    let mut config = match &args.config {
        Some(configured) => configured.read()?,
        None => args.preset.config(),
    };
    if let Some(target) = args.target {
        if target != 0.0 && !(1e-5..=1.0).contains(&target) {
            return Err(Failure::value(key("target"), target, "from 1e-5 to 1, or 0 for none"));
        }
        config.statistics.target = target;
    }
    if config.statistics.target != 0.0 && (args.shard.is_some() || args.merge || args.runs_of.is_some()) {
        let option = if args.runs_of.is_some() { key("runs_of") } else { words![key("shard"), " and ", key("merge")] };
        let reason = "a sweep with statistics.target does not know its runs beforehand; statistics.surfaces gives them";
        return Err(Failure::input(option, reason));
    }
    let text = config::text(&config)?;
    let plan = Plan::new(config)?;
    let (mut runs, loads) = (plan.runs.len(), plan.config.loads.p_star.len());
    memory::check_count(
        "statistics.realisations",
        "contacts",
        (runs as u64).saturating_mul(loads as u64),
        CONTACT_BYTES,
    )?;
    if plan.config.statistics.target > 0.0 {
        runs = plan.points.len() * REALISATIONS;
    }
    let refuse = move |found: &Vec<Pressed>| {
        (found.len() != loads).then(|| format!("the run has {} loads; it must have {loads}", found.len()))
    };
    let work = Work { name: "sweep", config: text, parts: runs, refuse: Box::new(refuse) };
    let sweep = Sweep { args, session, plan, work };
    match args.shard {
        Some(shard) if args.dry_run => {
            Ok(Outcome::Planned(PlanReport::new(&sweep.plan, &sweep.plan.runs_of_shard(shard), Some(shard))?))
        }
        Some(shard) => sweep.compute_shard(shard),
        None if args.merge => sweep.merge(),
        None => sweep.compute(),
    }
}

/// A sweep that was asked for.
struct Sweep<'a> {
    args: &'a Args,
    session: &'a Session,
    plan: Plan,
    /// The runs, with the configuration as TOML.
    work: Work<Vec<Pressed>>,
}

impl Sweep<'_> {
    fn all(&self) -> Vec<usize> {
        (0..self.plan.runs.len()).collect()
    }

    /// Refuses runs whose grids do not fit into memory.
    fn check_memory(&self, runs: &[usize]) -> Result<(), Failure> {
        let mut points: Vec<usize> = runs.iter().map(|run| self.plan.runs[*run].point).collect();
        points.dedup();
        points.into_iter().try_for_each(|point| self.check_grid(point))
    }

    fn check_grid(&self, point: usize) -> Result<(), Failure> {
        memory::fits(MemoryNeed::HARD_WALL, "the grid", self.plan.points[point].grid.points())
    }

    /// Computes all runs in this process.
    fn compute(self) -> Result<Outcome, Failure> {
        if self.args.show_config {
            return Ok(Outcome::Config(self.work.config));
        }
        let all = self.all();
        self.check_memory(&all)?;
        if self.args.dry_run {
            return Ok(Outcome::Planned(PlanReport::new(&self.plan, &all, None)?));
        }
        let earlier = self.args.runs_of.as_deref().map(|path| check::earlier(path, &self.plan)).transpose()?;
        let output = self.claim()?;
        // The target gives way to the numbers of surfaces in the configuration of the result.
        let counts = |line: &&str| !["target", "surfaces"].iter().any(|name| line.starts_with(&format!("{name} = ")));
        let counts = if self.plan.config.statistics.target > 0.0 { counts } else { |_: &&str| true };
        self.work.check_finished(&output, self.args.resume, counts)?;
        let (journal, mut finished) = Journal::open(&output.beside(".journal"), &self.work, self.args.resume)?;
        finished.extend(earlier.into_iter().flatten().enumerate());
        let kept = parts::resumes(journal.path());
        self.conclude(&output, journal, finished, &kept)
    }

    /// Computes the runs of a shard.
    fn compute_shard(self, shard: Shard) -> Result<Outcome, Failure> {
        let runs = self.plan.runs_of_shard(shard);
        self.check_memory(&runs)?;
        let output = parts::claim_shard(&self.args.out, shard)?;
        let (journal, finished) = Journal::open(&output.beside(".journal"), &self.work, self.args.resume)?;
        let started = Instant::now();
        let keeper = Keeper::new(&self.plan, &runs, journal, finished, self.session);
        let computed = run_shard(&self.plan, shard, &keeper);
        keeper.progress.finish();
        let journal = keeper.journal.path().to_path_buf();
        computed
            .map_err(|error| Failure::from(error).with(remark("finished runs", &journal, parts::resumes(&journal))))?;
        Ok(Outcome::Shard(ShardReport {
            shard: shard.to_string(),
            runs: runs.len(),
            all_runs: self.work.parts,
            journal,
            seconds: started.elapsed().as_secs_f64(),
            peak_bytes: peak_bytes(),
        }))
    }

    /// Takes the runs from the journals of all shards, and computes those that are missing.
    fn merge(self) -> Result<Outcome, Failure> {
        if self.args.dry_run {
            let out = target(&self.args.out).map_err(|error| Failure::input(key("out"), error))?;
            let gathered = Gathered::read(&out, &self.work, false)?;
            let missing = self.work.missing(&gathered.finished);
            return Ok(Outcome::Planned(PlanReport::new(&self.plan, &missing, None)?));
        }
        let output = self.claim()?;
        let stored = || stored::stored(output.path(), &self.work.config, &self.plan);
        let Merge { finished, open, gathered } = self.work.merge(&output, |count| self.plan.shards(count), stored)?;
        self.check_memory(&open)?;
        self.check_grid(Example::point(&self.plan))?;
        let (journal, _) = Journal::open(&output.beside(".journal"), &self.work, true)?;
        let outcome = self.conclude(&output, journal, finished, &parts::merges(&output))?;
        gathered.remove();
        Ok(outcome)
    }

    fn claim(&self) -> Result<Output, Failure> {
        let output = parts::claim(&self.args.out)?;
        check_names(&gfmd_report::kappa::figures::stem(&self.args.out))
            .map_err(|reason| Failure::input(key("out"), reason))?;
        Ok(output)
    }

    /// Computes the runs that are not finished, and writes the result; `kept` names what is kept if that fails.
    fn conclude(
        &self,
        output: &Output,
        journal: Journal,
        finished: Finished,
        kept: &Words,
    ) -> Result<Outcome, Failure> {
        let Self { args, session, plan, .. } = self;
        let started = Instant::now();
        let keeper = Keeper::new(plan, &self.all(), journal, finished, session);
        let study = Study::new(plan.clone(), &keeper);
        keeper.progress.finish();
        let study = study
            .map_err(|error| Failure::from(error).with(remark("finished runs", keeper.journal.path(), kept.clone())))?;
        let seconds = started.elapsed().as_secs_f64();
        for Extrapolation { hurst, p_star, area, fit, .. } in &study.analysis.extrapolations {
            let place = format!("H = {hurst}, p* = {p_star}, area {}", area.name());
            fit.warnings.iter().for_each(|warning| session.note(warning.code(), format!("{place}: {warning}")));
        }
        // With a target, the configuration of the result has the numbers of surfaces that it came to.
        let text = config::text(&study.plan.config)?;
        let path = file::write(output, &study, &session.provenance(text), seconds)
            .map_err(|error| error.with(remark("all runs", keeper.journal.path(), kept.clone())))?;
        keeper.journal.remove();
        let plots = gfmd_report::kappa::figures::draw(&args.out, &study)?;
        Ok(Outcome::Done(Box::new(Report::new(&study.plan, &study.analysis, (path, plots), (seconds, peak_bytes())))))
    }
}

/// The journal, the progress bar and Ctrl-C of a sweep.
struct Keeper<'a> {
    plan: &'a Plan,
    journal: Journal,
    finished: Mutex<Finished>,
    progress: Progress,
    session: &'a Session,
}

impl<'a> Keeper<'a> {
    /// The keeper of these runs of a plan.
    fn new(plan: &'a Plan, runs: &[usize], journal: Journal, finished: Finished, session: &'a Session) -> Self {
        let work = runs.iter().map(|run| plan.work(&plan.points[plan.runs[*run].point])).sum();
        let progress = Progress::of_sizes(session, "runs", runs.len(), work);
        Self { plan, journal, finished: Mutex::new(finished), progress, session }
    }

    /// The number of a run in the journal.
    fn number(&self, run: &Run) -> usize {
        let first = match self.plan.config.statistics.target > 0.0 {
            true => run.point * REALISATIONS,
            false => self.plan.runs_of(run.point).start,
        };
        first + run.realisation as usize
    }

    fn advance(&self, run: &Run) {
        let point = &self.plan.points[run.point];
        self.progress.advance(self.plan.work(point), &format!("H = {}, n = {}", point.hurst, point.n()));
    }
}

impl Keep for Keeper<'_> {
    fn recall(&self, run: &Run) -> Option<Vec<Pressed>> {
        let number = self.number(run);
        let loads = self.finished.lock().unwrap_or_else(PoisonError::into_inner).remove(&number);
        loads.inspect(|_| self.advance(run))
    }

    fn keep(&self, run: &Run, loads: &[Pressed]) -> Result<(), Box<dyn Error + Send + Sync>> {
        self.journal.record(self.number(run), &loads.to_vec())?;
        self.advance(run);
        Ok(())
    }

    fn more(&self, plan: &Plan, reached: f64) {
        let target = 100.0 * plan.config.statistics.target;
        let more = plan.runs.len();
        tracing::info!("statistical error {:.2} %, target {target:.2} %: up to {more} surfaces", 100.0 * reached);
        self.progress.extend(more, plan.runs.iter().map(|run| plan.work(&plan.points[run.point])).sum());
    }

    fn is_interrupted(&self) -> bool {
        self.session.is_interrupted()
    }
}
