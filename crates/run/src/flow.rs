//! Flow of a fluid through the gap of a contact, by Reynolds' equation.

use gfmd_flow::{Flow, FlowError, Wanted, flow};
use ndarray::{Array2, ArrayView2, Zip};

use gfmd_input::failure::Failure;
use gfmd_input::source::Surface;

/// Computes the flow through the gap, relative to a uniform gap equal to the mean gap; points with a positive
/// `pressure` are closed. Soft surfaces may overlap so far that their mean gap is not positive. The flow is then
/// relative to a uniform gap equal to the largest one, and only its paths have a meaning. Only [`Wanted::Fields`] gives
/// paths. `warn` receives a message if the flow is less exact than it should be.
///
/// # Errors
/// Returns an error if the flow cannot be computed.
pub fn through(
    surface: &Surface,
    [pressure, gap]: [ArrayView2<f64>; 2],
    mean_gap: f64,
    wanted: Wanted,
    warn: impl FnOnce(String),
) -> Result<Flow, Failure> {
    let scale = if mean_gap > 0.0 { mean_gap } else { gap.fold(f64::MIN_POSITIVE, |largest, gap| largest.max(*gap)) };
    let mut cubes = Array2::zeros(gap.dim());
    Zip::from(&mut cubes).and(gap).and(pressure).for_each(|cube, gap, p| {
        *cube = if *p > 0.0 || *gap <= 0.0 { 0.0 } else { (gap / scale).powi(3) };
    });
    match flow(&surface.grid, cubes.view(), surface.boundary, wanted) {
        Err(FlowError::NotConverged { state, .. }) => {
            warn(format!("the residual of the flow is {:.1e}", state.worst()));
            Ok(*state)
        }
        found => found.map_err(|error| Failure::computation(error.to_string())),
    }
}
