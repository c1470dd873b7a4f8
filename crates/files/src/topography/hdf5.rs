//! HDF5 files of any program, read in Rust: the HDF5 library is written in C and not made for damaged files.

use hdf5_reader::error::{ByteOrder, Error};
use hdf5_reader::group::Group;
use hdf5_reader::{
    Attribute, CompoundField, Dataset, Datatype, H5Type, Hdf5File, OpenOptions, StringSize, VarLenKind,
    dtype_element_size,
};

/// What one byte of a file can become: deflate makes at most 1032 bytes from one.
const LARGEST_RATIO: usize = 1032;

/// The bytes that a small file may become.
const SMALL: usize = 1 << 20;

/// The most datasets that are listed, groups that are searched, and groups inside each other.
const MOST_DATASETS: usize = 1000;
const MOST_GROUPS: usize = 10_000;
const DEEPEST: usize = 8;

/// The most bytes of all records together. Records describe others.
const MOST_RECORDS: usize = 1 << 20;

/// The most numbers of a field of a record, and bytes of a text.
const MOST_NUMBERS: usize = 1 << 12;
const LONGEST_TEXT: usize = 1 << 16;

/// An HDF5 file.
pub(super) struct Hdf5 {
    file: Hdf5File,
}

/// A field of a record.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Field {
    Text(String),
    /// A number or an array of numbers.
    Numbers(Vec<f64>),
    /// A field of another type.
    Other,
}

impl Hdf5 {
    /// Opens a file of `bytes` bytes. Nothing is allocated for what only a shape declares.
    pub(super) fn open(
        bytes: usize,
        open: impl FnOnce(OpenOptions) -> Result<Hdf5File, Error>,
    ) -> Result<Self, String> {
        let most = bytes.saturating_mul(LARGEST_RATIO).max(SMALL);
        let options = OpenOptions::default().with_chunk_cache_bytes(0);
        let options =
            options.with_max_read_bytes(most).with_max_chunk_bytes(most).with_max_object_header_bytes(4 * SMALL);
        open(options).map(|file| Self { file }).map_err(text)
    }

    /// True if there is a dataset at `path`.
    pub(super) fn contains(&self, path: &str) -> bool {
        self.file.dataset(path).is_ok()
    }

    /// The paths and shapes of the datasets of real numbers in all groups, in the order of their paths, without coordinates
    /// (dimension scales).
    pub(super) fn datasets(&self) -> Vec<(String, Vec<usize>)> {
        let mut search = Search { groups: 0, found: Vec::new() };
        if let Ok(root) = self.file.root_group() {
            search.group(&root, "", DEEPEST);
        }
        search.found
    }

    /// The lengths of a dataset's dimensions.
    pub(super) fn shape(&self, path: &str) -> Result<Vec<usize>, String> {
        shape(&self.dataset(path)?)
    }

    /// All values of a dataset of real numbers, row-major.
    pub(super) fn values(&self, path: &str) -> Result<Vec<f64>, String> {
        let dataset = self.dataset(path)?;
        let values = match <f64 as H5Type>::native_copy_compatible(dataset.dtype()) {
            true => dataset.read_array::<f64>().map(|array| array.into_raw_vec_and_offset().0),
            false => dataset.read_array::<Real>().map(|array| array.into_iter().map(|Real(value)| value).collect()),
        };
        values.map_err(text)
    }

    /// A text attribute of a dataset.
    pub(super) fn text(&self, path: &str, name: &str) -> Result<String, String> {
        let texts = self.attribute(path, name)?.read_strings().map_err(text)?;
        Ok(texts.into_iter().next().unwrap_or_default())
    }

    /// A numerical attribute of a dataset. Other programs store a number as an array of one.
    pub(super) fn number(&self, path: &str, name: &str) -> Result<f64, String> {
        match self.attribute(path, name)?.read_1d::<Real>().map_err(text)?[..] {
            [Real(number)] => Ok(number),
            ref numbers => Err(format!("the attribute {name} has {} numbers; it must have one", numbers.len())),
        }
    }

    /// All values of a dataset of compound type, or of such an attribute of the dataset.
    pub(super) fn records(&self, path: &str, attribute: Option<&str>) -> Result<Vec<Vec<Field>>, String> {
        let dataset = self.dataset(path)?;
        let (kind, bytes) = match attribute {
            Some(name) => {
                let attribute = self.attribute(path, name)?;
                (attribute.datatype, attribute.raw_data)
            }
            None => {
                let found = dataset.raw_byte_len().map_err(text)?;
                if found > MOST_RECORDS {
                    return Err(format!(
                        "the records of {path} have {found} bytes; they must have at most {MOST_RECORDS}"
                    ));
                }
                (dataset.dtype().clone(), dataset.read_raw_bytes().map_err(text)?)
            }
        };
        let Datatype::Compound { size, fields } = kind else {
            return Err(format!("{path} has no records; it must have some"));
        };
        let record = |bytes: &[u8]| fields.iter().map(|field| self::field(&dataset, field, bytes)).collect();
        Ok(bytes.chunks_exact((size as usize).max(1)).map(record).collect())
    }

    fn attribute(&self, path: &str, name: &str) -> Result<Attribute, String> {
        self.dataset(path)?.attribute(name).map_err(text)
    }

