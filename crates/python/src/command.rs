//! The commands of the program, in this process.

use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use clap::Parser;
use gfmd_cli::failure::{Failure, Outcome};
use gfmd_cli::program::{Command, keep_freed_memory, status};
use gfmd_cli::session::{Common, Session};
use gfmd_cli::{body, check, contact, damping, green, json, kappa_sweep, law, path, punch, report, surface, theory};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyInt};
use serde::Serialize;
use toml::{Table, Value};

use crate::failure::{failed, refused};
use crate::worker;

/// Time between two looks at an interruption.
const PAUSE: Duration = Duration::from_millis(20);

#[derive(Parser)]
#[command(name = "gfmd")]
struct Line {
    #[command(subcommand)]
    command: Command,
}

/// Runs the words of a command, and returns its report as JSON with the kind and the text of a failure.
#[pyfunction]
#[pyo3(signature = (words, threads=0, tick=None))]
pub(crate) fn run(py: Python<'_>, words: Vec<String>, threads: usize, tick: Option<Py<PyAny>>) -> PyResult<Ended> {
    let line = Line::try_parse_from(std::iter::once("gfmd".to_owned()).chain(words)).map_err(|error| {
        let text = error.render().to_string();
        let lines = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage"));
        let line = lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
        refused(py, &line.trim_start_matches("error: "))
    })?;
    carry_out(py, &line.command, threads, tick.as_ref())
}

/// Solves the problem in a dictionary with the keys of the flags of a command, and returns as [`run`]. The fields go to the file
/// `out`.
#[pyfunction]
#[pyo3(signature = (command, problem, out=None, threads=0, tick=None))]
pub(crate) fn solve(
    py: Python<'_>,
    command: &str,
    problem: &Bound<'_, PyDict>,
    out: Option<PathBuf>,
    threads: usize,
    tick: Option<Py<PyAny>>,
) -> PyResult<Ended> {
    let command = Command::of(command, table(problem)?, out).map_err(|failure| refused(py, &failure))?;
    carry_out(py, &command, threads, tick.as_ref())
}

/// The table of a dictionary; an entry that is `None` is left out.
pub(crate) fn table(values: &Bound<'_, PyDict>) -> PyResult<Table> {
    let given = values.iter().filter(|(_, value)| !value.is_none());
    given.map(|(key, value)| Ok((key.extract()?, entry(&value)?))).collect()
}

fn entry(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    if let Ok(flag) = value.cast::<PyBool>() {
        return Ok(flag.is_true().into());
    }
    if value.is_instance_of::<PyInt>() {
        return Ok(value.extract::<i64>()?.into());
    }
    if let Ok(text) = value.extract::<String>() {
        return Ok(text.into());
    }
    match value.extract::<f64>() {
        Ok(number) => Ok(number.into()),
        Err(_) => Ok(Value::Array(value.try_iter()?.map(|value| entry(&value?)).collect::<PyResult<_>>()?)),
    }
}

/// A report as JSON, with the kind and the text of a failure.
type Ended = (String, Option<(&'static str, String)>);

fn carry_out(py: Python<'_>, command: &Command, threads: usize, tick: Option<&Py<PyAny>>) -> PyResult<Ended> {
    let session = Session::silent(Common { json: true, threads, quiet: true, verbose: 0 }).without_resumption();
    let (result, raised) = worker::run(py, threads, tick, |shared| {
        let (finished, wait) = channel::<()>();
        std::thread::scope(|scope| {
            let session = &session;
            scope.spawn(move || {
                // The sender is dropped when the command ends, also by a panic.
                while wait.recv_timeout(PAUSE) == Err(RecvTimeoutError::Timeout) {
                    if shared.see(0, f64::NAN).is_break() {
                        session.interrupt();
                    }
                }
            });
            let result = report(command, session);
            drop(finished);
            result
        })
    })?;
    // An interruption keeps the result so far; any other exception of a signal's handler is the caller's own.
    let raised = match raised {
        Some(error) if !error.is_instance_of::<PyKeyboardInterrupt>(py) => return Err(error),
        other => other,
    };
    let (text, failure) = result.map_err(|failure| failed(py, &failure))?;
    let failure = failure.or_else(|| raised.map(|_| ("interrupted", "interrupted at the end".into())));
    Ok((text, failure))
}

type Report = Result<Ended, Failure>;

fn report(command: &Command, session: &Session) -> Report {
    match command {
        Command::Check(args) => ended(check::run(args, session)?, session),
        Command::Report(args) => whole(&report::run(args, session)?, session),
        Command::Contact(args) => ended(contact::run(args, session)?, session),
        Command::Punch(args) => ended(punch::run(args, session)?, session),
        Command::Path(args) => ended(path::run(args, session)?, session),
        Command::Body(args) => whole(&body::run(args, session)?, session),
        Command::Surface(args) => whole(&surface::run(args, session)?, session),
        Command::Damping(args) => whole(&damping::run(args, session)?, session),
        Command::Green(args) => whole(&green::run(args)?, session),
        Command::Law(args) => whole(&law::run(args)?, session),
        Command::Theory(args) => whole(&theory::run(args, session)?, session),
        Command::KappaSweep(args) => match kappa_sweep::run(args, session)? {
            kappa_sweep::Outcome::Done(report) => whole(&*report, session),
            kappa_sweep::Outcome::Shard(report) => whole(&report, session),
            kappa_sweep::Outcome::Planned(plan) => whole(&plan, session),
            kappa_sweep::Outcome::Config(text) => {
                Ok((json::to_string(&text).map_err(|error| Failure::Computation(error.to_string()))?, None))
            }
        },
    }
}

fn whole(report: &impl Serialize, session: &Session) -> Report {
    Ok((session.json(report)?, None))
}

fn ended(Outcome { report, failure }: Outcome<impl Serialize>, session: &Session) -> Report {
    let failure = failure.map(|failure| match failure {
        Failure::Interrupted(text) => ("interrupted", text),
        Failure::Input(text) | Failure::Computation(text) => ("not converged", text),
    });
    Ok((session.json(&report)?, failure))
}

/// The exit status of the program `gfmd` with these words, of which the first is its name.
#[pyfunction]
pub(crate) fn program(py: Python<'_>, words: Vec<std::ffi::OsString>) -> u8 {
    keep_freed_memory(); // the process is that of the program
    py.detach(|| status("gfmd", words, Command::run))
}
