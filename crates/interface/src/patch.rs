use std::ops::Range;
use std::sync::Arc;

use gfmd_contact::{Clearance, RigidSurface};
use gfmd_field::{Grid, Share};
use gfmd_vector::for_each;

/// Periodic cell for a patch with free boundaries: the patch and empty surface beside it, with twice the points along
/// each axis. There the rigid surface is so [far](FAR) away that neither law nor wall acts (theory.md, section 8.1).
/// The patch is the first part of the first rows. Several processes share the rows of the patch, and otherwise the rows
/// of the cell.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    /// Numbers of points of a row of the patch and of the cell.
    columns: [usize; 2],
    /// Points of the cell of this process.
    cell: usize,
    /// Rows of the patch of each process, and rows of the patch in the part of the cell of each process.
    rows: [Arc<[Range<usize>]>; 2],
    share: Share,
    /// Heights of the cell, with clearance below zero.
    heights: Arc<[f64]>,
}

/// Clearance outside the patch, in the units of the solve, where heights are of order 1: every law vanishes there, and
/// its ninth power does not overflow.
const FAR: f64 = 1e30;

impl Patch {
    /// Creates the patch of `surface` in its cell, with the rows of the cell of this process.
    pub(crate) fn of(surface: &RigidSurface, cell: &Grid, of_cell: &Share) -> Self {
        let (share, [nx, ny]) = (surface.share().clone(), surface.grid().points());
        let [_, wide] = cell.points();
        let inside = |rows: &Range<usize>| rows.start.min(nx)..rows.end.min(nx);
        let rows = match share.is_whole() {
            true => [std::iter::once(0..nx).collect(), std::iter::once(0..nx).collect()],
            false => [share.all_rows().iter().cloned().collect(), of_cell.all_rows().iter().map(inside).collect()],
        };
        let cell = of_cell.own().len();
        let patch = Self { columns: [ny, wide], cell, rows, share, heights: Arc::default() };
        let mut heights = vec![-FAR; cell];
        patch.place(surface.clearance().iter().map(|clearance| -clearance), &mut heights);
        Self { heights: heights.into(), ..patch }
    }

    /// Returns the clearance of the cell.
    pub(crate) fn clearance(&self) -> Clearance<'_> {
        Clearance::below(0.0, &self.heights)
    }

    /// Returns the number of points of the patch of this process.
    pub(crate) fn len(&self) -> usize {
        self.rows[0][self.rank()].len() * self.columns[0]
    }

    /// Returns the points of the patch of this process.
    pub(crate) fn share(&self) -> &Share {
        &self.share
    }

    /// Writes the values on the patch into the fields of the cell, field by field.
    pub(crate) fn place(&self, values: impl IntoIterator<Item = f64>, fields: &mut [f64]) {
        let values: Vec<f64> = values.into_iter().collect();
        let ([ny, wide], [patch, cell]) = (self.columns, &self.rows);
        for (values, field) in values.chunks_exact(self.len()).zip(fields.chunks_exact_mut(self.cell)) {
            let moved = (!self.share.is_whole()).then(|| self.share.moved(values, ny, [patch, cell]));
            let rows = moved.as_deref().unwrap_or(values).chunks_exact(ny);
            field.chunks_exact_mut(wide).zip(rows).for_each(|(row, values)| row[..ny].copy_from_slice(values));
        }
    }

    /// Returns the values on the patch from the fields of the cell, field by field.
    pub(crate) fn inside(&self, fields: &[f64]) -> Vec<f64> {
        fields.chunks_exact(self.cell).flat_map(|field| self.values(|at| field[at])).collect()
    }

    /// Returns the values of a function of the points of the cell on the patch.
    pub(crate) fn values(&self, of: impl Fn(usize) -> f64 + Sync) -> Vec<f64> {
        let ([ny, wide], [patch, cell]) = (self.columns, &self.rows);
        let mut values = vec![0.0; cell[self.rank()].len() * ny];
        for_each([&mut values[..]], &|start, [values]| {
            values.iter_mut().enumerate().for_each(|(k, value)| {
                let i = start + k;
                *value = of(i / ny * wide + i % ny);
            });
        });
        if self.share.is_whole() { values } else { self.share.moved(&values, ny, [cell, patch]) }
    }

    fn rank(&self) -> usize {
        self.share.ranks().rank()
    }
}
