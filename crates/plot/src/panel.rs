//! The contents of a chart: axes, series of points, reference lines.

/// A value with its uncertainty.
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
    /// A point without an error bar.
    pub fn new(x: f64, y: f64) -> Self {
        Self { x, y, range: None }
    }

    /// A point with an error bar from y - error to y + error.
    pub fn with_error(x: f64, y: f64, error: f64) -> Self {
        Self { x, y, range: Some([y - error, y + error]) }
    }

    /// A point with an error bar from `range[0]` to `range[1]`.
    pub fn within(x: f64, y: f64, range: [f64; 2]) -> Self {
        Self { x, y, range: Some(range) }
    }
}

/// Style of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A symbol at each point, with error bars.
    Points,
    /// A hollow symbol at each point, for derived instead of measured values.
    HollowPoints,
    /// A line from point to point.
    Line,
    /// A broken line from point to point.
    Dashes,
    /// Symbols joined by a thin line.
    JoinedPoints,
    /// A heavy line from point to point.
    Bold,
    /// A line from point to point, with a pale area between it and a side of the axes.
    Filled(Side),
}

/// The end of the pale area of a filled line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The upper edge of the axes.
    Top,
    /// The lower edge of the axes.
    Bottom,
    /// Zero.
    Zero,
}

/// Points of one label, colour and style.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Name in the legend; no entry if empty.
    pub label: String,
    /// Index of the colour and symbol; a fit has the index of its data.
    pub hue: usize,
    /// Style: symbols or lines.
    pub mark: Mark,
    /// The points, in the order of the line.
    pub points: Vec<Point>,
}

impl Series {
    /// Symbols with error bars.
    pub fn points(label: &str, hue: usize, points: Vec<Point>) -> Self {
        Self { label: label.into(), hue, mark: Mark::Points, points }
    }

    /// A line through pairs (x, y).
    pub fn line(label: &str, hue: usize, pairs: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let points = pairs.into_iter().map(|(x, y)| Point::new(x, y)).collect();
        Self { label: label.into(), hue, mark: Mark::Line, points }
    }
}

/// A horizontal reference line, or a band if its two ends differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Lower and upper end; they are equal for a line.
    pub range: [f64; 2],
    /// Label at the right of the axes.
    pub label: String,
}

impl Level {
    /// A line at `y`.
    pub fn line(y: f64, label: &str) -> Self {
        Self { range: [y, y], label: label.into() }
    }

    /// A band over `range`.
    pub fn band(range: [f64; 2], label: &str) -> Self {
        Self { range, label: label.into() }
    }
}

/// Spacing of an axis, or of the colours of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Scale {
    /// Equal steps.
    #[default]
    Linear,
    /// Equal factors; values must be above zero.
    Log,
}

/// One axis of a panel.
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
    /// A linear axis with its range from the data.
    pub fn linear(label: &str) -> Self {
        Self { label: label.into(), scale: Scale::Linear, range: None }
    }

    /// A logarithmic axis with its range from the data.
    pub fn log(label: &str) -> Self {
        Self { label: label.into(), scale: Scale::Log, range: None }
    }

    /// This axis with a given range.
    pub fn over(self, range: [f64; 2]) -> Self {
        Self { range: Some(range), ..self }
    }
}

/// One pair of axes with its data.
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
    /// The data; lines are drawn first.
    pub series: Vec<Series>,
}
