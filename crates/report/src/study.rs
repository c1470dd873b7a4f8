//! Page about a study of many contacts, and its table.

use gfmd_check::study::{Cube, CubeNumber, MeanOver, StateAxis};
use gfmd_files::Reader;
use gfmd_input::failure::Failure;
use gfmd_plot::{Axis, Chart, Mark, Panel, Point, Series};
use gfmd_record::{Head, Importance, Origin, Sliding, State, Subject, heads, largest, significant, with_limit};
use maud::{Markup, html};

use crate::page::{Certificate, Fact, Page, Table, config, of, powers, sentence, text, transforms, whole};

/// Number of a study in a table.
pub struct Shown<'a> {
    /// Word above the numbers.
    pub word: &'static str,
    /// The word with the unit.
    pub head: String,
    /// Importance in a table.
    pub importance: Importance,
    /// Values.
    pub number: &'a CubeNumber,
    /// Factor to the shown unit.
    pub factor: f64,
}

/// Returns the numbers of a study that tables of a single contact show, without numbers of the search.
pub fn shown(cube: &Cube) -> Vec<Shown<'_>> {
    match &*cube.command {
        "slide" => shown_of::<Sliding>(cube),
        _ => shown_of::<State>(cube),
    }
}

fn shown_of<S: Subject>(cube: &Cube) -> Vec<Shown<'_>> {
    let units = cube.known_units();
    let of_fields = heads::<S>(gfmd_record::Table::State).filter(|(column, _)| column.origin == Origin::Fields);
    let is_axis = |name: &str| cube.axes.iter().any(|axis| axis.name == name);
    let found = of_fields.filter_map(|(column, head)| {
        let number = cube.number(column.name).filter(|_| !is_axis(column.name))?;
        let finite = number.values.iter().filter(|value| value.is_finite());
        let largest = finite.map(|value| value.abs()).reduce(f64::max).filter(|largest| *largest > 0.0)?;
        let unit = units.shown(column.unit, largest);
        let Head { word, importance, .. } = head;
        let head = unit.as_ref().map_or_else(|| word.to_owned(), |unit| format!("{word} / {}", unit.divisor()));
        Some(Shown { word, head, importance, number, factor: unit.map_or(1.0, |unit| unit.factor) })
    });
    found.collect()
}

/// Standard error divided by the mean below which it is rounding, or the tolerance of a prescribed load.
const ROUNDING: f64 = 1e-8;

/// Returns the standard error of a mean, unless it is unknown or rounding.
fn error_of(mean: &MeanOver) -> Option<f64> {
    mean.standard_error.filter(|error| *error > ROUNDING * mean.mean.abs())
}

/// Formats a mean with its standard error in units of the last digits; five digits without an error.
pub fn cell(mean: Option<MeanOver>, factor: f64) -> String {
    let Some(found) = mean else { return "-".into() };
    match error_of(&found) {
        Some(error) => with_limit(found.mean * factor, found.mean * factor, error * factor),
        None => significant(found.mean * factor),
    }
}

/// Kinds of the coordinates of states.
const KINDS: [&str; 4] = ["stress", "length", "stress*length^2", "length/time"];

/// Returns the kind of the coordinates of an axis of the states.
fn kind_of(cube: &Cube, axis: &StateAxis) -> Option<&'static str> {
    let units = cube.known_units();
    KINDS.into_iter().find(|kind| units.name(kind) == axis.units)
}

/// Returns the name of an axis of the states in front of its readable unit, and the factor to this unit.
fn coordinate(cube: &Cube, axis: &StateAxis, name: &str) -> (String, f64) {
    let largest = largest(axis.values.iter().flatten().copied());
    match kind_of(cube, axis).and_then(|kind| cube.known_units().shown(kind, largest)) {
        Some(unit) => (format!("{name} / {}", unit.divisor()), unit.factor),
        None if axis.units == "1" => (name.to_owned(), 1.0),
        None => (format!("{name} / {}", axis.units), 1.0),
    }
}

/// Returns for each axis of the states its name with its readable unit, and the coordinate of each state.
pub fn coordinates(cube: &Cube) -> Vec<(String, Vec<String>)> {
    let of = |(index, axis): (usize, &StateAxis)| {
        let (head, factor) = coordinate(cube, axis, &axis.name);
        let value = |state: usize| cube.coordinates(state)[index];
        let text = |value: f64| if factor == 1.0 { value.to_string() } else { significant(value * factor) };
        (head, (0..cube.states()).map(|state| text(value(state))).collect())
    };
    cube.axes.iter().enumerate().map(of).collect()
}

/// Says how many members have warnings.
pub fn with_warnings(members: usize) -> String {
    if members == 1 { "1 member has warnings".into() } else { format!("{members} members have warnings") }
}

