//! `wear`: a rough surface sliding on an elastic body, both losing depth by Archard's law.

mod check;
mod figures;
mod report;

use std::borrow::Cow;
use std::path::PathBuf;

use clap::Args as ClapArgs;
use gfmd_contact::{Drive, Load};
use gfmd_input::failure::{Failure, Outcome};
use gfmd_input::session::Session;
use gfmd_input::source::SourceArgs;
use gfmd_interface::{Refinement, Wear};
use gfmd_problem::options::flags::toml_of;
use gfmd_problem::options::values::{Entry, as_numbers, from_numbers};
use gfmd_problem::options::{BodyArgs, ComplianceArgs};
use gfmd_problem::{Facts, WearBy, key};
use gfmd_report::figures::{Scene, SceneFields, parse_prefix};
use gfmd_run::series::{Asked, Head, Prepared, SeriesOutcome};
use ndarray::Array2;
use serde::{Deserialize, Serialize};

use crate::course::{Followed, PathInput, PathOptions, PathSettings, StepArgs, counted, legs, lengths};
use crate::loads::LoadArgs;
use gfmd_problem::options::{Kinds, Options};

pub use self::report::Report;

/// Flags of `wear`.
#[derive(ClapArgs, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(mut_arg("steps", |arg| arg.help("Steps of a leg")))]
#[command(after_help = "Examples:
  gfmd wear --n 128 --eps-f-inv 16 --p-star 0.05 --coefficient 1 --distance 0,1e-3:0.1:20 --steps 1 --out w.h5 --plots w
  gfmd wear --surface scan.sur --young 2GPa --pressure 1MPa --coefficient 1e-15/Pa --distance 0,1m --steps 50 --json")]
pub struct Args {
    #[command(flatten)]
    #[serde(flatten)]
    source: SourceArgs,
    #[command(flatten)]
    #[serde(flatten)]
    body: BodyArgs,
    #[command(flatten)]
    #[serde(flatten)]
    #[option(kinds = Kinds::COMPLIANCE)]
    compliance: ComplianceArgs,
    #[command(flatten)]
    #[serde(flatten)]
    around: PathOptions,
    #[command(flatten)]
    #[serde(flatten)]
    loads: LoadArgs,
    /// Sliding distances of the legs. Each leg ends at a waypoint; the first begins at first touch; a leg of no
    /// distance is one step
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "S1|A:B:N,..",
        required = true,
        allow_negative_numbers = true,
        help_heading = "Waypoints"
    )]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    #[option(kinds = Kinds::LENGTH)]
    distance: Vec<Entry>,
    /// Wear coefficient over hardness, of both surfaces together, 1/stress: the depth lost per distance, over the
    /// pressure
    #[arg(long, value_name = "K", required = true, allow_negative_numbers = true, help_heading = "Wear")]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::WEAR)]
    coefficient: Option<f64>,
    #[command(flatten)]
    #[serde(flatten)]
    steps: StepArgs,
    /// Draw wear, area and largest pressure against the distance: PREFIX-wear.svg, .png; of the last step the worn
    /// profile beside the unworn: PREFIX-profile, the depth lost: PREFIX-depth, and PREFIX-map (pressure), PREFIX-gap,
    /// PREFIX-section
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix, help_heading = "Output")]
    #[serde(skip)]
    plots: Option<PathBuf>,
}

impl Args {
    fn facts(&self, line: bool) -> Facts {
        Facts {
            wear: Some(WearBy::Distance),
            is_wear: true,
            line,
            approach: self.loads.is_approach(),
            ..self.around.of(self.steps.resume, self.compliance.of(self.body.facts()))
        }
    }

    /// Returns the problem requested by the flags.
    fn asked(&self) -> Asked<'_> {
        Asked {
            compliance: Cow::Borrowed(&self.compliance),
            wear: self.coefficient.map(|by_distance| Wear { by_distance, by_slip: 0.0 }),
            boundary: self.around.boundary,
            ..Asked::new(&self.source, Cow::Borrowed(&self.body), self.steps.search.budget())
        }
    }

    fn coefficient(&self) -> Result<f64, Failure> {
        match self.coefficient {
            None => Err(Failure::missing("coefficient", "it must be positive and finite")),
            Some(found) if !(found > 0.0 && found.is_finite()) => {
                Err(Failure::value(key("coefficient"), found, "positive and finite"))
            }
            Some(coefficient) => Ok(coefficient),
        }
    }

    /// Returns the resolved configuration as TOML.
    fn config(&self) -> Result<String, Failure> {
        let resolved = Self { source: self.source.resolved()?, ..self.clone() };
        toml_of(&resolved).map_err(|error| Failure::computation(error.to_string()))
    }
}

