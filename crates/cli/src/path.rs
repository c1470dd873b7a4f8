//! `path`: a contact along a path of loads, approaches, lateral displacements, times and sliding distances, each step
//! starting from the last.

mod args;
mod check;
mod course;
mod derivatives;
mod figures;
mod legs;
mod memory;
mod report;
mod stored;
mod strain;
mod waypoints;

use std::borrow::Cow;
use std::path::PathBuf;
use std::time::Duration;

use clap::Args as ClapArgs;
use gfmd_check::statistics;
use gfmd_contact::{Drive, Load, RigidSurface, Solver};
use gfmd_interface::{LimitingPressure, Path, Refinement, Step, Wear};
use gfmd_law::LawKind;
use gfmd_plasticity::PlasticState;
use gfmd_problem::{AnyState, Facts, Inelastic, Posed, WearBy, key, setting, words};
use ndarray::ArrayView2;
use serde::{Deserialize, Serialize};

use self::args::{PathOptions, StepArgs};
use self::course::{Followed, PathInput, PathSettings};
use self::waypoints::WaypointArgs;
use crate::loads::Sign;
use crate::measuring::{Conducting, MeasureArgs, draw_patches};
use crate::whole::Whole;
use gfmd_input::failure::{Failure, Outcome, or_none};
use gfmd_input::hardness::HardnessArgs;
use gfmd_input::lower::LowerArgs;
use gfmd_input::session::Session;
use gfmd_input::source::{SourceArgs, Surface};
use gfmd_problem::options::BodyArgs;
use gfmd_problem::options::Options;
use gfmd_problem::options::flags::toml_of;
use gfmd_problem::options::{ComplianceArgs, FrictionArgs, LawArgs, PlasticityArgs, PronyArgs, WearArgs};
use gfmd_record::Record;
use gfmd_report::figures::{Scene, parse_prefix};
use gfmd_run::resume::EVERY;
use gfmd_run::series::{Asked, Field, Head, Places, Prepared, SeriesOutcome, StateFile, StiffnessArgs};

pub use self::derivatives::{Derivatives, derivatives};
pub use self::report::{Report, Sliding};
pub use self::stored::stored;

/// Default of --energy-solves with friction: the first two steps of a rough surface may take about 100 further solves.
const FRICTION_SOLVES: u64 = 12;

/// Flags of `path`.
#[derive(ClapArgs, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(after_help = "Examples:
  gfmd path --n 256 --eps-f-inv 16 --law exponential --param gamma=2e-4,range=1.2e-3 \\
    --approach=-0.004,0.004,-0.007 --steps 20 --out loop.h5 --plots loop
  gfmd path --n 128 --p-star 0.05 --friction 0.3 --lateral 0,0.002,-0.002,0.002 --steps 16 --plots slip
  gfmd path --n 128 --hardness 0.1 --p-star 0.01,0.3,0.01,0.3 --steps 10 --out imprint.h5 --plots imprint
  gfmd path --n 64 --poisson 0.3 --yield-stress 0.02 --hardening 0.02 --p-star 0.01,0.1,0 --steps 8 --out metal.h5
  gfmd path --n 128 --prony 0.1:0.3,10:0.4 --pressure 0.01 --time 0,1e-3:1e3:25 --steps 1 --out creep.h5 --plots creep
  gfmd path --n 128 --p-star 0.05 --coefficient 1 --distance 0,1e-3:0.1:20 --steps 1 --out worn.h5 --plots worn
  gfmd path --n 64 --dim 2 --law npc --param phi_n=1e-4,phi_t=1e-4,delta_n=0.002,delta_t=0.002 \\
    --approach 0.002 --lateral 0,0.01 --json")]
