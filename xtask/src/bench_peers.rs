//! `bench-peers`: times this program and peers (other programs) on common problems, to one certified residual.
//!
//! The peers are installed from PyPI into a separate Python environment, and every solve is a separate process. One
//! independent routine in NumPy (peers/certify.py) computes the residuals of all final pressures.

mod adhesion;
mod any_load;
mod contestant;
mod creep;
mod figure;
mod judge;
mod kept;
mod measure;
mod process;
mod python;
mod report;
mod rows;
mod solve;
mod table;
mod tolerance;
mod yielding;

#[cfg(test)]
mod tests;

use std::fmt;
use std::path::{Path, PathBuf};

use clap::{Args as ClapArgs, ValueEnum};
use gfmd_contact::{Boundary, Solver};
use gfmd_field::Grid;
use gfmd_input::failure::Failure;
use gfmd_input::session::{Session, machine};
use gfmd_problem::options::{named, parse_choice};
use gfmd_surface::{SelfAffine, Statistics};
use ndarray::Array2;
use ndarray_npy::write_npy;
use serde::{Serialize, Serializer};

pub use adhesion::{Adhesion, Course, Row as AdhesionRow};
pub use any_load::{AnyLoad, Block, Cell, ContactVariant, Row};
use contestant::{Contestant, Problem};
pub use creep::{Creep, Row as CreepRow};
use measure::Bench;
use python::Environment;
use report::Interrupted;
pub use report::{Case, Entry, Report, Timing};
pub use rows::{Args as RowsArgs, Rows, run as rows};
pub use solve::{Args as SolveArgs, Solve, run as solve};
pub use yielding::{Course as YieldingCourse, Row as YieldingRow, Yielding};

/// Flags of `bench-peers`.
#[derive(ClapArgs, gfmd_problem::options::Options, Clone, Debug, Serialize)]
#[command(after_help = "Examples:
  gfmd bench-peers --quick
  gfmd bench-peers --write-docs
  gfmd bench-peers --any-load --write-docs
  gfmd bench-peers --creep --sizes 256,1024 --write-docs
  gfmd bench-peers --adhesion --sizes 128,256 --write-docs
  gfmd bench-peers --yielding --write-docs
  gfmd bench-peers --boundary free --sizes 512 --peers tamaas,aspher,hertzian
  gfmd bench-peers --sizes 2048 --hurst 0.8 --p-star 0.05 --peers tamaas --tamaas-fftw tuned --json")]
