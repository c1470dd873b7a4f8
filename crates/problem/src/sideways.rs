//! Lateral displacement of a surface without lateral traction.

use std::sync::Arc;

use gfmd_contact::{Boundary, Fields, Refusal};
use gfmd_field::{Grid, Share};
use gfmd_green::Body;
use gfmd_response::{FreeFullCompliance, FreeFullTransforms, FullResponse, FullTransforms};
use ndarray::Array2;

/// Response of the lateral displacement to the pressure, with the boundary of the contact.
pub(crate) enum Sideways {
    Cell(Arc<FullResponse>),
    Patch(Arc<FreeFullCompliance>),
}

impl Sideways {
    /// Creates the response of `body` on `grid`, for the rows of this process.
    ///
    /// # Errors
    /// Returns an error for a patch of a profile, or of a body without lateral support.
    pub(crate) fn new(boundary: Boundary, share: &Share, grid: &Grid, body: &Body) -> Result<Self, Refusal> {
        Ok(match boundary {
            Boundary::Periodic => Self::Cell(FullResponse::distributed(*grid, body, share).into()),
            Boundary::Free => Self::Patch(FreeFullCompliance::distributed(*grid, body, share)?.into()),
        })
    }

    /// Returns u_x and u_y (u_x of a profile) `[x, y]`, length, by the pressure of a state.
    pub(crate) fn displacement(&self, state: &dyn Fields) -> Vec<Array2<f64>> {
        let pressure = state.pressure();
        let (shape, points) = (pressure.dim(), pressure.len());
        let components = match self {
            Self::Cell(response) => response.components(),
            Self::Patch(response) => response.components(),
        };
        let normal = components.normal() * points;
        let mut traction = vec![0.0; components.len() * points];
        traction[normal..].iter_mut().zip(pressure.iter()).for_each(|(traction, pressure)| *traction = -pressure);
        let mut displacement = vec![0.0; traction.len()];
        match self {
            Self::Cell(response) => FullTransforms::of(response).compliance(&traction, &mut displacement),
            Self::Patch(response) => FreeFullTransforms::of(response).compliance(&traction, &mut displacement),
        }
        let lateral = displacement[..normal].chunks_exact(points);
        lateral.map(|field| Array2::from_shape_fn(shape, |(i, j)| field[i * shape.1 + j])).collect()
    }
}
