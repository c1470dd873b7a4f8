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
mod error;
mod frame;
mod legend;
mod map;
mod panel;
mod symbol;
mod text;

#[cfg(test)]
mod tests;

pub use chart::{COLUMN, Chart, TWO_COLUMNS};
pub use error::PlotError;
pub use map::{Below, Map};
pub use panel::{Axis, Level, Mark, Panel, Point, Scale, Series};
