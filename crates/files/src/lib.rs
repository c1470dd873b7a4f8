//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! - [`Output`] claims a path. Every writer writes to a part file, syncs it, and renames it, so that an older file of
//!   that name is valid until the new one is complete.
//! - [`gfmd_topography`] reads height maps of instruments and programs; [`X3p`] writes them for other programs. Also
//!   from that crate:
//! - [`input`] opens regular files only, without waiting, and detects changes while they are read.
//! - [`Archive`] and [`Reader`] write and read HDF5 with named dimensions and units.
//! - [`Journal`] preserves the finished parts of long work if the process is killed; [`Checksum`] identifies files and
//!   arrays.
//! - [`vti::Image`] writes fields for ParaView, [`vtp::write`] a surface; [`npy`] reads and writes NumPy arrays.

mod archive;
mod attribute;
mod error;
mod fields;
mod journal;
pub mod npy;
mod output;
pub mod vti;
mod vtk;
pub mod vtp;
mod warning;
mod x3p;

pub use archive::{
    Archive, Coordinates, Dimension, Draft, Memory, Provenance, Reader, SCHEMA_VERSION, Value, Variable, rows_of_chunk,
};
pub use attribute::Attribute;
pub use error::FileError;
pub use fields::axes;
pub use gfmd_field::contiguous;
pub use gfmd_topography::unit::{convert_lengths, is_length as is_length_unit};
pub use gfmd_topography::{
    CONSISTENT_UNITS, Checksum, Input, ListedChannel, Listing, Number, Reading, Topography, TopographyError,
    cell_lengths, input, legible, split_dataset,
};
pub use journal::{Journal, JournalError};
pub use output::{Output, folder, is_one_file, replace, sync_folder, target};
pub use vtk::PointArray;
pub use warning::{Warning, Warnings};
pub use x3p::X3p;
