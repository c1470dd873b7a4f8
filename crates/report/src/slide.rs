//! Page about steady sliding, and its figures.

use gfmd_field::Grid;
use gfmd_files::Reader;
use gfmd_plot::{Axis, Chart, Mark, Panel, Point, Series};
use gfmd_problem::options::KindsByKey;
use gfmd_record::{Record, Sliding, SlidingFacts, with_limit};
use gfmd_unit::Units;
use maud::html;

use crate::figures::{Drawn, field};
use crate::page::{Fact, Page, Stored, StoredSurface, config, given, number, of, option, powers, with_unit};
use crate::path::interface;
use gfmd_input::failure::Failure;
use gfmd_input::hardness;

const OF_FRICTION: &str = "B. N. J. Persson, Theory of rubber friction and contact mechanics, Journal of Chemical \
     Physics 115, 3840–3861 (2001).";
const OF_HEAT: &str = "J. C. Jaeger, Moving sources of heat and the temperature at sliding contacts, Journal and \
     Proceedings of the Royal Society of New South Wales 76, 203–224 (1942).";

/// Formats a number with an unknown grid error.
fn rough(value: f64) -> maud::Markup {
    powers(&with_limit(value, f64::NAN, f64::NAN))
}

/// Returns the axis for this number of velocities.
fn axis(velocities: usize, units: &Units) -> Axis {
    let label = format!("velocity / ({})", units.name("length/time"));
    if velocities > 1 { Axis::log(&label) } else { Axis::linear(&label) }
}

/// Returns the point of a number against the velocity.
fn point(state: &Record<Sliding>, name: &str) -> Point {
    Point::new(state.number("velocity"), state.number(name))
}

/// Returns a chart of friction and contact area against velocity, with one curve of `velocities` points per load.
pub fn chart(states: &[Record<Sliding>], velocities: usize, units: &Units) -> Chart {
    let curves = |names: [&'static str; 2]| -> Vec<Series> {
        let curve = |(hue, states): (usize, &[Record<Sliding>])| {
            let points = |name: &str| states.iter().map(|s| point(s, name)).collect();
            let label = format!("*p*\\* = {:.3}", states[0].number("p_star"));
            let theory = Series::points(if hue == 0 { "Persson" } else { "" }, hue, points(names[1]));
            [
                Series { mark: Mark::JoinedPoints, ..Series::points(&label, hue, points(names[0])) },
                Series { mark: Mark::Line, ..theory },
            ]
        };
        states.chunks(velocities.max(1)).enumerate().flat_map(curve).collect()
    };
    let panel = |label: &str, series: Vec<Series>| Panel {
        x: axis(velocities, units),
        y: Axis::linear(label),
        series,
        ..Panel::default()
    };
    // Persson's theory has no friction of the interface.
    let (label, name) = match states.iter().any(|state| state.number("friction_interface") > 0.0) {
        true => ("friction by hysteresis", "friction_hysteresis"),
        false => ("friction", "friction"),
    };
    let panels = vec![
        panel(label, curves([name, "persson_friction"])),
        panel("contact area", curves(["area_fraction", "persson_area_fraction"])),
    ];
    Chart { share_y: false, ..Chart::new(panels) }
}

/// Returns a chart of largest and mean contact temperature against velocity, with `velocities` points per load.
pub fn rises(states: &[Record<Sliding>], velocities: usize, units: &Units) -> Chart {
    let curve = |(hue, states): (usize, &[Record<Sliding>])| {
        let points = |name: &str| states.iter().map(|s| point(s, name)).collect();
        let label = format!("largest, *p*\\* = {:.3}", states[0].number("p_star"));
        let mean = Series::points(if hue == 0 { "mean in contact" } else { "" }, hue, points("heat_mean_rise"));
        [
            Series { mark: Mark::JoinedPoints, ..Series::points(&label, hue, points("heat_max_rise")) },
            Series { mark: Mark::Line, ..mean },
        ]
    };
    let label = format!("rise of the temperature / {}", units.name("temperature"));
    let panel = Panel {
        x: axis(velocities, units),
        y: if velocities > 1 { Axis::log(&label) } else { Axis::linear(&label) },
        series: states.chunks(velocities.max(1)).enumerate().flat_map(curve).collect(),
        ..Panel::default()
    };
    Chart::new(vec![panel])
}

/// Returns the figure of a temperature above the surface mean, on a grid with lengths in `length`.
pub fn temperature<'a>(grid: &Grid, values: &'a [f64], length: &str, units: &Units) -> Drawn<'a> {
    field(grid, values, &format!("temperature *T* / {}", units.name("temperature")), length)
}

