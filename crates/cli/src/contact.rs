//! `contact`: one contact problem, one or more loads.

mod check;
mod figures;
mod file;
mod page;

use std::fmt;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::Args as ClapArgs;
use gfmd_contact::{Boundary, Contact, Fields, Load, Refusal, Resumable, RigidSurface, SolveError, Visit, Watch};
use gfmd_files::{Output, contiguous};
use gfmd_green::Body;
use gfmd_interface::Interface;
use gfmd_law::{Kind, Law};
use gfmd_measure::Scales;
use serde::Serialize;

use crate::choice::{by_name, parse_choice};
use crate::convergence::{History, NotConverged};
use crate::elastic::{BodyArgs, OtherArgs};
use crate::failure::{Failure, Outcome, reached};
use crate::figures::parse_prefix;
use crate::law::LawArgs;
use crate::load::{LoadRecord, Recorded};
use crate::memory::{Held, peak_bytes};
use crate::progress::Progress;
use crate::resume::{CheckpointArgs, Kept, Part, ResumeArgs};
use crate::scan::Scan;
use crate::session::{Session, list_files};
use crate::solver::SolverArgs;
use crate::source::{SourceArgs, Surface};

pub(crate) use check::{again, check};
pub use file::{Chosen, ContactFile};
pub(crate) use page::page;

/// Flags of `contact`.
#[derive(ClapArgs, Clone, Debug, Serialize)]
#[command(after_help = "Examples:
  gfmd contact --n 256 --hurst 0.8 --p-star 0.01,0.05,0.2
  gfmd contact --surface h.npy --length 1 --young 1 --poisson 0 --pressure 0.01,0.05 --json --out c.h5
  gfmd contact --n 512 --law exponential --param gamma=1e-5 --param range=1e-4 --p-star 0.02,0.01,0,-0.002
  gfmd contact --n 4096 --p-star 0.01,0.02,0.05,0.1 --out night.h5 --checkpoint 600 --resume
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
    control: ControlArgs,
    /// The surroundings of the surface
    #[arg(long, value_parser = parse_choice::<Boundary>(), default_value_t = Boundary::Periodic)]
    #[serde(serialize_with = "by_name")]
    boundary: Boundary,
    /// Largest pressure that the surfaces carry, stress; where it is reached they are pressed into each other
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    hardness: Option<f64>,
    #[command(flatten)]
    #[serde(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    #[serde(flatten)]
    law: LawArgs,
    /// Fields of each load that go into --out: some of pressure, displacement_z, gap and plastic_depth, or none; default: all
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
    /// Draw the contact map and area against pressure: PREFIX-map.svg, .png, PREFIX-area.svg, .png
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix)]
    #[serde(skip)]
    plots: Option<PathBuf>,
}

