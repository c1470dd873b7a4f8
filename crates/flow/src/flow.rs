use gfmd_field::Grid;
use gfmd_measure::Surroundings;
use ndarray::{Array2, ArrayView2};

use crate::cells::{Balance, Cells, conducting};
use crate::multigrid::{Multigrid, dot};

/// The largest [residual](Flow::residual) of a flow.
pub const TOLERANCE: f64 = 1e-4;

/// Largest number of iterations. Some 20 are usual.
const ITERATIONS: usize = 1000;

/// Iterations between two balances.
const CHECKS: usize = 4;

/// The residual at which iterations end.
const ENOUGH: f64 = 0.5 * TOLERANCE;

/// The flow under a unit mean gradient along one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    /// Deviation of the potential from its mean gradient −1 along the axis, times length; zero where nothing flows.
    pub potential: Array2<f64>,
    /// Magnitude of the flux: flow per width.
    pub flux: Array2<f64>,
    /// Number of iterations.
    pub iterations: usize,
}

/// The flow through a field of conductivities.
#[derive(Clone, Debug, PartialEq)]
pub struct Flow {
    /// The mean flux along x and y (rows) under a unit mean gradient along x and y (columns), in the unit of the
    /// conductivities. It is exactly zero for an axis along which no patch of conducting cells percolates.
    pub conductivity: [[f64; 2]; 2],
    /// True along x (y) if something flows.
    pub percolates: [bool; 2],
    /// The largest relative deviation of the flow through a section x = const (of a gradient along y: y = const) from the mean flow,
    /// of the dissipated power from the flow, and the size of what is missing in the balances of all cells, as the root of the power that it would
    /// cost over the dissipated power, computed from the potential face by face. The conductivity along a gradient is that of the
    /// power, of which the true potential has the least: this error enters squared.
    pub residual: f64,
    /// The flow along x and along y; none without percolation.
    pub paths: [Option<Path>; 2],
}

/// Reasons why there is no flow.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FlowError {
    /// Conductivities of another shape than the grid.
    #[error("the conductivities have {found:?} points; they must have {expected:?} as the grid")]
    Shape {
        /// The shape.
        found: [usize; 2],
        /// The shape of the grid.
        expected: [usize; 2],
    },
    /// Too few or too many points along an axis.
    #[error("the grid has {0:?} points; a flow needs at least 2 along each axis, and less than 2^32 in all")]
    Points([usize; 2]),
    /// A conductivity that is negative or not finite.
    #[error("the conductivity at {index:?} is {value}; it must be finite and not negative")]
    Conductivity {
        /// Its indices.
        index: [usize; 2],
        /// Its value.
        value: f64,
    },
    /// The balance is not good enough.
    #[error("the flow did not converge to {TOLERANCE:e} in {iterations} iterations: its residual is {:.1e}", state.residual)]
    NotConverged {
        /// The flow reached.
        state: Box<Flow>,
        /// Number of iterations.
        iterations: usize,
    },
}

/// The flow through `conductivity` `[x, y]`, any unit, zero where nothing passes. A field that ends has reservoirs at two
/// opposite edges and walls at the two others.
///
/// # Errors
/// Unusable conductivities; a balance that is not met to [`TOLERANCE`].
pub fn flow(grid: &Grid, conductivity: ArrayView2<f64>, surroundings: Surroundings) -> Result<Flow, FlowError> {
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
    // The largest is the unit.
    let unit = conductivity.iter().copied().fold(0.0, f64::max);
    let scaled: Vec<f64> = conductivity.iter().map(|k| if *k > 0.0 { k / unit } else { 0.0 }).collect();
    let scaled_field = ArrayView2::from_shape(expected, &scaled).map_err(|_| FlowError::Shape { found, expected })?;
    let patches = conducting(scaled_field, surroundings);
    let percolates = patches.percolate();
    let along = |axis: usize| {
        percolates[axis].then(|| Solved::new(&Cells::new(grid, &scaled, surroundings, &patches, axis), expected, unit))
    };
    let solved: [Option<Solved>; 2] = rayon::join(|| along(0), || along(1)).into();
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

/// The flow along one axis.
struct Solved {
    flux: [f64; 2],
    residual: f64,
    path: Path,
}

impl Solved {
    /// Conjugate gradients, flexible since the preconditioner is not linear.
    fn new(cells: &Cells, shape: [usize; 2], unit: f64) -> Self {
        let n = cells.len();
        let area = cells.area();
        let mut multigrid = Multigrid::new(cells.graph());
        let source = cells.source();
        let mut residual = source.clone();
        let [mut potential, mut direction, mut image, mut step, mut before] = std::array::from_fn(|_| vec![0.0; n]);
        let (mut last, mut iterations) = (0.0, 0);
        while iterations < ITERATIONS {
            multigrid.precondition(&residual, &mut step);
            let slope = dot(&residual, &step);
            if iterations % CHECKS == 0 && cells.balance(&potential).with(slope, area).residual <= ENOUGH {
                break;
            }
            let beta = if iterations == 0 { 0.0 } else { (slope - dot(&before, &step)) / last };
            last = slope;
            direction.iter_mut().zip(&step).for_each(|(d, z)| *d = z + beta * *d);
            multigrid.graph().apply(&direction, &mut image);
            let length = dot(&residual, &direction) / dot(&direction, &image);
            if !length.is_finite() {
                break;
            }
            before.copy_from_slice(&residual);
            for (((p, r), d), image) in potential.iter_mut().zip(&mut residual).zip(&direction).zip(&image) {
                *p += length * d;
                *r -= length * image;
            }
            iterations += 1;
        }
        multigrid.graph().apply(&potential, &mut image);
        residual.iter_mut().zip(&source).zip(&image).for_each(|((r, b), image)| *r = b - image);
        multigrid.precondition(&residual, &mut step);
        let slope = dot(&residual, &step);
        let Balance { mut flux, power, residual } = cells.balance(&potential).with(slope, area);
        flux[cells.axis()] = power;
        let field = |values: Vec<f64>| Array2::from_shape_vec(shape, values).unwrap_or_default();
        let fluxes = cells.flux(&potential).into_iter().map(|flux| flux * unit).collect();
        let path = Path { potential: field(cells.spread(&potential)), flux: field(fluxes), iterations };
        Self { flux: flux.map(|flux| flux * unit), residual, path }
    }
}
