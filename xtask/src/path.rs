//! `path`: a contact along a path of loads, approaches and lateral displacements, each step from the last.

use std::fmt;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args as ClapArgs;
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_interface::{
    Drive, FrictionState, FrictionalContact, Interface, InterfaceError, Method, Normal, Settings, State,
};
use gfmd_law::{Kind, Law, Limit};
use gfmd_response::{FullResponse, NormalResponse};
use ndarray::{Array2, ArrayView2, Axis};
use serde::Serialize;

use crate::archive::{Archive, Dimension, Output, Variable};
use crate::contact::{axes, check_available, contiguous};
use crate::elastic::BodyArgs;
use crate::failure::Failure;
use crate::law::LawArgs;
use crate::progress::Progress;
use crate::session::{Session, peak_bytes};
use crate::source::{SourceArgs, Surface};

/// Flags of `path`.
#[derive(ClapArgs, Clone, Debug, Serialize)]
#[command(after_help = "Examples:
  cargo xtask path --n 256 --law exponential --param gamma=1e-5 --param range=4e-4 --displacement=-0.002,0.006,-0.004 \\
    --steps 20 --out loop.h5 --plots loop
  cargo xtask path --n 128 --p-star 0.05 --friction 0.3 --lateral 0,0.002,-0.002,0.002 --steps 16 --plots slip
  cargo xtask path --n 64 --dim 2 --law npc --param phi_n=1e-4,phi_t=1e-4,delta_n=0.002,delta_t=0.002 \\
    --displacement 0.002 --lateral 0,0.01 --json")]
pub struct Args {
    #[command(flatten)]
    #[serde(flatten)]
    source: SourceArgs,
    #[command(flatten)]
    #[serde(flatten)]
    body: BodyArgs,
    #[command(flatten)]
    #[serde(flatten)]
    law: LawArgs,
    /// Coulomb friction behind a hard wall, with this coefficient
    #[arg(long, value_name = "MU", conflicts_with_all = ["law", "shear_strength"], allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    friction: Option<f64>,
    /// Friction of this shear strength (Tresca) behind a hard wall, stress
    #[arg(long, value_name = "TAU", conflicts_with = "law", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    shear_strength: Option<f64>,
    #[command(flatten)]
    #[serde(flatten)]
    waypoints: WaypointArgs,
    /// Steps from one waypoint to the next
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..), value_name = "N")]
    steps: u32,
    /// Largest residual of a converged state
    #[arg(long, default_value_t = 1e-8, value_name = "TOL", allow_negative_numbers = true)]
    tol: f64,
    /// Iterations after which a step is given up
    #[arg(long, default_value_t = 100_000, value_name = "N")]
    max_iter: u64,
    /// Write the path, and the fields at its waypoints, to this HDF5 file
    #[arg(long, value_name = "FILE.h5")]
    #[serde(skip)]
    out: Option<PathBuf>,
    /// Draw the path and the map at its end: PREFIX-path.svg, .png, PREFIX-map.svg, .png
    #[arg(long, value_name = "PREFIX")]
    #[serde(skip)]
    plots: Option<PathBuf>,
}

/// Where the path turns. One value stays as it is; several of both kinds go together.
#[derive(ClapArgs, Clone, Debug, Serialize)]
struct WaypointArgs {
    /// Mean pressures, stress; negative pulls
    #[arg(long, value_delimiter = ',', value_name = "P1,P2,..", group = "drive", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pressure: Vec<f64>,
    /// Reduced pressures p/(E* g); negative pulls
    #[arg(long, value_delimiter = ',', value_name = "P1,P2,..", group = "drive", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    p_star: Vec<f64>,
    /// Rigid approaches beyond first touch, length; negative apart
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "D1,D2,..",
        group = "drive",
        required_unless_present_any = ["pressure", "p_star"],
        allow_negative_numbers = true
    )]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    displacement: Vec<f64>,
    /// Lateral displacements of the rigid surface, length; with them all components of the surface move
    #[arg(long, value_delimiter = ',', value_name = "X1,X2,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    lateral: Vec<f64>,
    /// Direction of the lateral displacement, degrees from x
    #[arg(long, default_value_t = 0.0, value_name = "DEG", allow_negative_numbers = true)]
    direction: f64,
}

