//! Protocol of the thesis: table 5.2 and figure 5.1.

use std::fmt::Write;

use gfmd_input::failure::Failure;
use gfmd_plot::{Axis, Chart, Mark, Panel, Point, Series};

use super::summary::{Protocol, Summaries, Summary, or_none};

/// Cells that the thesis extrapolates, with its C_c, alpha_c, C_f, alpha_f, kappa_TFC.
const PRINTED: [([f64; 2], [f64; 5]); 2] = [
    ([256.0, 4.0], [2.640_09, 0.991_761, 10.24, 1.0, 2.2]),
    ([256.0, 8.0], [2.640_09, 0.991_761, 9.310_12, 0.965_235, 2.0]),
];

pub(super) fn table(summaries: &Summaries) -> Result<String, Failure> {
    let summary = summaries.read("source")?;
    let mut text = String::from(
        "| 1/ε_t, 1/ε_f, 1/ε_c | κ_sim | C_c | α_c | C_f | α_f | κ_TFC |\n|---|---|---|---|---|---|---|\n",
    );
    for (cell, [c, alpha_c, f, alpha_f, kappa]) in PRINTED {
        let undone = kappa + c * cell[1].powf(-alpha_c) + f * cell[0].powf(-alpha_f);
        let _ = writeln!(
            text,
            "| thesis: 2, {}, {} | {undone:.3} (undone) | {c} | {alpha_c} | {f} | {alpha_f} | {kappa} |",
            cell[0], cell[1]
        );
    }
    for protocol in &summary.protocol {
        let [t, f, c] = protocol.reference;
        let part = |axis: &str, of: fn(&super::summary::Arm) -> Option<&super::summary::Number>| {
            or_none(protocol.arm(axis).and_then(of))
        };
        let _ = writeln!(
            text,
            "| {t}, {f}, {c} | {} | {} | {} | {} | {} | {} |",
            protocol.kappa_sim.shown(),
            part("c", |arm| arm.coefficient.as_ref()),
            part("c", |arm| arm.exponent.as_ref()),
            part("f", |arm| arm.coefficient.as_ref()),
            part("f", |arm| arm.exponent.as_ref()),
            or_none(protocol.kappa_tfc.as_ref())
        );
    }
    for protocol in summary.protocol.iter() {
        let [t, f, c] = protocol.reference;
        let found = [("c", "ε_c"), ("f", "ε_f")].into_iter().filter_map(|(axis, letter)| limit(protocol, axis, letter));
        let _ = writeln!(text, "\nAbout ({t}, {f}, {c}): {}.", found.collect::<Vec<_>>().join("; "));
    }
    Ok(text)
}

/// Describes the limit along one axis, and the finest cell with its prediction from the others.
fn limit(protocol: &Protocol, axis: &str, letter: &str) -> Option<String> {
    let arm = protocol.arm(axis)?;
    let (finest, kappa) = (arm.eps_inv.last()?, arm.kappa.last()?);
    let mut text = format!("{letter} → 0: {}", or_none(arm.limit.as_ref()));
    if let Some(predicted) = &arm.predicted {
        let _ = write!(text, ", 1/{letter} = {finest}: {}, from the others {}", kappa.shown(), predicted.shown());
    }
    Some(text)
}

/// Returns the table of all cells of the sweep.
pub(super) fn cells(summaries: &Summaries) -> Result<String, Failure> {
    let Summary { points, .. } = summaries.read("source")?;
    let mut text = String::from("| 1/ε_t | 1/ε_f | n | 1/ε_c = 2 | 4 | 8 | 16 |\n|---|---|---|---|---|---|---|\n");
    let mut rows: Vec<[f64; 2]> = points.iter().map(|point| [point.eps_t_inv, point.eps_f_inv]).collect();
    rows.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    rows.dedup();
    for [t, f] in rows {
        let of_row = || points.iter().filter(|point| [point.eps_t_inv, point.eps_f_inv] == [t, f]);
        let largest = of_row().map(|point| point.n).max().unwrap_or(0);
        let cells = [2.0, 4.0, 8.0, 16.0].map(|c| {
            let cell = of_row().find(|point| point.eps_c_inv == c);
            cell.map_or_else(|| "–".into(), super::summary::Point::shown)
        });
        let _ = writeln!(text, "| {t} | {f} | to {largest} | {} |", cells.join(" | "));
    }
    Ok(text)
}

/// Draws figure 5.1: κ against eps_c for each spectral width, and against eps_f for each eps_c.
pub(super) fn figure(summaries: &Summaries) -> Result<String, Failure> {
    let Summary { points, protocol, .. } = summaries.read("source")?;
    let size = points.iter().map(|point| point.eps_t_inv).fold(f64::INFINITY, f64::min);
    let of_size = || points.iter().filter(|point| point.eps_t_inv == size);
    let panel = |along: fn(&super::summary::Point) -> f64,
                 other: fn(&super::summary::Point) -> f64,
                 letters: [&str; 2],
                 axis: &str| {
        let mut values: Vec<f64> = of_size().map(other).collect();
        values.sort_by(f64::total_cmp);
        values.dedup();
        let mut series = Vec::new();
        for (hue, value) in values.into_iter().enumerate() {
            let cells = of_size().filter(|point| other(point) == value);
            let shown =
                cells.map(|point| Point::with_error(along(point).recip(), point.kappa, point.kappa_sem.unwrap_or(0.0)));
            series.push(Series::points(&format!("1/*ε*_{} = {value}", letters[1]), hue, shown.collect()));
            let reference = protocol.iter().find(|one| {
                let [t, f, c] = one.reference;
                t == size && if axis == "c" { f == value } else { c == value }
            });
            let arm = reference.and_then(|one| one.arm(axis));
            if let Some((arm, limit, coefficient, exponent)) =
                arm.and_then(|arm| Some((arm, arm.limit?, arm.coefficient?, arm.exponent?)))
            {
                let coarsest = arm.eps_inv.first().copied().unwrap_or(1.0);
                let line = (0..=80).map(|k| {
                    let eps = f64::from(k) / 80.0 / coarsest;
                    (eps, limit.value + coefficient.value * eps.powf(exponent.value))
                });
                series.push(Series { mark: Mark::Dashes, ..Series::line("", hue, line) });
            }
        }
        let x = Axis::linear(&format!("*ε*_{}", letters[0]));
        Panel { x, y: Axis::linear("*κ*_{sim}"), series, ..Panel::default() }
    };
    let chart = Chart {
        share_y: false,
        ..Chart::new(vec![
            panel(|point| point.eps_c_inv, |point| point.eps_f_inv, ["c", "f"], "c"),
            panel(|point| point.eps_f_inv, |point| point.eps_c_inv, ["f", "c"], "f"),
        ])
    };
    Ok(chart.svg()?)
}