pub struct Args {
    #[command(flatten)]
    #[serde(flatten)]
    source: SourceArgs,
    #[command(flatten)]
    #[serde(flatten)]
    body: BodyArgs,
    #[command(flatten)]
    #[serde(flatten)]
    compliance: ComplianceArgs,
    #[command(flatten)]
    #[serde(flatten)]
    lower: LowerArgs,
    #[command(flatten)]
    #[serde(flatten)]
    prony: PronyArgs,
    #[command(flatten)]
    #[serde(flatten)]
    plasticity: PlasticityArgs,
    #[command(flatten)]
    #[serde(flatten)]
    law: LawArgs,
    #[command(flatten)]
    #[serde(flatten)]
    friction: FrictionArgs,
    #[command(flatten)]
    #[serde(flatten)]
    wear: WearArgs,
    #[command(flatten)]
    #[serde(flatten)]
    around: PathOptions,
    #[command(flatten)]
    #[serde(flatten)]
    measure: MeasureArgs,
    #[command(flatten)]
    #[serde(flatten)]
    hardness: HardnessArgs,
    #[command(flatten)]
    #[serde(flatten)]
    waypoints: WaypointArgs,
    #[command(flatten)]
    #[serde(flatten)]
    steps: StepArgs,
    #[command(flatten)]
    #[serde(flatten)]
    stiffness: StiffnessArgs,
    /// Largest error of the dissipated energy divided by the work of a step, for laws with an energy. With friction,
    /// half of it also bounds the change of the shear, as an energy, when the increments of a step are halved, and its
    /// square root the change of the sticking fraction when the last increment is halved
    #[arg(
        long,
        alias = "energy-tol",
        default_value_t = Refinement::default().tolerance,
        value_name = "TOL",
        allow_negative_numbers = true,
        help_heading = "Accuracy"
    )]
    energy_tolerance: f64,
    /// Largest average number of further solves per step to find the dissipated energy, and with friction the shear; 0
    /// for none [default: 4; 12 with friction, else 0 for a viscoelastic or yielding body and with wear]
    #[arg(long, value_name = "N", help_heading = "Accuracy")]
    energy_solves: Option<u64>,
    /// Draw the path: PREFIX-path.svg, .png; a sheared viscoelastic body: -shear, with many panels -time; energy lost
    /// by cause: -losses; wear: -wear and, of the last step, -profile and -depth; a yielding body: -imprint (residual
    /// topography) and -strain (section below the surface); the step with the largest contact: -map (pressure), -gap,
    /// -section (both surfaces and the pressure along x) and, with attraction, -traction
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix, help_heading = "Output")]
    #[serde(skip)]
    plots: Option<PathBuf>,
}

impl Args {
    /// Returns the facts of the path, without the parts of the contact.
    fn series(&self) -> Facts {
        Facts {
            approach: self.waypoints.given() == "approach",
            lateral: self.waypoints.moves_sideways(),
            ..self.measure.of(self.around.series(self.steps.resume))
        }
    }

    /// Returns the problem requested by the flags.
    fn asked(&self) -> Result<Asked<'_>, Failure> {
        let body = self.prony.long_term(&self.body)?;
        self.measure.asked(Asked {
            compliance: Cow::Borrowed(&self.compliance),
            base: Cow::Borrowed(&self.around.base),
            lower: Cow::Borrowed(&self.lower),
            law: Cow::Borrowed(&self.law),
            hardness: self.hardness.hardness.as_ref(),
            inelastic: Inelastic {
                plasticity: self.plasticity.plasticity(&self.body)?,
                shear: self.friction.shear()?,
                relaxation: self.prony.series()?,
                wear: self.wear.wear()?,
            },
            boundary: self.around.boundary,
            ..Asked::new(&self.source, Cow::Owned(body), self.steps.search.budget())
        })
    }

    /// Returns the time between two copies of a running step, if any are made.
    fn checkpoint(&self) -> Result<Option<Duration>, Failure> {
        let every = self.steps.checkpoint.every()?;
        // Only the search of a step of a body that yields is a single one.
        let is_single = self.plasticity.yield_stress.is_some() && self.energy_solves() == 0;
        match every {
            found if is_single || found == Some(EVERY) => Ok(found),
            found => Err(Failure::value(
                key("checkpoint"),
                found.map_or(0.0, |time| time.as_secs_f64()),
                words!["left out unless the body yields and each step is one solve: ", setting("energy_solves", 0)],
            )),
        }
    }

    fn energy_solves(&self) -> u64 {
        let default = match () {
            () if self.friction.is_given() => FRICTION_SOLVES,
            // Without slip, a step of a body that relaxes or yields, or of surfaces that wear, is as good as --steps.
            () if self.prony.relaxing().is_some() || self.wear.coefficient.is_some() => 0,
            () if self.plasticity.yield_stress.is_some() => 0,
            () => Refinement::default().solves_per_step,
        };
        self.energy_solves.unwrap_or(default)
    }

    /// Returns the resolved configuration as TOML.
    pub(crate) fn config(&self) -> Result<String, Failure> {
        let energy_solves = Some(self.energy_solves());
        let resolved = Self { source: self.source.resolved()?, energy_solves, ..self.clone() };
        toml_of(&resolved).map_err(|error| Failure::computation(error.to_string()))
    }
}