pub struct Args {
    /// Grid points along a side [default: 512,1024,2048; with --any-load or --creep 256; with --adhesion 128;
    /// with --yielding 32,64,128]
    #[arg(long, value_delimiter = ',', value_name = "N,..")]
    pub sizes: Vec<usize>,
    /// Hurst exponents
    #[arg(long, value_delimiter = ',', default_values_t = [0.8, 0.0], value_name = "H,..")]
    pub hurst: Vec<f64>,
    /// Reduced pressures p/(E* g) [default: 0.0001,0.01,0.05,0.2,1; with --any-load 0.0001 to 3]
    #[arg(long, value_delimiter = ',', value_name = "P,..")]
    pub p_star: Vec<f64>,
    /// The surroundings of the surfaces
    #[arg(
        long,
        value_parser = parse_choice::<Boundary>(),
        default_value_t = Boundary::Periodic,
        conflicts_with = "any_load"
    )]
    #[serde(with = "named")]
    pub boundary: Boundary,
    /// A table of all loads, from first touch to full contact, with periodic and free boundaries and with a hardness:
    /// what every program reaches there, judged by one certificate, and what fails. Each is asked for --tolerance, and
    /// up to twice for less
    #[arg(long, conflicts_with_all = ["quick", "solvers"])]
    pub any_load: bool,
    /// With --any-load: leave times out, as on a machine that is not idle
    #[arg(long, requires = "any_load")]
    pub without_times: bool,
    /// Creep tests of viscoelastic bodies, of this program and of Tamaas, in the same steps
    #[arg(long, conflicts_with_all = ["any_load", "quick", "solvers", "resume", "boundary"])]
    pub creep: bool,
    /// Loads with an exponential adhesion, of this program and of Tamaas
    #[arg(long, conflicts_with_all = ["any_load", "creep", "quick", "solvers", "p_star", "resume", "boundary"])]
    pub adhesion: bool,
    /// Steps of a sphere on a body that yields, of this program and of Tamaas
    #[arg(
        long,
        conflicts_with_all = ["any_load", "creep", "adhesion", "quick", "solvers", "p_star", "resume", "boundary"]
    )]
    pub yielding: bool,
    /// Numbers of threads
    #[arg(long, value_delimiter = ',', default_values_t = [1, 2], value_name = "N,..")]
    pub thread_counts: Vec<usize>,
    /// Seed of the surfaces
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Bound on the certified residuals of all programs: complementarity, penetration, negative pressure and load
    #[arg(long, default_value_t = 1e-8, value_name = "TOL")]
    pub tolerance: f64,
    /// Solvers of this program to run
    #[arg(
        long,
        value_parser = parse_choice::<Solver>(),
        value_delimiter = ',',
        default_values_t = [Solver::Auto, Solver::PolonskyKeer]
    )]
    #[serde(serialize_with = "names")]
    pub solvers: Vec<Solver>,
    /// Peers (other programs) to run, of those that are installed [default: tamaas,contact-mechanics,no-restart,aspher;
    /// with free boundaries tamaas,contact-mechanics,aspher,hertzian; with --any-load all]
    #[arg(long, value_enum, value_delimiter = ',')]
    pub peers: Vec<Peer>,
    /// FFTW used by Tamaas
    #[arg(long, value_enum, default_value_t = TamaasFftw::Preloaded)]
    pub tamaas_fftw: TamaasFftw,
    /// Smallest number of solves up to 1024 x 1024 points; larger ones may run once. The median is reported
    #[arg(long, default_value_t = 3, value_name = "K")]
    pub repeats: usize,
    /// Time limit: a peer is left out of a case that takes it longer, or is expected to
    /// [default: 1800; with --any-load and --adhesion 60]
    #[arg(long, value_name = "SECONDS")]
    pub patience: Option<f64>,
    /// A smoke run: 128 and 256 points, H = 0.8, p* = 0.05, one repeat
    #[arg(long, conflicts_with_all = ["sizes", "hurst", "p_star", "repeats"])]
    pub quick: bool,
    /// Python program that creates the environment
    #[arg(long, default_value = "python3", value_name = "PROGRAM")]
    pub python: PathBuf,
    /// Folder of the environment, created if missing [default: bench-peers/venv beside the build]
    #[arg(long, value_name = "FOLDER")]
    pub venv: Option<PathBuf>,
    /// Continue an interrupted run: its finished cases are taken as they are. It must have had the same settings,
    /// program, peers and machine
    #[arg(long)]
    pub resume: bool,
    /// Write the documentation page [default: docs/benchmarks.md; with --any-load docs/any-load.md; with --creep
    /// docs/creep-peers.md]
    #[arg(long, value_name = "FILE.md")]
    pub write_docs: Option<Option<PathBuf>>,
}

fn names<S: Serializer>(solvers: &[Solver], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(solvers.iter().map(|solver| solver.name()))
}

/// A peer: another program with a solver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Peer {
    /// Tamaas, PolonskyKeerRey
    Tamaas,
    /// ContactMechanics, its default solver
    ContactMechanics,
    /// ContactMechanics with NuMPI's conjugate gradients without restart, at a prescribed displacement
    NoRestart,
    /// ContactMechanics with NuMPI's conjugate gradients without restart, under a load (slower)
    NoRestartLoad,
    /// Tamaas with free boundaries registered, and not also chosen: it solves the periodic problem
    TamaasRegistered,
    /// ASPHER, its nested grids
    Aspher,
    /// ASPHER with its active set, which leaves points out, and the H2 operator, an approximation, which that needs
    /// (free boundaries)
    AspherActive,
    /// hertzian, which has free boundaries only; install it into the environment from its repository
    Hertzian,
}

