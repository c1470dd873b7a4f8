//! The checksum of everything that a file contains, so that a changed or damaged file is noticed.

use hdf5_reader::error::Error;
use hdf5_reader::group::Group;
use hdf5_reader::{Attribute, Dataset, Datatype, StringSize};

use crate::Checksum;
use crate::stored::{Decode, Hdf5, Number, text};

/// The attribute of the root that holds the checksum of all else.
pub(super) const NAME: &str = "content_sha256";

/// The most values that are read at a time.
const PIECE: usize = 1 << 22;

/// The checksum of the names, shapes and values of all variables, and of all attributes that are single numbers or texts.
pub(super) fn checksum(file: &Hdf5) -> Result<String, String> {
    let mut sum = Checksum::default();
    group(file, &file.root()?, "", &mut Vec::new(), &mut sum)?;
    Ok(sum.text())
}

/// Adds a group, which must not be one of the groups at the addresses `seen`: a damaged file can link a group into itself.
fn group(file: &Hdf5, of: &Group, path: &str, seen: &mut Vec<u64>, sum: &mut Checksum) -> Result<(), String> {
    if seen.contains(&of.address()) {
        return Err(format!("the group {path} has two names"));
    }
    seen.push(of.address());
    attributes(of.attributes().map_err(text)?, path, sum)?;
    let (groups, datasets) = of.member_names().map_err(text)?;
    let mut names: Vec<(&String, bool)> = groups.iter().map(|name| (name, true)).collect();
    names.extend(datasets.iter().map(|name| (name, false)));
    names.sort();
    for (name, is_group) in names {
        let path = format!("{path}/{name}");
        match is_group {
            true => group(file, &of.group(name).map_err(text)?, &path, seen, sum)?,
            false => variable(file, &of.dataset(name).map_err(text)?, &path, sum)?,
        }
    }
    Ok(())
}

fn attributes(mut attributes: Vec<Attribute>, path: &str, sum: &mut Checksum) -> Result<(), String> {
    attributes.sort_by(|one, other| one.name.cmp(&other.name));
    // Links between dimensions and variables, which are arrays, follow from the rest.
    for attribute in attributes.iter().filter(|attribute| attribute.name != NAME && attribute.shape.is_empty()) {
        sum.bytes(format!("{path}@{}=", attribute.name).as_bytes());
        match &attribute.datatype {
            kind @ (Datatype::FloatingPoint { .. } | Datatype::FixedPoint { .. }) => {
                sum.bytes(&bits(&attribute.raw_data, kind).map_err(text)?);
            }
            // Texts of fixed length are the marks of dimension scales.
            Datatype::String { size: StringSize::Fixed(_), .. } => {}
            _ => sum.bytes(attribute.read_string().map_err(text)?.as_bytes()),
        }
    }
    Ok(())
}

fn variable(file: &Hdf5, dataset: &Dataset, path: &str, sum: &mut Checksum) -> Result<(), String> {
    attributes(dataset.attributes(), path, sum)?;
    let shape = file.shape(path)?;
    sum.bytes(format!("{path}{shape:?}=").as_bytes());
    match dataset.dtype() {
        Datatype::FloatingPoint { .. } => values::<f64>(file, path, &shape, |value| sum.bytes(&value.to_le_bytes())),
        Datatype::FixedPoint { signed: true, .. } => {
            values::<i64>(file, path, &shape, |value| sum.bytes(&value.to_le_bytes()))
        }
        Datatype::FixedPoint { .. } => values::<u64>(file, path, &shape, |value| sum.bytes(&value.to_le_bytes())),
        _ => file.texts(path).map(|texts| texts.iter().for_each(|text| sum.bytes(format!("{text}\n").as_bytes()))),
    }
}

/// The bytes of a number of 64 bits that equals a number of any type.
fn bits(bytes: &[u8], kind: &Datatype) -> Result<[u8; 8], Error> {
    match kind {
        Datatype::FloatingPoint { .. } => f64::decode(bytes, kind).map(f64::to_le_bytes),
        Datatype::FixedPoint { signed: true, .. } => i64::decode(bytes, kind).map(i64::to_le_bytes),
        _ => u64::decode(bytes, kind).map(u64::to_le_bytes),
    }
}

/// Reads a variable in pieces along its first dimension.
fn values<T: Number>(file: &Hdf5, path: &str, shape: &[usize], mut see: impl FnMut(T)) -> Result<(), String> {
    let row = shape.iter().skip(1).fold(1_usize, |product, &length| product.saturating_mul(length));
    let length = shape.first().map_or(1, |&length| length);
    if length.saturating_mul(row) <= PIECE {
        file.values(path)?.into_iter().for_each(see);
        return Ok(());
    }
    let rows = (PIECE / row).max(1);
    for start in (0..length).step_by(rows) {
        file.slab(path, start..(start + rows).min(length))?.into_iter().for_each(&mut see);
    }
    Ok(())
}
