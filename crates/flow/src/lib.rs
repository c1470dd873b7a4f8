//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! k is zero where the surfaces touch. The equation is balanced cell by cell (finite volumes): a cell surrounds each
//! point, and the conductance of the face between two cells is the harmonic mean of their k, which is exact for layers
//! in series and in parallel (theory.md, section 9.1). Conjugate gradients are preconditioned by an approximate
//! elimination of the cells, block by block on all threads. Its quality does not depend on the shape or the contrast of
//! channels and dams.

mod cells;
mod elimination;
mod flow;
mod fluid;
mod graph;
mod halved;
mod numbering;
mod potential;
mod queue;
mod remaining;
mod search;
mod tree;

/// Number of cells or graph nodes in a part. Sums are formed within parts first, so that they do not depend on the
/// number of threads.
const PART: usize = 1 << 12;

pub use flow::{Flow, FlowError, Path, flow};
pub use fluid::Fluid;
pub use gfmd_field::Grid;
pub use gfmd_measure::Boundary;
pub use ndarray;
pub use search::{TOLERANCE, Wanted};
