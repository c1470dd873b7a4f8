//! `path`: a contact along a path of loads, approaches and lateral displacements, each step from the last.

mod check;
mod figures;
mod file;
mod page;
mod report;
mod waypoints;

use std::borrow::Cow;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::Args as ClapArgs;
use gfmd_contact::{
    Boundary, Budget, Drive, Equilibrium as _, Fields as _, Hardness, Refusal, RigidSurface, SolveError, Visit,
};
use gfmd_field::Grid;
use gfmd_files::Output;
use gfmd_green::Body;
use gfmd_interface::{Path, Quasistatic as _, Reading, Refinement, Step};
use gfmd_law::{Kind, Law, Limit};
use gfmd_measure::Scales;
use gfmd_problem::{Facts, Friction, Given, Posed, Rest, Task, pose};
use gfmd_record::{At, Record};
use serde::{Deserialize, Serialize};

use self::file::PathFile;
use self::waypoints::WaypointArgs;
use crate::choice::{named, parse_choice};
use crate::convergence::{History, NotConverged};
use crate::elastic::BodyArgs;
use crate::failure::{Failure, Outcome};
use crate::figures::{Face, Scene, Shown, parse_prefix, rough};
use crate::flags::{of_keys, without_flags};
use crate::hardness::{self, GivenHardness};
use crate::law::{Adhesion, LawArgs};
use crate::memory;
use crate::progress::Progress;
use crate::resume::{Kept, Part, ResumeArgs};
use crate::session::Session;
use crate::source::{SourceArgs, Surface};
use crate::values::within;

pub(crate) use self::check::{again, check};
pub(crate) use self::page::page;
pub use self::report::{Head, Report, Sliding};

/// The default of --energy-solves with friction: the first load of a rough surface takes about 60 further solves.
const FRICTION_SOLVES: u64 = 10;

