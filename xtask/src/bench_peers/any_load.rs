//! `--any-load`: results and failures of every program at any load, with each kind of boundary and with a hardness.
//!
//! Unlike the timed comparison, which needs certified results, this one shows failures: every pressure that a program
//! returns is judged by one certificate, even if the program itself reports that it did not converge.

mod page;

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use gfmd_contact::{Boundary, Solver};
use gfmd_input::failure::Failure;
use gfmd_input::session::{Session, machine};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::contestant::{Contestant, Place, Problem};
use super::judge::{Verdict, judge};
use super::process::ProgramFailure;
use super::python::Environment;
use super::solve::Solve;
use super::table::{Table, median, write_beside};
use super::{Args, Peer, RMS_GRADIENT, kept, problems};

/// Reduced pressures, from first touch to full contact.
pub(super) const LOADS: [f64; 9] = [1e-4, 1e-3, 0.01, 0.1, 0.3, 0.9, 0.99, 1.0, 3.0];

/// Peers in the table.
pub(super) const PEERS: [Peer; 7] = [
    Peer::Tamaas,
    Peer::TamaasRegistered,
    Peer::ContactMechanics,
    Peer::NoRestartLoad,
    Peer::Aspher,
    Peer::AspherActive,
    Peer::Hertzian,
];

/// Largest number of iterations of a peer, and number of solves to find a tolerance with a certified result.
const MOST_ITERATIONS: u64 = 20_000;
const TRIALS: usize = 3;

/// Fraction of the bound to aim at after a result that is not certified, and the smallest factor.
const AIM: f64 = 0.3;
const LEAST: f64 = 1e-3;

/// Kind of contact.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ContactVariant {
    /// Name in tables.
    pub name: &'static str,
    /// Boundary, "periodic" or "free".
    #[serde(with = "gfmd_problem::options::named")]
    pub boundary: Boundary,
    /// Largest pressure divided by E*.
    pub hardness: Option<f64>,
}

/// Kinds of contact. The hardness is E* times the rms gradient, so that p* = 1 is the largest load.
const KINDS: [ContactVariant; 3] = [
    ContactVariant { name: "periodic", boundary: Boundary::Periodic, hardness: None },
    ContactVariant { name: "free", boundary: Boundary::Free, hardness: None },
    ContactVariant { name: "hardness", boundary: Boundary::Periodic, hardness: Some(RMS_GRADIENT) },
];

impl ContactVariant {
    /// Returns true if the table of this kind has the load.
    fn has(&self, p_star: f64) -> bool {
        match self.hardness {
            Some(hardness) => p_star * RMS_GRADIENT < hardness,
            // Between 0.3 and 1 loads are close to each other without a hardness.
            None => p_star <= 0.3 || p_star >= 1.0,
        }
    }
}

/// Table of all loads.
#[derive(Clone, Debug, Serialize)]
pub struct AnyLoad {
    /// Date of the run.
    pub date: String,
    /// Processor, cores, operating system.
    pub machine: String,
    /// Commit of this program.
    pub commit: String,
    /// Versions of all programs and packages.
    pub versions: BTreeMap<String, String>,
    /// Points along a side.
    pub points: usize,
    /// Bound on the certified residuals.
    pub tolerance: f64,
    /// Seed of the surfaces.
    pub seed: u64,
    /// Time limit of a peer, s.
    pub patience: f64,
    /// True if times are reported.
    pub timed: bool,
    /// One block per kind and Hurst exponent.
    pub blocks: Vec<Block>,
    /// Notes for readers of the results.
    pub notes: Vec<String>,
    /// File of this table.
    pub kept: PathBuf,
}

/// Loads on one surface.
#[derive(Clone, Debug, Serialize)]
pub struct Block {
    /// Kind of contact.
    pub kind: ContactVariant,
    /// Hurst exponent.
    pub hurst: f64,
    /// Contestants that solve such contacts.
    pub contestants: Vec<String>,
    /// One row per load.
    pub rows: Vec<Row>,
}

/// Results of an interrupted run.
#[derive(Default, Deserialize)]
struct Interrupted {
    blocks: Vec<Resumed>,
}

/// Block of an interrupted run.
#[derive(Deserialize)]
struct Resumed {
    kind: Value,
    hurst: f64,
    contestants: Vec<String>,
    rows: Vec<Row>,
}

