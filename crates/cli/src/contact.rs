//! `contact`: one contact problem, one or more loads.

mod check;
mod figures;
mod law_file;
mod measure;
mod report;
mod stored;
mod table;
mod threshold;
mod together;
mod vtk;

use std::borrow::Cow;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args as ClapArgs;
use gfmd_contact::{Boundary, Drive, Refusal, Visit};
use gfmd_files::Output;
use gfmd_flow::Wanted;
use gfmd_interface::Path;
use gfmd_law::LawKind;
use gfmd_problem::{Facts, Posed, Unknown, key, words};
use gfmd_record::{NOT_SOLVED, OnFinerGrid, Record, StateContext};
use gfmd_response::Components;
use gfmd_surface::{Interpolation, PowerSpectrum};
use ndarray::ArrayView2;
use serde::{Deserialize, Serialize};

use crate::loads::{LoadArgs, Sign};
use crate::measuring::{Conducting, Findings, Gathered, MeasureArgs, Touching, recalled};
use crate::progress::Progress;
use gfmd_input::base::MovedBase;
use gfmd_input::failure::{Failure, Outcome, or_none};
use gfmd_input::memory::peak_bytes;
use gfmd_input::session::Session;
use gfmd_input::source::Surface;
use gfmd_problem::options::flags::toml_of;
use gfmd_report::figures::{Face, Scene, SceneFields, parse_prefix};
use gfmd_run::accuracy;
use gfmd_run::resume::{CheckpointArgs, ResumeArgs, UnfinishedRun};
use gfmd_run::series::{
    Asked, Chosen, ContactArgs, Finer, Head, Places, Prepared, Series, SeriesOutcome, SolvedState, StateFile,
    StateHandler, beside, fields, run_with_journal,
};
use gfmd_run::trace::{Trace, TraceArgs, Tracer};

use crate::whole::{Whole, shown_by_first};
use gfmd_problem::options::Options;
use law_file::{LawFile, LawFileArgs};
pub use measure::measure;
pub use report::Report;
use report::{Accurate, GridUsed};
pub use stored::{configuration, records};
use vtk::VtkFile;

/// Flags of `contact`.
#[derive(ClapArgs, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(after_help = "Examples:
  gfmd contact --n 256 --hurst 0.8 --p-star 0.01,0.05,0.2
  gfmd contact --shape sphere:R=10mm --size 0.4mm --n 128 --young 70GPa --boundary free --force 1N
  gfmd contact --surface h.npy --size 1 --young 1 --poisson 0 --pressure 0.01,0.05 --json --out c.h5
  gfmd contact --n 512 --law exponential --param gamma=1e-5 --param range=1e-4 --p-star 0.02,0.01,0,-0.002
  gfmd contact --n 4096 --p-star 0.01,0.02,0.05,0.1 --out night.h5 --checkpoint 600 --resume
  gfmd contact --n 512 --p-star 1e-3:0.3:8 --statistics --flow --plots curve
  gfmd contact --n 512 --p-star 0.05 --vtk contact.vtp
  gfmd contact --n 64 --p-star 0.01,0.1 --seed 1:10 --out seeds.h5
  gfmd contact --n 512 --unit um --size 100um --young 70GPa --pressure 1MPa:1GPa:7 --export-law law.inp
  gfmd contact --n 128 --height 1 --p-star 0.01 --components all --solver verlet-critical --history --out dynamics.h5
  gfmd contact --n 256 --height 0.1 --poisson 0.3 --lower-seed 2 --p-star 0.01,0.05 --plots squeezed
  gfmd contact --surface a.x3p --second-surface b.x3p --shift 3e-6,0 --detrend plane --p-star 0.02
  gfmd contact --surface scan.txt --detrend plane --boundary free --e-star 1e9 --p-star 0.02 --plots scan")]