/// Flags of `path`.
#[derive(ClapArgs, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(after_help = "Examples:
  gfmd path --n 256 --eps-f-inv 16 --law exponential --param gamma=2e-4,range=1.2e-3 \\
    --displacement=-0.004,0.004,-0.007 --steps 20 --out loop.h5 --plots loop
  gfmd path --n 128 --p-star 0.05 --friction 0.3 --lateral 0,0.002,-0.002,0.002 --steps 16 --plots slip
  gfmd path --n 128 --hardness 0.1 --p-star 0.01,0.3,0.01,0.3 --steps 10 --out imprint.h5 --plots imprint
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
    /// Coulomb friction with this coefficient, at a hard wall
    #[arg(long, value_name = "MU", conflicts_with_all = ["law", "shear_strength"], allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    friction: Option<f64>,
    /// Friction with this shear strength (Tresca), stress, at a hard wall
    #[arg(long, value_name = "TAU", conflicts_with = "law", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    shear_strength: Option<f64>,
    /// The surroundings of the surface; free: a patch that does not repeat
    #[arg(long, value_parser = parse_choice::<Boundary>(), default_value_t = Boundary::Periodic)]
    #[serde(with = "named", skip_serializing_if = "is_periodic")]
    boundary: Boundary,
    /// Largest pressure that the surfaces carry behind a hard wall, stress, or FILE.npy or FILE.h5:/dataset with that of each point;
    /// the plastic depth stays
    #[arg(long, value_name = "P|FILE", allow_negative_numbers = true, conflicts_with_all = ["friction", "shear_strength"])]
    #[serde(skip_serializing_if = "Option::is_none")]
    hardness: Option<GivenHardness>,
    #[command(flatten)]
    #[serde(flatten)]
    waypoints: WaypointArgs,
    /// Steps from one waypoint to the next
    #[arg(long, default_value_t = 20, value_parser = clap::value_parser!(u32).range(1..), value_name = "N")]
    #[serde(deserialize_with = "within::<1, { u32::MAX as u64 }, _, _>")]
    steps: u32,
    /// Largest residual of a converged state
    #[arg(long, default_value_t = 1e-8, value_name = "TOL", allow_negative_numbers = true)]
    tol: f64,
    /// Largest number of iterations for one step
    #[arg(long, default_value_t = 100_000, value_name = "N")]
    max_iter: u64,
    /// Largest error of the dissipated energy over the work done in a step, for laws that have an energy; with friction
    /// also twice the largest change of the shear in a step, as an energy, when its increments are halved, and its root
    /// that of the part of the contact that sticks, when the last one is
    #[arg(long, default_value_t = Refinement::default().tolerance, value_name = "TOL", allow_negative_numbers = true)]
    energy_tol: f64,
    /// Largest number of further solves per step, on average, to find the dissipated energy, and with friction the
    /// shear; 0 for none [default: 4, with friction 10]
    #[arg(long, value_name = "N")]
    energy_solves: Option<u64>,
    #[command(flatten)]
    #[serde(skip)]
    resume: ResumeArgs,
    /// Write the path, and the fields at its waypoints, to this HDF5 file
    #[arg(long, value_name = "FILE.h5")]
    #[serde(skip)]
    out: Option<PathBuf>,
    /// Draw the path, PREFIX-path.svg, .png, and its step with the largest contact: PREFIX-map (pressure), PREFIX-gap, PREFIX-section
    /// (both surfaces and the pressure along x), with an attraction PREFIX-traction
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
    /// The path of a table of keys, which is written to `out`.
    ///
    /// # Errors
    /// Another key; a value of another type.
    pub(crate) fn of(table: toml::Table, out: Option<PathBuf>) -> Result<Self, Failure> {
        Ok(Self { out, ..of_keys(table)? })
    }

    fn budget(&self) -> Budget {
        Budget { tolerance: self.tol, max_iterations: self.max_iter }
    }

    /// The facts of the path, whose surface may be a `line`.
    fn facts(&self, line: bool) -> Facts {
        let friction = (self.friction.map(|_| Friction::Coulomb)).or(self.shear_strength.map(|_| Friction::Tresca));
        Facts {
            task: Task::Path,
            law: self.law.law,
            hardness: self.hardness.is_some(),
            friction,
            boundary: self.boundary,
            line,
            approach: self.waypoints.flag() == "--displacement",
            lateral: !self.waypoints.lateral.is_empty(),
            resume: self.resume.resume,
            ..self.body.facts()
        }
    }

    fn energy_solves(&self) -> u64 {
        let slips = self.friction.is_some() || self.shear_strength.is_some();
        let default = if slips { FRICTION_SOLVES } else { Refinement::default().solves_per_step };
        self.energy_solves.unwrap_or(default)
    }

    /// The resolved configuration as TOML.
    fn config(&self) -> Result<String, Failure> {
        let energy_solves = Some(self.energy_solves());
        let resolved = Self { source: self.source.resolved()?, energy_solves, ..self.clone() };
        toml::to_string(&resolved).map_err(|error| Failure::Computation(error.to_string()))
    }
}

/// Runs the command.
///
/// # Errors
/// Unusable input; a file that could not be written.
pub fn run(args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
    Prepared::new(args, session)?.run(args, session)
}

fn is_periodic(boundary: &Boundary) -> bool {
    *boundary == Boundary::Periodic
}

/// The input of the command, checked before the first solve.
struct Prepared {
    facts: Facts,
    surface: Surface,
    body: Body,
    law: Arc<dyn Law>,
    hardness: Option<Hardness>,
    limit: Option<Limit>,
    drives: Vec<Drive>,
    output: Option<Output>,
}

impl Prepared {
    fn new(args: &Args, session: &Session) -> Result<Self, Failure> {
        let body = args.body.body()?;
        args.budget().check().map_err(|error| Failure::input("--tol", error))?;
        if !(1e-9..=0.1).contains(&args.energy_tol) {
            return Err(Failure::value("--energy-tol", format!("{:e}", args.energy_tol), "between 1e-9 and 0.1"));
        }
        args.facts(false).check()?;
        let limit = (args.friction.map(Limit::Coulomb)).or(args.shear_strength.map(Limit::Tresca));
        let flag = if args.friction.is_some() { "--friction" } else { "--shear-strength" };
        let limit = limit.map(Limit::check).transpose().map_err(|error| Failure::input(flag, error))?;
        let law = args.law.build()?.into_shared();
        let surface = args.source.bounded(args.boundary, session)?;
        let facts = args.facts(surface.grid.is_line());
        facts.check()?;
        let hardness = args.hardness.as_ref().map(|hardness| hardness.read(&surface.grid)).transpose()?;
        memory::fits(facts.held(false), "the grid", surface.grid.points())?;
        let hard = limit.is_some() || args.law.law == Kind::HardWall;
        let unit_pressure = body.contact_modulus() * surface.rms_gradient();
        args.body.check_on(&surface.grid, unit_pressure)?;
        let drives = args.waypoints.drives(args.steps, unit_pressure, hard)?;
        let output =
            args.out.as_ref().map(Output::claim).transpose().map_err(|error| Failure::input("--out", error))?;
        Ok(Self { facts, surface, body, law, hardness, limit, drives, output })
    }

