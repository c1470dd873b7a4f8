//! `contact`: one contact problem, one or more loads.

mod check;
mod conductance;
mod figures;
mod file;
mod page;
mod report;
mod series;
mod shared;
mod slopes;
mod statistics;
mod stored;
mod table;
mod threshold;
mod together;
mod vtk;
mod watching;
mod whole;

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

use clap::Args as ClapArgs;
use gfmd_contact::{Boundary, Dynamics, Equilibrium as _, Hardness, Load, Refusal};
use gfmd_files::Output;
use gfmd_green::{Body, Height};
use gfmd_law::{Kind, Law};
use gfmd_problem::{Facts, Given, Posed, Rest, Unknown, pose};
use gfmd_record::repulsion;
use gfmd_response::Components;
use gfmd_surface::PowerSpectrum;
use ndarray::Array2;
use serde::{Deserialize, Serialize};

use crate::base::{BaseArgs, MovedBase};
use crate::choice::{named, parse_choice};
use crate::dynamics::DynamicsArgs;
use crate::elastic::{BodyArgs, height, parse_height};
use crate::failure::{Failure, Outcome, reached};
use crate::figures::parse_prefix;
use crate::flags::without_flags;
use crate::hardness::{self, GivenHardness};
use crate::law::{Adhesion, LawArgs};
use crate::lower::{self, LowerArgs};
use crate::memory::{self, peak_bytes};
use crate::resume::{CheckpointArgs, Kept, ResumeArgs};
use crate::session::Session;
use crate::solver::SolverArgs;
use crate::source::{SourceArgs, Surface};
use crate::trace::TraceArgs;
use crate::values::{Entry, as_numbers, from_numbers, numbers};

pub(crate) use check::{again, check};
use conductance::Conducting;
pub use file::{Chosen, ContactFile};
pub(crate) use page::page;
pub use report::{Lower, Report};
use series::Series;
pub use slopes::Slopes;
pub use stored::{configuration, facts_of, records};
use vtk::VtkFile;

/// Flags of `contact`.
#[derive(ClapArgs, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(after_help = "Examples:
  gfmd contact --n 256 --hurst 0.8 --p-star 0.01,0.05,0.2
  gfmd contact --surface h.npy --length 1 --young 1 --poisson 0 --pressure 0.01,0.05 --json --out c.h5
  gfmd contact --n 512 --law exponential --param gamma=1e-5 --param range=1e-4 --p-star 0.02,0.01,0,-0.002
  gfmd contact --n 4096 --p-star 0.01,0.02,0.05,0.1 --out night.h5 --checkpoint 600 --resume
  gfmd contact --n 512 --p-star 1e-3:0.3:8 --statistics --flow --plots curve
  gfmd contact --n 512 --p-star 0.05 --vtk contact.vtp
  gfmd contact --n 128 --height 1 --p-star 0.01 --components all --solver verlet-critical --history --out dynamics.h5
  gfmd contact --n 256 --height 0.1 --poisson 0.3 --lower-seed 2 --p-star 0.01,0.05 --plots squeezed
  gfmd contact --surface a.x3p --second-surface b.x3p --shift 3e-6,0 --detrend plane --p-star 0.02
  gfmd contact --surface scan.txt --detrend plane --boundary free --e-star 1e9 --p-star 0.02 --plots scan")]
