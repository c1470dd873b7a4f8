//! The flags of damped dynamics that several commands share: time step and damping.

use clap::Args;
use gfmd_contact::Factors;
use serde::{Deserialize, Serialize};

use super::values::up_to;
use crate::options::Options;
use crate::{Unusable, key, setting, words};

/// Flags of the dynamics.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Solver")]
pub struct DynamicsArgs {
    /// Time step divided by its undamped stability limit, for verlet-critical (default: 0.25) and verlet-modes
    #[arg(long, value_name = "F", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    dt: Option<f64>,
    /// Damping of verlet-critical divided by the critical damping of the softest mode (default: 1); or three numbers,
    /// each component's damping divided by the critical damping of its uniform mode
    #[arg(long, value_delimiter = ',', value_name = "F|FX,FY,FZ", num_args = 1..=3, allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "up_to::<3, _, _>")]
    damping: Vec<f64>,
}

/// The method for which the flags are given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DampedBy {
    /// Numbers, one or one for each component: `verlet-critical`.
    Numbers,
    /// Modes: `verlet-modes`.
    Modes,
    /// Another method.
    Other,
}

impl DynamicsArgs {
    /// Checks that the method takes the flags.
    ///
    /// # Errors
    /// Returns an error for a flag that the method does not take, or for two numbers instead of one or three.
    pub fn check(&self, method: DampedBy) -> Result<(), Unusable> {
        if let (Some(dt), DampedBy::Other) = (self.dt, method) {
            let allowed = words!["left out without ", setting("solver", "verlet-critical"), " or verlet-modes"];
            return Err(Unusable::value(key("dt"), dt, allowed));
        }
        if let (Some(factor), false) = (self.damping.first(), method == DampedBy::Numbers) {
            let allowed = words!["left out without ", setting("solver", "verlet-critical")];
            return Err(Unusable::value(key("damping"), factor, allowed));
        }
        self.factors().map(drop)
    }

    /// Returns the time step divided by its stability limit.
    pub fn time_step(&self) -> Option<f64> {
        self.dt
    }

    /// Returns the damping divided by the critical damping.
    ///
    /// # Errors
    /// Returns an error for two numbers.
    pub fn factors(&self) -> Result<Factors, Unusable> {
        match self.damping[..] {
            [] => Ok(Factors::Softest(1.0)),
            [factor] => Ok(Factors::Softest(factor)),
            [x, y, z] => Ok(Factors::Components([x, y, z])),
            _ => Err(Unusable::value(key("damping"), format!("{:?}", self.damping), "one number, or three")),
        }
    }

    /// Returns true if a flag is given.
    pub fn is_given(&self) -> bool {
        self.dt.is_some() || !self.damping.is_empty()
    }
}