/// The flags of the loads, of which exactly one is given.
#[derive(ClapArgs, Clone, Debug, Serialize)]
#[group(required = true, multiple = false)]
struct ControlArgs {
    /// Mean pressures, stress
    #[arg(long, value_delimiter = ',', value_name = "P1,P2,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pressure: Vec<f64>,
    /// Reduced pressures p/(E* g)
    #[arg(long, value_delimiter = ',', value_name = "P1,P2,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    p_star: Vec<f64>,
    /// Rigid approaches beyond first touch, length
    #[arg(long, value_delimiter = ',', value_name = "D1,D2,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    displacement: Vec<f64>,
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

/// The result, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub n: [usize; 2],
    pub length: [f64; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    pub surface: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scan: Option<Scan>,
    pub rms_gradient: f64,
    pub rms_height: f64,
    pub e_star: f64,
    /// The body, unless it is a half-space or a slab on a bonded base, and alone.
    #[serde(flatten)]
    pub others: OtherArgs,
    #[serde(skip)]
    pub body: Option<String>,
    pub boundary: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hardness: Option<f64>,
    pub loads: Vec<LoadRecord>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_converged: Option<NotConverged>,
    pub peak_bytes: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    pub plots: Vec<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// Unusable input; a file that could not be written.
pub fn run(args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
    Prepared::new(args, session)?.run(args, session)
}

/// The input of the command, checked before the first solve.
struct Prepared {
    surface: Surface,
    body: Body,
    law: Arc<dyn Law>,
    controls: Vec<Load>,
    output: Option<Output>,
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
        // Negative (tensile) loads need an attractive law.
        let pulls = args.law.law != Kind::HardWall;
        let allowed = if pulls { "finite" } else { "positive and finite" };
        for (flag, values) in flags {
            if let Some(bad) = values.iter().find(|v| !(v.is_finite() && (pulls || **v > 0.0))) {
                return Err(Failure::value(flag, bad, allowed));
            }
        }
        if let (Boundary::Free, true) = (args.boundary, pulls) {
            return Err(Failure::value("--boundary", args.boundary, "periodic with --law"));
        }
        if let (Some(hardness), true) = (args.hardness, pulls) {
            return Err(Failure::value("--hardness", hardness, "absent with --law"));
        }
        if let Some(hardness) = args.hardness.filter(|hardness| !(hardness.is_finite() && *hardness > 0.0)) {
            return Err(Failure::value("--hardness", hardness, "positive and finite"));
        }
        if let (Some(fields), None) = (&args.fields, args.hardness)
            && fields.names_plastic_depth()
        {
            return Err(Failure::value("--fields", fields, "without plastic_depth, or with --hardness"));
        }
        let surface = args.source.bounded(args.boundary, session)?;
        let fields = match (args.law.law, args.boundary) {
            (Kind::HardWall, Boundary::Periodic) if args.hardness.is_none() => Held::HARD_WALL,
            (Kind::HardWall, _) => Held::FREE,
            _ => Held::LAW,
        };
        fields.check("the grid", surface.grid.points())?;
        let unit_pressure = body.contact_modulus() * surface.rms_gradient();
        args.body.check_on(&surface.grid, unit_pressure)?;
        let controls = (args.control.pressure.iter().map(|p| Load::MeanPressure(*p)))
            .chain(args.control.p_star.iter().map(|p| Load::MeanPressure(p * unit_pressure)))
            .chain(args.control.displacement.iter().map(|d| Load::Approach(*d)))
            .collect();
        let output =
            args.out.as_ref().map(Output::claim).transpose().map_err(|error| Failure::input("--out", error))?;
        Ok(Self { surface, body, law, controls, output })
    }

    fn run(&self, args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
        let refuse = |refusal: Refusal| match refusal {
            Refusal::Body(_) => Failure::input("--boundary free", refusal),
            _ => Failure::input(&args.source.name(), refusal),
        };
        let (body, Surface { grid, heights, .. }) = (&self.body, &self.surface);
        if args.law.law == Kind::HardWall {
            // The solvers for a hard wall alone are faster than those for a law.
            let contact = Contact::bounded(args.boundary, body, grid, heights);
            let contact = match args.hardness {
                Some(hardness) => contact.and_then(|contact| contact.with_hardness(hardness)),
                None => contact,
            };
            let contact = contact.map_err(refuse)?;
            return self.press(&contact, contact.surface(), args, session);
        }
        let interface = Interface::new(body, grid, heights, Arc::clone(&self.law)).map_err(refuse)?;
        if let Some(trapping) = interface.trapping() {
            session.warn("lattice-trapping", trapping);
        }
        self.press(&interface, interface.surface(), args, session)
    }

    /// Solves the loads in turn, each from the state of the load before, until one fails.
    fn press<E: Resumable<State: Recorded>>(
        &self,
        contact: &E,
        rigid: &RigidSurface,
        args: &Args,
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
            rms_gradient: self.surface.rms_gradient(),
            rms_height: rigid.rms_height(),
            e_star: self.body.contact_modulus(),
            others: args.body.others.clone(),
            body: args.body.words(),
            boundary: self.surface.boundary.name(),
            hardness: args.hardness,
            loads: Vec::new(),
            not_converged: None,
            peak_bytes: 0,
            out: None,
            plots: Vec::new(),
        };
        let resolved = Args { source: args.source.resolved()?, ..args.clone() };
        let config = toml::to_string(&resolved).map_err(|error| Failure::Computation(error.to_string()))?;
        let mut kept = match &self.output {
            Some(output) => {
                let head = session.identity(&config, &self.surface);
                Some(Kept::open(output, head, self.controls.len(), args.resume, args.checkpoint.every()?)?)
            }
            None => None,
        };
        let series = Series { prepared: self, contact, args, session };
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
        report.peak_bytes = peak_bytes();
        let written = report.out.as_ref().map_or_else(String::new, |out| format!("; kept in {}", out.display()));
        let failure = failure.map(|failure| failure.with(&written));
        Ok(Outcome { report, failure })
    }
}

