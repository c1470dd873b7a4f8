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
    /// Without an error bar.
    pub fn new(x: f64, y: f64) -> Self {
        Self { x, y, range: None }
    }

    /// With the error bar y - error to y + error.
    pub fn with_error(x: f64, y: f64, error: f64) -> Self {
        Self { x, y, range: Some([y - error, y + error]) }
    }

    /// With the error bar from `range[0]` to `range[1]`.
    pub fn within(x: f64, y: f64, range: [f64; 2]) -> Self {
        Self { x, y, range: Some(range) }
    }
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A symbol at each point; error bars where there are errors.
    Points,
    /// A hollow symbol at each point, for what is derived, not measured.
    HollowPoints,
    /// A line from point to point.
    Line,
    /// A broken line from point to point.
    Dashes,
    /// Symbols joined by a thin line.
    JoinedPoints,
}

/// Points that belong together.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Its name in the legend; none if empty.
    pub label: String,
    /// Index of its colour and symbol; a fit takes that of its data.
    pub hue: usize,
    /// Symbols or lines.
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

/// A horizontal reference: a line, or a band if it has a width.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// Lower and upper end; equal for a line.
    pub range: [f64; 2],
    /// Written at the right of the axes.
    pub label: String,
}

impl Level {
    /// A line.
    pub fn line(y: f64, label: &str) -> Self {
        Self { range: [y, y], label: label.into() }
    }

    /// A band.
    pub fn band(range: [f64; 2], label: &str) -> Self {
        Self { range, label: label.into() }
    }
}

/// Spacing of an axis.
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
    /// Linear, range from the data.
    pub fn linear(label: &str) -> Self {
        Self { label: label.into(), scale: Scale::Linear, range: None }
    }

    /// Logarithmic, range from the data.
    pub fn log(label: &str) -> Self {
        Self { label: label.into(), scale: Scale::Log, range: None }
    }

    /// The same with given ends.
    pub fn over(self, range: [f64; 2]) -> Self {
        Self { range: Some(range), ..self }
    }
}

/// One pair of axes and what is drawn in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// Written above the axes, if not empty.
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