/// Runs the command.
///
/// # Errors
/// Returns an error for unusable input or a file that cannot be written.
pub fn run(args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
    let input = session.agree(path_input(args, session))?;
    warn_of_yield_stress(args, session);
    let settings = PathSettings {
        asked: args.asked()?,
        measure: &args.measure,
        option: args.waypoints.given(),
        stiffness: args.stiffness,
        resume: args.steps.resume,
        checkpoint: args.checkpoint()?,
        refinement: Refinement { tolerance: args.energy_tolerance, solves_per_step: args.energy_solves() },
        config: args.config()?,
    };
    input.run(&settings, session, |followed| finish(&input, args, followed, session))
}

/// Returns the input of the command, checked before the first solve.
fn path_input(args: &Args, session: &Session) -> Result<PathInput, Failure> {
    if !(1e-9..=0.1).contains(&args.energy_tolerance) {
        return Err(Failure::value(
            key("energy_tolerance"),
            format!("{:e}", args.energy_tolerance),
            "between 1e-9 and 0.1",
        ));
    }
    args.stiffness.check()?;
    match (args.prony.relaxing(), args.waypoints.time.is_empty()) {
        (Some(_), true) => return Err(Failure::missing("time", words!["it is needed with ", key("prony")])),
        (None, false) => return Err(Failure::value(key("time"), "given", words!["left out without ", key("prony")])),
        _ => {}
    }
    match (args.wear.fact(), args.waypoints.distance.is_empty()) {
        (Some(WearBy::Distance), true) => {
            return Err(Failure::missing("distance", words!["it is needed with ", key("coefficient")]));
        }
        (Some(WearBy::Slip), false) => {
            return Err(Failure::value(key("distance"), "given", words!["left out with ", setting("wear_by", "slip")]));
        }
        (None, false) => {
            return Err(Failure::value(key("distance"), "given", words!["left out without ", key("coefficient")]));
        }
        _ => {}
    }
    if args.friction.friction.is_none() && args.friction.friction_of != LimitingPressure::default() {
        let without = words!["left out without ", key("friction")];
        return Err(Failure::value(key("friction_of"), args.friction.friction_of, without));
    }
    if args.wear.fact().is_none() && args.wear.wear_by != WearBy::default() {
        let without = words!["left out without ", key("coefficient")];
        return Err(Failure::value(key("wear_by"), args.wear.wear_by, without));
    }
    let prepared = Prepared::new(&args.asked()?, args.series(), session)?;
    args.body.check_modulus(prepared.surface.unit.as_deref())?;
    let sign = if args.law.law == LawKind::HardWall { Sign::NotNegative } else { Sign::Any };
    let (drives, places) = args.waypoints.drives(&args.steps.steps, &prepared, sign)?;
    if let Some(Wear { by_distance, .. }) = prepared.inelastic.wear {
        check_distance(by_distance, &drives, &prepared.surface)?;
    }
    let conducting = Conducting::new(&args.measure, &prepared, Solver::Auto)?;
    let is_written = args.steps.out.is_some() || session.is_in_memory();
    let output = if session.is_first() { session.output(args.steps.out.as_ref())? } else { None };
    Ok(PathInput { prepared, conducting, drives, places, output, is_written })
}

