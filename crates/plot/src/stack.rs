//! Panels one below the other with a common abscissa.

use super::axis::Ticks;
use super::drawing::Drawing;
use super::frame::{EDGE, Frame, TICK, UNDER, left_margin};
use super::legend::{arrange, draw_legend, legend};
use super::panels::{HEAD, Labels, draw_panel, right_margin};
use super::{Panel, PlotError};

/// Height per label of an ordinate.
const LABEL_HEIGHT: f64 = 20.0;

/// Distance between two panels.
const BETWEEN: f64 = 7.0;

/// Draws panels (at least one) with their `ranges` from top to bottom. `total` is the width of the figure, `height` the
/// height of the first axes; the others have half of it.
pub(super) fn draw(
    panels: &[Panel],
    ranges: &[[[f64; 2]; 2]],
    [total, height]: [f64; 2],
) -> Result<Drawing, PlotError> {
    let lowest = panels.len() - 1;
    // The abscissa spans all panels, unless the lowest has a given range.
    let whole = |[a, b]: [f64; 2], [[low, high], _]: &[[f64; 2]; 2]| [a.min(*low), b.max(*high)];
    let abscissa = &panels[lowest].x;
    let range = abscissa.range.unwrap_or_else(|| ranges.iter().fold([f64::INFINITY, f64::NEG_INFINITY], whole));

    let legend = legend(panels, ranges);
    let (legend_rows, legend_height) = arrange(&legend, total - 2.0 * EDGE);
    let mut placed = Vec::new();
    let mut top = EDGE + legend_height + 0.5 * TICK;
    for (index, panel) in panels.iter().enumerate() {
        let height = if index == 0 { height } else { 0.5 * height };
        let ticks = Ticks::new(panel.y.scale, ranges[index][1], height / LABEL_HEIGHT)?;
        top += if panel.title.is_empty() && ticks.factor.is_empty() { 0.0 } else { HEAD };
        placed.push((panel, ticks, top, height));
        top += height + BETWEEN;
    }
    let bottom = top - BETWEEN;

    let lefts = placed.iter().map(|(panel, ticks, ..)| left_margin(ticks, &panel.y));
    let left = EDGE + lefts.fold(0.0, f64::max);
    let rights = panels.iter().zip(ranges).map(|(panel, range)| right_margin(panel, range[1]));
    let right = rights.fold(0.0, f64::max);
    let width = (total - left - right - EDGE).max(40.0);
    let x = Ticks::new(abscissa.scale, range, width / 34.0)?;
    let mut svg = String::new();
    for (index, (panel, y, top, height)) in placed.into_iter().enumerate() {
        let frame = Frame { left, top, width, height, x: x.clone(), y };
        let labels = Labels { x: index == lowest, y: true, levels: true };
        draw_panel(&mut svg, panel, &frame, index, labels);
    }
    draw_legend(&mut svg, &legend_rows, total);
    Ok(Drawing { width: total, height: bottom + UNDER + EDGE, pictures: Vec::new(), elements: svg })
}
