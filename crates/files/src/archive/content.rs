//! Checksum of the whole content of a file, which reveals a changed or damaged file.

use std::collections::BTreeMap;

use hdf5_reader::error::Error;
use hdf5_reader::group::Group;
use hdf5_reader::{Attribute, Dataset, Datatype, StringSize};
use rayon::prelude::*;

use crate::Checksum;
use gfmd_topography::stored::{Decode, Hdf5, Number, text};

/// Root attribute with the checksum of all other content.
pub(super) const NAME: &str = "content_sha256";

/// Largest number of values in a piece, equal to a chunk in files of this program.
const PIECE: usize = 1 << 18;

/// Largest chunk in bytes, for results rewritten by another program. Each chunk is expanded whole.
const LARGEST_CHUNK: usize = 1 << 28;

/// Number of values added to the checksum at a time.
const BATCH: usize = 1 << 10;

/// Real numbers of variables, row-major, by path.
pub(super) type Values = BTreeMap<String, Vec<f64>>;

/// Computes the checksum of the names, shapes and values of all variables, and of all attributes that are single
/// numbers or texts. Also returns the real numbers of the variables whose path is `wanted`. Returns `None` if `stop`
/// returned true meanwhile.
pub(super) fn checksum(
    file: &Hdf5,
    stop: &(dyn Fn() -> bool + Sync),
    wanted: &dyn Fn(&str) -> bool,
) -> Result<Option<(String, Values)>, String> {
    let mut sum = Sum { sum: Checksum::default(), stop, wanted, kept: Values::new() };
    match group(file, &file.root()?, "", &mut Vec::new(), &mut sum) {
        Err(ChecksumFailure::Stopped) => Ok(None),
        Err(ChecksumFailure::Unreadable(reason)) => Err(reason),
        Ok(()) => Ok(Some((sum.sum.text(), sum.kept))),
    }
}

/// Running checksum that can be stopped, with the values to keep.
struct Sum<'a> {
    sum: Checksum,
    stop: &'a (dyn Fn() -> bool + Sync),
    wanted: &'a dyn Fn(&str) -> bool,
    kept: Values,
}

impl Sum<'_> {
    fn bytes(&mut self, bytes: &[u8]) {
        self.sum.bytes(bytes);
    }
}

/// Reason why a checksum is not computed.
enum ChecksumFailure {
    Stopped,
    Unreadable(String),
}

impl From<String> for ChecksumFailure {
    fn from(reason: String) -> Self {
        Self::Unreadable(reason)
    }
}

impl From<Error> for ChecksumFailure {
    fn from(error: Error) -> Self {
        Self::Unreadable(text(error))
    }
}

/// Returns an error if the chunks of a variable are larger than [`LARGEST_CHUNK`].
pub(super) fn check_chunk(file: &Hdf5, path: &str) -> Result<(), String> {
    let found = file.chunk_bytes(path)?;
    if found <= LARGEST_CHUNK {
        return Ok(());
    }
    Err(format!("its chunks have {found} bytes; those of a result have at most {LARGEST_CHUNK}"))
}

/// Adds a group, which must not be at one of the addresses `seen`: a damaged file can link a group into itself.
fn group(file: &Hdf5, of: &Group, path: &str, seen: &mut Vec<u64>, sum: &mut Sum) -> Result<(), ChecksumFailure> {
    if seen.contains(&of.address()) {
        return Err(format!("the group {path} has two names").into());
    }
    seen.push(of.address());
    let own = of.attributes()?;
    let (groups, datasets) = of.member_names()?;
    if !path.is_empty() && groups.is_empty() && datasets.is_empty() && own.iter().all(|one| !is_counted(one)) {
        return Err(format!("the group {path} is empty; no result has such a group").into());
    }
    attributes(own, path, sum)?;
    let mut names: Vec<(&String, bool)> = groups.iter().map(|name| (name, true)).collect();
    names.extend(datasets.iter().map(|name| (name, false)));
    names.sort();
    for (name, is_group) in names {
        let path = format!("{path}/{name}");
        match is_group {
            true => group(file, &of.group(name)?, &path, seen, sum)?,
            false => variable(file, &of.dataset(name)?, &path, sum)?,
        }
    }
    Ok(())
}

fn is_counted(attribute: &Attribute) -> bool {
    attribute.name != NAME && attribute.shape.is_empty()
}

fn attributes(mut attributes: Vec<Attribute>, path: &str, sum: &mut Sum) -> Result<(), ChecksumFailure> {
    attributes.sort_by(|one, other| one.name.cmp(&other.name));
    // Links between dimensions and variables, which are arrays, follow from the rest.
    for attribute in attributes.iter().filter(|attribute| is_counted(attribute)) {
        sum.bytes(format!("{path}@{}=", attribute.name).as_bytes());
        match &attribute.datatype {
            kind @ (Datatype::FloatingPoint { .. } | Datatype::FixedPoint { .. }) => {
                sum.bytes(&bits(&attribute.raw_data, kind)?);
            }
            // Texts of fixed length mark dimension scales.
            Datatype::String { size: StringSize::Fixed(_), .. } => {}
            _ => sum.bytes(attribute.read_string()?.as_bytes()),
        }
    }
    Ok(())
}

