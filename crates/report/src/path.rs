//! Page about a path, and its figures.

mod course;

use gfmd_files::Reader;
use gfmd_plot::Chart;
use gfmd_problem::options::KindsByKey;
use maud::{Markup, html};

use self::course::CAUSES;
pub use self::course::{Course, Drawing};
pub use crate::legs::leg_number;
use crate::legs::waypoints;
use crate::page::{
    Fact, Page, Stored, StoredSurface, config, given, number, of, option, powers, transforms, unit_for, whole,
};
use crate::strain::strained_body;
use crate::wear::worn_surface;
use gfmd_input::failure::Failure;
use gfmd_input::hardness;
use gfmd_measure::GridLimit;
use gfmd_record::{State, with_limit};

const CITED: [&str; 2] = [
    "C. Campañá, M. H. Müser, Practical Green’s function approach to the simulation of elastic semi-infinite solids, \
     Physical Review B 74, 075420 (2006).",
    "R. Pohrt, Q. Li, Complete boundary element formulation for normal and tangential contact problems, Physical \
     Mesomechanics 17, 334–340 (2014).",
];

const OF_WEAR: [&str; 1] =
    ["J. F. Archard, Contact and rubbing of flat surfaces, Journal of Applied Physics 24, 981–988 (1953)."];

