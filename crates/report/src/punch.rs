//! Page about a punch.

use gfmd_field::Grid;
use gfmd_files::Reader;
use gfmd_plot::{Axis, Chart, Colours, Panel, Series};
use maud::html;

use crate::figures::{Drawn, about_zero, field};
use crate::page::{Fact, Page, Table, body, config, given, number, of, text, transforms};
use gfmd_input::failure::Failure;
use gfmd_unit::Units;

const CITED: [&str; 1] =
    ["I. A. Polonsky, L. M. Keer, A numerical method for solving rough contact problems based on the multi-level \
     multi-summation and conjugate gradient techniques, Wear 231, 206–219 (1999)."];

/// Label of the pressure.
const PRESSURE: &str = "pressure / mean pressure";

/// Builds the page about the punch in a file.
///
/// # Errors
/// Returns an error if the file has no fields of a punch.
pub fn page(reader: &Reader) -> Result<Page, Failure> {
    let unusable = |error: &dyn std::fmt::Display| Failure::refused(error.to_string());
    let table = config(reader);
    let value = |name: &str| single(reader, "/punch", name);
    let word = |name: &str| table.get(name).map(ToString::to_string).unwrap_or_default().replace('"', "");
    let mut page =
        Page { title: "Flat rigid punch on an elastic body".into(), cited: CITED.to_vec(), ..Page::default() };
    let [depth, mean, most, residual] = ["depth", "mean_pressure", "max_pressure", "residual"].map(value);
    let converged = value("converged") != 0.0;
    page.answer.push(if converged {
        html! {
            p.headline { "Mean pressure " (number(mean)) " " span { "at the depth " (given(depth)) } }
            p {
                "It is the force over the whole cell. The largest pressure, beside the edge, is " (number(most))
                ": it grows without limit as the grid is refined. "
                "The elastic energy per area is " (number(value("elastic_energy"))) ". "
            }
        }
    } else {
        html! { p.headline { "The search did not converge: there is no result" } }
    });
    let path = "/fields/displacement";
    let shape = reader.shape(path).map_err(|error| unusable(&error))?;
    let (points, components) = match shape[..] {
        [nx, components @ (2 | 3)] => ([nx, 1], components),
        [nx, ny, components @ (2 | 3)] => ([nx, ny], components),
        _ => return Err(Failure::refused(format!("{path} has the shape {shape:?}; it must be that of a surface"))),
    };
    // The cell is one step longer than the distance from the first to the last point.
    let side = |axis: &str, n: usize| -> f64 {
        let places: Vec<f64> = reader.values(&format!("/fields/{axis}")).unwrap_or_default();
        let step = if places.len() > 1 { places[1] - places[0] } else { 1.0 };
        step * n as f64
    };
    let lengths = [side("x", points[0]), if points[1] == 1 { 1.0 } else { side("y", points[1]) }];
    let grid = Grid::new(points, lengths).map_err(|error| unusable(&error))?;
    let [nx, ny] = points;
    page.asked.push(Fact::new("contact", &word("contact")));
    page.asked.push(Fact(
        html! { "grid" },
        html! {
            (nx) @if ny > 1 { " × " (ny) } " points on " (given(lengths[0])) @if ny > 1 { " × " (given(lengths[1])) }
            @else { ", plane strain" }
        },
    ));
    page.asked.push(body(&table, &Units::default()));
    page.asked.push(Fact(html! { "points under the punch" }, given(value("contact_nodes"))));
    page.asked.push(Fact(html! { "width" }, given(value("punch_width"))));
    page.asked.push(Fact(html! { "depth" }, given(depth)));
    let tolerance = of(&table, "tolerance");
    page.asked.push(Fact(html! { "solver" }, html! { (text(&word("solver"))) ", tolerance " (given(tolerance)) }));

    let names = if components == 2 { &["x", "z"][..] } else { &["x", "y", "z"] };
    let read = |name: &str| -> Result<Vec<Vec<f64>>, Failure> {
        let all: Vec<f64> = reader.values(&format!("/fields/{name}")).map_err(|error| unusable(&error))?;
        let whole = all.len() == grid.len() * components && all.iter().all(|value| value.is_finite());
        if !whole {
            return Err(Failure::refused(format!("/fields/{name} was not computed at all points of the surface")));
        }
        let part = |component| all.iter().skip(component).step_by(components).copied().collect();
        Ok((0..components).map(part).collect())
    };
    let (displacement, traction) = (read("displacement")?, read("traction")?);
    let over = |values: &[f64], unit: f64| -> Vec<f64> { values.iter().map(|value| value / unit).collect() };
    let middle = |values: &[f64], unit: f64| -> Vec<(f64, f64)> {
        let step = grid.spacing()[0];
        (0..nx).map(|i| (i as f64 * step, values[i * ny + ny / 2] / unit)).collect()
    };
    let normal = components - 1;
    let pressure: Vec<f64> = traction[normal].iter().map(|t| -t / mean).collect();
    if !grid.is_line() {
        // A sticking punch may have tension below it.
        let drawn = if pressure.iter().any(|p| *p < 0.0) {
            let mut drawn = field(&grid, &pressure, PRESSURE, "length");
            if let Drawn::Map(map) = &mut drawn {
                (map.colours, map.range) = (Colours::Diverging, about_zero(&pressure));
            }
            drawn
        } else {
            crate::figures::pressure(&grid, &pressure, PRESSURE, "length")
        };
        let caption =
            html! { "Pressure over the mean pressure of the cell; beyond the end of the scale beside the edge." };
        page.field(&drawn, "pressure", &caption);
        for (component, name) in displacement.iter().zip(names) {
            let values = over(component, depth);
            let caption = html! { "Displacement " i { "u" } sub { (name) } " over the depth." };
            let drawn = field(&grid, &values, &format!("*u*_{name} / depth"), "length");
            page.field(&drawn, &format!("displacement {name}"), &caption);
        }
    }
    let lines = |letter: &str, fields: &[Vec<f64>], unit: f64| -> Vec<Series> {
        let line = |component: usize| {
            Series::line(&format!("*{letter}*_{}", names[component]), component, middle(&fields[component], unit))
        };
        vec![line(0), line(normal)]
    };
    let cuts = [lines("u", &displacement, depth), lines("t", &traction, mean)];
    let caption = html! { "Along " i { "x" } " through the middle; a negative " i { "t" } sub { "z" } " presses." };
    page.chart(&cut(cuts, "mean pressure"), "cut through the middle", &caption);
    page.group(reader, "/punch", "The numbers of the punch, under their names in the file.");
    page.certificate("error of the prescribed displacement over the depth", residual, tolerance);
    page.failure(reader, "search");
    page.cost.extend([
        Fact(html! { "iterations" }, given(value("iterations"))),
        Fact(html! { "transform pairs" }, transforms(value("transform_pairs"))),
        Fact(html! { "time" }, html! { (number(value("seconds"))) " s" }),
    ]);
    Ok(page)
}

