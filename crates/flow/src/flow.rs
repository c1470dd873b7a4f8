use gfmd_field::Grid;
use gfmd_measure::Boundary;
use ndarray::{Array2, ArrayView2};

use crate::cells::{Axes, Cells, conducting, larger};
use crate::numbering::Numbering;
use crate::search::{Search, TOLERANCE, Wanted, search};

/// Fields of the flow under a unit mean gradient along one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Deviation of the potential from its mean gradient −1 along the axis, in length; zero where nothing flows.
    pub potential: Array2<f64>,
    /// Magnitude of the flux: flow per width.
    pub flux: Array2<f64>,
    /// Largest of three relative deviations, computed from the potential face by face: the flow missing in the balance
    /// of a cell, divided by the mean flow through a face of a section; the flow through a section x = const (y = const
    /// for a gradient along y) from the mean flow; the dissipated power from the flow.
    pub residual: f64,
}

/// Flow through a field of conductivities.
#[derive(Clone, Debug, PartialEq)]
pub struct Flow {
    /// Mean flux along x and y (rows) under a unit mean gradient along x and y (columns), in the unit of the
    /// conductivities. Exactly zero along an axis along which no patch of conducting cells percolates; in a periodic
    /// field also across it. An entry on the diagonal is not smaller than the conductivity of the network of cells, and
    /// exceeds it by at most the part `residual` of itself. The others are known to this part of the geometric mean of
    /// the two powers.
    pub conductivity: [[f64; 2]; 2],
    /// True along x (y) if something flows along this axis.
    pub percolates: [bool; 2],
    /// Distance between an upper and a lower bound of the conductivity along an axis, divided by the conductivity; the
    /// larger of x and y. A non-periodic field has this residual also for the gradients across the reservoirs, divided
    /// by the larger of their dissipated power and the conductivity along the reservoirs.
    pub residual: f64,
    /// Number of iterations; the larger of both axes if they are solved one after the other.
    pub iterations: usize,
    /// Fields along x and along y; `None` without percolation, and for [`Wanted::Conductivity`].
    pub paths: [Option<Path>; 2],
}

impl Flow {
    /// Returns the largest residual of the conductivity and of the fields.
    pub fn worst(&self) -> f64 {
        self.paths.iter().flatten().fold(self.residual, |worst, path| larger(worst, path.residual))
    }
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
    /// Residual of the conductivity or of a field that does not meet [`TOLERANCE`].
    #[error(
        "the flow did not converge to {TOLERANCE:e} in {} iterations: its residual is {:.1e}",
        state.iterations,
        state.worst()
    )]
    NotConverged {
        /// Flow reached.
        state: Box<Flow>,
    },
}

/// Computes the flow through `conductivity` `[x, y]`, in any unit, zero where nothing passes. A non-periodic field has
/// reservoirs at two opposite edges and walls at the other two.
///
/// # Errors
/// Returns an error if conductivities are unusable or if a residual does not meet [`TOLERANCE`].
pub fn flow(grid: &Grid, conductivity: ArrayView2<f64>, boundary: Boundary, wanted: Wanted) -> Result<Flow, FlowError> {
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
    let unit = conductivity.iter().copied().fold(0.0, f64::max);
    let patches = conducting(conductivity, boundary);
    let values = conductivity.as_standard_layout();
    let values = values.as_slice().ok_or(FlowError::Shape { found, expected })?;
    let percolates = patches.percolate();
    let problem = Problem { grid, conductivity: values, boundary, wanted, unit };
    let numbering = |axis: usize| {
        let chosen: Vec<bool> = patches.patches.iter().map(|patch| patch.percolates[axis]).collect();
        Numbering::new(grid, boundary, &patches, &chosen)
    };
    let mut state = Flow { conductivity: [[0.0; 2]; 2], percolates, residual: 0.0, iterations: 0, paths: [None, None] };
    match (boundary, percolates) {
        (_, [false, false]) => {}
        // Loops of different patches do not cross, so that the same patches percolate along both axes.
        (Boundary::Periodic, [true, true]) => problem.solve([0, 1], 0, &numbering(0), &mut state),
        // No patch conducts along both axes: the other entries are zero.
        (Boundary::Periodic, [x, _]) => {
            let axis = usize::from(!x);
            problem.solve([axis], axis, &numbering(axis), &mut state);
        }
        (Boundary::Free, _) => {
            for axis in (0..2).filter(|axis| percolates[*axis]) {
                problem.solve([axis, 1 - axis], axis, &numbering(axis), &mut state);
            }
        }
    }
    if state.worst() <= TOLERANCE { Ok(state) } else { Err(FlowError::NotConverged { state: state.into() }) }
}

/// Data common to the gradients of a flow.
struct Problem<'a> {
    grid: &'a Grid,
    conductivity: &'a [f64],
    boundary: Boundary,
    wanted: Wanted,
    /// Largest conductivity, the unit of the cells.
    unit: f64,
}

impl Problem<'_> {
    /// Solves for the flows under these gradients in one network, and enters them into `state`.
    fn solve<const N: usize>(&self, gradients: [usize; N], reservoirs: usize, numbering: &Numbering, state: &mut Flow) {
        let cells = gradients.map(|gradient| {
            Cells::new(
                self.grid,
                (self.conductivity, self.unit),
                self.boundary,
                numbering,
                Axes { gradient, reservoirs },
            )
        });
        let Search { found, shared, iterations } = search(cells.each_ref(), self.wanted);
        state.iterations = state.iterations.max(iterations);
        let [first, last] = [gradients[0], gradients[N - 1]];
        state.conductivity[last][first] = shared * self.unit;
        if self.boundary == Boundary::Periodic {
            state.conductivity[first][last] = shared * self.unit;
        }
        for (cells, found) in cells.iter().zip(found) {
            state.residual = larger(state.residual, found.residual);
            if cells.is_across() {
                continue;
            }
            let axis = cells.axes().gradient;
            state.conductivity[axis][axis] = found.power * self.unit;
            if let Some((potential, residual)) = found.fields {
                let field = |values: Vec<f64>| {
                    Array2::from_shape_vec(self.grid.points(), values).expect("a value for each point")
                };
                let flux = cells.flux(&potential).into_iter().map(|flux| flux * self.unit).collect();
                let potential = field(cells.spread(&potential));
                state.paths[axis] = Some(Path { potential, flux: field(flux), residual });
            }
        }
    }
}
