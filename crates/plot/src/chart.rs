//! Panels with axes, series, reference lines and a legend.

use std::fmt::Write;

use super::axis::{Ticks, padded};
use super::colour::{INK, REFERENCE, hex, hue};
use super::drawing::Drawing;
use super::text::{Anchor, Text, number};
use super::{Axis, Chart, Mark, Panel, PlotError, Point, Scale, Series};

/// Font sizes, points.
pub(super) const LABEL: f64 = 8.0;
pub(super) const TICK: f64 = 7.0;

/// Lengths, points.
pub(super) const GAP: f64 = 3.0;
const EDGE: f64 = 4.0;
const MAJOR: f64 = 3.2;
const MINOR: f64 = 1.8;
const SYMBOL: f64 = 2.3;
const SAMPLE: f64 = 16.0;
const BETWEEN_PANELS: f64 = 12.0;

/// Where a pair of axes lies in the drawing.
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) x: Ticks,
    pub(super) y: Ticks,
}

impl Frame {
    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        // Far outside is as good as infinitely far, and SVG renderers prefer it.
        let far = |fraction: f64| fraction.clamp(-50.0, 50.0);
        (self.left + far(self.x.fraction(x)) * self.width, self.top + (1.0 - far(self.y.fraction(y))) * self.height)
    }
}

pub(super) fn draw(chart: &Chart) -> Result<Drawing, PlotError> {
    if chart.panels.is_empty() {
        return Err(PlotError::Empty { what: "the figure has no panels" });
    }
    chart.panels.iter().try_for_each(check)?;
    let count = chart.panels.len();
    let ranges = ranges(chart)?;
    let y_ticks = ranges
        .iter()
        .zip(&chart.panels)
        .map(|(range, panel)| Ticks::new(panel.y.scale, range[1], chart.height / 26.0))
        .collect::<Result<Vec<_>, _>>()?;

    let legend = legend(chart);
    let (legend_rows, legend_height) = arrange(&legend, chart.width - 2.0 * EDGE);
    let titled = chart.panels.iter().any(|panel| !panel.title.is_empty());
    let factored = y_ticks.iter().any(|ticks| !ticks.factor.is_empty());
    let above = if titled || factored { LABEL + GAP + 1.0 } else { 0.0 };
    let top = EDGE + legend_height + above + 0.5 * TICK;

    // Margins: tick labels and the label of the ordinate at the left, names of reference lines at the right.
    let lefts: Vec<f64> = (0..count)
        .map(|i| if i == 0 || !chart.share_y { left_margin(&y_ticks[i], &chart.panels[i].y) } else { 0.0 })
        .collect();
    let rights: Vec<f64> = (0..count)
        .map(|i| if i + 1 == count || !chart.share_y { right_margin(&chart.panels[i]) } else { 0.0 })
        .collect();
    let margins: f64 = lefts.iter().chain(&rights).sum();
    let gaps = (count - 1) as f64 * BETWEEN_PANELS;
    let width = ((chart.width - 2.0 * EDGE - margins - gaps) / count as f64).max(40.0);

    let mut svg = String::new();
    let mut left = EDGE;
    for (i, panel) in chart.panels.iter().enumerate() {
        left += lefts[i];
        let x = Ticks::new(panel.x.scale, ranges[i][0], width / 34.0)?;
        let frame = Frame { left, top, width, height: chart.height, x, y: y_ticks[i].clone() };
        let bare = chart.share_y && i > 0;
        let named = !chart.share_y || i + 1 == count;
        draw_panel(&mut svg, panel, &frame, i, bare, named);
        left += width + rights[i] + BETWEEN_PANELS;
    }
    draw_legend(&mut svg, &legend_rows, chart.width);
    let bottom = top + chart.height + GAP + TICK + GAP + LABEL + 0.3 * LABEL + EDGE;
    Ok(Drawing { width: chart.width, height: bottom, pictures: Vec::new(), elements: svg })
}

