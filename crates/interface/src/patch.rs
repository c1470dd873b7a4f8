use std::sync::Arc;

use gfmd_contact::RigidSurface;
use gfmd_field::Grid;

/// The periodic cell in which the problem of a patch with free boundaries is solved: the patch and, around it, an empty
/// surface twice as large, where the rigid surface is so [far](FAR) away that no law and no wall acts (theory.md,
/// section 8.1). Values of the patch are the first of the first rows.
#[derive(Clone, Debug)]
pub(crate) struct Patch {
    points: [usize; 2],
    cell: [usize; 2],
    has_level: bool,
    /// The clearance of the whole cell.
    clearance: Arc<[f64]>,
}

/// The clearance outside of the patch, in the units of the solve, in which heights are of the order of 1: every law has
/// faded away there, and a ninth power is still a number.
const FAR: f64 = 1e30;

impl Patch {
    /// The patch of `surface` in its cell.
    pub(crate) fn of(surface: &RigidSurface, cell: &Grid, has_level: bool) -> Self {
        let points = surface.grid().points();
        let patch = Self { points, cell: cell.points(), has_level, clearance: Arc::default() };
        let mut clearance = vec![FAR; cell.len()];
        patch.place(surface.clearance(), &mut clearance);
        Self { clearance: clearance.into(), ..patch }
    }

    /// False if the displacement is known up to a constant.
    pub(crate) fn has_level(&self) -> bool {
        self.has_level
    }

    pub(crate) fn clearance(&self) -> &[f64] {
        &self.clearance
    }

    /// Number of points of the patch.
    pub(crate) fn len(&self) -> usize {
        self.points[0] * self.points[1]
    }

    /// The place in the cell of point `i` of the patch.
    pub(crate) fn place_of(&self, i: usize) -> usize {
        i / self.points[1] * self.cell[1] + i % self.points[1]
    }

    /// Writes the values of the patch into a field of the cell.
    pub(crate) fn place<'a>(&self, values: impl IntoIterator<Item = &'a f64>, field: &mut [f64]) {
        values.into_iter().enumerate().for_each(|(i, value)| field[self.place_of(i)] = *value);
    }

    /// The values on the patch of the fields of the cell, one field after another.
    pub(crate) fn inside(&self, fields: &[f64]) -> Vec<f64> {
        let [nx, ny] = self.points;
        let rows =
            fields.chunks_exact(self.cell[0] * self.cell[1]).flat_map(|field| field.chunks(self.cell[1]).take(nx));
        rows.flat_map(|row| &row[..ny]).copied().collect()
    }
}
