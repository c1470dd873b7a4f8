//! Result files: HDF5 with named dimensions and units, written to a part file and renamed when complete.
//!
//! - [`Output::claim`] reserves a path for this process; a second process is refused. The claim is an operating system
//!   lock on `NAME.lock`, so that it always ends with the process.
//! - [`Archive::create`] writes `NAME.part`; [`Archive::finish`] syncs it to the disk and renames it to the target.
//!   Until then an older file of that name is unchanged; an unfinished archive removes its part file when dropped.
//! - Every variable has named dimensions, `units` and `long_name`. Dimension scales are in the group of the variables
//!   that use them, so that each group can be opened as a dataset with its coordinates: `xarray.open_dataset(file,
//!   group="/fields", engine="h5netcdf")`, `netCDF4.Dataset(file)["fields"]`, h5py, `h5dump`.
//! - An archive of [`Output::memory`] puts its variables into a [`Memory`] and writes no file; its [`Draft`] writes the
//!   file later.
//! - The root attribute `content_sha256` is a checksum of all other content; [`Reader::is_intact`] recomputes it.
//! - [`Reader`] reads values, for resuming and for input. It is written in Rust, and the HDF5 library only writes,
//!   since a damaged file can crash the library.

mod chunks;
mod content;
mod memory;
mod reader;
mod scale;
mod variable;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;

use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, File, Group, H5Type, Location};

use crate::attribute::Attribute;
use crate::{FileError, Input, Output, Warnings};
use gfmd_topography::stored::Hdf5;
use scale::Scale;

pub use memory::{Draft, Memory, Value};
pub use reader::Reader;
pub use variable::{Coordinates, Dimension, Provenance, Variable};

/// Version of the file layout, increased when a name or its meaning changes.
pub const SCHEMA_VERSION: u32 = 2;

/// Bytes per chunk before compression: large enough for deflate and few seeks, small enough for partial reads.
const CHUNK_BYTES: usize = 1 << 21;

/// Size in bytes below which arrays are stored uncompressed in one piece.
const SMALL_BYTES: usize = 1 << 13;

/// Deflate level. For heights and pressures of 2048 x 2048 points, levels 1 to 6 differ by 1 % in size, levels 2 and 6
/// by 25 to 80 % in time.
const DEFLATE: u8 = 2;

/// HDF5 file being written. Only [`Archive::finish`] replaces the target.
#[derive(Debug)]
pub struct Archive<'a> {
    output: &'a Output,
    /// `None` in memory, and while closing.
    file: Option<File>,
    /// Dimension scales by group and name.
    scales: BTreeMap<(String, String), Scale>,
    warnings: Warnings,
}

impl<'a> Archive<'a> {
    /// Creates `NAME.part` beside the claimed target. A part file left by an earlier process is overwritten.
    pub fn create(output: &'a Output, provenance: &Provenance) -> Result<Self, FileError> {
        let (scales, warnings) = (BTreeMap::new(), provenance.warnings.clone());
        if let Some(memory) = output.in_memory() {
            memory.begin(provenance);
            return Ok(Self { output, file: None, scales, warnings });
        }
        let part = output.part();
        let file = File::create(&part).map_err(|error| FileError::create(&part, &error))?;
        let mut archive = Self { output, file: Some(file), scales, warnings };
        let texts = [
            ("program", &provenance.program),
            ("version", &provenance.version),
            ("git_commit", &provenance.git_commit),
            ("command", &provenance.command),
            ("created", &provenance.created),
            ("config", &provenance.config),
            ("machine", &provenance.machine),
        ];
        archive.attribute("/", "schema_version", i64::from(SCHEMA_VERSION))?;
        for (name, text) in texts {
            archive.attribute("/", name, text.as_str())?;
        }
        archive.attribute("/", "threads", provenance.threads as i64)?;
        Ok(archive)
    }

    /// Writes a whole variable, row-major. Booleans are written as `u8` with the units `1`.
    pub fn write<T: Value>(&mut self, path: &str, variable: &Variable, values: &[T]) -> Result<(), FileError> {
        self.check_length(path, variable, values.len())?;
        if let Some(memory) = self.output.in_memory() {
            return memory.put(path, variable, values);
        }
        let dataset = self.new_dataset::<T>(path, variable, None)?;
        if !self.output.has_values() {
            return Ok(());
        }
        let shape = variable.shape();
        let written = match shape.len() {
            0 => dataset.write_scalar(&values[0]),
            axes => chunks::write(&dataset, &vec![0; axes], &shape, values),
        };
        self.flushed(path, &dataset, written)
    }

