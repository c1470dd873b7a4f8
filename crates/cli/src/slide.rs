//! `slide`: a rough surface that slides steadily over a body, with hysteresis, flash temperature, or both.

mod check;
mod file;
mod heat;
mod report;
mod steady_state;
mod stored;

use std::borrow::Cow;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args as ClapArgs;
use gfmd_contact::{Contact, Load, Refusal, SolveError, Visit};
use gfmd_files::Output;
use gfmd_heat::HeatError;
use gfmd_input::failure::{Failure, Outcome, or_none};
use gfmd_input::hardness::HardnessArgs;
use gfmd_input::memory::peak_bytes;
use gfmd_input::session::Session;
use gfmd_input::source::SourceArgs;
use gfmd_medium::{SlidingContact, SlidingError, Velocity, VelocityError};
use gfmd_problem::options::flags::toml_of;
use gfmd_problem::options::values::{Entry, as_numbers, from_numbers, numbers};
use gfmd_problem::options::{BodyArgs, PronyArgs, named, parse_choice_but};
use gfmd_problem::{Facts, GridError, Inelastic, SIZES, Unusable, key, words};
use gfmd_record::{Record, Sliding, SlidingContext, SlidingFacts};
use gfmd_report::figures::parse_prefix;
use gfmd_run::resume::{FinishedStep, ResumeArgs, UnfinishedRun};
use gfmd_run::series::{Asked, Head, Prepared, at_same_place, run_with_journal, sources};
use ndarray::Array2;
use serde::{Deserialize, Serialize};

use crate::loads::{LoadArgs, Sign};
use crate::progress::Progress;
use gfmd_problem::options::SearchArgs;

use self::file::{StatesFile, fields};
use self::heat::{HeatArgs, Source};
pub use self::report::Report;
use self::steady_state::SteadyState;
pub use self::stored::stored;
use gfmd_problem::options::{Kinds, Options};

/// Flags of `slide`.
#[derive(ClapArgs, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(after_help = "Examples:
  gfmd slide --n 256 --prony 1e-3:0.3,1e-1:0.3,10:0.3 --p-star 0.05 --velocity 1e-3:1e4:15 --plots rubber
  gfmd slide --n 128 --height 0.2 --poisson 0.48 --relaxes shear --prony 0.1:0.8 --pressure 0.01,0.05 --velocity 1 \
    --direction 30 --json
  gfmd slide --n 256 --p-star 0.02 --heat 1,0.01,0.2,0.1 --friction 0.3 --velocity 0.01:100:9 --plots warm")]
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
    control: LoadArgs,
    /// Friction coefficient of the interface (Coulomb), 0 for none: all points slide, and the shear MU p along the
    /// velocity lifts the surface of a compressible body, adds to the friction, and generates the heat MU p v
    #[arg(long, value_name = "MU", allow_negative_numbers = true, help_heading = "Contact")]
    #[serde(skip_serializing_if = "Option::is_none")]
    friction: Option<f64>,
    #[command(flatten)]
    #[serde(flatten)]
    hardness: HardnessArgs,
    #[command(flatten)]
    #[serde(flatten)]
    heat: HeatArgs,
    /// Velocities of the rigid surface relative to the body, length divided by the time unit of relaxation times and
    /// diffusivity; A:B:N is N values from A to B in geometric steps. Each load is solved at each velocity
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "V1|A:B:N,..",
        required = true,
        allow_negative_numbers = true,
        help_heading = "Load"
    )]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    #[option(kinds = Kinds::VELOCITY)]
    velocity: Vec<Entry>,
    /// Direction of the velocity, degrees from x
    #[arg(long, default_value_t = 0.0, value_name = "DEG", allow_negative_numbers = true, help_heading = "Load")]
    direction: f64,
    #[command(flatten)]
    #[serde(flatten)]
    search: SearchArgs,
    /// How to estimate the discretisation error of areas and frictions, none or refine; refine also solves each state
    /// on the finer grid
    #[arg(
        long,
        value_parser = parse_choice_but::<GridError>(&["estimate"]),
        default_value_t = GridError::None,
        help_heading = "Accuracy"
    )]
    #[serde(skip_serializing_if = "is_none", with = "named")]
    grid_error: GridError,
    #[command(flatten)]
    #[serde(skip)]
    resume: ResumeArgs,
    /// Write the states and their fields to this HDF5 file
    #[arg(long, value_name = "FILE.h5", help_heading = "Output")]
    #[serde(skip)]
    out: Option<PathBuf>,
    /// Draw friction against velocity with Persson's theory: PREFIX-friction.svg, .png; with heat -rise and
    /// -temperature; of the last state -map (pressure), -gap, -section
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix, help_heading = "Output")]
    #[serde(skip)]
    plots: Option<PathBuf>,
}

