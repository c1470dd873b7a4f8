//! Files of contact mechanics, read and written safely. No physics, no clock, no terminal.
//!
//! - [`Output`] claims a path; every writer here puts its bytes beside it, syncs them, and renames: an older file under
//!   that name is good until the new one is.
//! - [`Archive`] and [`Reader`] write and read HDF5 with named dimensions and units.
//! - [`vti::Image`] writes fields for ParaView; [`npy`] reads and writes arrays of NumPy.
//! - [`Topography`] reads height maps in all these formats and in the text of instruments.
//!
//! ```
//! use gfmd_files::{Archive, Dimension, Output, Provenance, Reader, Variable};
//!
//! # let folder = tempfile::tempdir().unwrap();
//! # let path = folder.path().join("contact.h5");
//! let output = Output::claim(&path)?;
//! let provenance = Provenance { command: "gfmd contact".into(), ..Provenance::default() };
//! let mut archive = Archive::create(&output, &provenance)?;
//! let load = Dimension::index("load", 2, "load step");
//! let area = Variable { dimensions: &[&load], units: "1", long_name: "contact area fraction" };
//! archive.write("/loads/area_fraction", &area, &[0.02, 0.1])?;
//! archive.finish()?;
//! assert_eq!(Reader::open(&path)?.values::<f64>("/loads/area_fraction")?, [0.02, 0.1]);
//! # Ok::<(), gfmd_files::FileError>(())
//! ```

mod archive;
mod error;
mod fields;
pub mod npy;
mod output;
mod topography;
pub mod vti;

pub use archive::{Archive, Attribute, Coordinates, Dimension, Provenance, Reader, SCHEMA_VERSION, Variable};
pub use error::FileError;
pub use fields::{axes, contiguous};
pub use output::{Output, folder, replace, sync_folder};
pub use topography::archived::{lengths as cell_lengths, split as split_dataset};
pub use topography::{Topography, TopographyError};
