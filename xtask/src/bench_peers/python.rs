//! Python environment of the peers, created once with pinned versions, and the scripts that run in it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::json;
use tempfile::TempDir;

use super::process::{ProgramFailure, output};
use super::{Args, Peer, TamaasFftw};

const REQUIREMENTS: &str = include_str!("../../peers/requirements.txt");

/// Package to install if the system has no FFTW.
const PYFFTW: &str = "pyFFTW==0.15.1";

/// Time limit of installation, planning, judging and solves of this program.
pub(super) const LONG: Duration = Duration::from_secs(3600);

/// Script of the environment.
#[derive(Clone, Copy, Debug)]
pub(super) enum Script {
    Adhesion,
    Aspher,
    Certify,
    ContactMechanics,
    Creep,
    Describe,
    Hertzian,
    Tamaas,
    Yardstick,
    Yielding,
}

impl Script {
    const ALL: [Self; 10] = [
        Self::Adhesion,
        Self::Aspher,
        Self::Certify,
        Self::ContactMechanics,
        Self::Creep,
        Self::Describe,
        Self::Hertzian,
        Self::Tamaas,
        Self::Yardstick,
        Self::Yielding,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Adhesion => "adhesion_tamaas.py",
            Self::Aspher => "solve_aspher.py",
            Self::Hertzian => "solve_hertzian.py",
            Self::Certify => "certify.py",
            Self::ContactMechanics => "solve_contact_mechanics.py",
            Self::Creep => "creep_tamaas.py",
            Self::Describe => "describe.py",
            Self::Tamaas => "solve_tamaas.py",
            Self::Yardstick => "yardstick.py",
            Self::Yielding => "yielding_tamaas.py",
        }
    }

    fn text(self) -> &'static str {
        match self {
            Self::Adhesion => include_str!("../../peers/adhesion_tamaas.py"),
            Self::Aspher => include_str!("../../peers/solve_aspher.py"),
            Self::Hertzian => include_str!("../../peers/solve_hertzian.py"),
            Self::Certify => include_str!("../../peers/certify.py"),
            Self::ContactMechanics => include_str!("../../peers/solve_contact_mechanics.py"),
            Self::Creep => include_str!("../../peers/creep_tamaas.py"),
            Self::Describe => include_str!("../../peers/describe.py"),
            Self::Tamaas => include_str!("../../peers/solve_tamaas.py"),
            Self::Yardstick => include_str!("../../peers/yardstick.py"),
            Self::Yielding => include_str!("../../peers/yielding_tamaas.py"),
        }
    }
}

/// Module shared by the scripts.
const MODULE: (&str, &str) = ("peak_memory.py", include_str!("../../peers/peak_memory.py"));

/// FFTW with vector code: names or paths of its libraries.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Fftw {
    pub(super) library: String,
    pub(super) threads: Option<String>,
    pub(super) needs: Vec<String>,
    pub(super) source: String,
}

#[derive(Deserialize)]
struct Description {
    python: String,
    fftw: Option<Fftw>,
    /// Versions of the installed packages of peers.
    versions: BTreeMap<String, String>,
}

/// Measurement of the yardstick at one size and number of threads.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Yardstick {
    pub(super) threads: usize,
    /// Mean time of one pair in each batch.
    pub(super) seconds: Vec<f64>,
    /// Processor time divided by the product of wall time and number of threads.
    pub(super) share: f64,
}

#[derive(Deserialize)]
struct Yardsticks {
    version: String,
    pairs: Vec<Yardstick>,
}

/// Python with the peers installed.
pub(super) struct Environment {
    python: PathBuf,
    python_version: String,
    packages: BTreeMap<String, String>,
    fftw: Fftw,
    fftw_version: String,
    pub(super) tamaas_fftw: TamaasFftw,
    /// Notes for readers of the results.
    pub(super) notes: Vec<String>,
    scratch: TempDir,
}

