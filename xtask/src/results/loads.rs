//! kappa at light loads, against Nayak's parameter, and of surfaces with H = 1.

use std::fmt::Write;

use gfmd_measure::SelfAffineArea;
use gfmd_plot::{Axis, Chart, Mark, Panel, Point as Dot, Series};
use gfmd_run::failure::Failure;

use super::summary::{Fit, Point, Summaries, Summary};

const HURSTS: [f64; 4] = [0.0, 0.3, 0.5, 0.8];

/// The loads below those of the main sweep, and the two that they have in common.
const LIGHT: [f64; 5] = [0.002, 0.005, 0.01, 0.02, 0.05];

/// kappa_TFC at light loads, with half of the interval of statistical and systematic error together, and the formula.
pub(super) fn light(summaries: &Summaries) -> Result<String, Failure> {
    let low = summaries.read("low")?;
    let head = HURSTS.map(|hurst| format!("H = {hurst} | formula")).join(" | ");
    let mut text = format!("| p\\* | {head} |\n|---|{}\n", "---|".repeat(2 * HURSTS.len()));
    for p_star in LIGHT {
        let mut cells = Vec::new();
        for hurst in HURSTS {
            let wanted = low.fits.iter().find(|fit| fit.hurst == hurst && fit.p_star == p_star && fit.area == "raw");
            let missing = || Failure::Input(format!("low.json has no fit for H = {hurst} at p* = {p_star}"));
            let fit = wanted.ok_or_else(missing)?;
            let half = fit.total_ci95.map_or_else(String::new, |[low, high]| format!(" ± {:.3}", 0.5 * (high - low)));
            let formula = SelfAffineArea::new(hurst).map_or(f64::NAN, |area| area.at(p_star) / p_star);
            cells.push(format!("{:.3}{half} | {formula:.3}", fit.kappa_tfc));
        }
        let _ = writeln!(text, "| {p_star} | {} |", cells.join(" | "));
    }
    Ok(text)
}

/// The errors of kappa_TFC of the main sweep at its first load, one by one.
pub(super) fn budget(summaries: &Summaries) -> Result<String, Failure> {
    const FORMS: [(&str, &str); 5] = [
        ("alpha-f-free", "α_f fitted"),
        ("leading-alpha-f", "α_f = 1 − H"),
        ("without-coarsest-eps-f", "without the largest ε_f"),
        ("without-coarsest-eps-t", "without the largest ε_t"),
        ("corrected-area", "area: perimeter correction in place of the edge"),
    ];
    const MAIN: f64 = 0.02;
    let [main, loose, tight] =
        [summaries.read("composed")?, summaries.read("tolerance-6")?, summaries.read("tolerance-10")?];
    let of = |sweep: &Summary, hurst: f64| -> Result<usize, Failure> {
        let wanted = |fit: &Fit| fit.hurst == hurst && fit.p_star == MAIN && fit.area == "raw";
        let missing = || Failure::Input(format!("a summary has no fit for H = {hurst} at p* = {MAIN}"));
        sweep.fits.iter().position(wanted).ok_or_else(missing)
    };
    let head = HURSTS.map(|hurst| format!("H = {hurst}")).join(" | ");
    let mut text = format!("| error | {head} |\n|---|{}\n", "---|".repeat(HURSTS.len()));
    let mut row = |name: &str, value: &dyn Fn(f64) -> Result<String, Failure>| -> Result<(), Failure> {
        let cells = HURSTS.into_iter().map(value).collect::<Result<Vec<_>, _>>()?;
        let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
        Ok(())
    };
    row("statistical, 95 %", &|hurst| {
        let fit = &main.fits[of(&main, hurst)?];
        Ok(fit.ci95.map_or_else(|| "–".into(), |[low, high]| format!("± {:.4}", 0.5 * (high - low))))
    })?;
    for (form, name) in FORMS {
        row(name, &|hurst| {
            let fit = &main.fits[of(&main, hurst)?];
            let found = fit.alternatives.iter().find(|other| other.form == form);
            Ok(found.map_or_else(|| "–".into(), |other| format!("{:+.4}", other.kappa_tfc - fit.kappa_tfc)))
        })?;
    }
    row("residuals of 1e-6 in place of 1e-10", &|hurst| {
        let [one, other] = [&loose.fits[of(&loose, hurst)?], &tight.fits[of(&tight, hurst)?]];
        Ok(format!("{:+.4}", one.kappa_tfc - other.kappa_tfc))
    })?;
    Ok(text)
}

/// Nayak's parameter of an isotropic surface whose spectrum falls like q^(-2(1+H)) over a ratio `band` of wavelengths.
fn nayak(hurst: f64, band: f64) -> f64 {
    let moment = |power: f64| {
        let exponent = power - 2.0 * hurst;
        if exponent.abs() < 1e-9 { band.ln() } else { (band.powf(exponent) - 1.0) / exponent }
    };
    1.5 * moment(0.0) * moment(4.0) / moment(2.0).powi(2)
}

/// kappa (perimeter corrected) on the finest grids of each ratio of wavelengths: H, 1/eps_f, Nayak's parameter, the cell.
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

pub(super) fn nayak_table(summaries: &Summaries) -> Result<String, Failure> {
    let mut text = String::from("| H | 1/ε_f | Nayak's α | κ |\n|---|---|---|---|\n");
    for (hurst, band, alpha, cell) in by_band(summaries)? {
        let _ = writeln!(text, "| {hurst} | {band} | {alpha:.1} | {} |", cell.shown_corrected());
    }
    Ok(text)
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

/// kappa of surfaces with H = 1 against the ratio of their wavelengths.
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

/// The area of the same surfaces on finer and finer grids, counted, and corrected by its perimeter.
pub(super) fn edge(summaries: &Summaries) -> Result<String, Failure> {
    let sweep = summaries.read("edge")?;
    let mut cells: Vec<&Point> = sweep.points.iter().collect();
    cells.sort_by(|one, other| one.eps_c_inv.total_cmp(&other.eps_c_inv));
    let mut text =
        String::from("| n | 1/ε_c | counted | corrected | with the edge of the fit |\n|---|---|---|---|---|\n");
    for cell in cells {
        let counted = cell.kappa * cell.p_star;
        let corrected = cell.kappa_corrected.unwrap_or(f64::NAN) * cell.p_star;
        let fitted = counted - (0.82 + 0.3 / cell.eps_c_inv) * (counted - corrected);
        let _ = writeln!(text, "| {} | {} | {counted:.4} | {corrected:.4} | {fitted:.4} |", cell.n, cell.eps_c_inv);
    }
    Ok(text)
}