impl Resumed {
    fn is_of(&self, kind: &ContactVariant, hurst: f64, contestants: &[String]) -> bool {
        self.kind["name"] == kind.name && self.hurst == hurst && self.contestants == contestants
    }
}

/// Results for one load.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Row {
    /// Reduced pressure.
    pub p_star: f64,
    /// Contact area fraction of the first contestant.
    pub contact: Option<f64>,
    /// Results of each contestant.
    pub cells: Vec<Cell>,
}

/// Result of a contestant.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Cell {
    /// Requested tolerance, in the measure of the program.
    pub tolerance: f64,
    /// Wall time, the median of the repeats.
    pub seconds: Option<f64>,
    /// Iterations of the solver.
    pub iterations: Option<u64>,
    /// Transform pairs that the program computed.
    pub transform_pairs: Option<f64>,
    /// Verdict on the pressure, if there is one.
    pub verdict: Option<Verdict>,
    /// True if the residual is within the bound.
    pub certified: bool,
    /// Message of the program about a failure.
    pub said: Option<String>,
}

/// Runs the comparison and writes the page if requested.
///
/// # Errors
/// An interruption; a file that cannot be written.
pub(super) fn run(
    args: &Args,
    folder: &Path,
    environment: &Environment,
    session: &Session,
) -> Result<AnyLoad, Failure> {
    let mut table = AnyLoad {
        date: jiff::Zoned::now().date().to_string(),
        machine: machine(),
        commit: gfmd_input::session::GIT_COMMIT.into(),
        versions: environment.versions(),
        points: args.sizes[0],
        tolerance: args.tolerance,
        seed: args.seed,
        patience: args.patience(),
        timed: !args.without_times,
        blocks: Vec::new(),
        notes: environment.notes.clone(),
        kept: folder.join("any-load.json"),
    };
    let all = [Contestant::Own(Solver::Auto)].into_iter().chain(args.peers.iter().copied().map(Contestant::Peer));
    let all: Vec<Contestant> = all.collect();
    let resumed = if args.resume { table.resumed()? } else { Interrupted::default() };
    for kind in KINDS {
        let contestants: Vec<Contestant> =
            all.iter().copied().filter(|contestant| contestant.suits(kind.boundary, kind.hardness)).collect();
        for &hurst in &args.hurst {
            let names: Vec<String> = contestants.iter().map(ToString::to_string).collect();
            let resumed = resumed.blocks.iter().find(|block| block.is_of(&kind, hurst, &names));
            table.blocks.push(Block { kind, hurst, contestants: names, rows: Vec::new() });
            let problems = problems(args, table.points, hurst, environment.scratch())?;
            for problem in problems.into_iter().filter(|problem| kind.has(problem.p_star)) {
                let problem = Problem {
                    boundary: kind.boundary,
                    hardness: kind.hardness,
                    most_iterations: Some(MOST_ITERATIONS),
                    ..problem
                };
                let finished = resumed.and_then(|block| block.rows.iter().find(|row| row.p_star == problem.p_star));
                if let Some(row) = finished {
                    table.push(row.clone());
                    continue;
                }
                table.push(Trial { args, environment, session, problem: &problem }.row(&contestants, kind.name)?);
                table.keep()?;
            }
        }
    }
    if let Some(file) = args.page() {
        write_beside(file, &table.page())?;
    }
    Ok(table)
}

/// One load, for all contestants.
struct Trial<'a> {
    args: &'a Args,
    environment: &'a Environment,
    session: &'a Session,
    problem: &'a Problem,
}

