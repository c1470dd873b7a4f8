//! `slide`: a rough surface that slides steadily over a viscoelastic body.

mod check;
mod file;
mod report;

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args as ClapArgs;
use gfmd_contact::{Boundary, Budget, Contact, Dynamics, Load, SolveError, Solver};
use gfmd_problem::options::flags::without_flags;
use gfmd_problem::options::values::{Entry, as_numbers, from_numbers, numbers};
use gfmd_problem::options::{BodyArgs, ComplianceArgs, LawArgs, PronyArgs};
use gfmd_problem::{Facts, GridError};
use gfmd_report::figures::parse_prefix;
use gfmd_run::base::BaseArgs;
use gfmd_run::failure::{Failure, Outcome};
use gfmd_run::lower::LowerArgs;
use gfmd_run::memory::peak_bytes;
use gfmd_run::series::{Asked, Head, Prepared};
use gfmd_run::session::Session;
use gfmd_run::source::SourceArgs;
use gfmd_viscoelastic::{SlidingContact, SlidingState, Velocity, VelocityError};
use serde::{Deserialize, Serialize};

use crate::contact::ControlArgs;
use crate::progress::Progress;

pub(crate) use self::check::{again, check};
use self::file::StatesFile;
pub use self::report::{Report, State};

/// Flags of `slide`.
#[derive(ClapArgs, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(after_help = "Examples:
  gfmd slide --n 256 --prony 1e-3:0.3,1e-1:0.3,10:0.3 --p-star 0.05 --velocity 1e-3:1e4:15 --plots rubber
  gfmd slide --n 128 --height 0.2 --poisson 0.48 --relaxes shear --prony 0.1:0.8 --pressure 0.01,0.05 --velocity 1 --direction 30 --json")]
pub struct Args {
    #[command(flatten)]
    #[serde(flatten)]
    source: SourceArgs,
    #[command(flatten)]
    #[serde(flatten)]
    body: BodyArgs,
    #[command(flatten)]
    #[serde(flatten)]
    prony: PronyArgs,
    #[command(flatten)]
    #[serde(flatten)]
    control: ControlArgs,
    /// Velocities of the rigid surface relative to the body, length over the unit of the relaxation times; A:B:N is N
    /// values from A to B in geometric steps. Each load is solved at each of them
    #[arg(long, value_delimiter = ',', value_name = "V1|A:B:N,..", required = true, allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    velocity: Vec<Entry>,
    /// Direction of the velocity, degrees from x
    #[arg(long, default_value_t = 0.0, value_name = "DEG", allow_negative_numbers = true)]
    direction: f64,
    /// Largest residual of a converged state
    #[arg(long, default_value_t = 1e-8, value_name = "TOL", allow_negative_numbers = true)]
    tol: f64,
    /// Largest number of iterations for one state
    #[arg(long, default_value_t = 100_000, value_name = "N")]
    max_iter: u64,
    /// Write the states and their fields to this HDF5 file
    #[arg(long, value_name = "FILE.h5")]
    #[serde(skip)]
    out: Option<PathBuf>,
    /// Draw the friction against the velocity, with Persson's theory: PREFIX-friction.svg, .png
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix)]
    #[serde(skip)]
    plots: Option<PathBuf>,
}

impl Default for Args {
    fn default() -> Self {
        without_flags()
    }
}

impl Args {
    fn budget(&self) -> Budget {
        Budget { tolerance: self.tol, max_iterations: self.max_iter }
    }

    /// Gives the problem that the flags ask for to `take`.
    fn asked<T>(&self, take: impl FnOnce(&Asked) -> Result<T, Failure>) -> Result<T, Failure> {
        let (body, prony) = (self.prony.long_term(&self.body)?, self.prony.series()?);
        take(&Asked {
            source: &self.source,
            body: &body,
            compliance: &ComplianceArgs::default(),
            base: &BaseArgs::default(),
            lower: &LowerArgs::default(),
            law: &LawArgs::default(),
            hardness: None,
            limit: None,
            prony: prony.as_ref(),
            wear: None,
            boundary: Boundary::Periodic,
            dynamics: Dynamics::default(),
            solver: Solver::Auto,
            budget: self.budget(),
            once: false,
        })
    }

    /// The resolved configuration as TOML.
    fn config(&self) -> Result<String, Failure> {
        let resolved = Self { source: self.source.resolved()?, ..self.clone() };
        toml::to_string(&resolved).map_err(|error| Failure::Computation(error.to_string()))
    }

    fn velocities(&self) -> Result<Vec<Velocity>, Failure> {
        let velocity = |speed: f64| {
            Velocity::new(speed, self.direction).map_err(|error| match error {
                VelocityError::Speed(found) => Failure::value("--velocity", found, "positive and finite"),
                VelocityError::Direction(found) => Failure::value("--direction", found, "finite"),
            })
        };
        let made = numbers(&self.velocity).map(velocity).collect::<Result<Vec<_>, Failure>>()?;
        if made.is_empty() {
            return Err(Failure::Input("--velocity is missing; it must have at least one value".into()));
        }
        Ok(made)
    }
}