pub struct Args {
    /// Options that pose the contact.
    #[command(flatten)]
    #[serde(flatten)]
    pub problem: ContactArgs,
    #[command(flatten)]
    #[serde(flatten)]
    control: LoadArgs,
    #[command(flatten)]
    #[serde(flatten)]
    measure: MeasureArgs,
    /// Find the loads, between the lowest and the highest, at which the gap closes to flow along x and along y
    #[arg(long, help_heading = "Measurements")]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    flow_threshold: bool,
    #[command(flatten)]
    #[serde(flatten)]
    trace: TraceArgs,
    #[arg(long, value_name = "F1,F2,..|none", requires = "out", help = help_of_fields(), help_heading = "Output")]
    #[serde(skip_serializing_if = "Option::is_none")]
    fields: Option<Chosen>,
    #[command(flatten)]
    #[serde(skip)]
    resume: ResumeArgs,
    #[command(flatten)]
    #[serde(skip)]
    checkpoint: CheckpointArgs,
    /// Write fields and scalars to this HDF5 file
    #[arg(long, value_name = "FILE.h5", help_heading = "Output")]
    #[serde(skip)]
    out: Option<PathBuf>,
    /// Write the surface under the last load to this VTK file, for ParaView: undeformed (.vti) or deformed (.vtp), both
    /// with all fields, the heights and the points in contact
    #[arg(long, value_name = "FILE.vti|FILE.vtp", help_heading = "Output")]
    #[serde(skip)]
    vtk: Option<PathBuf>,
    #[command(flatten)]
    #[serde(skip)]
    law_file: LawFileArgs,
    /// Draw the last load: PREFIX-map.svg, .png (pressure), -gap, -section (both surfaces and the pressure along x)
    /// and, with attraction, -traction; area against pressure: -area; with a lower surface also -lower-map etc., with
    /// --statistics patches, distributions and spectrum, with --flow the flux
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix, help_heading = "Output")]
    #[serde(skip)]
    plots: Option<PathBuf>,
}

fn help_of_fields() -> String {
    let fields = Chosen::listed(", ");
    format!("Fields of each load to write to --out: some of {fields}, or none; default: all")
}

/// Runs the command.
///
/// # Errors
/// Returns an error for unusable input or a file that cannot be written.
pub fn run(args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
    let Some(asked) = args.problem.accuracy else { return on_one_grid(args, session) };
    // The first grid only estimates the required grid and writes no files.
    let mut now = Args { out: None, vtk: None, plots: None, law_file: LawFileArgs::default(), ..args.clone() };
    now.problem.accuracy = None;
    session.agree(
        Loads::new(&now, session)
            .and_then(|loads| accuracy::check(asked, &loads.prepared, loads.prepared.facts.approach)),
    )?;
    let mut grids: Vec<GridUsed> = Vec::new();
    let mut last: Option<Report> = None;
    loop {
        let started = Instant::now();
        let Outcome { mut report, failure } = match (on_one_grid(&now, session), last) {
            (Ok(outcome), _) => outcome,
            // If a grid is refused, keep the earlier result.
            (Err(failure), Some(report)) => {
                let found = grids.last().map_or_else(String::new, ToString::to_string);
                let failure = Failure::computation(words![
                    key("accuracy"),
                    format!(" is {}; {found}: ", asked.relative()),
                    failure.words(),
                ]);
                return Ok(Outcome { report, failure: Some(failure) });
            }
            (Err(failure), None) => return Err(failure),
        };
        let worst = accuracy::worst(&report.loads, asked);
        let times = worst.as_ref().map_or(1, |worst| worst.times);
        grids.push(GridUsed { n: report.head.n, seconds: started.elapsed().as_secs_f64(), worst });
        report.accuracy = Some(Accurate { asked: asked.relative(), grids: grids.clone() });
        let has_files =
            now.out == args.out && now.vtk == args.vtk && now.plots == args.plots && now.law_file == args.law_file;
        if failure.is_some() || (times == 1 && has_files) {
            return Ok(Outcome { report, failure });
        }
        let source = now.problem.source.finer(times, Interpolation::Waves)?;
        now = Args { problem: ContactArgs { source, ..now.problem }, ..args.clone() };
        last = Some(report);
    }
}

