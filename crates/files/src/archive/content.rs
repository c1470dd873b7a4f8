//! The checksum of everything that a file contains, so that a changed or damaged file is noticed.

use hdf5::types::{TypeDescriptor, VarLenUnicode};
use hdf5::{Dataset, File, Group, H5Type, Location};

use super::reader::texts;
use crate::Checksum;

/// The attribute of the root that holds the checksum of all else.
pub(super) const NAME: &str = "content_sha256";

/// The most values that are read at a time.
const PIECE: usize = 1 << 22;

/// The checksum of the names, shapes and values of all variables, and of all attributes that are single numbers or texts.
pub(super) fn checksum(file: &File) -> hdf5::Result<String> {
    let mut sum = Checksum::default();
    group(&file.as_group()?, "", &mut sum)?;
    Ok(sum.text())
}

fn group(of: &Group, path: &str, sum: &mut Checksum) -> hdf5::Result<()> {
    attributes(of, path, sum)?;
    let mut names = of.member_names()?;
    names.sort();
    for name in names {
        let path = format!("{path}/{name}");
        match of.dataset(&name) {
            Ok(dataset) => variable(&dataset, &path, sum)?,
            Err(_) => group(&of.group(&name)?, &path, sum)?,
        }
    }
    Ok(())
}

fn attributes(of: &Location, path: &str, sum: &mut Checksum) -> hdf5::Result<()> {
    let mut names = of.attr_names()?;
    names.sort();
    for name in names.iter().filter(|name| *name != NAME) {
        let attribute = of.attr(name)?;
        if attribute.ndim() > 0 {
            continue; // Links between dimensions and variables follow from the rest.
        }
        sum.bytes(format!("{path}@{name}=").as_bytes());
        match attribute.dtype()?.to_descriptor()? {
            TypeDescriptor::Float(_) => sum.bytes(&attribute.read_scalar::<f64>()?.to_le_bytes()),
            TypeDescriptor::Integer(_) => sum.bytes(&attribute.read_scalar::<i64>()?.to_le_bytes()),
            TypeDescriptor::Unsigned(_) => sum.bytes(&attribute.read_scalar::<u64>()?.to_le_bytes()),
            TypeDescriptor::VarLenUnicode => sum.bytes(attribute.read_scalar::<VarLenUnicode>()?.as_bytes()),
            // The marks of dimension scales.
            _ => {}
        }
    }
    Ok(())
}

fn variable(dataset: &Dataset, path: &str, sum: &mut Checksum) -> hdf5::Result<()> {
    attributes(dataset, path, sum)?;
    sum.bytes(format!("{path}{:?}=", dataset.shape()).as_bytes());
    match dataset.dtype()?.to_descriptor()? {
        TypeDescriptor::Float(_) => values::<f64>(dataset, |value| sum.bytes(&value.to_le_bytes())),
        TypeDescriptor::Integer(_) => values::<i64>(dataset, |value| sum.bytes(&value.to_le_bytes())),
        TypeDescriptor::Unsigned(_) => values::<u64>(dataset, |value| sum.bytes(&value.to_le_bytes())),
        _ => texts(dataset).map(|texts| texts.iter().for_each(|text| sum.bytes(format!("{text}\n").as_bytes()))),
    }
}

/// Reads a variable in pieces along its first dimension.
fn values<T: H5Type>(dataset: &Dataset, mut see: impl FnMut(&T)) -> hdf5::Result<()> {
    let shape = dataset.shape();
    let row: usize = shape.iter().skip(1).product();
    if dataset.size() <= PIECE || row == 0 {
        dataset.read_raw::<T>()?.iter().for_each(see);
        return Ok(());
    }
    let rows = (PIECE / row).max(1);
    for start in (0..shape[0]).step_by(rows) {
        let mut selection = vec![hdf5::SliceOrIndex::from(start..(start + rows).min(shape[0]))];
        selection.extend(shape[1..].iter().map(|_| hdf5::SliceOrIndex::from(..)));
        let piece = dataset.read_slice::<T, _, ndarray::IxDyn>(hdf5::Hyperslab::from(selection))?;
        piece.iter().for_each(&mut see);
    }
    Ok(())
}
