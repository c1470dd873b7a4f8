use std::sync::Arc;

use gfmd_contact::RigidSurface;
use gfmd_field::Grid;

/// Periodic cell for a patch with free boundaries: the patch and empty surface beside it, with twice the points along
/// each axis. There the rigid surface is so [far](FAR) away that neither law nor wall acts (theory.md, section 8.1).
/// The patch is the first part of the first rows.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    points: [usize; 2],
    cell: [usize; 2],
    /// Clearance of the whole cell.
    clearance: Arc<[f64]>,
}

/// Clearance outside the patch, in the units of the solve, where heights are of order 1: every law vanishes there, and
/// its ninth power does not overflow.
const FAR: f64 = 1e30;

impl Patch {
    /// Creates the patch of `surface` in its cell.
    pub(crate) fn of(surface: &RigidSurface, cell: &Grid) -> Self {
        let points = surface.grid().points();
        let patch = Self { points, cell: cell.points(), clearance: Arc::default() };
        let mut clearance = vec![FAR; cell.len()];
        patch.place(surface.clearance().iter().copied(), &mut clearance);
        Self { clearance: clearance.into(), ..patch }
    }

    pub(crate) fn clearance(&self) -> &[f64] {
        &self.clearance
    }

    /// Returns the number of points of the patch.
    pub(crate) fn len(&self) -> usize {
        self.points[0] * self.points[1]
    }

    /// Returns the index in the cell of point `i` of the patch.
    pub(crate) fn place_of(&self, i: usize) -> usize {
        i / self.points[1] * self.cell[1] + i % self.points[1]
    }

    /// Writes the values on the patch into the fields of the cell, field by field.
    pub(crate) fn place(&self, values: impl IntoIterator<Item = f64>, fields: &mut [f64]) {
        let (patch, cell) = (self.len(), self.cell[0] * self.cell[1]);
        for (i, value) in values.into_iter().enumerate() {
            fields[i / patch * cell + self.place_of(i % patch)] = value;
        }
    }

    /// Returns the values on the patch from the fields of the cell, field by field.
    pub(crate) fn inside(&self, fields: &[f64]) -> Vec<f64> {
        let [nx, ny] = self.points;
        let rows =
            fields.chunks_exact(self.cell[0] * self.cell[1]).flat_map(|field| field.chunks(self.cell[1]).take(nx));
        rows.flat_map(|row| &row[..ny]).copied().collect()
    }
}
