//! What the figures of the commands show.

use std::path::{Path, PathBuf};

use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_law::Law;
use gfmd_measure::theory::{BUSH_GIBSON_THOMAS_KAPPA, persson_area};
use gfmd_mixed::MixedSolution;
use gfmd_plot::{Axis, Below, Chart, Map, Mark, Panel, PlotError, Point, Series};
use ndarray::{Array2, Array3, ArrayView3};

use crate::contact;
use crate::damping;
use crate::failure::Failure;
use crate::path::StepRecord;
use crate::punch;

/// The figures of one contact: `PREFIX-map` of the last load, and `PREFIX-area` if there are several loads
/// of a hard wall.
///
/// # Errors
/// Files that cannot be written.
pub fn contact(
    prefix: &Path,
    report: &contact::Report,
    grid: &Grid,
    pressure: &Array2<f64>,
) -> Result<Vec<PathBuf>, Failure> {
    let unit = report.unit.as_deref().unwrap_or("length");
    let mut files = draw_pressure(&named(prefix, "map"), grid, pressure, report.e_star, unit)?;
    if report.loads.len() > 1 && report.loads.iter().all(|load| load.law.is_none()) {
        let measured = report.loads.iter().map(|load| Point::new(load.p_star, load.area_fraction)).collect();
        let corrected = report.loads.iter().map(|load| Point::new(load.p_star, load.area_fraction_corrected)).collect();
        let mut series = vec![Series { mark: Mark::JoinedPoints, ..Series::points("counted points", 0, measured) }];
        if !grid.is_line() {
            series.push(Series {
                label: "perimeter corrected".into(),
                hue: 1,
                mark: Mark::HollowPoints,
                points: corrected,
            });
        }
        let loads = report.loads.iter().map(|load| load.p_star);
        series.extend(theories(loads.clone().fold(f64::INFINITY, f64::min), loads.fold(0.0, f64::max)));
        files.extend(area_chart(series).save(&named(prefix, "area")).map_err(failed)?);
    }
    Ok(files)
}

/// The figures of a punch: maps `PREFIX-u_x`, `-u_y`, `-u_z` and `-pressure`, and `PREFIX-cut` along x through its
/// middle, with the displacement `[x, y, component]` of the reference, if there is one; of a strip, the cut alone.
///
/// # Errors
/// Files that cannot be written.
pub fn punch(
    prefix: &Path,
    report: &punch::Report,
    grid: &Grid,
    body: &Body,
    solution: &MixedSolution,
    reference: Option<&Array3<f64>>,
) -> Result<Vec<PathBuf>, Failure> {
    let modulus = body.material().contact_modulus();
    let normal = report.components.len() - 1;
    let mut files = Vec::new();
    if !grid.is_line() {
        for (field, name) in solution.displacement.outer_iter().zip(&report.components) {
            let values: Vec<f64> = field.iter().map(|u| u / report.depth).collect();
            let map = Map::new(&values, grid.points(), grid.lengths(), &format!("*u*_{name} / depth"));
            files.extend(map.save(&named(prefix, &format!("u_{name}"))).map_err(failed)?);
        }
        let pressure = solution.traction.index_axis(ndarray::Axis(0), normal).mapv(|t| -t);
        files.extend(draw_pressure(&named(prefix, "pressure"), grid, &pressure, modulus, "length")?);
    }
    // Through the middle, where by symmetry nothing points along y.
    let cut = |field: ArrayView3<f64>, component: usize, unit: f64| {
        let (n, rows, _) = field.dim();
        let spacing = grid.lengths()[0] / n as f64;
        (0..n).map(|i| (i as f64 * spacing, field[[i, rows / 2, component]] / unit)).collect::<Vec<_>>()
    };
    let [u, t] = [&solution.displacement, &solution.traction].map(|field| field.view().permuted_axes([1, 2, 0]));
    let mut displacement = Vec::new();
    let mut traction = Vec::new();
    for component in [0, normal] {
        let name = report.components[component];
        displacement.push(Series::line(&format!("*u*_{name}"), component, cut(u, component, report.depth)));
        traction.push(Series::line(&format!("*t*_{name}"), component, cut(t, component, modulus)));
        if let Some(reference) = reference {
            let line = Series::line(
                &format!("*u*_{name}, reference"),
                component + 3,
                cut(reference.view(), component, report.depth),
            );
            displacement.push(Series { mark: Mark::Dashes, ..line });
        }
    }
    let panel =
        |label: &str, series| Panel { x: Axis::linear("*x*"), y: Axis::linear(label), series, ..Panel::default() };
    let panels = vec![panel("displacement / depth", displacement), panel("traction / *E*\\*", traction)];
    let chart = Chart { share_y: false, ..Chart::new(panels) };
    files.extend(chart.save(&named(prefix, "cut")).map_err(failed)?);
    Ok(files)
}