impl Environment {
    /// Creates the environment if it is missing, and finds an FFTW.
    pub(super) fn prepare(args: &Args, folder: &Path, session: &Session) -> Result<Self, Failure> {
        let venv = args.venv.clone().unwrap_or_else(|| folder.join("venv"));
        let (python, mut notes) = install(&args.python, &venv, session)?;
        let scratch = tempfile::tempdir_in(folder).map_err(|error| cannot_write(folder, &error))?;
        let scripts = Script::ALL.map(|script| (script.name(), script.text()));
        for (name, text) in scripts.into_iter().chain([MODULE]) {
            let file = scratch.path().join(name);
            fs::write(&file, text).map_err(|error| cannot_write(&file, &error))?;
        }
        let describe = || -> Result<Description, Failure> {
            let description = run(&python, scratch.path(), Script::Describe, None, &[], LONG, session);
            description.map_err(|ended| ended.failure("the Python environment"))
        };
        let mut description = describe()?;
        if description.fftw.is_none() {
            tracing::info!("no FFTW on this system (Debian: libfftw3-double3); installing that of pyFFTW");
            pip(&python, &[PYFFTW], session)?;
            description = describe()?;
        }
        let Some(fftw) = description.fftw else {
            let reason =
                "neither the system nor pyFFTW provides it, and the yardstick needs it (Debian: libfftw3-double3)";
            return Err(Failure::input("FFTW", reason));
        };
        if fftw.source != "system" {
            notes.push("The system has no FFTW: the yardstick and Tamaas used the FFTW of pyFFTW.".to_owned());
        }
        let mut tamaas_fftw = args.tamaas_fftw;
        if !cfg!(target_os = "linux") && tamaas_fftw != TamaasFftw::Own {
            notes.push("Libraries are preloaded on Linux only: Tamaas ran with the FFTW of its package.".into());
            tamaas_fftw = TamaasFftw::Own;
        }
        let python_version = description.python;
        let fftw_version = String::new();
        let packages = description.versions;
        let mut environment =
            Self { python, python_version, packages, fftw, fftw_version, tamaas_fftw, notes, scratch };
        environment.fftw_version = environment.yardsticks(&[], &[], 0.0, session)?.version;
        Ok(environment)
    }

    /// Returns a temporary folder for surfaces and pressures, deleted when this value is dropped.
    pub(super) fn scratch(&self) -> &Path {
        self.scratch.path()
    }

    /// Returns the versions of the packages, of Python and of this program.
    pub(super) fn versions(&self) -> BTreeMap<String, String> {
        let mut versions = self.packages.clone();
        versions.insert("Python".into(), self.python_version.clone());
        versions.insert("gfmd".into(), env!("CARGO_PKG_VERSION").into());
        versions
    }

    /// Returns true if the package of a peer is installed.
    pub(super) fn has(&self, peer: Peer) -> bool {
        self.packages.contains_key(peer.package())
    }

    /// Describes the FFTW of the yardstick.
    pub(super) fn fftw_in_words(&self) -> String {
        let threads = if self.fftw.threads.is_some() { "" } else { ", without threads" };
        format!("{} ({}{threads})", self.fftw_version, self.fftw.source)
    }

    /// Returns the FFTW that replaces the one in the package of Tamaas.
    pub(super) fn preloaded(&self) -> Option<&Fftw> {
        (self.tamaas_fftw != TamaasFftw::Own).then_some(&self.fftw)
    }

    pub(super) fn tamaas_has_threads(&self) -> bool {
        self.preloaded().is_some_and(|fftw| fftw.threads.is_some())
    }

    /// Times the yardstick for about `seconds` per size and number of threads; several threads need an FFTW with
    /// threads.
    pub(super) fn yardstick(
        &self,
        points: usize,
        threads: &[usize],
        session: &Session,
    ) -> Result<Vec<Yardstick>, Failure> {
        if self.fftw.threads.is_none() && threads.iter().any(|t| *t > 1) {
            return Err(Failure::refused("--thread-counts must be 1, since this FFTW has no threads"));
        }
        Ok(self.yardsticks(&[points], threads, 0.5, session)?.pairs)
    }

    fn yardsticks(
        &self,
        sizes: &[usize],
        threads: &[usize],
        seconds: f64,
        session: &Session,
    ) -> Result<Yardsticks, Failure> {
        let wisdom = self.scratch().join("wisdom");
        let task =
            json!({ "sizes": sizes, "threads": threads, "fftw": self.fftw, "wisdom": wisdom, "seconds": seconds });
        self.run(Script::Yardstick, &task, session).map_err(|ended| ended.failure("the yardstick"))
    }

