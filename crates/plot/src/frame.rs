//! A pair of axes in the drawing: box, ticks and labels.

use std::fmt::Write;

use super::Axis;
use super::axis::Ticks;
use super::colour::{INK, hex};
use super::text::{Anchor, Text, number};

/// Font sizes in points.
pub(super) const LABEL: f64 = 8.0;
pub(super) const TICK: f64 = 7.0;

/// Lengths in points.
pub(super) const GAP: f64 = 3.0;
pub(super) const EDGE: f64 = 4.0;
const MAJOR: f64 = 3.2;
const MINOR: f64 = 1.8;

/// Pair of axes and its position in the drawing, in points.
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
    pub(super) x: Ticks,
    pub(super) y: Ticks,
}

impl Frame {
    pub(super) fn at(&self, x: f64, y: f64) -> (f64, f64) {
        // Points far outside are clipped anyway; SVG renderers need moderate coordinates.
        let far = |fraction: f64| fraction.clamp(-50.0, 50.0);
        (self.left + far(self.x.fraction(x)) * self.width, self.top + (1.0 - far(self.y.fraction(y))) * self.height)
    }
}

pub(super) fn left_margin(ticks: &Ticks, axis: &Axis) -> f64 {
    let widest = ticks.major.iter().map(|(_, label)| Text::new(label, TICK).width()).fold(0.0, f64::max);
    let label = if axis.label.is_empty() { 0.0 } else { LABEL + 2.0 * GAP };
    widest + GAP + label
}

/// Height of the labels below the axes.
pub(super) const UNDER: f64 = GAP + TICK + GAP + 1.3 * LABEL;

/// Draws the box, ticks and labels; an omitted axis has no labels.
pub(super) fn draw_axes(svg: &mut String, frame: &Frame, x: Option<&Axis>, y: Option<&Axis>) {
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

    if let Some(x) = x {
        for (value, label) in &frame.x.major {
            let at = left + frame.x.fraction(*value) * width;
            Text::new(label, TICK).write(svg, at, bottom + GAP + 0.85 * TICK, Anchor::Middle, 0.0, &ink);
        }
        let below = bottom + GAP + TICK + GAP + 0.8 * LABEL;
        Text::new(&x.label, LABEL).write(svg, left + 0.5 * width, below, Anchor::Middle, 0.0, &ink);
        if !frame.x.factor.is_empty() {
            Text::new(&frame.x.factor, TICK).write(svg, right, below, Anchor::End, 0.0, &ink);
        }
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
