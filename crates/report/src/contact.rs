//! Page about a contact.

use gfmd_files::Reader;
use gfmd_plot::{Chart, Mark, Point, Series};
use gfmd_problem::options::KindsByKey;
use maud::html;

use crate::figures::{area_chart, theories};
use crate::page::{
    Certificate, FaceFields, Fact, Page, Stored, StoredSurface, config, given, number, of, option, text,
};
use gfmd_input::failure::Failure;
use gfmd_input::{hardness, lower};
use gfmd_record::State;

const CITED: [&str; 3] = [
    "C. Campañá, M. H. Müser, Practical Green’s function approach to the simulation of elastic semi-infinite solids, \
     Physical Review B 74, 075420 (2006).",
    "I. A. Polonsky, L. M. Keer, A numerical method for solving rough contact problems based on the multi-level \
     multi-summation and conjugate gradient techniques, Wear 231, 206–219 (1999).",
    "V. A. Yastrebov, G. Anciaux, J.-F. Molinari, On the accurate computation of the true contact-area in mechanical \
     contact of random rough surfaces, Tribology International 114, 161–171 (2017): the perimeter correction.",
];

/// Builds the page about the contact in a file. `kinds` are the kinds of the options that the file records.
///
/// # Errors
/// Returns an error if the file has no loads.
pub fn page(reader: &Reader, kinds: &KindsByKey) -> Result<Page, Failure> {
    let loads = Stored::new(reader, "/loads", "mean_pressure")?;
    let table = config(reader);
    let word = |name: &str| table.get(name).map(ToString::to_string).unwrap_or_default().replace('"', "");
    let mut page = Page { title: "Contact of a rough surface".into(), cited: CITED.to_vec(), ..Page::default() };
    let column = |name: &str| loads.column(name);
    let [p_star, area, corrected, kappa] = ["p_star", "area_fraction", "area_fraction_corrected", "kappa"].map(column);
    let mean = column("mean_pressure");
    // Skip loads that did not converge. A file of another program may lack this column but has the residuals.
    let converged = column("converged");
    let solved = (0..loads.len()).filter(|&load| mean[load].is_finite() && converged[load] != 0.0);
    let solved: Vec<usize> = solved.collect();
    let surface = StoredSurface::read(reader);
    let is_line = surface.as_ref().is_ok_and(|surface| surface.grid.is_line());

    if let Some(&last) = solved.last() {
        let shown = |name: &str, times: f64| loads.said(name, last, times);
        let error = column("area_fraction_grid_error")[last];
        page.answer.push(html! {
            p.headline {
                (shown("area_fraction", 100.0)) " % of the surface is in contact "
                span { "at " i { "p" } "* = " (given(p_star[last])) }
            }
            (loads.joint(last))
        });
        page.answer.push(html! {
            p {
                @if loads.has("force") { "Force " (shown("force", 1.0)) ", mean pressure " } @else { "Mean pressure " }
                (shown("mean_pressure", 1.0)) ", approach " (shown("approach", 1.0)) ", mean gap "
                (shown("mean_gap", 1.0)) ", largest pressure " (shown("max_pressure", 1.0)) ". "
                @if kappa[last].is_finite() {
                    "κ = " i { "a" } sub { "r" } "/" i { "p" } "* = " (shown("kappa", 1.0)) ". "
                }
                @if loads.has("area_fraction_limit") && !error.is_finite() {
                    "Two digits and ~: the grid error of the number is not known. "
                }
                @if error.is_finite() {
                    "Numbers with brackets are those of an infinitely fine grid; the brackets have the error of their \
                     last digits (95 %). "
                    "On this grid " (number(100.0 * area[last])) " % of the points are in contact, with an error of at \
                        most "
                    (format!("{:.1}", 100.0 * error)) " % of the surface. "
                } @else if !is_line {
                    "These are counted points; corrected for the pixels along the perimeter the area is "
                    (number(100.0 * corrected[last])) " %, and the distance of the two is a measure of the error of \
                        this grid. "
                }
                @if solved.len() > 1 { "The last of " (solved.len()) " loads." }
            }
        });
    }
    if solved.is_empty() {
        page.answer.push(html! { p.headline { "No load converged: there is no result" } });
    }
    page.asked(&surface, &table, &word("law"));
    if !word("boundary").is_empty() {
        page.asked.push(Fact::new("boundary of the cell", &word("boundary")));
    }
    match word("components").as_str() {
        "all" => page.asked.push(Fact::new("unknown displacement", "all components, without lateral traction")),
        "held" => page.asked.push(Fact::new("lateral displacement", "held at zero on the whole surface")),
        _ => {}
    }
    if table.contains_key("finite_slope") {
        page.asked
            .push(Fact::new("slopes", "finite: displaced points, pressures along the normal of the rigid surface"));
    }
    match table.get("hardness") {
        Some(toml::Value::String(file)) => {
            page.asked.push(Fact::new("hardness", &format!("that of each point, {file}")))
        }
        Some(hardness) => {
            page.asked.push(Fact(html! { "hardness" }, option(("hardness", kinds), hardness, &loads.units())))
        }
        None => {}
    }
    page.asked.push(Fact::new("loads", &format!("{} ({})", loads.len(), controlled(&table))));
    let tolerance = of(&table, "tolerance");
    page.asked.push(Fact(html! { "solver" }, html! { (text(&word("solver"))) ", tolerance " (given(tolerance)) }));

    let drawn = AREAS.map(column);
    let points: Vec<[f64; 5]> = solved.iter().map(|&load| drawn.each_ref().map(|column| column[load])).collect();
    if points.len() > 1 && word("law") == "hard-wall" {
        let caption = html! {
            "Contact area against the reduced pressure " i { "p" } "* = " i { "p" } "/(" i { "E" } "* " i { "g" } ")."
        };
        page.chart(&areas(&points, is_line), "contact area against pressure", &caption);
    }
    // E* from the load with the largest pressure: with a law a load may be zero.
    let loudest = solved.iter().copied().max_by(|a, b| mean[*a].abs().total_cmp(&mean[*b].abs()));
    let modulus = loudest.map_or(f64::NAN, |load| {
        let gradient = surface.as_ref().map_or(f64::NAN, |surface| surface.rms_gradient);
        mean[load] / (p_star[load] * gradient)
    });
    let hardness = surface.as_ref().ok().and_then(|surface| hardness::of_result(reader, &table, &surface.grid));
    let state = solved.last().map_or_else(String::new, |last| format!("load {last}"));
    page.fields(reader, &surface, (solved.last().copied(), &state, modulus), hardness.as_ref());
    if lower::is_stored(reader) {
        page.asked.push(Fact::new("lower surface", &reader.text("/lower", "description").unwrap_or_default()));
        if let (Ok(surface), Some(&last)) = (&surface, solved.last()) {
            page.face(reader, surface, (last, &state, modulus), None, &FaceFields::LOWER);
        }
    }
    page.failure(reader, "load");

    let names = loads.names("residual_");
    page.certificates.extend(names.into_iter().map(|name| {
        let largest = loads.worst(&name);
        Certificate { name: name.trim_start_matches("residual_").replace('_', " "), largest, allowed: tolerance }
    }));
    page.numbers::<State>(&loads, loads.len(), "load");
    page.effort(&loads);
    Ok(page)
}