/// The result, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub n: [usize; 2],
    pub length: [f64; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    pub surface: String,
    pub rms_gradient: f64,
    pub rms_height: f64,
    pub e_star: f64,
    pub law: String,
    pub steps: Vec<StepRecord>,
    /// Work done along the path that is not stored at its end, per area.
    pub dissipated: f64,
    pub lowest_mean_pressure: f64,
    /// The step at which the surfaces parted under their load, the last one.
    pub parted_at: Option<usize>,
    pub peak_bytes: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    pub plots: Vec<PathBuf>,
}

/// One step of a path.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "`SCALARS` says what each is, once for code and files")]
pub struct StepRecord {
    pub mean_pressure: f64,
    pub p_star: f64,
    pub displacement: f64,
    pub lateral: [f64; 2],
    pub mean_shear: [f64; 2],
    pub area_fraction: f64,
    pub stick_fraction: f64,
    pub mean_gap: f64,
    pub elastic_energy: f64,
    pub interface_energy: f64,
    pub dissipated: f64,
    pub passed_instability: bool,
    pub lowest_curvature: f64,
    pub iterations: u64,
    pub transform_pairs: u64,
    pub converged: bool,
    pub residual: ResidualRecord,
    pub seconds: f64,
}

/// The residuals of a step, recomputed from its final fields.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(untagged)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub enum ResidualRecord {
    Law { equilibrium: f64, penetration: f64, wall_tension: f64, load: f64 },
    Friction { complementarity: f64, penetration: f64, load: f64, friction: f64, excess: f64 },
}

impl ResidualRecord {
    /// The largest part.
    pub fn worst(&self) -> f64 {
        match *self {
            Self::Law { equilibrium, penetration, wall_tension, load } => {
                gfmd_interface::Residual { equilibrium, penetration, wall_tension, load }.worst()
            }
            Self::Friction { complementarity, penetration, load, friction, excess } => {
                gfmd_interface::FrictionResidual { complementarity, penetration, load, friction, excess }.worst()
            }
        }
    }
}

struct Scalar {
    name: &'static str,
    units: &'static str,
    long_name: &'static str,
    value: fn(&StepRecord) -> f64,
}

const fn scalar(
    name: &'static str,
    units: &'static str,
    long_name: &'static str,
    value: fn(&StepRecord) -> f64,
) -> Scalar {
    Scalar { name, units, long_name, value }
}

const SCALARS: &[Scalar] = &[
    scalar("mean_pressure", "stress", "mean pressure over the whole surface; negative where it is pulled", |r| {
        r.mean_pressure
    }),
    scalar("p_star", "1", "reduced pressure p/(E* g)", |r| r.p_star),
    scalar("displacement", "length", "rigid approach beyond first touch", |r| r.displacement),
    scalar("lateral_x", "length", "lateral displacement of the rigid surface along x", |r| r.lateral[0]),
    scalar("lateral_y", "length", "lateral displacement of the rigid surface along y", |r| r.lateral[1]),
    scalar("mean_shear_x", "stress", "mean shear traction on the elastic surface along x", |r| r.mean_shear[0]),
    scalar("mean_shear_y", "stress", "mean shear traction on the elastic surface along y", |r| r.mean_shear[1]),
    scalar("area_fraction", "1", "points that are repelled over all points", |r| r.area_fraction),
    scalar("stick_fraction", "1", "points in contact that stick over all points; NaN without friction", |r| {
        r.stick_fraction
    }),
    scalar("mean_gap", "length", "mean distance between the surfaces", |r| r.mean_gap),
    scalar("elastic_energy", "stress*length", "elastic energy per area of the surface", |r| r.elastic_energy),
    scalar("interface_energy", "stress*length", "energy of the law per area of the surface; NaN without one", |r| {
        r.interface_energy
    }),
    scalar(
        "dissipated",
        "stress*length",
        "work of this step that is not stored, per area; of laws by trapezoids",
        |r| r.dissipated,
    ),
    scalar("passed_instability", "1", "1 if directions of negative curvature were met on the way", |r| {
        f64::from(u8::from(r.passed_instability))
    }),
    scalar(
        "lowest_curvature",
        "1",
        "lowest curvature that the last search for a step saw, over the elastic one",
        |r| r.lowest_curvature,
    ),
    scalar("iterations", "1", "steps of the solver", |r| r.iterations as f64),
    scalar("transform_pairs", "1", "forward and inverse transforms of one component, in pairs", |r| {
        r.transform_pairs as f64
    }),
    scalar("converged", "1", "1 if all residuals are at most the tolerance", |r| f64::from(u8::from(r.converged))),
    scalar("residual", "1", "largest residual, from the final fields", |r| r.residual.worst()),
];

