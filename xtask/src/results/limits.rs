//! Table 5.1 of the thesis: kappa of other authors, beside ours under their conditions.

use std::fmt::Write;

use gfmd_input::failure::Failure;

use super::kappa;
use super::summary::Summaries;

/// Row of that table: authors, H, kappa, 1/eps_c, 1/eps_f, 1/eps_t as printed; the conditions of our result.
struct Row {
    authors: &'static str,
    hurst: &'static str,
    kappa: &'static str,
    printed: [&'static str; 3],
    ours: Ours,
}

/// Our result beside the printed one.
enum Ours {
    /// In all limits, for these Hurst exponents.
    Limit(&'static [f64]),
    /// In the limit of eps_c, at these 1/eps_f.
    Bands(&'static [f64], &'static [f64]),
    /// A remark in words.
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
        ours: Ours::Bands(&[0.3, 0.8], &[512.0]),
    },
    Row {
        authors: "Campañá, Müser",
        hurst: "0.2…0.8",
        kappa: "2.09…1.98",
        printed: ["ext.", "≈ 1000", "1"],
        ours: Ours::Bands(&[0.3, 0.8], &[512.0]),
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
        ours: Ours::Words("profiles, below"),
    },
    Row {
        authors: "Yastrebov et al.",
        hurst: "0…0.8",
        kappa: "2.4…2.2",
        printed: ["0", "32…512", "0"],
        ours: Ours::Bands(&[0.0, 0.8], &[32.0, 512.0]),
    },
];

pub(super) fn table(summaries: &Summaries) -> Result<String, Failure> {
    let sweep = summaries.read("ladders")?;
    let limits = kappa::limits(&sweep);
    let mut text = String::from(
        "| authors | H | κ | 1/ε_c | 1/ε_f | 1/ε_t | ours at p\\* = 0.02 |\n|---|---|---|---|---|---|---|\n",
    );
    for Row { authors, hurst, kappa, printed: [c, f, t], ours } in ROWS {
        let shown = match ours {
            Ours::Words(words) => words.to_owned(),
            Ours::Limit(all) => {
                let one = |hurst: &f64| -> Result<String, Failure> {
                    let limit = kappa::at(&limits, *hurst, kappa::P_STAR)?;
                    Ok(format!("H = {hurst}: {:.3} ± {:.3}", limit.kappa, limit.half()))
                };
                all.iter().map(one).collect::<Result<Vec<_>, _>>()?.join("; ")
            }
            Ours::Bands(all, bands) => {
                let one = |hurst: &f64| -> Result<String, Failure> {
                    let at = |band: &f64| -> Result<String, Failure> {
                        let wanted = [*hurst, 1.0, *band, 4.0, kappa::P_STAR];
                        let found = sweep
                            .points
                            .iter()
                            .find(|at| [at.hurst, at.eps_t_inv, at.eps_f_inv, at.eps_c_inv, at.p_star] == wanted);
                        let missing = || Failure::refused(format!("ladders.json has no point at 1/eps_f = {band}"));
                        let point = found.ok_or_else(missing)?;
                        Ok(format!("{:.2}", point.kappa - point.edge.unwrap_or(0.0)))
                    };
                    Ok(format!("H = {hurst}: {}", bands.iter().map(at).collect::<Result<Vec<_>, _>>()?.join("…")))
                };
                let all = all.iter().map(one).collect::<Result<Vec<_>, _>>()?.join("; ");
                let bands = bands.iter().map(f64::to_string).collect::<Vec<_>>().join(" and ");
                format!("{all} (1/ε_f = {bands}, 1/ε_t = 1, ε_c → 0)")
            }
        };
        let _ = writeln!(text, "| {authors} | {hurst} | {kappa} | {c} | {f} | {t} | {shown} |");
    }
    Ok(text)
}