pub struct Args {
    #[command(flatten)]
    #[serde(flatten)]
    source: SourceArgs,
    #[command(flatten)]
    #[serde(flatten)]
    body: BodyArgs,
    #[command(flatten)]
    #[serde(flatten)]
    base: BaseArgs,
    #[command(flatten)]
    #[serde(flatten)]
    lower: LowerArgs,
    #[command(flatten)]
    #[serde(flatten)]
    control: ControlArgs,
    /// The surroundings of the surface
    #[arg(long, value_parser = parse_choice::<Boundary>(), default_value_t = Boundary::Periodic)]
    #[serde(with = "named")]
    boundary: Boundary,
    /// The components of the surface displacement that are unknown
    #[arg(long, value_parser = parse_choice::<Unknown>(), default_value_t = Unknown::Normal)]
    #[serde(skip_serializing_if = "is_normal", with = "named")]
    components: Unknown,
    /// Largest pressure that the surfaces carry, stress, or FILE.npy or FILE.h5:/dataset with that of each point; where it is
    /// reached the surfaces are pressed into each other
    #[arg(long, value_name = "P|FILE", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    hardness: Option<GivenHardness>,
    /// Do not take slopes as small: points of the body meet the height at their displaced place, and pressures act along the normal of
    /// the rigid surface
    #[arg(long)]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    finite_slope: bool,
    /// Measure patches, distributions of pressure and gap, spectrum of the pressure, and conductance
    #[arg(long)]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    statistics: bool,
    /// Depth of the electrodes on which the two conductors stand whose conductance --statistics measures, length, or inf
    #[arg(long, default_value = "inf", value_name = "H|inf", value_parser = parse_height, allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "is_infinite", with = "height")]
    conductor_height: Height,
    /// Compute the flow of a fluid through the gap along x and along y (Reynolds' equation)
    #[arg(long)]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    flow: bool,
    /// Find the loads between the lowest and the highest one at which the gap closes for a flow along x and along y
    #[arg(long)]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    flow_threshold: bool,
    #[command(flatten)]
    #[serde(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    #[serde(flatten)]
    dynamics: DynamicsArgs,
    #[command(flatten)]
    #[serde(flatten)]
    trace: TraceArgs,
    #[command(flatten)]
    #[serde(flatten)]
    law: LawArgs,
    /// Start the first load from the state of a law with 8, 4 and 2 times the range and the same work, one after the other
    #[arg(long)]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    range_continuation: bool,
    /// Fields of each load that go into --out: some of pressure, displacement_z, gap, plastic_depth, displacement_x,
    /// displacement_y, lower_pressure, lower_displacement_z and lower_gap, or none; default: all
    #[arg(long, value_name = "F1,F2,..|none")]
    #[serde(skip_serializing_if = "Option::is_none")]
    fields: Option<Chosen>,
    #[command(flatten)]
    #[serde(skip)]
    resume: ResumeArgs,
    #[command(flatten)]
    #[serde(skip)]
    checkpoint: CheckpointArgs,
    /// Write fields and scalars to this HDF5 file
    #[arg(long, value_name = "FILE.h5")]
    #[serde(skip)]
    out: Option<PathBuf>,
    /// Write the surface of the last load to this file of VTK, for ParaView: .vti the points of the undeformed surface, .vtp the
    /// deformed surface, both with all fields, the heights and the points in contact
    #[arg(long, value_name = "FILE.vti|FILE.vtp")]
    #[serde(skip)]
    vtk: Option<PathBuf>,
    /// Draw the last load, and area against pressure: PREFIX-map.svg, .png (pressure), PREFIX-gap, PREFIX-section (both surfaces and the
    /// pressure along x), with an attraction PREFIX-traction, PREFIX-area; with a lower surface also PREFIX-lower-map and so on, with
    /// the statistics also patches, distributions and spectrum, with the flow its flux
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix)]
    #[serde(skip)]
    plots: Option<PathBuf>,
}

/// The flags of the loads, of which exactly one is given.
#[derive(ClapArgs, Clone, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
#[group(required = true, multiple = false)]
struct ControlArgs {
    /// Mean pressures, stress; A:B:N is N values from A to B in geometric steps
    #[arg(long, value_delimiter = ',', value_name = "P1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    pressure: Vec<Entry>,
    /// Reduced pressures p/(E* g)
    #[arg(long, value_delimiter = ',', value_name = "P1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    p_star: Vec<Entry>,
    /// Rigid approaches beyond first touch, length
    #[arg(long, value_delimiter = ',', value_name = "D1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    displacement: Vec<Entry>,
}

