use gfmd_field::Grid;
use gfmd_measure::Surroundings;
use ndarray::{Array2, ArrayView2};

use crate::cells::{Balance, Cells, Potential, conducting};
use crate::elimination::Elimination;
use crate::graph::{dot, largest, zip};

/// The largest [residual](Flow::residual) of a flow.
pub const TOLERANCE: f64 = 1e-8;

/// Largest number of iterations. Some 60 are usual.
const ITERATIONS: usize = 1000;

/// Rounds of iterations, each from balances that are computed anew.
const ROUNDS: usize = 12;

/// The largest reduction of the error in a round, beyond which rounding counts.
const REDUCTION: f64 = 1e-10;

/// The part of the tolerance that the iterations of the first round leave; those of each further one leave this part of it.
const MARGIN: f64 = 0.3;

/// Iterations between two looks at what is missing.
const CHECKS: usize = 4;

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
    /// The largest of three relative deviations, computed from the potential face by face: what is missing in the balance of a cell,
    /// over the mean flow through a face of a section; the flow through a section x = const (of a gradient along y: y = const)
    /// from the mean flow; the dissipated power from the flow.
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
    let cells = [0, 1].map(|axis| Cells::new(grid, &scaled, surroundings, &patches, axis));
    let solved =
        |cells: &Cells, potential: &[Potential], iterations| Solved::new(cells, potential, iterations, expected, unit);
    let solved: [Option<Solved>; 2] = match &cells {
        // The equations are the same; their factors, too.
        [x, y] if percolates == [true; 2] && x.has_equations_of(y) => {
            let ([of_x, of_y], iterations) = solve([x, y]);
            rayon::join(|| Some(solved(x, &of_x, iterations)), || Some(solved(y, &of_y, iterations))).into()
        }
        [x, y] => {
            let along = |cells: &Cells| {
                percolates[cells.axis()].then(|| {
                    let ([potential], iterations) = solve([cells]);
                    solved(cells, &potential, iterations)
                })
            };
            rayon::join(|| along(x), || along(y)).into()
        }
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

/// The flow along one axis.
struct Solved {
    flux: [f64; 2],
    residual: f64,
    path: Path,
}

impl Solved {
    fn new(cells: &Cells, potential: &[Potential], iterations: usize, shape: [usize; 2], unit: f64) -> Self {
        let Balance { mut flux, power, residual } = cells.balance(potential);
        flux[cells.axis()] = power;
        let field = |values: Vec<f64>| Array2::from_shape_vec(shape, values).unwrap_or_default();
        let fluxes = cells.flux(potential).into_iter().map(|flux| flux * unit).collect();
        let path = Path { potential: field(cells.spread(potential)), flux: field(fluxes), iterations };
        Self { flux: flux.map(|flux| flux * unit), residual, path }
    }
}

/// The potentials of cells with the same equations under different gradients, and the number of iterations: conjugate gradients,
/// started again from balances that are computed anew.
fn solve<const N: usize>(cells: [&Cells; N]) -> ([Vec<Potential>; N], usize) {
    let graph = cells[0].graph();
    let factors = Elimination::of(&graph);
    let (n, area) = (graph.len(), cells[0].area());
    let mut potentials: [Vec<Potential>; N] = std::array::from_fn(|_| vec![Potential::default(); n]);
    let [mut residual, mut step, mut direction, mut image, mut correction] = std::array::from_fn(|_| vec![[0.0; N]; n]);
    let (mut work, mut iterations) = (Vec::new(), 0);
    let mut balances: [Balance; N] = std::array::from_fn(|k| cells[k].balance(&potentials[k]));
    let mut margin = MARGIN;
    for _ in 0..ROUNDS {
        for (k, (cells, potential)) in cells.iter().zip(&potentials).enumerate() {
            let missing = cells.missing(potential);
            residual.iter_mut().zip(missing).for_each(|(residual, missing)| residual[k] = missing);
        }
        correction.fill([0.0; N]);
        let (mut first, mut last) = ([0.0; N], [0.0; N]);
        // Each iteration lowers the power by a known amount; what remains gives the flow, and so what may be missing in a cell.
        let mut power = balances.each_ref().map(|balance| balance.power);
        while iterations < ITERATIONS {
            factors.solve(&residual, &mut step, &mut work);
            let slope = dot(&residual, &step);
            if last == [0.0; N] {
                (first, last) = (slope, slope);
                direction.copy_from_slice(&step);
            } else {
                let beta: [f64; N] = std::array::from_fn(|k| if last[k] > 0.0 { slope[k] / last[k] } else { 0.0 });
                zip(&mut direction, &step, |d, z| (0..N).for_each(|k| d[k] = z[k] + beta[k] * d[k]));
                last = slope;
            }
            graph.apply(&direction, &mut image);
            let work_done = dot(&direction, &image);
            let length: [f64; N] =
                std::array::from_fn(|k| if work_done[k] > 0.0 { slope[k] / work_done[k] } else { 0.0 });
            zip(&mut correction, &direction, |p, d| (0..N).for_each(|k| p[k] += length[k] * d[k]));
            zip(&mut residual, &image, |r, image| (0..N).for_each(|k| r[k] -= length[k] * image[k]));
            iterations += 1;
            (0..N).for_each(|k| power[k] -= length[k] * slope[k] / area);
            let enough = |k: usize| {
                let allowed = margin * TOLERANCE * power[k] * cells[k].width();
                slope[k] <= REDUCTION * REDUCTION * first[k] || largest(&residual, k) <= allowed
            };
            if iterations % CHECKS == 0 && (0..N).all(enough) {
                break;
            }
        }
        let mut done = true;
        for (k, (cells, potential)) in cells.iter().zip(&mut potentials).enumerate() {
            potential.iter_mut().zip(&correction).for_each(|(potential, c)| potential.add(c[k]));
            balances[k] = cells.balance(potential);
            done &= balances[k].residual <= TOLERANCE;
        }
        margin *= MARGIN;
        if done || iterations >= ITERATIONS {
            break;
        }
    }
    (potentials, iterations)
}
