//! Maps as bytes: the length of a head, the head as JSON, and the numbers, row by row along y, as 32-bit floats.

use gfmd_unit::Units;
use ndarray::ArrayView2;
use serde::Serialize;

/// Largest number of points along a side. Of a larger map every second, third, ... point is sent; parts of it have all.
const MOST: usize = 1024;

/// Part of a map: its first point, and its number of points along x and y.
#[derive(Clone, Copy)]
pub(super) struct Part {
    pub(super) from: [usize; 2],
    pub(super) count: [usize; 2],
}

/// Description of a map.
#[derive(Serialize)]
pub(super) struct Head {
    /// Number of points sent along x and y.
    n: [usize; 2],
    /// Number of points of the whole map.
    points: [usize; 2],
    /// First point that is sent.
    from: [usize; 2],
    /// Distance of sent points, in points.
    step: usize,
    /// Size of the whole map in `length_unit`.
    size: [f64; 2],
    length_unit: String,
    /// Unit of the numbers; empty without one.
    unit: String,
    /// Definition of the numbers.
    meaning: String,
    lowest: f64,
    highest: f64,
    undefined: usize,
}

/// Map of numbers `[x, y]` of a kind, on a cell of some size.
pub(super) struct Map<'a> {
    pub(super) values: ArrayView2<'a, f64>,
    pub(super) size: [f64; 2],
    pub(super) kind: &'a str,
    pub(super) meaning: &'a str,
}

impl Map<'_> {
    /// Returns the map, or a part of it that is cut at its edges, in readable units.
    pub(super) fn bytes(&self, units: &Units, part: Option<Part>) -> Vec<u8> {
        let points: [usize; 2] = self.values.dim().into();
        let Part { from, count } = part.unwrap_or(Part { from: [0, 0], count: points });
        let from = [0, 1].map(|axis| from[axis].min(points[axis]));
        let end = [0, 1].map(|axis| from[axis].saturating_add(count[axis]).min(points[axis]));
        let step = (end[0] - from[0]).max(end[1] - from[1]).div_ceil(MOST).max(1);
        let finite = || self.values.iter().copied().filter(|value| value.is_finite());
        let (lowest, highest) =
            finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
        let (factor, unit) = read(units, self.kind, lowest.abs().max(highest.abs()));
        let across = if points[1] == 1 { 0.0 } else { self.size[1] };
        let (longer, length_unit) = read(units, "length", self.size[0].max(across));
        let sent = self.values.slice(ndarray::s![from[0]..end[0];step, from[1]..end[1];step]);
        let head = Head {
            n: sent.dim().into(),
            points,
            from,
            step,
            size: self.size.map(|length| length * longer),
            length_unit,
            unit,
            meaning: self.meaning.into(),
            lowest: lowest * factor,
            highest: highest * factor,
            undefined: self.values.len() - finite().count(),
        };
        // Numbers that are not finite become null.
        let mut head = serde_json::to_vec(&head).unwrap_or_default();
        head.resize(head.len().next_multiple_of(4), b' ');
        let mut bytes = Vec::with_capacity(4 + head.len() + 4 * sent.len());
        bytes.extend_from_slice(&u32::try_from(head.len()).unwrap_or_default().to_le_bytes());
        bytes.append(&mut head);
        for j in 0..sent.ncols() {
            bytes.extend(sent.column(j).iter().flat_map(|value| ((value * factor) as f32).to_le_bytes()));
        }
        bytes
    }
}

/// Returns the factor and the name of the readable unit of numbers up to `largest`.
fn read(units: &Units, kind: &str, largest: f64) -> (f64, String) {
    if kind == "1" {
        return (1.0, String::new());
    }
    match units.shown(kind, largest) {
        Some(unit) => (unit.factor, unit.name),
        None => (1.0, units.name(kind)),
    }
}
