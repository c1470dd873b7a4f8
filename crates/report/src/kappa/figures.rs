//! Figures of a sweep.

use std::path::{Path, PathBuf};

use gfmd_fit::{Axis as Limit, Datum, Fit};
use gfmd_measure::theory::{BUSH_GIBSON_THOMAS_KAPPA, PERSSON_KAPPA};
use gfmd_plot::{Axis, Chart, Level, Mark, Panel, Point, Series};
use gfmd_sweep::{Analysis, Area, Config, Estimator, Extrapolation, Plan, Study};

use crate::figures::{area_chart, draw_pressure, named, theories};
use gfmd_input::failure::Failure;

/// Draws `NAME-extrapolation`, `NAME-area` and `NAME-map` beside the file `out`.
///
/// # Errors
/// Returns an error if a file cannot be written.
pub fn draw(out: &Path, study: &Study) -> Result<Vec<PathBuf>, Failure> {
    let Study { plan, analysis, example, .. } = study;
    let stem = stem(out);
    let mut files = Vec::new();
    // A sweep at one discretisation has nothing to extrapolate.
    let chart = extrapolation(&plan.config, analysis);
    if !chart.panels.is_empty() {
        files.extend(chart.save(&named(&stem, "extrapolation"))?);
    }
    if let Some(chart) = protocol(study) {
        files.extend(chart.save(&named(&stem, "protocol"))?);
    }
    if let Some(chart) = area(plan, analysis) {
        files.extend(chart.save(&named(&stem, "area"))?);
    }
    let modulus = plan.config.body()?.contact_modulus();
    let map = named(&stem, "map");
    files.extend(draw_pressure(&map, &example.point.grid, &example.pressure, modulus, "cell length")?);
    Ok(files)
}

/// Returns the figure prefix of a result.
pub fn stem(out: &Path) -> PathBuf {
    out.with_extension("")
}

