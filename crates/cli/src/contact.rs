//! `contact`: one contact problem, one or more loads.

mod figures;
mod file;

use std::fmt;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use clap::Args as ClapArgs;
use gfmd_contact::{Contact, Equilibrium, Fields, Load, Refusal, RigidSurface};
use gfmd_files::Output;
use gfmd_green::Body;
use gfmd_interface::Interface;
use gfmd_law::{Kind, Law};
use gfmd_measure::Scales;
use serde::Serialize;

use crate::elastic::BodyArgs;
use crate::failure::{Failure, Outcome, reached};
use crate::figures::parse_prefix;
use crate::law::LawArgs;
use crate::load::{LoadRecord, Recorded, ResidualRecord};
use crate::memory::{Held, peak_bytes};
use crate::progress::Progress;
use crate::session::{Session, list_files};
use crate::solver::SolverArgs;
use crate::source::{SourceArgs, Surface};

pub use file::ContactFile;

/// Flags of `contact`.
#[derive(ClapArgs, Clone, Debug, Serialize)]
#[command(after_help = "Examples:
  gfmd contact --n 256 --hurst 0.8 --p-star 0.01,0.05,0.2
  gfmd contact --surface h.npy --length 1 --young 1 --poisson 0 --pressure 0.01,0.05 --json --out c.h5
  gfmd contact --n 512 --law exponential --param gamma=1e-5 --param range=1e-4 --p-star 0.02,0.01,0,-0.002
  gfmd contact --surface scan.txt --detrend plane --periodise mirror --e-star 1e9 --p-star 0.02 --plots scan")]
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
    #[command(flatten)]
    #[serde(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    #[serde(flatten)]
    law: LawArgs,
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
    pub rms_gradient: f64,
    pub rms_height: f64,
    pub e_star: f64,
    pub loads: Vec<LoadRecord>,
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
    Prepared::new(args)?.run(args, session)
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
    fn new(args: &Args) -> Result<Self, Failure> {
        let body = args.body.body()?;
        args.solver.budget().check().map_err(|error| Failure::input("--tol", error))?;
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
        let surface = args.source.surface()?;
        let fields = if args.law.law == Kind::HardWall { Held::HARD_WALL } else { Held::LAW };
        fields.check("the grid", surface.grid.points())?;
        let unit_pressure = body.material().contact_modulus() * surface.rms_gradient();
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
        let refuse = |refusal: Refusal| Failure::input(&args.source.name(), refusal);
        let (body, Surface { grid, heights, .. }) = (&self.body, &self.surface);
        if args.law.law == Kind::HardWall {
            // The solvers for a hard wall alone are faster than those for a law.
            let contact = Contact::new(body, grid, heights).map_err(refuse)?;
            return self.press(&contact, contact.surface(), args, session);
        }
        let interface = Interface::new(body, grid, heights, Arc::clone(&self.law)).map_err(refuse)?;
        if let Some(trapping) = interface.trapping() {
            tracing::warn!("{trapping}");
        }
        self.press(&interface, interface.surface(), args, session)
    }

    /// Solves the loads in turn, each from the state of the load before, until one fails.
    fn press<E: Equilibrium<State: Recorded>>(
        &self,
        contact: &E,
        rigid: &RigidSurface,
        args: &Args,
        session: &Session,
    ) -> Result<Outcome<Report>, Failure> {
        let (solver, budget) = (args.solver.solver, args.solver.budget());
        if !contact.solvers().contains(&solver) {
            return Err(Refusal::Solver { found: solver, allowed: contact.solvers() }.into());
        }
        for (index, load) in self.controls.iter().enumerate() {
            let drive = (*load).into();
            let checked = contact.check(drive).and_then(|()| contact.check_resolution(drive, budget.tolerance));
            checked.map_err(|refusal| Failure::input(&format!("{}, load {index}", args.control.flag()), refusal))?;
        }
        let mut report = Report {
            n: self.surface.grid.points(),
            length: self.surface.grid.lengths(),
            unit: self.surface.unit.clone(),
            surface: self.surface.description.clone(),
            rms_gradient: self.surface.rms_gradient(),
            rms_height: rigid.rms_height(),
            e_star: self.body.material().contact_modulus(),
            loads: Vec::new(),
            peak_bytes: 0,
            out: None,
            plots: Vec::new(),
        };
        let file = self.output.as_ref().map(|output| {
            let resolved = Args { source: args.source.resolved()?, ..args.clone() };
            let config = toml::to_string(&resolved).map_err(|error| Failure::Computation(error.to_string()))?;
            let (loads, with_law) = (self.controls.len(), args.law.law != Kind::HardWall);
            ContactFile::create(output, &session.provenance(config), &self.surface, loads, with_law)
        });
        let mut file = file.transpose()?;
        let progress = Progress::new(&session.common, "loads", self.controls.len() as f64);
        let scales = Scales { contact_modulus: report.e_star, rms_gradient: report.rms_gradient };
        let mut last: Option<E::State> = None;
        let mut failure = None;
        for (index, load) in self.controls.iter().enumerate() {
            let started = Instant::now();
            let mut watch = |now: &gfmd_contact::Progress| {
                let gfmd_contact::Progress { iteration, residual } = now;
                progress.advance(0.0, &format!("load {index}, iteration {iteration}, residual {residual:.1e}"));
                if session.is_interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let press = contact.press(*load).solver(solver).budget(budget).starting_from(last.as_ref());
            let (state, stopped) = reached(press.watch(&mut watch).solve())?;
            let record = LoadRecord::measure(&state, &scales, budget.tolerance, started.elapsed().as_secs_f64());
            if let Some(file) = &mut file {
                file.write(index, &state)?;
            }
            progress.advance(1.0, &format!("p* {:.3e}, area {:.4}", record.p_star, record.area_fraction));
            record.check(index)?;
            report.loads.push(record);
            last = Some(state);
            if let Some(stopped) = stopped {
                failure = Some(stopped.at(&format!("load {index}")));
                break;
            }
        }
        progress.finish();
        if let Some(file) = file {
            report.out = Some(file.finish(&report.loads, self.controls.len())?);
        }
        report.peak_bytes = peak_bytes();
        if let (None, Some(prefix), Some(state)) = (&failure, &args.plots, &last) {
            let pressure = state.pressure().mapv(|p| p.max(0.0));
            report.plots = figures::draw(prefix, &report, &self.surface.grid, &pressure)?;
        }
        let kept = report.out.as_ref().map_or_else(String::new, |out| format!("; kept in {}", out.display()));
        let failure = failure.map(|failure| failure.with(&kept));
        Ok(Outcome { report, failure })
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
            "rms gradient {:.6} (spectral), rms height {:.6e} {unit}, E* = {:.6e}\n",
            self.rms_gradient, self.rms_height, self.e_star
        )?;
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
            let ResidualRecord { complementarity, penetration, negative_pressure, load: residual_load } = load.residual;
            let equilibrium = load.law.map_or(0.0, |law| law.residual_equilibrium);
            let worst =
                gfmd_relax::worst([complementarity, penetration, negative_pressure, residual_load, equilibrium]);
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
