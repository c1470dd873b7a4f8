//! The verdict on final pressures: certified residuals, and whether everyone found the same state.

use std::collections::BTreeMap;
use std::path::PathBuf;

use gfmd_cli::load::ResidualRecord;
use gfmd_cli::session::Session;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::contestant::Problem;
use super::process::Ended;
use super::python::{Environment, Script};

/// What peers/certify.py finds of one pressure. Lengths over the rms height, energies over mean pressure times rms height.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Verdict {
    /// The four residuals (docs/interface.md).
    pub residual: ResidualRecord,
    /// Points with pressure over all points.
    pub area_fraction: f64,
    /// Rigid approach beyond first touch.
    pub approach: f64,
    /// Elastic energy per area.
    pub energy: f64,
    /// Distance from the pressure of the first contestant.
    pub differs: Difference,
}

/// How two pressures differ.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Difference {
    /// Number of points in contact in one and not in the other.
    pub points: u64,
    /// Rms difference over rms pressure.
    pub pressure: f64,
}

/// Largest difference between two certified states: in pressure, and in contact points over all points.
pub(super) const AGREEMENT: f64 = 1e-6;

impl Verdict {
    /// The largest residual; NaN if any is.
    pub fn worst(&self) -> f64 {
        let r = self.residual;
        let all = [r.complementarity, r.penetration, r.negative_pressure, r.load];
        all.into_iter().fold(0.0, |worst, r| if worst.is_nan() || r <= worst { worst } else { r })
    }

    /// What is wrong with this pressure, if anything. On small grids [`AGREEMENT`] is less than one point; one may differ,
    /// since its pressure can be as small as it likes.
    pub(super) fn objection(&self, tolerance: f64, points: usize) -> Option<String> {
        let worst = self.worst();
        let exceeds = |found: f64, allowed: f64| found.is_nan() || found > allowed;
        if exceeds(worst, tolerance) {
            return Some(format!("its certified residual is {worst:.3e}, {tolerance:e} was asked for"));
        }
        if exceeds(self.differs.pressure, AGREEMENT) {
            let found = self.differs.pressure;
            return Some(format!("its pressure differs by {found:.3e} (rms, relative), {AGREEMENT:e} is allowed"));
        }
        let allowed = (AGREEMENT * (points * points) as f64).max(1.0);
        (self.differs.points as f64 > allowed).then(|| {
            format!(
                "its contact differs in {} of {points} x {points} points, {allowed:.0} are allowed",
                self.differs.points
            )
        })
    }
}

/// Judges the pressures in `fields`, by name. They are compared with that of `reference`.
pub(super) fn judge(
    problem: &Problem,
    fields: &BTreeMap<String, PathBuf>,
    reference: &str,
    environment: &Environment,
    session: &Session,
) -> Result<BTreeMap<String, Verdict>, Ended> {
    let task = json!({
        "heights": problem.heights, "mean_pressure": problem.mean_pressure, "fields": fields, "reference": reference,
    });
    environment.run(Script::Certify, &task, session)
}
