//! The failures of a command, and their exit status.

use std::fmt::{self, Display};

use gfmd_contact::{Fields, Refusal, SolveError};
use gfmd_files::legible::line;
use gfmd_files::{FileError, JournalError};
use gfmd_plot::PlotError;
use gfmd_problem::{Clash, Spelling, Unusable, Words, Written, key, setting, words};
use gfmd_sweep::SweepError;
use gfmd_unit::Units;

/// Reason why a command fails. Its message is one line, without characters that steer a terminal, also if it quotes a
/// file. The message names options as flags; [`spelled`](Self::spelled) gives other spellings.
#[derive(Debug)]
pub enum Failure {
    /// Unusable input: the option, field or file, the value found and the values allowed. Nothing was written.
    Input(Unusable),
    /// A solve that did not reach its tolerance. The message names the file that keeps the results so far.
    NotConverged(Words),
    /// Another computation that failed. The message names the file that keeps the results so far.
    Computation(Words),
    /// An interruption by the user. The message names the file that keeps the state.
    Interrupted(Words),
}

impl Failure {
    /// Returns the failure of a value that is out of its range, "--dt is 2; it must be above 0 and below 1".
    pub fn value(name: impl Into<Words>, found: impl Display, allowed: impl Into<Words>) -> Self {
        Unusable::value(name, found, allowed).into()
    }

    /// Returns the failure of an option that is left out, "--time is missing; it is needed with --prony".
    pub fn missing(option: &'static str, why: impl Into<Words>) -> Self {
        Unusable::missing(option, why).into()
    }

    /// Returns the failure of an option, field or file for a reason that a library states.
    pub fn input(name: impl Into<Words>, reason: impl Display) -> Self {
        Unusable::input(name, reason).into()
    }

    /// Returns the failure of an option, field or file for a reason in words that may name other options.
    pub fn because(name: impl Into<Words>, why: impl Into<Words>) -> Self {
        Unusable::of(why).at(name).into()
    }

    /// Returns the failure of a value that contradicts other input, "--n is 64; with --eps-t-inv 2 ...".
    pub fn contradicts(name: impl Into<Words>, found: impl Display, why: impl Into<Words>) -> Self {
        Unusable::contradicts(name, found, why).into()
    }

    /// Returns the failure of input in words that name it.
    pub fn refused(words: impl Into<Words>) -> Self {
        Unusable::of(words).into()
    }

    /// Returns the failure of a computation.
    pub fn computation(words: impl Into<Words>) -> Self {
        Self::Computation(words.into())
    }

    /// Returns the failure of a command that the user interrupted.
    pub fn interrupted(words: impl Into<Words>) -> Self {
        Self::Interrupted(words.into())
    }

    /// Returns the failure of a problem that cannot be posed on the surface with this name.
    pub fn posing(refusal: Refusal, surface: impl Into<Words>) -> Self {
        let name = match refusal {
            Refusal::Body(_) => setting("boundary", "free"),
            Refusal::Hardness { .. } | Refusal::HardnessShape { .. } => key("hardness"),
            _ => surface.into(),
        };
        Self::input(name, refusal)
    }

    /// Appends a remark, such as the file that keeps the results so far. Unusable input has no results and gets no
    /// remark.
    #[must_use]
    pub fn with(self, remark: impl Into<Words>) -> Self {
        match self {
            Self::Input(unusable) => Self::Input(unusable),
            Self::NotConverged(words) => Self::NotConverged(words.and(remark)),
            Self::Computation(words) => Self::Computation(words.and(remark)),
            Self::Interrupted(words) => Self::Interrupted(words.and(remark)),
        }
    }

    /// Shows the quantities of unusable input as they were written.
    #[must_use]
    pub fn as_written(self, written: &Written) -> Self {
        match self {
            Self::Input(unusable) => Self::Input(unusable.as_written(written)),
            other => other,
        }
    }

    /// Puts the place of the failure in front. The message of unusable input names its place already.
    #[must_use]
    pub fn at(self, place: impl Into<Words>) -> Self {
        let place = |words: Words| words![place, ": ", words];
        match self {
            Self::Input(unusable) => Self::Input(unusable),
            Self::NotConverged(words) => Self::NotConverged(place(words)),
            Self::Computation(words) => Self::Computation(place(words)),
            Self::Interrupted(words) => Self::Interrupted(place(words)),
        }
    }

    /// Returns the whole message.
    pub fn words(&self) -> Words {
        match self {
            Self::Input(unusable) => unusable.words(),
            Self::NotConverged(words) | Self::Computation(words) | Self::Interrupted(words) => words.clone(),
        }
    }