/// Largest depth that can be worn off, divided by the range of heights; the rounding errors of the remaining heights
/// are ten digits smaller than this range.
const MOST_WORN: f64 = 1e6;

/// Refuses distances over which surfaces with a wear `coefficient` lose a depth beyond the precision of the numbers of
/// heights of the `surface`.
fn check_distance(coefficient: f64, drives: &[Drive], surface: &Surface) -> Result<(), Failure> {
    let Surface { heights, share, .. } = surface;
    let [least, most] = [f64::min, f64::max].map(|fold| {
        let own = heights.iter().copied().fold(heights[[0, 0]], fold);
        share.each(own).into_iter().fold(own, fold)
    });
    let pressure = |drive: &Drive| if let Load::MeanPressure(pressure) = drive.load { pressure } else { 0.0 };
    let largest = drives.iter().map(pressure).fold(0.0, f64::max);
    let whole = drives.last().map_or(0.0, |drive| drive.distance);
    let allowed = MOST_WORN * (most - least) / (coefficient * largest);
    if most > least && whole > allowed {
        let allowed = format!("at most {allowed:.3e} in all, which wears off {MOST_WORN:e} times the range of heights");
        return Err(Failure::value(key("distance"), format!("{whole:e}"), allowed));
    }
    Ok(())
}

/// Writes the file of a path, draws it, and returns its report.
fn finish(
    PathInput { prepared, drives, places, .. }: &PathInput,
    args: &Args,
    followed: Followed,
    session: &Session,
) -> Result<Outcome<Report>, Failure> {
    let Followed { contact, path, outcome, mut file, gathered, widest, unsettled } = followed;
    warn_unsettled_steps(&unsettled, &path, args, session);
    if let (Some(file), Some(state)) = (&mut file, path.state()) {
        session.agree(memory::write(file, &prepared.surface, state))?;
    }
    if let Some(state) = path.state().and_then(AnyState::yielding) {
        warn_of_strain(state, prepared, session);
        let written = file.as_mut().map_or(Ok(()), |file| strain::write(file, &prepared.surface, state));
        session.agree(written)?;
    }
    if let Some(archive) = file.as_mut().and_then(StateFile::archive) {
        statistics::write(archive, prepared, &gathered.states)?;
    }
    let SeriesOutcome { records, mut failure, not_converged, parted_at } = outcome;
    if let Some(last) = records.last() {
        warn_of_wear(last, session);
    }
    let out = file.map(|file| file.finish(&records, drives.len(), not_converged.as_ref())).transpose();
    let out = session.agree(out)?.flatten();
    let out = session.written(out);
    let report = report_of(args, prepared, contact.surface(), (records, places))?;
    let mut report = Report { parted_at, not_converged, out, ..report };
    if let (None, Some(prefix), Some(shown)) = (&failure, &args.plots, widest) {
        let depth = path.state().and_then(|state| state.of_parts()?.wear_depth());
        let depth = depth.map(|depth| Field { name: "wear_depth", units: "length", values: depth.into() });
        let strained =
            path.state().and_then(AnyState::yielding).and_then(|state| figures::Strained::of(&prepared.surface, state));
        let whole = Whole::of(prepared, shown, depth.into_iter().collect(), &[]);
        let drawn = whole.map_or(Ok(Vec::new()), |Whole { surface, hardness, shown, fields, .. }| {
            let scene = Scene::upper(&surface, &shown, report.head.e_star, hardness.as_deref());
            let depth = fields.first().map(|field| field.values.view());
            let mut files = figures::draw(prefix, &report, places, &scene, (&surface, depth, strained.as_ref()))?;
            if args.measure.statistics {
                let shape = surface.grid.points();
                let repulsion = ArrayView2::from_shape(shape, &shown.repulsion);
                let repulsion = repulsion.map_err(|error| Failure::computation(error.to_string()))?;
                files.extend(draw_patches(prefix, &surface, repulsion)?);
            }
            Ok(files)
        });
        report.plots = or_none(session.agree(drawn), &mut failure);
    }
    Ok(Outcome { report, failure })
}

