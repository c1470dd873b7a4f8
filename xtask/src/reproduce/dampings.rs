//! Figure 4.1: the punch with several damping factors, beside the free slab.

use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_input::failure::Failure;
use gfmd_plot::{Axis, Chart, Mark, Panel, Series};
use serde_json::Value;

use super::Runs;
use super::free_slab::FreeSlab;

/// Damping divided by the critical damping.
const FACTORS: [(&str, f64); 4] = [("0.1", 0.1), ("0.3", 0.3), ("1", 1.0), ("3", 3.0)];

/// Number of steps of figure 4.1a, and step of figure 4.1b.
const STEPS: usize = 400;
const SNAPSHOT: usize = 100;

/// Stride of the drawn points of the line y = L/2.
const EVERY: usize = 2;

const LENGTH: f64 = 1.27;
const POINTS: f64 = 128.0;

/// Free slab of unit length and height, as below the punch.
const YOUNG: f64 = 70.0;
const POISSON: f64 = 0.33;
const HEIGHT: f64 = 1.0;

/// Returns the command of the punch with one factor, as it appears on the page.
pub(super) fn command(factor: &str) -> String {
    format!(
        "punch --solver verlet-critical --damping {factor} --max-iterations {STEPS} --tolerance 1e-15 --history \
         --history-mode 1,0,x"
    )
}

/// Draws the pictures; returns them with the suffixes of their file names.
pub(super) fn draw(number: &str, runs: &mut Runs) -> Result<Vec<(&'static str, String)>, Failure> {
    let points: String = (0..POINTS as usize)
        .step_by(EVERY)
        .map(|i| format!(" --history-point {:.6},0.635,x", i as f64 * LENGTH / POINTS))
        .collect();
    let mut modes = Vec::new();
    let mut profiles = Vec::new();
    for (hue, (factor, _)) in FACTORS.into_iter().enumerate() {
        let report = runs.run(&(command(factor) + &points))?;
        let history = &report["history"];
        let label = format!("factor {factor}");
        let amplitude = numbers(&history["modes"][0]["im"])?;
        modes.push(Series::line(&label, hue, amplitude.iter().enumerate().map(|(step, u)| (step as f64, u / LENGTH))));
        let line = history["points"].as_array().map_or(&[][..], Vec::as_slice);
        let profile = line.iter().map(|point| {
            let x = point["point"][0].as_f64().unwrap_or(f64::NAN);
            Ok((x / LENGTH, numbers(&point["u"])?.get(SNAPSHOT).copied().unwrap_or(f64::NAN) / LENGTH))
        });
        profiles.push(Series::line(&label, hue, profile.collect::<Result<Vec<_>, Failure>>()?));
    }
    let svg = |chart: Chart| chart.svg().map_err(Failure::from);
    if number == "4.1b" {
        // Reads the displacement of the converged state from the file of the figures below the punch.
        runs.run(super::PREPARATION[0])?;
        let file = gfmd_files::Reader::open(runs.folder.path().join("punch.h5"));
        let file = file.map_err(|error| Failure::computation(error.to_string()))?;
        let u: Vec<f64> =
            file.values("/fields/displacement").map_err(|error| Failure::computation(error.to_string()))?;
        let n = POINTS as usize;
        let exact = (0..n).map(|i| (i as f64 / POINTS, u[(i * n + n / 2) * 3] / LENGTH));
        profiles.push(Series { mark: Mark::Dashes, ..Series::line("converged", 6, exact) });
        let panel = Panel {
            x: Axis::linear("*x*/*L*"),
            y: Axis::linear(&format!("*u*_x/*z*_m after {SNAPSHOT} steps")),
            series: profiles,
            ..Panel::default()
        };
        return Ok(vec![("", svg(Chart::new(vec![panel]))?)]);
    }
    let failed = |reason: &dyn std::fmt::Display| Failure::computation(format!("the free slab: {reason}"));
    let material = Material::from_young(YOUNG, POISSON).map_err(|error| failed(&error))?;
    let body = Body::slab(material, HEIGHT).map_err(|error| failed(&error))?;
    let grid = Grid::square(POINTS as usize, 1.0).map_err(|error| failed(&error))?;
    let slab = FreeSlab::new(&body, grid).ok_or_else(|| failed(&"a single point"))?;
    let mut free = Vec::new();
    for (hue, (label, factor)) in FACTORS.into_iter().enumerate() {
        let amplitudes = slab.relax(factor, STEPS).map_err(|error| failed(&error))?;
        let points = amplitudes.iter().enumerate().map(|(step, u)| (step as f64, *u));
        free.push(Series::line(&format!("factor {label}"), hue, points));
    }
    let panel = |title: &str, label: &str, series| Panel {
        title: title.into(),
        x: Axis::linear("time step"),
        y: Axis::linear(label),
        series,
        ..Panel::default()
    };
    let panels = vec![
        panel("punch", "amplitude of *u*_x, mode (1, 0) / *z*_m", modes),
        panel("free slab", "amplitude of *u*_x, mode (0, 0) / start", free),
    ];
    Ok(vec![("", svg(Chart { share_y: false, ..Chart::new(panels) })?)])
}

fn numbers(value: &Value) -> Result<Vec<f64>, Failure> {
    let list: Option<Vec<f64>> = value.as_array().and_then(|list| list.iter().map(Value::as_f64).collect());
    list.ok_or_else(|| Failure::computation("a history has no numbers"))
}
