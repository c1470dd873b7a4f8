//! Figures for print as SVG and PNG: charts with error bars and reference lines, and maps of fields. The input is
//! numbers and labels; this crate knows no physics.
//!
//! All figures have one style: Arimo 8 pt (bundled, so that no system font is needed, and as wide as Arial, so that SVG
//! and PNG agree), the colour-blind-safe colours of Okabe and Ito, ticks inside on all sides, true minus signs and
//! superscripts. Figures are as wide as journal columns. PNG files have 300 dots per inch, or more, so that each pixel
//! of a map has at least one dot. Equal input gives equal bytes.
//!
//! Labels may contain markup: `*kappa*` is italic, `a_r` and `10^{-3}` are sub- and superscripts, `\` makes the next
//! character literal.
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
mod panels;
mod stack;
mod symbol;
mod text;

#[cfg(test)]
mod tests;

pub use chart::{COLUMN, Chart, TWO_COLUMNS};
pub use error::PlotError;
pub use map::{Below, Colours, Map, Maps};
pub use panel::{Axis, Level, Mark, Panel, Point, Scale, Series, Side};
