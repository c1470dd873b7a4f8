//! Dimension scales of the HDF5 Dimension Scale Specification: four attributes, written without the high-level library.
//!
//! A scale has the attributes CLASS = "DIMENSION_SCALE", NAME, and REFERENCE_LIST (the variables that use it, and the
//! index of the dimension). A variable has the attribute DIMENSION_LIST (the scales of each dimension).

use hdf5::types::{FixedAscii, TypeDescriptor, VarLenArray};
use hdf5::{Dataset, Datatype, File, ObjectReference1};
use hdf5_sys::h5t::{H5T_str_t, H5Tset_strpad};

use super::Dimension;

/// Dimension scale in the file and the variables that use it.
#[derive(Debug)]
pub(super) struct Scale {
    path: String,
    dimension: Dimension,
    users: Vec<(String, usize)>,
}

/// Entry of REFERENCE_LIST.
#[derive(Clone, Copy, hdf5::H5Type)]
#[repr(C)]
struct User {
    dataset: ObjectReference1,
    dimension: i32,
}

impl Scale {
    pub(super) fn new(path: String, dimension: Dimension) -> Self {
        Self { path, dimension, users: Vec::new() }
    }

    pub(super) fn path(&self) -> &str {
        &self.path
    }

    pub(super) fn dimension(&self) -> &Dimension {
        &self.dimension
    }

    /// Records the scale as dimension `position` of the variable at `path`.
    pub(super) fn attach(&mut self, path: &str, position: usize) {
        self.users.push((path.to_owned(), position));
    }

    pub(super) fn write_references(&self, file: &File) -> Result<(), hdf5::Error> {
        let users = self
            .users
            .iter()
            .map(|(path, position)| Ok(User { dataset: file.reference(path)?, dimension: *position as i32 }))
            .collect::<Result<Vec<_>, hdf5::Error>>()?;
        if users.is_empty() {
            return Ok(());
        }
        let list = file.dataset(&self.path)?.new_attr::<User>().shape(users.len()).create("REFERENCE_LIST")?;
        list.write_raw(&users)
    }
}

/// Marks a dataset as a dimension scale.
pub(super) fn mark(dataset: &Dataset, name: &str) -> Result<(), hdf5::Error> {
    write_terminated(dataset, "CLASS", "DIMENSION_SCALE")?;
    write_terminated(dataset, "NAME", name)
}

/// Writes the scales of a variable, one per dimension.
pub(super) fn write_dimension_list(file: &File, dataset: &Dataset, scales: &[String]) -> Result<(), hdf5::Error> {
    if scales.is_empty() {
        return Ok(());
    }
    let list = scales
        .iter()
        .map(|path| Ok(VarLenArray::from_slice(&[file.reference::<ObjectReference1>(path)?])))
        .collect::<Result<Vec<_>, hdf5::Error>>()?;
    let attribute = dataset.new_attr::<VarLenArray<ObjectReference1>>().shape(list.len()).create("DIMENSION_LIST")?;
    attribute.write_raw(&list)
}

/// Writes a zero-terminated string attribute of fixed length. Readers of dimension scales accept no other string type,
/// and the `hdf5` crate does not provide it.
fn write_terminated(dataset: &Dataset, name: &str, text: &str) -> Result<(), hdf5::Error> {
    let kind = Datatype::from_descriptor(&TypeDescriptor::FixedAscii(text.len() + 1))?;
    let status = hdf5::sync::sync(|| {
        #[allow(unsafe_code, reason = "the `hdf5` crate does not set the padding of strings")]
        // SAFETY: `kind` owns a fresh, modifiable string type and outlives the call; `sync` holds the library's lock.
        unsafe {
            H5Tset_strpad(kind.id(), H5T_str_t::H5T_STR_NULLTERM)
        }
    });
    if status < 0 {
        return Err(hdf5::Error::query()?);
    }
    let text = FixedAscii::<256>::from_ascii(text).map_err(|error| error.to_string())?;
    dataset.new_attr_builder().empty_as(kind).create(name)?.write_scalar(&text)
}