    /// Runs a script with the time limit [`LONG`].
    pub(super) fn run<T: DeserializeOwned>(
        &self,
        script: Script,
        task: &serde_json::Value,
        session: &Session,
    ) -> Result<T, ProgramFailure> {
        self.run_within(script, task, LONG, session)
    }

    /// Runs a script and parses its output as JSON.
    pub(super) fn run_within<T: DeserializeOwned>(
        &self,
        script: Script,
        task: &serde_json::Value,
        limit: Duration,
        session: &Session,
    ) -> Result<T, ProgramFailure> {
        let threads = task["threads"].as_u64().unwrap_or(1).to_string();
        let mut settings = vec![("OMP_NUM_THREADS", threads.clone()), ("OPENBLAS_NUM_THREADS", threads)];
        if let (Script::Adhesion | Script::Tamaas | Script::Creep, Some(fftw)) = (script, self.preloaded()) {
            let Fftw { needs, library, threads, .. } = fftw;
            let libraries = needs.iter().chain([library]).chain(threads);
            settings.push(("LD_PRELOAD", libraries.map(String::as_str).collect::<Vec<_>>().join(" ")));
        }
        run(&self.python, self.scratch(), script, Some(task), &settings, limit, session)
    }
}

fn run<T: DeserializeOwned>(
    python: &Path,
    scratch: &Path,
    script: Script,
    task: Option<&serde_json::Value>,
    settings: &[(&str, String)],
    limit: Duration,
    session: &Session,
) -> Result<T, ProgramFailure> {
    let mut command = Command::new(python);
    // Isolates the script from the packages and settings of the user.
    command.args(["-E", "-s"]).arg(scratch.join(script.name())).args(task.map(ToString::to_string));
    command.current_dir(scratch).envs(settings.iter().map(|(name, value)| (name, value)));
    let printed = output(&mut command, limit, session)?;
    serde_json::from_str(&printed)
        .map_err(|error| ProgramFailure::Failed(format!("the output of {} is no valid JSON: {error}", script.name())))
}

/// Returns the Python of the environment in `venv`, with all packages that could be installed, and remarks on others.
fn install(program: &Path, venv: &Path, session: &Session) -> Result<(PathBuf, Vec<String>), Failure> {
    let python = venv.join(if cfg!(windows) { "Scripts/python.exe" } else { "bin/python" });
    // This file is written last: without it, or with other contents, the environment is incomplete.
    let complete = venv.join("gfmd-requirements.txt");
    if fs::read_to_string(&complete).is_ok_and(|text| text == REQUIREMENTS) {
        return Ok((python, Vec::new()));
    }
    tracing::info!("installing the peers in {}", venv.display());
    let made = output(Command::new(program).arg("-m").arg("venv").arg(venv), LONG, session);
    made.map_err(|ended| match ended {
        ProgramFailure::Interrupted => ended.failure("the Python environment"),
        other => Failure::input("--python, --venv", other.in_words()),
    })?;
    let packages: Vec<&str> = REQUIREMENTS.lines().collect();
    let mut notes = Vec::new();
    if let Err(Failure::Computation(_)) = pip(&python, &packages, session) {
        // A package that cannot be built here does not block the others.
        for package in packages {
            match pip(&python, &[package], session) {
                Err(failure @ Failure::Computation(_)) => notes.push(format!("{package} is not installed: {failure}")),
                done => done?,
            }
        }
    }
    fs::write(&complete, REQUIREMENTS).map_err(|error| cannot_write(&complete, &error))?;
    Ok((python, notes))
}

fn pip(python: &Path, packages: &[&str], session: &Session) -> Result<(), Failure> {
    let mut command = Command::new(python);
    command.args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]).args(packages);
    let done = output(&mut command, LONG, session);
    done.map(|_| ()).map_err(|ended| ended.failure("pip cannot install it (Python 3.11 or later is needed)"))
}

fn cannot_write(file: &Path, error: &std::io::Error) -> Failure {
    Failure::computation(format!("cannot write {}: {error}", file.display()))
}
