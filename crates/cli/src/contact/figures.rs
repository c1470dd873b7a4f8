//! The figures of a contact.

use std::path::{Path, PathBuf};

use gfmd_field::Grid;
use gfmd_measure::theory::{ElastoplasticArea, persson_pressure};
use gfmd_plot::{Axis, Below, Chart, Mark, Panel, Point, Series};
use ndarray::{Array2, ArrayView2};

use super::Report;
use super::series::Gathered;
use super::statistics::patches;
use crate::failure::Failure;
use crate::figures::{Drawn, area_chart, draw_pressure, field, named, theories};
use crate::hardness::GivenHardness;
use crate::source::Surface;

/// Draws `PREFIX-map` of the last load, and `PREFIX-area` if there are several loads of a hard wall. `variance` is that of the
/// pressure in full contact.
pub(super) fn draw(
    prefix: &Path,
    report: &Report,
    grid: &Grid,
    pressure: &Array2<f64>,
    variance: f64,
) -> Result<Vec<PathBuf>, Failure> {
    let unit = report.unit.as_deref().unwrap_or("length");
    let mut files = draw_pressure(&named(prefix, "map"), grid, pressure, report.e_star, unit)?;
    if report.loads.len() > 1 && report.loads.iter().all(|load| load.law.is_none()) {
        let loads = report.loads.iter().map(|load| [load.p_star, load.area_fraction, load.area_fraction_corrected]);
        let mut chart = area(&loads.collect::<Vec<_>>(), grid.is_line());
        if let (Some(panel), Some(GivenHardness::Number(hardness))) = (chart.panels.first_mut(), &report.hardness) {
            // Without the hardness Persson's line hides below that with it.
            panel.series.retain(|series| series.label != "Persson");
            panel.series.extend(plastic(report, *hardness, variance));
        }
        files.extend(chart.save(&named(prefix, "area"))?);
    }
    Ok(files)
}

/// Draws `PREFIX-lower-map` of the last load.
pub(super) fn lower(
    prefix: &Path,
    report: &Report,
    grid: &Grid,
    pressure: &Array2<f64>,
) -> Result<Vec<PathBuf>, Failure> {
    let unit = report.unit.as_deref().unwrap_or("length");
    draw_pressure(&named(prefix, "lower-map"), grid, pressure, report.e_star, unit)
}

/// The points at the hardness, and both areas of Persson's theory with a hardness, against the reduced pressure.
fn plastic(report: &Report, hardness: f64, variance: f64) -> [Series; 3] {
    let unit = report.e_star * report.rms_gradient;
    let loads = || report.loads.iter().map(|load| load.p_star);
    let (lowest, highest) = (loads().fold(f64::INFINITY, f64::min), loads().fold(0.0, f64::max));
    let curve = |part: fn(&ElastoplasticArea) -> f64| {
        let pressures = (0..=80).map(|i| lowest * (highest / lowest).powf(f64::from(i) / 80.0));
        let areas = pressures.map(move |p| (p, part(&ElastoplasticArea::new(p * unit, variance, hardness))));
        areas.filter(|(_, area)| *area > 0.0).collect::<Vec<_>>()
    };
    let found = report.loads.iter().filter_map(|load| Some(Point::new(load.p_star, load.plastic_fraction?)));
    let found = found.filter(|point| point.y > 0.0);
    [
        Series { mark: Mark::JoinedPoints, ..Series::points("points at the hardness", 2, found.collect()) },
        Series::line("Persson with the hardness", 3, curve(ElastoplasticArea::total)),
        Series { mark: Mark::Dashes, ..Series::line("its points at the hardness", 3, curve(|area| area.plastic)) },
    ]
}

/// The contact area, counted and corrected, against the reduced pressure of loads, which are given in this order: reduced
/// pressure, area, corrected area.
pub(super) fn area(loads: &[[f64; 3]], is_line: bool) -> Chart {
    let column = |k: usize| loads.iter().map(|load| Point::new(load[0], load[k])).collect();
    let mut series = vec![Series { mark: Mark::JoinedPoints, ..Series::points("counted points", 0, column(1)) }];
    if !is_line {
        let label = "perimeter corrected".into();
        series.push(Series { label, hue: 1, mark: Mark::HollowPoints, points: column(2) });
        let p_star = || loads.iter().map(|load| load[0]);
        series.extend(theories(p_star().fold(f64::INFINITY, f64::min), p_star().fold(0.0, f64::max)));
    }
    area_chart(series)
}

/// The largest number of loads whose distributions are drawn.
const MOST_LOADS: usize = 4;

/// The decades of a logarithmic map below its largest value.
const DECADES: f64 = 8.0;

/// The map of a flux on a logarithmic scale.
fn flux(surface: &Surface, flux: ArrayView2<f64>, axis: &str) -> LogMap {
    let highest = flux.iter().copied().fold(0.0, f64::max).log10();
    let least = highest - DECADES;
    LogMap {
        values: flux.iter().map(|flux| flux.log10().max(least)).collect(),
        range: [least, highest],
        label: format!("log_{{10}} of the flux along *{axis}*"),
        grid: surface.grid,
        unit: surface.unit().into(),
    }
}

/// A map of logarithms.
struct LogMap {
    values: Vec<f64>,
    range: [f64; 2],
    label: String,
    grid: Grid,
    unit: String,
}