/// What was computed, and why it ended early if it did.
pub struct Outcome {
    /// The steps that were computed.
    pub report: Report,
    /// A step that did not converge, or an interruption.
    pub failure: Option<Failure>,
}

/// Runs the command.
///
/// # Errors
/// Unusable input; a file that could not be written.
pub fn run(args: &Args, session: &Session) -> Result<Outcome, Failure> {
    Prepared::new(args)?.run(args, session)
}

/// Fields of doubles that a path holds at its peak, with some room: of u_z alone, and of all components.
const FIELDS_OF_ONE: u64 = 27;
const FIELDS_OF_ALL: u64 = 75;

/// What acts between the surfaces.
enum Action {
    Law(Box<dyn Law>),
    Friction(Limit),
}

/// Everything that can be refused is refused before the first solve.
struct Prepared {
    surface: Surface,
    grid: Grid,
    body: Body,
    action: Action,
    drives: Vec<Drive>,
    output: Option<Output>,
}

impl Prepared {
    fn new(args: &Args) -> Result<Self, Failure> {
        let body = args.body.body()?;
        if !(1e-14..=0.1).contains(&args.tol) {
            return Err(Failure::input("--tol", format!("1e-14 to 0.1 is allowed, found {}", args.tol)));
        }
        let limit = (args.friction.map(Limit::Coulomb)).or(args.shear_strength.map(Limit::Tresca));
        let action = match limit {
            Some(limit) => {
                let flag = if args.friction.is_some() { "--friction" } else { "--shear-strength" };
                gfmd_law::Friction::new(limit, 1.0).map_err(|error| Failure::input(flag, error))?;
                Action::Friction(limit)
            }
            None => Action::Law(args.law.build()?),
        };
        let surface = args.source.surface()?;
        let [nx, ny] = surface.heights.dim().into();
        let grid = Grid::new([nx, ny], surface.lengths).map_err(|error| Failure::input("--length", error))?;
        let all = limit.is_some() || !args.waypoints.lateral.is_empty();
        let fields = if all { FIELDS_OF_ALL } else { FIELDS_OF_ONE };
        check_available([nx, ny], 8 * fields * grid.len() as u64)?;
        let hard = limit.is_some() || args.law.law == Kind::HardWall;
        let unit_pressure = body.material().contact_modulus() * surface.rms_gradient;
        let drives = args.waypoints.drives(args.steps, unit_pressure, hard)?;
        let output =
            args.out.as_ref().map(Output::claim).transpose().map_err(|error| Failure::input("--out", error))?;
        Ok(Self { surface, grid, body, action, drives, output })
    }

