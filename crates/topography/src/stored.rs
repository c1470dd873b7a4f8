//! HDF5 files of any program, read in Rust: the HDF5 library is written in C and not robust against damaged files.

mod number;

use std::sync::Arc;

use hdf5_reader::error::Error;
use hdf5_reader::group::Group;
use hdf5_reader::reference::read_object_references;
use hdf5_reader::{Attribute, Dataset, Datatype, FileStorage, Hdf5File, OpenOptions, SliceInfo, SliceInfoElem};
use ndarray::ArrayD;

use crate::Input;
use crate::packing::{Kind, Packing, Value};

use number::Stored;

pub use number::Decode;
pub use number::Number;

/// Largest expansion of a byte of a file: deflate expands one byte to at most 1032.
const LARGEST_RATIO: usize = 1032;

/// Number of bytes to which a small file may expand.
const SMALL_FILE_EXPANSION: usize = 1 << 20;

/// Largest number of datasets listed, of groups searched, and of nested groups.
const MOST_DATASETS: usize = 1000;
const MOST_GROUPS: usize = 10_000;
const DEEPEST: usize = 8;

/// HDF5 file.
pub struct Hdf5 {
    file: Hdf5File,
    /// Largest number of bytes of a dataset.
    most: usize,
}

impl Hdf5 {
    /// Opens a file on disk.
    pub fn open(input: &Input) -> Result<Self, String> {
        let file = input.handle().map_err(|error| error.to_string())?;
        let length = usize::try_from(input.length()).unwrap_or(usize::MAX);
        Self::limited(length, |options| {
            Hdf5File::from_storage_with_options(Arc::new(FileStorage::from_file(file)?), options)
        })
    }

