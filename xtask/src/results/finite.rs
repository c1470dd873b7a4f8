//! Surfaces of finite spectra: what they have besides κ.

use std::fmt::Write as _;

use gfmd_run::failure::Failure;

use super::summary::Summaries;
use crate::finite::{Kind, Known, Numbers};

/// A number with its error, to the second digit of that.
fn with_error(known: Option<Known>) -> String {
    known.map_or_else(
        || "–".into(),
        |[value, error]| {
            let digits = (1.0 - error.log10().floor()).clamp(0.0, 6.0) as usize;
            format!("{value:.digits$} ± {error:.digits$}")
        },
    )
}

/// A row for each kind of surface and load.
fn rows(summaries: &Summaries, loads: fn(&Kind) -> &[Numbers], head: &str) -> Result<String, Failure> {
    let report = summaries.finite()?;
    let mut text = format!("{head}\n|---|---|---|---|---|---|---|\n");
    for kind in &report.kinds {
        for Numbers { load, kappa, gap, stiffness, rms_pressure } in loads(kind) {
            let numbers = [kappa, gap, stiffness, rms_pressure].map(|known| with_error(*known)).join(" | ");
            let _ = writeln!(text, "| {} | {} | {load} | {numbers} |", kind.hurst, kind.eps_f_inv);
        }
    }
    Ok(text)
}

/// Under given reduced pressures.
pub(super) fn reduced(summaries: &Summaries) -> Result<String, Failure> {
    rows(summaries, |kind| &kind.reduced, "| H | 1/ε_f | p\\* | κ | ū/h_rms | K h_rms/p̄ | p_rms/(E\\* ḡ) |")
}

/// Under given loads of the long waves.
pub(super) fn of_long_waves(summaries: &Summaries) -> Result<String, Failure> {
    rows(summaries, |kind| &kind.of_long_waves, "| H | 1/ε_f | P | κ | ū/h_rms | K h_rms/p̄ | p_rms/(E\\* ḡ) |")
}

/// Where contacts begin to percolate, and how high the surfaces are.
pub(super) fn percolation(summaries: &Summaries) -> Result<String, Failure> {
    let mut text = String::from(
        "| H | 1/ε_f | surfaces | h_rms/(λ_l ḡ) | p\\* at percolation | area fraction |\n|---|---|---|---|---|---|\n",
    );
    for Kind { hurst, eps_f_inv, surfaces, height, percolation, .. } in &summaries.finite()?.kinds {
        let [height, load, area] = [*height, percolation[0], percolation[1]].map(|known| with_error(Some(known)));
        let _ = writeln!(text, "| {hurst} | {eps_f_inv} | {surfaces} | {height} | {load} | {area} |");
    }
    Ok(text)
}