/// Runs the command on the given grid.
fn on_one_grid(args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
    if session.ranks().is_none() {
        return Loads::new(args, session)?.run(args, session);
    }
    args.check_solver_of_several()?;
    // A file that one process cannot read or write ends all processes.
    session.agree(Loads::new(args, session))?.run(args, session)
}

/// Input of the command, checked before the first solve.
struct Loads {
    prepared: Prepared,
    conducting: Conducting,
    drives: Vec<Drive>,
    output: Option<Output>,
    vtk: Option<VtkFile>,
    law: Option<LawFile>,
}

impl Loads {
    fn new(args: &Args, session: &Session) -> Result<Self, Failure> {
        args.checkpoint.every()?;
        args.control.check(if args.problem.law.law == LawKind::HardWall { Sign::Positive } else { Sign::Any })?;
        let count = args.control.given_values().len();
        args.problem.check()?;
        args.check_history()?;
        if args.flow_threshold {
            threshold::check(args)?;
        }
        let once = count <= 1 && !args.measure.statistics && !args.measure.flow;
        let prepared = Prepared::new(&Asked { once, ..args.asked()? }, args.series(), session)?;
        let Prepared { facts, surface, .. } = &prepared;
        args.check_fields(facts)?;
        args.trace.tracer(&surface.grid, args.axes(&prepared))?;
        let conducting = Conducting::new(&args.measure, &prepared, args.problem.solver.solver)?;
        let drives = args.control.loads(&prepared)?.map(Into::into).collect();
        let law = LawFile::claim(args, &prepared, count, session)?;
        let own = |path: &Option<PathBuf>| path.clone().filter(|_| session.is_first());
        let output =
            own(&args.out).map(Output::claim).transpose().map_err(|error| Failure::input(key("out"), error))?;
        let vtk = own(&args.vtk).as_deref().map(VtkFile::claim).transpose()?;
        Ok(Self { prepared, conducting, drives, output, vtk, law })
    }

    /// Returns the variance of the pressure in full contact, from the spectrum of the heights of the whole `surface`;
    /// with free boundaries, from the gradient.
    fn pressure_variance(&self, surface: &Surface, unknown: Unknown) -> f64 {
        let Surface { grid, heights, boundary, .. } = surface;
        let modulus = self.prepared.body.contact_modulus();
        let by_gradient = 0.25 * (modulus * surface.rms_gradient()).powi(2);
        // With several processes, the first has all heights but only the lift of its own rows.
        let base = self.prepared.base.as_ref();
        if base.is_some_and(|base| base.lift.dim() != heights.dim()) {
            return by_gradient;
        }
        let heights = MovedBase::under(base, heights);
        let Ok(spectrum) = PowerSpectrum::of(&heights, grid) else { return by_gradient };
        if *boundary == Boundary::Free {
            return by_gradient;
        }
        let response = unknown.response(*grid, &self.prepared.body);
        let modes = grid.modes().zip(spectrum.power()).zip(response.stiffness());
        modes.map(|((mode, power), stiffness)| mode.weight * power * stiffness * stiffness).sum()
    }

    fn run(&self, args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
        let Self { prepared, drives, output, .. } = self;
        let contact = prepared.pose_with_warnings(&args.asked()?, session)?;
        prepared.check_drives(&contact, drives, args.control.option(), args.problem.solver.search.tolerance)?;
        prepared.warn_about_drives(drives, args.control.option(), session);
        let config = args.config()?;
        // A recorded search cannot be continued and is not kept.
        let kept = if args.out.is_some() && !args.trace.is_wanted() {
            let (head, every) = (prepared.identity(&config, session), args.checkpoint.every()?);
            let place = (output.as_ref(), &prepared.surface.share);
            Some(UnfinishedRun::open(place, head, drives.len(), args.resume, every)?)
        } else {
            None
        };
        let outcome = run_with_journal(
            kept,
            |kept| self.solve(&contact, args, config, kept, session),
            |report| report.out.as_ref(),
        );
        let Outcome { mut report, failure } = outcome?;
        report.peak_bytes = session.largest(peak_bytes());
        Ok(Outcome { report, failure })
    }