/// Builds the page about the sliding in a file. `kinds` are the kinds of the options that the file records.
///
/// # Errors
/// Returns an error if the file has no states.
pub fn page(reader: &Reader, kinds: &KindsByKey) -> Result<Page, Failure> {
    let stored = Stored::new(reader, "/states", "mean_pressure")?;
    let table = config(reader);
    let mut page = Page { title: "Steady sliding".into(), ..Page::default() };
    let column = |name: &str| stored.column(name);
    let [velocity, p_star, mean, friction, converged] =
        ["velocity", "p_star", "mean_pressure", "friction", "converged"].map(column);
    let [theory, of_interface] = ["persson_friction", "friction_interface"].map(column);
    let solved: Vec<usize> =
        (0..stored.len()).filter(|&state| mean[state].is_finite() && converged[state] != 0.0).collect();
    let (is_viscoelastic, has_heat) = (table.contains_key("prony"), stored.has("heat_max_rise"));
    let (has_friction, has_hardness) = (table.contains_key("friction"), stored.has("plastic_fraction"));
    let plastic = column("plastic_fraction");
    let [max_rise, mean_rise, fraction] = ["heat_max_rise", "heat_mean_rise", "heat_fraction"].map(column);
    let of_largest = |values: &[f64]| solved.iter().copied().max_by(|a, b| values[*a].total_cmp(&values[*b]));
    let largest = of_largest(if is_viscoelastic || has_friction { &friction } else { &max_rise });
    let units = stored.units();
    let limit = |name: &str, state: usize| {
        let of = |end: &str| column(&format!("{name}{end}"))[state];
        powers(&with_limit(of(""), of("_limit"), of("_limit_error")))
    };
    let place = |state: usize| {
        let velocity = with_unit(velocity[state], "length/time", &units);
        html! { "at the velocity " (velocity) ", " i { "p" } "* = " (given(p_star[state])) }
    };
    if largest.is_none() {
        page.answer.push(html! { p.headline { "No state converged: there is no result" } });
    }
    if let (Some(state), true) = (largest, is_viscoelastic || has_friction) {
        if is_viscoelastic {
            page.cited.push(OF_FRICTION);
        }
        page.answer.push(html! {
            p.headline { "Coefficient of friction " (limit("friction", state)) " " span { (place(state)) } }
            p {
                "The largest of " (solved.len()) " states. "
                @if has_friction {
                    "The interface has " (given(of_interface[state])) ", the deformation of the body "
                    (limit("friction_hysteresis", state)) ". "
                }
                @if is_viscoelastic { "Persson's theory of hysteresis has " (number(theory[state])) ". " }
                "The contact area is " (limit("area_fraction", state)) " of the surface. "
                @if has_hardness { "At " (rough(100.0 * plastic[state])) " % of it the pressure is the hardness. " }
            }
        });
    }
    let unit = stored.unit("heat_max_rise");
    if let (Some(state), true) = (of_largest(&max_rise), has_heat) {
        page.cited.push(OF_HEAT);
        page.answer.push(html! {
            p.headline {
                "Largest rise of the temperature " (rough(max_rise[state])) " " (unit) " " span { (place(state)) }
            }
            p {
                "Above the mean of the surface; the mean in contact is " (rough(mean_rise[state])) " " (unit) ". "
                @if fraction[state] != 1.0 { "The body takes " (rough(100.0 * fraction[state])) " % of the heat. " }
            }
        });
    }
    let surface = StoredSurface::read(reader);
    page.asked(&surface, &table, &interface(&table));
    for (term, key) in [
        ("branches (relaxation time, fraction)", "prony"),
        ("modulus that the branches relax", "moduli"),
        ("part that relaxes", "relaxes"),
        ("velocities", "velocity"),
        ("pressures", "pressure"),
        ("reduced pressures", "p_star"),
        ("forces", "force"),
        ("direction of sliding, degrees", "direction"),
        ("conductivity and diffusivity", "heat"),
        ("friction of the interface", "friction"),
        ("hardness", "hardness"),
    ] {
        if let Some(value) = table.get(key) {
            page.asked.push(Fact(html! { (term) }, option((key, kinds), value, &units)));
        }
    }
    let tolerance = of(&table, "tolerance");
    page.asked.push(Fact(html! { "tolerance" }, given(tolerance)));
    // The states of a load end where the first velocity occurs again.
    let again = velocity.iter().skip(1).position(|other| Some(other) == velocity.first());
    let velocities = again.map_or(velocity.len(), |place| place + 1);
    let facts = SlidingFacts { heat: has_heat, hardness: has_hardness, ..SlidingFacts::default() };
    let states = stored.records::<Sliding>(&facts);
    if solved.len() == stored.len() && velocities > 1 {
        if is_viscoelastic {
            let caption = html! { "Friction and contact area against the velocity, and Persson's theory (lines)." };
            page.chart(&chart(&states, velocities, &stored.units()), "friction against velocity", &caption);
        }
        if has_heat {
            let caption = html! { "Largest temperature in contact, and the mean (lines), against the velocity." };
            page.chart(&rises(&states, velocities, &stored.units()), "temperature against velocity", &caption);
        }
    }
    if let (Some(state), Ok(of)) = (solved.last().copied(), &surface) {
        let modulus = mean[state] / (p_star[state] * of.rms_gradient);
        if let (true, Ok(values)) = (has_heat, reader.slab("/fields/temperature", state)) {
            let caption = html! { "Temperature above the mean of the surface, state " (state) "." };
            page.field(&temperature(&of.grid, &values, &of.unit, &of.units), "temperature", &caption);
        }
        let hardness = hardness::of_result(reader, &table, &of.grid);
        page.fields(reader, &surface, (Some(state), &format!("state {state}"), modulus), hardness.as_ref());
    }
    page.numbers::<Sliding>(&stored, stored.len(), "state");
    page.residual(&stored, tolerance);
    if has_heat {
        page.certificate("temperatures of both bodies", stored.worst("heat_residual"), tolerance);
    }
    page.failure(reader, "state");
    page.effort(&stored);
    Ok(page)
}
