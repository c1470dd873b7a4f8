//! Limits of kappa: data/results/limits.json, and the tables and the sentence made from it.

use std::fmt::Write;

use gfmd_input::failure::Failure;
use gfmd_measure::SelfAffineArea;
use gfmd_measure::theory::persson_area;
use serde::Serialize;

use super::summary::{Fit, Summaries, Summary};

pub(super) const HURSTS: [f64; 4] = [0.0, 0.3, 0.5, 0.8];

/// Half of a 95 % interval divided by the standard error.
const NORMAL_975: f64 = 1.959_963_984_540_054;

/// Load of the result.
pub(super) const P_STAR: f64 = 0.02;

/// kappa in the limit, with its interval and the contributions to its error, each half of a 95 % interval.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Limit {
    pub(super) hurst: f64,
    pub(super) p_star: f64,
    pub(super) kappa: f64,
    /// Interval with all errors together.
    pub(super) ci95: [f64; 2],
    statistical: f64,
    form: f64,
    edge: f64,
}

/// File of the limits.
#[derive(Debug, Serialize)]
struct Limits {
    limits: Vec<Limit>,
}

/// Rounds a value to the digits of the file.
fn rounded(value: f64) -> f64 {
    (value * 1e4).round() / 1e4
}

impl Limit {
    fn of(fit: &Fit) -> Option<Self> {
        let (Some([low, high]), Some([least, most])) = (fit.ci95, fit.total_ci95) else { return None };
        let half = 0.5 * (high - low);
        let part = fit.edge.and_then(|edge| edge.share).zip(fit.kappa_tfc_standard_error);
        let edge = half * part.map_or(0.0, |(share, whole)| (share / whole).min(1.0));
        Some(Self {
            hurst: fit.hurst,
            p_star: fit.p_star,
            kappa: rounded(fit.kappa_tfc),
            ci95: [rounded(least), rounded(most)],
            statistical: rounded((half * half - edge * edge).max(0.0).sqrt()),
            form: rounded(fit.systematic),
            edge: rounded(edge),
        })
    }

    /// Returns half of the interval.
    pub(super) fn half(&self) -> f64 {
        0.5 * (self.ci95[1] - self.ci95[0])
    }
}

/// Returns the limits of a sweep from counted areas, by load and H.
pub(super) fn limits(sweep: &Summary) -> Vec<Limit> {
    let mut found: Vec<Limit> = sweep.fits.iter().filter(|fit| fit.area == "raw").filter_map(Limit::of).collect();
    found.sort_by(|one, other| one.p_star.total_cmp(&other.p_star).then(one.hurst.total_cmp(&other.hurst)));
    found
}

/// Returns the limit at one H and load.
pub(super) fn at(limits: &[Limit], hurst: f64, p_star: f64) -> Result<Limit, Failure> {
    let found = limits.iter().find(|limit| limit.hurst == hurst && limit.p_star == p_star);
    found.copied().ok_or_else(|| Failure::refused(format!("there is no limit for H = {hurst} at p* = {p_star}")))
}

/// Returns the text of data/results/limits.json, one limit per line.
pub(super) fn file(summaries: &Summaries) -> Result<String, Failure> {
    let all = Limits { limits: limits(&summaries.read("ladders")?) };
    let text = serde_json::to_string(&all).map_err(|error| Failure::input("limits.json", &error))?;
    Ok(text.replace("[{", "[\n{").replace("},{", "},\n{").replace("}]}", "}\n]}\n"))
}