impl Peer {
    /// Returns the name of its package.
    fn package(self) -> &'static str {
        match self {
            Self::Tamaas | Self::TamaasRegistered => "Tamaas",
            Self::ContactMechanics | Self::NoRestart | Self::NoRestartLoad => "ContactMechanics",
            Self::Aspher | Self::AspherActive => "aspher",
            Self::Hertzian => "hertzian",
        }
    }
}

/// The FFTW used by Tamaas.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum TamaasFftw {
    /// A preloaded FFTW with vector code, with estimated plans as requested by Tamaas
    Preloaded,
    /// A preloaded FFTW with vector code and measured plans, which users of Tamaas do not have
    Tuned,
    /// The FFTW inside the package of Tamaas
    Own,
}

impl Args {
    /// Returns the arguments with the default values, or the values of `--quick`, filled in and sorted.
    fn resolved(&self) -> Self {
        let mut args = self.clone();
        if self.quick {
            (args.sizes, args.hurst, args.p_star, args.repeats) = (vec![128, 256], vec![0.8], vec![0.05], 1);
        }
        let fill = |values: &mut Vec<usize>, defaults: &[usize]| {
            if values.is_empty() {
                values.extend(defaults);
            }
        };
        let sizes: &[usize] = match () {
            () if self.adhesion => &[128],
            () if self.yielding => &[32, 64, 128],
            () if self.any_load || self.creep => &[256],
            () => &[512, 1024, 2048],
        };
        fill(&mut args.sizes, sizes);
        if args.p_star.is_empty() {
            args.p_star = match () {
                () if self.any_load => any_load::LOADS.to_vec(),
                () if self.creep => vec![0.05],
                () => vec![1e-4, 0.01, 0.05, 0.2, 1.0],
            };
        }
        if args.peers.is_empty() {
            args.peers = match self.boundary {
                _ if self.any_load => any_load::PEERS.to_vec(),
                Boundary::Periodic => vec![Peer::Tamaas, Peer::ContactMechanics, Peer::NoRestart, Peer::Aspher],
                Boundary::Free => vec![Peer::Tamaas, Peer::ContactMechanics, Peer::Aspher, Peer::Hertzian],
            };
        }
        args.patience = args.patience.or(Some(if self.any_load || self.adhesion { 60.0 } else { 1800.0 }));
        args.sizes.sort_unstable();
        args.thread_counts.sort_unstable();
        args
    }

    /// Returns the time limit of a peer, s.
    fn patience(&self) -> f64 {
        self.patience.unwrap_or(f64::INFINITY)
    }

    /// Returns the page to write, if requested.
    fn page(&self) -> Option<&Path> {
        let default = match () {
            () if self.any_load => "docs/any-load.md",
            () if self.creep => "docs/creep-peers.md",
            () => "docs/benchmarks.md",
        };
        self.write_docs.as_ref().map(|file| file.as_deref().unwrap_or(Path::new(default)))
    }

    fn check(&self) -> Result<(), Failure> {
        let positive = |flag, values: &[f64]| match values.iter().find(|v| !(v.is_finite() && **v > 0.0)) {
            Some(bad) => Err(Failure::refused(format!("{flag} is {bad}; it must be positive and finite"))),
            None => Ok(()),
        };
        positive("--p-star", &self.p_star)?;
        if self.patience.is_some_and(|patience| !(patience > 0.0 && patience <= 1e7)) {
            return Err(Failure::refused(format!(
                "--patience is {}; it must be above 0 and at most 1e7 s",
                self.patience()
            )));
        }
        if !(1e-12..=1e-3).contains(&self.tolerance) {
            return Err(Failure::refused(format!(
                "--tolerance is {}; it must be between 1e-12 and 1e-3",
                self.tolerance
            )));
        }
        if let Some(bad) = self.sizes.iter().find(|n| **n < 32) {
            return Err(Failure::refused(format!("--sizes contains {bad}; each must be at least 32")));
        }
        if self.repeats == 0 {
            return Err(Failure::refused("--repeats is 0; it must be at least 1"));
        }
        if self.thread_counts.contains(&0) {
            return Err(Failure::refused("--thread-counts contains 0; each must be at least 1"));
        }
        let empty = [
            ("--sizes", self.sizes.is_empty()),
            ("--hurst", self.hurst.is_empty()),
            ("--p-star", self.p_star.is_empty()),
            ("--thread-counts", self.thread_counts.is_empty()),
            ("--solvers", self.solvers.is_empty()),
        ];
        match empty.into_iter().find(|(_, empty)| *empty) {
            Some((flag, _)) => Err(Failure::refused(format!("{flag} is empty; it must have at least one value"))),
            None => Ok(()),
        }
    }

