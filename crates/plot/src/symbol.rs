//! Symbols of points, and line widths.

use std::fmt::Write;

use super::Mark;
use super::text::number;

/// Half the size of a symbol, in points.
pub(super) const SYMBOL: f64 = 2.3;

/// Opacity of the area beside a filled line.
pub(super) const PALE_AREA: f64 = 0.2;

/// Returns the line width of a mark in points, or `None` for symbols alone.
pub(super) fn line_width(mark: Mark) -> Option<f64> {
    match mark {
        Mark::Line | Mark::Dashes => Some(1.1),
        Mark::JoinedPoints => Some(0.7),
        Mark::Bold => Some(2.2),
        Mark::Filled(_) => Some(0.6),
        Mark::Points | Mark::HollowPoints => None,
    }
}

/// Returns the outline of a symbol. Each colour has its own symbol, so that figures can be read without colours.
pub(super) fn symbol(hue: usize, (x, y): (f64, f64)) -> String {
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
