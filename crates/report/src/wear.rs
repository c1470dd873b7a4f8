//! Figures of wear.

use gfmd_field::Grid;
use gfmd_files::Reader;
use gfmd_plot::{Axis, Chart, Mark, Panel, Series};
use maud::html;

use crate::figures::{Drawn, field, largest, length, short, sides};
use crate::legs::{Abscissa, along};
use crate::page::{Page, StoredSurface};

/// Largest number of values along a profile; longer ones are thinned.
const MOST_POINTS: usize = 2000;

/// Returns panels of the mean depth lost, the contact area and the largest pressure against an abscissa, from columns
/// by name.
pub(crate) fn against(abscissa: &Abscissa, column: impl Fn(&str) -> Vec<f64>, modulus: f64, unit: &str) -> Vec<Panel> {
    let [volume, area, peak] = ["wear_volume", "area_fraction", "max_pressure"].map(column);
    let deep = length(unit, largest(&volume));
    let scaled = |values: Vec<f64>, factor: f64| values.into_iter().map(|value| value * factor).collect();
    let columns = vec![
        (scaled(volume, deep.factor), format!("mean depth lost / {}", deep.name)),
        (area, "contact area".to_owned()),
        (scaled(peak, 1.0 / modulus), "largest pressure / *E*\\*".to_owned()),
    ];
    along(abscissa, columns)
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
    let title = format!("row *y* = {place}{known}, through the largest wear");
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
