//! Poisson's ratio, height, gradient, methods, roll-off, profiles.

use std::fmt::Write;

use gfmd_input::failure::Failure;
use gfmd_plot::{Axis, Chart, Mark, Panel, Point, Series};

use super::summary::{Summaries, Summary};

const HURST: [&str; 2] = ["0.0", "0.8"];
const HEIGHTS: [&str; 5] = ["1.0", "0.5", "0.25", "0.1", "0.05"];
const RATIOS: [&str; 3] = ["0.0", "0.33", "0.5"];

fn slab(summaries: &Summaries, height: &str, hurst: &str, ratio: &str) -> Result<Summary, Failure> {
    summaries.read(&format!("axes/slab{height}-h{hurst}-nu{ratio}"))
}

pub(super) fn slab_figure(summaries: &Summaries) -> Result<String, Failure> {
    let mut panels = Vec::new();
    for hurst in HURST {
        let mut series = Vec::new();
        for (hue, ratio) in RATIOS.into_iter().enumerate() {
            let point = |height: &&str| -> Result<Point, Failure> {
                let summary = slab(summaries, height, hurst, ratio)?;
                let cell = summary.cell()?;
                let x = height.parse().map_err(|_| Failure::refused(format!("{height} is no height")))?;
                Ok(Point::with_error(x, cell.kappa, cell.kappa_sem.unwrap_or(0.0)))
            };
            let points = HEIGHTS.iter().map(point).collect::<Result<_, _>>()?;
            series.push(Series { mark: Mark::JoinedPoints, ..Series::points(&format!("*ν* = {ratio}"), hue, points) });
        }
        let (x, y) = (Axis::log("height / cell length"), Axis::linear("*κ* at *p*\\* = 0.02"));
        panels.push(Panel { title: format!("*H* = {hurst}"), x, y, series, ..Panel::default() });
    }
    Ok(Chart { share_y: false, ..Chart::new(panels) }.svg()?)
}

pub(super) fn surfaces(summaries: &Summaries) -> Result<String, Failure> {
    let rows = [
        ("spectrum (psd)", "0.3", "method-psd-h0.3"),
        ("successive random addition (sra)", "0.3", "method-sra-h0.3"),
        ("random midpoint displacement (rmd)", "0.3", "method-rmd-h0.3"),
        ("spectrum (psd)", "0.8", "method-psd-h0.8"),
        ("successive random addition (sra)", "0.8", "method-sra-h0.8"),
        ("random midpoint displacement (rmd)", "0.8", "method-rmd-h0.8"),
        ("roll-off at half of the longest wavelength", "0.8", "roll-off0.5-h0.8"),
        ("roll-off at a quarter of it", "0.8", "roll-off0.25-h0.8"),
        ("spectrum (psd)", "0", "half-space-h0.0-nu0.0"),
        ("exponent as printed in the thesis, 2(1 + H)", "0", "method-printed-h0.0"),
    ];
    let mut text = String::from("| surface | H | κ | perimeter corrected |\n|---|---|---|---|\n");
    for (what, hurst, name) in rows {
        let summary = summaries.read(&format!("axes/{name}"))?;
        let cell = summary.cell()?;
        let corrected = cell.kappa_corrected.map_or_else(String::new, |kappa| format!("{kappa:.3}"));
        let _ = writeln!(text, "| {what} | {hurst} | {} | {corrected} |", cell.shown());
    }
    Ok(text)
}

const PROFILES: [&str; 3] = ["0.0", "0.5", "0.8"];

/// Returns the reduced pressures of a summary in ascending order.
fn loads(summary: &Summary) -> Vec<f64> {
    let mut loads: Vec<f64> = summary.points.iter().map(|point| point.p_star).collect();
    loads.sort_by(f64::total_cmp);
    loads.dedup();
    loads
}

pub(super) fn lines(summaries: &Summaries) -> Result<String, Failure> {
    let mut text = String::new();
    for hurst in PROFILES {
        let summary = summaries.read(&format!("axes/line-h{hurst}"))?;
        let loads = loads(&summary);
        if text.is_empty() {
            let head = loads.iter().map(|load| format!("p\\* = {load}")).collect::<Vec<_>>().join(" | ");
            let _ = writeln!(text, "| H | 1/ε_f | {head} |\n|---|---|{}", "---|".repeat(loads.len()));
        }
        let mut bands: Vec<f64> = summary.points.iter().map(|point| point.eps_f_inv).collect();
        bands.sort_by(f64::total_cmp);
        bands.dedup();
        // The figure has all ratios.
        for band in bands.into_iter().filter(|band| [64.0, 4096.0].contains(band)) {
            let cell = |load: &f64| {
                let found = summary.points.iter().find(|point| point.eps_f_inv == band && point.p_star == *load);
                found.map_or_else(|| "–".into(), super::summary::Point::shown)
            };
            let cells: Vec<String> = loads.iter().map(cell).collect();
            let _ = writeln!(text, "| {hurst} | {band} | {} |", cells.join(" | "));
        }
    }
    Ok(text)
}

pub(super) fn line_figure(summaries: &Summaries) -> Result<String, Failure> {
    let mut panels = Vec::new();
    for hurst in PROFILES {
        let summary = summaries.read(&format!("axes/line-h{hurst}"))?;
        let mut series = Vec::new();
        for (hue, load) in loads(&summary).into_iter().enumerate() {
            let points = summary.points.iter().filter(|point| point.p_star == load);
            let points =
                points.map(|point| Point::with_error(point.eps_f_inv, point.kappa, point.kappa_sem.unwrap_or(0.0)));
            let points = points.collect();
            series
                .push(Series { mark: Mark::JoinedPoints, ..Series::points(&format!("*p*\\* = {load}"), hue, points) });
        }
        let (x, y) = (Axis::log("1/*ε*_f"), Axis::linear("*κ* of profiles"));
        panels.push(Panel { title: format!("*H* = {hurst}"), x, y, series, ..Panel::default() });
    }
    Ok(Chart::new(panels).svg()?)
}