fn is_none(how: &GridError) -> bool {
    *how == GridError::None
}

impl Args {
    /// The problem that the flags ask for.
    fn asked(&self) -> Result<Asked<'_>, Failure> {
        let body = self.prony.long_term(&self.body)?;
        Ok(Asked {
            inelastic: Inelastic { relaxation: self.prony.series()?, ..Inelastic::default() },
            hardness: self.hardness.hardness.as_ref(),
            ..Asked::new(&self.source, Cow::Owned(body), self.search.budget())
        })
    }

    /// The resolved configuration as TOML.
    pub(crate) fn config(&self) -> Result<String, Failure> {
        let resolved = Self { source: self.source.resolved()?, ..self.clone() };
        toml_of(&resolved).map_err(|error| Failure::computation(error.to_string()))
    }

    /// Returns the option of the loads with their values, and the velocities.
    pub(crate) fn loads(&self) -> (&'static str, Vec<f64>, Vec<f64>) {
        (self.control.option(), self.control.given_values(), numbers(&self.velocity).collect())
    }

    /// Returns the coefficient of friction of the interface, if it is given.
    fn friction(&self) -> Result<Option<f64>, Failure> {
        match self.friction {
            Some(found) if !(found >= 0.0 && found <= *SIZES.end()) => {
                Err(Failure::value(key("friction"), found, format!("at least 0 and at most {:e}", SIZES.end())))
            }
            friction => Ok(friction),
        }
    }

    fn velocities(&self) -> Result<Vec<Velocity>, Failure> {
        let velocity = |speed: f64| {
            Velocity::new(speed, self.direction).map_err(|error| match error {
                VelocityError::Speed(found) => Failure::value(key("velocity"), found, "positive and finite"),
                VelocityError::Direction(found) => Failure::value(key("direction"), found, "finite"),
            })
        };
        let made = numbers(&self.velocity).map(velocity).collect::<Result<Vec<_>, Failure>>()?;
        if made.is_empty() {
            return Err(Failure::missing("velocity", "it must have at least one value"));
        }
        Ok(made)
    }
}

/// The input of the command, checked before the first solve.
struct SlideInput {
    prepared: Prepared,
    sliding: SlidingContact,
    heat: Option<Source>,
    loads: Vec<Load>,
    velocities: Vec<Velocity>,
}

/// Fields of a state from which the next one starts.
const STARTS: [&str; 2] = ["pressure", "heat_flux"];

/// Problem on a grid with twice as many points along each side.
struct Finer {
    args: Args,
    input: SlideInput,
    /// Height of its highest point above the highest point of the coarser grid.
    rise: f64,
    last: Option<SteadyState>,
}

impl Finer {
    /// Poses the problem on finer grids, if requested.
    fn pose(args: &Args, prepared: &Prepared) -> Result<Vec<Self>, Failure> {
        let pose = |source: SourceArgs| {
            let args = Args { source, grid_error: GridError::None, ..args.clone() };
            let input = SlideInput::new(&args, &Session::silent())?;
            let rise = input.prepared.highest() - prepared.highest();
            Ok(Self { args, input, rise, last: None })
        };
        sources(&args.asked()?, prepared)?.into_iter().map(pose).collect()
    }

    /// Visits the last state, from which the next one starts.
    fn keep(&self, visitor: &mut dyn Visit) {
        visitor.flag(&mut self.last.is_some());
        let Some(last) = &self.last else { return };
        for name in STARTS {
            let mut field = last.field(name).into_owned();
            visitor.flag(&mut !field.is_empty());
            visitor.field(&mut field);
        }
    }

    /// Restores the last state, which [`keep`](Self::keep) visited, under a load and velocity of the coarser grid.
    fn resume(&mut self, (load, velocity): (Load, &Velocity), visitor: &mut dyn Visit) -> Result<(), Failure> {
        let (mut has_state, points) = (false, self.input.prepared.surface.grid.len());
        visitor.flag(&mut has_state);
        if !has_state {
            return Ok(());
        }
        let [pressure, into_body] = STARTS.map(|_| {
            let mut has_field = false;
            visitor.flag(&mut has_field);
            has_field.then(|| {
                let mut field = vec![0.0; points];
                visitor.field(&mut field);
                field
            })
        });
        let at = (at_same_place(load.into(), self.rise).load, velocity);
        self.last = Some(self.input.certify(at, pressure.unwrap_or_default(), into_body)?);
        Ok(())
    }