/// Returns the table of the result.
pub(super) fn table(summaries: &Summaries) -> Result<String, Failure> {
    let limits = limits(&summaries.read("ladders")?);
    let mut text = String::from(
        "| H | κ | 95 %, everything included | statistical | form | edge of the grid |\n|---|---|---|---|---|---|\n",
    );
    for hurst in HURSTS {
        let limit = at(&limits, hurst, P_STAR)?;
        let Limit { kappa, ci95: [low, high], statistical, form, edge, .. } = limit;
        let part = 100.0 * limit.half() / kappa;
        let _ = writeln!(
            text,
            "| {hurst} | **{kappa:.3}** | [{low:.3}, {high:.3}] (± {part:.2} %) | ± {statistical:.4} | ± {form:.4} \
             | ± {edge:.4} |"
        );
    }
    let cited = at(&limits, 0.8, P_STAR)?;
    let _ = writeln!(
        text,
        "\n**To cite**: \"κ = {:.3} ± {:.3} for H = 0.8 at p\\* = {P_STAR} (95 %, all errors)\", with the program.",
        cited.kappa,
        cited.half()
    );
    Ok(text)
}

/// Returns the sentence of the README.
pub(super) fn sentence(summaries: &Summaries) -> Result<String, Failure> {
    let limits = limits(&summaries.read("ladders")?);
    let one = |hurst: f64| -> Result<String, Failure> {
        let limit = at(&limits, hurst, P_STAR)?;
        Ok(format!("{:.3} ± {:.3} for H = {hurst}", limit.kappa, limit.half()))
    };
    let all = HURSTS.into_iter().map(one).collect::<Result<Vec<_>, _>>()?.join(", ");
    Ok(format!("**κ** at p\\* = {P_STAR} in the limit: {all} (95 %, everything included).\n"))
}

/// Returns the table of the limits at all loads, with half of the interval.
pub(super) fn loads(summaries: &Summaries) -> Result<String, Failure> {
    let limits = limits(&summaries.read("ladders")?);
    let mut loads: Vec<f64> = limits.iter().map(|limit| limit.p_star).collect();
    loads.dedup();
    let head = HURSTS.map(|hurst| format!("H = {hurst}")).join(" | ");
    let mut text = format!("| p\\* | {head} | Persson |\n|---|{}---|\n", "---|".repeat(HURSTS.len()));
    for p_star in loads {
        let mut cells = Vec::new();
        for hurst in HURSTS {
            let limit = at(&limits, hurst, p_star)?;
            cells.push(format!("{:.3} ± {:.3}", limit.kappa, limit.half()));
        }
        let _ = writeln!(text, "| {p_star} | {} | {:.3} |", cells.join(" | "), persson_area(p_star) / p_star);
    }
    Ok(text)
}

/// Returns the fit of counted areas at one H and load.
pub(super) fn fit(sweep: &Summary, hurst: f64, p_star: f64) -> Result<&Fit, Failure> {
    let wanted = |fit: &&Fit| fit.hurst == hurst && fit.p_star == p_star && fit.area == "raw";
    let missing = || Failure::refused(format!("a summary has no fit for H = {hurst} at p* = {p_star}"));
    sweep.fits.iter().find(wanted).ok_or_else(missing)
}

/// Returns χ² of the differences between both sets of surfaces, by their scatter and by all errors.
pub(super) fn seeds(summaries: &Summaries) -> Result<String, Failure> {
    const LOADS: [f64; 3] = [0.002, 0.02, 0.2];
    let [main, other] = [summaries.read("ladders")?, summaries.read("ladders-2")?];
    let mut sums = [const { Vec::new() }; 2];
    for p_star in LOADS {
        let mut sum = [0.0; 2];
        for hurst in HURSTS {
            let [one, two] = [fit(&main, hurst, p_star)?, fit(&other, hurst, p_star)?];
            let errors = [one, two].map(|fit| fit.kappa_tfc_standard_error.unwrap_or(f64::NAN));
            let [difference, error] = [one.kappa_tfc - two.kappa_tfc, errors[0].hypot(errors[1])];
            let all = [one, two].map(|fit| {
                let [low, high] = fit.total_ci95.unwrap_or([f64::NAN; 2]);
                0.5 * (high - low) / NORMAL_975
            });
            for (sum, error) in sum.iter_mut().zip([error, all[0].hypot(all[1])]) {
                *sum += (difference / error).powi(2);
            }
        }
        sums.iter_mut().zip(sum).for_each(|(sums, sum)| sums.push(format!("{sum:.1}")));
    }
    let [scatter, all] = sums.map(|sums| sums.join(", "));
    Ok(format!(
        "χ² of the differences over the four H at p\\* = {}: {scatter}; with the errors of form and edge {all}.\n",
        LOADS.map(|p_star| p_star.to_string()).join(", ")
    ))
}