impl Trial<'_> {
    fn row(&self, contestants: &[Contestant], kind: &str) -> Result<Row, Failure> {
        let Problem { hurst, p_star, .. } = *self.problem;
        let mut cells: Vec<Cell> = Vec::new();
        for contestant in contestants {
            let name = format!("{contestant}, {kind}, H = {hurst}, p* = {p_star}");
            let cell = self.cell(contestant, &contestants[0]).map_err(|ended| ended.failure(&name))?;
            tracing::info!("{name}: {cell}");
            cells.push(cell);
        }
        let contact = cells[0].verdict.as_ref().map(|verdict| verdict.area_fraction);
        Ok(Row { p_star, contact, cells })
    }

    /// Returns the best result of a contestant in up to [`TRIALS`] solves. The first solve requests the bound itself.
    fn cell(&self, contestant: &Contestant, reference: &Contestant) -> Result<Cell, ProgramFailure> {
        let Self { args, problem, .. } = self;
        let mut best = Cell::default();
        let mut tolerance = args.tolerance;
        for _ in 0..TRIALS {
            let cell = self.solve(contestant, reference, tolerance)?;
            let residual = cell.residual();
            let gave_up = cell.said.is_some();
            if best.verdict.is_none() || residual < best.residual() {
                best = cell;
            }
            // A program that cannot reach a tolerance does not reach a smaller one.
            if best.certified || gave_up || residual.is_nan() || matches!(contestant, Contestant::Own(_)) {
                break;
            }
            tolerance *= (AIM * args.tolerance / residual).clamp(LEAST, AIM);
        }
        if best.certified && !args.without_times {
            let mut seconds: Vec<f64> = best.seconds.into_iter().collect();
            while seconds.len() < args.repeats {
                let threads = self.threads(contestant);
                let out = contestant.pressure_file(self.environment.scratch(), threads);
                seconds.push(contestant.solve(problem, best.tolerance, threads, Some(&out), self.place())?.seconds);
            }
            best.seconds = Some(median(&seconds));
        }
        Ok(best)
    }

    /// Performs one solve and judges it. Only an interruption is an error.
    fn solve(&self, contestant: &Contestant, reference: &Contestant, tolerance: f64) -> Result<Cell, ProgramFailure> {
        let Self { args, environment, session, problem } = *self;
        let threads = self.threads(contestant);
        let file = contestant.pressure_file(environment.scratch(), threads);
        // A pressure left from another load must not be judged.
        let _ = std::fs::remove_file(&file);
        let failed = |said: String| Ok(Cell { tolerance, said: Some(said), ..Cell::default() });
        let solve = match contestant.solve(problem, tolerance, threads, Some(&file), self.place()) {
            Err(ProgramFailure::Interrupted) => return Err(ProgramFailure::Interrupted),
            Err(ended) => return failed(ended.in_words()),
            Ok(solve) => solve,
        };
        let own = reference.pressure_file(environment.scratch(), threads);
        let fields = BTreeMap::from([(reference.to_string(), own), (contestant.to_string(), file)]);
        let verdict = match judge(problem, &fields, &reference.to_string(), environment, session) {
            Err(ProgramFailure::Interrupted) => return Err(ProgramFailure::Interrupted),
            Err(ended) => return failed(ended.in_words()),
            Ok(mut verdicts) => verdicts.remove(&contestant.to_string()),
        };
        let Solve { seconds, iterations, transform_pairs, failure, .. } = solve;
        let certified = verdict.as_ref().is_some_and(|verdict| verdict.worst() <= args.tolerance);
        let no_number = || verdict.is_none().then(|| "its pressure is no number, or zero".to_owned());
        let said = failure.or_else(no_number);
        Ok(Cell { tolerance, seconds: Some(seconds), iterations, transform_pairs, verdict, certified, said })
    }

    fn threads(&self, contestant: &Contestant) -> usize {
        if contestant.is_threaded(self.environment) { self.args.thread_counts[0] } else { 1 }
    }

    fn place(&self) -> Place<'_> {
        let limit = Duration::from_secs_f64(self.args.patience());
        Place { environment: self.environment, session: self.session, limit }
    }
}

impl Cell {
    /// Returns the certified residual; NaN without a pressure.
    fn residual(&self) -> f64 {
        self.verdict.as_ref().map_or(f64::NAN, Verdict::worst)
    }
}

impl AnyLoad {
    /// Returns the blocks of an interrupted run with the settings of this one.
    fn resumed(&self) -> Result<Interrupted, Failure> {
        kept::read(&self.kept, self, &["date", "blocks", "notes", "kept"])
    }

    /// Adds a row to the last block.
    fn push(&mut self, row: Row) {
        if let Some(block) = self.blocks.last_mut() {
            block.rows.push(row);
        }
    }

    /// Writes the table to its file, so that a later failure does not lose it.
    fn keep(&self) -> Result<(), Failure> {
        let text = gfmd_input::json::to_string(self).map_err(|error| Failure::computation(error.to_string()))?;
        write_beside(&self.kept, &(text + "\n"))
    }
}

impl fmt::Display for AnyLoad {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        for table in self.tables() {
            writeln!(f, "{table}")?;
        }
        for line in self.failures().iter().chain(&self.notes) {
            writeln!(f, "{line}")?;
        }
        writeln!(f, "kept: {}", self.kept.display())
    }
}
