//! Table 5.1 of the source: kappa of other authors, beside ours under their conditions.

use std::fmt::Write;

use gfmd_run::failure::Failure;

use super::summary::{Fit, Summaries};

/// A row of the source's table: authors, H, kappa, 1/eps_c, 1/eps_f, 1/eps_t as printed; the conditions for which ours stands.
struct Row {
    authors: &'static str,
    hurst: &'static str,
    kappa: &'static str,
    printed: [&'static str; 3],
    ours: Ours,
}

/// Our result that stands beside.
enum Ours {
    /// In all limits, for these Hurst exponents: with the narrower interval of both ways to the fractal limit.
    Limit(&'static [f64]),
    /// In the limits of eps_t and eps_c, at 1/eps_f from one value to another.
    Bands(&'static [f64], [f64; 2]),
    /// Words.
    Words(&'static str),
}

const ROWS: [Row; 7] = [
    Row {
        authors: "Bush, Gibson, Thomas",
        hurst: "0…1",
        kappa: "√(8/π)…√(2π)",
        printed: ["0", "≈ 1", "0"],
        ours: Ours::Words("at vanishing load; not computed at 1/ε_f ≈ 1"),
    },
    Row {
        authors: "Persson",
        hurst: "0…1",
        kappa: "√(8/π)",
        printed: ["0", "0", "0"],
        ours: Ours::Limit(&[0.0, 0.3, 0.5, 0.8]),
    },
    Row {
        authors: "Hyun et al.",
        hurst: "0.3…0.9",
        kappa: "2.2…1.8",
        printed: ["2", "≈ 1000", "1"],
        ours: Ours::Bands(&[0.3, 0.8], [1024.0, 1024.0]),
    },
    Row {
        authors: "Campañá, Müser",
        hurst: "0.2…0.8",
        kappa: "2.09…1.98",
        printed: ["ext.", "≈ 1000", "1"],
        ours: Ours::Bands(&[0.3, 0.8], [1024.0, 1024.0]),
    },
    Row {
        authors: "Prodanov et al.",
        hurst: "0…0.8",
        kappa: "2.16…1.93",
        printed: ["ext.", "ext.", "ext."],
        ours: Ours::Limit(&[0.0, 0.3, 0.8]),
    },
    Row {
        authors: "van Dokkum et al.",
        hurst: "0…0.8",
        kappa: "1.45",
        printed: ["ext.", "ext.", "ext."],
        ours: Ours::Words("profiles: below"),
    },
    Row {
        authors: "Yastrebov et al.",
        hurst: "0…0.8",
        kappa: "2.4…2.2",
        printed: ["0", "32…512", "0"],
        ours: Ours::Bands(&[0.0, 0.8], [32.0, 512.0]),
    },
];

/// The load of our numbers.
const P_STAR: f64 = 0.02;

pub(super) fn table(summaries: &Summaries) -> Result<String, Failure> {
    let [powers, composed] = [summaries.read("hurst")?, summaries.read("composed")?];
    let found = |fits: &[Fit], hurst: f64| -> Result<usize, Failure> {
        let wanted = |fit: &Fit| fit.hurst == hurst && fit.p_star == P_STAR && fit.area == "raw";
        let missing = || Failure::Input(format!("there is no fit for H = {hurst} at p* = {P_STAR}"));
        fits.iter().position(wanted).ok_or_else(missing)
    };
    // At finite eps_f the power law describes the data; of the limits, the narrower interval counts.
    let of = |hurst: f64| found(&powers.fits, hurst).map(|index| &powers.fits[index]);
    let limit = |hurst: f64| -> Result<&Fit, Failure> {
        let both = [of(hurst)?, &composed.fits[found(&composed.fits, hurst)?]];
        let width = |fit: &Fit| fit.total_ci95.map_or(f64::INFINITY, |[low, high]| high - low);
        Ok(if width(both[1]) < width(both[0]) { both[1] } else { both[0] })
    };
    let mut text = String::from(
        "| authors | H | κ | 1/ε_c | 1/ε_f | 1/ε_t | ours at p\\* = 0.02 |\n|---|---|---|---|---|---|---|\n",
    );
    for Row { authors, hurst, kappa, printed: [c, f, t], ours } in ROWS {
        let shown = match ours {
            Ours::Words(words) => words.to_owned(),
            Ours::Limit(all) => {
                let one = |hurst: &f64| -> Result<String, Failure> {
                    let fit = limit(*hurst)?;
                    let interval =
                        fit.total_ci95.map_or_else(String::new, |[low, high]| format!(" [{low:.2}, {high:.2}]"));
                    Ok(format!("H = {hurst}: {:.2}{interval}", fit.kappa_tfc))
                };
                all.iter().map(one).collect::<Result<Vec<_>, _>>()?.join("; ")
            }
            Ours::Bands(all, [from, to]) => {
                let one = |hurst: &f64| -> Result<String, Failure> {
                    let fit = of(*hurst)?;
                    let at = |inverse: f64| {
                        let term = fit.terms.iter().find(|term| term.axis == "f");
                        fit.kappa_tfc + term.map_or(0.0, |term| term.coefficient * inverse.powf(-term.exponent))
                    };
                    let range = if from == to {
                        format!("{:.2}", at(from))
                    } else {
                        format!("{:.2}…{:.2}", at(from), at(to))
                    };
                    Ok(format!("H = {hurst}: {range}"))
                };
                let all = all.iter().map(one).collect::<Result<Vec<_>, _>>()?.join("; ");
                format!("{all} (ε_t, ε_c → 0, from the fit)")
            }
        };
        let _ = writeln!(text, "| {authors} | {hurst} | {kappa} | {c} | {f} | {t} | {shown} |");
    }
    Ok(text)
}