    /// Writes a variable of strings.
    pub fn write_text<S: AsRef<str>>(
        &mut self,
        path: &str,
        variable: &Variable,
        values: &[S],
    ) -> Result<(), FileError> {
        let texts = values.iter().map(|text| text_of(path, text.as_ref())).collect::<Result<Vec<_>, _>>()?;
        self.check_length(path, variable, texts.len())?;
        if let Some(memory) = self.output.in_memory() {
            memory.put_text(path, variable, values);
            return Ok(());
        }
        let dataset = self.new_dataset::<VarLenUnicode>(path, variable, None)?;
        if !self.output.has_values() {
            return Ok(());
        }
        let written =
            if variable.dimensions.is_empty() { dataset.write_scalar(&texts[0]) } else { dataset.write_raw(&texts) };
        self.flushed(path, &dataset, written)
    }

    /// Defines a variable whose entries along the first dimension are written one by one with [`Archive::write_slab`].
    /// Entries that are not written are NaN.
    pub fn define(&mut self, path: &str, variable: &Variable) -> Result<(), FileError> {
        if let Some(memory) = self.output.in_memory() {
            return memory.define(path, variable, false);
        }
        self.new_dataset::<f64>(path, variable, Some(f64::NAN)).map(drop)
    }

    /// Writes entry `index` along the first dimension of a variable defined with [`Archive::define`].
    pub fn write_slab(&mut self, path: &str, index: usize, values: &[f64]) -> Result<(), FileError> {
        let (dataset, shape) = self.defined(path)?;
        let expected: usize = shape.iter().skip(1).product();
        if shape.is_empty() || index >= shape[0] || values.len() != expected {
            return Err(FileError::Slab { variable: path.into(), index, found: values.len(), shape });
        }
        let Some(dataset) = dataset else { return self.fill(path, index * expected, values) };
        if !self.output.has_values() {
            return Ok(());
        }
        let (mut first, mut lengths) = (vec![0; shape.len()], shape);
        (first[0], lengths[0]) = (index, 1);
        let written = chunks::write(&dataset, &first, &lengths, values);
        self.flushed(path, &dataset, written)
    }

    /// Defines a two-dimensional variable; [`Archive::write_rows`] must then write all its rows.
    pub fn define_rows(&mut self, path: &str, variable: &Variable) -> Result<(), FileError> {
        if let Some(memory) = self.output.in_memory() {
            return memory.define(path, variable, true);
        }
        self.new_dataset::<f64>(path, variable, None).map(drop)
    }

    /// Writes whole rows, starting at row `first`, of a variable defined with [`Archive::define_rows`], or of entry
    /// `index` of a variable of more dimensions defined with [`Archive::define`]; entries are counted along all
    /// dimensions but the last two, row-major. If blocks begin and end at multiples of [`rows_of_chunk`], the bytes are
    /// the same as for a whole field.
    pub fn write_rows(
        &mut self,
        path: &str,
        index: Option<usize>,
        first: usize,
        values: &[f64],
    ) -> Result<(), FileError> {
        let (dataset, shape) = self.defined(path)?;
        let [rows, columns] = match (&shape[..], index) {
            (&[rows, columns], None) => [rows, columns],
            (&[first, ref others @ .., rows, columns], Some(index))
                if index < first * others.iter().product::<usize>() =>
            {
                [rows, columns]
            }
            _ => [0, 0],
        };
        let count = values.len() / columns.max(1);
        if columns == 0 || count * columns != values.len() || first + count > rows {
            let index = index.unwrap_or(first);
            return Err(FileError::Slab { variable: path.into(), index, found: values.len(), shape });
        }
        let Some(dataset) = dataset else {
            return self.fill(path, (index.unwrap_or(0) * rows + first) * columns, values);
        };
        if !self.output.has_values() {
            return Ok(());
        }
        let before = &shape[..shape.len() - 2];
        let mut entry = vec![0; before.len()];
        before.iter().enumerate().rev().fold(index.unwrap_or(0), |rest, (axis, length)| {
            entry[axis] = rest % length;
            rest / length
        });
        let lengths: Vec<usize> = before.iter().map(|_| 1).chain([count, columns]).collect();
        let first: Vec<usize> = entry.into_iter().chain([first, 0]).collect();
        let written = chunks::write(&dataset, &first, &lengths, values);
        self.flushed(path, &dataset, written)
    }

    /// Writes an attribute of the group or variable at `path`. A missing group is created.
    pub fn attribute(&mut self, path: &str, name: &str, value: impl Into<Attribute>) -> Result<(), FileError> {
        if let Some(memory) = self.output.in_memory() {
            memory.attribute(path, name, value.into());
            return Ok(());
        }
        let file = self.file()?;
        let whole = format!("{}@{name}", path.trim_end_matches('/'));
        let at: Location = match file.dataset(path) {
            Ok(dataset) => (**dataset).clone(),
            Err(_) => (*self.group(path)?).clone(),
        };
        let written = match value.into() {
            Attribute::Text(text) => write_attribute(&at, name, &text_of(&whole, &text)?),
            Attribute::Real(number) => write_attribute(&at, name, &number),
            Attribute::Integer(number) => write_attribute(&at, name, &number),
            Attribute::Natural(number) => write_attribute(&at, name, &number),
        };
        written.map_err(|error| self.failed(&whole, &error))
    }