    /// Returns all contestants; the first is the reference of the comparisons.
    fn contestants(&self) -> Vec<Contestant> {
        let own = self.solvers.iter().copied().map(Contestant::Own);
        own.chain(self.peers.iter().copied().map(Contestant::Peer)).collect()
    }

    /// Removes the peers that are not installed or do not suit the boundary; returns remarks on them.
    fn leave_out(&mut self, environment: &Environment) -> Vec<String> {
        let mut notes = Vec::new();
        let boundary = self.boundary;
        let is_any = self.any_load;
        self.peers.retain(|peer| {
            let contestant = Contestant::Peer(*peer);
            let why = if !environment.has(*peer) {
                "it is not installed"
            } else if !is_any && !contestant.suits(boundary, None) {
                "it has no contacts with these boundaries"
            } else {
                return true;
            };
            notes.push(format!("{contestant} is left out: {why}."));
            false
        });
        notes
    }
}

/// Cell length divided by longest wavelength, and grid points per shortest wavelength, of every surface.
const EPS_T_INV: f64 = 2.0;
const EPS_C_INV: f64 = 4.0;

/// Spectral rms gradient of every surface.
const RMS_GRADIENT: f64 = 0.1;

/// Result of the command.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Made {
    /// Times to one certified residual.
    Timed(Report),
    /// Table of all loads.
    AnyLoad(AnyLoad),
    /// Creep tests.
    Creep(Creep),
    /// Loads with adhesion.
    Adhesion(Adhesion),
    /// Steps of a body that yields.
    Yielding(Yielding),
}

impl fmt::Display for Made {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Timed(report) => report.fmt(f),
            Self::AnyLoad(table) => table.fmt(f),
            Self::Creep(table) => table.fmt(f),
            Self::Adhesion(table) => table.fmt(f),
            Self::Yielding(table) => table.fmt(f),
        }
    }
}

/// Runs the command. After a failure the finished cases are kept in a file named in the message.
///
/// # Errors
/// Invalid input; an environment that cannot be created; a failed solve of this program; without `--any-load` a result
/// with a certified residual above the tolerance, or one that differs from the first contestant.
pub fn run(args: &Args, session: &Session) -> Result<Made, Failure> {
    let mut args = args.resolved();
    args.check()?;
    let folder = work_folder()?;
    let mut environment = Environment::prepare(&args, &folder, session)?;
    if args.creep {
        return creep::run(&args, &environment, session).map(Made::Creep);
    }
    if args.adhesion {
        return adhesion::run(&args, &environment, session).map(Made::Adhesion);
    }
    if args.yielding {
        return yielding::run(&args, &environment, session).map(Made::Yielding);
    }
    let left_out = args.leave_out(&environment);
    environment.notes.extend(left_out);
    if args.any_load {
        return any_load::run(&args, &folder, &environment, session).map(Made::AnyLoad);
    }
    timed(&args, &folder, &environment, session).map(Made::Timed)
}

