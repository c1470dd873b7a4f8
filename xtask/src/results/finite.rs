//! Surfaces of finite spectra: properties other than κ.

use std::fmt::Write as _;

use gfmd_input::failure::Failure;

use super::summary::Summaries;
use crate::finite::{Known, Numbers, PRESSURES, SurfaceKind};

/// Hurst exponents, bands and loads in the tables; the file of the summary has all of them.
const HURST: [f64; 2] = [0.0, 0.8];
const BANDS: [usize; 2] = [8, 128];
const REDUCED: [f64; 3] = [0.01, 0.1, 0.5];
const ABOVE: [f64; 2] = [0.01, 0.1];
const OF_LONG_WAVES: [f64; 2] = [0.1, 1.0];

/// Returns the surfaces in the tables.
fn shown(summaries: &Summaries) -> Result<Vec<SurfaceKind>, Failure> {
    let is_shown = |kind: &SurfaceKind| HURST.contains(&kind.hurst) && BANDS.contains(&kind.eps_f_inv);
    Ok(summaries.finite()?.kinds.into_iter().filter(is_shown).collect())
}

/// Formats a value with its error in units of the last digit, to the second digit of the error.
fn with_error(known: Option<Known>) -> String {
    known.map_or_else(
        || "–".into(),
        |[value, error]| {
            // All surfaces are at the same step of a ramp.
            if error < 1e-9 * value.abs() {
                return format!("{value:.3}");
            }
            let digits = (1.0 - error.log10().floor()).clamp(0.0, 6.0) as usize;
            format!("{value:.digits$}({:.0})", error * 10_f64.powi(digits as i32))
        },
    )
}

/// Returns κ, mean gap, stiffness and pressure of a load as cells of a table.
fn cells(Numbers { kappa, gap, stiffness, rms_pressure, .. }: &Numbers) -> String {
    [kappa, gap, stiffness, rms_pressure].map(|known| with_error(*known)).join(" | ")
}

/// Returns the table for given reduced pressures.
pub(super) fn reduced(summaries: &Summaries) -> Result<String, Failure> {
    let mut text = String::from(
        "| H | 1/ε_f | p\\* | κ | ū/h_rms | K h_rms/p̄ | p_rms/(E\\* ḡ) |\n|---|---|---|---|---|---|---|\n",
    );
    for kind in &shown(summaries)? {
        for load in kind.reduced.iter().filter(|load| REDUCED.contains(&load.load)) {
            let _ = writeln!(text, "| {} | {} | {} | {} |", kind.hurst, kind.eps_f_inv, load.load, cells(load));
        }
    }
    Ok(text)
}

/// Returns the table of the pressure distribution, with Persson's.
pub(super) fn above(summaries: &Summaries) -> Result<String, Failure> {
    let heads = PRESSURES.map(|pressure| format!("p > {pressure} E\\* ḡ")).join(" | ");
    let mut text = format!("| H | 1/ε_f | p\\* | {heads} |\n|---|---|---|{}\n", "---|".repeat(PRESSURES.len()));
    for kind in &shown(summaries)? {
        let loads = kind.reduced.iter().zip(&kind.above);
        for (load, above) in loads.filter(|(load, _)| ABOVE.contains(&load.load)) {
            let cells: Vec<String> = above.iter().map(|known| with_error(Some(*known))).collect();
            let _ = writeln!(text, "| {} | {} | {} | {} |", kind.hurst, kind.eps_f_inv, load.load, cells.join(" | "));
        }
    }
    for load in ABOVE {
        let cells = PRESSURES.map(|pressure| format!("{:.4}", of_persson(load, pressure))).join(" | ");
        let _ = writeln!(text, "| Persson | | {load} | {cells} |");
    }
    Ok(text)
}

/// Returns the fraction of the surface above a pressure by Persson's theory, divided by p\*. Load and pressure are in
/// units of E\* ḡ; the standard deviation in full contact is half of it.
fn of_persson(load: f64, pressure: f64) -> f64 {
    let upper = |x: f64| 0.5 * libm::erfc(x * std::f64::consts::SQRT_2);
    (upper(pressure - load) - upper(pressure + load)) / load
}

/// Returns the table for given loads of the long waves.
pub(super) fn of_long_waves(summaries: &Summaries) -> Result<String, Failure> {
    let mut text =
        String::from("| H | 1/ε_f | P | κ | ū/h_rms | K h_rms/p̄ | p_rms/(E\\* ḡ) |\n|---|---|---|---|---|---|---|\n");
    for kind in &shown(summaries)? {
        for load in kind.of_long_waves.iter().filter(|load| OF_LONG_WAVES.contains(&load.load)) {
            let _ = writeln!(text, "| {} | {} | {} | {} |", kind.hurst, kind.eps_f_inv, load.load, cells(load));
        }
    }
    Ok(text)
}

/// Returns the table of the onset of percolation and of the surface heights.
pub(super) fn percolation(summaries: &Summaries) -> Result<String, Failure> {
    let mut text = String::from(
        "| H | 1/ε_f | surfaces | h_rms/(λ_l ḡ) | p\\* at percolation | area fraction |\n|---|---|---|---|---|---|\n",
    );
    for SurfaceKind { hurst, eps_f_inv, surfaces, height, percolation, .. } in &shown(summaries)? {
        let [height, load, area] = [*height, percolation[0], percolation[1]].map(|known| with_error(Some(known)));
        let _ = writeln!(text, "| {hurst} | {eps_f_inv} | {surfaces} | {height} | {load} | {area} |");
    }
    Ok(text)
}
