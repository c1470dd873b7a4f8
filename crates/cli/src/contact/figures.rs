//! Figures of a contact.

use std::path::{Path, PathBuf};

use gfmd_measure::theory::{ElastoplasticArea, persson_pressure};
use gfmd_plot::{Axis, Chart, Mark, Panel, Point, Series};
use ndarray::ArrayView2;

use super::Report;
use crate::measuring::{Gathered, draw_flow, draw_patches};
use gfmd_input::failure::Failure;
use gfmd_input::hardness::GivenHardness;
use gfmd_input::source::Surface;
use gfmd_report::contact::{AREAS, areas};
use gfmd_report::figures::{Scene, named, short, sides};

/// Draws the last load: `PREFIX-map`, `-traction`, `-gap` and `-section`, for a lower surface also `PREFIX-lower-map`
/// etc.; and `PREFIX-area` if there are several loads of a hard wall. `variance` is the variance of the pressure in
/// full contact.
pub(super) fn draw(prefix: &Path, report: &Report, scenes: &[Scene], variance: f64) -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    for scene in scenes {
        files.extend(scene.draw(prefix)?);
    }
    if report.loads.len() > 1 && report.loads.iter().all(|load| !load.has("interface_energy")) {
        let loads = report.loads.iter().map(|load| AREAS.map(|name| load.number(name)));
        let mut chart = areas(&loads.collect::<Vec<_>>(), report.head.n[1] == 1);
        if let (Some(panel), Some(GivenHardness::Number(hardness))) = (chart.panels.first_mut(), &report.head.hardness)
        {
            // Persson's line without the hardness would be hidden below the line with it.
            panel.series.retain(|series| series.label != "Persson");
            panel.series.extend(plastic(report, *hardness, variance));
        }
        files.extend(chart.save(&named(prefix, "area"))?);
    }
    Ok(files)
}

/// Returns the points at the hardness and both areas of Persson's theory with a hardness, against reduced pressure.
fn plastic(report: &Report, hardness: f64, variance: f64) -> [Series; 3] {
    let unit = report.head.e_star * report.head.rms_gradient;
    let loads = || report.loads.iter().map(|load| load.number("p_star"));
    let (lowest, highest) = (loads().fold(f64::INFINITY, f64::min), loads().fold(0.0, f64::max));
    let curve = |part: fn(&ElastoplasticArea) -> f64| {
        let pressures = (0..=80).map(|i| lowest * (highest / lowest).powf(f64::from(i) / 80.0));
        let areas = pressures.map(move |p| (p, part(&ElastoplasticArea::new(p * unit, variance, hardness))));
        areas.filter(|(_, area)| *area > 0.0).collect::<Vec<_>>()
    };
    let found =
        report.loads.iter().filter_map(|load| Some(Point::new(load.number("p_star"), load.value("plastic_fraction")?)));
    let mut found: Vec<Point> = found.filter(|point| point.y > 0.0).collect();
    found.sort_by(|a, b| a.x.total_cmp(&b.x));
    [
        Series { mark: Mark::JoinedPoints, ..Series::points("points at the hardness", 2, found) },
        Series::line("Persson with the hardness", 3, curve(ElastoplasticArea::total)),
        Series { mark: Mark::Dashes, ..Series::line("its points at the hardness", 3, curve(|area| area.plastic)) },
    ]
}

/// Largest number of loads for which distributions are drawn.
const MOST_LOADS: usize = 4;

/// Returns up to four of `count` loads, from the lowest to the highest.
fn chosen(report: &Report, count: usize) -> Vec<usize> {
    let mut sorted: Vec<usize> = (0..count).collect();
    sorted.sort_by(|a, b| report.loads[*a].number("p_star").total_cmp(&report.loads[*b].number("p_star")));
    let drawn = count.min(MOST_LOADS);
    (0..drawn).map(|k| sorted[if drawn == 1 { count - 1 } else { k * (count - 1) / (drawn - 1) }]).collect()
}