    /// Poses the contact.
    fn pose(&self, args: &Args) -> Result<Posed, Failure> {
        let given = Given {
            law: Arc::clone(&self.law),
            hardness: self.hardness.clone(),
            limit: self.limit,
            ..Given::new(self.facts, &self.body, &self.surface.grid, &self.surface.heights)
        };
        pose(&given).map_err(|refusal| Failure::posing(refusal, &args.source.name()))
    }

    fn run(&self, args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
        let contact = self.pose(args)?;
        let adhesion = self.adhesion(args);
        adhesion.map_or(Ok(()), |adhesion| adhesion.tell(args.law.coarse))?;
        if let Some(trapping) = contact.trapping() {
            session.warn("lattice-trapping", trapping);
        } else if let Some(unresolved) = adhesion.and_then(|adhesion| adhesion.unresolved()) {
            session.warn("process-zone", unresolved);
        }
        self.follow(&contact, args, session)
    }

    /// The numbers of the attraction, if there is one.
    fn adhesion(&self, args: &Args) -> Option<Adhesion> {
        let moments = &self.surface.statistics.moments;
        Adhesion::of(&args.law, &self.law, &self.surface.grid, moments, self.body.contact_modulus())
    }

    /// True if the states are those of a law, of a hard wall too.
    fn solves_a_law(&self) -> bool {
        self.limit.is_none() && !self.facts.is_wall_on_path()
    }

    /// The units of reduced quantities.
    fn scales(&self) -> Scales {
        Scales { contact_modulus: self.body.contact_modulus(), rms_gradient: self.surface.rms_gradient() }
    }

    /// Solves the problem along all drives, until a step fails.
    fn follow(&self, problem: &Posed, args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
        for (index, drive) in self.drives.iter().enumerate() {
            let checked = problem.check(*drive).and_then(|()| problem.check_resolution(*drive, args.tol));
            checked.map_err(|error| Failure::input(&format!("{}, step {index}", args.waypoints.flag()), error))?;
        }
        let mut kept = match &self.output {
            Some(output) if session.is_resumable() => {
                let identity = session.identity(&args.config()?, &self.surface.checksum())
                    + &hardness::identity(self.hardness.as_ref());
                Some(Kept::open(output, identity, self.drives.len(), args.resume, None)?)
            }
            _ => None,
        };
        let outcome = self.steps(problem, args, session, kept.as_mut());
        if let (Err(_) | Ok(Outcome { failure: Some(Failure::Interrupted(_)), .. }), Some(kept)) = (&outcome, &mut kept)
        {
            // The failure is the news; a disk that is full keeps what it has.
            let _ = kept.flush();
        }
        let remark = kept.as_ref().map_or_else(String::new, Kept::remark);
        let Outcome { report, failure } = outcome.map_err(|failure| failure.with(&remark))?;
        let written = report.out.as_ref().map_or_else(String::new, |out| format!("; kept in {}", out.display()));
        let failure = match (failure, kept) {
            (Some(interrupted @ Failure::Interrupted(_)), Some(_)) => Some(interrupted.with(&remark)),
            (failure, kept) => {
                kept.into_iter().for_each(Kept::remove);
                failure.map(|failure| failure.with(&written))
            }
        };
        Ok(Outcome { report, failure })
    }