    fn dataset(&self, path: &str) -> Result<Dataset, String> {
        self.file.dataset(path).map_err(text)
    }
}

fn text(error: Error) -> String {
    error.to_string().replace('\n', " ")
}

fn shape(dataset: &Dataset) -> Result<Vec<usize>, String> {
    let lengths = dataset.shape().iter().map(|&length| usize::try_from(length));
    lengths.collect::<Result<_, _>>().map_err(|_| format!("the shape is {:?}; it is too large", dataset.shape()))
}

/// A search for datasets.
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

/// Decodes a field of a record of `dataset`, or of an attribute of it.
fn field(dataset: &Dataset, field: &CompoundField, record: &[u8]) -> Field {
    let at = field.byte_offset as usize;
    let stored = |size: usize| record.get(at..at.checked_add(size)?);
    let elsewhere =
        |size: usize| dataset.resolve_vlen_reference_bytes(stored(dataset.vlen_reference_size())?, size).ok();
    let numbers = |bytes: &[u8], kind: &Datatype, size: usize| {
        let parts = bytes.chunks_exact(size.max(1)).take(MOST_NUMBERS);
        parts.map(|part| Real::from_bytes(part, kind).ok().map(|Real(number)| number)).collect()
    };
    let decoded = match &field.datatype {
        Datatype::VarLen { kind: VarLenKind::String, .. } | Datatype::String { size: StringSize::Variable, .. } => {
            elsewhere(1).map(|bytes| Field::Text(until_zero(&bytes)))
        }
        Datatype::String { size: StringSize::Fixed(length), .. } => {
            stored(*length as usize).map(|bytes| Field::Text(until_zero(bytes)))
        }
        Datatype::VarLen { base, .. } => {
            dtype_element_size(base).ok().and_then(|size| numbers(&elsewhere(size)?, base, size)).map(Field::Numbers)
        }
        Datatype::Array { base, .. } => dtype_element_size(&field.datatype)
            .ok()
            .zip(dtype_element_size(base).ok())
            .and_then(|(all, size)| numbers(stored(all)?, base, size))
            .map(Field::Numbers),
        kind => dtype_element_size(kind).ok().and_then(|size| numbers(stored(size)?, kind, size)).map(Field::Numbers),
    };
    decoded.unwrap_or(Field::Other)
}

fn until_zero(bytes: &[u8]) -> String {
    let bytes = &bytes[..bytes.len().min(LONGEST_TEXT)];
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).into_owned()
}

/// A real number of any type.
#[derive(Clone)]
struct Real(f64);

impl H5Type for Real {
    fn hdf5_type() -> Datatype {
        f64::hdf5_type()
    }

    fn from_bytes(bytes: &[u8], kind: &Datatype) -> Result<Self, Error> {
        let value = match kind {
            Datatype::FloatingPoint { size: 8, .. } => f64::from_bytes(bytes, kind)?,
            Datatype::FloatingPoint { size: 4, .. } => f32::from_bytes(bytes, kind)?.into(),
            Datatype::FloatingPoint { size: 2, byte_order } => half(bytes, *byte_order)?,
            Datatype::FixedPoint { size: 1, signed: true, .. } => i8::from_bytes(bytes, kind)?.into(),
            Datatype::FixedPoint { size: 1, .. } => u8::from_bytes(bytes, kind)?.into(),
            Datatype::FixedPoint { size: 2, signed: true, .. } => i16::from_bytes(bytes, kind)?.into(),
            Datatype::FixedPoint { size: 2, .. } => u16::from_bytes(bytes, kind)?.into(),
            Datatype::FixedPoint { size: 4, signed: true, .. } => i32::from_bytes(bytes, kind)?.into(),
            Datatype::FixedPoint { size: 4, .. } => u32::from_bytes(bytes, kind)?.into(),
            Datatype::FixedPoint { size: 8, signed: true, .. } => i64::from_bytes(bytes, kind)? as f64,
            Datatype::FixedPoint { size: 8, .. } => u64::from_bytes(bytes, kind)? as f64,
            other => {
                return Err(Error::TypeMismatch { expected: "a real number".into(), actual: format!("{other:?}") });
            }
        };
        Ok(Self(value))
    }

    fn element_size(kind: &Datatype) -> usize {
        dtype_element_size(kind).unwrap_or(0)
    }
}

/// The value of a float of 16 bits (IEEE 754).
fn half(bytes: &[u8], order: ByteOrder) -> Result<f64, Error> {
    let kind = Datatype::FixedPoint { size: 2, signed: false, byte_order: order };
    let bits = u16::from_bytes(bytes, &kind)?;
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023) / 1024.0);
    let magnitude = match exponent {
        0 => fraction * 2_f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction) * 2_f64.powi(exponent - 15),
    };
    Ok(if bits >> 15 == 1 { -magnitude } else { magnitude })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_those_of_the_standard() {
        let value = |bits: u16| half(&bits.to_le_bytes(), ByteOrder::LittleEndian).unwrap();
        let expected =
            [(0x3c00, 1.0), (0xc000, -2.0), (0x7bff, 65504.0), (0x0001, 2_f64.powi(-24)), (0x3555, 0.333_251_953_125)];
        assert!(expected.iter().all(|(bits, number)| value(*bits) == *number));
        assert!(value(0x7c00) == f64::INFINITY && value(0x7e00).is_nan());
    }
}
