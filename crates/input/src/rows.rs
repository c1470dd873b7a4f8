//! Fields distributed by rows over processes: from the process that reads files, and to the one that writes and draws.

use gfmd_field::Share;
use gfmd_files::{Archive, Checksum, Variable, contiguous, rows_of_chunk};
use ndarray::{Array2, ArrayView2};

use crate::failure::Failure;

/// Number of file chunks in a block of rows. A block travels at once, and all threads of the first process compress it.
const CHUNKS: usize = 16;

/// Returns the number of rows of a block with `columns` values each.
pub fn height(columns: usize) -> usize {
    CHUNKS * rows_of_chunk(columns)
}

/// Distributes the rows of a field of the first process; the other processes give `None`.
pub fn handed_out(share: &Share, whole: Option<&Array2<f64>>, columns: usize) -> Array2<f64> {
    let whole = whole.map(|whole| contiguous(whole)).unwrap_or_default();
    let rows = share.rows().len();
    let mut own = vec![0.0; rows * columns];
    share.from_first(&mut own, columns, height(columns), |rows, values| {
        values.copy_from_slice(&whole[rows.start * columns..rows.end * columns]);
    });
    Array2::from_shape_vec((rows, columns), own).expect("rows are whole")
}

/// Gathers the whole field at the first process; returns `None` at the others.
pub fn gathered(share: &Share, own: ArrayView2<f64>) -> Option<Array2<f64>> {
    let (columns, own) = (own.ncols(), contiguous(&own));
    let is_first = share.ranks().rank() == 0;
    let mut whole = Vec::with_capacity(if is_first { share.total() } else { 0 });
    share.to_first(&own, columns, height(columns), |_, values| whole.extend_from_slice(values));
    let shape = (whole.len() / columns, columns);
    if is_first { Array2::from_shape_vec(shape, whole).ok() } else { None }
}

/// Returns the SHA-256 of a field, row by row, from the rows of each process; only the first process gets it.
pub fn checksum(share: &Share, own: &[f64]) -> String {
    let columns = own.len() / share.rows().len();
    let mut sum = Checksum::default();
    share.to_first(own, columns, height(columns), |_, values| {
        values.iter().for_each(|value| sum.bytes(&value.to_le_bytes()));
    });
    sum.text()
}

/// Writes a variable along x and y to the `archive`, which only the first process has.
///
/// # Errors
/// Returns an error, at the first process, if the file cannot be written.
pub fn write_all(
    share: &Share,
    own: ArrayView2<f64>,
    mut archive: Option<&mut Archive>,
    path: &str,
    variable: &Variable,
) -> Result<(), Failure> {
    if let (Some(archive), true) = (&mut archive, share.is_whole()) {
        return Ok(archive.write(path, variable, &contiguous(&own))?);
    }
    let defined = archive.as_mut().map_or(Ok(()), |archive| archive.define_rows(path, variable));
    let written = write(share, own, archive, (path, None), |_| {});
    defined?;
    written
}

/// Writes a field to the `archive`, which only the first process has: the variable `path`, or its entry `index`. `see`
/// gets the values in order. All rows travel, even if they cannot be written.
///
/// # Errors
/// Returns an error, at the first process, if the file cannot be written.
pub fn write(
    share: &Share,
    own: ArrayView2<f64>,
    mut archive: Option<&mut Archive>,
    (path, index): (&str, Option<usize>),
    mut see: impl FnMut(&[f64]),
) -> Result<(), Failure> {
    let (columns, own) = (own.ncols(), contiguous(&own));
    if share.is_whole() {
        // A profile has one column, its share one row.
        see(&own);
        let Some(archive) = archive else { return Ok(()) };
        return Ok(match index {
            Some(index) => archive.write_slab(path, index, &own),
            None => archive.write_rows(path, None, 0, &own),
        }?);
    }
    let mut written = Ok(());
    share.to_first(&own, columns, height(columns), |rows, values| {
        see(values);
        if let (Some(archive), Ok(())) = (&mut archive, &written) {
            written = archive.write_rows(path, index, rows.start, values);
        }
    });
    Ok(written?)
}