    /// Makes the steps that are not kept, and writes the file. An interrupted run whose state is kept has no file.
    fn steps(
        &self,
        problem: &Posed,
        args: &Args,
        session: &Session,
        mut kept: Option<&mut Kept>,
    ) -> Result<Outcome<Report>, Failure> {
        let refinement = Refinement { tolerance: args.energy_tol, solves_per_step: args.energy_solves() };
        let mut path = Path::new(problem, args.budget(), refinement);
        let progress = Progress::new(&session.common, "steps", self.drives.len() as f64);
        let mut log = Log::new(self, args, session)?;
        if let Some(kept) = &mut kept {
            log.recall(kept, &mut path, &self.drives)?;
            progress.advance(log.steps.len() as f64, "kept");
        }
        let (mut parted_at, mut failure, mut not_converged) = (None, None, None);
        let (mut unsettled, mut settling_solves) = (Vec::new(), 0);
        for (index, drive) in self.drives.iter().enumerate().skip(log.steps.len()) {
            let started = Instant::now();
            let mut history = History::default();
            let mut watch = |now: &gfmd_contact::Progress| {
                let note = format!("step {index}, iteration {}, residual {:.1e}", now.iteration, now.residual);
                progress.advance(0.0, &note);
                history.see(now.iteration, now.residual);
                if session.is_interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let reached = path.step(*drive, &mut watch);
            let seconds = started.elapsed().as_secs_f64();
            let error = match (reached, path.state()) {
                (Ok(step), Some(state)) => {
                    let fields = log.write(state, &problem.reading(state), &step, seconds)?;
                    if step.is_unsettled {
                        unsettled.push(index);
                        settling_solves = settling_solves.max(path.settling_solves(&step));
                    }
                    let record = &log.steps[index];
                    let [pressure, area] = ["mean_pressure", "area_fraction"].map(|name| record.number(name));
                    progress.advance(1.0, &format!("p {pressure:.3e}, area {area:.4}"));
                    if let Some(kept) = &mut kept {
                        let text = record.to_line().map_err(|error| Failure::Computation(error.to_string()))?;
                        kept.add(&Part { text, fields });
                        kept.keep_state(|visitor| {
                            path.keep(visitor);
                            log.visit_widest(visitor);
                        })?;
                    }
                    continue;
                }
                (Err(error), _) => error,
                (Ok(_), None) => break,
            };
            let text = error.to_string();
            let (state, stopped) = match error {
                SolveError::Refused(refusal) if index == 0 => return Err(refusal.into()),
                // Numbers that this step alone makes too large; the steps before it stay.
                SolveError::Refused(_) => {
                    failure = Some(Failure::Computation(text).at(&format!("step {index}")));
                    break;
                }
                SolveError::Detached { .. } => {
                    parted_at = Some(index);
                    break;
                }
                SolveError::Interrupted { state } => (state, Failure::Interrupted("interrupted".into())),
                SolveError::NotConverged { state, why, .. } => {
                    let unmet = NotConverged::new(index, &*state, args.tol, &why, history);
                    unmet.tell("step");
                    not_converged = Some(unmet);
                    (state, Failure::Computation(text))
                }
            };
            failure = Some(stopped.at(&format!("step {index}")));
            let reading = problem.reading(&state);
            log.write(&state, &reading, &Step { effort: state.effort(), ..Step::default() }, seconds)?;
            break;
        }
        progress.finish();
        if let Some(first) = unsettled.first() {
            let (energy_solves, energy_tol) = (args.energy_solves(), args.energy_tol);
            let others = match unsettled.len() - 1 {
                0 => String::new(),
                others => format!(" and {others} more"),
            };
            session.warn(
                "increments",
                format!(
                    "step {first}{others}: shear, lost energy and sticking points may change by more than \
                     --energy-tol {energy_tol} with more increments; --energy-solves {energy_solves} did not suffice: \
                     about {settling_solves} should, or take more --steps"
                ),
            );
        }
        let is_kept = matches!(failure, Some(Failure::Interrupted(_))) && kept.is_some();
        let file = log.file.filter(|_| !is_kept);
        let out = file.map(|file| file.finish(&log.steps, self.drives.len(), not_converged.as_ref())).transpose()?;
        let report = Report::new(self.head(args), log.steps, args.steps as usize);
        let mut report = Report { parted_at, not_converged, out, ..report };
        if let (None, Some(prefix), Some((_, shown))) = (&failure, &args.plots, &log.widest) {
            let scene = Scene {
                shown,
                grid: &self.surface.grid,
                unit: self.surface.unit(),
                modulus: report.head.e_star,
                hardness: self.hardness.as_ref(),
                rigid: rough(self.surface.second.is_some()),
                face: Face::Upper,
            };
            report.plots = figures::draw(prefix, &report, args.steps as usize, &scene)?;
        }
        Ok(Outcome { report, failure })
    }

    fn head(&self, args: &Args) -> Head {
        Head {
            n: self.surface.grid.points(),
            length: self.surface.grid.lengths(),
            unit: self.surface.unit.clone(),
            surface: self.surface.description.clone(),
            scan: self.surface.scan.clone(),
            second: self.surface.second.clone(),
            rms_gradient: self.surface.rms_gradient(),
            rms_height: RigidSurface::new(&self.surface.grid, &self.surface.heights)
                .map_or(f64::NAN, |rigid| rigid.rms_height()),
            e_star: self.body.contact_modulus(),
            others: args.body.others.clone(),
            body: args.body.words(None),
            law: match &self.limit {
                Some(Limit::Coulomb(_)) => "coulomb".into(),
                Some(Limit::Tresca(_)) => "tresca".into(),
                None => args.law.law.name().into(),
            },
            boundary: Some(self.surface.boundary.name()).filter(|_| self.surface.boundary == Boundary::Free),
            hardness: args.hardness.clone(),
            adhesion: self.adhesion(args),
            direction: args.waypoints.along(),
        }
    }
}

/// The records of the steps so far.
struct Log<'a> {
    steps: Vec<Record>,
    steps_of_leg: usize,
    file: Option<PathFile<'a>>,
    /// The largest contact area, and its fields.
    widest: Option<(f64, Shown)>,
    facts: Facts,
    grid: Grid,
    scales: Scales,
    tolerance: f64,
}