/// Returns a chart of κ against eps^alpha for each axis without the terms of the other axes, with fit and limit.
pub(super) fn extrapolation(config: &Config, analysis: &Analysis) -> Chart {
    let shown: Vec<&Extrapolation> = analysis.extrapolations.iter().filter(|e| e.p_star == config.fit.p_star).collect();
    let result = analysis.result();
    let several = config.surface.hurst.len() > 1;
    let mut panels = Vec::new();
    for (position, axis) in Limit::ALL.into_iter().enumerate() {
        // The continuum error of the raw area is drawn against the measured edge if the fit uses the edge.
        let by_edge = axis == Limit::Continuum && result.fit.edge.is_some();
        if result.fit.term(axis).is_none() && !by_edge {
            continue;
        }
        let alpha = result.fit.term(axis).map_or(1.0, |term| term.exponent.value);
        // The eps_t term is multiplied by the power of eps_f.
        let crossed = axis == Limit::Thermodynamic && result.fit.parameters.crossed;
        let mut series = Vec::new();
        for extrapolation in &shown {
            let Extrapolation { hurst, area, data, fit, .. } = extrapolation;
            let family = config.surface.hurst.iter().position(|h| h == hurst).unwrap_or(0);
            let raw = *area == Area::Raw;
            let hue = if several { family } else { usize::from(!raw) };
            // Data that vary along another axis would overlap at one value of eps.
            let coarsest = data.iter().map(|datum| datum.eps_c).fold(0.0, f64::max);
            let on_arm = |eps: [f64; 3]| match crossed {
                true => eps[2] == coarsest,
                false => varies(data.iter().map(Datum::all_eps), eps, position),
            };
            let points = (data.iter().zip(&fit.data))
                .filter(|(datum, _)| on_arm(datum.all_eps()))
                .map(|(datum, report)| {
                    let value = fit.isolate(datum, axis);
                    let x = match (by_edge, crossed) {
                        (true, _) => datum.mean_edge(),
                        (_, true) => fit.parameters.power(axis, datum.all_eps()),
                        _ => datum.eps(axis).powf(alpha),
                    };
                    Point::with_error(x, value, report.standard_error.unwrap_or(0.0))
                })
                .collect();
            let counting = if raw { "counted points" } else { "perimeter corrected" };
            let label = if several { format!("*H* = {hurst}, {counting}") } else { counting.into() };
            let mark = if raw { Mark::Points } else { Mark::HollowPoints };
            series.push(Series { label, hue, mark, points });
            let curve = match (by_edge, crossed) {
                (true, _) => on_edge(fit, data.iter().filter(|datum| on_arm(datum.all_eps()))),
                (_, true) => {
                    let powers = data.iter().map(|datum| fit.parameters.power(axis, datum.all_eps()));
                    let coefficient = fit.term(axis).map_or(0.0, |term| term.coefficient.value);
                    let ends = [0.0, powers.fold(0.0, f64::max)];
                    ends.map(|x| (x, fit.kappa_tfc.value + coefficient * x)).to_vec()
                }
                _ => {
                    let largest = data.iter().map(|datum| datum.eps(axis)).fold(0.0, f64::max);
                    let mut others = [0.0; 3];
                    let curve = (0..=60).map(|i| {
                        let eps = largest * (f64::from(i) / 60.0).powf(1.0 / alpha);
                        others[axis as usize] = eps;
                        (eps.powf(alpha), fit.predict(others))
                    });
                    curve.collect()
                }
            };
            let line = Series::line("", hue, curve);
            series.push(if raw { line } else { Series { mark: Mark::Dashes, ..line } });
        }
        let letter = axis.letter();
        let label = if by_edge {
            "edge of the grid, estimated from each contact".into()
        } else if let (true, Some(fractal)) = (crossed, result.fit.term(Limit::Fractal)) {
            format!("*ε*_t^{{{alpha}}} *ε*_f^{{{:.2}}}", fractal.exponent.value)
        } else if (alpha - 1.0).abs() < 1e-12 {
            format!("*ε*_{letter}")
        } else {
            format!("*ε*_{letter}^{{{alpha:.2}}}")
        };
        let mut levels = Vec::new();
        if config.surface.dim == 3 {
            levels.push(Level::line(PERSSON_KAPPA, "Persson"));
            levels.push(Level::line(BUSH_GIBSON_THOMAS_KAPPA, "BGT"));
        }
        if let (Some(ci95), false) = (result.fit.kappa_tfc.ci95, several) {
            levels.push(Level::band(result.total_ci95().unwrap_or(ci95), "*κ*_{TFC}"));
        }
        let y = Axis::linear(&match config.fit.estimator {
            Estimator::Ratio => format!("*κ* = *a*_r *E*\\**g*/*p*   at *p*\\* = {}", config.fit.p_star),
            Estimator::Slope => "*κ* = *E*\\**g* d*a*_r/d*p*".into(),
        });
        panels.push(Panel { title: String::new(), x: Axis::linear(&label), y, levels, series });
    }
    Chart::new(panels)
}

/// Returns the fitted values along eps_c against the measured edge, starting with the limit at zero edge.
fn on_edge<'a>(fit: &Fit, data: impl Iterator<Item = &'a Datum>) -> Vec<(f64, f64)> {
    let limit = fit.kappa_tfc.value;
    let value = |datum: &Datum| {
        let own = fit.parameters.excess(datum.eps_c, datum.mean_edge());
        let term = fit
            .term(Limit::Continuum)
            .map_or(0.0, |term| term.coefficient.value * datum.eps_c.powf(term.exponent.value));
        (datum.mean_edge(), limit + own + term)
    };
    let mut curve: Vec<(f64, f64)> = std::iter::once((0.0, limit)).chain(data.map(value)).collect();
    curve.sort_by(|a, b| a.0.total_cmp(&b.0));
    curve
}

/// Returns true for data on the line along this axis, with the most frequent levels along the other two axes.
fn varies(all: impl Iterator<Item = [f64; 3]>, eps: [f64; 3], axis: usize) -> bool {
    let all: Vec<[f64; 3]> = all.collect();
    let others = |eps: &[f64; 3]| [0, 1, 2].map(|k| if k == axis { 0.0 } else { eps[k] });
    let count = |eps: &[f64; 3]| all.iter().filter(|other| others(other) == others(eps)).count();
    let most = all.iter().map(count).max().unwrap_or(0);
    count(&eps) == most
}