/// Builds the page about the path in a file. `kinds` are the kinds of the options that the file records.
///
/// # Errors
/// Returns an error if the file has no steps.
pub fn page(reader: &Reader, kinds: &KindsByKey) -> Result<Page, Failure> {
    let stored = Stored::new(reader, "/path", "mean_pressure")?;
    let table = config(reader);
    let word = |name: &str| table.get(name).map(ToString::to_string).unwrap_or_default().replace('"', "");
    let mut page = Page { title: "Contact along a path".into(), cited: CITED.to_vec(), ..Page::default() };
    if table.contains_key("coefficient") {
        page.cited.extend(OF_WEAR);
    }
    let column = |name: &str| stored.column(name);
    let [mean, p_star, area] = ["mean_pressure", "p_star", "area_fraction"].map(column);
    let angle = Some(of(&table, "direction")).filter(|angle| angle.is_finite()).unwrap_or(0.0).to_radians();
    let along = |x: &str, y: &str| -> Vec<f64> {
        column(x).iter().zip(column(y)).map(|(x, y)| x * angle.cos() + y * angle.sin()).collect()
    };
    let (lateral, shear) = (along("lateral_x", "lateral_y"), along("mean_shear_x", "mean_shear_y"));
    // Steps after the surfaces parted, or after a failure, were not computed.
    let converged = column("converged");
    let computed =
        mean.iter().zip(&converged).take_while(|(mean, converged)| mean.is_finite() && **converged != 0.0).count();
    let widest = (0..computed).max_by(|a, b| area[*a].total_cmp(&area[*b]));
    if computed == 0 {
        page.answer.push(html! { p.headline { "No step converged: there is no result" } });
        page.failure(reader, "step");
        return Ok(page);
    }
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
    // Wear is the only cause of losses.
    let wears_alone = stored.has("wear_volume") && stored.has("distance") && !stored.has("lost_wear");
    page.answer.push(html! {
        p.headline {
            @if wears_alone {
                (stored.said("wear_volume", computed - 1, 1.0)) " "
                span { "lost on average over the distance " (stored.said("distance", computed - 1, 1.0)) }
            } @else if dissipated.is_finite() {
                (lost) span { (unit) } " lost along the path "
                @if error > 0.0 { span { "± " (number(factor * error)) (unit) } }
            } @else { "No energy is defined for this law" }
        }
        (stored.joint(computed - 1))
    });
    let lowest = (0..computed).min_by(|a, b| mean[*a].total_cmp(&mean[*b])).unwrap_or(0);
    let friction = shear.iter().zip(&mean).take(computed).map(|(shear, mean)| (shear / mean).abs());
    let peak = column("max_pressure");
    let deepest = column("plastic_displacement_min").get(computed - 1).copied().unwrap_or(f64::NAN);
    let (factor_of_imprint, imprint_unit) = unit_for(deepest, "length", &units);
    let ran_in = [0, computed - 1].map(|step| peak[step] / mean[step]);
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
        @if let Some(causes) = by_cause(&stored, computed, dissipated) { p { (causes) } }
        @if stored.has("yield_depth") {
            p {
                "The body has yielded to a depth of " (stored.said("yield_depth", computed - 1, 1.0))
                ", with a plastic strain of " (stored.said("max_plastic_strain", computed - 1, 1.0)) " at most. "
                "The deepest imprint is " (number(-factor_of_imprint * deepest))
                (imprint_unit) ". "
            }
        }
        @if stored.has("wear_volume") {
            p {
                @if wears_alone { "Energy lost: " (lost) (unit) ". " }
                "The surfaces have lost " (stored.said("wear_volume", computed - 1, 1.0)) " of their height on average"
                @if column("wear_volume_error").get(computed - 1).is_some_and(|error| error.is_finite()) {
                    " (estimated error " (stored.said("wear_volume_error", computed - 1, 1.0)) ")"
                }
                ", " (stored.said("max_wear", computed - 1, 1.0)) " at most. "
                @if ran_in.iter().all(|ratio| ratio.is_finite()) && computed > 1 {
                    "From the first step to the last, the contact area went from "
                    (stored.said("area_fraction", 0, 100.0)) " % to "
                    (stored.said("area_fraction", computed - 1, 100.0))
                    " % of the surface, the largest pressure divided by the mean from " (number(ran_in[0])) " to "
                    (number(ran_in[1])) ". "
                }
            }
        }
    });
    if computed < stored.len() {
        page.remarks.push(format!("the path ends after step {} of {}", computed.saturating_sub(1), stored.len() - 1));
    }
    let surface = StoredSurface::read(reader);
    page.asked(&surface, &table, &interface(&table));
    let of_waypoints = ["pressure", "p_star", "force", "approach", "lateral", "lateral_y", "time", "distance"];
    let others = [
        "prony",
        "moduli",
        "relaxes",
        "friction",
        "shear_strength",
        "friction_of",
        "hardness",
        "yield_stress",
        "hardening",
        "hardening_curve",
        "kinematic_hardening",
        "layer_yield",
        "coefficient",
        "wear_by",
        "boundary",
    ];
    let of_waypoints = of_waypoints.map(|name| (name, "waypoints, "));
    for (name, of) in of_waypoints.into_iter().chain(others.map(|name| (name, ""))) {
        let is_default = name == "boundary" && word(name) == "periodic";
        if let Some(value) = table.get(name).filter(|_| !is_default) {
            let term = match name {
                "coefficient" if units.stress().is_none() => "wear coefficient (1/stress)".into(),
                "coefficient" => "wear coefficient".into(),
                "friction_of" => "friction proportional to".into(),
                "lateral_y" => format!("{of}lateral, at a right angle"),
                _ => format!("{of}{}", name.replace("p_star", "p*").replace('_', " ")),
            };
            page.asked.push(Fact(html! { (term) }, option((name, kinds), value, &units)));
        }
    }
    let steps = table.get("steps").map_or_else(Default::default, |value| option(("steps", kinds), value, &units));
    page.asked.push(Fact(html! { "steps between waypoints" }, steps));
    page.asked.push(Fact(html! { "tolerance" }, given(of(&table, "tolerance"))));

    let (Ok(unit), gradient) =
        (surface.as_ref().map(|s| s.unit.clone()), surface.as_ref().map_or(f64::NAN, |s| s.rms_gradient))
    else {
        return Ok(page);
    };
    // Unit of pressure E* g, from the step with the largest pressure.
    let loudest = (0..computed).max_by(|a, b| mean[*a].abs().total_cmp(&mean[*b].abs()));
    let scale = loudest.map_or(f64::NAN, |step| mean[step] / p_star[step]);
    let waypoints = waypoints(&table, computed);
    let of_steps = |name: &str| column(name)[..computed].to_vec();
    let course = Course {
        column: &of_steps,
        direction: [angle.cos(), angle.sin()],
        waypoints: waypoints.clone(),
        relaxes,
        modulus: scale / gradient,
        unit_pressure: scale,
        unit: &unit,
        units: &units,
    };
    let drawings = if computed > 1 { course.drawings() } else { Vec::new() };
    for Drawing { title, panels, .. } in drawings {
        for (panel, caption) in panels {
            page.chart(&Chart::new(vec![panel]), title, &html! { (caption) });
        }
    }
    if let (Ok(surface), Some(index)) = (&surface, waypoints.len().checked_sub(1)) {
        worn_surface(&mut page, reader, surface, index);
        strained_body(&mut page, reader, surface, index);
    }
    // Fields are kept at the waypoints only; show the one with the largest contact.
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

