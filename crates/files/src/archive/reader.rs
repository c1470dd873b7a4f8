//! Reading of values and attributes.

use std::path::{Path, PathBuf};

use hdf5::types::{FixedAscii, FixedUnicode, TypeDescriptor, VarLenAscii, VarLenUnicode};
use hdf5::{Container, Dataset, File, H5Type};

use super::{FileError, content};
use crate::error::reason;

/// An HDF5 file of any program, opened for reading.
#[derive(Debug)]
pub struct Reader {
    path: PathBuf,
    file: File,
}

impl Reader {
    /// Opens a file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FileError> {
        let path = path.as_ref().to_path_buf();
        if let Err(source) = std::fs::File::open(&path) {
            return Err(FileError::Io { action: "open", path, source });
        }
        match File::open(&path) {
            Ok(file) => Ok(Self { path, file }),
            Err(error) => Err(FileError::Open { reason: reason(&error), path }),
        }
    }

    /// True if the content of the file is that which was written; `None` if the file has no checksum.
    ///
    /// # Errors
    /// A file that cannot be read to its end.
    pub fn is_intact(&self) -> Result<Option<bool>, FileError> {
        let Ok(stated) = self.text("/", content::NAME) else { return Ok(None) };
        let found = content::checksum(&self.file).map_err(|error| FileError::read(&self.path, "(all)", &error))?;
        Ok(Some(found == stated))
    }

    /// The path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The names in a group, sorted; empty if there is no such group.
    pub fn names(&self, group: &str) -> Vec<String> {
        let mut names = self.file.group(group).and_then(|group| group.member_names()).unwrap_or_default();
        names.sort();
        names
    }

    /// True if there is a variable at `path`.
    pub fn contains(&self, path: &str) -> bool {
        self.file.dataset(path).is_ok()
    }

    /// The lengths of a variable's dimensions.
    pub fn shape(&self, path: &str) -> Result<Vec<usize>, FileError> {
        Ok(self.dataset(path)?.shape())
    }

    /// All values of a variable, row-major; the library converts numbers of another type to `T`.
    pub fn values<T: H5Type>(&self, path: &str) -> Result<Vec<T>, FileError> {
        let dataset = self.dataset(path)?;
        let values = check_stored(&dataset).and_then(|()| dataset.read_raw());
        values.map_err(|error| FileError::read(&self.path, path, &error))
    }

    /// Entry `index` along the first dimension of a variable.
    pub fn slab<T: H5Type>(&self, path: &str, index: usize) -> Result<Vec<T>, FileError> {
        let dataset = self.dataset(path)?;
        let shape = dataset.shape();
        if shape.first().is_none_or(|&length| index >= length) {
            return Err(FileError::Slab { variable: path.into(), index, found: 0, shape });
        }
        let mut selection = vec![hdf5::SliceOrIndex::from(index..index + 1)];
        selection.extend(shape[1..].iter().map(|_| hdf5::SliceOrIndex::from(..)));
        let slab = dataset.read_slice::<T, _, ndarray::IxDyn>(hdf5::Hyperslab::from(selection));
        slab.map(|values| values.into_iter().collect()).map_err(|error| FileError::read(&self.path, path, &error))
    }

    /// All values of a variable of strings.
    pub fn texts(&self, path: &str) -> Result<Vec<String>, FileError> {
        let dataset = self.dataset(path)?;
        texts(&dataset).map_err(|error| FileError::read(&self.path, path, &error))
    }

    /// A text attribute of the group or variable at `path`; `/` is the root.
    pub fn text(&self, path: &str, name: &str) -> Result<String, FileError> {
        let whole = format!("{}@{name}", path.trim_end_matches('/'));
        let found = self.attribute(path, name).and_then(|attribute| texts(&attribute));
        let texts = found.map_err(|error| FileError::read(&self.path, &whole, &error))?;
        Ok(texts.into_iter().next().unwrap_or_default())
    }

    /// A numerical attribute of the group or variable at `path`.
    pub fn number(&self, path: &str, name: &str) -> Result<f64, FileError> {
        let whole = format!("{}@{name}", path.trim_end_matches('/'));
        // Other programs store a number as an array of one.
        let found = self.attribute(path, name).and_then(|attribute| match attribute.read_raw()?[..] {
            [number] => Ok(number),
            ref numbers => Err(format!("the attribute has {} numbers; it must have one", numbers.len()).into()),
        });
        found.map_err(|error| FileError::read(&self.path, &whole, &error))
    }

    fn attribute(&self, path: &str, name: &str) -> Result<hdf5::Attribute, hdf5::Error> {
        match self.file.dataset(path) {
            Ok(dataset) => dataset.attr(name),
            Err(_) => self.file.group(path)?.attr(name),
        }
    }

    fn dataset(&self, path: &str) -> Result<Dataset, FileError> {
        self.file.dataset(path).map_err(|_| {
            let group = path.rsplit_once('/').map_or("/", |(group, _)| if group.is_empty() { "/" } else { group });
            FileError::Missing { path: self.path.clone(), variable: path.into(), present: self.names(group) }
        })
    }
}

/// Returns an error if a large dataset has more values than the bytes stored for it can hold: nothing is to be allocated for
/// what only a shape declares. Deflate makes at most 1032 bytes from one.
fn check_stored(dataset: &Dataset) -> Result<(), hdf5::Error> {
    const LARGEST_RATIO: u64 = 1032;
    let needed = (dataset.size() as u64).saturating_mul(dataset.dtype()?.size() as u64);
    let stored = dataset.storage_size();
    if needed > 1 << 20 && needed > stored.saturating_mul(LARGEST_RATIO) {
        return Err(
            format!("the shape is {:?}, {needed} bytes; the file has {stored} bytes for it", dataset.shape()).into()
        );
    }
    Ok(())
}

/// Reads strings of fixed or variable length.
pub(super) fn texts(container: &Container) -> Result<Vec<String>, hdf5::Error> {
    fn all<T: H5Type + ToString>(container: &Container) -> Result<Vec<String>, hdf5::Error> {
        Ok(container.read_raw::<T>()?.iter().map(ToString::to_string).collect())
    }
    match container.dtype()?.to_descriptor()? {
        TypeDescriptor::VarLenAscii => all::<VarLenAscii>(container),
        TypeDescriptor::FixedAscii(_) => all::<FixedAscii<4096>>(container),
        TypeDescriptor::FixedUnicode(_) => all::<FixedUnicode<4096>>(container),
        _ => all::<VarLenUnicode>(container),
    }
}
