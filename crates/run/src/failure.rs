//! The failures of a command, and their exit status.

use std::fmt::Display;

use gfmd_contact::{Fields, Refusal, SolveError};
use gfmd_files::FileError;
use gfmd_files::legible::line;
use gfmd_plot::PlotError;
use gfmd_problem::{Clash, Unusable};
use gfmd_sweep::SweepError;

/// Reasons why a command fails. Each message is one line, without characters that steer a terminal, also if it quotes a
/// file.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Unusable input. The message states the flag, field or file, the value found and the values allowed. Nothing was
    /// written.
    #[error("{}", line(.0))]
    Input(String),
    /// A computation that failed. The message names the file that keeps the results so far.
    #[error("{}", line(.0))]
    Computation(String),
    /// An interruption by the user. The message names the file that keeps the state.
    #[error("{}", line(.0))]
    Interrupted(String),
}

impl Failure {
    /// The failure of a value that is out of its range, "--dt is 2; it must be above 0 and below 1".
    pub fn value(name: &str, found: impl Display, allowed: impl Display) -> Self {
        Unusable::value(name, found, allowed).into()
    }

    /// The failure of a flag, field or file for a reason that a library states.
    pub fn input(name: &str, reason: impl Display) -> Self {
        Unusable::input(name, reason).into()
    }

    /// The failure of a problem that cannot be posed on the surface with this name.
    pub(crate) fn posing(refusal: Refusal, surface: &str) -> Self {
        let name = match refusal {
            Refusal::Body(_) => "--boundary free",
            Refusal::Hardness { .. } | Refusal::HardnessShape { .. } => "--hardness",
            _ => surface,
        };
        Self::input(name, refusal)
    }

    /// Appends a remark, such as the file that keeps the results so far. Unusable input has no results and gets no
    /// remark.
    #[must_use]
    pub fn with(self, remark: &str) -> Self {
        match self {
            Self::Input(text) => Self::Input(text),
            Self::Computation(text) => Self::Computation(text + remark),
            Self::Interrupted(text) => Self::Interrupted(text + remark),
        }
    }

    /// Puts the place of the failure in front. The message of unusable input names its place already.
    #[must_use]
    pub fn at(self, place: &str) -> Self {
        match self {
            Self::Input(text) => Self::Input(text),
            Self::Computation(text) => Self::Computation(format!("{place}: {text}")),
            Self::Interrupted(text) => Self::Interrupted(format!("{place}: {text}")),
        }
    }

    /// The exit status (docs/interface.md).
    pub fn status(&self) -> u8 {
        match self {
            Self::Computation(_) => 1,
            Self::Input(_) => 2,
            Self::Interrupted(_) => 130,
        }
    }
}

/// The report of a command that may end early, and the reason if it did.
pub struct Outcome<R> {
    /// The results so far. If there is a failure, their last part has not converged.
    pub report: R,
    /// A part that did not converge, or an interruption.
    pub failure: Option<Failure>,
}

/// Returns the state that a solve has reached, and the failure if it did not converge.
///
/// # Errors
/// Unusable input, for which there is no state.
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
    /// Puts the flag to which the refusal applies in front.
    fn from(refusal: Refusal) -> Self {
        let flag = match &refusal {
            Refusal::Tolerance(_) => "--tol",
            Refusal::MeanPressure { .. }
            | Refusal::NotPressed { what: "mean pressure", .. }
            | Refusal::NotFinite { what: "mean pressure", .. }
            | Refusal::LoadBelowTractionRounding { .. }
            | Refusal::LoadBelowRoughnessRounding { what: "mean pressure", .. }
            | Refusal::LoadUnderflows { what: "mean pressure", .. }
            | Refusal::Unresolved { what: "mean pressure", .. }
            | Refusal::Rounding { what: "mean pressure", .. } => "--pressure",
            Refusal::UnitOutOfRange { .. } | Refusal::Unit { .. } => "--young",
            Refusal::NotFinite { what: "lateral displacement", .. }
            | Refusal::Rounding { what: "shear traction", .. } => "--lateral",
            Refusal::Approach { .. }
            | Refusal::NoApproach
            | Refusal::NotPressed { .. }
            | Refusal::NotFinite { what: "approach", .. }
            | Refusal::LoadBelowRoughnessRounding { .. }
            | Refusal::LoadUnderflows { .. }
            | Refusal::Unresolved { .. }
            | Refusal::Rounding { .. } => "--displacement",
            Refusal::Solver { .. } | Refusal::NoEnergy | Refusal::NoDynamics => "--solver",
            Refusal::Law(_) => "--param",
            Refusal::Search(_) | Refusal::Overflow => return Self::Computation(refusal.to_string()),
            _ => "--surface",
        };
        Self::input(flag, refusal)
    }
}

impl From<Clash> for Failure {
    fn from(clash: Clash) -> Self {
        Self::Input(clash.to_string())
    }
}

impl From<Unusable> for Failure {
    fn from(unusable: Unusable) -> Self {
        Self::Input(unusable.to_string())
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        match error {
            FileError::Memory { .. } => Self::Input(error.to_string()),
            _ => Self::Computation(error.to_string()),
        }
    }
}

impl From<PlotError> for Failure {
    fn from(error: PlotError) -> Self {
        Self::Computation(error.to_string())
    }
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        let text = error.to_string();
        match error {
            SweepError::Contact { source, .. } if matches!(*source, SolveError::Refused(_)) => Self::Input(text),
            SweepError::Contact { .. } | SweepError::Keep(_) => Self::Computation(text),
            SweepError::Interrupted(_) => Self::Interrupted(text),
            _ => Self::Input(text),
        }
    }
}