    /// Solves a state of the coarser grid, and returns its numbers, or the reason why there are none.
    fn reach(
        &mut self,
        (load, velocity): (Load, &Velocity),
        is_first: bool,
        session: &Session,
    ) -> Result<Result<Record<Sliding>, String>, Failure> {
        let at = (at_same_place(load.into(), self.rise).load, velocity);
        let start = self.last.take().filter(|_| !is_first);
        Ok(match self.input.reach(at, start.as_ref(), &self.args, session) {
            Ok((_, Some(failure @ Failure::Interrupted(_)))) => return Err(failure),
            Ok((_, Some(failure))) => Err(failure.to_string()),
            Ok((reached, None)) => {
                let record = self.input.record(at, &reached, self.args.search.tolerance, f64::NAN, Vec::new());
                self.last = Some(reached);
                Ok(record)
            }
            Err(refusal) => Err(refusal.to_string()),
        })
    }
}

impl SlideInput {
    fn new(args: &Args, session: &Session) -> Result<Self, Failure> {
        args.control.check(Sign::Positive)?;
        if args.grid_error == GridError::Estimate {
            let why = "the estimate was measured on contacts at rest; while surfaces slide, the pressure has different \
                       slopes at leading and trailing edges, and their errors do not cancel in the friction";
            return Err(Failure::from(
                Unusable::value(key("grid_error"), args.grid_error, words!["none or refine"]).because(why),
            ));
        }
        let (velocities, friction) = (args.velocities()?, args.friction()?);
        let heat = args.heat.source(friction)?;
        if args.prony.series()?.is_none() && friction.is_none() {
            return Err(Failure::refused(words![
                key("prony"),
                " and ",
                key("friction"),
                " are missing; one of them is needed to slide",
            ]));
        }
        let series = Facts {
            approach: args.control.is_approach(),
            grid_error: args.grid_error,
            resume: args.resume.resume,
            ..Facts::default()
        };
        let prepared = Prepared::new(&args.asked()?, series, session)?;
        args.body.check_modulus(prepared.surface.unit.as_deref())?;
        let Prepared { surface, body, inelastic, .. } = &prepared;
        let contact = Contact::new(body, &surface.grid, &surface.heights);
        let mut contact = contact.map_err(|refusal| Failure::input(args.source.name(), refusal))?;
        let loads: Vec<Load> = args.control.loads(&prepared)?.collect();
        if let Some(hardness) = &prepared.hardness {
            contact =
                contact.with_hardness(hardness.clone()).map_err(|error| Failure::input(key("hardness"), error))?;
            for load in &loads {
                if let Load::MeanPressure(mean) = load {
                    let checked = hardness.check_mean(*mean);
                    checked.map_err(|refusal| Failure::input(key(args.control.option()), refusal))?;
                }
            }
        }
        let sliding = match &inelastic.relaxation {
            Some((prony, relaxes)) => SlidingContact::new(contact, body, prony, *relaxes),
            None => SlidingContact::elastic(contact, body),
        };
        let mut sliding = sliding.map_err(|refusal| Failure::input(args.source.name(), refusal))?;
        if let Some(friction) = friction {
            let of_friction = |error: SlidingError| Failure::input(key("friction"), error);
            let relaxation = inelastic.relaxation.as_ref().map(|(prony, relaxes)| (prony, *relaxes));
            sliding = sliding.with_friction(body, friction, relaxation).map_err(of_friction)?;
            for velocity in &velocities {
                sliding.check(velocity).map_err(|refusal| of_friction(refusal.into()))?;
            }
        }
        Ok(Self { prepared, sliding, heat, loads, velocities })
    }

    /// Every load at every velocity, loads outer.
    fn states(&self) -> impl Iterator<Item = (Load, &Velocity)> {
        self.loads.iter().flat_map(|load| self.velocities.iter().map(|velocity| (*load, velocity)))
    }

    /// Returns the features that decide which numbers the states have.
    fn facts(&self) -> SlidingFacts {
        SlidingFacts {
            heat: self.heat.is_some(),
            shared: self.heat.is_some_and(|heat| heat.is_shared()),
            hardness: self.prepared.hardness.is_some(),
            refined: self.prepared.facts.grid_error == GridError::Refine,
        }
    }

