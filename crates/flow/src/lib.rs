//! Flow through a thin gap, or current through a thin layer: div(k ∇p) = 0 with a unit mean gradient along x and along
//! y.
//!
//! For a fluid between two surfaces, k is the cube of the gap (Reynolds equation); it is zero where they touch. The
//! equation is balanced cell by cell (finite volumes): a cell surrounds each point, and the conductance of the face
//! between two cells is the harmonic mean of their k, which is exact for layers in series and in parallel (theory.md,
//! section 9.1). Conjugate gradients are preconditioned by an approximate elimination of the cells, block by block on
//! all threads. Its quality does not depend on the shape or the contrast of channels and dams.
//!
//! ```
//! use gfmd_field::Grid;
//! use gfmd_flow::{Boundary, flow};
//! use ndarray::Array2;
//!
//! // Channels along x, of conductivity 1 and 3 in turn.
//! let grid = Grid::square(16, 1.0)?;
//! let channels = Array2::from_shape_fn((16, 16), |(_, j)| if j % 4 < 2 { 1.0 } else { 3.0 });
//! let found = flow(&grid, channels.view(), Boundary::Periodic)?;
//! let [[along, _], [_, across]] = found.conductivity;
//! assert!((along - 2.0).abs() < 1e-6 && (across - 1.5).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Other crates provide the gap (`gfmd-contact`) and labels of patches (`gfmd-measure`).

mod cells;
mod elimination;
mod flow;
mod graph;
mod halved;
mod numbering;
mod queue;
mod remaining;
mod search;

/// Number of cells or graph nodes in a part. Sums are formed within parts first, so that they do not depend on the
/// number of threads.
const PART: usize = 1 << 12;

pub use flow::{Flow, FlowError, Path, flow};
pub use gfmd_measure::Boundary;
pub use search::TOLERANCE;
