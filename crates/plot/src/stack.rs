//! Panels one below the other, with one abscissa.

use super::axis::Ticks;
use super::chart::{HEAD, Labels, draw_panel, ranges, right_margin};
use super::drawing::Drawing;
use super::frame::{EDGE, Frame, TICK, UNDER, left_margin};
use super::legend::{arrange, draw_legend, legend};
use super::{Chart, PlotError};

/// The height that a label of an ordinate takes.
const ROOM: f64 = 20.0;

/// The distance between two panels.
const BETWEEN: f64 = 7.0;

/// Draws the panels of a chart from top to bottom. The chart has at least one panel.
pub(super) fn draw(chart: &Chart) -> Result<Drawing, PlotError> {
    let ranges = ranges(chart)?;
    let lowest = chart.panels.len() - 1;
    // The abscissa holds all panels, unless the lowest has a range.
    let whole = |[a, b]: [f64; 2], [[low, high], _]: &[[f64; 2]; 2]| [a.min(*low), b.max(*high)];
    let abscissa = &chart.panels[lowest].x;
    let range = abscissa.range.unwrap_or_else(|| ranges.iter().fold([f64::INFINITY, f64::NEG_INFINITY], whole));

    let legend = legend(&chart.panels);
    let (legend_rows, legend_height) = arrange(&legend, chart.width - 2.0 * EDGE);
    let mut panels = Vec::new();
    let mut top = EDGE + legend_height + 0.5 * TICK;
    for (index, panel) in chart.panels.iter().enumerate() {
        let height = if index == 0 { chart.height } else { 0.5 * chart.height };
        let ticks = Ticks::new(panel.y.scale, ranges[index][1], height / ROOM)?;
        top += if panel.title.is_empty() && ticks.factor.is_empty() { 0.0 } else { HEAD };
        panels.push((panel, ticks, top, height));
        top += height + BETWEEN;
    }
    let bottom = top - BETWEEN;

    let lefts = panels.iter().map(|(panel, ticks, ..)| left_margin(ticks, &panel.y));
    let left = EDGE + lefts.fold(0.0, f64::max);
    let right = chart.panels.iter().map(right_margin).fold(0.0, f64::max);
    let width = (chart.width - left - right - EDGE).max(40.0);
    let x = Ticks::new(abscissa.scale, range, width / 34.0)?;
    let mut svg = String::new();
    for (index, (panel, y, top, height)) in panels.into_iter().enumerate() {
        let frame = Frame { left, top, width, height, x: x.clone(), y };
        let labels = Labels { x: index == lowest, y: true, levels: true };
        draw_panel(&mut svg, panel, &frame, index, labels);
    }
    draw_legend(&mut svg, &legend_rows, chart.width);
    Ok(Drawing { width: chart.width, height: bottom + UNDER + EDGE, pictures: Vec::new(), elements: svg })
}
