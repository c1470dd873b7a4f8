//! Warnings about slopes that are not small, for the program and Python.

use gfmd_problem::{Facts, Words, key, words};

/// Rms gradient above which slopes are not small: contact areas change by more than one or two hundredths
/// (docs/contacts.md).
const LARGEST_SMALL_SLOPE: f64 = 0.2;

/// Slopes that are not small.
#[derive(Clone, Debug)]
pub struct Slopes {
    rms_gradient: f64,
    max_slope: f64,
    hint: Words,
}

impl Slopes {
    /// Code of the warning.
    pub const CODE: &str = "large-slope";

    /// Returns the slopes if they are not small.
    pub fn of(rms_gradient: f64, max_slope: impl FnOnce() -> f64, facts: &Facts) -> Option<Self> {
        let possible = Facts { finite_slope: true, ..*facts }.check().is_ok();
        let hint = match (facts.finite_slope, possible) {
            (true, _) => "; strains are still taken as small".into(),
            (false, true) => words!["; ", key("finite_slope"), " includes the slopes"],
            (false, false) => Words::default(),
        };
        (rms_gradient > LARGEST_SMALL_SLOPE).then(|| Self { rms_gradient, max_slope: max_slope(), hint })
    }

    /// Returns the warning, with the largest pressure divided by E*.
    pub fn message(&self, strain: f64) -> Words {
        let Self { rms_gradient, max_slope, hint } = self;
        let found = format!(
            "the rms gradient is {rms_gradient:.2}, the largest slope {max_slope:.2}, and the largest pressure \
             {strain:.2} E*: what the linear theory neglects is of this size"
        );
        words![found, hint.clone()]
    }
}
