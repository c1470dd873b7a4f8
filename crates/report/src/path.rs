//! Page about a path.

use gfmd_files::Reader;
use gfmd_plot::{Axis, Chart, Mark, Panel, Point, Series};
use gfmd_problem::options::Kinds;
use maud::html;

use crate::figures::{largest as farthest, length};
use crate::page::{
    Fact, Page, Stored, StoredSurface, config, given, number, of, option, powers, transforms, unit_for, whole,
};
use gfmd_input::failure::Failure;
use gfmd_input::hardness;
use gfmd_measure::GridLimit;
use gfmd_record::{State, with_limit};
use gfmd_unit::Units;

const CITED: [&str; 2] = [
    "C. Campañá, M. H. Müser, Practical Green’s function approach to the simulation of elastic semi-infinite solids, \
     Physical Review B 74, 075420 (2006).",
    "R. Pohrt, Q. Li, Complete boundary element formulation for normal and tangential contact problems, Physical \
     Mesomechanics 17, 334–340 (2014).",
];

/// Builds the page about the path in a file.
///
/// # Errors
/// Returns an error if the file has no steps.
pub fn page(reader: &Reader) -> Result<Page, Failure> {
    let stored = Stored::new(reader, "/path", "mean_pressure")?;
    let table = config(reader);
    let word = |name: &str| table.get(name).map(ToString::to_string).unwrap_or_default().replace('"', "");
    let mut page = Page { title: "Contact along a path".into(), cited: CITED.to_vec(), ..Page::default() };
    let column = |name: &str| stored.column(name);
    let [mean, p_star, approach, area, stick] =
        ["mean_pressure", "p_star", "approach", "area_fraction", "stick_fraction"].map(column);
    let angle = Some(of(&table, "direction")).filter(|angle| angle.is_finite()).unwrap_or(0.0).to_radians();
    let along = |x: &str, y: &str| -> Vec<f64> {
        column(x).iter().zip(column(y)).map(|(x, y)| x * angle.cos() + y * angle.sin()).collect()
    };
    let (lateral, shear) = (along("lateral_x", "lateral_y"), along("mean_shear_x", "mean_shear_y"));
    // Steps after the surfaces parted, or after a failure, were not computed.
    let converged = column("converged");
    let computed =
        mean.iter().zip(&converged).take_while(|(mean, converged)| mean.is_finite() && **converged != 0.0).count();
    let steps_of_leg = table.get("steps").and_then(toml::Value::as_integer).unwrap_or(1).max(1) as usize;
    let widest = (0..computed).max_by(|a, b| area[*a].total_cmp(&area[*b]));
    if computed == 0 {
        page.answer.push(html! { p.headline { "No step converged: there is no result" } });
        page.failure(reader, "step");
        return Ok(page);
    }
    let time = column("time");
    let relaxes = table.contains_key("prony");
    let sideways = lateral[..computed].iter().any(|value| value != &lateral[0]);

    let sum = |name: &str| column(name)[..computed].iter().copied().filter(|v| !v.is_nan()).reduce(|a, b| a + b);
    let dissipated = sum("dissipated").unwrap_or(f64::NAN);
    // The error of the sum is known if all errors are. Earlier versions wrote the imbalance of a step as its error.
    let is_error = !relaxes || column("work_imbalance").iter().any(|value| value.is_finite());
    let [losses, errors] = ["dissipated", "dissipated_error"].map(column);
    let parts = losses[..computed].iter().zip(&errors[..computed]);
    let error = parts.filter(|(lost, _)| !lost.is_nan()).map(|(_, error)| *error).sum::<f64>();
    let error = if is_error { error } else { f64::NAN };
    let units = stored.units();
    let (factor, unit) = unit_for(dissipated, "stress*length", &units);
    let lost = match stored.has("dissipated_limit") {
        true => {
            let steps = column("dissipated").into_iter().zip(column("dissipated_limit")).take(computed);
            let fine: f64 = steps.filter(|(lost, _)| !lost.is_nan()).map(|(_, fine)| fine).sum();
            let half_width = GridLimit::of_two_grids(dissipated, fine).half_width;
            let half_width = if error > half_width { error } else { half_width };
            powers(&with_limit(factor * dissipated, factor * fine, factor * half_width))
        }
        false => number(factor * dissipated),
    };
    page.answer.push(html! {
        p.headline {
            @if dissipated.is_finite() {
                (lost) span { (unit) } " lost along the path "
                @if error.is_finite() { span { "± " (number(factor * error)) (unit) } }
            } @else { "No energy is defined for this law" }
        }
    });
    let lowest = (0..computed).min_by(|a, b| mean[*a].total_cmp(&mean[*b])).unwrap_or(0);
    let friction = shear.iter().zip(&mean).take(computed).map(|(shear, mean)| (shear / mean).abs());
    page.answer.push(html! {
        p {
            (computed) " of " (stored.len()) " steps. "
            @if let Some(widest) = widest {
                "Largest contact area " (stored.said("area_fraction", widest, 100.0)) " %, "
            }
            "lowest mean pressure " (stored.said("mean_pressure", lowest, 1.0))
            @if sideways { ", largest ratio of shear to pressure " (number(friction.fold(f64::NAN, f64::max))) }
            ". "
            @if dissipated.is_finite() && !error.is_finite() {
                "No error of the lost energy is known. "
            }
        }
    });
    if computed < stored.len() {
        page.remarks.push(format!("the path ends after step {} of {}", computed.saturating_sub(1), stored.len() - 1));
    }
    let surface = StoredSurface::read(reader);
    let friction = ["friction", "shear_strength"].into_iter().find(|name| table.contains_key(*name));
    let law = friction.map_or_else(|| word("law"), |name| format!("hard wall, {}", name.replace('_', " ")));
    page.asked(&surface, &table, &law);
    let of_waypoints = [
        ("pressure", Kinds::STRESS),
        ("p_star", Kinds::NUMBER),
        ("approach", Kinds::LENGTH),
        ("lateral", Kinds::LENGTH),
        ("time", Kinds::TIME),
    ];
    let others = [
        ("prony", Kinds::PRONY),
        ("moduli", Kinds::NUMBER),
        ("relaxes", Kinds::NUMBER),
        ("friction", Kinds::NUMBER),
        ("shear_strength", Kinds::STRESS),
        ("hardness", Kinds::HARDNESS),
    ];
    let of_waypoints = of_waypoints.map(|(name, kinds)| (name, kinds, "waypoints, "));
    for (name, kinds, of) in of_waypoints.into_iter().chain(others.map(|(name, kinds)| (name, kinds, ""))) {
        if let Some(value) = table.get(name) {
            let term = format!("{of}{}", name.replace("p_star", "p*").replace('_', " "));
            page.asked.push(Fact(html! { (term) }, option(kinds, value, &units)));
        }
    }
    page.asked.push(Fact::new("steps between waypoints", &word("steps")));
    page.asked.push(Fact(html! { "tolerance" }, given(of(&table, "tolerance"))));

    let (Ok(unit), gradient) =
        (surface.as_ref().map(|s| s.unit.clone()), surface.as_ref().map_or(f64::NAN, |s| s.rms_gradient))
    else {
        return Ok(page);
    };
    // Unit of pressure E* g, from the step with the largest pressure.
    let loudest = (0..computed).max_by(|a, b| mean[*a].abs().total_cmp(&mean[*b].abs()));
    let scale = loudest.map_or(f64::NAN, |step| mean[step] / p_star[step]);
    // Motion that separates the directions of a loop, common to all panels.
    let drive = match (sideways, approach.iter().any(|value| value.is_finite())) {
        (true, _) => lateral.to_vec(),
        (false, true) => approach.to_vec(),
        (false, false) => p_star.to_vec(),
    };
    let panel = |x: &str, y: &str, points: Vec<(f64, f64)>| Panel {
        x: Axis::linear(x),
        y: Axis::linear(y),
        series: legs(&points, &drive, steps_of_leg),
        ..Panel::default()
    };
    let pairs =
        |x: &[f64], y: &[f64]| -> Vec<(f64, f64)> { x.iter().copied().zip(y.iter().copied()).take(computed).collect() };
    let reduced = "*p*/(*E*\\* *g*)";
    let shears: Vec<f64> = shear.iter().map(|shear| shear / scale).collect();
    let panels = match sideways {
        _ if relaxes => in_time([&area, &p_star, &approach].map(|values| pairs(&time, values)), reduced, &unit),
        true => {
            let read = length(&unit, farthest(&lateral[..computed]));
            let lateral: Vec<f64> = lateral.iter().map(|value| value * read.factor).collect();
            let x = format!("lateral displacement / {}", read.name);
            let (label, share) = if stick.iter().any(|share| share.is_finite()) {
                ("sticking area", &stick)
            } else {
                ("contact area", &area)
            };
            vec![panel(&x, "shear / (*E*\\* *g*)", pairs(&lateral, &shears)), panel(&x, label, pairs(&lateral, share))]
        }
        false => {
            let area = panel(reduced, "contact area", pairs(&p_star, &area));
            // The displacement may have no reference level.
            match approach.iter().any(|approach| approach.is_finite()) {
                true => {
                    let read = length(&unit, farthest(&approach[..computed]));
                    let approach: Vec<f64> = approach.iter().map(|value| value * read.factor).collect();
                    vec![panel(&format!("approach / {}", read.name), reduced, pairs(&approach, &p_star)), area]
                }
                false => vec![area],
            }
        }
    };
    let caption = match relaxes {
        true => html! { "Contact area, pressure and approach against time." },
        false => html! { "The path, leg by leg; each point is an equilibrium." },
    };
    if computed > 1 && !panels.is_empty() {
        page.chart(&Chart::new(panels), "the path", &caption);
    }
    // Fields are kept at the waypoints only; show the one with the largest contact.
    let waypoints = waypoints(&table, "time", computed, steps_of_leg);
    let at_waypoint = waypoints.iter().copied().max_by(|a, b| area[*a].total_cmp(&area[*b]));
    let hardness = surface.as_ref().ok().and_then(|surface| hardness::of_result(reader, &table, &surface.grid));
    let shown = at_waypoint.and_then(|step| waypoints.iter().position(|other| *other == step));
    let state = at_waypoint.map_or_else(String::new, |step| format!("step {step}"));
    page.fields(reader, &surface, (shown, &state, scale / gradient), hardness.as_ref());
    page.failure(reader, "step");

    let tolerance = of(&table, "tolerance");
    page.residual(&stored, tolerance);
    page.numbers::<State>(&stored, computed, "step");
    if let Some(widest) = widest {
        page.answer.push(html! {
            p { "The contact is largest at step " (widest) ", " i { "p" } "* = " (number(p_star[widest])) "." }
        });
    }
    page.cost.extend([
        Fact(html! { "transform pairs" }, transforms(stored.sum("transform_pairs"))),
        Fact(html! { "iterations" }, whole(stored.sum("iterations"))),
        Fact(html! { "additional solves" }, whole(stored.sum("extra_solves"))),
    ]);
    Ok(page)
}

