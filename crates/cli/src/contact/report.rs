//! The result of a contact.

use std::path::PathBuf;

use gfmd_record::Record;
use serde::Serialize;

use super::threshold::Threshold;
use gfmd_run::convergence::NotConverged;
use gfmd_run::series::Head;
use gfmd_run::trace::Trace;

/// The result, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    #[serde(flatten)]
    pub head: Head,
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
