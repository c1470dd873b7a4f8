//! How a command fails, and the exit status that goes with it.

use std::fmt::Display;
use std::process::ExitCode;

use gfmd_contact::{Fields, Refusal, SolveError};
use gfmd_files::FileError;
use gfmd_plot::PlotError;

/// Why a command did not do what it was asked. Each is one clear line.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The input cannot be used: the flag, field or file, what was found, what is allowed. Nothing was written.
    #[error("{0}")]
    Input(String),
    /// The computation failed. What was computed so far is kept and named.
    #[error("{0}")]
    Computation(String),
    /// Stopped by the user; the state is saved and named.
    #[error("{0}")]
    Interrupted(String),
}

impl Failure {
    /// An unusable value of a flag or field.
    pub fn input(name: &str, reason: impl Display) -> Self {
        Self::Input(format!("{name}: {reason}"))
    }

    /// The same with a remark at its end, such as where the work done so far is kept. Unusable input left none.
    #[must_use]
    pub fn with(self, remark: &str) -> Self {
        match self {
            Self::Input(text) => Self::Input(text),
            Self::Computation(text) => Self::Computation(text + remark),
            Self::Interrupted(text) => Self::Interrupted(text + remark),
        }
    }

    /// The same, with where it happened in front. Unusable input happens nowhere.
    #[must_use]
    pub fn at(self, place: &str) -> Self {
        match self {
            Self::Input(text) => Self::Input(text),
            Self::Computation(text) => Self::Computation(format!("{place}: {text}")),
            Self::Interrupted(text) => Self::Interrupted(format!("{place}: {text}")),
        }
    }

    /// The exit status (docs/interface.md).
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Computation(_) => 1,
            Self::Input(_) => 2,
            Self::Interrupted(_) => 130,
        })
    }
}

/// The report of a command that may end early, and the reason if it did.
pub struct Outcome<R> {
    /// All that was computed; the last part of it has not converged if there is a failure.
    pub report: R,
    /// A part that did not converge, or an interruption.
    pub failure: Option<Failure>,
}

/// The state that a solve has reached, with the failure if it did not come to rest.
///
/// # Errors
/// Unusable input: there is no state.
pub fn reached<S: Fields>(outcome: Result<S, SolveError<S>>) -> Result<(S, Option<Failure>), Failure> {
    match outcome {
        Ok(state) => Ok((state, None)),
        Err(SolveError::Refused(refusal)) => Err(refusal.into()),
        Err(SolveError::Interrupted { state }) => Ok((*state, Some(Failure::Interrupted("interrupted".into())))),
        Err(error) => {
            let failure = Failure::Computation(error.to_string());
            match error.into_state() {
                Some(state) => Ok((state, Some(failure))),
                None => Err(failure),
            }
        }
    }
}

impl From<Refusal> for Failure {
    /// Names the flag at fault.
    fn from(refusal: Refusal) -> Self {
        let flag = match &refusal {
            Refusal::Tolerance(_) => "--tol",
            Refusal::MeanPressure { .. } | Refusal::NotPressed { what: "mean pressure", .. } => "--pressure",
            Refusal::Approach { .. } | Refusal::NoApproach | Refusal::NotPressed { .. } => "--displacement",
            Refusal::NotFinite { what: "lateral displacement", .. } => "--lateral",
            Refusal::Solver { .. } | Refusal::NoEnergy | Refusal::NoDynamics => "--solver",
            Refusal::Law(_) => "--param",
            Refusal::Search(_) => return Self::Computation(refusal.to_string()),
            _ => "--surface",
        };
        Self::input(flag, refusal)
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::Computation(error.to_string())
    }
}

impl From<PlotError> for Failure {
    fn from(error: PlotError) -> Self {
        Self::Computation(error.to_string())
    }
}
