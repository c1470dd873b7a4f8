//! Reading of values and attributes.

use std::any::Any;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use gfmd_topography::stored::{Decode, Hdf5, Number, text};
use hdf5_reader::{Datatype, StringSize};

use super::{FileError, SCHEMA_VERSION, content};
use crate::Input;
use crate::attribute::Attribute;

/// Name of this program in its results.
const PROGRAM: &str = "gfmd";

/// HDF5 file of any program, opened for reading. It is decoded in Rust: a damaged file gives an error.
pub struct Reader {
    path: PathBuf,
    input: Input,
    file: Hdf5,
    memory: Mutex<Memory>,
}

/// Cached content of a file.
#[derive(Default)]
struct Memory {
    /// Lengths of the dimensions of a group, by group name.
    lengths: BTreeMap<String, Vec<usize>>,
    /// Entries along the first dimension of a variable compressed together: variable, first entry, and values.
    block: Option<(String, usize, Box<dyn Any + Send>)>,
    /// Values kept when the checksum was computed.
    kept: content::Values,
}

impl Reader {
    /// Opens a regular file.
    ///
    /// # Errors
    /// A file that cannot be opened, is not a regular file, is not HDF5, or is a result of this program with another
    /// layout.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, FileError> {
        let path = path.as_ref().to_path_buf();
        let input = match Input::settled(&path) {
            Ok(input) => input,
            Err(source) => return Err(FileError::Io { action: "open", path, source }),
        };
        let file = match Hdf5::open(&input) {
            Ok(file) => file,
            Err(reason) => return Err(FileError::Open { reason, path }),
        };
        let is_ours = file.text("/", "program").is_ok_and(|program| program == PROGRAM);
        match file.number("/", "schema_version") {
            Ok(found) if is_ours && found != f64::from(SCHEMA_VERSION) => Err(FileError::Layout { path, found }),
            _ => Ok(Self { path, input, file, memory: Mutex::default() }),
        }
    }

    /// Returns true if the content of the file matches its checksum, or `None` if the file has no checksum.
    ///
    /// # Errors
    /// A file that cannot be read to its end.
    pub fn is_intact(&self) -> Result<Option<bool>, FileError> {
        self.is_intact_until(&|| false)
    }

    /// Compares like [`is_intact`](Self::is_intact) until `stop` returns true, which counts as a mismatch.
    ///
    /// # Errors
    /// A file that cannot be read to its end.
    pub fn is_intact_until(&self, stop: &(dyn Fn() -> bool + Sync)) -> Result<Option<bool>, FileError> {
        let Ok(stated) = self.text("/", content::NAME) else { return Ok(None) };
        self.compare(&stated, stop, &|_| false).map(Some)
    }

    /// Compares like [`is_intact`](Self::is_intact) and keeps the real numbers of the variables whose path is `wanted`,
    /// which [`values`](Self::values) and [`take`](Self::take) then return without reading them again.
    ///
    /// # Errors
    /// A file that cannot be read to its end.
    pub fn is_intact_keeping(&self, wanted: &dyn Fn(&str) -> bool) -> Result<Option<bool>, FileError> {
        let Ok(stated) = self.text("/", content::NAME) else { return Ok(None) };
        self.compare(&stated, &|| false, wanted).map(Some)
    }

    fn compare(
        &self,
        stated: &str,
        stop: &(dyn Fn() -> bool + Sync),
        wanted: &dyn Fn(&str) -> bool,
    ) -> Result<bool, FileError> {
        for path in self.variables() {
            self.check(&path)?;
        }
        let Some((found, kept)) = self.content(stop, wanted)? else { return Ok(false) };
        self.memory().kept = kept;
        Ok(found == stated)
    }

    /// Computes the checksum of the content: names, shapes and values of all variables, and all attributes that are
    /// single numbers or texts, except the checksum itself.
    ///
    /// # Errors
    /// A file that cannot be read to its end.
    pub fn content_sha256(&self) -> Result<String, FileError> {
        Ok(self.content(&|| false, &|_| false)?.unwrap_or_default().0)
    }

    fn content(
        &self,
        stop: &(dyn Fn() -> bool + Sync),
        wanted: &dyn Fn(&str) -> bool,
    ) -> Result<Option<(String, content::Values)>, FileError> {
        content::checksum(&self.file, stop, wanted).map_err(|reason| self.failed("(all)", reason))
    }

    /// Returns the variable that needs most memory when read, and its bytes, or `None` for a file without variables.
    pub fn largest(&self) -> Option<(String, u64)> {
        let bytes = |path: String| {
            let shape = self.file.shape(&path).ok()?;
            // Each number is stored twice: as in the file and as used.
            let bytes = shape.iter().fold(16_u64, |product, &length| product.saturating_mul(length as u64));
            Some((path, bytes))
        };
        self.variables().into_iter().filter_map(bytes).max_by_key(|(_, bytes)| *bytes)
    }

    /// Returns the paths of all variables, down to the depth of results.
    fn variables(&self) -> Vec<String> {
        let (mut groups, mut found) = (vec![(String::new(), 0)], Vec::new());
        for _ in 0..MOST_GROUPS {
            let Some((group, depth)) = groups.pop() else { break };
            for name in self.names(if group.is_empty() { "/" } else { &group }) {
                let path = format!("{group}/{name}");
                match self.contains(&path) {
                    true => found.push(path),
                    false if depth < DEEPEST => groups.push((path, depth + 1)),
                    false => {}
                }
            }
        }
        found
    }

    /// Returns the SHA-256 of the open file, even if another file has taken its name.
    ///
    /// # Errors
    /// A file that cannot be read, or was changed in place since it was opened.
    pub fn checksum(&self) -> Result<String, FileError> {
        let sum = self.input.checksum();
        sum.map_err(|source| FileError::Io { action: "read", path: self.path.clone(), source })
    }

    /// Reads the bytes of the open file, even if another file has taken its name.
    ///
    /// # Errors
    /// A file that cannot be read, or was changed in place since it was opened.
    pub fn bytes(&self) -> Result<Vec<u8>, FileError> {
        let bytes = self.input.bytes(u64::MAX);
        bytes.map_err(|source| FileError::Io { action: "read", path: self.path.clone(), source })
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the names in a group, sorted; empty if there is no such group.
    pub fn names(&self, group: &str) -> Vec<String> {
        self.file.names(group).unwrap_or_default()
    }

    /// Returns true if there is a variable at `path`.
    pub fn contains(&self, path: &str) -> bool {
        self.file.contains(path)
    }

    /// Returns the lengths of the dimensions of a variable.
    pub fn shape(&self, path: &str) -> Result<Vec<usize>, FileError> {
        self.check(path)?;
        self.file.shape(path).map_err(|reason| self.failed(path, reason))
    }

    /// Reads all values of a variable, row-major. Numbers of another type are converted to `T`.
    pub fn values<T: Number + 'static>(&self, path: &str) -> Result<Vec<T>, FileError> {
        self.check(path)?;
        if let Some(kept) = self.memory().kept.get(path).and_then(|kept| (kept as &dyn Any).downcast_ref::<Vec<T>>()) {
            return Ok(kept.clone());
        }
        self.file.values(path).map_err(|reason| self.failed(path, reason))
    }

    /// Returns all values of a variable, row-major, and no longer keeps them.
    ///
    /// # Errors
    /// A variable that cannot be read.
    pub fn take(&self, path: &str) -> Result<Vec<f64>, FileError> {
        let kept = self.memory().kept.remove(path);
        kept.map_or_else(|| self.values(path), Ok)
    }

    /// Reads all values of a variable of any program, scaled and with NaN for missing values by the NetCDF conventions.
    pub fn physical(&self, path: &str) -> Result<Vec<f64>, FileError> {
        self.check(path)?;
        self.file.physical(path).map_err(|reason| self.failed(path, reason))
    }

    /// Reads entry `index` along the first dimension of a variable.
    pub fn slab<T: Number + 'static>(&self, path: &str, index: usize) -> Result<Vec<T>, FileError> {
        let shape = self.shape(path)?;
        let Some(&length) = shape.first().filter(|&&length| index < length) else {
            return Err(FileError::Slab { variable: path.into(), index, found: 0, shape });
        };
        let failed = |reason| self.failed(path, reason);
        let together = self.file.chunk(path).map_err(failed)?.map_or(1, |chunk| chunk[0]);
        let start = index - index % together;
        if together == 1 {
            return self.file.part(path, &[[index, index + 1]]).map_err(failed);
        }
        let mut memory = self.memory();
        let known = |(of, first, _): &&(String, usize, Box<dyn Any + Send>)| of == path && *first == start;
        let values = memory.block.as_ref().filter(known).and_then(|(.., values)| values.downcast_ref::<Vec<T>>());
        let entry = |values: &[T]| {
            let size = shape.iter().skip(1).product::<usize>();
            values[(index - start) * size..][..size].to_vec()
        };
        if let Some(values) = values {
            return Ok(entry(values));
        }
        let values: Vec<T> = self.file.part(path, &[[start, length.min(start + together)]]).map_err(failed)?;
        let found = entry(&values);
        memory.block = Some((path.to_owned(), start, Box::new(values)));
        Ok(found)
    }

    /// Reads all values of a variable of strings.
    pub fn texts(&self, path: &str) -> Result<Vec<String>, FileError> {
        self.check(path)?;
        self.file.texts(path).map_err(|reason| self.failed(path, reason))
    }

    /// Returns the attributes of the group or variable at `path` that are single numbers or texts, sorted by name.
    /// Attributes that mark and link dimensions are left out.
    ///
    /// # Errors
    /// A path without an object, or attributes that cannot be read.
    pub fn attributes(&self, path: &str) -> Result<Vec<(String, Attribute)>, FileError> {
        self.file.attributes(path).and_then(values).map_err(|reason| self.failed(&attribute(path, "*"), reason))
    }

    /// Returns true if the variable at `path` holds the coordinates of a dimension.
    pub fn is_coordinate(&self, path: &str) -> bool {
        self.contains(path) && self.text(path, "CLASS").is_ok_and(|class| class == "DIMENSION_SCALE")
    }

    /// Reads a text attribute of the group or variable at `path`; `/` is the root.
    pub fn text(&self, path: &str, name: &str) -> Result<String, FileError> {
        self.file.text(path, name).map_err(|reason| self.failed(&attribute(path, name), reason))
    }

    /// Reads a numerical attribute of the group or variable at `path`.
    pub fn number(&self, path: &str, name: &str) -> Result<f64, FileError> {
        self.file.number(path, name).map_err(|reason| self.failed(&attribute(path, name), reason))
    }

    /// Returns an error for a missing variable, with the existing names, or for invalid chunks or an invalid shape.
    fn check(&self, path: &str) -> Result<(), FileError> {
        let group = path.rsplit_once('/').map_or("/", |(group, _)| if group.is_empty() { "/" } else { group });
        if !self.contains(path) {
            let present = self.names(group);
            return Err(FileError::Missing { path: self.path.clone(), variable: path.into(), present });
        }
        content::check_chunk(&self.file, path).map_err(|reason| self.failed(path, reason))?;
        let shape = self.file.shape(path).map_err(|reason| self.failed(path, reason))?;
        // Files of other programs may have dimensions elsewhere.
        if shape.is_empty() || self.file.number("/", "schema_version").is_err() || self.is_coordinate(path) {
            return Ok(());
        }
        let lengths = self.lengths(group);
        if shape.iter().all(|length| lengths.contains(length)) {
            return Ok(());
        }
        let reason = format!("its shape is {shape:?}; the dimensions of its group have the lengths {lengths:?}");
        Err(self.failed(path, reason))
    }

    /// Returns the lengths of the dimensions of a group.
    fn lengths(&self, group: &str) -> Vec<usize> {
        if let Some(known) = self.memory().lengths.get(group) {
            return known.clone();
        }
        let paths = self.names(group).into_iter().map(|name| format!("{}/{name}", group.trim_end_matches('/')));
        let coordinates = paths.filter(|path| self.is_coordinate(path));
        let mut lengths: Vec<usize> = coordinates.filter_map(|path| self.file.shape(&path).ok()).flatten().collect();
        lengths.sort_unstable();
        lengths.dedup();
        self.memory().lengths.insert(group.to_owned(), lengths.clone());
        lengths
    }

    fn memory(&self) -> MutexGuard<'_, Memory> {
        self.memory.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn failed(&self, variable: &str, reason: String) -> FileError {
        FileError::Read { path: self.path.clone(), variable: variable.into(), reason }
    }
}