/// Largest depth that can be worn off, divided by the range of heights; the rounding errors of the remaining heights
/// are ten digits smaller than this range.
const MOST_WORN: f64 = 1e6;

/// Refuses distances with a lost depth, `rate` per distance, beyond the precision of the numbers of `heights`.
fn check_distance(rate: f64, distances: &[f64], heights: &Array2<f64>) -> Result<(), Failure> {
    let [least, most] = [f64::min, f64::max].map(|fold| heights.iter().copied().fold(heights[[0, 0]], fold));
    let (whole, allowed) = (distances.iter().sum::<f64>(), MOST_WORN * (most - least) / rate);
    if most > least && whole > allowed {
        let allowed = format!("at most {allowed:.3e} in all, which wears off {MOST_WORN:e} times the range of heights");
        return Err(Failure::value(key("distance"), format!("{whole:e}"), allowed));
    }
    Ok(())
}

/// Returns the input of the command, checked before the first solve.
fn path_input(args: &Args, session: &Session) -> Result<PathInput, Failure> {
    args.coefficient()?;
    let distances = lengths("distance", &args.distance)?;
    if distances.is_empty() {
        return Err(Failure::missing("distance", "it must have at least one value"));
    }
    let prepared = Prepared::new(&args.asked(), |line| args.facts(line), session)?;
    args.body.check_modulus(prepared.surface.unit.as_deref())?;
    args.loads.check(false)?;
    let (values, load) = args.loads.values(prepared.unit_pressure());
    let pressure = values.iter().map(|&value| if let Load::MeanPressure(p) = load(value) { p } else { 0.0 });
    check_distance(args.coefficient()? * pressure.fold(0.0, f64::max), &distances, &prepared.surface.heights)?;
    let lists = [(args.loads.option(), values.len()), ("distance", distances.len())];
    let count = counted(&lists, args.steps.steps, |count| count)?;
    let (drives, places) = legs([&values], [&distances], count, args.steps.steps, |[value], [distance]| {
        Drive::from(load(value)).after(distance)
    });
    let output = session.output(args.steps.out.as_ref())?;
    Ok(PathInput { prepared, drives, places, output })
}

/// Runs the command.
///
/// # Errors
/// Returns an error for unusable input or a file that cannot be written.
pub fn run(args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
    let input = path_input(args, session)?;
    let settings = PathSettings {
        asked: args.asked(),
        option: args.loads.option(),
        resume: args.steps.resume,
        // Steps are never subdivided.
        refinement: Refinement { solves_per_step: 0, ..Refinement::default() },
        config: args.config()?,
    };
    input.run(&settings, session, |followed| finish(&input, args, followed, session), |report| report.out.as_ref())
}

/// Writes the file of a path, draws it, and returns its report.
fn finish(
    PathInput { prepared, drives, .. }: &PathInput,
    args: &Args,
    Followed { contact, path, outcome, file, .. }: Followed,
    session: &Session,
) -> Result<Outcome<Report>, Failure> {
    let SeriesOutcome { records, failure, not_converged, .. } = outcome;
    let out = file.map(|file| file.finish(&records, drives.len(), not_converged.as_ref())).transpose()?.flatten();
    let out = session.written(out);
    let head = Head::new(&args.asked(), prepared, contact.surface());
    let report = Report::new(head, args.coefficient()?, records);
    let mut report = Report { not_converged, out, ..report };
    let worn = path.state().and_then(|state| Some((state, state.on_path()?.wear_depth()?)));
    if let (None, Some(prefix), Some((state, depth))) = (&failure, &args.plots, worn) {
        let shown = SceneFields::of(state, None, None);
        let scene = Scene::upper(&prepared.surface, &shown, report.head.e_star, None);
        report.plots = figures::draw(prefix, &report, &scene, (&prepared.surface, depth))?;
    }
    Ok(Outcome { report, failure })
}