/// Returns the difference of the formula from the limits at the Hurst exponents outside its fit.
pub(super) fn between(summaries: &Summaries) -> Result<String, Failure> {
    let sweep = summaries.read("between")?;
    let mut errors = Vec::new();
    for fit in sweep.fits.iter().filter(|fit| fit.area == "raw") {
        let area = SelfAffineArea::new(fit.hurst)
            .ok_or_else(|| Failure::refused(format!("H is {} in between.json", fit.hurst)))?;
        errors.push(area.at(fit.p_star) / fit.p_star / fit.kappa_tfc - 1.0);
    }
    let (rms, most) = spread(&errors);
    let count = errors.len();
    Ok(format!("Over these {count} limits the formula is off by {rms:.2} % rms, at most {most:.2} %.\n"))
}

/// Returns root mean square and largest magnitude, in per cent.
fn spread(errors: &[f64]) -> (f64, f64) {
    let squares = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
    (100.0 * squares.sqrt(), 100.0 * errors.iter().fold(0.0, |most: f64, error| most.max(error.abs())))
}

/// Returns the table of the form error at the load of the result, with the exponent and the edge of the fit.
pub(super) fn budget(summaries: &Summaries) -> Result<String, Failure> {
    const FORMS: [(&str, &str); 5] = [
        ("least-alpha-f", "least α from 1 − H that χ² allows"),
        ("largest-alpha-f", "largest α to min(1, 2 − 2H) that χ² allows"),
        ("without-coarsest-eps-f", "without the largest ε_f"),
        ("second-closure", "second closure"),
        ("between-closures", "half of the difference of both closures at the smallest ε_f"),
    ];
    let main = summaries.read("ladders")?;
    let head = HURSTS.map(|hurst| format!("H = {hurst}")).join(" | ");
    let mut text = format!("| | {head} |\n|---|{}\n", "---|".repeat(HURSTS.len()));
    let mut row = |name: &str, value: &dyn Fn(f64) -> Result<String, Failure>| -> Result<(), Failure> {
        let cells = HURSTS.into_iter().map(value).collect::<Result<Vec<_>, _>>()?;
        let _ = writeln!(text, "| {name} | {} |", cells.join(" | "));
        Ok(())
    };
    let of = |hurst: f64| fit(&main, hurst, P_STAR);
    row("exponent α of the difference of both closures", &|hurst| {
        let term = of(hurst)?.terms.iter().find(|term| term.axis == "f");
        Ok(term.map_or_else(|| "–".into(), |term| format!("{:.2}", term.exponent)))
    })?;
    row("χ²/degrees of freedom", &|hurst| {
        let found = of(hurst)?;
        Ok(format!("{:.1}/{}", found.chi_squared, found.degrees_of_freedom))
    })?;
    row("factor of the edge", &|hurst| {
        Ok(of(hurst)?.edge.map_or_else(|| "–".into(), |edge| format!("{:.3}", edge.factor)))
    })?;
    for (form, name) in FORMS {
        row(name, &|hurst| {
            let found = of(hurst)?;
            let other = found.alternatives.iter().find(|other| other.form == form);
            Ok(other.map_or_else(|| "–".into(), |other| format!("{:+.4}", other.kappa_tfc - found.kappa_tfc)))
        })?;
    }
    Ok(text)
}
