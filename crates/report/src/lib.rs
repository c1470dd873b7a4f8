//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! [`contact`], [`path`], [`slide`], [`punch`], [`body`], [`kappa`] and [`study`] build the [`Page`] of a file of this
//! kind from its numbers and fields alone. [`whole_page`] adds the sections common to all results and writes the page,
//! which needs no network. [`contact_law`] is the law of a contact for finite elements, as text. [`figures`] holds the
//! common parts of figures in files and pages, [`surface`] the figures and the page of a surface. The charts come from
//! `gfmd-plot`.
#![warn(missing_docs)]

pub mod body;
pub mod contact;
pub mod contact_law;
pub mod figures;
pub mod kappa;
mod legs;
mod page;
pub mod path;
pub mod punch;
pub mod slide;
pub mod strain;
pub mod study;
pub mod surface;
pub mod wear;

pub use page::{Page, check_replaceable, quoted, warnings, whole_page};
