//! Page about fields below a surface.

use gfmd_files::Reader;
use gfmd_plot::{Axis, Chart, Colours, Map, Mark, Panel, Point, Series};
use maud::html;

use crate::figures::about_zero;
use crate::page::{Fact, Page, Table, body, config, given, list, number, text, unit_for, with_unit};
use gfmd_input::failure::Failure;
use gfmd_unit::Units;

/// Largest relative difference between depth steps that count as equal.
const EVEN: f64 = 1e-6;

/// Builds the page about the fields in a file.
///
/// # Errors
/// Returns an error if the file has no depths.
pub fn page(reader: &Reader) -> Result<Page, Failure> {
    let values = |name: &str| reader.values::<f64>(&format!("/fields/{name}"));
    let depths = values("depth").map_err(|error| Failure::refused(error.to_string()))?;
    let table = config(reader);
    let mut page = Page { title: "Fields below a surface".into(), ..Page::default() };
    let fields = Fields::read(reader, &depths);
    let slice = reader.text("/fields", "slice").unwrap_or_default();
    let unit = |name: &str| {
        let unit = text(&reader.text(&format!("/fields/{name}"), "units").unwrap_or_default());
        if unit == "1" { String::new() } else { unit }
    };
    let known = |name: &str, kind: &str| Some(unit(name)).filter(|unit| !unit.is_empty() && unit != kind);
    let stress = known("von_mises", "stress").or_else(|| known("stress", "stress"));
    let units = Units::new(known("depth", "length").as_deref(), stress.as_deref());
    let length = Some(unit("depth")).filter(|unit| unit != "length").unwrap_or_default();
    let most = fields.of("von_mises").map(|field| field.largest_at(0));
    match most.as_ref().and_then(|all| all.iter().zip(&depths).max_by(|a, b| a.0.total_cmp(b.0))) {
        Some((most, depth)) => page.answer.push(html! {
            @let (factor, name) = unit_for(*most, "stress", &units);
            p.headline {
                "Largest equivalent stress of von Mises " (number(*most * factor)) (name) " "
                span { "at the depth " (with_unit(*depth, "length", &units)) }
            }
            p { "Of " (depths.len()) " depths" @if !slice.is_empty() { ", in the slice " (text(&slice)) } "." }
        }),
        None => page.answer.push(html! {
            p.headline { (fields.0.len()) " fields at " (depths.len()) " depths" }
        }),
    }
    let word = |name: &str| table.get(name).map(ToString::to_string).unwrap_or_default().replace('"', "");
    page.asked.push(Fact::new("displacement of the surface", &word("surface")));
    if !slice.is_empty() {
        page.asked.push(Fact::new("slice", &slice));
    }
    if depths.len() <= 8 {
        page.asked.push(Fact(html! { "depths" }, html! { (list(&depths, "length", &units)) }));
    } else if let (Some(first), Some(last)) = (depths.first(), depths.last()) {
        page.asked.push(Fact(
            html! { "depths" },
            html! {
                (depths.len()) " from " (with_unit(*first, "length", &units)) " to "
                (with_unit(*last, "length", &units))
            },
        ));
    }
    page.asked.push(body(&table, &units));
    let sum = reader.text("/input", "file_sha256").unwrap_or_default();
    if !sum.is_empty() {
        page.asked.push(Fact::new("SHA-256 of the input", &sum));
    }
    fields.profiles(&mut page, &depths, &unit);
    fields.maps(&mut page, reader, &depths, &unit);

    let rows = depths.iter().enumerate().map(|(level, depth)| {
        let cells = fields.0.iter().flat_map(|field| field.columns().map(move |of| number(field.largest(level, of))));
        [given(*depth)].into_iter().chain(cells).collect()
    });
    let heads = fields.0.iter().flat_map(|field| {
        let unit = unit(field.name);
        field.columns().map(move |of| {
            let unit = unit.clone();
            let title = field.title(of).replace(['*', '{', '}'], "");
            let (symbol, index) = title.split_once('_').unwrap_or((&title, ""));
            html! { (symbol) sub { (index) } br; small { (unit) } }
        })
    });
    page.tables.push(Table {
        caption: html! { "The largest magnitude of each component at each depth." },
        head: [html! { "depth" @if !length.is_empty() { br; small { (length) } } }].into_iter().chain(heads).collect(),
        rows: rows.collect(),
    });
    Ok(page)
}

/// A field at all depths.
struct Field {
    name: &'static str,
    symbol: &'static str,
    /// Names of the components in file order; a scalar has one empty name.
    components: Vec<String>,
    values: Vec<f64>,
    levels: usize,
    /// Points of a level along both axes; a slice or a strip has one point along y.
    points: [usize; 2],
}

/// The complete fields of a file.
struct Fields(Vec<Field>);

impl Fields {
    fn read(reader: &Reader, depths: &[f64]) -> Self {
        let names = |dimension: &str| reader.texts(&format!("/fields/{dimension}")).unwrap_or_default();
        let (vector, tensor, single) = (&names("component"), &names("tensor"), &vec![String::new()]);
        let kinds = [
            ("von_mises", "von Mises stress", single),
            ("displacement", "*u*", vector),
            ("stress", "*σ*", tensor),
            ("strain", "*ε*", tensor),
            ("energy_density", "energy density", single),
        ];
        let read = |(name, symbol, components): (&'static str, &'static str, &Vec<String>)| {
            let (path, components) = (format!("/fields/{name}"), components.clone());
            let shape = reader.shape(&path).ok()?;
            let inner = shape.strip_prefix(&[depths.len()])?;
            let inner = if components.len() > 1 { inner.strip_suffix(&[components.len()])? } else { inner };
            let points = match inner {
                [n] => [*n, 1],
                [nx, ny] => [*nx, *ny],
                _ => return None,
            };
            let values: Vec<f64> = reader.values(&path).ok()?;
            let is_whole = values.iter().all(|value| value.is_finite());
            is_whole.then_some(Field { name, symbol, components, values, levels: depths.len(), points })
        };
        Self(kinds.into_iter().filter_map(read).collect())
    }

