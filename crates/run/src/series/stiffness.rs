//! Stiffness of the states of a series.

use std::borrow::Cow;

use clap::Args;
use gfmd_contact::Stiffness;
use gfmd_problem::options::Options;
use gfmd_problem::{AnyState, NoStiffness, Posed, key};
use ndarray::ArrayRef2;
use serde::{Deserialize, Serialize};

use gfmd_input::failure::Failure;

/// Option of the stiffness of each state.
#[derive(Args, Options, Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(default)]
pub struct StiffnessArgs {
    /// Largest relative stiffness error of a hard wall; 1e-9 can be reached
    #[arg(
        long,
        alias = "stiffness-tol",
        value_name = "TOL",
        default_value_t = Stiffness::TOLERANCE,
        help_heading = "Solver"
    )]
    #[serde(skip_serializing_if = "is_usual")]
    pub stiffness_tolerance: f64,
}

fn is_usual(tolerance: &f64) -> bool {
    *tolerance == Stiffness::TOLERANCE
}

/// Allowed tolerances of the stiffness; rounding errors are some 1e-10.
const SMALLEST_TOLERANCE: f64 = 1e-9;
const LARGEST_TOLERANCE: f64 = 0.1;

impl StiffnessArgs {
    /// Checks the tolerance.
    ///
    /// # Errors
    /// Returns an error for a tolerance out of range.
    pub fn check(self) -> Result<(), Failure> {
        if (SMALLEST_TOLERANCE..=LARGEST_TOLERANCE).contains(&self.stiffness_tolerance) {
            return Ok(());
        }
        let allowed = format!("{SMALLEST_TOLERANCE:e} to {LARGEST_TOLERANCE}");
        Err(Failure::value(key("stiffness_tolerance"), self.stiffness_tolerance, allowed))
    }

    /// Returns the stiffness of a state at rest, or the reason why it has none. `warn` receives a remark if the
    /// stiffness is less exact than requested.
    ///
    /// # Errors
    /// Returns the reason why there is no stiffness.
    pub fn of(
        self,
        contact: &Posed,
        state: &AnyState,
        warn: impl FnOnce(String),
    ) -> Result<Stiffness, Cow<'static, str>> {
        found(contact.stiffness(state, self.stiffness_tolerance), warn)
    }

    /// Returns the stiffness of the state along a path with this pressure and gap of each face, or the reason why it
    /// has none.
    ///
    /// # Errors
    /// Returns the reason why there is no stiffness.
    pub fn of_fields(self, contact: &Posed, faces: &[[&ArrayRef2<f64>; 2]]) -> Result<Stiffness, Cow<'static, str>> {
        found(contact.stiffness_of_fields(faces, self.stiffness_tolerance), |_| {})
    }
}

/// Returns the stiffness found, or the reason why there is none. `warn` receives a remark if it is less exact than
/// requested.
fn found(result: Result<Stiffness, NoStiffness>, warn: impl FnOnce(String)) -> Result<Stiffness, Cow<'static, str>> {
    result.or_else(|error| match error {
        NoStiffness::Undefined(reason) => Err(reason),
        NoStiffness::Inexact(reached, why) => {
            warn(why);
            Ok(reached)
        }
    })
}