/// Every value is finite, and above zero on a logarithmic axis.
fn check(panel: &Panel) -> Result<(), PlotError> {
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
            // An error bar that reaches zero is cut at the frame, not refused.
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

/// The ends of x and y for each panel.
fn ranges(chart: &Chart) -> Result<Vec<[[f64; 2]; 2]>, PlotError> {
    let xs = |panel: &Panel| -> Vec<f64> { panel.series.iter().flat_map(|s| s.points.iter().map(|p| p.x)).collect() };
    let ys = |panel: &Panel| -> Vec<f64> {
        let positive = |y: &f64| panel.y.scale == Scale::Linear || *y > 0.0;
        let of = |point: &Point| [Some(point.y), point.range.map(|r| r[0]), point.range.map(|r| r[1])];
        let points = panel.series.iter().flat_map(|series| series.points.iter().flat_map(of).flatten());
        points.chain(panel.levels.iter().flat_map(|level| level.range)).filter(positive).collect()
    };
    let common: Vec<f64> = chart.panels.iter().flat_map(ys).collect();
    let end = |axis: &Axis, values: Vec<f64>| {
        axis.range
            .or_else(|| padded(axis.scale, values.into_iter()))
            .ok_or(PlotError::Empty { what: "an axis has no values" })
    };
    chart
        .panels
        .iter()
        .map(|panel| {
            let y = if chart.share_y { end(&chart.panels[0].y, common.clone())? } else { end(&panel.y, ys(panel))? };
            Ok([end(&panel.x, xs(panel))?, y])
        })
        .collect()
}

pub(super) fn left_margin(ticks: &Ticks, axis: &Axis) -> f64 {
    let widest = ticks.major.iter().map(|(_, label)| Text::new(label, TICK).width()).fold(0.0, f64::max);
    let label = if axis.label.is_empty() { 0.0 } else { LABEL + 2.0 * GAP };
    widest + GAP + label
}

fn right_margin(panel: &Panel) -> f64 {
    let widest = panel.levels.iter().map(|level| Text::new(&level.label, TICK).width()).fold(0.0, f64::max);
    if widest > 0.0 { widest + GAP } else { 0.5 * TICK }
}

fn draw_panel(svg: &mut String, panel: &Panel, frame: &Frame, index: usize, bare: bool, named: bool) {
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
    let is_line = |series: &&Series| matches!(series.mark, Mark::Line | Mark::Dashes);
    for series in panel.series.iter().filter(is_line) {
        draw_series(svg, series, frame);
    }
    for series in panel.series.iter().filter(|series| !is_line(series)) {
        draw_series(svg, series, frame);
    }
    svg.push_str("</g>\n");
    draw_axes(svg, frame, &panel.x, if bare { None } else { Some(&panel.y) });
    if !panel.title.is_empty() {
        let indent =
            if frame.y.factor.is_empty() || bare { 0.0 } else { Text::new(&frame.y.factor, TICK).width() + 2.0 * GAP };
        let title = Text::new(&panel.title, LABEL);
        title.write(svg, left + indent, top - GAP - 1.0, Anchor::Start, 0.0, &hex(INK));
    }
    if named {
        draw_level_names(svg, panel, frame);
    }
}

/// Names of the reference lines at the right, moved apart where they would touch.
fn draw_level_names(svg: &mut String, panel: &Panel, frame: &Frame) {
    let mut names: Vec<(f64, Text)> = panel
        .levels
        .iter()
        .filter(|level| !level.label.is_empty())
        .map(|level| (frame.at(0.0, 0.5 * (level.range[0] + level.range[1])).1, Text::new(&level.label, TICK)))
        .filter(|(y, _)| (frame.top - 1.0..=frame.top + frame.height + 1.0).contains(y))
        .collect();
    names.sort_by(|a, b| a.0.total_cmp(&b.0));
    let room = 1.15 * TICK;
    for _ in 0..100 {
        let mut moved = false;
        for i in 1..names.len() {
            let short = room - (names[i].0 - names[i - 1].0);
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

/// The box, its ticks, their labels and the labels of the axes; without `y` the ordinate has no words.
pub(super) fn draw_axes(svg: &mut String, frame: &Frame, x: &Axis, y: Option<&Axis>) {
    let Frame { left, top, width, height, .. } = frame;
    let (right, bottom) = (left + width, top + height);
    let ink = hex(INK);
    let mut path = String::new();
    let mut tick = |from: (f64, f64), by: (f64, f64)| {
        let [x, y, dx, dy] = [from.0, from.1, by.0, by.1].map(number);
        let _ = write!(path, "M{x} {y}l{dx} {dy}");
    };
    let all = |ticks: &Ticks| -> Vec<(f64, f64)> {
        let major = ticks.major.iter().map(|(value, _)| (ticks.fraction(*value), MAJOR));
        major.chain(ticks.minor.iter().map(|value| (ticks.fraction(*value), MINOR))).collect()
    };
    for (fraction, length) in all(&frame.x) {
        let at = left + fraction * width;
        tick((at, bottom), (0.0, -length));
        tick((at, *top), (0.0, length));
    }
    for (fraction, length) in all(&frame.y) {
        let at = bottom - fraction * height;
        tick((*left, at), (length, 0.0));
        tick((right, at), (-length, 0.0));
    }
    let [l, t, w, h] = [*left, *top, *width, *height].map(number);
    let _ = writeln!(svg, r#"<path d="{path}" stroke="{ink}" stroke-width="0.6" fill="none"/>"#);
    let _ = writeln!(
        svg,
        r#"<rect x="{l}" y="{t}" width="{w}" height="{h}" stroke="{ink}" stroke-width="0.8" fill="none"/>"#
    );

    for (value, label) in &frame.x.major {
        let at = left + frame.x.fraction(*value) * width;
        Text::new(label, TICK).write(svg, at, bottom + GAP + 0.85 * TICK, Anchor::Middle, 0.0, &ink);
    }
    let below = bottom + GAP + TICK + GAP + 0.8 * LABEL;
    Text::new(&x.label, LABEL).write(svg, left + 0.5 * width, below, Anchor::Middle, 0.0, &ink);
    if !frame.x.factor.is_empty() {
        Text::new(&frame.x.factor, TICK).write(svg, right, below, Anchor::End, 0.0, &ink);
    }
    let Some(y) = y else { return };
    for (value, label) in &frame.y.major {
        let at = bottom - frame.y.fraction(*value) * height;
        Text::new(label, TICK).write(svg, left - GAP, at + 0.35 * TICK, Anchor::End, 0.0, &ink);
    }
    let beside = left - left_margin(&frame.y, y) + 0.8 * LABEL;
    Text::new(&y.label, LABEL).write(svg, beside, top + 0.5 * height, Anchor::Middle, -90.0, &ink);
    if !frame.y.factor.is_empty() {
        Text::new(&frame.y.factor, TICK).write(svg, *left, top - GAP - 1.0, Anchor::Start, 0.0, &ink);
    }
}

fn draw_series(svg: &mut String, series: &Series, frame: &Frame) {
    let colour = hex(hue(series.hue));
    let positions: Vec<(f64, f64)> = series.points.iter().map(|point| frame.at(point.x, point.y)).collect();
    let line = match series.mark {
        Mark::Line => Some((1.1, "")),
        Mark::Dashes => Some((1.1, r#" stroke-dasharray="5 2.5""#)),
        Mark::JoinedPoints => Some((0.7, "")),
        Mark::Points | Mark::HollowPoints => None,
    };
    if let (Some((width, dashes)), true) = (line, positions.len() > 1) {
        let mut path = String::new();
        for (i, (x, y)) in positions.iter().enumerate() {
            let _ = write!(path, "{}{} {}", if i == 0 { 'M' } else { 'L' }, number(*x), number(*y));
        }
        let _ = writeln!(
            svg,
            r#"<path d="{path}" stroke="{colour}" stroke-width="{width}"{dashes} stroke-linejoin="round" fill="none"/>"#
        );
    }
    if matches!(series.mark, Mark::Line | Mark::Dashes) {
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

/// The outline of a symbol; each colour has its own, so that a figure can be read without colours.
fn symbol(hue: usize, (x, y): (f64, f64)) -> String {
    let polygon = |corners: &[(f64, f64)]| {
        let mut path = String::new();
        for (i, (dx, dy)) in corners.iter().enumerate() {
            let _ = write!(
                path,
                "{}{} {}",
                if i == 0 { 'M' } else { 'L' },
                number(x + SYMBOL * dx),
                number(y + SYMBOL * dy)
            );
        }
        path + "Z"
    };
    match hue % 7 {
        0 => {
            let (left, y, r) = (number(x - SYMBOL), number(y), number(SYMBOL));
            let d = number(2.0 * SYMBOL);
            format!("M{left} {y}a{r} {r} 0 1 0 {d} 0a{r} {r} 0 1 0 -{d} 0Z")
        }
        1 => polygon(&[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)]),
        2 => polygon(&[(0.0, -1.2), (1.1, 0.75), (-1.1, 0.75)]),
        3 => polygon(&[(0.0, -1.25), (1.25, 0.0), (0.0, 1.25), (-1.25, 0.0)]),
        4 => polygon(&[(0.0, 1.2), (1.1, -0.75), (-1.1, -0.75)]),
        5 => polygon(&[(1.2, 0.0), (-0.75, 1.1), (-0.75, -1.1)]),
        _ => polygon(&[(0.0, -1.2), (1.14, -0.37), (0.71, 0.97), (-0.71, 0.97), (-1.14, -0.37)]),
    }
}

/// What the legend names: each label once, with all marks that carry it, by colour.
struct Entry {
    text: Text,
    samples: Vec<Vec<Series>>,
}

impl Entry {
    fn width(&self) -> f64 {
        self.samples.iter().map(|samples| sample_width(samples)).sum::<f64>() + GAP + self.text.width()
    }
}

fn sample_width(samples: &[Series]) -> f64 {
    let symbols = samples.iter().all(|sample| matches!(sample.mark, Mark::Points | Mark::HollowPoints));
    if symbols { 4.0 * SYMBOL } else { SAMPLE }
}

fn legend(chart: &Chart) -> Vec<Entry> {
    let mut entries: Vec<(&str, Entry)> = Vec::new();
    for series in chart.panels.iter().flat_map(|panel| &panel.series).filter(|series| !series.label.is_empty()) {
        let sample = Series { points: Vec::new(), ..series.clone() };
        let position = entries.iter().position(|(label, _)| *label == series.label).unwrap_or(entries.len());
        if position == entries.len() {
            let text = Text::new(&series.label, TICK);
            entries.push((&series.label, Entry { text, samples: Vec::new() }));
        }
        let samples = &mut entries[position].1.samples;
        match samples.iter_mut().find(|group| group[0].hue == sample.hue) {
            Some(group) if group.contains(&sample) => {}
            Some(group) => group.push(sample),
            None => samples.push(vec![sample]),
        }
    }
    entries.into_iter().map(|(_, entry)| entry).collect()
}

/// Rows of entries that fit into `width`, and their height.
fn arrange(entries: &[Entry], width: f64) -> (Vec<Vec<&Entry>>, f64) {
    let mut rows: Vec<Vec<&Entry>> = Vec::new();
    let mut used = f64::INFINITY;
    for entry in entries {
        let needed = entry.width() + 4.0 * GAP;
        if used + needed > width {
            rows.push(Vec::new());
            used = 0.0;
        }
        if let Some(row) = rows.last_mut() {
            row.push(entry);
        }
        used += needed;
    }
    let height = rows.len() as f64 * 1.4 * TICK + if rows.is_empty() { 0.0 } else { GAP };
    (rows, height)
}

fn draw_legend(svg: &mut String, rows: &[Vec<&Entry>], width: f64) {
    for (i, row) in rows.iter().enumerate() {
        let total: f64 = row.iter().map(|entry| entry.width()).sum::<f64>() + 4.0 * GAP * (row.len() - 1) as f64;
        let mut left = 0.5 * (width - total);
        let y = EDGE + (i as f64 + 0.5) * 1.4 * TICK;
        for entry in row {
            let mut at = left;
            for group in &entry.samples {
                let width = sample_width(group);
                group.iter().for_each(|sample| draw_sample(svg, sample, [at, at + width], y));
                at += width;
            }
            entry.text.write(svg, at + GAP, y + 0.35 * TICK, Anchor::Start, 0.0, &hex(INK));
            left += entry.width() + 4.0 * GAP;
        }
    }
}

fn draw_sample(svg: &mut String, series: &Series, ends: [f64; 2], y: f64) {
    let colour = hex(hue(series.hue));
    let dashes = if series.mark == Mark::Dashes { r#" stroke-dasharray="5 2.5""# } else { "" };
    if matches!(series.mark, Mark::Line | Mark::Dashes | Mark::JoinedPoints) {
        let [x0, x1, y] = [ends[0], ends[1], y].map(number);
        let width = if series.mark == Mark::JoinedPoints { 0.7 } else { 1.1 };
        let _ =
            writeln!(svg, r#"<path d="M{x0} {y}H{x1}" stroke="{colour}" stroke-width="{width}"{dashes} fill="none"/>"#);
    }
    let symbol = symbol(series.hue, (0.5 * (ends[0] + ends[1]), y));
    match series.mark {
        Mark::Points | Mark::JoinedPoints => {
            let _ = writeln!(svg, r##"<path d="{symbol}" fill="{colour}" stroke="#ffffff" stroke-width="0.4"/>"##);
        }
        Mark::HollowPoints => {
            let _ = writeln!(svg, r##"<path d="{symbol}" fill="#ffffff" stroke="{colour}" stroke-width="1"/>"##);
        }
        Mark::Line | Mark::Dashes => {}
    }
}