    /// Solves the loads that are not kept, and writes the file. An interrupted run with a kept state has no file.
    fn solve(
        &self,
        contact: &Posed,
        args: &Args,
        config: String,
        mut kept: Option<&mut UnfinishedRun>,
        session: &Session,
    ) -> Result<Outcome<Report>, Failure> {
        let Self { prepared, drives, output, .. } = self;
        let series = Series {
            prepared,
            session,
            drives,
            tolerance: args.problem.solver.search.tolerance,
            places: Places::All,
            chosen: args.fields.clone().unwrap_or_default(),
            ends_with_file: !args.flow_threshold,
        };
        let mut file = series.file(output.as_ref(), config, args.out.is_some())?;
        let progress = Progress::new(session, "loads", drives.len());
        let finer = Finer::pose(&args.problem, prepared, session)?.into_iter().map(|finer| {
            let conducting = Conducting::new(&args.measure, &finer.prepared, args.problem.solver.solver)?;
            Ok((finer, conducting))
        });
        let finer = finer.collect::<Result<_, Failure>>()?;
        let mut measuring =
            Measuring { loads: self, contact, args, session, finer, gathered: Gathered::default(), trace: None };
        let mut path = Path::new(contact, args.problem.solver.search.budget(), None).solver(args.problem.solver.solver);
        let mut stop = session.stop();
        let outcome = series.run(
            &mut path,
            || args.problem.after_longer_ranges(prepared, drives[0], &mut stop),
            (file.as_mut(), kept.as_deref_mut()),
            &progress,
            &mut measuring,
        )?;
        let Measuring { gathered, trace, mut finer, .. } = measuring;
        let is_kept = outcome.is_kept(kept.as_deref());
        let SeriesOutcome { records, mut failure, not_converged, .. } = outcome;
        let head = Head::new(&args.asked()?, prepared, contact.surface());
        let mut report = Report {
            head: Head { fluid: args.measure.fluid.fluid.clone(), ..head },
            facts: prepared.facts,
            accuracy: None,
            loads: records,
            history: trace,
            flow_threshold: None,
            not_converged,
            peak_bytes: 0,
            out: None,
            vtk: None,
            export_law: None,
            plots: Vec::new(),
        };
        if failure.is_none() && args.flow_threshold {
            let finer = finer.iter_mut().map(|(finer, _)| finer);
            report.flow_threshold = Some(self.threshold(contact, args, session, &progress, finer)?);
        }
        progress.finish();
        if is_kept {
            return Ok(Outcome { report, failure });
        }
        report.head.warn_about_slopes(&report.loads, &prepared.facts, session);
        prepared.warn_about_strain(report.loads.iter().map(|load| load.number("approach")), session);
        if let Some(file) = file {
            report.out = session.agree(self.finish(file, &report, &gathered))?;
        }
        let wanted = args.plots.is_some() || args.vtk.is_some();
        if let (None, Some(state), true) = (&failure, path.state(), wanted) {
            let lift = prepared.lift();
            let shown = SceneFields::of(state, lift, state.plastic_depth());
            let fields =
                if args.vtk.is_some() { fields(&prepared.facts, state, prepared.base.as_ref()) } else { Vec::new() };
            let whole = Whole::of(prepared, shown, fields, state.lateral());
            let below = state.lower().map(|lower| SceneFields::below(lower, state.lower_plastic_depth()));
            let below = below.and_then(|shown| shown_by_first(&prepared.surface, shown));
            let show = |whole| self.show(args, &whole, below.as_ref(), &gathered, &mut report);
            or_none(session.agree(whole.map_or(Ok(()), show)), &mut failure);
        }
        let law = self.law.as_ref().filter(|_| failure.is_none()).map(|law| law.write(&report, prepared)).transpose();
        report.export_law = or_none(session.agree(law), &mut failure).flatten();
        Ok(Outcome { report, failure })
    }

