//! The page about steady sliding, and its figure.

use gfmd_files::Reader;
use gfmd_plot::{Axis, Chart, Mark, Panel, Point, Series};
use maud::html;

use crate::page::{Certificate, Fact, Page, Stored, StoredSurface, Table, config, given, number, of, whole};
use gfmd_run::failure::Failure;

const CITED: [&str; 1] = ["B. N. J. Persson, Theory of rubber friction and contact mechanics, Journal of Chemical \
     Physics 115, 3840–3861 (2001)."];

/// The columns of the table: names in a file, and their heads.
const COLUMNS: [(&str, &str); 9] = [
    ("velocity", "velocity"),
    ("mean_pressure", "pressure"),
    ("p_star", "p*"),
    ("displacement", "approach"),
    ("area_fraction", "area"),
    ("friction", "friction"),
    ("friction_slope", "by slopes"),
    ("persson_friction", "Persson"),
    ("mean_gap", "mean gap"),
];

/// The label of the velocity, whose unit of time is that of the relaxation times.
const VELOCITY: &str = "velocity / (length/time)";

/// A state of steady sliding for its figure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sliding {
    /// Velocity, length over the unit of the relaxation times.
    pub velocity: f64,
    /// Reduced pressure.
    pub p_star: f64,
    /// Coefficient of friction, and its value in Persson's theory.
    pub friction: [f64; 2],
    /// Contact area fraction, and its value in Persson's theory.
    pub area: [f64; 2],
}

/// Friction and contact area against the velocity, a curve for each load, with `velocities` points each.
pub fn chart(states: &[Sliding], velocities: usize) -> Chart {
    let curves = |of: fn(&Sliding) -> [f64; 2]| -> Vec<Series> {
        let curve = |(hue, states): (usize, &[Sliding])| {
            let points = |which: usize| states.iter().map(|s| Point::new(s.velocity, of(s)[which])).collect();
            let label = format!("*p*\\* = {:.3}", states[0].p_star);
            let theory = Series::points(if hue == 0 { "Persson" } else { "" }, hue, points(1));
            [
                Series { mark: Mark::JoinedPoints, ..Series::points(&label, hue, points(0)) },
                Series { mark: Mark::Line, ..theory },
            ]
        };
        states.chunks(velocities.max(1)).enumerate().flat_map(curve).collect()
    };
    let panel = |label: &str, series: Vec<Series>| Panel {
        x: if velocities > 1 { Axis::log(VELOCITY) } else { Axis::linear(VELOCITY) },
        y: Axis::linear(label),
        series,
        ..Panel::default()
    };
    let panels =
        vec![panel("friction", curves(|state| state.friction)), panel("contact area", curves(|state| state.area))];
    Chart { share_y: false, ..Chart::new(panels) }
}

/// The page about the sliding in a file.
///
/// # Errors
/// A file without states.
pub fn page(reader: &Reader) -> Result<Page, Failure> {
    let stored = Stored::new(reader, "/states", "mean_pressure")?;
    let table = config(reader);
    let mut page =
        Page { title: "Steady sliding on a viscoelastic body".into(), cited: CITED.to_vec(), ..Page::default() };
    let column = |name: &str| stored.column(name);
    let [velocity, p_star, mean, friction, converged] =
        ["velocity", "p_star", "mean_pressure", "friction", "converged"].map(column);
    let [theory, area, theory_area] = ["persson_friction", "area_fraction", "persson_area_fraction"].map(column);
    let solved: Vec<usize> =
        (0..stored.len()).filter(|&state| mean[state].is_finite() && converged[state] != 0.0).collect();
    let largest = solved.iter().copied().max_by(|a, b| friction[*a].total_cmp(&friction[*b]));
    match largest {
        Some(state) => page.answer.push(html! {
            p.headline {
                "Coefficient of friction " (number(friction[state])) " "
                span { "at the velocity " (given(velocity[state])) ", " i { "p" } "* = " (given(p_star[state])) }
            }
            p {
                "The largest of " (solved.len()) " states. Persson's theory has " (number(theory[state]))
                "; the contact area is " (number(100.0 * area[state])) " % of the surface. "
            }
        }),
        None => page.answer.push(html! { p.headline { "No state converged: there is no result" } }),
    }
    let surface = StoredSurface::read(reader);
    page.asked(&surface, &table, "hard wall");
    let word = |name: &str| table.get(name).map(ToString::to_string).unwrap_or_default().replace('"', "");
    for (term, key) in [
        ("branches (relaxation time, fraction)", "prony"),
        ("modulus that the branches relax", "moduli"),
        ("part that relaxes", "relaxes"),
        ("velocities", "velocity"),
        ("pressures", "pressure"),
        ("reduced pressures", "p_star"),
        ("direction of sliding, degrees", "direction"),
    ] {
        if table.contains_key(key) {
            page.asked.push(Fact::new(term, &word(key)));
        }
    }
    let tolerance = of(&table, "tol");
    page.asked.push(Fact(html! { "tolerance" }, given(tolerance)));
    // Each load has as many states as there are before a velocity comes again.
    let again = velocity.iter().skip(1).position(|other| Some(other) == velocity.first());
    let velocities = again.map_or(velocity.len(), |place| place + 1);
    let states: Vec<Sliding> = (0..stored.len())
        .map(|k| Sliding {
            velocity: velocity[k],
            p_star: p_star[k],
            friction: [friction[k], theory[k]],
            area: [area[k], theory_area[k]],
        })
        .collect();
    if solved.len() == stored.len() && velocities > 1 {
        let caption = html! { "Friction and contact area against the velocity, and Persson's theory (lines)." };
        page.chart(&chart(&states, velocities), "friction against velocity", &caption);
    }
    if let (Some(state), Ok(of)) = (largest, &surface) {
        let modulus = mean[state] / (p_star[state] * of.rms_gradient);
        page.fields(reader, &surface, (Some(state), modulus), None);
    }
    let units = |name: &str| stored.unit(name);
    page.tables.push(Table {
        caption: html! { "The states." },
        head: [html! { "state" }]
            .into_iter()
            .chain(COLUMNS.map(|(name, head)| {
                html! { span title=(stored.definition(name)) { (head) } br; small { (units(name)) } }
            }))
            .collect(),
        rows: (0..stored.len())
            .map(|row| {
                let cells = COLUMNS.map(|(name, _)| number(stored.column(name)[row]));
                [whole(row as f64)].into_iter().chain(cells).collect()
            })
            .collect(),
    });
    page.certificates.push(Certificate {
        name: "largest of all conditions".into(),
        largest: stored.worst("residual"),
        allowed: tolerance,
    });
    page.failure(reader, "state");
    page.cost.extend([
        Fact(html! { "transform pairs" }, number(stored.sum("transform_pairs"))),
        Fact(html! { "iterations" }, whole(stored.sum("iterations"))),
        Fact(html! { "time" }, html! { (number(stored.sum("seconds"))) " s" }),
    ]);
    Ok(page)
}
