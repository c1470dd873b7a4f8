//! Page about wear, and its figures.

use gfmd_field::Grid;
use gfmd_files::Reader;
use gfmd_plot::{Axis, Chart, Mark, Panel, Series};
use gfmd_problem::options::Kinds;
use maud::html;

use crate::figures::{Drawn, field, largest, length, short, sides};
use crate::legs::{along, waypoints};
use crate::page::{Fact, Page, Stored, StoredSurface, config, given, number, of, option, with_unit};
use gfmd_input::failure::Failure;
use gfmd_record::State;

const CITED: [&str; 2] = [
    "J. F. Archard, Contact and rubbing of flat surfaces, Journal of Applied Physics 24, 981–988 (1953).",
    "L. A. Galin, Contact problems of the theory of elasticity in the presence of wear, Prikladnaya Matematika i \
     Mekhanika 40, 981–986 (1976).",
];

/// Largest number of values along a profile; longer ones are thinned.
const MOST_POINTS: usize = 2000;

/// Returns panels of the mean depth lost, the contact area and the largest pressure against the sliding distance, from
/// columns by name.
pub fn against_distance(column: impl Fn(&str) -> Vec<f64>, modulus: f64, unit: &str) -> Vec<Panel> {
    let distance = column("distance");
    against(("distance", &distance), column, modulus, unit)
}

/// Returns the same panels against a length of the given name.
pub(crate) fn against(
    (name, distance): (&str, &[f64]),
    column: impl Fn(&str) -> Vec<f64>,
    modulus: f64,
    unit: &str,
) -> Vec<Panel> {
    let [volume, area, peak] = ["wear_volume", "area_fraction", "max_pressure"].map(column);
    let [far, deep] = [distance, &volume].map(|values| length(unit, largest(values)));
    let against = |values: &[f64], factor: f64| -> Vec<(f64, f64)> {
        distance.iter().zip(values).map(|(x, y)| (x * far.factor, y * factor)).collect()
    };
    let columns = vec![
        (against(&volume, deep.factor), format!("mean depth lost / {}", deep.name)),
        (against(&area, 1.0), "contact area".to_owned()),
        (against(&peak, 1.0 / modulus), "largest pressure / *E*\\*".to_owned()),
    ];
    along(&format!("{name} / {}", far.name), columns)
}

/// Returns the heights along the row with the largest depth lost, before and after wear as if only the rough surface
/// wore; `None` if nothing is lost.
pub fn profile(grid: &Grid, [heights, depth]: [&[f64]; 2], unit: &str) -> Option<Chart> {
    let [nx, ny] = grid.points();
    let deepest =
        (0..depth.len()).max_by(|a, b| depth[*a].total_cmp(&depth[*b])).filter(|place| depth[*place] > 0.0)?;
    let row = deepest % ny;
    let places: Vec<usize> = (0..nx).step_by(nx.div_ceil(MOST_POINTS)).map(|i| i * ny + row).collect();
    let side = sides(grid, unit);
    let extent = |values: &dyn Fn(usize) -> f64| {
        let [low, high] = places.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], place| {
            [low.min(values(*place)), high.max(values(*place))]
        });
        high - low
    };
    let height = length(unit, extent(&|place| heights[place]).max(extent(&|place| heights[place] - depth[place])));
    let [dx, dy] = grid.spacing();
    let line = |values: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        let point = |place: &usize| ((place / ny) as f64 * dx * side.factor, values(*place) * height.factor);
        places.iter().map(point).collect()
    };
    let known = if unit == "length" { String::new() } else { format!(" {}", side.name) };
    let place = short(row as f64 * dy * side.factor);
    let title = format!("row *y* = {place}{known}, that of the largest wear");
    let panel = Panel {
        title: if grid.is_line() { String::new() } else { title },
        x: Axis::linear(&format!("*x* / {}", side.name)),
        y: Axis::linear(&format!("height *h* / {}", height.name)),
        series: vec![
            Series { mark: Mark::Dashes, ..Series::line("unworn", 6, line(&|place| heights[place])) },
            Series::line("worn", 0, line(&|place| heights[place] - depth[place])),
        ],
        ..Panel::default()
    };
    Some(Chart::new(vec![panel]))
}

/// Passes the map of the depth lost, or its profile for a line contact, to `take`.
pub fn depth_of<R>(grid: &Grid, depth: &[f64], unit: &str, take: impl FnOnce(&Drawn) -> R) -> R {
    let read = length(unit, largest(depth));
    let scaled: Vec<f64> = depth.iter().map(|w| w * read.factor).collect();
    take(&field(grid, &scaled, &format!("depth lost *w* / {}", read.name), unit))
}