    /// Completes the file, syncs it to the disk, and renames it to the target. Returns an empty path if in memory.
    pub fn finish(mut self) -> Result<PathBuf, FileError> {
        if let Some(memory) = self.output.in_memory() {
            memory.finish();
            return Ok(PathBuf::new());
        }
        let part = self.output.part();
        self.attribute("/", "warnings", self.warnings.lines())?;
        for scale in self.scales.values() {
            scale.write_references(self.file()?).map_err(|error| FileError::write(&part, scale.path(), &error))?;
        }
        self.file()?.flush().map_err(|error| self.failed("(checksum)", &error))?;
        if self.output.has_values() {
            let input = Input::open(&part).map_err(|error| error.to_string());
            let file = input.and_then(|input| Hdf5::open(&input));
            let sum = file.and_then(|file| content::checksum(&file, &|| false, &|_| false));
            let unreadable = |reason| FileError::Write { path: part.clone(), variable: "(checksum)".into(), reason };
            self.attribute("/", content::NAME, sum.map_err(unreadable)?.unwrap_or_default().0)?;
        }
        if let Some(file) = self.file.take() {
            let closed = file.flush().and_then(|()| file.close());
            if let Err(error) = closed {
                let error = FileError::write(&part, "(end of file)", &error);
                let _ = fs::remove_file(&part);
                return Err(error);
            }
        }
        self.output.publish()?;
        Ok(self.output.path().to_path_buf())
    }

    fn file(&self) -> Result<&File, FileError> {
        self.file.as_ref().ok_or_else(|| FileError::Closed { path: self.output.path().into() })
    }

    /// Returns the variable at `path` (`None` if in memory) and its shape.
    fn defined(&self, path: &str) -> Result<(Option<Dataset>, Vec<usize>), FileError> {
        if let Some(memory) = self.output.in_memory() {
            return Ok((None, memory.shape(path)));
        }
        let dataset = self.file()?.dataset(path).map_err(|error| self.failed(path, &error))?;
        let shape = dataset.shape();
        Ok((Some(dataset), shape))
    }

    /// Writes numbers to a variable in memory, starting at index `start`.
    fn fill(&self, path: &str, start: usize, values: &[f64]) -> Result<(), FileError> {
        let memory = self.output.in_memory();
        let shape = || memory.map_or_else(Vec::new, |memory| memory.shape(path));
        let slab = || FileError::Slab { variable: path.into(), index: start, found: values.len(), shape: shape() };
        memory.and_then(|memory| memory.write(path, start, values)).ok_or_else(slab)
    }

    /// Flushes written data to the operating system.
    fn flushed(&self, path: &str, dataset: &Dataset, written: Result<(), hdf5::Error>) -> Result<(), FileError> {
        written.and_then(|()| dataset.flush()).map_err(|error| self.failed(path, &error))
    }

    fn failed(&self, variable: &str, error: &hdf5::Error) -> FileError {
        FileError::write(&self.output.part(), variable, error)
    }

    fn check_length(&self, path: &str, variable: &Variable, found: usize) -> Result<(), FileError> {
        let shape = variable.shape();
        if shape.iter().product::<usize>() == found {
            return Ok(());
        }
        Err(FileError::Length { variable: path.into(), found, shape })
    }

    /// Returns the group at `path`, creating it and its parents if necessary.
    fn group(&self, path: &str) -> Result<Group, FileError> {
        let mut group = self.file()?.as_group().map_err(|error| self.failed(path, &error))?;
        for name in path.split('/').filter(|name| !name.is_empty()) {
            let next = if group.link_exists(name) { group.group(name) } else { group.create_group(name) };
            group = next.map_err(|error| self.failed(path, &error))?;
        }
        Ok(group)
    }

    fn new_dataset<T: H5Type>(
        &mut self,
        path: &str,
        variable: &Variable,
        fill: Option<f64>,
    ) -> Result<Dataset, FileError> {
        let (parent, name) = path.rsplit_once('/').unwrap_or(("", path));
        let group = self.group(parent)?;
        for dimension in variable.dimensions {
            self.ensure_scale(&group, parent, dimension)?;
        }
        let dataset = create_dataset::<T>(&group, name, &variable.shape(), fill)
            .and_then(|dataset| describe(&dataset, variable.units, variable.long_name).map(|()| dataset))
            .map_err(|error| self.failed(path, &error))?;
        let mut lists = Vec::with_capacity(variable.dimensions.len());
        for (position, dimension) in variable.dimensions.iter().enumerate() {
            if let Some(scale) = self.scales.get_mut(&(parent.to_owned(), dimension.name.clone())) {
                scale.attach(path, position);
                lists.push(scale.path().to_owned());
            }
        }
        scale::write_dimension_list(self.file()?, &dataset, &lists).map_err(|error| self.failed(path, &error))?;
        Ok(dataset)
    }