    /// Opens a file in memory.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, String> {
        Self::limited(bytes.len(), |options| Hdf5File::from_bytes_with_options(bytes, options))
    }

    /// Opens a file of `bytes` bytes. Nothing is allocated based on a declared shape alone.
    fn limited(bytes: usize, open: impl FnOnce(OpenOptions) -> Result<Hdf5File, Error>) -> Result<Self, String> {
        let most = bytes.saturating_mul(LARGEST_RATIO).max(SMALL_FILE_EXPANSION);
        let options = OpenOptions::default().with_chunk_cache_bytes(0);
        let options = options
            .with_max_read_bytes(most)
            .with_max_chunk_bytes(most)
            .with_max_object_header_bytes(4 * SMALL_FILE_EXPANSION);
        open(options).map(|file| Self { file, most }).map_err(text)
    }

    /// Returns true if there is a dataset at `path`.
    pub fn contains(&self, path: &str) -> bool {
        self.file.dataset(path).is_ok()
    }

    /// Returns paths and shapes of the datasets of real numbers in all groups, sorted by path, without coordinates
    /// (dimension scales).
    pub fn datasets(&self) -> Vec<(String, Vec<usize>)> {
        let mut search = Search { groups: 0, found: Vec::new() };
        if let Ok(root) = self.file.root_group() {
            search.group(&root, "", DEEPEST);
        }
        search.found
    }

    /// Returns the lengths of the dimensions of a dataset.
    pub fn shape(&self, path: &str) -> Result<Vec<usize>, String> {
        shape(&self.dataset(path)?)
    }

    /// Returns the chunk lengths of a dataset, each at most its dimension, or `None` if it is not chunked.
    pub fn chunk(&self, path: &str) -> Result<Option<Vec<usize>>, String> {
        let dataset = self.dataset(path)?;
        let lengths = shape(&dataset)?;
        let chunk = dataset.chunks();
        Ok(chunk.map(|chunk| chunk.iter().zip(lengths).map(|(&chunk, all)| (chunk as usize).min(all).max(1)).collect()))
    }

    /// Returns the number of bytes to which a chunk of a dataset expands, or 0 if it is not chunked.
    pub fn chunk_bytes(&self, path: &str) -> Result<usize, String> {
        let dataset = self.dataset(path)?;
        let size = dataset.raw_element_size().map_err(text)?;
        let count = dataset
            .chunks()
            .map_or(0, |chunk| chunk.iter().fold(1_usize, |product, &length| product.saturating_mul(length as usize)));
        Ok(count.saturating_mul(size))
    }

    /// Returns the names in a group, sorted.
    pub fn names(&self, group: &str) -> Result<Vec<String>, String> {
        let (mut names, datasets) = self.file.group(group).and_then(|group| group.member_names()).map_err(text)?;
        names.extend(datasets);
        names.sort();
        Ok(names)
    }

    /// Reads all values of a dataset, row-major.
    pub fn values<T: Number>(&self, path: &str) -> Result<Vec<T>, String> {
        self.dataset(path)?.read_array().map(numbers).map_err(text)
    }

    /// Reads all values of a dataset, row-major, scaled and with NaN for missing values by the NetCDF conventions for
    /// attributes. Integers with an attribute that may scale them in an unknown way are an error.
    pub fn physical(&self, path: &str) -> Result<Vec<f64>, String> {
        let packing = self.packing(path)?;
        packing.check(path, None)?;
        let mut values = self.values(path)?;
        values.iter_mut().for_each(|value| *value = packing.value(*value));
        Ok(values)
    }

    /// Returns the conversion of the numbers of a dataset to values by its attributes.
    pub(crate) fn packing(&self, path: &str) -> Result<Packing, String> {
        let attributes: Vec<(String, Value)> = self.attributes(path)?.iter().map(value).collect();
        let is_netcdf = self.attribute("/", "_NCProperties").is_ok();
        Packing::of(self.kind(path)?, &attributes, is_netcdf).map_err(|reason| format!("{path}: {reason}"))
    }

    /// Returns the kind of the numbers of a dataset.
    pub(crate) fn kind(&self, path: &str) -> Result<Kind, String> {
        kind(self.dataset(path)?.dtype()).ok_or_else(|| format!("{path} has no real numbers; it must have some"))
    }

    /// Returns the names of the dimensions of the dataset `name` in `group`: paths of their coordinates, or labels, or
    /// `None` for unnamed dimensions.
    pub(crate) fn dimensions(&self, group: &str, name: &str) -> Vec<Option<String>> {
        let path = format!("{group}/{name}");
        let Ok(dataset) = self.file.dataset(&path) else { return Vec::new() };
        if let Ok(labels) = dataset.attribute("DIMENSION_LABELS").and_then(|labels| labels.read_strings()) {
            return labels.into_iter().map(|label| Some(label).filter(|label| !label.is_empty())).collect();
        }
        let Ok(list) = dataset.attribute("DIMENSION_LIST") else { return Vec::new() };
        let size = dataset.vlen_reference_size();
        let offset = u8::try_from(size.saturating_sub(8)).unwrap_or(8);
        let first = |reference: &[u8]| {
            let found = dataset.resolve_vlen_reference_bytes(reference, usize::from(offset)).ok()?;
            read_object_references(&found, offset).ok()?.first().copied()
        };
        // A dimension is in the group of the dataset, or in an enclosing group.
        let named = |reference: &[u8]| {
            let address = first(reference)?;
            let mut group = group;
            loop {
                let holder = if group.is_empty() { self.file.root_group() } else { self.file.group(group) };
                if let Some(name) = holder.ok()?.child_name_by_address(address).ok()? {
                    return Some(format!("{group}/{name}"));
                }
                group = group.rsplit_once('/')?.0;
            }
        };
        list.raw_data.chunks_exact(size).take(2).map(named).collect()
    }

    /// Reads the values of a dataset at ranges of its first dimensions, each from the first entry to one past the last.
    pub fn part<T: Number>(&self, path: &str, entries: &[[usize; 2]]) -> Result<Vec<T>, String> {
        let dataset = self.possible(path)?;
        let mut selection = SliceInfo::all(dataset.ndim());
        for (selected, [start, end]) in selection.selections.iter_mut().zip(entries) {
            *selected = SliceInfoElem::Slice { start: *start as u64, end: *end as u64, step: 1 };
        }
        dataset.read_slice(&selection).map(numbers).map_err(text)
    }

    /// Reads all values of a dataset of texts.
    pub fn texts(&self, path: &str) -> Result<Vec<String>, String> {
        self.dataset(path)?.read_strings().map_err(text)
    }

    /// Reads a text attribute of the group or dataset at `path`.
    pub fn text(&self, path: &str, name: &str) -> Result<String, String> {
        let texts = self.attribute(path, name)?.read_strings().map_err(text)?;
        Ok(texts.into_iter().next().unwrap_or_default())
    }

    /// Reads a numerical attribute of the group or dataset at `path`. Other programs store a number as an array with
    /// one element.
    pub fn number(&self, path: &str, name: &str) -> Result<f64, String> {
        match self.attribute(path, name)?.read_1d().map_err(text)?[..] {
            [Stored(number)] => Ok(number),
            ref numbers => Err(format!("the attribute {name} has {} numbers; it must have one", numbers.len())),
        }
    }

    /// Reads a numerical attribute like [`number`](Self::number); `None` if there is no such attribute.
    pub fn number_if_any(&self, path: &str, name: &str) -> Result<Option<f64>, String> {
        self.attribute(path, name).ok().map(|_| self.number(path, name)).transpose()
    }

    /// Returns an attribute of the group or dataset at `path`.
    pub fn attribute(&self, path: &str, name: &str) -> Result<Attribute, String> {
        let found = match self.file.dataset(path) {
            Ok(dataset) => dataset.attribute(name),
            Err(_) => self.file.group(path).and_then(|group| group.attribute(name)),
        };
        found.map_err(text)
    }

    /// Returns all attributes of the group or dataset at `path`.
    pub fn attributes(&self, path: &str) -> Result<Vec<Attribute>, String> {
        match self.file.dataset(path) {
            Ok(dataset) => Ok(dataset.attributes()),
            Err(_) => self.file.group(path).and_then(|group| group.attributes()).map_err(text),
        }
    }

    /// Returns the dataset at `path`.
    pub fn dataset(&self, path: &str) -> Result<Dataset, String> {
        self.file.dataset(path).map_err(text)
    }

    /// Returns the dataset at `path` if a file of this size can contain it.
    pub fn possible(&self, path: &str) -> Result<Dataset, String> {
        let dataset = self.dataset(path)?;
        let found = dataset.raw_byte_len().map_err(text)?;
        if found > self.most {
            return Err(format!("{path} declares {found} bytes; a file of this size holds at most {}", self.most));
        }
        // Each chunk is expanded whole, even beyond the dataset.
        let chunk = self.chunk_bytes(path)?;
        if chunk > found.max(LARGEST_CHUNK) {
            return Err(format!("the chunks of {path} have {chunk} bytes; they must have at most {LARGEST_CHUNK}"));
        }
        Ok(dataset)
    }

    /// Returns the root group.
    pub fn root(&self) -> Result<Group, String> {
        self.file.root_group().map_err(text)
    }
}