    fn run(&self, args: &Args, session: &Session) -> Result<Outcome, Failure> {
        let name = args.source.name();
        let refuse = |error: InterfaceError| Failure::input(&name, error);
        let heights = self.surface.heights.view();
        let all = matches!(self.action, Action::Friction(_)) || !args.waypoints.lateral.is_empty();
        let (normal, full);
        let mut mechanics = match &self.action {
            Action::Friction(limit) => {
                full = FullResponse::new(self.grid, &self.body);
                let contact = FrictionalContact::new(&full, heights, *limit).map_err(refuse)?;
                Mechanics::Friction(contact, None)
            }
            Action::Law(law) => {
                let interface = if all {
                    full = FullResponse::new(self.grid, &self.body);
                    Interface::full(&full, heights, law.as_ref())
                } else {
                    normal = NormalResponse::new(self.grid, &self.body);
                    Interface::normal(&normal, heights, law.as_ref())
                };
                let interface = interface.map_err(refuse)?;
                if let Some(trapping) = interface.trapping() {
                    tracing::warn!("{trapping}");
                }
                Mechanics::Law(interface, None)
            }
        };
        for drive in &self.drives {
            mechanics.check(*drive)?;
        }
        let mut report = Report {
            n: self.grid.points(),
            length: self.grid.lengths(),
            unit: self.surface.unit.clone(),
            surface: self.surface.description.clone(),
            rms_gradient: self.surface.rms_gradient,
            rms_height: heights.std(0.0),
            e_star: self.body.material().contact_modulus(),
            law: match &self.action {
                Action::Friction(Limit::Coulomb(_)) => "coulomb".into(),
                Action::Friction(Limit::Tresca(_)) => "tresca".into(),
                Action::Law(_) => args.law.law.name().into(),
            },
            steps: Vec::new(),
            dissipated: 0.0,
            lowest_mean_pressure: f64::INFINITY,
            parted_at: None,
            peak_bytes: 0,
            out: None,
            plots: Vec::new(),
        };
        let file = self.output.as_ref().map(|output| PathFile::create(output, self, args, all, session));
        let mut file = file.transpose()?;
        let settings = Settings { method: Method::Auto, tolerance: args.tol, max_iterations: args.max_iter };
        let progress = Progress::new(&session.common, "steps", self.drives.len() as f64);
        let mut failure = None;
        for (index, drive) in self.drives.iter().enumerate() {
            let started = Instant::now();
            let mut watch = |now: &gfmd_interface::Progress| {
                let note = format!("step {index}, iteration {}, residual {:.1e}", now.iteration, now.residual);
                progress.advance(0.0, &note);
                if session.is_interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let end = mechanics.step(*drive, &settings, &mut watch)?;
            let Some(mut record) = mechanics.record(report.steps.last(), args.tol) else { break };
            record.p_star = record.mean_pressure / (report.e_star * report.rms_gradient);
            record.seconds = started.elapsed().as_secs_f64();
            progress.advance(1.0, &format!("p {:.3e}, area {:.4}", record.mean_pressure, record.area_fraction));
            if let End::Parted = end {
                report.parted_at = Some(index);
                break;
            }
            report.dissipated += record.dissipated;
            report.lowest_mean_pressure = report.lowest_mean_pressure.min(record.mean_pressure);
            report.steps.push(record);
            let waypoint = index % args.steps as usize == 0;
            if let (Some(file), true) = (&mut file, waypoint) {
                file.write(index / args.steps as usize, &mechanics)?;
            }
            if let End::Failed(reason) = end {
                failure = Some(reason.at(&format!("step {index}")));
                break;
            }
        }
        progress.finish();
        if let Some(file) = file {
            report.out = Some(file.finish(&report.steps, self.drives.len())?);
        }
        report.peak_bytes = peak_bytes();
        if let (None, Some(prefix)) = (&failure, &args.plots) {
            let pressure = mechanics.pressure().mapv(|p| p.max(0.0));
            report.plots = crate::figures::path(prefix, &report, args.steps as usize, &self.grid, &pressure)?;
        }
        let kept = report.out.as_ref().map_or_else(String::new, |out| format!("; kept in {}", out.display()));
        Ok(Outcome { failure: failure.map(|failure| failure.with(&kept)), report })
    }
}

impl WaypointArgs {
    fn drives(&self, steps: u32, unit_pressure: f64, hard: bool) -> Result<Vec<Drive>, Failure> {
        let (flag, values, under_load) = if !self.pressure.is_empty() {
            ("--pressure", self.pressure.clone(), true)
        } else if !self.p_star.is_empty() {
            ("--p-star", self.p_star.iter().map(|p| p * unit_pressure).collect(), true)
        } else {
            ("--displacement", self.displacement.clone(), false)
        };
        let allowed = if hard { "positive, finite numbers are" } else { "finite numbers are" };
        if let Some(bad) = values.iter().find(|value| !(value.is_finite() && (!hard || **value > 0.0))) {
            return Err(Failure::input(flag, format!("{allowed} allowed, found {bad}")));
        }
        if let Some(bad) = self.lateral.iter().chain([&self.direction]).find(|value| !value.is_finite()) {
            return Err(Failure::input("--lateral", format!("finite numbers are allowed, found {bad}")));
        }
        let lateral = if self.lateral.is_empty() { vec![0.0] } else { self.lateral.clone() };
        let count = values.len().max(lateral.len());
        for (flag, length) in [(flag, values.len()), ("--lateral", lateral.len())] {
            if length != 1 && length != count {
                return Err(Failure::input(flag, format!("1 or {count} waypoints are allowed, found {length}")));
            }
        }
        let angle = self.direction.to_radians();
        // Exactly along x by default.
        let along = if self.direction == 0.0 { [1.0, 0.0] } else { [angle.cos(), angle.sin()] };
        let at = |list: &[f64], leg: usize, share: f64| match list {
            [only] => *only,
            list => list[leg] + share * (list[(leg + 1).min(list.len() - 1)] - list[leg]),
        };
        let drive = |leg: usize, share: f64| {
            let (value, sideways) = (at(&values, leg, share), at(&lateral, leg, share));
            let normal = if under_load { Normal::MeanPressure(value) } else { Normal::Approach(value) };
            Drive { normal, lateral: along.map(|c| c * sideways) }
        };
        let inside = (0..count - 1).flat_map(|leg| (0..steps).map(move |i| (leg, f64::from(i) / f64::from(steps))));
        Ok(inside.map(|(leg, share)| drive(leg, share)).chain([drive(count - 1, 0.0)]).collect())
    }
}

/// A problem with its last state.
enum Mechanics<'a> {
    Law(Interface<'a>, Option<State>),
    Friction(FrictionalContact<'a>, Option<FrictionState>),
}

/// How a step ended.
enum End {
    Rest,
    Parted,
    Failed(Failure),
}

impl Mechanics<'_> {
    fn check(&self, drive: Drive) -> Result<(), Failure> {
        let checked = match self {
            Self::Law(interface, _) => interface.check(drive),
            Self::Friction(contact, _) => contact.check(drive),
        };
        checked.map_err(|error| Failure::input("--displacement", error))
    }

    fn step(&mut self, drive: Drive, settings: &Settings, watch: gfmd_interface::Watch) -> Result<End, Failure> {
        let interrupted = || End::Failed(Failure::Interrupted("interrupted".into()));
        let error = match self {
            Self::Law(interface, state) => match interface.solve(drive, settings, state.as_ref(), watch) {
                Ok(next) => {
                    *state = Some(next);
                    return Ok(End::Rest);
                }
                Err(error) => error,
            },
            Self::Friction(contact, state) => match contact.solve(drive, settings, state.as_ref(), watch) {
                Ok(next) => {
                    *state = Some(next);
                    return Ok(End::Rest);
                }
                Err(error) => error,
            },
        };
        let text = error.to_string();
        match (error, self) {
            (InterfaceError::Detached { state: next, .. }, Self::Law(_, state)) => {
                *state = Some(*next);
                Ok(End::Parted)
            }
            (InterfaceError::NotConverged { state: next, .. }, Self::Law(_, state)) => {
                *state = Some(*next);
                Ok(End::Failed(Failure::Computation(text)))
            }
            (InterfaceError::FrictionNotConverged { state: next, .. }, Self::Friction(_, state)) => {
                *state = Some(*next);
                Ok(End::Failed(Failure::Computation(text)))
            }
            (InterfaceError::Interrupted { state: next }, Self::Law(_, state)) => {
                *state = Some(*next);
                Ok(interrupted())
            }
            (InterfaceError::FrictionInterrupted { state: next }, Self::Friction(_, state)) => {
                *state = Some(*next);
                Ok(interrupted())
            }
            _ => Err(Failure::Computation(text)),
        }
    }

    /// The scalars of the last state; `before` is the step that led to it.
    fn record(&self, before: Option<&StepRecord>, tolerance: f64) -> Option<StepRecord> {
        Some(match self {
            Self::Law(_, state) => {
                let state = state.as_ref()?;
                let gfmd_interface::Residual { equilibrium, penetration, wall_tension, load } = state.residual;
                // Work of the rigid surface, by trapezoids, less what is stored.
                let dissipated = before.map_or(0.0, |before| {
                    let pushed =
                        0.5 * (before.mean_pressure + state.mean_pressure) * (state.approach - before.displacement);
                    let dragged: f64 = (0..2)
                        .map(|c| {
                            0.5 * (before.mean_shear[c] + state.mean_shear[c]) * (state.lateral[c] - before.lateral[c])
                        })
                        .sum();
                    let stored =
                        state.elastic_energy + state.interface_energy - before.elastic_energy - before.interface_energy;
                    pushed + dragged - stored
                });
                StepRecord {
                    mean_pressure: state.mean_pressure,
                    p_star: f64::NAN,
                    displacement: state.approach,
                    lateral: state.lateral,
                    mean_shear: state.mean_shear,
                    area_fraction: state.contact_fraction,
                    stick_fraction: f64::NAN,
                    mean_gap: state.gap.mean().unwrap_or(f64::NAN),
                    elastic_energy: state.elastic_energy,
                    interface_energy: state.interface_energy,
                    dissipated,
                    passed_instability: state.passed_instability,
                    lowest_curvature: state.lowest_curvature,
                    iterations: state.iterations,
                    transform_pairs: state.transform_pairs,
                    converged: state.residual.worst() <= tolerance,
                    residual: ResidualRecord::Law { equilibrium, penetration, wall_tension, load },
                    seconds: f64::NAN,
                }
            }
            Self::Friction(_, state) => {
                let state = state.as_ref()?;
                let gfmd_interface::FrictionResidual { complementarity, penetration, load, friction, excess } =
                    state.residual;
                StepRecord {
                    mean_pressure: state.mean_pressure,
                    p_star: f64::NAN,
                    displacement: state.approach,
                    lateral: state.lateral,
                    mean_shear: state.mean_shear,
                    area_fraction: state.contact_fraction,
                    stick_fraction: state.stick_fraction,
                    mean_gap: state.gap.mean().unwrap_or(f64::NAN),
                    elastic_energy: state.elastic_energy,
                    interface_energy: f64::NAN,
                    dissipated: state.dissipated,
                    passed_instability: false,
                    lowest_curvature: f64::NAN,
                    iterations: state.iterations,
                    transform_pairs: state.transform_pairs,
                    converged: state.residual.worst() <= tolerance,
                    residual: ResidualRecord::Friction { complementarity, penetration, load, friction, excess },
                    seconds: f64::NAN,
                }
            }
        })
    }

    /// Tractions on the elastic surface, component by component, and the gap.
    fn fields(&self) -> Option<(Vec<ArrayView2<'_, f64>>, ArrayView2<'_, f64>)> {
        let (traction, gap) = match self {
            Self::Law(_, state) => state.as_ref().map(|state| (&state.traction, &state.gap))?,
            Self::Friction(_, state) => state.as_ref().map(|state| (&state.traction, &state.gap))?,
        };
        Some((traction.axis_iter(Axis(0)).collect(), gap.view()))
    }

    fn pressure(&self) -> Array2<f64> {
        self.fields().and_then(|(tractions, _)| tractions.last().map(|t| t.mapv(|t| -t))).unwrap_or_default()
    }
}

/// The HDF5 file of a path: fields waypoint by waypoint, scalars at the end.
struct PathFile<'a> {
    archive: Archive<'a>,
    shears: &'static [&'static str],
}