impl<'a> Log<'a> {
    fn new(prepared: &'a Prepared, args: &Args, session: &Session) -> Result<Self, Failure> {
        let create = |output| PathFile::create(output, prepared, args, session);
        Ok(Self {
            steps: Vec::new(),
            steps_of_leg: args.steps as usize,
            file: prepared.output.as_ref().map(create).transpose()?,
            widest: None,
            facts: prepared.facts,
            grid: prepared.surface.grid,
            scales: prepared.scales(),
            tolerance: args.tol,
        })
    }

    /// Takes over the steps that are kept, and continues the path from the last one.
    fn recall(&mut self, kept: &mut Kept, path: &mut Path<Posed>, drives: &[Drive]) -> Result<(), Failure> {
        for index in 0..kept.finished() {
            let Part { text, fields } = kept.part(index)?;
            let step = Record::from_line(&self.facts, &text);
            self.steps.push(step.map_err(|error| kept.unusable(index, error.to_string()))?);
            if let (Some(file), false) = (&mut self.file, fields.is_empty()) {
                file.write(index / self.steps_of_leg, &fields)?;
            }
        }
        let (Some(mut stored), Some(index)) = (kept.state(), kept.finished().checked_sub(1)) else { return Ok(()) };
        stored.restore(|visitor| {
            path.resume(drives[index], visitor)?;
            self.widest = Some((f64::NAN, Shown::zeros(self.grid.len())));
            self.visit_widest(visitor);
            Ok::<_, Refusal>(())
        })
    }

    /// Visits the largest contact area and its fields; there are none before the first step.
    fn visit_widest(&mut self, visitor: &mut dyn Visit) {
        if let Some((area, shown)) = &mut self.widest {
            visitor.number(area);
            shown.fields_mut().into_iter().for_each(|field| visitor.field(field));
        }
    }

    /// Records a step. Returns the fields that the file has of it, which are none between waypoints.
    fn write(
        &mut self,
        state: &Rest,
        reading: &Reading,
        step: &Step,
        seconds: f64,
    ) -> Result<Vec<Cow<'static, [f64]>>, Failure> {
        let index = self.steps.len();
        let mut fields = Vec::new();
        if let (Some(file), true) = (&mut self.file, index.is_multiple_of(self.steps_of_leg)) {
            fields = file.fields(state);
            file.write(index / self.steps_of_leg, &fields)?;
        }
        let at = At::in_scales(&self.facts, state, &self.scales, &self.grid, self.tolerance);
        let record = Record::of(&At { seconds, approach: reading.approach, step: Some((step, *reading)), ..at });
        let area = record.number("area_fraction");
        if self.widest.as_ref().is_none_or(|(most, _)| area > *most) {
            self.widest = Some((area, Shown::of(state, None, state.plastic_depth())));
        }
        self.steps.push(record);
        Ok(fields)
    }
}