impl LogMap {
    fn save(&self, stem: &Path) -> Result<Vec<PathBuf>, Failure> {
        let mut drawn = field(&self.grid, &self.values, &self.label, &self.unit);
        if let Drawn::Map(map) = &mut drawn {
            map.below = Some(Below { threshold: self.range[0], label: "none".into() });
            map.range = Some(self.range);
        }
        drawn.save(stem)
    }
}

/// Draws what `--statistics` and `--flow` have measured: `PREFIX-patches` and `PREFIX-flow` of the last load,
/// `PREFIX-pressures`, `PREFIX-gaps` and `PREFIX-spectrum` of up to four loads. `variance` is that of the pressure in full contact.
pub(super) fn measured(
    prefix: &Path,
    report: &Report,
    surface: &Surface,
    pressure: &Array2<f64>,
    gathered: &Gathered,
    variance: f64,
) -> Result<Vec<PathBuf>, Failure> {
    let (grid, unit) = (&surface.grid, surface.unit());
    let mut files = Vec::new();
    if let Some(flow) = &gathered.flow
        && let Some(path) = flow.paths.iter().flatten().next()
    {
        let axis = if flow.paths[0].is_some() { "x" } else { "y" };
        files.extend(flux(surface, path.flux.view(), axis).save(&named(prefix, "flow"))?);
    }
    if gathered.loads.is_empty() {
        return Ok(files);
    }
    if !grid.is_line() {
        let found = patches(surface, pressure.view());
        // Neighbours in the order of their numbers get distant colours, by steps of the golden section.
        let colour =
            |label: &u32| if *label == 0 { 0.0 } else { 0.05 + 0.95 * (f64::from(*label) * 0.618_033_988_75).fract() };
        let values: Vec<f64> = found.labels.iter().map(colour).collect();
        let mut drawn = field(grid, &values, &format!("{} patches, told apart by colour", found.patches.len()), unit);
        if let Drawn::Map(map) = &mut drawn {
            map.below = Some(Below { threshold: 0.0, label: "no contact".into() });
            (map.range, map.numbers) = (Some([0.0, 1.0]), false);
        }
        files.extend(drawn.save(&named(prefix, "patches"))?);
    }
    let count = gathered.loads.len();
    let drawn = count.min(MOST_LOADS);
    let chosen: Vec<usize> =
        (0..drawn).map(|k| if drawn == 1 { count - 1 } else { k * (count - 1) / (drawn - 1) }).collect();
    let scale = report.e_star * report.rms_gradient;
    let label = |load: usize| format!("*p*\\* = {:.3}", report.loads[load].p_star);
    let (mut pressures, mut gaps) = (Vec::new(), Vec::new());
    for (hue, &load) in chosen.iter().enumerate() {
        let found = &gathered.loads[load];
        let bins = found.pressure.middles.iter().zip(&found.pressure.densities);
        let positive = bins.filter(|(_, density)| **density > 0.0);
        let densities = positive.map(|(p, density)| (p / scale, density * scale));
        pressures.push(Series::line(&label(load), hue, densities));
        let mean = report.loads[load].mean_pressure;
        let theory = found.pressure.middles.iter().map(|p| (p / scale, persson_pressure(*p, mean, variance) * scale));
        let theory: Vec<(f64, f64)> = theory.filter(|(_, density)| *density > 1e-6).collect();
        let name = if hue == 0 { "Persson" } else { "" };
        pressures.push(Series { mark: Mark::Dashes, ..Series::line(name, hue, theory) });
        let bins = found.gap.middles.iter().zip(&found.gap.densities).filter(|(_, density)| **density > 0.0);
        let height = report.rms_height;
        gaps.push(Series::line(&label(load), hue, bins.map(|(gap, density)| (gap / height, density * height))));
    }
    let chart = |x: Axis, y: Axis, series| Chart::new(vec![Panel { x, y, series, ..Panel::default() }]);
    pressures.retain(|series: &Series| !series.points.is_empty());
    let of_pressure = chart(Axis::linear("pressure *p*/(*E*\\**g*)"), Axis::log("density × *E*\\**g*"), pressures);
    files.extend(of_pressure.save(&named(prefix, "pressures"))?);
    gaps.retain(|series: &Series| !series.points.is_empty());
    if !gaps.is_empty() {
        let of_gap = chart(Axis::linear("gap / *h*_{rms}"), Axis::log("density × *h*_{rms}"), gaps);
        files.extend(of_gap.save(&named(prefix, "gaps"))?);
    }
    let spectra = chosen.iter().enumerate().filter_map(|(hue, &load)| {
        let bins = gathered.loads[load]
            .spectrum()?
            .iter()
            .filter(|bin| bin[1] > 0.0)
            .map(|bin| (bin[0], bin[1] / report.e_star.powi(2)));
        Some(Series::line(&label(load), hue, bins))
    });
    let spectra: Vec<Series> = spectra.filter(|series| !series.points.is_empty()).collect();
    if !spectra.is_empty() {
        let x = Axis::log(&format!("wavenumber *q* × {unit}"));
        files.extend(chart(x, Axis::log("spectrum of *p*/*E*\\*"), spectra).save(&named(prefix, "spectrum"))?);
    }
    Ok(files)
}
