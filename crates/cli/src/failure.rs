//! The failures of a command, and their exit status.

use std::fmt::Display;
use std::ops::RangeInclusive;

use gfmd_contact::{Fields, Refusal, SolveError};
use gfmd_files::FileError;
use gfmd_files::legible::line;
use gfmd_plot::PlotError;
use gfmd_problem::Clash;

/// Reasons why a command fails. Each message is one line, without characters that steer a terminal, also if it quotes a file.
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
        Self::Input(short(&format!("{name} is {found}; it must be {allowed}")))
    }

    /// The failure of a flag, field or file for a reason that a library states.
    pub fn input(name: &str, reason: impl Display) -> Self {
        Self::Input(short(&format!("{name}: {reason}")))
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

    /// Appends a remark, such as the file that keeps the results so far. Unusable input has no results and gets no remark.
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

/// Writes numbers with more than this many digits as powers of ten.
const MOST_DIGITS: usize = 24;

/// The text with very long numbers, as 1 followed by three hundred zeros, as powers of ten.
fn short(text: &str) -> String {
    let is_number = |c: char| c.is_ascii_digit() || c == '.';
    let mut words = Vec::new();
    for word in text.split_inclusive(|c: char| !is_number(c)) {
        let digits = word.trim_end_matches(|c: char| !is_number(c));
        let number: Option<f64> = if digits.len() > MOST_DIGITS { digits.parse().ok() } else { None };
        words.push(number.map_or_else(|| word.to_owned(), |number| format!("{number:e}{}", &word[digits.len()..])));
    }
    words.concat()
}

/// The sizes of moduli, lengths and stresses whose squares are numbers with all their digits.
pub const SIZES: RangeInclusive<f64> = 1e-140..=1e140;

/// Checks the size of a number, which depends on the unit in which it is given.
///
/// # Errors
/// A size whose square is too large or too small for a number.
pub fn check_size(flag: &str, found: f64) -> Result<(), Failure> {
    if SIZES.contains(&found) {
        return Ok(());
    }
    Err(Failure::value(flag, format!("{found:e}"), "between 1e-140 and 1e140, which another unit makes it"))
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
            | Refusal::Hidden { .. }
            | Refusal::Shallow { what: "mean pressure", .. }
            | Refusal::Slight { what: "mean pressure", .. }
            | Refusal::Rounding { what: "mean pressure", .. } => "--pressure",
            Refusal::Digits { .. } | Refusal::Unit { .. } => "--young",
            Refusal::NotFinite { what: "lateral displacement", .. }
            | Refusal::Rounding { what: "shear traction", .. } => "--lateral",
            Refusal::Approach { .. }
            | Refusal::NoApproach
            | Refusal::NotPressed { .. }
            | Refusal::NotFinite { what: "approach", .. }
            | Refusal::Shallow { .. }
            | Refusal::Slight { .. }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_numbers_are_short_in_messages() {
        let message = |found: f64| Failure::value("--young", found, "positive").to_string();
        assert_eq!(message(1e300), "--young is 1e300; it must be positive");
        assert_eq!(message(-2.5e-300), "--young is -2.5e-300; it must be positive");
        assert_eq!(message(0.1), "--young is 0.1; it must be positive");
        assert_eq!(Failure::input("--out", "a.b/c-1.2.3").to_string(), "--out: a.b/c-1.2.3");
    }
}