/// Adds the worn profile and the depth lost at waypoint `index`, if the file has the depth.
pub(crate) fn worn_surface(page: &mut Page, reader: &Reader, surface: &StoredSurface, index: usize) {
    let Ok(depth) = surface.field(reader, "wear_depth", index) else { return };
    let caption = html! {
        "Heights before and after, along the row of the largest wear, as if the rough surface alone wore."
    };
    if let Some(chart) = profile(&surface.grid, [&surface.heights, &depth], &surface.unit) {
        page.chart(&chart, "the worn profile beside the unworn", &caption);
    }
    depth_of(&surface.grid, &depth, &surface.unit, |drawn| {
        page.field(drawn, "depth lost", &html! { "Depth that both surfaces have lost." });
    });
}

/// Builds the page about the wear in a file.
///
/// # Errors
/// Returns an error if the file has no steps.
pub fn page(reader: &Reader) -> Result<Page, Failure> {
    let stored = Stored::new(reader, "/wear", "mean_pressure")?;
    let table = config(reader);
    let mut page = Page { title: "Wear of a rough contact".into(), cited: CITED.to_vec(), ..Page::default() };
    let column = |name: &str| stored.column(name);
    let [mean, converged, p_star, peak] = ["mean_pressure", "converged", "p_star", "max_pressure"].map(column);
    let computed =
        mean.iter().zip(&converged).take_while(|(mean, converged)| mean.is_finite() && **converged != 0.0).count();
    let Some(last) = computed.checked_sub(1) else {
        page.answer.push(html! { p.headline { "No step converged: there is no result" } });
        page.failure(reader, "step");
        return Ok(page);
    };
    let units = stored.units();
    let shown = |name: &str| stored.said(name, last, 1.0);
    page.answer.push(html! {
        p.headline {
            (shown("wear_volume")) " "
            span { "lost on average over the distance " (shown("distance")) }
        }
    });
    page.answer.push(html! {
        p {
            (computed) " of " (stored.len()) " steps. The largest depth lost is "
            (shown("max_wear"))
            "; the contact area went from " (stored.said("area_fraction", 0, 100.0)) " % to "
            (stored.said("area_fraction", last, 100.0))
            " % of the surface, the largest pressure divided by the mean from " (number(peak[0] / mean[0])) " to "
            (number(peak[last] / mean[last])) ". "
        }
    });
    if computed < stored.len() {
        page.remarks.push(format!("the path ends after step {last} of {}", stored.len() - 1));
    }
    let surface = StoredSurface::read(reader);
    page.asked(&surface, &table, "hard wall, wear");
    let coefficient = of(&table, "coefficient");
    let term = if units.stress().is_some() { "wear coefficient" } else { "wear coefficient (1/stress)" };
    page.asked.push(Fact(html! { (term) }, with_unit(coefficient, "1/stress", &units)));
    for (term, key, kinds) in [
        ("distances of the legs", "distance", Kinds::LENGTH),
        ("waypoints, pressure", "pressure", Kinds::STRESS),
        ("waypoints, p*", "p_star", Kinds::NUMBER),
        ("waypoints, approach", "approach", Kinds::LENGTH),
        ("steps of a leg", "steps", Kinds::NUMBER),
    ] {
        if let Some(value) = table.get(key) {
            page.asked.push(Fact(html! { (term) }, option(kinds, value, &units)));
        }
    }
    let tolerance = of(&table, "tolerance");
    page.asked.push(Fact(html! { "tolerance" }, given(tolerance)));
    let (mut shown, mut state, mut modulus) = (None, String::new(), f64::NAN);
    if let Ok(surface) = &surface {
        let loudest = (0..computed).max_by(|a, b| mean[*a].total_cmp(&mean[*b]));
        let scale = loudest.map_or(f64::NAN, |step| mean[step] / p_star[step]);
        modulus = scale / surface.rms_gradient;
        let steps = |name: &str| column(name)[..computed].to_vec();
        let panels = against_distance(steps, modulus, &surface.unit);
        if computed > 1 && !panels.is_empty() {
            let caption = html! { "Mean depth lost, contact area and largest pressure against the sliding distance." };
            page.chart(&Chart::new(panels), "wear against distance", &caption);
        }
        let steps_of_leg = table.get("steps").and_then(toml::Value::as_integer).unwrap_or(1).max(1) as usize;
        let waypoints = waypoints(&table, computed, steps_of_leg);
        shown = waypoints.len().checked_sub(1);
        state = waypoints.last().map_or_else(String::new, |step| format!("step {step}"));
        if let Some(index) = shown {
            worn_surface(&mut page, reader, surface, index);
        }
    }
    page.fields(reader, &surface, (shown, &state, modulus), None);
    page.failure(reader, "step");
    page.residual(&stored, tolerance);
    page.numbers::<State>(&stored, computed, "step");
    page.effort(&stored);
    Ok(page)
}