/// A value on a section through a body: `[along, upwards]`.
pub struct SectionMap<'a> {
    /// Of the file.
    pub name: &'a str,
    /// Of the colour bar.
    pub label: &'a str,
    /// Row-major.
    pub values: &'a [f64],
}

/// The figures of a section of `size` (along `axis`, and depth): `PREFIX-name` of each map.
///
/// # Errors
/// Files that cannot be written.
pub fn section<'a>(
    prefix: &Path,
    maps: impl Iterator<Item = SectionMap<'a>>,
    shape: [usize; 2],
    size: [f64; 2],
    axis: &str,
    unit: &str,
) -> Result<Vec<PathBuf>, Failure> {
    let mut files = Vec::new();
    for SectionMap { name, label, values } in maps {
        let mut map = Map::new(values, shape, size, label);
        map.x = format!("*{axis}* / {unit}");
        map.y = format!("height above the lowest level / {unit}");
        map.range = central(values);
        files.extend(map.save(&named(prefix, name)).map_err(failed)?);
    }
    Ok(files)
}

/// The range of all but two per mille at either end, where it is much narrower than the whole: a field with singular
/// edges has a few values far from the rest.
fn central(values: &[f64]) -> Option<[f64; 2]> {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = |per_mille: usize| sorted[(sorted.len() - 1) * per_mille / 1000];
    let (whole, most) = (at(1000) - at(0), at(998) - at(2));
    (most > 0.0 && whole > 1.5 * most).then(|| [at(2), at(998)])
}

/// The figure of damped relaxations, `PREFIX-damping`: slowest mode and pushed point against time step.
///
/// # Errors
/// Files that cannot be written.
pub fn damping(prefix: &Path, report: &damping::Report) -> Result<Vec<PathBuf>, Failure> {
    let shown = report.runs.iter().filter_map(|run| run.steps_to_1e8).min().unwrap_or(report.steps).min(report.steps);
    // Amplitudes below this are left out.
    let least = 1e-8;
    let thinned = |history: &[f64]| {
        let stride = (shown as usize / 500).max(1);
        let steps = history.iter().take(shown as usize + 1).enumerate().step_by(stride);
        let visible = steps.map(|(step, a)| (step as f64, a.abs())).filter(|(_, a)| *a > least);
        visible.collect::<Vec<_>>()
    };
    let panel = |title: &str, history: fn(&damping::Run) -> &[f64]| {
        let lines = report.runs.iter().enumerate();
        let series = lines
            .map(|(hue, run)| Series::line(&format!("*η* = {} *η*_{{cr}}", run.factor), hue, thinned(history(run))));
        Panel {
            title: title.into(),
            x: Axis::linear("time step").over([0.0, f64::from(shown)]),
            y: Axis::log("amplitude").over([least, 2.0]),
            series: series.collect(),
            ..Panel::default()
        }
    };
    let panels = vec![panel("slowest mode", |run| &run.mode), panel("pushed point", |run| &run.point)];
    Ok(Chart::new(panels).save(&named(prefix, "damping")).map_err(failed)?.to_vec())
}

