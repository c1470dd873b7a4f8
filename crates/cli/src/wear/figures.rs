//! Figures of wear.

use std::path::{Path, PathBuf};

use gfmd_files::contiguous;
use gfmd_input::failure::Failure;
use gfmd_input::source::Surface;
use gfmd_plot::Chart;
use gfmd_report::figures::{Scene, named};
use gfmd_report::wear::{against_distance, depth_of, profile};
use ndarray::Array2;

use super::Report;

/// Draws the path against the distance, and its last step with the lost depth.
pub(super) fn draw(
    prefix: &Path,
    report: &Report,
    scene: &Scene,
    (surface, depth): (&Surface, &Array2<f64>),
) -> Result<Vec<PathBuf>, Failure> {
    let mut files = scene.draw(prefix)?;
    let unit = surface.unit();
    let column = |name: &str| report.steps.iter().map(|step| step.number(name)).collect::<Vec<_>>();
    let panels = against_distance(column, report.head.e_star, unit);
    if !panels.is_empty() {
        files.extend(Chart { share_y: false, ..Chart::new(panels) }.save(&named(prefix, "wear"))?);
    }
    let (heights, depth) = (contiguous(&surface.heights), contiguous(depth));
    if let Some(chart) = profile(&surface.grid, [&heights, &depth], unit) {
        files.extend(chart.save(&named(prefix, "profile"))?);
    }
    if !surface.grid.is_line() {
        depth_of(&surface.grid, &depth, unit, |drawn| {
            files.extend(drawn.save(&named(prefix, "depth"))?);
            Ok::<_, Failure>(())
        })?;
    }
    Ok(files)
}
