//! Figures for print: charts with error bars and reference lines, maps of fields, as SVG and PNG. Numbers and words in,
//! no physics here.
//!
//! One look for all: Arimo 8 pt (bundled, with the widths of Arial, so no system font is needed and both files look the
//! same), the colour-blind-safe colours of Okabe and Ito, ticks inside on all sides, true minus signs and superscripts.
//! Sizes are those of journal columns; PNG files have 300 dots per inch. Equal input gives equal bytes.
//!
//! Words may contain markup: `*kappa*` is italic, `a_r`, `10^{-3}` are sub- and superscripts, `\` takes the next
//! character as it is.
//!
//! ```
//! use gfmd_plot::{Axis, Chart, Level, Panel, Point, Series};
//!
//! let points = vec![Point::with_error(0.25, 2.9, 0.05), Point::with_error(0.125, 2.5, 0.04)];
//! let panel = Panel {
//!     x: Axis::linear("*ε*_c"),
//!     y: Axis::linear("*κ*"),
//!     series: vec![Series::points("*H* = 0.8", 0, points)],
//!     levels: vec![Level::line(2.507, "Bush–Gibson–Thomas")],
//!     ..Panel::default()
//! };
//! let chart = Chart::new(vec![panel]);
//! assert!(chart.svg()?.contains("Bush–Gibson–Thomas"));
//! # Ok::<(), gfmd_plot::PlotError>(())
//! ```

mod axis;
mod chart;
mod colour;
mod drawing;
mod map;
mod text;

#[cfg(test)]
mod tests;

use std::io;
use std::path::{Path, PathBuf};

pub use map::{Below, Map};

/// Width of one journal column, in points.
pub const COLUMN: f64 = 252.0;

/// Width of two journal columns, in points.
pub const TWO_COLUMNS: f64 = 516.0;

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

/// Panels side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// From left to right.
    pub panels: Vec<Panel>,
    /// Whether all panels have one common ordinate, labelled at the left.
    pub share_y: bool,
    /// Width of the figure in points.
    pub width: f64,
    /// Height of the axes in points.
    pub height: f64,
}

impl Chart {
    /// One panel fills a column, several fill two; several share their ordinate.
    pub fn new(panels: Vec<Panel>) -> Self {
        let several = panels.len() > 1;
        Self { panels, share_y: several, width: if several { TWO_COLUMNS } else { COLUMN }, height: 150.0 }
    }

    /// The figure as SVG text.
    pub fn svg(&self) -> Result<String, PlotError> {
        Ok(chart::draw(self)?.svg())
    }

    /// The figure as PNG bytes.
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        chart::draw(self)?.png()
    }

    /// Writes `stem.svg` and `stem.png`.
    pub fn save(&self, stem: &Path) -> Result<[PathBuf; 2], PlotError> {
        chart::draw(self)?.save(stem)
    }
}

impl Map<'_> {
    /// The figure as SVG text, the field in it as an embedded PNG image.
    pub fn svg(&self) -> Result<String, PlotError> {
        Ok(map::draw(self)?.svg())
    }

    /// The figure as PNG bytes.
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        map::draw(self)?.png()
    }

    /// Writes `stem.svg` and `stem.png`.
    pub fn save(&self, stem: &Path) -> Result<[PathBuf; 2], PlotError> {
        map::draw(self)?.save(stem)
    }
}

/// Why there is no figure.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlotError {
    /// Nothing to draw.
    #[error("nothing to plot: {what}")]
    Empty {
        /// What is missing.
        what: &'static str,
    },
    /// A value that is not a number.
    #[error("cannot plot {found} in {place}; finite numbers are allowed")]
    NotFinite {
        /// What was found.
        found: f64,
        /// Where.
        place: String,
    },
    /// A value at or below zero on a logarithmic axis.
    #[error("cannot plot {found} in {place} on a logarithmic axis; numbers above zero are allowed")]
    NotPositive {
        /// What was found.
        found: f64,
        /// Where.
        place: String,
    },
    /// An axis from and to the same place, or backwards.
    #[error("an axis from {} to {} asked; the second end must be above the first", range[0], range[1])]
    BadRange {
        /// What was found.
        range: [f64; 2],
    },
    /// A field that does not fill its grid.
    #[error("{found} values for a map of {} x {}; at least 2 x 2 are needed, one value each", shape[0], shape[1])]
    Shape {
        /// Number of values.
        found: usize,
        /// Points along x and y.
        shape: [usize; 2],
    },
    /// The drawing could not be turned into an image.
    #[error("cannot render the figure: {reason}")]
    Render {
        /// In the words of the library.
        reason: String,
    },
    /// The file could not be written.
    #[error("cannot write {}: {source}", path.display())]
    Io {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}