impl ControlArgs {
    /// The flag that is given.
    fn flag(&self) -> &'static str {
        match (self.pressure.is_empty(), self.p_star.is_empty()) {
            (false, _) => "--pressure",
            (_, false) => "--p-star",
            _ => "--displacement",
        }
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_normal(components: &Unknown) -> bool {
    *components == Unknown::Normal
}

fn is_infinite(height: &Height) -> bool {
    *height == Height::Infinite
}

/// The ranges of `--range-continuation`, over the one asked for.
pub const RANGES: [f64; 3] = [8.0, 4.0, 2.0];

/// Runs the command.
///
/// # Errors
/// Unusable input; a file that could not be written.
pub fn run(args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
    if session.ranks().is_none() {
        return Prepared::new(args, session)?.run(args, session);
    }
    args.check_solver_of_several()?;
    // A file that one process cannot read or write ends all of them.
    session.agree(Prepared::new(args, session))?.run(args, session)
}

/// The input of the command, checked before the first solve.
struct Prepared {
    facts: Facts,
    surface: Surface,
    body: Body,
    base: Option<MovedBase>,
    /// Below the slab.
    lower: Option<Surface>,
    law: Arc<dyn Law>,
    hardness: Option<Hardness>,
    conducting: Conducting,
    controls: Vec<Load>,
    output: Option<Output>,
    vtk: Option<VtkFile>,
}

impl Prepared {
    fn new(args: &Args, session: &Session) -> Result<Self, Failure> {
        let body = args.body.body()?;
        args.solver.budget().check().map_err(|error| Failure::input("--tol", error))?;
        args.checkpoint.every()?;
        let law = args.law.build()?.into_shared();
        let flags = [
            ("--pressure", &args.control.pressure),
            ("--p-star", &args.control.p_star),
            ("--displacement", &args.control.displacement),
        ];
        if flags.iter().filter(|(_, values)| !values.is_empty()).count() != 1 {
            let allowed = flags.map(|(flag, _)| flag).join(", ");
            return Err(Failure::Input(format!(
                "loads are given by none or several of {allowed}; it must be one of them"
            )));
        }
        // Negative (tensile) loads need an attractive law.
        let pulls = args.law.law != Kind::HardWall;
        let allowed = if pulls { "finite" } else { "positive and finite" };
        for (flag, values) in flags {
            if let Some(bad) = numbers(values).find(|v| !(v.is_finite() && (pulls || *v > 0.0))) {
                return Err(Failure::value(flag, bad, allowed));
            }
        }
        if args.range_continuation && args.law.with_range(1.0)?.is_none() {
            let found = format!("--range-continuation: the law {} has no range", args.law.law.name());
            return Err(Failure::Input(found + "; it must be one of exponential, morse, dugdale"));
        }
        let facts = |line: bool| Facts { processes: session.processes().all, ..args.facts(line) };
        facts(false).check()?;
        args.check_dynamics()?;
        let surface = args.source.bounded(args.boundary, session)?;
        let facts = facts(surface.grid.is_line());
        facts.check()?;
        let lower = args.lower.read(&args.source, &surface, session)?;
        if lower.is_some() && surface.heights.iter().all(|height| *height == surface.heights[[0, 0]]) {
            return Err(Failure::input(
                &args.source.name(),
                "the heights are all equal; with a lower surface only that may be flat",
            ));
        }
        if let Some(missing) = args.fields.as_ref().and_then(|fields| fields.missing(&facts)) {
            let needs = match missing {
                "plastic_depth" => "--hardness",
                "displacement_x" | "displacement_y" => "--components all or --finite-slope (a profile has no y)",
                "repulsion" => {
                    "a --law with a wall (exponential, dugdale); elsewhere it is the positive part of the pressure"
                }
                _ => "--lower-surface or --lower-seed",
            };
            return Err(Failure::value("--fields", missing, format!("left out without {needs}")));
        }
        // The statistics of loads that are kept are measured again.
        if let (Some(fields), true) = (&args.fields, args.statistics && args.resume.resume)
            && fields.contact_and_gap(&facts).is_none()
        {
            let needed = format!("with {} and gap for --statistics with --resume", repulsion(&facts));
            return Err(Failure::value("--fields", fields, needed));
        }
        args.trace.tracer(&surface.grid, args.axes(&surface))?;
        if args.flow_threshold {
            threshold::check(args)?;
        }
        let loads = flags.iter().map(|(_, values)| numbers(values).count()).sum::<usize>();
        let held = facts.held(loads <= 1 && !args.statistics && !args.flow);
        session.agree(memory::fits_with_rest(held, "the grid", surface.grid.points(), session.processes()))?;
        let (base, hardness) = args.read_fields(&body, &surface, session)?;
        let surface = match &base {
            // What the contact sees is the surface that the base displaces.
            Some(base) => surface.displaced(&base.lift).map_err(|error| Failure::input(&args.source.name(), error))?,
            None => surface,
        };
        let unit_pressure = body.contact_modulus() * surface.rms_gradient();
        args.body.check_on(&surface.grid, unit_pressure)?;
        let conducting = Conducting::new(args, &body, &surface)?;
        let controls = (numbers(&args.control.pressure).map(Load::MeanPressure))
            .chain(numbers(&args.control.p_star).map(|p| Load::MeanPressure(p * unit_pressure)))
            .chain(numbers(&args.control.displacement).map(Load::Approach))
            .collect();
        let own = |path: &Option<PathBuf>| path.clone().filter(|_| session.is_first());
        let output = own(&args.out).map(Output::claim).transpose().map_err(|error| Failure::input("--out", error))?;
        let vtk = own(&args.vtk).as_deref().map(VtkFile::claim).transpose()?;
        Ok(Self { facts, surface, body, base, lower, law, hardness, conducting, controls, output, vtk })
    }