/// Returns the extent of a study and the number of its members in words.
pub fn words(cube: &Cube) -> [String; 2] {
    let count = |count: usize, one: &str, more: &str| format!("{count} {}", if count == 1 { one } else { more });
    let lists = [
        count(cube.surfaces.len(), "surface", "surfaces"),
        count(cube.seeds.len(), "seed", "seeds"),
        count(cube.bodies.len(), "body", "bodies"),
    ];
    let axes = cube.axes.iter().map(|axis| match &*axis.name {
        "velocity" => count(axis.length, "velocity", "velocities"),
        name => count(axis.length, name, &format!("{name}s")),
    });
    let all: Vec<String> = lists.into_iter().chain(axes).collect();
    [format!("study of {}: {}", cube.command, all.join(" x ")), count(cube.members(), "member", "members")]
}

/// Largest number of curves in a figure.
const MOST_CURVES: usize = 12;

/// Returns the chart of a number against the last axis of the states, a curve for each surface, body and other state.
fn chart(cube: &Cube, shown: &Shown) -> Option<Chart> {
    let axis = cube.axes.last().filter(|axis| axis.length > 0)?;
    let others = cube.states() / axis.length;
    let (label, factor) = coordinate(cube, axis, &axis.long_name);
    let units = cube.known_units();
    let curves = (0..cube.surfaces.len())
        .flat_map(|surface| (0..cube.bodies.len()).map(move |body| (surface, body)))
        .flat_map(|(surface, body)| (0..others).map(move |other| (surface, body, other)));
    let mut series = Vec::new();
    for (hue, (surface, body, other)) in curves.enumerate().take(MOST_CURVES) {
        let mut label = Vec::new();
        if cube.surfaces.len() > 1 {
            label.push(plain(&text(&cube.surfaces[surface])));
        }
        if cube.bodies.len() > 1 {
            label.push(plain(&text(&cube.bodies[body])));
        }
        if others > 1 {
            let (axis, value) = (&cube.axes[0], cube.coordinates(other * axis.length)[0]);
            let value = kind_of(cube, axis).map_or_else(|| value.to_string(), |kind| units.words(value, kind));
            label.push(format!("{} {value}", axis.name));
        }
        let point = |index: usize| {
            let state = other * axis.length + index;
            let mean = cube.mean(shown.number, surface, body, state)?;
            let x = axis.values.as_ref().map_or(index as f64, |values| values[index] * factor);
            let y = mean.mean * shown.factor;
            Some(error_of(&mean).map_or(Point::new(x, y), |error| Point::with_error(x, y, error * shown.factor)))
        };
        let points: Vec<Point> = (0..axis.length).filter_map(point).collect();
        if !points.is_empty() {
            series.push(Series { mark: Mark::JoinedPoints, ..Series::points(&label.join(", "), hue, points) });
        }
    }
    let values = axis.values.clone().unwrap_or_default();
    let [least, most] = [f64::min, f64::max].map(|fold| values.iter().copied().reduce(fold).unwrap_or(0.0));
    let label = plain(&label);
    let x = if least > 0.0 && most > 10.0 * least { Axis::log(&label) } else { Axis::linear(&label) };
    let panel = Panel { x, y: Axis::linear(&plain(&shown.head)), series, ..Panel::default() };
    (!panel.series.is_empty()).then(|| Chart::new(vec![panel]))
}

/// Returns a text as a label that shows its asterisks.
fn plain(label: &str) -> String {
    label.replace('*', "\\*")
}

/// Returns true if a number is the given load itself.
fn is_given(cube: &Cube, name: &str) -> bool {
    let loads = cube.axes.iter().find(|axis| axis.name == "load");
    loads.is_some_and(|loads| match loads.long_name.contains("approach") {
        true => name == "approach",
        false => ["mean_pressure", "p_star"].contains(&name),
    })
}

