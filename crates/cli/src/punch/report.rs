//! The printed report of `punch`, and the scalars of its file.

use std::fmt;
use std::path::PathBuf;

use gfmd_green::Height;
use serde::Serialize;

use super::{Comparison, ContactName, Nodes, Refinement};
use crate::session::list_files;
use gfmd_problem::options::given::ArrayOption;
use gfmd_problem::options::{OtherArgs, height};
use gfmd_record::{Punch, Record, Table, heads};
use gfmd_run::convergence::NotConverged;
use gfmd_run::trace::Trace;
use gfmd_unit::Units;

/// The result, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub dim: u8,
    pub n: [usize; 2],
    pub size: [f64; 2],
    #[serde(with = "height")]
    pub height: Height,
    pub young: f64,
    pub poisson: f64,
    #[serde(flatten)]
    pub others: OtherArgs,
    pub contact: ContactName,
    pub nodes: Nodes,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mask: Option<ArrayOption>,
    /// The file of the traction beside the punch.
    #[serde(rename = "traction", skip_serializing_if = "Option::is_none")]
    pub prescribed_traction: Option<ArrayOption>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub shift: Vec<f64>,
    pub components: Vec<&'static str>,
    /// Numbers of the punch.
    #[serde(flatten)]
    pub numbers: Record<Punch>,
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
        let ([nx, ny], number) = (self.n, |name: &str| self.numbers.number(name));
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
            self.size[0],
            self.size[1],
            number("contact_nodes")
        )?;
        match &self.mask {
            Some(mask) => writeln!(f, "points of {mask}\n")?,
            None => {
                let [width, effective] = ["punch_width", "effective_width"].map(number);
                writeln!(f, "width {width:.6}, effective width of the points {effective:.6}\n")?;
            }
        }
        if !self.shift.is_empty() {
            let traction: Vec<f64> =
                self.components.iter().map(|component| number(&format!("mean_traction_{component}"))).collect();
            writeln!(f, "shift {:?}, mean traction {traction:?}", self.shift)?;
        }
        for (column, head) in heads::<Punch>(Table::State) {
            writeln!(f, "{:<14} {:>15.8e}", head.word, number(column.name))?;
        }
        let per_component = number("transform_pairs") as u64 / self.components.len() as u64;
        writeln!(
            f,
            "residual       {:>15.1e} after {} iterations, {per_component} transform pairs per component, {:.2} s{}",
            number("residual"),
            number("iterations"),
            number("seconds"),
            if self.numbers.is("converged") { "" } else { "  NOT CONVERGED" }
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