/// A law: T_n over the span of `normal` for each value of `tangential`, and T_t the other way round.
///
/// # Errors
/// Files that cannot be written.
pub fn law(stem: &Path, law: &dyn Law, normal: &[f64], tangential: &[f64]) -> Result<Vec<PathBuf>, Failure> {
    const STEPS: u32 = 200;
    let curves = |span: &[f64], others: &[f64], name: &str, of: &dyn Fn(f64, f64) -> f64| -> Vec<Series> {
        let low = span.iter().copied().fold(f64::INFINITY, f64::min);
        let high = span.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut others = others.to_vec();
        others.sort_by(f64::total_cmp);
        others.dedup();
        let along = |other: f64| {
            (0..=STEPS)
                .map(move |i| low + (high - low) * f64::from(i) / f64::from(STEPS))
                .map(move |x| (x, of(x, other)))
        };
        let named = |(hue, other): (usize, &f64)| {
            Series::line(&format!("{name} = {other}").replace('-', "−"), hue, along(*other))
        };
        others.iter().enumerate().map(named).collect()
    };
    let opening = curves(normal, tangential, "Δ_t", &|n, t| law.response(n, t).traction[0]);
    let sliding = curves(tangential, normal, "Δ_n", &|t, n| law.response(n, t).traction[1]);
    let mut panels =
        vec![Panel { x: Axis::linear("Δ_n"), y: Axis::linear("*T*_n"), series: opening, ..Panel::default() }];
    if law.mixed_mode().is_some() {
        panels.push(Panel { x: Axis::linear("Δ_t"), y: Axis::linear("*T*_t"), series: sliding, ..Panel::default() });
    } else {
        panels[0].series.truncate(1);
        panels[0].series[0].label.clear();
    }
    Ok(Chart { share_y: false, ..Chart::new(panels) }.save(stem).map_err(failed)?.into())
}

/// A path, leg by leg: pressure against approach and contact area against pressure, or shear and sticking area against
/// lateral displacement if it moves sideways; and the map of pressure at its end.
///
/// # Errors
/// Files that cannot be written.
pub fn path(
    prefix: &Path,
    report: &crate::path::Report,
    steps_of_leg: usize,
    grid: &Grid,
    pressure: &Array2<f64>,
) -> Result<Vec<PathBuf>, Failure> {
    let unit = report.unit.as_deref().unwrap_or("length");
    let mut files = draw_pressure(&named(prefix, "map"), grid, pressure, report.e_star, unit)?;
    let unit_pressure = report.e_star * report.rms_gradient;
    let legs = |of: &dyn Fn(&StepRecord) -> (f64, f64)| -> Vec<Series> {
        let last = report.steps.len().saturating_sub(1);
        let leg = |(hue, start): (usize, usize)| {
            let points = report.steps[start..=(start + steps_of_leg).min(last)].iter().map(|step| {
                let (x, y) = of(step);
                Point::new(x, y)
            });
            let label = format!("leg {}", hue + 1);
            Series { mark: Mark::JoinedPoints, ..Series::points(&label, hue, points.collect()) }
        };
        (0..last.max(1)).step_by(steps_of_leg).enumerate().map(leg).collect()
    };
    let sideways = report.steps.iter().any(|step| step.lateral != report.steps[0].lateral);
    let lateral = |step: &StepRecord| report.along(step.lateral);
    let shear = |step: &StepRecord| report.along(step.mean_shear);
    let reduced = "*p*/(*E*\\* *ḡ*)";
    let panels = if sideways {
        let x = Axis::linear(&format!("lateral displacement / {unit}"));
        let share = |step: &StepRecord| {
            if step.stick_fraction.is_nan() { step.area_fraction } else { step.stick_fraction }
        };
        let sticking = report.steps.iter().any(|step| !step.stick_fraction.is_nan());
        let area = if sticking { "sticking area" } else { "contact area" };
        vec![
            Panel {
                x: x.clone(),
                y: Axis::linear("shear / (*E*\\* *ḡ*)"),
                series: legs(&|step| (lateral(step), shear(step) / unit_pressure)),
                ..Panel::default()
            },
            Panel { x, y: Axis::linear(area), series: legs(&|step| (lateral(step), share(step))), ..Panel::default() },
        ]
    } else {
        vec![
            Panel {
                x: Axis::linear(&format!("approach / {unit}")),
                y: Axis::linear(reduced),
                series: legs(&|step| (step.displacement, step.p_star)),
                ..Panel::default()
            },
            Panel {
                x: Axis::linear(reduced),
                y: Axis::linear("contact area"),
                series: legs(&|step| (step.p_star, step.area_fraction)),
                ..Panel::default()
            },
        ]
    };
    let chart = Chart { share_y: false, ..Chart::new(panels) };
    files.extend(chart.save(&named(prefix, "path")).map_err(failed)?);
    Ok(files)
}