    /// Writes the measurements of all loads and closes the file under its name.
    fn finish(&self, mut file: StateFile, report: &Report, gathered: &Gathered) -> Result<Option<PathBuf>, Failure> {
        let surface = &self.prepared.surface;
        if let Some(archive) = file.archive() {
            gfmd_check::statistics::write(archive, &self.prepared, &gathered.states)?;
            if let Some(found) = &report.flow_threshold {
                threshold::write(archive, &surface.units(), &self.prepared.facts, found)?;
            }
            if let Some(history) = &report.history {
                history.write(archive, surface.unit())?;
            }
        }
        file.finish(&report.loads, self.drives.len(), report.not_converged.as_ref())
    }

    /// Writes the last load as a VTK file and draws it, if requested.
    fn show(
        &self,
        args: &Args,
        whole: &Whole,
        below: Option<&SceneFields>,
        gathered: &Gathered,
        report: &mut Report,
    ) -> Result<(), Failure> {
        if let Some(vtk) = &self.vtk {
            report.vtk = Some(vtk.write(&whole.surface, &whole.shown, &whole.fields, &whole.lateral)?);
        }
        let Some(prefix) = &args.plots else { return Ok(()) };
        let Whole { surface, hardness, shown, .. } = whole;
        let variance = self.pressure_variance(surface, args.problem.components);
        let upper = Scene::upper(surface, shown, report.head.e_star, hardness.as_deref());
        let lower = below.map(|shown| Scene { shown, face: Face::Lower, ..upper });
        let scenes: Vec<Scene> = [upper].into_iter().chain(lower).collect();
        report.plots = figures::draw(prefix, report, &scenes, variance)?;
        let repulsion = ArrayView2::from_shape(surface.grid.points(), &shown.repulsion);
        let repulsion = repulsion.map_err(|error| Failure::computation(error.to_string()))?;
        let measured = figures::measured(prefix, report, surface, &repulsion, gathered, variance)?;
        report.plots.extend(measured);
        Ok(())
    }
}

/// Measurements of the loads.
struct Measuring<'a> {
    loads: &'a Loads,
    contact: &'a Posed,
    args: &'a Args,
    session: &'a Session,
    finer: Vec<(Finer, Conducting)>,
    gathered: Gathered,
    trace: Option<Trace>,
}

