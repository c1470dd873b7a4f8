//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! All figures have one style: Arimo 8 pt (bundled, so that no system font is needed, and as wide as Arial, so that SVG
//! and PNG agree), the colour-blind-safe colours of Okabe and Ito, ticks inside on all sides, true minus signs and
//! superscripts. PNG files have 300 dots per inch, or more, so that each pixel of a map has at least one dot. Equal
//! input gives equal bytes.
//!
//! Labels may contain markup: `*kappa*` is italic, `a_r` and `10^{-3}` are sub- and superscripts, `\` makes the next
//! character literal.

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