/// Largest number of bytes of a chunk that is larger than its dataset.
const LARGEST_CHUNK: usize = 1 << 28;

/// Returns the kind of real numbers; `None` for other values.
fn kind(datatype: &Datatype) -> Option<Kind> {
    match *datatype {
        Datatype::FloatingPoint { size, .. } => Some(Kind { is_float: true, is_signed: true, bytes: u32::from(size) }),
        Datatype::FixedPoint { size, signed, .. } => {
            Some(Kind { is_float: false, is_signed: signed, bytes: u32::from(size) })
        }
        _ => None,
    }
}

/// Returns the name and value of an attribute.
fn value(attribute: &Attribute) -> (String, Value) {
    let value = match kind(&attribute.datatype) {
        Some(Kind { is_float, .. }) => match attribute.read_1d::<Stored<f64>>() {
            Ok(numbers) => Value::Numbers { numbers: numbers.into_iter().map(|Stored(n)| n).collect(), is_float },
            Err(_) => Value::Other,
        },
        None => {
            let text = attribute.read_strings().ok().and_then(|texts| texts.into_iter().next());
            text.map_or(Value::Other, Value::Text)
        }
    };
    (attribute.name.clone(), value)
}

/// Returns the message of an error on one line.
pub fn text(error: Error) -> String {
    error.to_string().replace('\n', " ")
}

fn numbers<T>(array: ArrayD<Stored<T>>) -> Vec<T> {
    array.into_iter().map(|Stored(value)| value).collect()
}

fn shape(dataset: &Dataset) -> Result<Vec<usize>, String> {
    let lengths = dataset.shape().iter().map(|&length| usize::try_from(length));
    lengths.collect::<Result<_, _>>().map_err(|_| format!("the shape is {:?}; it is too large", dataset.shape()))
}

/// Search for datasets.
struct Search {
    groups: usize,
    found: Vec<(String, Vec<usize>)>,
}

impl Search {
    fn group(&mut self, group: &Group, path: &str, depth: usize) {
        self.groups += 1;
        let Ok((groups, datasets)) = group.member_names() else { return };
        let mut names: Vec<(String, bool)> = groups.into_iter().map(|name| (name, true)).collect();
        names.extend(datasets.into_iter().map(|name| (name, false)));
        names.sort();
        for (name, is_group) in names {
            if self.found.len() >= MOST_DATASETS || self.groups >= MOST_GROUPS {
                return;
            }
            let whole = format!("{path}/{name}");
            if is_group {
                if let (1.., Ok(inner)) = (depth, group.group(&name)) {
                    self.group(&inner, &whole, depth - 1);
                }
            } else if let Ok(dataset) = group.dataset(&name) {
                let is_number = matches!(dataset.dtype(), Datatype::FixedPoint { .. } | Datatype::FloatingPoint { .. });
                let class = dataset.attribute("CLASS").and_then(|class| class.read_strings());
                let is_scale = class.is_ok_and(|class| class == ["DIMENSION_SCALE"]);
                if let (true, false, Ok(shape)) = (is_number, is_scale, shape(&dataset)) {
                    self.found.push((whole, shape));
                }
            }
        }
    }
}