    /// Writes the scale of a dimension in a group at its first use.
    fn ensure_scale(&mut self, group: &Group, parent: &str, dimension: &Dimension) -> Result<(), FileError> {
        let key = (parent.to_owned(), dimension.name.clone());
        if let Some(scale) = self.scales.get(&key) {
            if scale.dimension() != dimension {
                return Err(FileError::Dimension { group: parent.into(), dimension: dimension.name.clone() });
            }
            return Ok(());
        }
        let path = format!("{parent}/{}", dimension.name);
        let write = || -> Result<(), hdf5::Error> {
            let shape = [dimension.len()];
            let dataset = match &dimension.coordinates {
                Coordinates::Index(length) => {
                    let dataset = create_dataset::<i64>(group, &dimension.name, &shape, None)?;
                    dataset.write_raw(&(0..*length as i64).collect::<Vec<_>>())?;
                    dataset
                }
                Coordinates::Values(values) => {
                    let dataset = create_dataset::<f64>(group, &dimension.name, &shape, None)?;
                    dataset.write_raw(values)?;
                    dataset
                }
                Coordinates::Labels(labels) => {
                    let dataset = create_dataset::<VarLenUnicode>(group, &dimension.name, &shape, None)?;
                    let labels: Result<Vec<VarLenUnicode>, _> = labels.iter().map(|label| label.parse()).collect();
                    dataset.write_raw(&labels.map_err(|_| "a label contains a zero byte")?)?;
                    dataset
                }
            };
            describe(&dataset, &dimension.units, &dimension.long_name)?;
            scale::mark(&dataset, &dimension.name)?;
            dataset.flush()
        };
        write().map_err(|error| self.failed(&path, &error))?;
        self.scales.insert(key, Scale::new(path, dimension.clone()));
        Ok(())
    }
}

impl Drop for Archive<'_> {
    fn drop(&mut self) {
        if let Some(file) = self.file.take() {
            drop(file);
            let _ = fs::remove_file(self.output.part());
        }
    }
}

/// Creates a dataset, chunked and compressed unless small, without time stamps: equal values give equal bytes.
fn create_dataset<T: H5Type>(
    group: &Group,
    name: &str,
    shape: &[usize],
    fill: Option<f64>,
) -> Result<Dataset, hdf5::Error> {
    let size = size_of::<T>();
    let mut builder = group.new_dataset_builder().obj_track_times(false);
    if let Some(fill) = fill {
        builder = builder.fill_value(fill);
    }
    if shape.iter().product::<usize>() * size >= SMALL_BYTES {
        builder = builder.chunk(chunk(shape, size)).shuffle().deflate(DEFLATE);
    }
    builder.empty::<T>().shape(shape).create(name)
}

/// Returns the number of rows with `columns` numbers each that are compressed together.
pub fn rows_of_chunk(columns: usize) -> usize {
    (CHUNK_BYTES / size_of::<f64>() / columns.max(1)).max(1)
}

/// Returns the shape of a chunk: whole rows up to [`CHUNK_BYTES`]; one entry of the first of three dimensions.
fn chunk(shape: &[usize], size: usize) -> Vec<usize> {
    let mut chunk = vec![1; shape.len()];
    let mut entries = (CHUNK_BYTES / size).max(1);
    let keep = usize::from(shape.len() > 2);
    for (chunk, &length) in chunk[keep..].iter_mut().zip(&shape[keep..]).rev() {
        *chunk = length.clamp(1, entries);
        entries = (entries / *chunk).max(1);
    }
    chunk
}

fn describe(at: &Location, units: &str, long_name: &str) -> Result<(), hdf5::Error> {
    for (name, text) in [("units", units), ("long_name", long_name)] {
        let text: VarLenUnicode = text.parse().map_err(|_| format!("{name} contains a zero byte"))?;
        write_attribute(at, name, &text)?;
    }
    Ok(())
}

fn write_attribute<T: H5Type>(at: &Location, name: &str, value: &T) -> Result<(), hdf5::Error> {
    at.new_attr::<T>().create(name)?.write_scalar(value)
}

fn text_of(path: &str, text: &str) -> Result<VarLenUnicode, FileError> {
    text.parse().map_err(|_| FileError::Text { variable: path.into() })
}
