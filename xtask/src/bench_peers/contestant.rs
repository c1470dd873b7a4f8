//! Contestants, and one solve by each.

use std::fmt;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use gfmd_contact::{Boundary, Solver};
use gfmd_input::session::Session;
use serde_json::json;

use super::process::{ProgramFailure, output};
use super::python::{Environment, LONG, Script};
use super::solve::Solve;
use super::{Peer, TamaasFftw};

/// Program with one of its solvers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Contestant {
    /// This program with one of its solvers.
    Own(Solver),
    /// Another program.
    Peer(Peer),
}

impl fmt::Display for Contestant {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Own(Solver::Auto) => f.write_str("gfmd"),
            Self::Own(solver) => write!(f, "gfmd {solver}"),
            Self::Peer(Peer::Tamaas) => f.write_str("Tamaas"),
            Self::Peer(Peer::ContactMechanics) => f.write_str("ContactMechanics"),
            Self::Peer(Peer::NoRestart) => f.write_str("CM no-restart"),
            Self::Peer(Peer::NoRestartLoad) => f.write_str("CM no-restart, load"),
            Self::Peer(Peer::TamaasRegistered) => f.write_str("Tamaas, registered"),
            Self::Peer(Peer::Aspher) => f.write_str("ASPHER"),
            Self::Peer(Peer::AspherActive) => f.write_str("ASPHER active"),
            Self::Peer(Peer::Hertzian) => f.write_str("hertzian"),
        }
    }
}

/// One load on one surface; E* = 1, cell length 1.
#[derive(Clone, Debug)]
pub(super) struct Problem {
    pub(super) points: usize,
    pub(super) hurst: f64,
    pub(super) p_star: f64,
    pub(super) mean_pressure: f64,
    pub(super) heights: PathBuf,
    pub(super) boundary: Boundary,
    pub(super) hardness: Option<f64>,
    /// Largest number of iterations of a peer; `None` leaves it to the peer.
    pub(super) most_iterations: Option<u64>,
    /// File with the pressure of the first contestant.
    pub(super) answer: PathBuf,
}

/// Settings of a solve.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) environment: &'a Environment,
    pub(super) session: &'a Session,
    /// Time after which a peer is stopped.
    pub(super) limit: Duration,
}

impl Contestant {
    /// Returns true if the contestant can use more than one thread.
    pub(super) fn is_threaded(&self, environment: &Environment) -> bool {
        match self {
            Self::Own(_) | Self::Peer(Peer::Aspher | Peer::AspherActive) => true,
            Self::Peer(Peer::Tamaas | Peer::TamaasRegistered) => environment.tamaas_has_threads(),
            Self::Peer(_) => false,
        }
    }

    /// Returns true if the contestant solves contacts of this kind.
    pub(super) fn suits(&self, boundary: Boundary, hardness: Option<f64>) -> bool {
        match self {
            Self::Own(solver) => hardness.is_none() || matches!(solver, Solver::Auto | Solver::PreconditionedCg),
            Self::Peer(Peer::Tamaas | Peer::ContactMechanics) => true,
            Self::Peer(Peer::NoRestart) => boundary == Boundary::Periodic && hardness.is_none(),
            Self::Peer(Peer::NoRestartLoad | Peer::Aspher) => hardness.is_none(),
            Self::Peer(Peer::Hertzian | Peer::TamaasRegistered | Peer::AspherActive) => {
                boundary == Boundary::Free && hardness.is_none()
            }
        }
    }

    /// Returns the file of the final pressure. This program has one file, since its pressure does not depend on the
    /// number of threads.
    pub(super) fn pressure_file(&self, folder: &Path, threads: usize) -> PathBuf {
        let name = self.to_string().replace([' ', ','], "-");
        let threads = if let Self::Own(_) = self { String::new() } else { format!("-{threads}") };
        folder.join(format!("{name}{threads}.npy"))
    }

    /// Solves to `tolerance`, which has a meaning specific to the contestant, and writes the final pressure to `out`,
    /// in .npy. This program writes no file if `out` is `None`; peers need one.
    pub(super) fn solve(
        &self,
        problem: &Problem,
        tolerance: f64,
        threads: usize,
        out: Option<&Path>,
        place: Place,
    ) -> Result<Solve, ProgramFailure> {
        let task = |more: serde_json::Value| {
            let mut task = json!({
                "heights": problem.heights,
                "mean_pressure": problem.mean_pressure,
                "tolerance": tolerance,
                "threads": threads,
                "boundary": problem.boundary.name(),
                "hardness": problem.hardness,
                "answer": problem.answer,
                "out": out.map_or_else(|| place.environment.scratch().join("unused.npy"), Path::to_path_buf),
            });
            if let (Some(task), serde_json::Value::Object(more)) = (task.as_object_mut(), more) {
                task.extend(more);
                task.extend(problem.most_iterations.map(|most| ("most".to_owned(), json!(most))));
            }
            task
        };
        let environment = place.environment;
        match self {
            Self::Own(solver) => own(*solver, problem, tolerance, threads, out, place.session),
            Self::Peer(peer @ (Peer::Tamaas | Peer::TamaasRegistered)) => {
                let measured = environment.tamaas_fftw == TamaasFftw::Tuned;
                let fftw = environment.preloaded();
                let plans = if measured { "measured" } else { "estimated" };
                let solver = if *peer == Peer::Tamaas { "dcfft" } else { "default" };
                let task = task(json!({ "fftw": fftw, "plans": plans, "solver": solver }));
                environment.run_within(Script::Tamaas, &task, place.limit, place.session)
            }
            Self::Peer(peer) => {
                let (script, solver) = match peer {
                    Peer::NoRestart => (Script::ContactMechanics, "no-restart"),
                    Peer::NoRestartLoad => (Script::ContactMechanics, "no-restart-load"),
                    Peer::Aspher => (Script::Aspher, "default"),
                    Peer::AspherActive => (Script::Aspher, "active"),
                    Peer::Hertzian => (Script::Hertzian, "default"),
                    _ => (Script::ContactMechanics, "default"),
                };
                environment.run_within(script, &task(json!({ "solver": solver })), place.limit, place.session)
            }
        }
    }
}

/// Solves with this program in a new process, so that its memory can be measured and caches are as cold as for peers.
pub(super) fn own(
    solver: Solver,
    problem: &Problem,
    tolerance: f64,
    threads: usize,
    out: Option<&Path>,
    session: &Session,
) -> Result<Solve, ProgramFailure> {
    let program = std::env::current_exe().map_err(|error| ProgramFailure::Failed(error.to_string()))?;
    let mut command = Command::new(program);
    command.args([
        "bench-solve",
        "--json",
        "--quiet",
        "--solver",
        solver.name(),
        "--boundary",
        problem.boundary.name(),
    ]);
    command.arg("--surface").arg(&problem.heights);
    command.arg("--pressure").arg(format!("{:?}", problem.mean_pressure));
    command.arg("--tolerance").arg(format!("{tolerance:e}"));
    command.arg("--threads").arg(threads.to_string());
    if let Some(hardness) = problem.hardness {
        command.arg("--hardness").arg(format!("{hardness:?}"));
    }
    if let Some(out) = out {
        command.arg("--out").arg(out);
    }
    let printed = output(&mut command, LONG, session)?;
    serde_json::from_str(&printed).map_err(|error| ProgramFailure::Failed(format!("its output has {error}")))
}
