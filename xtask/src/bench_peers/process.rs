//! Runs of other programs, with a time limit and interruption by the user.

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use gfmd_input::failure::Failure;
use gfmd_input::session::Session;

/// Reason why a program gave no result.
#[derive(Debug)]
pub(super) enum ProgramFailure {
    /// The program was stopped after this time.
    TooLong(Duration),
    /// The user interrupted the run.
    Interrupted,
    /// The program could not be started, or failed; with its last line of output.
    Failed(String),
}

impl ProgramFailure {
    /// Returns the failure of a program that the command cannot do without.
    pub(super) fn failure(self, what: &str) -> Failure {
        match self {
            Self::Interrupted => Failure::interrupted(format!("interrupted: {what}")),
            other => Failure::computation(format!("{what}: {}", other.in_words())),
        }
    }

    pub(super) fn in_words(self) -> String {
        match self {
            Self::TooLong(limit) => format!("it takes longer than {} s", limit.as_secs_f64()),
            Self::Interrupted => "interrupted".into(),
            Self::Failed(said) => said,
        }
    }
}

/// Time between two checks of a running program. It does not limit the resolution of the measured times.
const PAUSE: Duration = Duration::from_millis(5);

/// Runs `command` and returns its stdout.
pub(super) fn output(command: &mut Command, limit: Duration, session: &Session) -> Result<String, ProgramFailure> {
    let failed = |error: std::io::Error| ProgramFailure::Failed(error.to_string());
    // Files instead of pipes, since a full pipe would block the program.
    let [mut stdout, mut stderr] = [tempfile::tempfile().map_err(failed)?, tempfile::tempfile().map_err(failed)?];
    let handles = [stdout.try_clone().map_err(failed)?, stderr.try_clone().map_err(failed)?];
    let [to_stdout, to_stderr] = handles.map(Stdio::from);
    let program = command.get_program().to_string_lossy().into_owned();
    let started = command.stdin(Stdio::null()).stdout(to_stdout).stderr(to_stderr).spawn();
    let mut child = started.map_err(|error| ProgramFailure::Failed(format!("cannot start {program}: {error}")))?;
    let deadline = Instant::now() + limit;
    let status = loop {
        match child.try_wait().map_err(failed)? {
            Some(status) => break status,
            None if session.is_interrupted() => return Err(stopped(&mut child, ProgramFailure::Interrupted)),
            None if Instant::now() >= deadline => return Err(stopped(&mut child, ProgramFailure::TooLong(limit))),
            None => std::thread::sleep(PAUSE),
        }
    };
    if session.is_interrupted() {
        return Err(ProgramFailure::Interrupted);
    }
    if !status.success() {
        let said = text(&mut stderr).map_err(failed)?;
        let last = said.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("it printed no message");
        return Err(ProgramFailure::Failed(format!("{status}: {}", last.trim())));
    }
    text(&mut stdout).map_err(failed)
}

fn stopped(child: &mut Child, why: ProgramFailure) -> ProgramFailure {
    match child.kill().and_then(|()| child.wait()) {
        Ok(_) => why,
        Err(error) => ProgramFailure::Failed(format!("it cannot be stopped: {error}")),
    }
}

fn text(file: &mut File) -> std::io::Result<String> {
    file.seek(SeekFrom::Start(0))?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
