//! The figures of a surface: map, profile, spectrum.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use gfmd_field::Grid;
use gfmd_plot::{Axis, Chart, Map, Mark, Panel, Series};
use gfmd_surface::RadialBin;
use ndarray::Array2;

use super::{Report, Window};
use gfmd_report::figures::{length, named, short, sides};
use gfmd_run::failure::Failure;

/// The largest number of points that a line is drawn with; longer profiles are thinned to lowest and highest values.
const MOST_POINTS: usize = 4000;

/// The ratio of the whole range to that without outliers from which on the colours of a map leave them out.
const FAR: f64 = 2.0;

/// Draws `PREFIX-map` (not of a profile), `PREFIX-profile` and `PREFIX-spectrum`.
pub(super) fn draw(
    prefix: &Path,
    heights: &Array2<f64>,
    grid: &Grid,
    spectrum: &[RadialBin],
    report: &Report,
) -> Result<Vec<PathBuf>, Failure> {
    let unit = report.unit.as_deref().unwrap_or("length");
    let mut files = Vec::new();
    if !grid.is_line() {
        let values: Vec<f64> = heights.iter().copied().collect();
        let (side, height) = (sides(grid, unit), length(unit, values.iter().fold(0.0, |a: f64, b| a.max(b.abs()))));
        let values: Vec<f64> = values.iter().map(|value| value * height.factor).collect();
        let cell = grid.lengths().map(|length| length * side.factor);
        let mut map = Map::new(&values, grid.points(), cell, &format!("height *h* / {}", height.name));
        map.x = format!("*x* / {}", side.name);
        map.y = format!("*y* / {}", side.name);
        map.range = without_outliers(&values);
        files.extend(map.save(&named(prefix, "map"))?);
    }
    files.extend(profile(heights, grid, unit).save(&named(prefix, "profile"))?);
    if let Some(chart) = spectrum_chart(grid, spectrum, report, unit) {
        files.extend(chart.save(&named(prefix, "spectrum"))?);
    }
    Ok(files)
}

/// The range of all but a thousandth of the values at either end, if the others lie far beyond it.
fn without_outliers(values: &[f64]) -> Option<[f64; 2]> {
    let mut sorted = values.to_vec();
    let beyond = values.len() / 1000;
    let (least, most) = (beyond, values.len() - 1 - beyond);
    let low = *sorted.select_nth_unstable_by(least, f64::total_cmp).1;
    let high = *sorted.select_nth_unstable_by(most, f64::total_cmp).1;
    let whole = values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &value| [a.min(value), b.max(value)]);
    (high > low && whole[1] - whole[0] > FAR * (high - low)).then_some([low, high])
}

/// The heights along the row of points through the middle.
fn profile(heights: &Array2<f64>, grid: &Grid, unit: &str) -> Chart {
    let row = grid.points()[1] / 2;
    let spacing = grid.spacing();
    let column = heights.column(row);
    let step = (2 * column.len()).div_ceil(MOST_POINTS).max(1);
    let line = column.iter().copied().enumerate().collect::<Vec<_>>();
    let ends = |part: &[(usize, f64)]| -> Vec<(usize, f64)> {
        let lowest = part.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
        let highest = part.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
        let mut both: Vec<_> = lowest.into_iter().chain(highest).collect();
        both.sort_by_key(|(index, _)| *index);
        both.dedup();
        both
    };
    let side = sides(grid, unit);
    let read = length(unit, column.iter().fold(0.0, |largest: f64, height| largest.max(height.abs())));
    let points = line.chunks(step).flat_map(ends);
    let points = points.map(|(i, height)| (i as f64 * spacing[0] * side.factor, height * read.factor));
    let place = short(row as f64 * spacing[1] * side.factor);
    let title = if grid.is_line() { String::new() } else { format!("*y* = {place} {}", side.name) };
    Chart::new(vec![Panel {
        title,
        x: Axis::linear(&format!("*x* / {}", side.name)),
        y: Axis::linear(&format!("height *h* / {}", read.name)),
        series: vec![Series::line("", 0, points)],
        ..Panel::default()
    }])
}

/// The radially averaged spectrum with the wavelengths that the points resolve and the fitted power law; `None` if no
/// mode has power.
fn spectrum_chart(grid: &Grid, spectrum: &[RadialBin], report: &Report, unit: &str) -> Option<Chart> {
    let with_power = spectrum.iter().filter(|bin| bin.density > 0.0);
    let points: Vec<(f64, f64)> = with_power.map(|bin| (bin.wavenumber, bin.density)).collect();
    let highest = points.iter().map(|point| point.1).fold(0.0, f64::max);
    // Rounding of a spectrum with a cut-off is not shown.
    let points: Vec<(f64, f64)> = points.into_iter().filter(|point| point.1 > 1e-16 * highest).collect();
    let lowest = points.iter().map(|point| point.1).fold(f64::INFINITY, f64::min);
    if points.is_empty() {
        return None;
    }
    let label = match report.window {
        Window::None => "spectrum",
        Window::Hann => "spectrum, Hann window",
    };
    let mut series = vec![Series::line(label, 0, points)];
    let at = |wavelength: f64| [(TAU / wavelength, lowest), (TAU / wavelength, highest)];
    if let Some(scan) = &report.scan {
        let [longest, shortest] = scan.resolves;
        let words = format!("resolved: {} to {} {unit}", short(longest), short(shortest));
        series.push(Series { mark: Mark::Dashes, ..Series::line(&words, 1, at(longest)) });
        series.push(Series { mark: Mark::Dashes, ..Series::line("", 1, at(shortest)) });
    }
    if let Some(hurst) = report.hurst {
        series.extend(power_law(grid, spectrum, report.hurst_range, hurst));
    }
    let power = if grid.is_line() { 3 } else { 4 };
    let name = if grid.is_line() { "*C*^{1D}" } else { "*C*^{2D}" };
    Some(Chart::new(vec![Panel {
        x: Axis::log(&format!("wavenumber *q* / (rad/{unit})")),
        y: Axis::log(&format!("{name} / {unit}^{power}")),
        series,
        ..Panel::default()
    }]))
}

/// The power law of a Hurst exponent through the mean logarithm of the density in the range of the fit.
fn power_law(grid: &Grid, spectrum: &[RadialBin], [longest, shortest]: [f64; 2], hurst: f64) -> Option<Series> {
    let exponent = if grid.is_line() { 1.0 + 2.0 * hurst } else { 2.0 + 2.0 * hurst };
    let [from, to] = [TAU / longest, TAU / shortest];
    let inside = |bin: &&RadialBin| bin.density > 0.0 && (from..=to).contains(&bin.wavenumber);
    let (count, sum) = spectrum
        .iter()
        .filter(inside)
        .map(|bin| bin.density.ln() + exponent * bin.wavenumber.ln())
        .fold((0_usize, 0.0), |(count, sum), value| (count + 1, sum + value));
    if count == 0 {
        return None;
    }
    let factor = (sum / count as f64).exp();
    let line = [from, to].map(|q| (q, factor * q.powf(-exponent)));
    Some(Series { mark: Mark::Dashes, ..Series::line(&format!("*H* = {hurst:.2}"), 3, line) })
}