    fn of(&self, name: &str) -> Option<&Field> {
        self.0.iter().find(|field| field.name == name)
    }

    /// Adds a chart of the largest magnitudes against depth.
    fn profiles(&self, page: &mut Page, depths: &[f64], unit: &dyn Fn(&str) -> String) {
        if depths.len() < 2 {
            return;
        }
        for name in ["von_mises", "displacement"] {
            let Some(field) = self.of(name) else { continue };
            let line = |of: usize| {
                let points = depths.iter().zip(field.largest_at(of)).map(|(depth, most)| Point::new(*depth, most));
                let label = if field.components.len() > 1 { field.title(of) } else { String::new() };
                Series { mark: Mark::JoinedPoints, ..Series::points(&label, of, points.collect()) }
            };
            let quantity = if name == "displacement" { "largest displacement" } else { "largest von Mises stress" };
            let panel = Panel {
                x: Axis::linear(&format!("depth / {}", unit("depth"))),
                y: Axis::linear(&format!("{quantity} / {}", unit(name))),
                series: field.columns().map(line).collect(),
                ..Panel::default()
            };
            let caption = html! { "The largest magnitude at each depth." };
            page.chart(&Chart::new(vec![panel]), quantity, &caption);
        }
    }

    /// Adds maps of sections: across the depth if the file holds a slice at evenly spaced depths, otherwise at the
    /// depth with the largest values.
    fn maps(&self, page: &mut Page, reader: &Reader, depths: &[f64], unit: &dyn Fn(&str) -> String) {
        let places = |axis: &str| reader.values::<f64>(&format!("/fields/{axis}")).unwrap_or_default();
        let side = |axis: &str, n: usize| {
            let places = places(axis);
            if places.len() > 1 { (places[1] - places[0]) * n as f64 } else { 1.0 }
        };
        let axis = if places("x").is_empty() { "y" } else { "x" };
        let after = if unit("depth") == "length" { String::new() } else { format!(" {}", unit("depth")) };
        let steps: Vec<f64> = depths.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let even = steps.iter().all(|step| *step > 0.0 && (step - steps[0]).abs() <= EVEN * steps[0]);
        for field in self.0.iter().filter(|field| field.name != "strain") {
            for of in field.columns() {
                let [nx, ny] = field.points;
                let title = field.title(of);
                let label = format!("{title} / {}", unit(field.name));
                let (values, shape, size, origin, caption, up) = if ny == 1 {
                    if !even || depths.len() < 2 {
                        continue;
                    }
                    let levels = field.levels;
                    let at = |k: usize| field.value(levels - 1 - k % levels, k / levels, of);
                    let size = [side(axis, nx), steps[0] * levels as f64];
                    let caption = html! { "Section across the depth." };
                    let lowest = -(depths[levels - 1] + 0.5 * steps[0]);
                    ((0..nx * levels).map(at).collect::<Vec<_>>(), [nx, levels], size, [0.0, lowest], caption, "−depth")
                } else {
                    let most = field.largest_at(of);
                    let level = (0..field.levels).max_by(|a, b| most[*a].total_cmp(&most[*b])).unwrap_or(0);
                    let caption =
                        html! { "At the depth " (given(depths[level])) (after) ", where its magnitude is largest." };
                    let values = (0..nx * ny).map(|point| field.value(level, point, of)).collect();
                    (values, [nx, ny], [side("x", nx), side("y", ny)], [0.0; 2], caption, "*y*")
                };
                let mut map = Map::new(&values, shape, size, &label);
                map.origin = origin;
                map.x = format!("*{axis}* / {}", unit("depth"));
                map.y = format!("{up} / {}", unit("depth"));
                if field.components.len() > 1 {
                    map.colours = Colours::Diverging;
                    map.range = about_zero(&values);
                }
                page.field(&crate::figures::Drawn::Map(map), &field.words(of), &caption);
            }
        }
    }
}

impl Field {
    fn columns(&self) -> std::ops::Range<usize> {
        0..self.components.len()
    }

    fn title(&self, of: usize) -> String {
        match self.components[of].as_str() {
            "" => self.symbol.into(),
            component => format!("{}_{{{component}}}", self.symbol),
        }
    }

    /// Returns the name of the quantity in words, without markup.
    fn words(&self, of: usize) -> String {
        format!("{} {}", self.name.replace('_', " "), self.components[of]).trim_end().into()
    }

    fn value(&self, level: usize, point: usize, of: usize) -> f64 {
        let [nx, ny] = self.points;
        self.values[(level * nx * ny + point) * self.components.len() + of]
    }

    /// Returns the largest magnitude of a component at a depth.
    fn largest(&self, level: usize, of: usize) -> f64 {
        let [nx, ny] = self.points;
        (0..nx * ny).map(|point| self.value(level, point, of).abs()).fold(0.0, f64::max)
    }

    /// Returns the largest magnitude of a component at each depth.
    fn largest_at(&self, of: usize) -> Vec<f64> {
        (0..self.levels).map(|level| self.largest(level, of)).collect()
    }
}