/// Returns a chart of contact area against reduced pressure: the finest point of each family, and the extrapolated
/// limit. `None` for slopes, because they give no area.
pub(super) fn area(plan: &Plan, analysis: &Analysis) -> Option<Chart> {
    let config = &plan.config;
    if config.fit.estimator == Estimator::Slope {
        return None;
    }
    let loads = &config.loads.p_star;
    let mut series = Vec::new();
    for (family, &hurst) in config.surface.hurst.iter().enumerate() {
        let finest = (0..plan.points.len()).filter(|index| plan.points[*index].hurst == hurst).max_by(|a, b| {
            let eps_c = |index: usize| plan.points[index].discretisation.eps_c_inv;
            eps_c(*a).total_cmp(&eps_c(*b)).then(plan.points[*b].n().cmp(&plan.points[*a].n()))
        });
        let raw = analysis.data.iter().filter(|(key, _)| Some(key.point) == finest && key.area == Area::Raw);
        let points = raw
            .map(|(key, kappa)| {
                let p_star = loads[key.load];
                Point::with_error(p_star, kappa.mean() * p_star, kappa.standard_error().unwrap_or(0.0) * p_star)
            })
            .collect();
        let eps_c_inv = finest.map_or(0.0, |index| plan.points[index].discretisation.eps_c_inv);
        series.push(Series::points(&format!("*H* = {hurst}, 1/*ε*_c = {eps_c_inv}"), 2 * family, points));
        let limits = (analysis.extrapolations.iter()).filter(|e| e.hurst == hurst && e.area == Area::Raw);
        // The axes are logarithmic. A fit to few data may extrapolate to a limit below zero.
        let limits = limits.filter(|e| e.fit.kappa_tfc.value > 0.0);
        let mut points: Vec<Point> = limits
            .map(|e| {
                let kappa = e.fit.kappa_tfc;
                let point = Point::new(e.p_star, kappa.value * e.p_star);
                Point { range: kappa.ci95.map(|ci95| ci95.map(|k| k * e.p_star)), ..point }
            })
            .collect();
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let label = format!("*H* = {hurst}, limit");
        series.push(Series { label, hue: 2 * family + 1, mark: Mark::HollowPoints, points });
    }
    if config.surface.dim == 3 {
        series.extend(theories(loads[0], loads[loads.len() - 1]));
    }
    Some(area_chart(series))
}

/// Returns charts of κ against eps_c and eps_f, with one curve per value of the other; `None` without reference cells.
pub(super) fn protocol(study: &Study) -> Option<Chart> {
    let first = study.analysis.protocols.first()?;
    let loads = &study.plan.config.loads.p_star;
    let load = loads.iter().position(|p_star| *p_star == first.p_star)?;
    let arms = study.analysis.arms(&study.plan, first.hurst, load);
    let mut panels = Vec::new();
    for (axis, other) in [(Limit::Continuum, Limit::Fractal), (Limit::Fractal, Limit::Continuum)] {
        // Use the cell size with most points.
        let of_size = |t: f64| arms.iter().filter(move |arm| arm.axis == axis && arm.cell[0] == t);
        let points = |t: f64| of_size(t).map(|arm| arm.inverse.len()).sum::<usize>();
        let sizes = study.plan.points.iter().map(|point| point.discretisation.eps_t_inv);
        let Some(size) = sizes.max_by_key(|t| points(*t)) else { continue };
        let mut series = Vec::new();
        for (hue, arm) in of_size(size).enumerate() {
            let points = arm.inverse.iter().zip(&arm.kappa).map(|(inverse, kappa)| {
                let point = Point::new(inverse.recip(), kappa.value);
                Point { range: kappa.ci95, ..point }
            });
            let label = format!("1/*ε*_{} = {}", other.letter(), arm.cell[other as usize]);
            series.push(Series::points(&label, hue, points.collect()));
            if let (Some(curve), Some(coarsest)) = (arm.curve, arm.inverse.first()) {
                let line = (0..=80).map(|k| {
                    let eps = f64::from(k) / 80.0 / coarsest;
                    (eps, curve.limit.value + curve.coefficient.value * eps.powf(curve.exponent.value))
                });
                series.push(Series { mark: Mark::Dashes, ..Series::line("", hue, line) });
            }
        }
        if !series.is_empty() {
            let x = Axis::linear(&format!("*ε*_{}", axis.letter()));
            let title = format!("1/*ε*_t = {size}");
            panels.push(Panel { title, x, y: Axis::linear("*κ*_{sim}"), series, ..Panel::default() });
        }
    }
    (!panels.is_empty()).then(|| Chart { share_y: false, ..Chart::new(panels) })
}