/// The loads of one contact.
struct Series<'a, E: Resumable> {
    prepared: &'a Prepared,
    contact: &'a E,
    args: &'a Args,
    session: &'a Session,
}

impl<E: Resumable<State: Recorded>> Series<'_, E> {
    /// Solves the loads that are not kept, and writes the file. Returns the failure of the last load. An interrupted run
    /// whose state is kept has no file.
    fn solve(
        &self,
        report: &mut Report,
        mut kept: Option<&mut Kept>,
        config: String,
    ) -> Result<Option<Failure>, Failure> {
        let Self { prepared: Prepared { surface, controls, output, .. }, contact, args, session } = *self;
        let budget = args.solver.budget();
        let with_law = args.law.law != Kind::HardWall;
        let provenance = session.provenance(config);
        let chosen = args.fields.clone().unwrap_or(Chosen::ALL);
        let create = |output| {
            let is_plastic = args.hardness.is_some();
            ContactFile::create(output, &provenance, surface, controls.len(), with_law, is_plastic, chosen.clone())
        };
        let mut file = output.as_ref().map(create).transpose()?;
        let progress = Progress::new(&session.common, "loads", controls.len() as f64);
        let scales = Scales { contact_modulus: report.e_star, rms_gradient: report.rms_gradient };
        let mut last = match (&mut kept, &mut file) {
            (Some(kept), Some(file)) => self.recall(report, kept, file, &progress)?,
            _ => None,
        };
        let mut failure = None;
        for (index, load) in controls.iter().enumerate().skip(report.loads.len()) {
            let started = Instant::now();
            let mut watch = Watching {
                index,
                progress: &progress,
                session,
                history: History::default(),
                kept: kept.as_deref_mut(),
                closing: false,
                failed: None,
            };
            let press = contact.press(*load).solver(args.solver.solver).budget(budget).starting_from(last.as_ref());
            let solved = press.watch(&mut watch).solve();
            let Watching { history, failed, .. } = watch;
            failed.map_or(Ok(()), Err)?;
            let why = if let Err(SolveError::NotConverged { why, .. }) = &solved { Some(*why) } else { None };
            let (mut state, stopped) = match reached(solved) {
                // Numbers that this load alone makes too large; the loads before it stay.
                Err(refused) if index > 0 => {
                    failure = Some(Failure::Computation(refused.to_string()).at(&format!("load {index}")));
                    break;
                }
                other => other?,
            };
            let record = LoadRecord::measure(&state, &scales, budget.tolerance, started.elapsed().as_secs_f64());
            let record = record.bounded(surface.boundary, &surface.grid);
            progress.advance(1.0, &format!("p* {:.3e}, area {:.4}", record.p_star, record.area_fraction));
            record.check(index)?;
            report.loads.push(record);
            if let Some(why) = why {
                let unmet = NotConverged::new(index, &state, budget.tolerance, &why, history);
                unmet.tell("load");
                report.not_converged = Some(unmet);
            }
            if let Some(file) = &mut file {
                file.write(index, &state)?;
            }
            if let Some(stopped) = stopped {
                failure = Some(stopped.at(&format!("load {index}")));
                last = Some(state);
                break;
            }
            if let Some(kept) = &mut kept {
                let fields = chosen.fields(&state);
                let fields = fields.iter().map(|field| contiguous(field)).collect();
                kept.add(&Part { text: record.to_toml()?, fields });
                kept.keep_state(|visitor| contact.keep(&mut state, visitor))?;
            }
            last = Some(state);
        }
        progress.finish();
        if matches!(failure, Some(Failure::Interrupted(_))) && kept.is_some() {
            return Ok(failure);
        }
        if let Some(file) = file {
            report.out = Some(file.finish(&report.loads, controls.len(), report.not_converged.as_ref())?);
        }
        if let (None, Some(prefix), Some(state)) = (&failure, &args.plots, &last) {
            let pressure = state.pressure().mapv(|p| p.max(0.0));
            report.plots = figures::draw(prefix, report, &surface.grid, &pressure)?;
        }
        Ok(failure)
    }

    /// Takes over the loads that are kept; returns the state of the last one.
    fn recall(
        &self,
        report: &mut Report,
        kept: &mut Kept,
        file: &mut ContactFile,
        progress: &Progress,
    ) -> Result<Option<E::State>, Failure> {
        for index in 0..kept.finished() {
            let Part { text, fields } = kept.part(index)?;
            report.loads.push(toml::from_str(&text).map_err(|error| kept.unusable(index, error.message()))?);
            file.write_values(index, &fields)?;
            progress.advance(1.0, "kept");
        }
        let Some(index) = kept.finished().checked_sub(1) else { return Ok(None) };
        let load = self.prepared.controls[index];
        kept.state().map(|mut stored| stored.restore(|visitor| self.contact.restore(load.into(), visitor))).transpose()
    }
}