impl<'a> PathFile<'a> {
    fn create(
        output: &'a Output,
        prepared: &Prepared,
        args: &Args,
        all: bool,
        session: &Session,
    ) -> Result<Self, Failure> {
        let resolved = Args { source: args.source.resolved()?, ..args.clone() };
        let config = toml::to_string(&resolved).map_err(|error| Failure::Computation(error.to_string()))?;
        let mut archive = Archive::create(output, &session.provenance(config))?;
        let unit = prepared.surface.unit.as_deref().unwrap_or("length");
        let [x, y] = axes(&prepared.grid, unit);
        let height = Variable {
            dimensions: &[&x, &y],
            units: unit,
            long_name: "height of the rigid surface, peaks towards the elastic body",
        };
        archive.write("/surface/height", &height, &contiguous(&prepared.surface.heights))?;
        archive.attribute("/surface", "description", prepared.surface.description.as_str())?;
        let steps = args.steps as usize;
        let waypoint = Dimension::index("waypoint", prepared.drives.len().div_ceil(steps), "where the path turns");
        let shears: &[&str] = match (all, prepared.grid.is_line()) {
            (false, _) => &[],
            (true, true) => &["shear_x"],
            (true, false) => &["shear_x", "shear_y"],
        };
        let fields = [
            ("pressure", "stress", "pressure on the elastic surface, compression positive; attraction is negative"),
            ("gap", unit, "distance between the surfaces"),
            ("shear_x", "stress", "shear traction on the elastic surface along x"),
            ("shear_y", "stress", "shear traction on the elastic surface along y"),
        ];
        for (name, units, long_name) in fields.into_iter().take(2 + shears.len()) {
            archive
                .define(&format!("/fields/{name}"), &Variable { dimensions: &[&waypoint, &x, &y], units, long_name })?;
        }
        Ok(Self { archive, shears })
    }