/// Builds the page about the study in a file.
///
/// # Errors
/// Returns an error if the file has no study.
pub fn page(reader: &Reader) -> Result<Page, Failure> {
    let cube = Cube::read(reader)?;
    let mut page = Page { title: "Study of many contacts".into(), ..Page::default() };
    let failed: Vec<usize> = (0..cube.members()).filter(|member| !cube.errors[*member].is_empty()).collect();
    let solved = cube.members() - failed.len();
    let all = cube.members();
    page.answer.push(html! {
        p.headline { (solved) " of " (all) " members " span { "solved by gfmd " (text(&cube.command)) } }
        p {
            (sentence(&text(&words(&cube).join("; "))))
            ". The tables have means over the seeds, with standard errors in brackets."
        }
    });
    let names = |names: &[String]| text(&names.join(", "));
    let seeds: Vec<String> = cube.seeds.iter().map(ToString::to_string).collect();
    page.asked.push(Fact(html! { "surfaces" }, html! { (names(&cube.surfaces)) }));
    page.asked.push(Fact(html! { "seeds" }, html! { (seeds.join(", ")) }));
    page.asked.push(Fact(html! { "bodies" }, html! { (names(&cube.bodies)) }));
    let table = config(reader);
    if let Some(options) = table.get(&cube.command).and_then(toml::Value::as_table) {
        for (key, value) in options {
            page.asked.push(Fact(html! { (text(key)) }, html! { (text(&value.to_string())) }));
        }
    }
    let shown = shown(&cube);
    for one in shown.iter().filter(|one| !is_given(&cube, &one.number.name)) {
        if let Some(chart) = chart(&cube, one) {
            let caption =
                html! { (sentence(&text(&one.number.long_name))) ": mean over the seeds, and its standard error." };
            page.chart(&chart, &one.number.name.replace('_', " "), &caption);
        }
    }
    let curves =
        cube.surfaces.len() * cube.bodies.len() * cube.states() / cube.axes.last().map_or(1, |axis| axis.length.max(1));
    if curves > MOST_CURVES {
        page.remarks.push(format!("figures show {MOST_CURVES} of {curves} curves; the file has all"));
    }
    page.tables.push(means(&cube, &shown));
    if let Some(first) = failed.first() {
        let error = text(&cube.errors[*first]);
        page.remarks.push(format!(
            "{} of {all} members failed; the first is {}: {error}",
            failed.len(),
            place(&cube, *first)
        ));
        page.tables.push(failures(&cube, &failed));
    }
    let warned = cube.warnings.iter().filter(|warnings| !warnings.is_empty()).count();
    if warned > 0 {
        page.remarks.push(format!("{}, which are in /study/warnings", with_warnings(warned)));
    }
    let tolerances = cube.configs.iter().filter_map(|config| Some(of(&config.parse().ok()?, "tolerance")));
    let tolerance = tolerances.filter(|tolerance| tolerance.is_finite()).reduce(f64::max).unwrap_or(f64::NAN);
    for number in cube.numbers.iter().filter(|number| number.name.starts_with("residual")) {
        let largest = number.values.iter().copied().filter(|value| !value.is_nan()).reduce(f64::max);
        let name = number.name.trim_start_matches("residual").trim_start_matches('_').replace('_', " ");
        let name = if name.is_empty() { "residual".into() } else { name };
        if let Some(largest) = largest {
            page.certificates.push(Certificate { name, largest, allowed: tolerance });
        }
    }
    page.cost.push(Fact(html! { "members" }, whole(all as f64)));
    if let Some(pairs) = cube.number("transform_pairs") {
        let pairs = pairs.values.iter().filter(|value| !value.is_nan()).sum();
        page.cost.push(Fact(html! { "transform pairs" }, transforms(pairs)));
    }
    Ok(page)
}

fn place(cube: &Cube, member: usize) -> String {
    let [surface, seed, body] = cube.place(member);
    text(&format!("surface {}, seed {}, body {}", cube.surfaces[surface], cube.seeds[seed], cube.bodies[body]))
}

/// Returns the table of the means.
fn means(cube: &Cube, shown: &[Shown]) -> Table {
    let axes = coordinates(cube);
    let heads = axes.iter().map(|(head, _)| head.clone());
    let head = ["surface".to_owned(), "body".to_owned()].into_iter().chain(heads);
    let head = head.chain(shown.iter().map(|one| one.head.clone())).map(|head| html! { (text(&head)) }).collect();
    let mut rows: Vec<Vec<Markup>> = Vec::new();
    for (surface, name) in cube.surfaces.iter().enumerate() {
        for (body, of_body) in cube.bodies.iter().enumerate() {
            for state in 0..cube.states() {
                let named = [name, of_body].map(|name| html! { (text(name)) });
                let at = axes.iter().map(|(_, values)| html! { (values[state]) });
                let numbers =
                    shown.iter().map(|one| powers(&cell(cube.mean(one.number, surface, body, state), one.factor)));
                rows.push(named.into_iter().chain(at).chain(numbers).collect());
            }
        }
    }
    Table { caption: html! { "Mean over the seeds (standard error) at each surface, body and state." }, head, rows }
}

/// Returns the table of the members that failed.
fn failures(cube: &Cube, failed: &[usize]) -> Table {
    let row = |member: &usize| vec![html! { (place(cube, *member)) }, html! { (text(&cube.errors[*member])) }];
    Table {
        caption: html! { "Members that failed." },
        head: vec![html! { "member" }, html! { "reason" }],
        rows: failed.iter().map(row).collect(),
    }
}