/// Returns the indices of the steps with fields in a file. For legs with a `length`, the key of their times or
/// distances, these are the last steps of the legs.
pub(crate) fn waypoints(table: &toml::Table, length: &str, computed: usize, steps_of_leg: usize) -> Vec<usize> {
    let list = |name: &str| table.get(name).and_then(toml::Value::as_array).map_or(&[][..], Vec::as_slice);
    let lengths = list(length);
    if lengths.is_empty() {
        return (0..computed).step_by(steps_of_leg).collect();
    }
    let legs =
        ["pressure", "p_star", "approach"].map(|name| list(name).len()).into_iter().fold(lengths.len(), usize::max);
    let is_jump = |leg: usize| {
        let length = &lengths[leg.min(lengths.len() - 1)];
        length.as_float() == Some(0.0) || length.as_integer() == Some(0)
    };
    let ends = (0..legs).scan(0, |made, leg| {
        *made += if is_jump(leg) { 1 } else { steps_of_leg };
        Some(*made - 1)
    });
    ends.take_while(|end| *end < computed).collect()
}

/// Returns panels of contact area, reduced pressure and approach against time. The time axis is logarithmic, without
/// the state at time zero, if it spans more than two decades. A constant number has no panel.
pub fn in_time(columns: [Vec<(f64, f64)>; 3], reduced: &str, unit: &str) -> Vec<Panel> {
    let farthest = columns[2].iter().map(|(_, approach)| approach.abs()).filter(|size| size.is_finite());
    let read = length(unit, farthest.fold(0.0, f64::max));
    let [area, pressure, approach] = columns;
    let approach = approach.into_iter().map(|(time, value)| (time, value * read.factor)).collect();
    let labels = ["contact area".to_owned(), reduced.to_owned(), format!("approach / {}", read.name)];
    let time = Units::new(Some(unit), None).shown("time", 1.0).map_or("time".into(), |read| format!("time / {read}"));
    along(&time, [area, pressure, approach].into_iter().zip(labels).collect())
}