    fn write(&mut self, waypoint: usize, mechanics: &Mechanics) -> Result<(), Failure> {
        let Some((tractions, gap)) = mechanics.fields() else { return Ok(()) };
        self.archive.write_slab("/fields/pressure", waypoint, &contiguous(&mechanics.pressure()))?;
        self.archive.write_slab("/fields/gap", waypoint, &contiguous(&gap.to_owned()))?;
        for (name, shear) in self.shears.iter().zip(&tractions) {
            self.archive.write_slab(&format!("/fields/{name}"), waypoint, &contiguous(&shear.to_owned()))?;
        }
        Ok(())
    }

    fn finish(mut self, steps: &[StepRecord], count: usize) -> Result<PathBuf, Failure> {
        let step = Dimension::index("step", count, "step of the path");
        for scalar in SCALARS {
            let values: Vec<f64> = (0..count).map(|i| steps.get(i).map_or(f64::NAN, scalar.value)).collect();
            let variable = Variable { dimensions: &[&step], units: scalar.units, long_name: scalar.long_name };
            self.archive.write(&format!("/path/{}", scalar.name), &variable, &values)?;
        }
        Ok(self.archive.finish()?)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [nx, ny] = self.n;
        let unit = self.unit.as_deref().unwrap_or("length units");
        writeln!(f, "{}", self.surface)?;
        writeln!(f, "{nx} x {ny} points, cell {:.6e} x {:.6e} {unit}", self.length[0], self.length[1])?;
        writeln!(
            f,
            "rms gradient {:.6} (spectral), rms height {:.6e} {unit}, E* = {:.6e}, law {}\n",
            self.rms_gradient, self.rms_height, self.e_star, self.law
        )?;
        let heads =
            ["pressure", "approach", "lateral", "shear", "area", "stick", "energy", "dissipated", "steps", "residual"];
        writeln!(f, "{:>5}{}", "", heads.map(|head| format!("{head:>12}")).concat())?;
        for (index, step) in self.steps.iter().enumerate() {
            let law = if step.interface_energy.is_nan() { 0.0 } else { step.interface_energy };
            writeln!(
                f,
                "{index:>5}{:>12.4e}{:>12.4e}{:>12.4e}{:>12.4e}{:>12.6}{:>12.6}{:>12.4e}{:>12.4e}{:>12}{:>12.1e}{}{}",
                step.mean_pressure,
                step.displacement,
                step.lateral[0].hypot(step.lateral[1]),
                step.mean_shear[0].hypot(step.mean_shear[1]),
                step.area_fraction,
                step.stick_fraction,
                step.elastic_energy + law,
                step.dissipated,
                step.iterations,
                step.residual.worst(),
                if step.passed_instability { "  passed an instability" } else { "" },
                if step.converged { "" } else { "  NOT CONVERGED" }
            )?;
        }
        if let Some(step) = self.parted_at {
            writeln!(f, "{step:>5}  the surfaces part")?;
        }
        writeln!(
            f,
            "\ndissipated {:.6e} per area, lowest mean pressure {:.6e}",
            self.dissipated, self.lowest_mean_pressure
        )?;
        if let Some(out) = &self.out {
            writeln!(f, "written: {}", out.display())?;
        }
        self.plots.iter().try_for_each(|plot| writeln!(f, "drawn:   {}", plot.display()))
    }
}