/// Draws the measurements of `--statistics` and `--flow`: `PREFIX-patches` and `PREFIX-flow` of the last load,
/// `PREFIX-pressures`, `PREFIX-gaps` and `PREFIX-spectrum` of up to four loads. `variance` is the variance of the
/// pressure in full contact.
pub(super) fn measured(
    prefix: &Path,
    report: &Report,
    surface: &Surface,
    repulsion: &ArrayView2<f64>,
    gathered: &Gathered,
    variance: f64,
) -> Result<Vec<PathBuf>, Failure> {
    let (grid, unit) = (&surface.grid, surface.unit());
    let mut files = Vec::new();
    if let Some(flow) = &gathered.flow {
        files.extend(draw_flow(prefix, surface, flow)?);
    }
    if gathered.states.is_empty() {
        return Ok(files);
    }
    files.extend(draw_patches(prefix, surface, repulsion.view())?);
    let chosen = chosen(report, gathered.states.len());
    let scale = report.head.e_star * report.head.rms_gradient;
    let label = |load: usize| format!("*p*\\* = {}", short(report.loads[load].number("p_star")));
    let (mut pressures, mut gaps) = (Vec::new(), Vec::new());
    for (hue, &load) in chosen.iter().enumerate() {
        let found = &gathered.states[load];
        let bins = found.pressure.middles.iter().zip(&found.pressure.densities);
        let positive = bins.filter(|(_, density)| **density > 0.0);
        let densities = positive.map(|(p, density)| (p / scale, density * scale));
        pressures.push(Series::line(&label(load), hue, densities));
        // The theory holds for elastic bodies without attraction.
        if report.head.hardness.is_none() && !report.loads[load].has("interface_energy") {
            let mean = report.loads[load].number("mean_pressure");
            let density = |p: &f64| (p / scale, persson_pressure(*p, mean, variance) * scale);
            let theory: Vec<_> = found.pressure.middles.iter().map(density).filter(|(_, p)| *p > 1e-6).collect();
            let name = if hue == 0 { "Persson" } else { "" };
            pressures.push(Series { mark: Mark::Dashes, ..Series::line(name, hue, theory) });
        }
        let height = report.head.rms_height;
        let bins = found.gap_decades.iter().filter(|[_, density]| *density > 0.0);
        gaps.push(Series::line(&label(load), hue, bins.map(|[gap, density]| (gap / height, density * height))));
    }
    let chart = |x: Axis, y: Axis, series| Chart::new(vec![Panel { x, y, series, ..Panel::default() }]);
    pressures.retain(|series: &Series| !series.points.is_empty());
    let of_pressure = chart(Axis::linear("pressure *p*/(*E*\\**g*)"), Axis::log("density × *E*\\**g*"), pressures);
    files.extend(of_pressure.save(&named(prefix, "pressures"))?);
    gaps.retain(|series: &Series| !series.points.is_empty());
    if !gaps.is_empty() {
        let of_gap = chart(Axis::log("gap / *h*_{rms}"), Axis::log("density × *h*_{rms}"), gaps);
        files.extend(of_gap.save(&named(prefix, "gaps"))?);
    }
    let (side, power) = (sides(grid, unit), if grid.is_line() { 1 } else { 2 });
    let spectra = chosen.iter().enumerate().filter_map(|(hue, &load)| {
        let bins = gathered.states[load]
            .spectrum()?
            .iter()
            .filter(|bin| bin[1] > 0.0)
            .map(|bin| (bin[0] / side.factor, bin[1] / report.head.e_star.powi(2) * side.factor.powi(power)));
        Some(Series::line(&label(load), hue, bins))
    });
    let spectra: Vec<Series> = spectra.filter(|series| !series.points.is_empty()).collect();
    if !spectra.is_empty() {
        let raised = if power == 1 { String::new() } else { format!("^{power}") };
        let x = Axis::log(&format!("wavenumber *q* / (rad/{})", side.name));
        let y = Axis::log(&format!("spectrum of *p*/*E*\\* / {}{raised}", side.name));
        files.extend(chart(x, y, spectra).save(&named(prefix, "spectrum"))?);
    }
    Ok(files)
}
