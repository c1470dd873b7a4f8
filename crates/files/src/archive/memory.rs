use std::any::TypeId;
use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use hdf5::H5Type;
use ndarray::ArrayD;

use super::{Archive, Attribute, Dimension, Provenance, Variable};
use crate::{FileError, Output};

/// Result in memory instead of a file: numbers as `f64`, and a record of all other content for a [`Draft`].
#[derive(Clone, Debug, Default)]
pub struct Memory(Arc<Mutex<Content>>);

#[derive(Debug, Default)]
struct Content {
    values: BTreeMap<String, ArrayD<f64>>,
    provenance: Provenance,
    entries: Vec<Entry>,
    is_finished: bool,
    /// Maximum number of bytes of numbers; `None` for no limit.
    room: Option<u64>,
}

/// File that is not written yet, without the fields, which are passed to [`Draft::write`].
#[derive(Clone, Debug)]
pub struct Draft {
    values: BTreeMap<String, ArrayD<f64>>,
    provenance: Provenance,
    entries: Vec<Entry>,
}

/// Variable or attribute of a file.
#[derive(Clone, Debug)]
enum Entry {
    Numbers(Described, Numbers),
    Texts(Described, Vec<String>),
    Attribute { path: String, name: String, value: Attribute },
}

/// Variable without its values.
#[derive(Clone, Debug)]
struct Described {
    path: String,
    dimensions: Vec<Dimension>,
    units: String,
    long_name: String,
}

/// Way in which numbers are written.
#[derive(Clone)]
enum Numbers {
    /// All at once.
    Whole,
    /// Entry by entry along the first dimension; entries that are NaN throughout are left out.
    Entries,
    /// Row by row.
    Rows,
    /// All at once, with a type other than `f64`.
    Typed(Arc<Write>),
}

/// Function that writes a variable with values of its own.
type Write = dyn Fn(&mut Archive, &str, &Variable) -> Result<(), FileError> + Send + Sync;

/// Number that an [`Archive`] writes.
pub trait Value: H5Type + Copy + Default + Send + Sync {
    /// Converts the number to `f64`.
    fn real(self) -> f64;
}

macro_rules! values {
    ($($number:ty)+) => {$(
        impl Value for $number {
            fn real(self) -> f64 {
                self as f64
            }
        }
    )+};
}

values! { f32 f64 u8 u32 u64 i64 }

impl Memory {
    /// Removes the variables below `group`, such as `/fields/`, and returns them by path, with the draft of their file.
    /// The draft is `None` if no archive was finished.
    pub fn take(&self, group: &str) -> (BTreeMap<String, ArrayD<f64>>, Option<Draft>) {
        let Content { values, provenance, entries, is_finished, .. } = std::mem::take(&mut *self.content());
        let (fields, values) = values.into_iter().partition(|(path, _)| path.starts_with(group));
        (fields, is_finished.then_some(Draft { values, provenance, entries }))
    }

    /// Limits the total number of bytes of all numbers.
    #[must_use]
    pub fn limited(self, room: Option<u64>) -> Self {
        self.content().room = room;
        self
    }

    /// Begins a file.
    pub(super) fn begin(&self, provenance: &Provenance) {
        let mut content = self.content();
        *content = Content { provenance: provenance.clone(), room: content.room, ..Content::default() };
    }

    /// Completes the file.
    pub(super) fn finish(&self) {
        self.content().is_finished = true;
    }

    /// Stores a variable with all its values.
    pub(super) fn put<T: Value>(&self, path: &str, variable: &Variable, values: &[T]) -> Result<(), FileError> {
        let numbers = if TypeId::of::<T>() == TypeId::of::<f64>() {
            Numbers::Whole
        } else {
            let values = values.to_vec();
            Numbers::Typed(Arc::new(move |archive, path, variable| archive.write(path, variable, &values)))
        };
        self.store(path, variable, values.iter().copied().map(T::real), numbers)
    }

    /// Stores a variable whose values are written later, entry by entry or row by row.
    pub(super) fn define(&self, path: &str, variable: &Variable, by_rows: bool) -> Result<(), FileError> {
        let numbers = if by_rows { Numbers::Rows } else { Numbers::Entries };
        self.store(path, variable, std::iter::empty(), numbers)
    }

    fn store(
        &self,
        path: &str,
        variable: &Variable,
        mut values: impl Iterator<Item = f64>,
        numbers: Numbers,
    ) -> Result<(), FileError> {
        let shape = variable.shape();
        let needed = shape.iter().fold(8_u64, |product, &length| product.saturating_mul(length as u64));
        let mut content = self.content();
        if let Some(room) = &mut content.room {
            let available = *room;
            let too_large = || FileError::Memory { variable: path.into(), needed, available };
            *room = room.checked_sub(needed).ok_or_else(too_large)?;
        }
        let array = ArrayD::from_shape_simple_fn(shape, || values.next().unwrap_or(f64::NAN));
        content.values.insert(path.into(), array);
        content.entries.push(Entry::Numbers(Described::of(path, variable), numbers));
        Ok(())
    }