    /// Measures a state that was reached in some seconds, with its numbers on finer grids.
    fn record(
        &self,
        (_, velocity): (Load, &Velocity),
        SteadyState { state, heated }: &SteadyState,
        tolerance: f64,
        seconds: f64,
        finer: Vec<Result<Record<Sliding>, String>>,
    ) -> Record<Sliding> {
        let persson = self.sliding.persson(velocity, state.solution.mean_pressure);
        let scales = (&self.prepared.scales(), tolerance);
        let at =
            SlidingContext::new(velocity.speed(), (state, heated.as_ref()), persson, scales, seconds).beside(finer);
        Record::compute(&self.facts(), &at)
    }

    /// Recomputes the state of a pressure; `into_body` is the heat flux into the body, all of it if `None`.
    fn certify(
        &self,
        (load, velocity): (Load, &Velocity),
        pressure: Vec<f64>,
        into_body: Option<Vec<f64>>,
    ) -> Result<SteadyState, Failure> {
        let grid = &self.prepared.surface.grid;
        let field = |name: &str, values: Vec<f64>| {
            Array2::from_shape_vec(grid.points(), values).map_err(|error| Failure::input(name, error))
        };
        let pressure = field("/fields/pressure", pressure)?;
        let into_body = into_body.map(|values| field("/fields/heat_flux", values)).transpose()?;
        let state = self.sliding.certify(velocity, &pressure, load);
        let state = state.map_err(|refusal| Failure::input("/fields/pressure", refusal))?;
        let heated = self.heat.map(|heat| heat.certify(grid, velocity, &pressure, into_body.as_ref())).transpose();
        let heated = heated.map_err(|error| Failure::input("/fields/heat_flux", error))?;
        Ok(SteadyState { state, heated })
    }

    /// A state from the one before, and the reason why it is not one, if it is none.
    fn reach(
        &self,
        (load, velocity): (Load, &Velocity),
        start: Option<&SteadyState>,
        args: &Args,
        session: &Session,
    ) -> Result<(SteadyState, Option<Failure>), Refusal> {
        let start = start.map(|reached| &reached.state);
        let solved = self.sliding.slide(velocity, load, &args.search.budget(), start, &mut session.stop());
        let failed = |text: String, is_cut: bool| match is_cut {
            true => Failure::interrupted(text),
            false => Failure::computation(text),
        };
        let (state, mut failure) = match solved {
            Ok(state) => (state, None),
            Err(SolveError::Refused(refusal)) => return Err(refusal),
            Err(error) => {
                let failure = failed(error.to_string(), matches!(error, SolveError::Interrupted { .. }));
                (error.into_state().ok_or(Refusal::OtherKind)?, Some(failure))
            }
        };
        let grid = &self.prepared.surface.grid;
        let pressure = &state.solution.pressure;
        let heated = self.heat.and_then(|heat| match &failure {
            // The temperature of a state that is no result, with the residual that all of its heat leaves.
            Some(_) => heat.certify(grid, velocity, pressure, None).ok(),
            None => heat.heat(grid, velocity, pressure, &args.search.budget(), &mut session.stop()).map_or_else(
                |error| {
                    failure = Some(failed(error.to_string(), matches!(error, HeatError::Interrupted { .. })));
                    error.into_state()
                },
                Some,
            ),
        });
        Ok((SteadyState { state, heated }, failure))
    }

    /// Returns the report without states.
    fn report(&self, args: &Args) -> Result<Report, Failure> {
        let mut head = Head::new(&args.asked()?, &self.prepared, self.sliding.contact().surface());
        head.relaxation = args.prony.relaxation(&args.body)?;
        // Contacts at rest have these orders.
        head.grid_error.iter_mut().for_each(|found| found.orders.clear());
        Ok(Report {
            head,
            facts: self.facts(),
            direction: self.velocities[0].direction(),
            states: Vec::new(),
            peak_bytes: 0,
            out: None,
            plots: Vec::new(),
        })
    }