/// Returns panels of labelled columns against the length of a path. The axis is logarithmic, without a state at its
/// start, if it spans more than two decades. A constant number has no panel.
pub(crate) fn along(name: &str, columns: Vec<(Vec<(f64, f64)>, String)>) -> Vec<Panel> {
    let lengths =
        columns.iter().flat_map(|(points, _)| points).map(|(length, _)| *length).filter(|length| *length > 0.0);
    let [first, last] = lengths.fold([f64::INFINITY, 0.0], |[first, last], x| [x.min(first), x.max(last)]);
    let is_long = last > 100.0 * first;
    let panel = |(points, label): (Vec<(f64, f64)>, String)| {
        let shown = points.into_iter().filter(|(length, _)| !is_long || *length > 0.0).map(|(x, y)| Point::new(x, y));
        Panel {
            x: if is_long { Axis::log(name) } else { Axis::linear(name) },
            y: Axis::linear(&label),
            series: vec![Series { mark: Mark::JoinedPoints, ..Series::points("", 0, shown.collect()) }],
            ..Panel::default()
        }
    };
    let varies = |(points, _): &(Vec<(f64, f64)>, String)| {
        let values = || points.iter().map(|(_, value)| *value).filter(|value| value.is_finite());
        let [low, high] = [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)];
        high - low > 1e-6 * high.abs().max(low.abs())
    };
    columns.into_iter().filter(varies).map(panel).collect()
}

