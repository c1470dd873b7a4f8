//! The printed report of `punch`, and the scalars of its file.

use std::fmt;
use std::path::PathBuf;

use gfmd_green::Height;
use serde::Serialize;

use super::{Comparison, ContactName, Nodes, Refinement};
use crate::session::list_files;
use gfmd_problem::options::given::ArrayOption;
use gfmd_problem::options::{OtherArgs, height};
use gfmd_run::convergence::NotConverged;
use gfmd_run::trace::Trace;
use gfmd_unit::Units;

/// The result, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub dim: u8,
    pub n: [usize; 2],
    pub length: [f64; 2],
    #[serde(with = "height")]
    pub height: Height,
    pub young: f64,
    pub poisson: f64,
    #[serde(flatten)]
    pub others: OtherArgs,
    pub contact: ContactName,
    pub nodes: Nodes,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub punch_width: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effective_width: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mask: Option<ArrayOption>,
    /// The file of the traction beside the punch.
    #[serde(rename = "traction", skip_serializing_if = "Option::is_none")]
    pub prescribed_traction: Option<ArrayOption>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shift: Vec<f64>,
    pub depth: f64,
    pub contact_nodes: usize,
    pub components: Vec<&'static str>,
    pub mean_pressure: f64,
    pub mean_traction: Vec<f64>,
    pub max_pressure: f64,
    pub elastic_energy: f64,
    pub residual: f64,
    pub converged: bool,
    pub iterations: u64,
    pub transform_pairs: u64,
    pub seconds: f64,
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub comparison: Option<Comparison>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub refinement: Option<Refinement>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_converged: Option<NotConverged>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub history: Option<Trace>,
    pub peak_bytes: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    pub plots: Vec<PathBuf>,
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [nx, ny] = self.n;
        let kind = match self.contact {
            ContactName::Sticking => "sticking",
            ContactName::Frictionless => "frictionless",
        };
        let nodes = match self.nodes {
            Nodes::Strict => "its edge excluded",
            Nodes::Inclusive => "its edge included",
        };
        let body = match self.height {
            Height::Finite(height) => format!("a slab of height {height}"),
            Height::Infinite => "a half-space".into(),
        };
        let others = self.others.words(None, &Units::default());
        let others = if others.is_empty() { others } else { format!("; {others}") };
        writeln!(f, "flat {kind} punch on {body}, E = {}, nu = {}{others}", self.young, self.poisson)?;
        writeln!(
            f,
            "{nx} x {ny} points, cell {} x {}, {} points under the punch ({nodes})",
            self.length[0], self.length[1], self.contact_nodes
        )?;
        match &self.mask {
            Some(mask) => writeln!(f, "points of {mask}\n")?,
            None => {
                let [width, effective] = [self.punch_width, self.effective_width].map(|w| w.unwrap_or(f64::NAN));
                writeln!(f, "width {width:.6}, effective width of the points {effective:.6}\n")?;
            }
        }
        if !self.shift.is_empty() {
            writeln!(f, "shift {:?}, mean traction {:?}", self.shift, self.mean_traction)?;
        }
        writeln!(f, "depth          {:>15.8e}", self.depth)?;
        writeln!(f, "mean pressure  {:>15.8e}", self.mean_pressure)?;
        writeln!(f, "max pressure   {:>15.8e}", self.max_pressure)?;
        writeln!(f, "elastic energy {:>15.8e} per area", self.elastic_energy)?;
        let per_component = self.transform_pairs / self.components.len() as u64;
        writeln!(
            f,
            "residual       {:>15.1e} after {} iterations, {per_component} transform pairs per component, {:.2} s{}",
            self.residual,
            self.iterations,
            self.seconds,
            if self.converged { "" } else { "  NOT CONVERGED" }
        )?;
        if let Some(Comparison { reference, compared_points: [mx, my], error }) = &self.comparison {
            writeln!(f, "\nagainst {reference} on {mx} x {my} points, rms difference over depth:")?;
            for (component, error) in self.components.iter().zip(error) {
                writeln!(f, "u_{component}            {error:>15.6e}")?;
            }
        }
        if let Some(refinement) = &self.refinement {
            writeln!(f, "\n{:>8} {:>15}", "n", "mean pressure")?;
            for (n, pressure) in refinement.n.iter().zip(&refinement.mean_pressure) {
                writeln!(f, "{n:>8} {pressure:>15.8e}")?;
            }
            let order =
                refinement.order.map_or_else(String::new, |order| format!("   order of convergence {order:.3}"));
            writeln!(f, "{:>8} {:>15.8e}{order}", "limit", refinement.extrapolated)?;
        }
        list_files(f, self.out.as_deref(), &self.plots)
    }
}

/// The scalars of the file: name, units, meaning, value.
pub(super) fn scalars(report: &Report) -> [(&'static str, &'static str, &'static str, f64); 12] {
    // The points of a mask have no width.
    let effective_width = report.effective_width.unwrap_or(f64::NAN);
    [
        ("mean_pressure", "stress", "mean pressure over the whole surface", report.mean_pressure),
        ("max_pressure", "stress", "largest pressure, at the edge of the punch", report.max_pressure),
        ("depth", "length", "depth to which the punch is pressed", report.depth),
        ("punch_width", "length", "width of the punch", report.punch_width.unwrap_or(f64::NAN)),
        ("effective_width", "length", "width as which its points act, N - 1/3 spacings", effective_width),
        ("contact_nodes", "1", "points under the punch", report.contact_nodes as f64),
        ("elastic_energy", "stress*length", "elastic energy per area of the surface", report.elastic_energy),
        ("residual", "1", "largest error of the prescribed displacement over the depth", report.residual),
        ("converged", "1", "1 if the residual is within the tolerance", f64::from(u8::from(report.converged))),
        ("iterations", "1", "iterations, or time steps", report.iterations as f64),
        ("transform_pairs", "1", "transform pairs of one component", report.transform_pairs as f64),
        ("seconds", "s", "wall time", report.seconds),
    ]
}