/// A prefix of figures, in a folder that exists.
///
/// # Errors
/// The folder that does not.
pub fn parse_prefix(text: &str) -> Result<PathBuf, String> {
    let prefix = PathBuf::from(text);
    let folder = gfmd_files::folder(&prefix);
    if folder.is_dir() { Ok(prefix) } else { Err(format!("there is no folder {}", folder.display())) }
}

pub(crate) fn named(stem: &Path, what: &str) -> PathBuf {
    let name = stem.file_name().unwrap_or_default().to_string_lossy();
    stem.with_file_name(format!("{name}-{what}"))
}

pub(crate) fn failed(error: PlotError) -> Failure {
    Failure::Computation(error.to_string())
}

pub(crate) fn area_chart(series: Vec<Series>) -> Chart {
    Chart::new(vec![Panel {
        x: Axis::log("reduced pressure *p*\\* = *p*/(*E*\\**g*)"),
        y: Axis::log("contact area fraction *a*_r"),
        series,
        ..Panel::default()
    }])
}

/// Area of Persson's theory, and the straight line of Bush, Gibson and Thomas where it is below one.
pub(crate) fn theories(lowest: f64, highest: f64) -> [Series; 2] {
    let pressures = |to: f64| (0..=80).map(move |i| lowest * (to / lowest).powf(f64::from(i) / 80.0));
    let persson = pressures(highest).map(|p| (p, persson_area(p)));
    let linear_to = highest.min(0.5 / BUSH_GIBSON_THOMAS_KAPPA).max(lowest);
    let bush = pressures(linear_to).map(|p| (p, BUSH_GIBSON_THOMAS_KAPPA * p));
    [Series::line("Persson", 5, persson), Series { mark: Mark::Dashes, ..Series::line("Bush–Gibson–Thomas", 6, bush) }]
}

/// Values along a line beyond this number are thinned for the figure.
const MOST_POINTS: usize = 4000;

/// A map of the pressure, or its profile for a line contact.
pub(crate) fn draw_pressure(
    stem: &Path,
    grid: &Grid,
    pressure: &Array2<f64>,
    modulus: f64,
    unit: &str,
) -> Result<Vec<PathBuf>, Failure> {
    let values: Vec<f64> = pressure.iter().map(|p| p / modulus).collect();
    let [lx, ly] = grid.lengths();
    let label = "pressure *p*/*E*\\*";
    if grid.is_line() {
        let step = values.len().div_ceil(MOST_POINTS);
        let spacing = grid.spacing()[0];
        let highest = |part: &[f64]| part.iter().copied().fold(0.0, f64::max);
        let line = values.chunks(step).enumerate().map(|(i, part)| ((i * step) as f64 * spacing, highest(part)));
        let panel = Panel {
            x: Axis::linear(&format!("*x* / {unit}")),
            y: Axis::linear(label),
            series: vec![Series::line("", 0, line)],
            ..Panel::default()
        };
        return Ok(Chart::new(vec![panel]).save(stem).map_err(failed)?.to_vec());
    }
    let mut map = Map::new(&values, grid.points(), [lx, ly], label);
    map.x = format!("*x* / {unit}");
    map.y = format!("*y* / {unit}");
    map.below = Some(Below { threshold: 0.0, label: "no contact".into() });
    Ok(map.save(stem).map_err(failed)?.to_vec())
}