fn variable(file: &Hdf5, dataset: &Dataset, path: &str, sum: &mut Sum) -> Result<(), ChecksumFailure> {
    attributes(dataset.attributes(), path, sum)?;
    check_chunk(file, path)?;
    let shape = file.shape(path)?;
    sum.bytes(format!("{path}{shape:?}=").as_bytes());
    match dataset.dtype() {
        Datatype::FloatingPoint { .. } => {
            let mut kept = (sum.wanted)(path).then(Vec::new);
            values(file, path, &shape, f64::to_le_bytes, sum, |piece| {
                kept.iter_mut().for_each(|kept| kept.extend_from_slice(piece));
            })?;
            sum.kept.extend(kept.map(|values| (path.to_owned(), values)));
            Ok(())
        }
        Datatype::FixedPoint { signed: true, .. } => values(file, path, &shape, i64::to_le_bytes, sum, |_| {}),
        Datatype::FixedPoint { .. } => values(file, path, &shape, u64::to_le_bytes, sum, |_| {}),
        _ => {
            file.texts(path)?.iter().for_each(|text| sum.bytes(format!("{text}\n").as_bytes()));
            Ok(())
        }
    }
}

/// Returns the bytes of a number of any type, converted to 64 bits without loss.
fn bits(bytes: &[u8], kind: &Datatype) -> Result<[u8; 8], Error> {
    match kind {
        Datatype::FloatingPoint { .. } => f64::decode(bytes, kind).map(f64::to_le_bytes),
        Datatype::FixedPoint { signed: true, .. } => i64::decode(bytes, kind).map(i64::to_le_bytes),
        _ => u64::decode(bytes, kind).map(u64::to_le_bytes),
    }
}

/// Adds the values of a variable, converted by `bytes`, and shows them to `see` in order. Pieces are read on all
/// threads.
fn values<T: Number>(
    file: &Hdf5,
    path: &str,
    shape: &[usize],
    bytes: impl Fn(T) -> [u8; 8],
    sum: &mut Sum,
    mut see: impl FnMut(&[T]),
) -> Result<(), ChecksumFailure> {
    file.possible(path)?;
    let pieces = pieces(shape, &file.chunk(path)?.unwrap_or_else(|| vec![1; shape.len()]));
    let mut batch = Vec::with_capacity(8 * BATCH);
    for together in pieces.chunks(rayon::current_num_threads()) {
        if (sum.stop)() {
            return Err(ChecksumFailure::Stopped);
        }
        let read = |piece: &Vec<[usize; 2]>| {
            if piece.is_empty() { file.values(path) } else { file.part(path, piece) }
        };
        let read: Vec<Result<Vec<T>, String>> = together.par_iter().map(read).collect();
        for values in read {
            let values = values?;
            see(&values);
            for values in values.chunks(BATCH) {
                batch.clear();
                values.iter().for_each(|value| batch.extend_from_slice(&bytes(*value)));
                sum.bytes(&batch);
            }
        }
    }
    Ok(())
}

/// Returns the pieces of a variable in order, as [`Hdf5::part`] reads them. Pieces have at most [`PIECE`] values, or
/// more with larger chunks; they end at ends of chunks, so that each chunk is expanded only once.
fn pieces(shape: &[usize], chunk: &[usize]) -> Vec<Vec<[usize; 2]>> {
    let (Some((&length, inner)), Some((&step, inner_chunk))) = (shape.split_first(), chunk.split_first()) else {
        return vec![Vec::new()];
    };
    if shape.contains(&0) {
        return Vec::new();
    }
    let inner_count = inner.iter().fold(1_usize, |product, &length| product.saturating_mul(length));
    let entries = ((PIECE / inner_count.max(1)) / step).max(1) * step;
    let outer = (0..length).step_by(entries).map(|start| [start, length.min(start + entries)]);
    // Chunks of several entries are not divided.
    let is_whole = inner_count <= PIECE || entries > 1;
    let inner = if is_whole { vec![Vec::new()] } else { pieces(inner, inner_chunk) };
    let joined = |outer| inner.iter().map(move |inner| std::iter::once(outer).chain(inner.iter().copied()).collect());
    outer.flat_map(joined).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pieces_follow_each_other_and_are_small() {
        let pieces = |shape: &[usize]| pieces(shape, &vec![1; shape.len()]);
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

    #[test]
    fn each_chunk_is_in_one_piece() {
        let long = 1 << 24;
        let cases: [(&[usize], &[usize]); 8] = [
            (&[long], &[long]),
            (&[long], &[1000]),
            (&[long + 5], &[1 << 20]),
            (&[7, 300, 2000], &[1, 131, 2000]),
            (&[7, 300, 2000], &[3, 10, 2000]),
            (&[40, 1 << 20], &[1, 1 << 19]),
            (&[40, 1 << 20], &[7, 64]),
            (&[3, 4, 5, 90_000], &[1, 1, 2, 80_000]),
        ];
        for (shape, chunk) in cases {
            let (mut next, mut seen) = (0, std::collections::BTreeSet::new());
            for piece in pieces(shape, chunk) {
                // The values of each piece follow the values of the previous piece.
                let place = |axis: usize, piece: &[[usize; 2]]| piece.get(axis).map_or(0, |range| range[0]);
                let start = (0..shape.len()).fold(0, |at, axis| at * shape[axis] + place(axis, &piece));
                assert_eq!(start, next, "{shape:?} {chunk:?} {piece:?}");
                let lengths =
                    (0..shape.len()).map(|axis| piece.get(axis).map_or(shape[axis], |range| range[1] - range[0]));
                next += lengths.product::<usize>();
                let chunks = (0..shape.len()).map(|axis| {
                    let [from, to] = piece.get(axis).copied().unwrap_or([0, shape[axis]]);
                    (from / chunk[axis], to.div_ceil(chunk[axis]))
                });
                assert!(seen.insert(chunks.collect::<Vec<_>>()), "{shape:?} {chunk:?} {piece:?}");
                for (axis, [from, to]) in piece.iter().copied().enumerate() {
                    assert!(from % chunk[axis] == 0 && (to % chunk[axis] == 0 || to == shape[axis]), "{piece:?}");
                }
            }
            assert_eq!(next, shape.iter().product::<usize>(), "{shape:?} {chunk:?}");
        }
    }
}