/// Returns a path of points, leg by leg: joined points where the `drive`, one number per point, rises, hollow points
/// and a broken line where it falls.
pub fn legs(points: &[(f64, f64)], drive: &[f64], steps_of_leg: usize) -> Vec<Series> {
    let last = points.len().saturating_sub(1);
    let leg = |(hue, start): (usize, usize)| {
        let end = (start + steps_of_leg).min(last);
        let points = points.get(start..=end).unwrap_or_default();
        let falls = drive.get(start).zip(drive.get(end)).is_some_and(|(first, last)| last < first);
        let points: Vec<Point> = points.iter().map(|(x, y)| Point::new(*x, *y)).collect();
        let series = |label: &str, mark| Series { mark, ..Series::points(label, hue, points.clone()) };
        match falls {
            false => vec![series(&format!("leg {}, rising", hue + 1), Mark::JoinedPoints)],
            true => {
                vec![series("", Mark::Dashes), series(&format!("leg {}, falling", hue + 1), Mark::HollowPoints)]
            }
        }
    };
    (0..last.max(1)).step_by(steps_of_leg).enumerate().flat_map(leg).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Attraction grows while the surfaces approach: the abscissa falls, the drive rises.
    #[test]
    fn directions_are_those_of_the_drive() {
        let (points, drive) = ([(0.0, 0.0), (-1.0, 1.0), (-2.0, 0.5), (0.0, 0.0)], [0.0, 1.0, 2.0, -1.0]);
        let labels: Vec<String> = legs(&points, &drive, 2).into_iter().map(|series| series.label).collect();
        assert_eq!(labels, ["leg 1, rising", "", "leg 2, falling"]);
        // A path that ended within its second leg, and one without a step.
        assert_eq!(legs(&points[..3], &drive[..3], 1).len(), 2);
        assert!(legs(&[], &[], 2).iter().all(|series| series.points.is_empty()));
    }
}