/// Returns true if the first step of a path, given by its columns, takes no time and no distance.
fn loads_at_once(column: impl Fn(&str) -> Vec<f64>) -> bool {
    ["time", "distance"].iter().all(|name| !column(name).first().is_some_and(|length| *length > 0.0))
}

/// Returns the sum of the imbalances of work and energy of the steps of a path, given by its columns; `None` if no step
/// has one. A first step that takes no time and no distance is left out: it loads the surfaces at once, and the work of
/// a growing contact is no trapezium.
pub fn work_imbalance(column: impl Fn(&str) -> Vec<f64>) -> Option<f64> {
    let known: Vec<(usize, f64)> =
        column("work_imbalance").into_iter().enumerate().filter(|(_, value)| value.is_finite()).collect();
    let first = usize::from(loads_at_once(column));
    // A sum of no numbers would be -0.
    let sum = known.iter().filter(|(step, _)| *step >= first).fold(0.0, |sum, (_, value)| sum + value);
    (!known.is_empty()).then_some(sum)
}

/// Returns the interface of a path, or of steady sliding, in words: the law or the wall, and the further parts.
pub(crate) fn interface(table: &toml::Table) -> String {
    let word = |name: &str| table.get(name).and_then(toml::Value::as_str).unwrap_or_default();
    let mut parts = vec![match word("law") {
        "hard-wall" | "" => "hard wall",
        law => law,
    }];
    let further = [
        ("friction", "friction"),
        ("shear_strength", "shear strength"),
        ("hardness", "hardness"),
        ("yield_stress", "yielding body"),
        ("coefficient", if word("wear_by") == "slip" { "wear by slip" } else { "wear by distance" }),
    ];
    parts.extend(further.into_iter().filter(|(key, _)| table.contains_key(*key)).map(|(_, said)| said));
    parts.join(", ")
}

/// Formats a share in percent with two digits, at most two of them decimals.
fn rough(percent: f64) -> Markup {
    let digits = (1 - percent.abs().max(0.1).log10().floor() as i32).max(0) as usize;
    if percent == 0.0 {
        html! { "0" }
    } else {
        html! { (format!("{percent:.digits$}")) }
    }
}

/// Returns the parts of the lost energy by cause; `None` unless there are several causes.
fn by_cause(stored: &Stored, computed: usize, dissipated: f64) -> Option<Markup> {
    let there: Vec<_> = CAUSES.iter().filter(|(column, _)| stored.has(column)).collect();
    if there.len() < 2 || dissipated.is_nan() || dissipated <= 0.0 {
        return None;
    }
    let sum = |name: &str| -> f64 { stored.column(name)[..computed].iter().filter(|value| value.is_finite()).sum() };
    let column = |name: &str| stored.column(name)[..computed].to_vec();
    let imbalance = work_imbalance(column).filter(|_| computed > 1).map(|sum| sum / dissipated);
    let start = if loads_at_once(column) { "After the first step, work" } else { "Work" };
    Some(html! {
        "Lost by "
        @for (index, (column, cause)) in there.iter().enumerate() {
            @if index > 0 { ", " }
            (cause) " " (rough(100.0 * sum(column) / dissipated)) " %"
        }
        ". "
        @if let Some(imbalance) = imbalance {
            (start) " and energies balance to " (rough(100.0 * imbalance)) " % of the loss. "
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A first step that loads at once has no balance; one that takes time has.
    #[test]
    fn the_total_leaves_out_a_first_step_at_once() {
        let of = |times: &[f64], distances: &[f64]| {
            work_imbalance(|name: &str| match name {
                "work_imbalance" => vec![8.0, 2.0, f64::NAN, 1.0],
                "time" => times.to_vec(),
                "distance" => distances.to_vec(),
                _ => Vec::new(),
            })
        };
        assert_eq!(of(&[], &[]), Some(3.0));
        assert_eq!(of(&[0.0, 1.0], &[f64::NAN; 2]), Some(3.0));
        assert_eq!(of(&[1.0, 2.0], &[]), Some(11.0));
        assert_eq!(of(&[0.0, 0.0], &[0.5, 1.0]), Some(11.0));
        assert_eq!(work_imbalance(|_| vec![f64::NAN; 3]), None);
        assert_eq!(work_imbalance(|name| if name == "work_imbalance" { vec![4.0] } else { vec![] }), Some(0.0));
    }
}
