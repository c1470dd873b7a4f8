//! Contents of a chart: axes, series of points, reference lines.

use std::cmp::Ordering;

/// Value with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Abscissa.
    pub x: f64,
    /// Ordinate.
    pub y: f64,
    /// Lower and upper end of the error bar.
    pub range: Option<[f64; 2]>,
}

impl Point {
    /// Creates a point without an error bar.
    pub fn new(x: f64, y: f64) -> Self {
        Self { x, y, range: None }
    }

    /// Creates a point with an error bar from y - error to y + error.
    pub fn with_error(x: f64, y: f64, error: f64) -> Self {
        Self { x, y, range: Some([y - error, y + error]) }
    }

    /// Creates a point with an error bar from `range[0]` to `range[1]`.
    pub fn within(x: f64, y: f64, range: [f64; 2]) -> Self {
        Self { x, y, range: Some(range) }
    }
}

/// Style of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// Symbols with error bars.
    Points,
    /// Hollow symbols, for derived instead of measured values.
    HollowPoints,
    /// Line through the points.
    Line,
    /// Dashed line through the points.
    Dashes,
    /// Symbols joined by a thin line.
    JoinedPoints,
    /// Heavy line through the points.
    Bold,
    /// Line through the points, with a pale area between it and a side of the axes.
    Filled(Side),
}

/// Boundary of the pale area of a filled line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Upper edge of the axes.
    Top,
    /// Lower edge of the axes.
    Bottom,
    /// Zero.
    Zero,
}

/// Points with a common label, colour and style.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend; no entry if empty.
    pub label: String,
    /// Index of the colour and symbol; a fit shares the index of its data.
    pub hue: usize,
    /// Style: symbols or lines.
    pub mark: Mark,
    /// Points, in the order of the line.
    pub points: Vec<Point>,
}

impl Series {
    /// Creates a series of symbols with error bars.
    pub fn points(label: &str, hue: usize, points: Vec<Point>) -> Self {
        Self { label: label.into(), hue, mark: Mark::Points, points }
    }

    /// Creates a line through pairs (x, y).
    pub fn line(label: &str, hue: usize, pairs: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let points = pairs.into_iter().map(|(x, y)| Point::new(x, y)).collect();
        Self { label: label.into(), hue, mark: Mark::Line, points }
    }
}

/// Horizontal reference line, or a band if its two ends differ.
///
/// Data and bands set the axis, lines do not: the legend names a line beyond the axis, with its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Lower and upper end, equal for a line.
    pub range: [f64; 2],
    /// Label at the right of the axes.
    pub label: String,
}

impl Level {
    /// Creates a line at `y`.
    pub fn line(y: f64, label: &str) -> Self {
        Self { range: [y, y], label: label.into() }
    }

    /// Creates a band over `range`.
    pub fn band(range: [f64; 2], label: &str) -> Self {
        Self { range, label: label.into() }
    }

    /// Returns the height of the label.
    pub(super) fn middle(&self) -> f64 {
        0.5 * self.range[0] + 0.5 * self.range[1]
    }

    /// Returns whether the label is below, inside or above an axis.
    pub(super) fn place(&self, [low, high]: [f64; 2]) -> Ordering {
        let middle = self.middle();
        if middle < low {
            Ordering::Less
        } else if middle > high {
            Ordering::Greater
        } else {
            Ordering::Equal
        }
    }
}

/// Spacing of an axis, or of the colours of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps.
    #[default]
    Linear,
    /// Equal factors; values must be positive.
    Log,
}

/// Axis of a panel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Spacing.
    pub scale: Scale,
    /// Ends of the axis; from the data if absent.
    pub range: Option<[f64; 2]>,
}

impl Axis {
    /// Creates a linear axis with its range from the data.
    pub fn linear(label: &str) -> Self {
        Self { label: label.into(), scale: Scale::Linear, range: None }
    }

    /// Creates a logarithmic axis with its range from the data.
    pub fn log(label: &str) -> Self {
        Self { label: label.into(), scale: Scale::Log, range: None }
    }

    /// Returns the axis with a given range.
    pub fn over(self, range: [f64; 2]) -> Self {
        Self { range: Some(range), ..self }
    }
}

/// Pair of axes with its data.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// Title above the axes; none if empty.
    pub title: String,
    /// Abscissa.
    pub x: Axis,
    /// Ordinate.
    pub y: Axis,
    /// Reference lines and bands, behind the data.
    pub levels: Vec<Level>,
    /// Data; areas are drawn first, then lines, then symbols.
    pub series: Vec<Series>,
}
