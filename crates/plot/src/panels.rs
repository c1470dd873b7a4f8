//! Drawing of the panels of a chart: ranges, axes, series, reference lines.

use std::cmp::Ordering;
use std::fmt::Write;

use super::axis::padded;
use super::colour::{INK, REFERENCE, hex, hue};
use super::frame::{Frame, GAP, LABEL, TICK, draw_axes};
use super::symbol::{PALE_AREA, line_width, symbol};
use super::text::{Anchor, Text, number};
use super::{Axis, Mark, Panel, PlotError, Point, Scale, Series, Side};

/// Height of the titles and factors above the axes.
pub(super) const HEAD: f64 = LABEL + GAP + 1.0;

/// Checks that every value is finite, and positive on a logarithmic axis.
pub(super) fn check(panel: &Panel) -> Result<(), PlotError> {
    let one = |found: f64, axis: &Axis, place: &dyn Fn() -> String| {
        if !found.is_finite() {
            return Err(PlotError::NotFinite { found, place: place() });
        }
        if axis.scale == Scale::Log && found <= 0.0 {
            return Err(PlotError::NotPositive { found, place: place() });
        }
        Ok(())
    };
    if panel.series.iter().all(|series| series.points.is_empty()) {
        return Err(PlotError::Empty { what: "a panel has no points" });
    }
    for series in &panel.series {
        for (i, point) in series.points.iter().enumerate() {
            let place = || format!("point {i} of series \"{}\"", series.label);
            one(point.x, &panel.x, &place)?;
            one(point.y, &panel.y, &place)?;
            // An error bar that reaches zero on a logarithmic axis is allowed: it is clipped at the frame.
            for end in point.range.into_iter().flatten() {
                one(end, &Axis::default(), &place)?;
            }
        }
    }
    for level in &panel.levels {
        level.range.iter().try_for_each(|&end| one(end, &panel.y, &|| format!("reference \"{}\"", level.label)))?;
    }
    Ok(())
}

/// Returns the ranges of x and y of each panel, from data with their error bars and from bands; reference lines may lie
/// outside. With `share_y`, all panels have the same range of y.
pub(super) fn ranges(panels: &[Panel], share_y: bool) -> Result<Vec<[[f64; 2]; 2]>, PlotError> {
    let xs = |panel: &Panel| -> Vec<f64> { panel.series.iter().flat_map(|s| s.points.iter().map(|p| p.x)).collect() };
    let ys = |panel: &Panel| -> Vec<f64> {
        let positive = |y: &f64| panel.y.scale == Scale::Linear || *y > 0.0;
        let of = |point: &Point| [Some(point.y), point.range.map(|r| r[0]), point.range.map(|r| r[1])];
        let points = panel.series.iter().flat_map(|series| series.points.iter().flat_map(of).flatten());
        let zero = panel.series.iter().filter(|series| series.mark == Mark::Filled(Side::Zero)).map(|_| 0.0);
        let bands = panel.levels.iter().map(|level| level.range).filter(|[low, high]| low != high).flatten();
        points.chain(zero).chain(bands).filter(positive).collect()
    };
    let common: Vec<f64> = panels.iter().flat_map(ys).collect();
    let end = |axis: &Axis, values: Vec<f64>| {
        axis.range
            .or_else(|| padded(axis.scale, values.into_iter()))
            .ok_or(PlotError::Empty { what: "an axis has no values" })
    };
    panels
        .iter()
        .map(|panel| {
            let y = if share_y { end(&panels[0].y, common.clone())? } else { end(&panel.y, ys(panel))? };
            Ok([end(&panel.x, xs(panel))?, y])
        })
        .collect()
}

/// Returns the width right of the axes, whose range of y is given.
pub(super) fn right_margin(panel: &Panel, range: [f64; 2]) -> f64 {
    let inside = panel.levels.iter().filter(|level| level.place(range) == Ordering::Equal);
    let widest = inside.map(|level| Text::new(&level.label, TICK).width()).fold(0.0, f64::max);
    if widest > 0.0 { widest + GAP } else { 0.5 * TICK }
}

/// Labelled parts of a panel.
#[derive(Clone, Copy)]
pub(super) struct Labels {
    pub(super) x: bool,
    pub(super) y: bool,
    pub(super) levels: bool,
}

