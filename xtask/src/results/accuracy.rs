//! Estimated grid errors of contacts compared with the true errors.

use std::fmt::Write as _;

use gfmd_input::failure::Failure;
use gfmd_plot::{Axis, Chart, Panel, Point, Series};

use super::summary::Summaries;
use crate::accuracy::Coverage;

/// Modes in the table, of random surfaces; the figure and the summary have all.
const SHOWN: [&str; 3] = ["estimate", "free", "refine"];

/// Fewest contacts with an error of a quantity in the table.
const FEWEST: usize = 10;

/// Formats the fraction of contacts with the exact value inside the interval, followed by the smallest fraction of all
/// groups of surfaces and loads.
fn share(groups: &std::collections::BTreeMap<String, Coverage>) -> String {
    let part = |found: &Coverage| found.covered as f64 / found.told as f64;
    let all = groups.get("all").map_or(f64::NAN, part);
    let least = groups.iter().filter(|(_, found)| found.told > 0).min_by(|a, b| part(a.1).total_cmp(&part(b.1)));
    least.map_or_else(|| "–".into(), |(_, found)| format!("{all:.3} ({:.3})", part(found)))
}

/// Returns the quantity with the same relative errors as `name`: a multiple of it, or its value along the other axis.
fn same_as(name: &str) -> Option<&'static str> {
    match name {
        "kappa" => Some("area_fraction"),
        "conductance" => Some("stiffness"),
        "flow_yy" => Some("flow_xx"),
        _ => None,
    }
}

/// Returns the table of the quantities of random surfaces, for each mode.
pub(super) fn table(summaries: &Summaries) -> Result<String, Failure> {
    let report = summaries.accuracy()?;
    let mut text = String::from(
        "| number | told | error of the number | of its limit | limit within its error | width |\n\
         |---|---|---|---|---|---|\n",
    );
    for (mode, numbers) in report.modes.iter().filter(|(mode, _)| SHOWN.contains(&mode.as_str())) {
        let _ = writeln!(text, "| **{mode}** | | | | | |");
        for (name, groups) in numbers {
            let Some(all) = groups.get("all").filter(|all| all.told >= FEWEST) else { continue };
            if same_as(name).is_some_and(|other| numbers.contains_key(other)) {
                continue;
            }
            let Coverage { told, untold, number_error, limit_error, width, .. } = all;
            let count = told + untold;
            let percent = |error: &f64| format!("{:.2} %", 100.0 * error);
            let _ = writeln!(
                text,
                "| {name} | {told}/{count} | {} | {} | {} | {width:.1} |",
                percent(number_error),
                if *limit_error < 1e-4 { format!("{limit_error:.0e}") } else { percent(limit_error) },
                share(groups)
            );
        }
    }
    Ok(text)
}

/// Draws the error of the limits against the error of the quantities.
pub(super) fn figure(summaries: &Summaries) -> Result<String, Failure> {
    let report = summaries.accuracy()?;
    let mut series: Vec<Series> = (report.modes.iter().enumerate())
        .map(|(hue, (mode, numbers))| {
            let all = numbers.values().filter_map(|groups| groups.get("all")).filter(|all| all.told > 0);
            Series::points(mode, hue, all.map(|all| Point::new(all.number_error, all.limit_error)).collect())
        })
        .collect();
    series.push(Series::line("equal", report.modes.len(), [1e-4, 0.2].map(|error| (error, error))));
    let (x, y) = (Axis::log("error of the number"), Axis::log("error of its limit"));
    Ok(Chart::new(vec![Panel { x, y, series, ..Panel::default() }]).svg()?)
}