/// Returns the name of the prescribed quantity of a configuration.
fn controlled(table: &toml::Table) -> &'static str {
    match ["approach", "p_star", "force"].map(|name| table.contains_key(name)) {
        [true, ..] => "prescribed approach",
        [_, true, _] => "prescribed reduced pressure",
        [.., true] => "prescribed force",
        _ => "prescribed mean pressure",
    }
}

/// Columns of a load that [`areas`] needs.
pub const AREAS: [&str; 5] =
    ["p_star", "area_fraction", "area_fraction_corrected", "area_fraction_limit", "area_fraction_limit_error"];

/// Returns a chart of the contact area against the reduced pressure, for loads given by the columns [`AREAS`] in any
/// order. It shows the limit on an infinitely fine grid with its error if known, otherwise the counted and the
/// corrected area. The line runs from the lowest to the highest load.
pub fn areas(loads: &[[f64; 5]], is_line: bool) -> Chart {
    let mut loads = loads.to_vec();
    loads.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let column = |k: usize| loads.iter().map(|load| Point::new(load[0], load[k])).collect();
    let known = loads.iter().filter(|load| load[3].is_finite() && load[4].is_finite());
    let limits: Vec<Point> = known.map(|load| Point::with_error(load[0], load[3], load[4])).collect();
    let counted = Series { mark: Mark::JoinedPoints, ..Series::points("counted points", 0, column(1)) };
    let mut series = if limits.is_empty() {
        let label = "perimeter corrected".into();
        let corrected = Series { label, hue: 1, mark: Mark::HollowPoints, points: column(2) };
        [counted].into_iter().chain((!is_line).then_some(corrected)).collect()
    } else {
        vec![
            Series { mark: Mark::JoinedPoints, ..Series::points("infinitely fine grid, 95 %", 0, limits) },
            Series { hue: 1, mark: Mark::HollowPoints, ..counted },
        ]
    };
    if !is_line {
        let p_star = || loads.iter().map(|load| load[0]);
        series.extend(theories(p_star().fold(f64::INFINITY, f64::min), p_star().fold(0.0, f64::max)));
    }
    area_chart(series)
}
