//! Figures of a fitted series.

use std::path::{Path, PathBuf};

use gfmd_medium::PronyFit;
use gfmd_plot::{Axis, Chart, Panel, Point, Series};
use gfmd_unit::Units;

use super::Measured;
use gfmd_input::failure::Failure;
use gfmd_report::figures::named;

/// Number of points of a curve.
const STEPS: u32 = 300;

/// Draws the measured and the fitted moduli against the frequency, and the moduli of the branches against their times.
pub(super) fn draw(stem: &Path, points: &[Measured], fit: &PronyFit, units: &Units) -> Result<Vec<PathBuf>, Failure> {
    let stress = units.name("stress");
    let lowest = points.iter().map(|point| point.frequency).fold(f64::INFINITY, f64::min);
    let highest = points.iter().map(|point| point.frequency).fold(0.0, f64::max);
    // A decade beyond the data shows the ends of the series.
    let (low, high) = ((lowest / 10.0).ln(), (highest * 10.0).ln());
    let frequencies = || (0..=STEPS).map(|i| (low + (high - low) * f64::from(i) / f64::from(STEPS)).exp());
    let of = |number: fn(&Measured) -> f64| points.iter().map(|p| Point::new(p.frequency, number(p))).collect();
    let moduli = Panel {
        x: Axis::log(if points.iter().any(|point| point.log_a_t != 0.0) {
            "reduced frequency / Hz"
        } else {
            "frequency / Hz"
        }),
        y: Axis::log(&format!("modulus / {stress}")),
        series: vec![
            Series::points("storage", 0, of(|point| point.storage)),
            Series::points("loss", 1, of(|point| point.loss)),
            Series::line("fit", 0, frequencies().map(|f| (f, fit.modulus(f).re))),
            Series::line("", 1, frequencies().map(|f| (f, fit.modulus(f).im))),
        ],
        ..Panel::default()
    };
    let branch = |branch: &gfmd_medium::FittedBranch| match branch.modulus_error {
        Some(error) => {
            // The bar of a modulus below its error ends far down the logarithmic axis.
            let low = (branch.modulus - error).max(0.1 * branch.modulus);
            Point::within(branch.time, branch.modulus, [low, branch.modulus + error])
        }
        None => Point::new(branch.time, branch.modulus),
    };
    let branches = Panel {
        x: Axis::log("relaxation time / s"),
        y: Axis::log(&format!("modulus of the branch / {stress}")),
        series: vec![Series::points("", 2, fit.branches.iter().map(branch).collect())],
        ..Panel::default()
    };
    let mut files = Vec::new();
    for (name, panel) in [("moduli", moduli), ("branches", branches)] {
        files.extend(Chart::new(vec![panel]).save(&named(stem, name))?);
    }
    Ok(files)
}
