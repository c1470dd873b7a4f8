//! The result of a contact.

use std::fmt;
use std::path::PathBuf;

use gfmd_record::Record;
use serde::Serialize;

use super::threshold::Threshold;
use gfmd_run::accuracy::Worst;
use gfmd_run::convergence::NotConverged;
use gfmd_run::series::Head;
use gfmd_run::trace::Trace;

/// The result, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    #[serde(flatten)]
    pub head: Head,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accurate>,
    pub loads: Vec<Record>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub history: Option<Trace>,
    /// Along x and along y.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flow_threshold: Option<[Option<Threshold>; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_converged: Option<NotConverged>,
    pub peak_bytes: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    /// The file of VTK.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vtk: Option<PathBuf>,
    pub plots: Vec<PathBuf>,
}

/// The grids that were used for an accuracy, as printed.
#[derive(Clone, Debug, Serialize)]
pub struct Accurate {
    /// The largest relative error that was asked for.
    pub asked: f64,
    /// The grids, one after the other.
    pub grids: Vec<GridUsed>,
}

/// A grid that was used for an accuracy, as printed.
#[derive(Clone, Debug, Serialize)]
pub struct GridUsed {
    /// Points along each side.
    pub n: [usize; 2],
    /// Wall time, s.
    pub seconds: f64,
    /// The number that is farthest from the accuracy.
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
