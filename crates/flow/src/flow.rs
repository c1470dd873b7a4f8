use gfmd_field::Grid;
use gfmd_measure::Boundary;
use ndarray::{Array2, ArrayView2};

use crate::cells::{Balance, Cells, conducting};
use crate::numbering::Numbering;
use crate::search::{Found, TOLERANCE, search};

/// Flow under a unit mean gradient along one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Deviation of the potential from its mean gradient −1 along the axis, in length; zero where nothing flows.
    pub potential: Array2<f64>,
    /// Magnitude of the flux: flow per width.
    pub flux: Array2<f64>,
    /// Number of iterations.
    pub iterations: usize,
}

/// Flow through a field of conductivities.
#[derive(Clone, Debug, PartialEq)]
pub struct Flow {
    /// Mean flux along x and y (rows) under a unit mean gradient along x and y (columns), in the unit of the
    /// conductivities. Exactly zero for an axis along which no patch of conducting cells percolates.
    pub conductivity: [[f64; 2]; 2],
    /// True along x (y) if something flows along this axis.
    pub percolates: [bool; 2],
    /// Largest of three relative deviations, computed from the potential face by face: the flow missing in the balance
    /// of a cell, divided by the mean flow through a face of a section; the flow through a section x = const (y = const
    /// for a gradient along y) from the mean flow; the dissipated power from the flow.
    pub residual: f64,
    /// Flow along x and along y; `None` without percolation.
    pub paths: [Option<Path>; 2],
}

/// Error of a flow computation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FlowError {
    /// Conductivities with a different shape than the grid.
    #[error("the conductivities have {found:?} points; they must have {expected:?} as the grid")]
    Shape {
        /// Shape of the conductivities.
        found: [usize; 2],
        /// Shape of the grid.
        expected: [usize; 2],
    },
    /// Too few points along an axis, or too many points in all.
    #[error("the grid has {0:?} points; a flow needs at least 2 along each axis, and less than 2^32 in all")]
    Points([usize; 2]),
    /// Negative or non-finite conductivity.
    #[error("the conductivity at {index:?} is {value}; it must be finite and not negative")]
    Conductivity {
        /// Indices of the point.
        index: [usize; 2],
        /// Conductivity at this point.
        value: f64,
    },
    /// Balance that does not meet [`TOLERANCE`].
    #[error(
        "the flow did not converge to {TOLERANCE:e} in {iterations} iterations: its residual is {:.1e}",
        state.residual
    )]
    NotConverged {
        /// Flow reached.
        state: Box<Flow>,
        /// Number of iterations.
        iterations: usize,
    },
}

/// Computes the flow through `conductivity` `[x, y]`, in any unit, zero where nothing passes. A non-periodic field has
/// reservoirs at two opposite edges and walls at the other two.
///
/// # Errors
/// Returns an error if conductivities are unusable or if the balance does not meet [`TOLERANCE`].
pub fn flow(grid: &Grid, conductivity: ArrayView2<f64>, boundary: Boundary) -> Result<Flow, FlowError> {
    let (found, expected) = (conductivity.dim().into(), grid.points());
    if found != expected {
        return Err(FlowError::Shape { found, expected });
    }
    if expected.contains(&1) || u32::try_from(grid.len()).is_err() {
        return Err(FlowError::Points(expected));
    }
    if let Some(((i, j), &value)) = conductivity.indexed_iter().find(|(_, k)| !(k.is_finite() && **k >= 0.0)) {
        return Err(FlowError::Conductivity { index: [i, j], value });
    }
    // The largest conductivity is the unit.
    let unit = conductivity.iter().copied().fold(0.0, f64::max);
    let scaled: Vec<f64> = conductivity.iter().map(|k| if *k > 0.0 { k / unit } else { 0.0 }).collect();
    let scaled_field = ArrayView2::from_shape(expected, &scaled).map_err(|_| FlowError::Shape { found, expected })?;
    let patches = conducting(scaled_field, boundary);
    let percolates = patches.percolate();
    // Usually the same patches conduct along both axes.
    let chosen = [0, 1].map(|axis| patches.patches.iter().map(|patch| patch.percolates[axis]).collect::<Vec<bool>>());
    let numbering = |axis: usize| Numbering::new(grid, boundary, &patches, &chosen[axis]);
    let along_x = numbering(0);
    let along_y = (chosen[0] != chosen[1]).then(|| numbering(1));
    let numberings = [&along_x, along_y.as_ref().unwrap_or(&along_x)];
    let [x, y] = [0, 1].map(|axis| Cells::new(grid, &scaled, boundary, numberings[axis], axis));
    let solved = |cells: &Cells, found, iterations| Solved::new(cells, found, iterations, expected, unit);
    let solved: [Option<Solved>; 2] = if percolates == [true; 2] && x.has_equations_of(&y) {
        let ([of_x, of_y], iterations) = search([&x, &y]);
        rayon::join(|| Some(solved(&x, of_x, iterations)), || Some(solved(&y, of_y, iterations))).into()
    } else {
        [x, y].map(|cells| {
            percolates[cells.axis()].then(|| {
                let ([found], iterations) = search([&cells]);
                solved(&cells, found, iterations)
            })
        })
    };
    let mut state = Flow { conductivity: [[0.0; 2]; 2], percolates, residual: 0.0, paths: [None, None] };
    let mut iterations = 0;
    for (axis, solved) in solved.into_iter().enumerate() {
        let Some(Solved { flux, residual, path }) = solved else { continue };
        [0, 1].into_iter().for_each(|row| state.conductivity[row][axis] = flux[row]);
        state.residual = if residual.is_nan() { residual } else { state.residual.max(residual) };
        iterations = iterations.max(path.iterations);
        state.paths[axis] = Some(path);
    }
    if state.residual <= TOLERANCE {
        Ok(state)
    } else {
        Err(FlowError::NotConverged { state: state.into(), iterations })
    }
}

/// Flow along one axis.
struct Solved {
    flux: [f64; 2],
    residual: f64,
    path: Path,
}

impl Solved {
    fn new(cells: &Cells, found: Found, iterations: usize, shape: [usize; 2], unit: f64) -> Self {
        let Found { potential, balance: Balance { mut flux, power, residual, .. } } = found;
        flux[cells.axis()] = power;
        let field = |values: Vec<f64>| Array2::from_shape_vec(shape, values).expect("a value for each point");
        let fluxes = cells.flux(&potential).into_iter().map(|flux| flux * unit).collect();
        let path = Path { potential: field(cells.spread(&potential)), flux: field(fluxes), iterations };
        Self { flux: flux.map(|flux| flux * unit), residual, path }
    }
}