    /// Stores a variable of strings.
    pub(super) fn put_text<S: AsRef<str>>(&self, path: &str, variable: &Variable, values: &[S]) {
        let texts = values.iter().map(|text| text.as_ref().to_owned()).collect();
        self.content().entries.push(Entry::Texts(Described::of(path, variable), texts));
    }

    /// Stores an attribute.
    pub(super) fn attribute(&self, path: &str, name: &str, value: Attribute) {
        self.content().entries.push(Entry::Attribute { path: path.into(), name: name.into(), value });
    }

    /// Returns the shape of a variable; empty if there is none.
    pub(super) fn shape(&self, path: &str) -> Vec<usize> {
        self.content().values.get(path).map_or_else(Vec::new, |values| values.shape().to_vec())
    }

    /// Writes values into a variable from index `start`, row-major. Returns `None` beyond its end.
    pub(super) fn write(&self, path: &str, start: usize, values: &[f64]) -> Option<()> {
        let mut content = self.content();
        let all = content.values.get_mut(path)?.as_slice_mut()?;
        all.get_mut(start..start.checked_add(values.len())?)?.copy_from_slice(values);
        Some(())
    }

    fn content(&self) -> MutexGuard<'_, Content> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Draft {
    /// Replaces the text of an existing attribute.
    pub fn replace(&mut self, group: &str, attribute: &str, text: &str) {
        for entry in &mut self.entries {
            match entry {
                Entry::Attribute { path, name, value } if path == group && name == attribute => *value = text.into(),
                _ => {}
            }
        }
    }

    /// Writes the file with the `fields` that were taken out, and returns its path. Its content is the same as if it
    /// had been written directly.
    ///
    /// # Errors
    /// Fields that are missing or have another shape; a file that cannot be written.
    pub fn write(&self, output: &Output, fields: &BTreeMap<String, ArrayD<f64>>) -> Result<PathBuf, FileError> {
        let mut archive = Archive::create(output, &self.provenance)?;
        for entry in &self.entries {
            match entry {
                Entry::Attribute { path, name, value } => archive.attribute(path, name, value.clone())?,
                Entry::Texts(described, texts) => {
                    described.variable(|variable| archive.write_text(&described.path, variable, texts))?;
                }
                Entry::Numbers(described, numbers) => {
                    let path = &described.path;
                    let values = fields.get(path).or_else(|| self.values.get(path));
                    let values = values.map(|values| values.as_standard_layout());
                    let values = values.as_ref().and_then(|values| values.as_slice()).unwrap_or_default();
                    described.variable(|variable| numbers.write(&mut archive, path, variable, values))?;
                }
            }
        }
        archive.finish()
    }
}

impl Numbers {
    fn write(&self, archive: &mut Archive, path: &str, variable: &Variable, values: &[f64]) -> Result<(), FileError> {
        archive.check_length(path, variable, values.len())?;
        match self {
            Self::Whole => archive.write(path, variable, values),
            Self::Typed(write) => write(archive, path, variable),
            Self::Rows => {
                archive.define_rows(path, variable)?;
                archive.write_rows(path, None, 0, values)
            }
            Self::Entries => {
                archive.define(path, variable)?;
                let size = variable.shape().iter().skip(1).product::<usize>().max(1);
                let entries = values.chunks(size).enumerate();
                let mut written = entries.filter(|(_, entry)| entry.iter().any(|value| !value.is_nan()));
                written.try_for_each(|(index, entry)| archive.write_slab(path, index, entry))
            }
        }
    }
}

impl fmt::Debug for Numbers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Whole => "Whole",
            Self::Entries => "Entries",
            Self::Rows => "Rows",
            Self::Typed(_) => "Typed",
        })
    }
}

impl Described {
    fn of(path: &str, variable: &Variable) -> Self {
        Self {
            path: path.into(),
            dimensions: variable.dimensions.iter().map(|&dimension| dimension.clone()).collect(),
            units: variable.units.into(),
            long_name: variable.long_name.into(),
        }
    }

    fn variable<R>(&self, take: impl FnOnce(&Variable) -> R) -> R {
        let dimensions: Vec<&Dimension> = self.dimensions.iter().collect();
        take(&Variable { dimensions: &dimensions, units: &self.units, long_name: &self.long_name })
    }
}