pub(super) fn draw_panel(svg: &mut String, panel: &Panel, frame: &Frame, index: usize, labels: Labels) {
    let Frame { left, top, width, height, .. } = frame;
    let [l, t, w, h] = [*left, *top, *width, *height].map(number);
    let _ = writeln!(svg, r#"<clipPath id="panel{index}"><rect x="{l}" y="{t}" width="{w}" height="{h}"/></clipPath>"#);
    let _ = writeln!(svg, r##"<g clip-path="url(#panel{index})">"##);
    for level in &panel.levels {
        let ((_, low), (_, high)) = (frame.at(0.0, level.range[0]), frame.at(0.0, level.range[1]));
        let colour = hex(REFERENCE);
        if level.range[0] == level.range[1] {
            let _ = writeln!(
                svg,
                r#"<path d="M{l} {y}h{w}" stroke="{colour}" stroke-width="0.8" stroke-dasharray="4 2.2" fill="none"/>"#,
                y = number(low)
            );
        } else {
            let (y, tall) = (number(high.min(low)), number((low - high).abs()));
            let _ =
                writeln!(svg, r#"<rect x="{l}" y="{y}" width="{w}" height="{tall}" fill="{colour}" opacity="0.18"/>"#);
        }
    }
    // Areas, then lines, then symbols.
    let layer = |series: &Series| match series.mark {
        Mark::Filled(_) => 0,
        Mark::Line | Mark::Dashes | Mark::Bold => 1,
        Mark::Points | Mark::HollowPoints | Mark::JoinedPoints => 2,
    };
    for wanted in 0..3 {
        panel.series.iter().filter(|series| layer(series) == wanted).for_each(|series| draw_series(svg, series, frame));
    }
    svg.push_str("</g>\n");
    draw_axes(svg, frame, Some(&panel.x).filter(|_| labels.x), Some(&panel.y).filter(|_| labels.y));
    if !panel.title.is_empty() {
        let indent = if frame.y.factor.is_empty() || !labels.y {
            0.0
        } else {
            Text::new(&frame.y.factor, TICK).width() + 2.0 * GAP
        };
        let title = Text::new(&panel.title, LABEL);
        title.write(svg, left + indent, top - GAP - 1.0, Anchor::Start, 0.0, &hex(INK));
    }
    if labels.levels {
        draw_level_names(svg, panel, frame);
    }
}

/// Writes the names of the reference lines at the right, moved apart where they would overlap.
fn draw_level_names(svg: &mut String, panel: &Panel, frame: &Frame) {
    let mut names: Vec<(f64, Text)> = panel
        .levels
        .iter()
        .filter(|level| !level.label.is_empty())
        .filter(|level| (0.0..=1.0).contains(&frame.y.fraction(level.middle())))
        .map(|level| (frame.at(0.0, level.middle()).1, Text::new(&level.label, TICK)))
        .collect();
    names.sort_by(|a, b| a.0.total_cmp(&b.0));
    let distance = 1.15 * TICK;
    for _ in 0..100 {
        let mut moved = false;
        for i in 1..names.len() {
            let short = distance - (names[i].0 - names[i - 1].0);
            if short > 1e-6 {
                names[i - 1].0 -= 0.5 * short;
                names[i].0 += 0.5 * short;
                moved = true;
            }
        }
        if !moved {
            break;
        }
    }
    for (y, name) in names {
        name.write(svg, frame.left + frame.width + GAP, y + 0.35 * TICK, Anchor::Start, 0.0, &hex(REFERENCE));
    }
}

fn draw_series(svg: &mut String, series: &Series, frame: &Frame) {
    let colour = hex(hue(series.hue));
    let positions: Vec<(f64, f64)> = series.points.iter().map(|point| frame.at(point.x, point.y)).collect();
    if let (Some(width), true) = (line_width(series.mark), positions.len() > 1) {
        let mut path = String::new();
        for (i, (x, y)) in positions.iter().enumerate() {
            let _ = write!(path, "{}{} {}", if i == 0 { 'M' } else { 'L' }, number(*x), number(*y));
        }
        if let Mark::Filled(side) = series.mark {
            let edge = match side {
                Side::Top => frame.top,
                Side::Bottom => frame.top + frame.height,
                Side::Zero => frame.at(0.0, 0.0).1,
            };
            let [first, last] = [0, positions.len() - 1].map(|i| number(positions[i].0));
            let edge = number(edge);
            let _ = writeln!(
                svg,
                r#"<path d="{path}L{last} {edge}L{first} {edge}Z" fill="{colour}" opacity="{PALE_AREA}"/>"#
            );
        }
        let dashes = if series.mark == Mark::Dashes { r#" stroke-dasharray="5 2.5""# } else { "" };
        let _ = writeln!(
            svg,
            r#"<path d="{path}" stroke="{colour}" stroke-width="{width}"{dashes} stroke-linejoin="round" fill="none"/>"#
        );
    }
    if matches!(series.mark, Mark::Line | Mark::Dashes | Mark::Bold | Mark::Filled(_)) {
        return;
    }
    let mut bars = String::new();
    for (point, (x, _)) in series.points.iter().zip(&positions) {
        let Some(range) = point.range else { continue };
        let clip = |end: f64| if frame.y.fraction(end).is_finite() { end } else { f64::MIN_POSITIVE };
        let [low, high] = range.map(|end| frame.at(point.x, clip(end)).1);
        let [left, x, low, high] = [x - 1.8, *x, low, high].map(number);
        let _ = write!(bars, "M{x} {low}V{high}M{left} {low}h3.6M{left} {high}h3.6");
    }
    if !bars.is_empty() {
        let _ = writeln!(svg, r#"<path d="{bars}" stroke="{colour}" stroke-width="0.8" fill="none"/>"#);
    }
    let (fill, edge) =
        if series.mark == Mark::HollowPoints { ("#ffffff", colour.as_str()) } else { (colour.as_str(), "#ffffff") };
    let edge_width = if series.mark == Mark::HollowPoints { 1.0 } else { 0.4 };
    let symbols: String = positions.iter().map(|&at| symbol(series.hue, at)).collect();
    let _ = writeln!(svg, r#"<path d="{symbols}" fill="{fill}" stroke="{edge}" stroke-width="{edge_width}"/>"#);
}
