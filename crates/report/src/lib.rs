//! What is drawn and laid out of results: figures of a state, of areas and of sweeps, and the page of HTML about a file.
//!
//! [`contact`], [`path`], [`slide`], [`wear`], [`punch`], [`body`] and [`kappa`] make the [`Page`] about a file of this
//! kind, from its numbers and fields alone; [`whole_page`] adds what every result has and writes it, to be opened
//! without a network. [`figures`] has the parts of figures that results have in common, as files or in a page;
//! [`surface`] those of a surface, and its page. The charts themselves are those of `gfmd-plot`.
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
