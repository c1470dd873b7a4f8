//! The figure of damped relaxations.

use std::path::{Path, PathBuf};

use gfmd_plot::{Axis, Chart, Panel, Series};

use super::{Report, Run};
use gfmd_report::figures::named;
use gfmd_run::failure::Failure;

/// Draws `PREFIX-damping`: the amplitudes of the slowest mode and of the displaced point against time step.
pub(super) fn draw(prefix: &Path, report: &Report) -> Result<Vec<PathBuf>, Failure> {
    let shown = report.runs.iter().filter_map(|run| run.steps_to_1e8).min().unwrap_or(report.steps).min(report.steps);
    // Smaller amplitudes are not drawn.
    let least = 1e-8;
    let thinned = |history: &[f64]| {
        let stride = (shown as usize / 500).max(1);
        let steps = history.iter().take(shown as usize + 1).enumerate().step_by(stride);
        let visible = steps.map(|(step, a)| (step as f64, a.abs())).filter(|(_, a)| *a > least);
        visible.collect::<Vec<_>>()
    };
    let panel = |title: &str, history: fn(&Run) -> &[f64]| {
        let lines = report.runs.iter().enumerate();
        let series = lines
            .map(|(hue, run)| Series::line(&format!("*η* = {} *η*_{{cr}}", run.factor), hue, thinned(history(run))));
        Panel {
            title: title.into(),
            x: Axis::linear("time step").over([0.0, f64::from(shown)]),
            y: Axis::log("amplitude").over([least, 2.0]),
            series: series.collect(),
            ..Panel::default()
        }
    };
    let panels = vec![panel("slowest mode", |run| &run.mode), panel("pushed point", |run| &run.point)];
    Ok(Chart::new(panels).save(&named(prefix, "damping"))?.to_vec())
}
