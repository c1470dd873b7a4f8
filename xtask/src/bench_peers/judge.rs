//! Verdicts on final pressures: certified residuals, and agreement with the first contestant.

use std::collections::BTreeMap;
use std::path::PathBuf;

use gfmd_input::session::Session;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::contestant::Problem;
use super::process::ProgramFailure;
use super::python::{Environment, Script};

/// Result of peers/certify.py for one pressure. Lengths are in units of the rms height, energies in units of mean
/// pressure times rms height.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Verdict {
    /// Residuals (docs/interface/contact.md).
    pub residual: BTreeMap<String, f64>,
    /// Fraction of points with pressure.
    pub area_fraction: f64,
    /// Rigid approach beyond first touch.
    pub approach: f64,
    /// Elastic energy per area.
    pub energy: f64,
    /// Difference from the pressure of the first contestant.
    pub differs: Difference,
}

/// Difference of two pressures.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Difference {
    /// Number of points in contact in only one of the two.
    pub points: u64,
    /// Rms difference divided by rms pressure.
    pub pressure: f64,
}

/// Largest difference allowed between two certified states, in pressure and in the fraction of contact points.
pub(super) const AGREEMENT: f64 = 1e-6;

impl Verdict {
    /// Returns the largest residual; NaN if any is NaN.
    pub fn worst(&self) -> f64 {
        gfmd_relax::worst(self.residual.values().copied())
    }

    /// Returns the reason why this pressure is rejected, if any. On small grids [`AGREEMENT`] is less than one point.
    /// One point may differ in any case, since its pressure can be arbitrarily small.
    pub(super) fn objection(&self, tolerance: f64, points: usize) -> Option<String> {
        let worst = self.worst();
        let exceeds = |found: f64, allowed: f64| found.is_nan() || found > allowed;
        if exceeds(worst, tolerance) {
            return Some(format!("its certified residual is {worst:.3e}; it must be at most {tolerance:e}"));
        }
        if exceeds(self.differs.pressure, AGREEMENT) {
            let found = self.differs.pressure;
            return Some(format!(
                "its pressure differs by {found:.3e} (rms, relative); it may differ by {AGREEMENT:e}"
            ));
        }
        let allowed = (AGREEMENT * (points * points) as f64).max(1.0);
        (self.differs.points as f64 > allowed).then(|| {
            format!(
                "its contact differs in {} of {points} x {points} points; it may differ in {allowed:.0}",
                self.differs.points
            )
        })
    }
}

/// Judges the pressures in the files `fields`, by contestant, and compares them with `reference`. A pressure that is
/// not a number or carries no load has no verdict.
pub(super) fn judge(
    problem: &Problem,
    fields: &BTreeMap<String, PathBuf>,
    reference: &str,
    environment: &Environment,
    session: &Session,
) -> Result<BTreeMap<String, Verdict>, ProgramFailure> {
    let task = json!({
        "heights": problem.heights, "mean_pressure": problem.mean_pressure, "boundary": problem.boundary.name(),
        "hardness": problem.hardness, "fields": fields, "reference": reference,
    });
    environment.run(Script::Certify, &task, session)
}