/// Returns the report of the steps of a path on this rigid surface, whose legs end at `places`.
fn report_of(
    args: &Args,
    prepared: &Prepared,
    surface: &RigidSurface,
    (records, places): (Vec<Record>, &Places),
) -> Result<Report, Failure> {
    let mut head = Head::new(&args.asked()?, prepared, surface);
    head.relaxation = args.prony.relaxation(&args.body)?;
    head.yielding = prepared.yielding(&args.plasticity)?;
    head.fluid.clone_from(&args.measure.fluid.fluid);
    let report = Report::new(head, args.waypoints.along(), records, places);
    Ok(Report { facts: prepared.facts, coefficient: args.wear.coefficient, ..report })
}

/// Yield stress divided by Young's modulus above which the strain at yield is not small.
const LARGEST_YIELD_STRAIN: f64 = 0.02;

/// Plastic strain above which the theory of small strains is far off.
const LARGEST_PLASTIC_STRAIN: f64 = 0.2;

/// Warns of a yield stress that is large for the modulus.
fn warn_of_yield_stress(args: &Args, session: &Session) {
    let part = args.plasticity.yield_stress.map_or(0.0, |found| found / args.body.young());
    if args.body.e_star.is_none() && part >= LARGEST_YIELD_STRAIN {
        let text = words![
            key("yield_stress"),
            format!(" is {part:.3} of Young's modulus: metals have 0.001 to 0.01, and strains are taken as small"),
        ];
        session.warn("yield-strain", text);
    }
}

/// Warns of plastic strain that is not small, or that reaches the lowest cell.
fn warn_of_strain(state: &PlasticState, prepared: &Prepared, session: &Session) {
    let most = state.max_plastic_strain();
    if most > LARGEST_PLASTIC_STRAIN {
        let text = format!("the plastic strain reaches {most:.2}; the theory assumes small strains");
        session.warn("large-plastic-strain", text);
    }
    if state.yields_at_bottom() {
        let depth = prepared.surface.units().words(state.yield_depth(), "length");
        let text = words![
            format!(
                "the lowest cell yields, at a depth of {depth}, and the material below it cannot: more or thicker "
            ),
            key("cells"),
            " reach deeper",
        ];
        session.warn("yield-depth", text);
    }
}

/// Error of the wear volume divided by it above which a warning asks for more steps.
const LARGEST_WEAR_ERROR: f64 = 0.05;

/// Warns of a wear volume that depends much on the number of steps.
fn warn_of_wear(last: &Record, session: &Session) {
    let Some((volume, error)) = last.value("wear_volume").zip(last.value("wear_volume_error")) else { return };
    if error > LARGEST_WEAR_ERROR * volume {
        let text = words![
            format!(
                "the wear volume has an estimated error of {:.0} %; compare a run with more ",
                100.0 * error / volume
            ),
            key("steps"),
        ];
        session.warn("wear-error", text);
    }
}

/// Warns of steps that further increments would change.
fn warn_unsettled_steps(unsettled: &[(usize, Step)], path: &Path<Posed>, args: &Args, session: &Session) {
    let Some((first, _)) = unsettled.first() else { return };
    let (energy_solves, energy_tolerance) = (args.energy_solves(), args.energy_tolerance);
    let settling = unsettled.iter().map(|(_, step)| path.settling_solves(step)).max().unwrap_or(energy_solves);
    let others = match unsettled.len() - 1 {
        0 => String::new(),
        others => format!(" and {others} more"),
    };
    session.warn(
        "increments",
        words![
            format!("step {first}{others}: shear, lost energy and sticking points may change by more than "),
            setting("energy_tolerance", energy_tolerance),
            " with more increments; ",
            setting("energy_solves", energy_solves),
            format!(" did not suffice: try about {settling}, or more "),
            key("steps"),
        ],
    );
}
