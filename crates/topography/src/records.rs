//! Values of compound type in HDF5 files, used by some formats to describe their datasets.

use hdf5_reader::{CompoundField, Dataset, Datatype, StringSize, VarLenKind, dtype_element_size};

use crate::stored::{Decode, Hdf5, text};

/// Largest number of bytes of all records together, which only describe other datasets.
const MOST_RECORDS: usize = 1 << 20;

/// Largest number of numbers in a field of a record, and of bytes in a text.
const MOST_NUMBERS: usize = 1 << 12;
const LONGEST_TEXT: usize = 1 << 16;

/// Field of a record.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Field {
    Text(String),
    /// Number or array of numbers.
    Numbers(Vec<f64>),
    /// Field of another type.
    Other,
}

/// Reads all values of a dataset of compound type, or of an attribute of compound type.
pub(crate) fn records(file: &Hdf5, path: &str, attribute: Option<&str>) -> Result<Vec<Vec<Field>>, String> {
    let dataset = file.dataset(path)?;
    let (kind, bytes) = match attribute {
        Some(name) => {
            let attribute = file.attribute(path, name)?;
            (attribute.datatype, attribute.raw_data)
        }
        None => {
            let found = dataset.raw_byte_len().map_err(text)?;
            if found > MOST_RECORDS {
                return Err(format!("the records of {path} have {found} bytes; they must have at most {MOST_RECORDS}"));
            }
            (dataset.dtype().clone(), dataset.read_raw_bytes().map_err(text)?)
        }
    };
    let Datatype::Compound { size, fields } = kind else {
        return Err(format!("{path} has no records; it must have some"));
    };
    let record = |bytes: &[u8]| fields.iter().map(|field| decode(&dataset, field, bytes)).collect();
    Ok(bytes.chunks_exact((size as usize).max(1)).map(record).collect())
}

/// Decodes a field of a record of `dataset`, or of one of its attributes.
fn decode(dataset: &Dataset, field: &CompoundField, record: &[u8]) -> Field {
    let at = field.byte_offset as usize;
    let stored = |size: usize| record.get(at..at.checked_add(size)?);
    let elsewhere =
        |size: usize| dataset.resolve_vlen_reference_bytes(stored(dataset.vlen_reference_size())?, size).ok();
    let numbers = |bytes: &[u8], kind: &Datatype, size: usize| {
        let parts = bytes.chunks_exact(size.max(1)).take(MOST_NUMBERS);
        parts.map(|part| f64::decode(part, kind).ok()).collect()
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