/// Returns charts of displacement / depth and of traction / stress along a line through the middle.
pub fn cut([displacement, traction]: [Vec<Series>; 2], stress: &str) -> Chart {
    let panel = |label: &str, series| {
        let (x, y) = (Axis::linear("*x* / length"), Axis::linear(label));
        Panel { x, y, series, ..Panel::default() }
    };
    let traction = panel(&format!("traction / {stress}"), traction);
    Chart { share_y: false, ..Chart::new(vec![panel("displacement / depth", displacement), traction]) }
}

/// Reads a number of a group; NaN if the file does not have it.
fn single(reader: &Reader, group: &str, name: &str) -> f64 {
    let values: Vec<f64> = reader.values(&format!("{group}/{name}")).unwrap_or_default();
    if values.len() == 1 { values[0] } else { f64::NAN }
}

impl Page {
    /// Adds the table of all single numbers of a group, with their units and definitions.
    pub(crate) fn group(&mut self, reader: &Reader, group: &str, caption: &str) {
        let rows = reader.names(group).into_iter().filter_map(|name| {
            let path = format!("{group}/{name}");
            let value = Some(single(reader, group, &name)).filter(|value| value.is_finite())?;
            let attribute = |name: &str| text(&reader.text(&path, name).unwrap_or_default());
            let unit = attribute("units");
            let unit = if unit == "1" { String::new() } else { unit.replace('*', "·") };
            let meaning = html! { span.meaning { (attribute("long_name")) } };
            let shown = if value.fract() == 0.0 { given(value) } else { number(value) };
            Some(vec![html! { code { (text(&name)) } }, shown, html! { (unit) }, meaning])
        });
        let rows: Vec<_> = rows.collect();
        let heads = vec![html! { "number" }, html! { "value" }, html! { "unit" }, html! { span.meaning { "meaning" } }];
        self.tables.push(Table { caption: html! { (caption) }, head: heads, rows });
    }
}
