//! `path`: a contact along a path of loads, approaches and lateral displacements, each step from the last.

mod figures;
mod file;
mod mechanics;
mod record;
mod report;
mod waypoints;

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args as ClapArgs;
use gfmd_files::Output;
use gfmd_green::Body;
use gfmd_interface::{Drive, FrictionalContact, Interface, InterfaceError, Method, Settings};
use gfmd_law::{Kind, Law, Limit};
use gfmd_response::{FullResponse, NormalResponse};
use serde::Serialize;

use self::file::PathFile;
use self::mechanics::{End, Mechanics};
use self::waypoints::WaypointArgs;
use crate::elastic::BodyArgs;
use crate::failure::{Failure, Outcome};
use crate::figures::parse_prefix;
use crate::law::LawArgs;
use crate::memory::{Held, peak_bytes};
use crate::progress::Progress;
use crate::session::Session;
use crate::source::{SourceArgs, Surface};

pub use self::record::{ResidualRecord, StepRecord};
pub use self::report::{Report, Sliding};

/// Flags of `path`.
#[derive(ClapArgs, Clone, Debug, Serialize)]
#[command(after_help = "Examples:
  gfmd path --n 256 --law exponential --param gamma=1e-5 --param range=4e-4 --displacement=-0.002,0.006,-0.004 \\
    --steps 20 --out loop.h5 --plots loop
  gfmd path --n 128 --p-star 0.05 --friction 0.3 --lateral 0,0.002,-0.002,0.002 --steps 16 --plots slip
  gfmd path --n 64 --dim 2 --law npc --param phi_n=1e-4,phi_t=1e-4,delta_n=0.002,delta_t=0.002 \\
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
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix)]
    #[serde(skip)]
    plots: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// Unusable input; a file that could not be written.
pub fn run(args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
    Prepared::new(args)?.run(args, session)
}

/// What acts between the surfaces.
enum Action {
    Law(Box<dyn Law>),
    Friction(Limit),
}

/// Everything that can be refused is refused before the first solve.
struct Prepared {
    surface: Surface,
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
        let all = limit.is_some() || !args.waypoints.lateral.is_empty();
        let fields = if all { Held::ALL_COMPONENTS } else { Held::LAW };
        fields.check("the grid", surface.grid.points())?;
        let hard = limit.is_some() || args.law.law == Kind::HardWall;
        let unit_pressure = body.material().contact_modulus() * surface.rms_gradient();
        let drives = args.waypoints.drives(args.steps, unit_pressure, hard)?;
        let output =
            args.out.as_ref().map(Output::claim).transpose().map_err(|error| Failure::input("--out", error))?;
        Ok(Self { surface, body, action, drives, output })
    }

    fn run(&self, args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
        let name = args.source.name();
        let refuse = |error: InterfaceError| Failure::input(&name, error);
        let heights = self.surface.heights.view();
        let all = matches!(self.action, Action::Friction(_)) || !args.waypoints.lateral.is_empty();
        let (normal, full);
        let mut mechanics = match &self.action {
            Action::Friction(limit) => {
                full = FullResponse::new(self.surface.grid, &self.body);
                let contact = FrictionalContact::new(&full, heights, *limit).map_err(refuse)?;
                Mechanics::Friction(contact, None)
            }
            Action::Law(law) => {
                let interface = if all {
                    full = FullResponse::new(self.surface.grid, &self.body);
                    Interface::full(&full, heights, law.as_ref())
                } else {
                    normal = NormalResponse::new(self.surface.grid, &self.body);
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
            n: self.surface.grid.points(),
            length: self.surface.grid.lengths(),
            unit: self.surface.unit.clone(),
            surface: self.surface.description.clone(),
            rms_gradient: self.surface.rms_gradient(),
            rms_height: heights.std(0.0),
            e_star: self.body.material().contact_modulus(),
            law: match &self.action {
                Action::Friction(Limit::Coulomb(_)) => "coulomb".into(),
                Action::Friction(Limit::Tresca(_)) => "tresca".into(),
                Action::Law(_) => args.law.law.name().into(),
            },
            direction: args.waypoints.along(),
            steps: Vec::new(),
            sliding: Vec::new(),
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
        report.sliding = report.sliding(args.steps as usize);
        report.peak_bytes = peak_bytes();
        if let (None, Some(prefix)) = (&failure, &args.plots) {
            let pressure = mechanics.pressure().mapv(|p| p.max(0.0));
            report.plots = figures::draw(prefix, &report, args.steps as usize, &self.surface.grid, &pressure)?;
        }
        let kept = report.out.as_ref().map_or_else(String::new, |out| format!("; kept in {}", out.display()));
        Ok(Outcome { failure: failure.map(|failure| failure.with(&kept)), report })
    }
}