    /// The variance of the pressure in full contact, from the spectrum of the heights of the whole `surface`; by the gradient with
    /// free boundaries.
    fn pressure_variance(&self, surface: &Surface, unknown: Unknown) -> f64 {
        let Surface { grid, heights, boundary, .. } = surface;
        let modulus = self.body.contact_modulus();
        let by_gradient = 0.25 * (modulus * surface.rms_gradient()).powi(2);
        // Of several processes the first one has all heights, and the lift of its own rows.
        let base = self.base.as_ref();
        if base.is_some_and(|base| base.lift.dim() != heights.dim()) {
            return by_gradient;
        }
        let heights = MovedBase::under(base, heights);
        let Ok(spectrum) = PowerSpectrum::of(&heights, grid) else { return by_gradient };
        if *boundary == Boundary::Free {
            return by_gradient;
        }
        let response = unknown.response(*grid, &self.body);
        let modes = grid.modes().zip(spectrum.power()).zip(response.stiffness());
        modes.map(|((mode, power), stiffness)| mode.weight * power * stiffness * stiffness).sum()
    }

    /// The numbers of the attraction, if there is one.
    fn adhesion(&self, args: &Args) -> Option<Adhesion> {
        Adhesion::of(
            &args.law,
            &self.law,
            &self.surface.grid,
            &self.surface.statistics.moments,
            self.body.contact_modulus(),
        )
    }

    /// Poses the contact with this law.
    fn pose(&self, args: &Args, heights: &Array2<f64>, law: Arc<dyn Law>) -> Result<Posed, Failure> {
        let given = Given {
            share: self.surface.share.clone(),
            lower: self.lower.as_ref().map(|lower| &*lower.heights),
            law,
            hardness: self.hardness.clone(),
            dynamics: args.dynamics()?,
            ..Given::new(self.facts, &self.body, &self.surface.grid, heights)
        };
        pose(&given).map_err(|refusal| Failure::posing(refusal, &args.source.name()))
    }

    fn run(&self, args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
        let heights = &*MovedBase::under(self.base.as_ref(), &self.surface.heights);
        let contact = self.pose(args, heights, Arc::clone(&self.law))?;
        let adhesion = self.adhesion(args);
        adhesion.map_or(Ok(()), |adhesion| adhesion.tell(args.law.coarse))?;
        if let Some(trapping) = contact.trapping() {
            session.warn("lattice-trapping", trapping);
        } else if let Some(unresolved) = adhesion.and_then(|adhesion| adhesion.unresolved()) {
            session.warn("process-zone", unresolved);
        }
        self.press(&contact, args, heights, session)
    }

