//! Result of a contact.

use std::fmt;
use std::path::PathBuf;

use gfmd_problem::Facts;
use gfmd_record::Record;
use serde::Serialize;

use super::threshold::Threshold;
use gfmd_run::accuracy::Worst;
use gfmd_run::convergence::NotConverged;
use gfmd_run::series::Head;
use gfmd_run::trace::Trace;

/// Printed result.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    #[serde(flatten)]
    pub head: Head,
    /// Features that decide which numbers the loads have.
    #[serde(skip)]
    pub facts: Facts,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accurate>,
    pub loads: Vec<Record>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub history: Option<Trace>,
    /// Thresholds along x and along y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flow_threshold: Option<[Option<Threshold>; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_converged: Option<NotConverged>,
    pub peak_bytes: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    /// VTK file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vtk: Option<PathBuf>,
    /// Law for finite elements.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub export_law: Option<PathBuf>,
    pub plots: Vec<PathBuf>,
}

/// Printed grids used to reach an accuracy.
#[derive(Clone, Debug, Serialize)]
pub struct Accurate {
    /// Largest relative error allowed.
    pub asked: f64,
    /// Grids in the order of use.
    pub grids: Vec<GridUsed>,
}

/// Printed grid used to reach an accuracy.
#[derive(Clone, Debug, Serialize)]
pub struct GridUsed {
    /// Points along each side.
    pub n: [usize; 2],
    /// Wall time, s.
    pub seconds: f64,
    /// Number farthest from the accuracy.
    #[serde(flatten)]
    pub worst: Option<Worst>,
}

impl fmt::Display for GridUsed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { n: [nx, ny], seconds, worst } = self;
        write!(f, "{nx} x {ny} points, {seconds:.2} s, ")?;
        match worst {
            Some(Worst { number, error: Some(error), .. }) => write!(f, "{number} to {:.2} %", 100.0 * error),
            Some(Worst { number, reason: Some(reason), .. }) => write!(f, "{number} not known: {reason}"),
            _ => f.write_str("no number has a known error"),
        }
    }
}
