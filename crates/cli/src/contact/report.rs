use std::path::PathBuf;

use gfmd_problem::{Facts, Unknown};
use gfmd_record::Record;
use serde::Serialize;

use super::is_normal;
use super::slopes::Slopes;
use super::threshold::Threshold;
use crate::base::BaseArgs;
use crate::choice::named;
use crate::convergence::NotConverged;
use crate::elastic::OtherArgs;
use crate::hardness::GivenHardness;
use crate::law::Adhesion;
use crate::session::Session;
use crate::source::Second;
use crate::source::scan::Scan;
use crate::trace::Trace;

/// The result, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub n: [usize; 2],
    pub length: [f64; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    pub surface: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scan: Option<Scan>,
    #[serde(flatten)]
    pub second: Option<Second>,
    pub rms_gradient: f64,
    pub max_slope: f64,
    pub rms_height: f64,
    pub e_star: f64,
    /// The body, unless it is a half-space or a slab on a bonded base, and alone.
    #[serde(flatten)]
    pub others: OtherArgs,
    #[serde(skip)]
    pub body: Option<String>,
    #[serde(flatten)]
    pub base: BaseArgs,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lower: Option<Lower>,
    pub boundary: &'static str,
    #[serde(skip_serializing_if = "is_normal", with = "named")]
    pub components: Unknown,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hardness: Option<GivenHardness>,
    /// With an attraction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adhesion: Option<Adhesion>,
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

impl Report {
    /// Warns of slopes and strains that are not small.
    pub(super) fn warn_of_slopes(&self, facts: &Facts, session: &Session) {
        let Self { rms_gradient, max_slope, e_star, loads, .. } = self;
        let Some(slopes) = Slopes::of(*rms_gradient, || *max_slope, facts) else { return };
        let strain = loads.iter().map(|load| load.number("max_pressure") / e_star).fold(0.0, f64::max);
        session.warn(Slopes::CODE, slopes.told(strain));
    }
}

/// The surface below the slab, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Lower {
    pub surface: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scan: Option<Scan>,
    pub rms_gradient: f64,
    pub rms_height: f64,
}