/// The watcher of one load: progress, history, interruption, and copies of the solve.
struct Watching<'a, 'k> {
    index: usize,
    progress: &'a Progress,
    session: &'a Session,
    history: History,
    kept: Option<&'a mut Kept<'k>>,
    /// True after an interruption, which waits for the next copy.
    closing: bool,
    failed: Option<Failure>,
}

impl Watch for Watching<'_, '_> {
    fn see(&mut self, now: &gfmd_contact::Progress) -> ControlFlow<()> {
        let gfmd_contact::Progress { iteration, residual } = *now;
        let note = format!("load {}, iteration {iteration}, residual {residual:.1e}", self.index);
        self.progress.advance(0.0, &note);
        self.history.see(iteration, residual);
        if self.failed.is_some() || self.closing || (self.session.is_interrupted() && self.kept.is_none()) {
            return ControlFlow::Break(());
        }
        self.closing = self.session.is_interrupted();
        ControlFlow::Continue(())
    }

    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        let Some(kept) = self.kept.as_deref_mut().filter(|kept| self.closing || kept.is_due()) else { return };
        self.failed = kept.checkpoint(variables).err();
    }

    fn recall(&mut self) -> Option<&mut dyn Visit> {
        let running = self.kept.as_deref_mut()?.running()?;
        Some(running)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [nx, ny] = self.n;
        let unit = self.unit.as_deref().unwrap_or("length units");
        writeln!(f, "{}", self.surface)?;
        if let Some(scan) = &self.scan {
            write!(f, "{scan}")?;
        }
        writeln!(f, "{nx} x {ny} points, cell {:.6e} x {:.6e} {unit}", self.length[0], self.length[1])?;
        let (kind, free) = if self.boundary == Boundary::Free.name() {
            ("differences", "; free boundaries: a patch on an unbounded half-space")
        } else {
            ("spectral", "")
        };
        writeln!(
            f,
            "rms gradient {:.6} ({kind}), rms height {:.6e} {unit}, E* = {:.6e}{free}\n",
            self.rms_gradient, self.rms_height, self.e_star
        )?;
        if let Some(body) = &self.body {
            writeln!(f, "elastic body: {body}\n")?;
        }
        if let Some(hardness) = self.hardness {
            let shares = self.loads.iter().map(|load| format!("{:.6}", load.plastic_fraction.unwrap_or(f64::NAN)));
            writeln!(f, "hardness {hardness:.6e}, plastic fractions {}\n", shares.collect::<Vec<_>>().join(", "))?;
        }
        writeln!(
            f,
            "{:>11} {:>11} {:>11} {:>9} {:>9} {:>7} {:>11} {:>11} {:>7} {:>8} {:>9}",
            "pressure",
            "p*",
            "approach",
            "area",
            "corrected",
            "kappa",
            "mean gap",
            "peak p",
            "steps",
            "pairs",
            "residual"
        )?;
        for load in &self.loads {
            let equilibrium = load.law.map_or(0.0, |law| law.residual_equilibrium);
            let worst = gfmd_relax::worst([load.residual.worst(), equilibrium]);
            writeln!(
                f,
                "{:>11.4e} {:>11.4e} {:>11.4e} {:>9.6} {:>9.6} {:>7.4} {:>11.4e} {:>11.4e} {:>7} {:>8.1} {:>9.1e}{}",
                load.mean_pressure,
                load.p_star,
                load.displacement,
                load.area_fraction,
                load.area_fraction_corrected,
                load.kappa,
                load.mean_gap,
                load.max_pressure,
                load.iterations,
                load.transform_pairs,
                worst,
                if load.converged { "" } else { "  NOT CONVERGED" }
            )?;
        }
        list_files(f, self.out.as_deref(), &self.plots)
    }
}
