//! Variables of a step between two Newton steps, for its checkpoint.

use gfmd_field::Share;
use gfmd_relax::Visit;
use gfmd_vector::with_contiguous;
use ndarray::Array2;

use crate::cells::Mesh;
use crate::operator::CellFields;
use crate::volume::COMPONENTS;

/// Start of the next trial: what the last evaluation found.
pub(crate) struct Start {
    /// Strain of the cells that may yield.
    pub(crate) strain: CellFields<f64>,
    pub(crate) pressure: Array2<f64>,
    /// Error of the energy by the residuals of the contact.
    pub(crate) noise: f64,
    /// Energy, the least so far.
    pub(crate) least: f64,
    /// Residual; `None` for the first evaluation.
    pub(crate) residual: Option<f64>,
}

impl Start {
    /// Returns a start that a checkpoint fills.
    pub(crate) fn empty(mesh: &Mesh) -> Self {
        let pressure = Array2::zeros(mesh.surface_shape());
        Self { strain: vec![Vec::new(); mesh.cells.len()], pressure, noise: 0.0, least: 0.0, residual: Some(0.0) }
    }

    /// Visits the start, and the change of the strain by the Newton step from it.
    pub(crate) fn visit(&mut self, change: &mut CellFields<f32>, mesh: &Mesh, visitor: &mut dyn Visit) {
        let Self { strain, pressure, noise, least, residual } = self;
        visitor.numbers(&mut [noise, least]);
        residual.iter_mut().for_each(|residual| visitor.number(residual));
        with_contiguous(pressure, |pressure| visitor.rows(&mesh.division.surface, pressure));
        visit_cells(strain, mesh, visitor, |visitor, share, field| visitor.rows(share, field));
        visit_cells(change, mesh, visitor, |visitor, share, field| visitor.single_rows(share, field));
    }
}

/// Visits the fields of cells.
fn visit_cells<T: Copy + Default>(
    fields: &mut CellFields<T>,
    mesh: &Mesh,
    visitor: &mut dyn Visit,
    visit: impl Fn(&mut dyn Visit, &Share, &mut [T]),
) {
    fields.resize(mesh.cells.len(), Vec::new());
    let own: Vec<bool> = fields.iter().map(|field| !field.is_empty()).collect();
    for (cell, mut has_field) in mesh.division.any(&own).into_iter().enumerate() {
        let (field, share, points) = (&mut fields[cell], mesh.division.of(cell), mesh.division.points(cell));
        visitor.flag(&mut has_field);
        field.resize(if has_field { COMPONENTS * points } else { 0 }, T::default());
        let mut rest = &mut field[..];
        for _ in 0..if has_field { COMPONENTS } else { 0 } {
            let (component, after) = std::mem::take(&mut rest).split_at_mut(points);
            visit(visitor, share, component);
            rest = after;
        }
    }
}
