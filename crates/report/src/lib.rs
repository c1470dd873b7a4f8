//! Presentation of results: figures of a state, of areas and of sweeps, and the HTML page of a file.
//!
//! [`contact`], [`path`], [`slide`], [`wear`], [`punch`], [`body`] and [`kappa`] make the [`Page`] of a file of this
//! kind, from its numbers and fields alone; [`whole_page`] adds the sections of all results and writes the page, which
//! needs no network. [`figures`] has the common parts of figures, in files or in a page; [`surface`] the figures and
//! the page of a surface. The charts themselves are those of `gfmd-plot`.
#![warn(missing_docs)]

pub mod body;
pub mod contact;
pub mod figures;
pub mod kappa;
mod page;
pub mod path;
pub mod punch;
pub mod slide;
pub mod surface;
pub mod wear;

pub use page::{MARK, Page, quoted, warnings, whole_page};
