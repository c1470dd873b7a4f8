//! kappa of surfaces with H = 1 against Nayak's parameter, and the area on finer grids.

use std::f64::consts::{LN_2, PI};
use std::fmt::Write;

use gfmd_input::failure::Failure;
use gfmd_plot::{Axis, Chart, Mark, Panel, Point as Dot, Series};

use super::kappa::HURSTS;
use super::summary::{Point, Summaries};

/// Returns Nayak's parameter of an isotropic surface with a spectrum ∝ q^(-2(1+H)) over a ratio `band` of wavelengths.
fn nayak(hurst: f64, band: f64) -> f64 {
    let moment = |power: f64| {
        let exponent = power - 2.0 * hurst;
        if exponent.abs() < 1e-9 { band.ln() } else { (band.powf(exponent) - 1.0) / exponent }
    };
    1.5 * moment(0.0) * moment(4.0) / moment(2.0).powi(2)
}

/// Returns kappa (perimeter corrected) on the finest grids of each ratio of wavelengths: H, 1/eps_f, Nayak's parameter,
/// cell.
fn by_band(summaries: &Summaries) -> Result<Vec<(f64, f64, f64, Point)>, Failure> {
    let powers = summaries.read("hurst")?;
    let mut rows = Vec::new();
    for hurst in HURSTS {
        let mut cells: Vec<&Point> =
            powers.points.iter().filter(|at| at.hurst == hurst && at.eps_t_inv == 4.0 && at.eps_c_inv == 4.0).collect();
        cells.sort_by(|one, other| one.eps_f_inv.total_cmp(&other.eps_f_inv));
        rows.extend(cells.into_iter().map(|at| (hurst, at.eps_f_inv, nayak(hurst, at.eps_f_inv), at.clone())));
    }
    Ok(rows)
}

pub(super) fn nayak_figure(summaries: &Summaries) -> Result<String, Failure> {
    let rows = by_band(summaries)?;
    let series = HURSTS.into_iter().enumerate().map(|(hue, hurst)| {
        let of = rows.iter().filter(|row| row.0 == hurst);
        let points = of.filter_map(|(_, _, alpha, cell)| {
            Some(Dot::with_error(*alpha, cell.kappa_corrected?, cell.kappa_corrected_sem.unwrap_or(0.0)))
        });
        Series { mark: Mark::JoinedPoints, ..Series::points(&format!("*H* = {hurst}"), hue, points.collect()) }
    });
    let (x, y) = (Axis::log("Nayak's parameter *α*"), Axis::linear("*κ* at *p*\\* = 0.02, perimeter corrected"));
    Ok(Chart::new(vec![Panel { x, y, series: series.collect(), ..Panel::default() }]).svg()?)
}

/// Returns the table of kappa of surfaces with H = 1 against the ratio of their wavelengths.
pub(super) fn one(summaries: &Summaries) -> Result<String, Failure> {
    let sweep = summaries.read("one")?;
    let mut loads: Vec<f64> = sweep.points.iter().map(|point| point.p_star).collect();
    loads.sort_by(f64::total_cmp);
    loads.dedup();
    let mut bands: Vec<f64> = sweep.points.iter().map(|point| point.eps_f_inv).collect();
    bands.sort_by(f64::total_cmp);
    bands.dedup();
    let head = loads.iter().map(|load| format!("p\\* = {load}")).collect::<Vec<_>>().join(" | ");
    let mut text = format!("| 1/ε_f | {head} |\n|---|{}\n", "---|".repeat(loads.len()));
    for band in bands {
        let cell = |load: &f64| {
            let found = sweep.points.iter().find(|point| point.eps_f_inv == band && point.p_star == *load);
            found.map_or_else(|| "–".into(), Point::shown_corrected)
        };
        let cells: Vec<String> = loads.iter().map(cell).collect();
        let _ = writeln!(text, "| {band} | {} |", cells.join(" | "));
    }
    Ok(text)
}

/// Returns the table of the area of the same surfaces on finer and finer grids, counted and perimeter corrected.
pub(super) fn edge(summaries: &Summaries) -> Result<String, Failure> {
    let sweep = summaries.read("edge")?;
    let mut cells: Vec<&Point> = sweep.points.iter().collect();
    cells.sort_by(|one, other| one.eps_c_inv.total_cmp(&other.eps_c_inv));
    let mut text =
        String::from("| n | 1/ε_c | counted | corrected | limit, from each contact |\n|---|---|---|---|---|\n");
    for cell in cells {
        let counted = cell.kappa * cell.p_star;
        let corrected = cell.kappa_corrected.unwrap_or(f64::NAN) * cell.p_star;
        // The perimeter correction is (π − 1 + ln 2)/24 of a pixel for each boundary link.
        let strip = counted - corrected;
        let narrow = strip / counted * 24.0 / (PI - 1.0 + LN_2);
        let fitted = counted - (0.858 + 0.021 * narrow.min(3.0).powi(2)) * strip;
        let _ = writeln!(text, "| {} | {} | {counted:.4} | {corrected:.4} | {fitted:.4} |", cell.n, cell.eps_c_inv);
    }
    Ok(text)
}
