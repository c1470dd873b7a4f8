//! The checksum of the whole content of a file, which reveals a changed or damaged file.

use hdf5_reader::error::Error;
use hdf5_reader::group::Group;
use hdf5_reader::{Attribute, Dataset, Datatype, StringSize};
use rayon::prelude::*;

use crate::Checksum;
use gfmd_topography::stored::{Decode, Hdf5, Number, text};

/// The root attribute with the checksum of all other content.
pub(super) const NAME: &str = "content_sha256";

/// The largest number of values of a piece: that of a chunk in files of this program.
const PIECE: usize = 1 << 18;

/// The number of values that are added to the checksum at a time.
const BATCH: usize = 1 << 10;

/// The checksum of the names, shapes and values of all variables, and of all attributes that are single numbers or
/// texts.
pub(super) fn checksum(file: &Hdf5) -> Result<String, String> {
    let mut sum = Checksum::default();
    group(file, &file.root()?, "", &mut Vec::new(), &mut sum)?;
    Ok(sum.text())
}

/// Adds a group, which must not be one of the groups at the addresses `seen`: a damaged file can link a group into
/// itself.
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
        Datatype::FloatingPoint { .. } => values(file, path, &shape, f64::to_le_bytes, sum),
        Datatype::FixedPoint { signed: true, .. } => values(file, path, &shape, i64::to_le_bytes, sum),
        Datatype::FixedPoint { .. } => values(file, path, &shape, u64::to_le_bytes, sum),
        _ => file.texts(path).map(|texts| texts.iter().for_each(|text| sum.bytes(format!("{text}\n").as_bytes()))),
    }
}

/// The bytes of a number of any type, converted to 64 bits without loss.
fn bits(bytes: &[u8], kind: &Datatype) -> Result<[u8; 8], Error> {
    match kind {
        Datatype::FloatingPoint { .. } => f64::decode(bytes, kind).map(f64::to_le_bytes),
        Datatype::FixedPoint { signed: true, .. } => i64::decode(bytes, kind).map(i64::to_le_bytes),
        _ => u64::decode(bytes, kind).map(u64::to_le_bytes),
    }
}

/// Adds the values of a variable, the `bytes` of each. Pieces are read on all threads.
fn values<T: Number>(
    file: &Hdf5,
    path: &str,
    shape: &[usize],
    bytes: impl Fn(T) -> [u8; 8],
    sum: &mut Checksum,
) -> Result<(), String> {
    file.possible(path)?;
    let pieces = pieces(shape);
    let mut batch = Vec::with_capacity(8 * BATCH);
    for together in pieces.chunks(rayon::current_num_threads()) {
        let read = |piece: &Vec<[usize; 2]>| {
            if piece.is_empty() { file.values(path) } else { file.part(path, piece) }
        };
        let read: Vec<Result<Vec<T>, String>> = together.par_iter().map(read).collect();
        for values in read {
            for values in values?.chunks(BATCH) {
                batch.clear();
                values.iter().for_each(|value| batch.extend_from_slice(&bytes(*value)));
                sum.bytes(&batch);
            }
        }
    }
    Ok(())
}

/// The pieces of a variable in their order, of at most [`PIECE`] values, as [`Hdf5::part`] reads them.
fn pieces(shape: &[usize]) -> Vec<Vec<[usize; 2]>> {
    let Some((&length, inner)) = shape.split_first() else { return vec![Vec::new()] };
    if shape.contains(&0) {
        return Vec::new();
    }
    let inner_count = inner.iter().fold(1_usize, |product, &length| product.saturating_mul(length));
    let entries = (PIECE / inner_count.max(1)).max(1);
    let outer = (0..length).step_by(entries).map(|start| [start, length.min(start + entries)]);
    let inner = if inner_count <= PIECE { vec![Vec::new()] } else { pieces(inner) };
    let joined = |outer| inner.iter().map(move |inner| std::iter::once(outer).chain(inner.iter().copied()).collect());
    outer.flat_map(joined).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_follow_each_other_and_are_small() {
        assert_eq!(pieces(&[]), [Vec::<[usize; 2]>::new()]);
        assert_eq!(pieces(&[7]), [[[0, 7]]]);
        assert_eq!(pieces(&[2, 3, 5]), [[[0, 2]]]);
        let field = pieces(&[2, 300, 2000]);
        assert_eq!(field[..3], [[[0, 1], [0, 131]], [[0, 1], [131, 262]], [[0, 1], [262, 300]]]);
        assert_eq!(field[3], [[1, 2], [0, 131]]);
        let long = pieces(&[2, PIECE + 1]);
        assert_eq!(long[..2], [[[0, 1], [0, PIECE]], [[0, 1], [PIECE, PIECE + 1]]]);
        assert_eq!(long[2..], [[[1, 2], [0, PIECE]], [[1, 2], [PIECE, PIECE + 1]]]);
        assert!(pieces(&[1 << 60, 0]).is_empty());
    }
}