/// Times all contestants to one certified residual.
fn timed(args: &Args, folder: &Path, environment: &Environment, session: &Session) -> Result<Report, Failure> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let (possible, too_many): (Vec<usize>, Vec<usize>) = args.thread_counts.iter().partition(|t| **t <= cores);
    if possible.is_empty() {
        return Err(Failure::refused(format!(
            "--thread-counts is {too_many:?}; it must be between 1 and {cores} on this machine"
        )));
    }
    let mut report = Report {
        date: jiff::Zoned::now().date().to_string(),
        machine: machine(),
        commit: gfmd_input::session::GIT_COMMIT.into(),
        versions: environment.versions(),
        fftw: environment.fftw_in_words(),
        tamaas_fftw: environment.tamaas_fftw,
        contestants: args.contestants().iter().map(ToString::to_string).collect(),
        boundary: args.boundary.name(),
        tolerance: args.tolerance,
        seed: args.seed,
        cases: Vec::new(),
        notes: environment.notes.clone(),
        kept: folder.join("bench-peers.json"),
    };
    if !too_many.is_empty() {
        report.notes.push(format!("Numbers of threads {too_many:?} were left out: the machine has {cores} cores."));
    }
    let resumed = if args.resume { report.resumed()? } else { Interrupted::default() };
    let notes: Vec<String> = resumed.notes.into_iter().filter(|note| !report.notes.contains(note)).collect();
    report.notes.extend(notes);
    let mut bench = Bench::new(args, possible, environment, session, resumed.cases);
    for &points in &args.sizes {
        for &hurst in &args.hurst {
            let problems = problems(args, points, hurst, environment.scratch())?;
            for problem in &problems {
                if let Some(case) = bench.finished(problem) {
                    report.cases.push(case);
                    continue;
                }
                let done = bench.case(problem, &mut report.notes).map_err(|failure| report.keep_after(failure))?;
                report.cases.push(done);
                report.keep()?;
            }
        }
    }
    if let Some(file) = args.page() {
        report.write_page(file)?;
    }
    Ok(report)
}

/// Returns the folder for the files of this command, beside the build.
fn work_folder() -> Result<PathBuf, Failure> {
    let program = std::env::current_exe().ok();
    let build = program.as_deref().and_then(|file| file.parent()?.parent()).map(PathBuf::from);
    let folder = build.unwrap_or_else(|| "target".into()).join("bench-peers");
    let made = std::fs::create_dir_all(&folder);
    made.map_err(|error| Failure::computation(format!("{}: {error}", folder.display())))?;
    Ok(folder)
}

/// Returns the heights of a surface in a cell of length 1, and their rms gradient.
fn rough(points: usize, hurst: f64, seed: u64) -> Result<(Array2<f64>, f64), Failure> {
    let refuse = |error: &dyn std::fmt::Display| Failure::input("--sizes, --hurst", error);
    let grid = Grid::new([points; 2], [1.0; 2]).map_err(|error| refuse(&error))?;
    let shortest = EPS_C_INV / points as f64;
    let spectrum = SelfAffine {
        hurst,
        longest_wavelength: 1.0 / EPS_T_INV,
        shortest_wavelength: shortest,
        ..SelfAffine::with_rms_gradient(RMS_GRADIENT)
    };
    let heights = spectrum.heights(&grid, seed).map_err(|error| refuse(&error))?;
    let statistics = Statistics::of(&heights, &grid).map_err(|error| refuse(&error))?;
    Ok((heights, statistics.moments.rms_gradient()))
}

/// Returns the problems of one surface, one per load, and writes the surface to `folder` for all contestants.
fn problems(args: &Args, points: usize, hurst: f64, folder: &Path) -> Result<Vec<Problem>, Failure> {
    let (heights, rms_gradient) = rough(points, hurst, args.seed)?;
    let file = folder.join(format!("h-{points}-{hurst}.npy"));
    write_npy(&file, &heights).map_err(|error| Failure::computation(format!("{}: {error}", file.display())))?;
    let answer = args.contestants()[0].pressure_file(folder, 1);
    let load = |&p_star: &f64| {
        let mean_pressure = p_star * rms_gradient;
        let (heights, answer) = (file.clone(), answer.clone());
        let (boundary, hardness, most_iterations) = (args.boundary, None, None);
        Problem { points, hurst, p_star, mean_pressure, heights, boundary, hardness, most_iterations, answer }
    };
    Ok(args.p_star.iter().map(load).collect())
}
