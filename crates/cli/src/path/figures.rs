//! Figures of a path.

use std::path::{Path, PathBuf};

use gfmd_plot::{Axis, Chart, Panel, Series};
use gfmd_record::Record;

use super::Report;
use gfmd_input::failure::Failure;
use gfmd_report::figures::{Scene, length, named};
use gfmd_report::path::{in_time, legs};

/// Draws the path leg by leg and the step with the largest contact. The path is pressure against approach and contact
/// area against pressure, or, with lateral motion, shear and sticking area against lateral displacement.
pub(super) fn draw(
    prefix: &Path,
    report: &Report,
    steps_of_leg: usize,
    scene: &Scene,
) -> Result<Vec<PathBuf>, Failure> {
    let unit = report.head.unit.as_deref().unwrap_or("length");
    let mut files = scene.draw(prefix)?;
    let unit_pressure = report.head.e_star * report.head.rms_gradient;
    let lateral = |step: &Record| report.along(step.vector("lateral"));
    // Motion that separates the directions of a loop, common to all panels.
    let drive = |step: &Record| match report.moves_sideways() {
        true => lateral(step),
        false => step.value("approach").unwrap_or_else(|| step.number("p_star")),
    };
    let drive: Vec<f64> = report.steps.iter().map(drive).collect();
    let legs = |of: &dyn Fn(&Record) -> (f64, f64)| -> Vec<Series> {
        legs(&report.steps.iter().map(of).collect::<Vec<_>>(), &drive, steps_of_leg)
    };
    let shear = |step: &Record| report.along(step.vector("mean_shear"));
    let reduced = "*p*/(*E*\\* *ḡ*)";
    let panels = if report.head.relaxation.is_some() {
        let points = |name: &str| report.steps.iter().map(|step| (step.number("time"), step.number(name))).collect();
        in_time(["area_fraction", "p_star", "approach"].map(points), reduced, unit)
    } else if report.moves_sideways() {
        let read = length(unit, report.steps.iter().map(|step| lateral(step).abs()).fold(0.0, f64::max));
        let x = Axis::linear(&format!("lateral displacement / {}", read.name));
        let lateral = |step: &Record| lateral(step) * read.factor;
        let share = |step: &Record| step.value("stick_fraction").unwrap_or_else(|| step.number("area_fraction"));
        let sticking = report.steps.iter().any(|step| step.value("stick_fraction").is_some());
        let area = if sticking { "sticking area" } else { "contact area" };
        vec![
            Panel {
                x: x.clone(),
                y: Axis::linear("shear / (*E*\\* *ḡ*)"),
                series: legs(&|step| (lateral(step), shear(step) / unit_pressure)),
                ..Panel::default()
            },
            Panel { x, y: Axis::linear(area), series: legs(&|step| (lateral(step), share(step))), ..Panel::default() },
        ]
    } else {
        let read = length(unit, report.steps.iter().map(|step| step.number("approach").abs()).fold(0.0, f64::max));
        let approach = Panel {
            x: Axis::linear(&format!("approach / {}", read.name)),
            y: Axis::linear(reduced),
            series: legs(&|step| (step.number("approach") * read.factor, step.number("p_star"))),
            ..Panel::default()
        };
        let mut panels = vec![
            approach,
            Panel {
                x: Axis::linear(reduced),
                y: Axis::linear("contact area"),
                series: legs(&|step| (step.number("p_star"), step.number("area_fraction"))),
                ..Panel::default()
            },
        ];
        if report.steps.iter().all(|step| step.value("approach").is_none()) {
            panels.remove(0);
        }
        panels
    };
    if panels.is_empty() {
        return Ok(files);
    }
    let chart = Chart { share_y: false, ..Chart::new(panels) };
    files.extend(chart.save(&named(prefix, "path"))?);
    Ok(files)
}