/// The input of the command, checked before the first solve.
struct Way {
    prepared: Prepared,
    sliding: SlidingContact,
    loads: Vec<Load>,
    velocities: Vec<Velocity>,
}

impl Way {
    fn new(args: &Args, session: &Session) -> Result<Self, Failure> {
        args.control.check(false)?;
        let velocities = args.velocities()?;
        let missing = || Failure::Input("--prony is missing; it is needed to slide".into());
        if args.prony.relaxing().is_none() {
            return Err(missing());
        }
        let facts = |line: bool| Facts {
            line,
            relaxes: args.prony.relaxing(),
            approach: args.control.flag() == "--displacement",
            grid_error: GridError::None,
            ..args.body.facts()
        };
        let prepared = args.asked(|asked| Prepared::new(asked, facts, session))?;
        args.body.check_modulus(prepared.surface.unit.as_deref())?;
        let Prepared { surface, body, prony, .. } = &prepared;
        let contact = Contact::new(body, &surface.grid, &surface.heights);
        let contact = contact.map_err(|refusal| Failure::input(&args.source.name(), refusal))?;
        let sliding = SlidingContact::new(contact, body, prony.as_ref().ok_or_else(missing)?, args.prony.relaxes);
        let sliding = sliding.map_err(|refusal| Failure::input(&args.source.name(), refusal))?;
        let loads = args.control.loads(prepared.unit_pressure()).collect();
        Ok(Self { prepared, sliding, loads, velocities })
    }

    /// Every load at every velocity, loads outer.
    fn states(&self) -> impl Iterator<Item = (Load, &Velocity)> {
        self.loads.iter().flat_map(|load| self.velocities.iter().map(|velocity| (*load, velocity)))
    }
}

/// Runs the command.
///
/// # Errors
/// Unusable input; a file that could not be written.
pub fn run(args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
    let way = Way::new(args, session)?;
    let Way { prepared, sliding, velocities, .. } = &way;
    let output = session.output(args.out.as_ref())?;
    let mut head = args.asked(|asked| Ok(Head::new(asked, prepared, sliding.contact().surface())))?;
    head.relaxation = args.prony.told(&args.body)?;
    let direction = velocities[0].direction();
    let mut report = Report { head, direction, states: Vec::new(), peak_bytes: 0, out: None, plots: Vec::new() };
    let count = way.states().count();
    let config = args.config()?;
    let file = output.as_ref().map(|output| StatesFile::new(output, &session.provenance(config), prepared, count));
    let mut file = file.transpose()?;
    let progress = Progress::new(session.quiet, "states", count as f64);
    let (mut failure, mut last): (Option<Failure>, Option<SlidingState>) = (None, None);
    for (index, (load, velocity)) in way.states().enumerate() {
        let (started, place) = (Instant::now(), format!("state {index}"));
        let mut watch = |_: &gfmd_contact::Progress| match session.is_interrupted() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        // The first velocity of a load starts anew.
        let start = last.as_ref().filter(|_| !index.is_multiple_of(velocities.len()));
        let state = match sliding.slide(velocity, load, &args.budget(), start, &mut watch) {
            Ok(state) => state,
            Err(SolveError::Refused(refusal)) if index == 0 => {
                return Err(Failure::input(args.control.flag(), refusal));
            }
            Err(SolveError::Refused(refusal)) => {
                failure = Some(Failure::Computation(refusal.to_string()).at(&place));
                break;
            }
            Err(error) => {
                let text = error.to_string();
                let is_cut = matches!(error, SolveError::Interrupted { .. });
                failure = Some(if is_cut { Failure::Interrupted(text) } else { Failure::Computation(text) }.at(&place));
                let Some(state) = error.into_state() else { break };
                state
            }
        };
        let persson = sliding.persson(velocity, state.solution.mean_pressure);
        let seconds = started.elapsed().as_secs_f64();
        let record = State::new(velocity, &state, persson, (&prepared.scales(), args.tol), seconds);
        progress.advance(1.0, &format!("velocity {:.3e}, friction {:.4}", record.velocity, record.friction));
        if let Some(file) = &mut file {
            file.write(index, &state)?;
        }
        report.states.push(record);
        if failure.is_some() {
            break;
        }
        last = Some(state);
    }
    progress.finish();
    let out = file.map(|file| file.finish(&report.states, count)).transpose()?;
    report.out = session.written(out);
    report.peak_bytes = peak_bytes();
    if let (None, Some(prefix)) = (&failure, &args.plots) {
        report.plots = report.draw(prefix, velocities.len())?;
    }
    Ok(Outcome { report, failure })
}