    /// Solves the states that are not kept, and writes the file. An interrupted run whose states are kept has no file.
    fn run(
        &self,
        args: &Args,
        output: Option<&Output>,
        mut kept: Option<&mut UnfinishedRun>,
        session: &Session,
    ) -> Result<Outcome<Report>, Failure> {
        let Self { prepared, velocities, .. } = self;
        let mut report = self.report(args)?;
        let count = self.states().count();
        let provenance = session.provenance(args.config()?);
        let mut finer = Finer::pose(args, prepared)?;
        let file = output.map(|output| StatesFile::new(output, &provenance, prepared, self.facts(), count));
        let mut file = file.transpose()?;
        let progress = Progress::new(session, "states", count);
        let (mut failure, mut last): (Option<Failure>, Option<SteadyState>) = (None, None);
        let finished = kept.as_ref().map_or(0, |kept| kept.finished());
        let names: Vec<&str> = fields(self.facts()).map(|field| field.name).collect();
        for (index, at) in self.states().enumerate() {
            let (started, place) = (Instant::now(), format!("state {index}"));
            if let Some(kept) = kept.as_mut().filter(|_| index < finished) {
                let FinishedStep { text, mut fields } = kept.part(index)?;
                let record = Record::from_line(&self.facts(), &text);
                report.states.push(record.map_err(|error| kept.unusable(index, error))?);
                if let Some(file) = &mut file {
                    file.write(index, &fields)?;
                }
                if index + 1 == finished {
                    let of = |name: &str| names.iter().position(|other| *other == name);
                    let into_body = of("heat_flux").map(|place| std::mem::take(&mut fields[place]).into_owned());
                    last = Some(self.certify(at, std::mem::take(&mut fields[0]).into_owned(), into_body)?);
                    if let Some(mut stored) = kept.state() {
                        let mut resume =
                            |visitor: &mut dyn Visit| finer.iter_mut().try_for_each(|finer| finer.resume(at, visitor));
                        stored.restore(&mut resume)?;
                    }
                }
                progress.advance(1.0, "kept");
                continue;
            }
            // The first velocity of a load starts anew.
            let start = last.as_ref().filter(|_| !index.is_multiple_of(velocities.len()));
            let (reached, failed) = match self.reach(at, start, args, session) {
                Ok(reached) => reached,
                Err(refusal) if index == 0 => return Err(Failure::input(key(args.control.option()), refusal)),
                Err(refusal) => {
                    failure = Some(Failure::computation(refusal.to_string()).at(&place));
                    break;
                }
            };
            let is_first = index.is_multiple_of(velocities.len());
            let beside = |finer: &mut Finer| match &failed {
                Some(failed) => Ok(Err(failed.to_string())),
                None => finer.reach(at, is_first, session),
            };
            let (beside, failed) = match finer.iter_mut().map(beside).collect() {
                Ok(beside) => (beside, failed),
                Err(failure) => (finer.iter().map(|_| Err(failure.to_string())).collect(), Some(failure)),
            };
            let record = self.record(at, &reached, args.search.tolerance, started.elapsed().as_secs_f64(), beside);
            let number = match record.value("heat_max_rise") {
                Some(rise) => format!("largest rise {rise:.4e}"),
                None => format!("friction {:.4}", record.number("friction")),
            };
            progress.advance(1.0, &format!("velocity {:.3e}, {number}", record.number("velocity")));
            let fields: Vec<_> = names.iter().map(|name| reached.field(name)).collect();
            if let Some(file) = &mut file {
                file.write(index, &fields)?;
            }
            if let (None, Some(kept)) = (&failed, &mut kept) {
                let text = record.to_line().map_err(|error| Failure::computation(error.to_string()))?;
                kept.add(&FinishedStep { text, fields }, &[])?;
                kept.keep_state(|visitor| finer.iter().for_each(|finer| finer.keep(visitor)))?;
            }
            report.states.push(record);
            failure = failed.map(|failed| failed.at(&place));
            last = Some(reached);
            if failure.is_some() {
                break;
            }
        }
        progress.finish();
        let is_kept = matches!(failure, Some(Failure::Interrupted(_))) && kept.is_some();
        if !is_kept {
            prepared.warn_about_strain(report.states.iter().map(|state| state.number("approach")), session);
        }
        let out = file.filter(|_| !is_kept).map(|file| file.finish(&report.states, count)).transpose()?;
        report.out = session.written(out);
        report.peak_bytes = peak_bytes();
        if let (None, Some(prefix), Some(last)) = (&failure, &args.plots, &last) {
            let is_viscoelastic = prepared.inelastic.relaxation.is_some();
            let of_surface = (&prepared.surface, prepared.hardness.as_ref(), last);
            let drawn = report.draw(prefix, (velocities.len(), is_viscoelastic), of_surface);
            report.plots = or_none(drawn, &mut failure);
        }
        Ok(Outcome { report, failure })
    }
}

/// Runs the command.
///
/// # Errors
/// Unusable input; a file that could not be written.
pub fn run(args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
    let input = SlideInput::new(args, session)?;
    let output = session.output(args.out.as_ref())?;
    let kept = match &output {
        Some(output) if !session.is_in_memory() => {
            let identity = input.prepared.identity(&args.config()?, session);
            let place = (Some(output), &input.prepared.surface.share);
            Some(UnfinishedRun::open(place, identity, input.states().count(), args.resume, None)?)
        }
        _ => None,
    };
    run_with_journal(kept, |kept| input.run(args, output.as_ref(), kept, session), |report| report.out.as_ref())
}
