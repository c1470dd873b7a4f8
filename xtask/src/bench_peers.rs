//! `bench-peers`: times this program and peers (other programs) on common contact problems, to one certified residual.
//!
//! The peers are installed from PyPI into a separate Python environment, and every solve is a separate process. One
//! independent routine in NumPy (peers/certify.py) computes the residuals of all final pressures.

mod contestant;
mod judge;
mod measure;
mod process;
mod python;
mod report;
mod tolerance;

#[cfg(test)]
mod tests;

use std::path::PathBuf;

use clap::{Args as ClapArgs, ValueEnum};
use gfmd_cli::choice::parse_choice;
use gfmd_cli::failure::Failure;
use gfmd_cli::session::{Session, machine};
use gfmd_contact::Solver;
use gfmd_field::Grid;
use gfmd_surface::{SelfAffine, Statistics};
use ndarray_npy::write_npy;
use serde::{Serialize, Serializer};

use contestant::{Contestant, Problem};
use measure::Bench;
use python::Environment;
pub use report::{Case, Entry, Report, Timing};

/// Flags of `bench-peers`.
#[derive(ClapArgs, Clone, Debug, Serialize)]
#[command(after_help = "Examples:
  gfmd bench-peers --quick
  gfmd bench-peers --write-docs
  gfmd bench-peers --sizes 2048 --hurst 0.8 --p-star 0.05 --peers tamaas --tamaas-fftw tuned --json")]
pub struct Args {
    /// Grid points along a side
    #[arg(long, value_delimiter = ',', default_values_t = [512, 1024, 2048], value_name = "N,..")]
    pub sizes: Vec<usize>,
    /// Hurst exponents
    #[arg(long, value_delimiter = ',', default_values_t = [0.8, 0.0], value_name = "H,..")]
    pub hurst: Vec<f64>,
    /// Reduced pressures p/(E* g)
    #[arg(long, value_delimiter = ',', default_values_t = [0.01, 0.05, 0.2], value_name = "P,..")]
    pub p_star: Vec<f64>,
    /// Numbers of threads
    #[arg(long, value_delimiter = ',', default_values_t = [1, 2], value_name = "N,..")]
    pub thread_counts: Vec<usize>,
    /// Seed of the surfaces
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Bound on the certified residuals of all programs: complementarity, penetration, negative pressure and load
    #[arg(long, default_value_t = 1e-8, value_name = "TOL")]
    pub tol: f64,
    /// Solvers of this program to run
    #[arg(long, value_parser = parse_choice::<Solver>(), value_delimiter = ',', default_values_t = [Solver::Auto, Solver::PolonskyKeer])]
    #[serde(serialize_with = "names")]
    pub solvers: Vec<Solver>,
    /// Peers (other programs) to run
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [Peer::Tamaas, Peer::ContactMechanics, Peer::NoRestart])]
    pub peers: Vec<Peer>,
    /// FFTW used by Tamaas
    #[arg(long, value_enum, default_value_t = TamaasFftw::Preloaded)]
    pub tamaas_fftw: TamaasFftw,
    /// Smallest number of solves up to 1024 x 1024 points; larger ones may run once. The median is reported
    #[arg(long, default_value_t = 3, value_name = "K")]
    pub repeats: usize,
    /// Time limit: a peer is left out of a case that takes it longer, or is expected to
    #[arg(long, default_value_t = 1800.0, value_name = "SECONDS")]
    pub patience: f64,
    /// A smoke run: 128 and 256 points, H = 0.8, p* = 0.05, one repeat
    #[arg(long, conflicts_with_all = ["sizes", "hurst", "p_star", "repeats"])]
    pub quick: bool,
    /// Python program that creates the environment
    #[arg(long, default_value = "python3", value_name = "PROGRAM")]
    pub python: PathBuf,
    /// Folder of the environment, created if missing [default: bench-peers/venv beside the build]
    #[arg(long, value_name = "FOLDER")]
    pub venv: Option<PathBuf>,
    /// Write the documentation page
    #[arg(long, num_args = 0..=1, default_missing_value = "docs/benchmarks.md", value_name = "FILE.md")]
    pub write_docs: Option<PathBuf>,
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
    /// The arguments with the values of `--quick` filled in, and sorted.
    fn resolved(&self) -> Self {
        let mut args = self.clone();
        if self.quick {
            (args.sizes, args.hurst, args.p_star, args.repeats) = (vec![128, 256], vec![0.8], vec![0.05], 1);
        }
        args.sizes.sort_unstable();
        args.thread_counts.sort_unstable();
        args
    }

    fn check(&self) -> Result<(), Failure> {
        let positive = |flag, values: &[f64]| match values.iter().find(|v| !(v.is_finite() && **v > 0.0)) {
            Some(bad) => Err(Failure::Input(format!("{flag} is {bad}; it must be positive and finite"))),
            None => Ok(()),
        };
        positive("--p-star", &self.p_star)?;
        if !(self.patience > 0.0 && self.patience <= 1e7) {
            return Err(Failure::Input(format!(
                "--patience is {}; it must be above 0 and at most 1e7 s",
                self.patience
            )));
        }
        if !(1e-12..=1e-3).contains(&self.tol) {
            return Err(Failure::Input(format!("--tol is {}; it must be between 1e-12 and 1e-3", self.tol)));
        }
        if let Some(bad) = self.sizes.iter().find(|n| **n < 32) {
            return Err(Failure::Input(format!("--sizes contains {bad}; each must be at least 32")));
        }
        if self.repeats == 0 {
            return Err(Failure::Input("--repeats is 0; it must be at least 1".into()));
        }
        if self.thread_counts.contains(&0) {
            return Err(Failure::Input("--thread-counts contains 0; each must be at least 1".into()));
        }
        let empty = [
            ("--sizes", self.sizes.is_empty()),
            ("--hurst", self.hurst.is_empty()),
            ("--p-star", self.p_star.is_empty()),
            ("--thread-counts", self.thread_counts.is_empty()),
            ("--solvers", self.solvers.is_empty()),
        ];
        match empty.into_iter().find(|(_, empty)| *empty) {
            Some((flag, _)) => Err(Failure::Input(format!("{flag} is empty; it must have at least one value"))),
            None => Ok(()),
        }
    }

    /// All contestants; the first is the reference of the comparisons.
    fn contestants(&self) -> Vec<Contestant> {
        let own = self.solvers.iter().copied().map(Contestant::Own);
        own.chain(self.peers.iter().copied().map(Contestant::Peer)).collect()
    }
}