/// Maximum depth and number of groups searched for variables: a group may contain itself.
const DEEPEST: usize = 4;
const MOST_GROUPS: usize = 10_000;

impl std::fmt::Debug for Reader {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.debug_struct("Reader").field("path", &self.path).finish_non_exhaustive()
    }
}

fn attribute(path: &str, name: &str) -> String {
    format!("{}@{name}", path.trim_end_matches('/'))
}

/// Returns the attributes that are single numbers, or texts of any length, by name.
fn values(all: Vec<hdf5_reader::Attribute>) -> Result<Vec<(String, Attribute)>, String> {
    let mut found = Vec::new();
    for one in all.into_iter().filter(|one| one.shape.is_empty()) {
        let value = match &one.datatype {
            kind @ Datatype::FloatingPoint { .. } => f64::decode(&one.raw_data, kind).map(Into::into),
            kind @ Datatype::FixedPoint { signed: true, .. } => i64::decode(&one.raw_data, kind).map(Into::into),
            kind @ Datatype::FixedPoint { .. } => u64::decode(&one.raw_data, kind).map(Into::into),
            // Texts of fixed length mark dimension scales.
            Datatype::String { size: StringSize::Fixed(_), .. } => continue,
            _ => one.read_string().map(Into::into),
        };
        found.push((one.name.clone(), value.map_err(text)?));
    }
    found.sort_by(|(one, _), (other, _)| one.cmp(other));
    Ok(found)
}
