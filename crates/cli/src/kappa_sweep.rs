//! `kappa-sweep`: kappa in the thermodynamic, fractal and continuum limit, from many contacts.

mod calibration;
mod check;
mod config;
mod figures;
mod file;
mod journal;
mod page;
mod protocol;
mod report;

use std::error::Error;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use clap::Args as ClapArgs;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use gfmd_contact::SolveError;
use gfmd_files::Output;
use gfmd_sweep::{Extrapolation, Keep, Plan, Preset, Pressed, Study, SweepError};

pub(crate) use check::check;
pub(crate) use page::page;
pub use protocol::ProtocolReport;
pub use report::{PlanReport, Report};

use crate::failure::Failure;
use crate::memory::{self, Held, peak_bytes};
use crate::progress::Progress;
use crate::session::Session;
use journal::{Finished, Journal, Size};

/// Flags of `kappa-sweep`.
#[derive(ClapArgs, Clone, Debug)]
#[command(after_help = "Examples:
  gfmd kappa-sweep
  gfmd kappa-sweep --preset smoke --out smoke.h5
  gfmd kappa-sweep --preset thesis --dry-run
  gfmd kappa-sweep --config sweep.toml --out sweep.h5 --resume
  gfmd kappa-sweep --config other-fit.toml --runs-of sweep.h5 --out other-fit.h5")]
pub struct Args {
    /// Sweep to compute, by name
    #[arg(long, default_value = Preset::Default.name(), value_parser = preset(), conflicts_with = "config")]
    pub preset: Preset,
    /// Configuration of a sweep in TOML (docs/interface.md); missing fields are those of the preset "default"
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Write the results to this file, and plots beside it
    #[arg(long, default_value = "kappa.h5", value_name = "FILE.h5")]
    pub out: PathBuf,
    /// Continue a sweep that was interrupted or killed
    #[arg(long)]
    pub resume: bool,
    /// Take the contacts from this result, whose configuration may differ in the fit only, and analyse them anew
    #[arg(long, value_name = "FILE.h5", conflicts_with = "resume")]
    pub runs_of: Option<PathBuf>,
    /// Print every point, its memory and the expected time, and compute nothing
    #[arg(long)]
    pub dry_run: bool,
    /// Print the configuration as TOML, as a template for --config, and compute nothing
    #[arg(long, conflicts_with = "dry_run")]
    pub show_config: bool,
}

fn preset() -> impl TypedValueParser<Value = Preset> {
    let names = Preset::ALL.map(|preset| PossibleValue::new(preset.name()).help(preset.meaning()));
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Preset>())
}

/// The bytes of a finished contact: in the journal, in the result and in the file.
const CONTACT_BYTES: u64 = 1024;

/// The output of the command.
pub enum Outcome {
    /// The result of a sweep.
    Done(Box<Report>),
    /// The plan of a sweep.
    Planned(PlanReport),
    /// A configuration as TOML.
    Config(String),
}

/// Runs the command.
///
/// # Errors
/// An unusable configuration; a contact that did not converge; a file that could not be written; an interruption. Finished
/// runs are kept in the journal beside the output, which the message names.
pub fn run(args: &Args, session: &Session) -> Result<Outcome, Failure> {
    let config = match &args.config {
        Some(path) => config::read(path)?,
        None => args.preset.config(),
    };
    let text = config::text(&config)?;
    let plan = Plan::new(config)?;
    plan.points.iter().try_for_each(|point| Held::HARD_WALL.check("the grid", point.grid.points()))?;
    let (runs, loads) = (plan.runs.len() as u64, plan.config.loads.p_star.len() as u64);
    memory::check_count("statistics.realisations", "contacts", runs.saturating_mul(loads), CONTACT_BYTES)?;
    if args.show_config {
        return Ok(Outcome::Config(text));
    }
    if args.dry_run {
        return Ok(Outcome::Planned(PlanReport::new(&plan)?));
    }
    let earlier = args.runs_of.as_deref().map(|path| check::earlier(path, &plan)).transpose()?;
    let output = Output::claim(&args.out).map_err(|error| Failure::input("--out", error))?;
    let size = Size { runs: plan.runs.len(), loads: plan.config.loads.p_star.len() };
    let (journal, mut finished) = Journal::open(&output.beside(".journal"), &text, size, args.resume)?;
    finished.extend(earlier.into_iter().flatten().enumerate());
    let started = Instant::now();
    let keeper = Keeper::new(&plan, journal, finished, session);
    let study = Study::new(plan.clone(), &keeper);
    keeper.progress.finish();
    let study = study.map_err(|error| {
        let kept = format!("; finished runs are in {}, --resume continues", keeper.journal.path().display());
        Failure::from(error).with(&kept)
    })?;
    let seconds = started.elapsed().as_secs_f64();
    for Extrapolation { hurst, p_star, area, fit, .. } in &study.analysis.extrapolations {
        let place = format!("H = {hurst}, p* = {p_star}, area {}", area.name());
        fit.warnings.iter().for_each(|warning| session.note(warning.code(), format!("{place}: {warning}")));
    }
    let kept = format!("; all runs are in {}, --resume continues", keeper.journal.path().display());
    let path = file::write(&output, &study, &session.provenance(text), seconds).map_err(|error| error.with(&kept))?;
    keeper.journal.remove();
    let plots = figures::draw(&args.out, &study)?;
    Ok(Outcome::Done(Box::new(Report::new(&study, path, plots, seconds, peak_bytes()))))
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
    fn new(plan: &'a Plan, journal: Journal, finished: Finished, session: &'a Session) -> Self {
        let work = plan.runs.iter().map(|run| plan.work(&plan.points[run.point])).sum();
        let progress = Progress::new(&session.common, "kappa sweep", work);
        Self { plan, journal, finished: Mutex::new(finished), progress, session }
    }

    fn advance(&self, run: usize) {
        let point = &self.plan.points[self.plan.runs[run].point];
        self.progress.advance(self.plan.work(point), &format!("H = {}, n = {}", point.hurst, point.n()));
    }
}

impl Keep for Keeper<'_> {
    fn recall(&self, run: usize) -> Option<Vec<Pressed>> {
        let loads = self.finished.lock().unwrap_or_else(PoisonError::into_inner).remove(&run);
        loads.inspect(|_| self.advance(run))
    }

    fn keep(&self, run: usize, loads: &[Pressed]) -> Result<(), Box<dyn Error + Send + Sync>> {
        self.journal.record(run, loads)?;
        self.advance(run);
        Ok(())
    }

    fn is_interrupted(&self) -> bool {
        self.session.is_interrupted()
    }
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        let text = error.to_string();
        match error {
            SweepError::Contact { source, .. } if matches!(*source, SolveError::Refused(_)) => Self::Input(text),
            SweepError::Contact { .. } | SweepError::Keep(_) => Self::Computation(text),
            SweepError::Interrupted(_) => Self::Interrupted(text),
            _ => Self::Input(text),
        }
    }
}