    /// Returns the message with its options spelled as flags or as arguments.
    pub fn spelled(&self, spelling: Spelling) -> String {
        line(&match self {
            Self::Input(unusable) => unusable.spelled(spelling),
            _ => self.words().spelled(spelling),
        })
    }

    /// Returns the exit status (docs/interface.md).
    pub fn status(&self) -> u8 {
        match self {
            Self::NotConverged(_) | Self::Computation(_) => 1,
            Self::Input(_) => 2,
            Self::Interrupted(_) => 130,
        }
    }
}

impl Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.spelled(Spelling::Flag))
    }
}

impl std::error::Error for Failure {}

/// The report of a command that may end early, and the reason if it did.
pub struct Outcome<R> {
    /// The results so far. If there is a failure, their last part has not converged.
    pub report: R,
    /// A part that did not converge, or an interruption.
    pub failure: Option<Failure>,
}

/// Returns what was made of finished results; if that failed, nothing, and keeps the reason in `failure`, so that the
/// results are printed.
pub fn or_none<T: Default>(made: Result<T, Failure>, failure: &mut Option<Failure>) -> T {
    made.unwrap_or_else(|reason| {
        failure.get_or_insert(reason);
        T::default()
    })
}

/// Returns the state that a solve has reached, and the failure, in these `units`, if it did not converge.
///
/// # Errors
/// Unusable input, for which there is no state.
pub fn reached<S: Fields>(outcome: Result<S, SolveError<S>>, units: &Units) -> Result<(S, Option<Failure>), Failure> {
    match outcome {
        Ok(state) => Ok((state, None)),
        Err(SolveError::Refused(refusal)) => Err(refusal.into()),
        Err(SolveError::Interrupted { state }) => Ok((*state, Some(Failure::interrupted("interrupted")))),
        Err(error) => {
            let failure = Failure::NotConverged(error.words(|stress| units.words(stress, "stress")).into());
            match error.into_state() {
                Some(state) => Ok((state, Some(failure))),
                None => Err(failure),
            }
        }
    }
}

impl From<Refusal> for Failure {
    /// Puts the option to which the refusal applies in front.
    fn from(refusal: Refusal) -> Self {
        let option = match &refusal {
            Refusal::Tolerance(_) => "tolerance",
            Refusal::MeanPressure { .. }
            | Refusal::NotFinite { what: "mean pressure", .. }
            | Refusal::LoadBelowTractionRounding { .. }
            | Refusal::LoadBelowRoughnessRounding { what: "mean pressure", .. }
            | Refusal::LoadUnderflows { what: "mean pressure", .. }
            | Refusal::Unresolved { what: "mean pressure", .. }
            | Refusal::Rounding { what: "mean pressure", .. } => "pressure",
            Refusal::UnitOutOfRange { .. } | Refusal::Unit { .. } => "young",
            Refusal::NotFinite { what: "lateral displacement", .. }
            | Refusal::Rounding { what: "shear traction", .. } => "lateral",
            Refusal::Approach { .. }
            | Refusal::NoApproach
            | Refusal::NotFinite { what: "approach", .. }
            | Refusal::LoadBelowRoughnessRounding { .. }
            | Refusal::LoadUnderflows { .. }
            | Refusal::Unresolved { .. }
            | Refusal::Rounding { .. } => "approach",
            Refusal::Solver { .. } | Refusal::NoEnergy | Refusal::NoDynamics => "solver",
            Refusal::Law(_) => "param",
            Refusal::Search(_) | Refusal::Overflow => return Self::computation(refusal.to_string()),
            _ => "surface",
        };
        Self::input(key(option), refusal)
    }
}

impl From<Clash> for Failure {
    fn from(clash: Clash) -> Self {
        Self::Input(clash.into())
    }
}

impl From<Unusable> for Failure {
    fn from(unusable: Unusable) -> Self {
        Self::Input(unusable)
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        match error {
            FileError::Memory { .. } => Self::refused(error.to_string()),
            _ => Self::computation(error.to_string()),
        }
    }
}

impl From<JournalError> for Failure {
    /// A journal that cannot be written or read is a failed computation; one of another run is unusable input.
    fn from(error: JournalError) -> Self {
        match error {
            JournalError::Io { .. } => Self::computation(error.to_string()),
            error => Self::refused(error.to_string()),
        }
    }
}

impl From<PlotError> for Failure {
    fn from(error: PlotError) -> Self {
        Self::computation(error.to_string())
    }
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        let text = error.to_string();
        match error {
            SweepError::Contact { source, .. } if matches!(*source, SolveError::Refused(_)) => Self::refused(text),
            SweepError::Contact { .. } | SweepError::Keep(_) => Self::computation(text),
            SweepError::Interrupted(_) => Self::interrupted(text),
            _ => Self::refused(text),
        }
    }
}