/// Cell length over longest wavelength, and grid points per shortest wavelength, of every surface.
const EPS_T_INV: f64 = 2.0;
const EPS_C_INV: f64 = 4.0;

/// Points along the side of a surface that needs a negligible amount of memory.
const SMALL: usize = 32;

/// Spectral rms gradient of every surface.
const RMS_GRADIENT: f64 = 0.1;

/// Runs the command. After a failure the finished cases are kept in a file, which the message names.
///
/// # Errors
/// Invalid input; an environment that cannot be created; a failed solve of this program; a result whose certified
/// residual exceeds the tolerance, or which differs from that of the first contestant.
pub fn run(args: &Args, session: &Session) -> Result<Report, Failure> {
    let args = args.resolved();
    args.check()?;
    let folder = work_folder()?;
    let environment = Environment::prepare(&args, &folder, session)?;
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let (possible, too_many): (Vec<usize>, Vec<usize>) = args.thread_counts.iter().partition(|t| **t <= cores);
    if possible.is_empty() {
        return Err(Failure::Input(format!(
            "--thread-counts is {too_many:?}; it must be between 1 and {cores} on this machine"
        )));
    }
    let mut report = Report {
        date: jiff::Zoned::now().date().to_string(),
        machine: machine(),
        commit: gfmd_cli::session::GIT_COMMIT.into(),
        versions: environment.versions(),
        fftw: environment.fftw_in_words(),
        tamaas_fftw: environment.tamaas_fftw,
        contestants: args.contestants().iter().map(ToString::to_string).collect(),
        tolerance: args.tol,
        seed: args.seed,
        cases: Vec::new(),
        notes: environment.notes.clone(),
        kept: folder.join("bench-peers.json"),
    };
    if !too_many.is_empty() {
        report.notes.push(format!("Numbers of threads {too_many:?} were left out: the machine has {cores} cores."));
    }
    let small = problems(&args, SMALL, 0.8, environment.scratch())?;
    let mut bench = Bench::new(&args, possible, &small[0], &environment, session)?;
    for &points in &args.sizes {
        for &hurst in &args.hurst {
            let problems = problems(&args, points, hurst, environment.scratch())?;
            for problem in &problems {
                let done = bench.case(problem, &mut report.notes).map_err(|failure| report.keep_after(failure))?;
                report.cases.push(done);
                report.keep()?;
            }
        }
    }
    if let Some(file) = &args.write_docs {
        report.write_page(file)?;
    }
    Ok(report)
}

/// The folder for the files of this command, beside the build.
fn work_folder() -> Result<PathBuf, Failure> {
    let program = std::env::current_exe().ok();
    let build = program.as_deref().and_then(|file| file.parent()?.parent()).map(PathBuf::from);
    let folder = build.unwrap_or_else(|| "target".into()).join("bench-peers");
    let made = std::fs::create_dir_all(&folder);
    made.map_err(|error| Failure::Computation(format!("{}: {error}", folder.display())))?;
    Ok(folder)
}

/// The problems of one surface, one per load; writes the surface to `folder` for all contestants.
fn problems(args: &Args, points: usize, hurst: f64, folder: &std::path::Path) -> Result<Vec<Problem>, Failure> {
    let refuse = |error: &dyn std::fmt::Display| Failure::input("--sizes, --hurst", error);
    let grid = Grid::new([points; 2], [1.0; 2]).map_err(|error| refuse(&error))?;
    let shortest = EPS_C_INV / points as f64;
    let spectrum = SelfAffine {
        hurst,
        longest_wavelength: 1.0 / EPS_T_INV,
        shortest_wavelength: shortest,
        ..SelfAffine::with_rms_gradient(RMS_GRADIENT)
    };
    let heights = spectrum.heights(&grid, args.seed).map_err(|error| refuse(&error))?;
    let statistics = Statistics::of(&heights, &grid).map_err(|error| refuse(&error))?;
    let rms_gradient = statistics.moments.rms_gradient();
    let file = folder.join(format!("h-{points}-{hurst}.npy"));
    write_npy(&file, &heights).map_err(|error| Failure::Computation(format!("{}: {error}", file.display())))?;
    let answer = args.contestants()[0].pressure_file(folder, 1);
    let load = |&p_star: &f64| {
        let mean_pressure = p_star * rms_gradient;
        Problem { points, hurst, p_star, mean_pressure, heights: file.clone(), answer: answer.clone() }
    };
    Ok(args.p_star.iter().map(load).collect())
}