impl StateHandler for Measuring<'_> {
    fn tracer(&self) -> Result<Option<Tracer>, Failure> {
        let prepared = &self.loads.prepared;
        self.args.trace.tracer(&prepared.surface.grid, self.args.axes(prepared))
    }

    fn traced(&mut self, tracer: Tracer) {
        self.trace = Some(tracer.trace());
    }

    fn refused(&self, refusal: Refusal) -> Failure {
        match refusal {
            Refusal::Search(error) if self.args.problem.dynamics.is_given() => {
                Failure::input(words![key("dt"), ", ", key("damping")], error)
            }
            refusal => refusal.into(),
        }
    }

    fn record(&mut self, solved: SolvedState<'_>) -> Result<Record, Failure> {
        let SolvedState { index, state, at, started, is_cut, .. } = solved;
        let warn = |code, text: String| self.session.warn(code, format!("load {index}: {text}"));
        let stiffness = if is_cut {
            Err(NOT_SOLVED.into())
        } else {
            self.args.problem.stiffness.of(self.contact, state, |text| warn("stiffness", text))
        };
        let at = StateContext { stiffness, ..at };
        let Loads { prepared, conducting, drives, .. } = self.loads;
        // Only the figure of the flux shows single cells.
        let wanted = if self.args.plots.is_some() { Wanted::Fields } else { Wanted::Conductivity };
        let surface = (&prepared.surface, conducting);
        let findings = Findings::of(&self.args.measure, surface, &Touching::of(state, &at), wanted, warn);
        let findings = self.session.agree(findings.map_err(|failure| failure.at(format!("load {index}"))))?;
        let seconds = started.elapsed().as_secs_f64();
        let finer = match is_cut {
            true => self.finer.iter().map(|_| Err(NOT_SOLVED.to_owned())).collect(),
            false => self.on_finer_grids(drives[index])?,
        };
        for reason in finer.iter().filter_map(|found| found.as_ref().err()).filter(|_| !is_cut) {
            warn("grid", format!("no limit is known: {reason}"));
        }
        let record = Record::of(&StateContext { seconds, measured: findings.borrowed(), finer, ..at });
        if let Some(coarse) = accuracy::too_coarse(&record) {
            self.session.warn("grid", words![format!("load {index}: "), coarse]);
        }
        self.gathered.states.extend(findings.arrays);
        self.gathered.flow = findings.flow.or(self.gathered.flow.take());
        Ok(record)
    }

    fn keep(&mut self, visitor: &mut dyn Visit) {
        self.finer.iter_mut().for_each(|(finer, _)| finer.keep(visitor));
    }

    fn resume(&mut self, last: usize, visitor: &mut dyn Visit) -> Result<(), Refusal> {
        let drive = self.loads.drives[last];
        self.finer.iter_mut().try_for_each(|(finer, _)| finer.resume(drive, visitor))
    }

    fn recall(&mut self, fields: &[Cow<[f64]>]) -> Result<(), Failure> {
        let chosen = self.args.fields.clone().unwrap_or_default();
        self.gathered.states.extend(recalled(&self.loads.prepared, &chosen, fields)?);
        Ok(())
    }
}

impl Measuring<'_> {
    /// Returns the records of a load on the finer grids.
    fn on_finer_grids(&mut self, drive: Drive) -> Result<Vec<Result<OnFinerGrid, String>>, Failure> {
        let (args, session) = (self.args, self.session);
        let mut stop = session.stop();
        let mut record = |(finer, conducting): &mut (Finer, Conducting)| {
            let (state, surface, at) = finer.reach(drive, &mut stop)?;
            let touching = Touching::of(state, &at);
            let surface = (surface, &*conducting);
            let findings = Findings::of(&args.measure, surface, &touching, Wanted::Conductivity, |_, _| {})?;
            Ok(OnFinerGrid::of(&StateContext { measured: findings.borrowed(), ..at }))
        };
        self.finer.iter_mut().map(|finer| beside(record(finer))).collect()
    }
}

impl Args {
    /// Returns the resolved configuration as TOML.
    pub(crate) fn config(&self) -> Result<String, Failure> {
        let resolved = Self { problem: self.problem.resolved()?, ..self.clone() };
        toml_of(&resolved).map_err(|error| Failure::computation(error.to_string()))
    }

    /// Returns the option of the loads, with their values.
    pub(crate) fn loads(&self) -> (&'static str, Vec<f64>) {
        (self.control.option(), self.control.given_values())
    }

    /// Checks that the chosen fields exist and include all required ones.
    fn check_fields(&self, facts: &Facts) -> Result<(), Failure> {
        let Some(fields) = &self.fields else { return Ok(()) };
        if let Some(missing) = fields.missing(facts) {
            let allowed = format!("left out without {}", missing.of_loads.unwrap_or("a path"));
            return Err(Failure::value(key("fields"), missing.name, allowed));
        }
        // Statistics of kept loads are measured again.
        if self.resume.resume {
            self.measure.check_resumed(fields, facts)?;
        }
        Ok(())
    }

    /// Returns the axes of the moving components.
    fn axes(&self, prepared: &Prepared) -> &'static [usize] {
        let of_grid = Components::of(&prepared.surface.grid);
        let moves_all = prepared.facts.moves_all_by(self.problem.solver.solver);
        if moves_all || self.problem.finite_slope { of_grid.axes() } else { &of_grid.axes()[of_grid.normal()..] }
    }
}