    /// The state of the first load by laws of longer ranges; `None` if that is not asked for.
    fn after_longer_ranges(
        &self,
        args: &Args,
        heights: &Array2<f64>,
        session: &Session,
    ) -> Result<Option<Rest>, Failure> {
        let mut last: Option<Rest> = None;
        for factor in RANGES.into_iter().filter(|_| args.range_continuation) {
            let Some(law) = args.law.with_range(factor)? else { break };
            let interface = self.pose(args, heights, law.into_shared())?;
            let mut watch = |_: &gfmd_contact::Progress| {
                if session.is_interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let press = interface.press(self.controls[0]).solver(args.solver.solver).budget(args.solver.budget());
            let (state, failure) = reached(press.starting_from(last.as_ref()).watch(&mut watch).solve())?;
            if let Some(failure) = failure {
                return Err(failure.at(&format!("range times {factor}")));
            }
            last = Some(state);
        }
        Ok(last)
    }

    /// Solves the loads in turn, each from the state of the load before, until one fails.
    fn press(
        &self,
        contact: &Posed,
        args: &Args,
        heights: &Array2<f64>,
        session: &Session,
    ) -> Result<Outcome<Report>, Failure> {
        let solver = args.solver.solver;
        if !contact.solvers().contains(&solver) {
            return Err(Refusal::Solver { found: solver, allowed: contact.solvers() }.into());
        }
        for (index, load) in self.controls.iter().enumerate() {
            let drive = (*load).into();
            let checked = contact.check(drive).and_then(|()| contact.check_resolution(drive, args.solver.tol));
            checked.map_err(|refusal| Failure::input(&format!("{}, load {index}", args.control.flag()), refusal))?;
        }
        let mut report = Report {
            n: self.surface.grid.points(),
            length: self.surface.grid.lengths(),
            unit: self.surface.unit.clone(),
            surface: self.surface.description.clone(),
            scan: self.surface.scan.clone(),
            second: self.surface.second.clone(),
            rms_gradient: self.surface.rms_gradient(),
            max_slope: self.surface.max_slope(),
            rms_height: contact.surface().rms_height(),
            e_star: self.body.contact_modulus(),
            others: args.body.others.clone(),
            body: args.body.words(args.lower.flag().map(|_| lower::BETWEEN)),
            base: args.base.clone(),
            lower: self.lower.as_ref().map(|lower| Lower {
                surface: lower.description.clone(),
                scan: lower.scan.clone(),
                rms_gradient: lower.rms_gradient(),
                rms_height: lower.statistics.moments.rms_height(),
            }),
            boundary: self.surface.boundary.name(),
            components: args.components,
            hardness: args.hardness.clone(),
            adhesion: self.adhesion(args),
            loads: Vec::new(),
            history: None,
            flow_threshold: None,
            not_converged: None,
            peak_bytes: 0,
            out: None,
            vtk: None,
            plots: Vec::new(),
        };
        let resolved = Args { source: args.source.resolved()?, ..args.clone() };
        let config = toml::to_string(&resolved).map_err(|error| Failure::Computation(error.to_string()))?;
        // A search that is recorded, or that several processes share, is not kept: it cannot be continued.
        let mut kept = match &self.output {
            Some(output) if !args.trace.is_wanted() && session.ranks().is_none() => {
                let base = self.base.as_ref().map_or_else(String::new, |base| format!("\nbase {}", base.checksum()));
                let lower =
                    self.lower.as_ref().map_or_else(String::new, |lower| format!("\nlower {}", lower.checksum()));
                let hardness = hardness::identity(self.hardness.as_ref());
                let head = session.identity(&config, &self.surface.checksum()) + &base + &lower + &hardness;
                Some(Kept::open(output, head, self.controls.len(), args.resume, args.checkpoint.every()?)?)
            }
            _ => None,
        };
        let series = Series { prepared: self, contact, args, heights, session };
        let outcome = series.solve(&mut report, kept.as_mut(), config);
        if let (Err(_) | Ok(Some(Failure::Interrupted(_))), Some(kept)) = (&outcome, &mut kept) {
            // The failure is the news; a disk that is full keeps what it has.
            let _ = kept.flush();
        }
        let remark = kept.as_ref().map_or_else(String::new, Kept::remark);
        let mut failure = outcome.map_err(|failure| failure.with(&remark))?;
        let interrupted = matches!(failure, Some(Failure::Interrupted(_)));
        match (interrupted, kept) {
            (true, Some(_)) => failure = failure.map(|failure| failure.with(&remark)),
            (false, Some(kept)) => kept.remove(),
            _ => {}
        }
        report.peak_bytes = session.largest(peak_bytes());
        let written = report.out.as_ref().map_or_else(String::new, |out| format!("; kept in {}", out.display()));
        let failure = failure.map(|failure| failure.with(&written));
        Ok(Outcome { report, failure })
    }
}

impl Default for Args {
    fn default() -> Self {
        without_flags()
    }
}

impl Args {
    fn dynamics(&self) -> Result<Dynamics, Failure> {
        Ok(Dynamics { time_step: self.dynamics.time_step(), damping: self.dynamics.factors()? })
    }

    /// The axes of the components that move.
    fn axes(&self, surface: &Surface) -> &'static [usize] {
        let of_grid = Components::of(&surface.grid);
        if self.components == Unknown::All || self.finite_slope {
            of_grid.axes()
        } else {
            &of_grid.axes()[of_grid.normal()..]
        }
    }
}
