//! Periodic grids, the real fields on them, and their half-spectrum Fourier transforms.
//!
//! A field is a `[x, y]` array in row-major order (y contiguous), passed as a flat slice of `grid.len()` values. A line
//! (plane strain) is a grid with one point along y: same types, same calls.
//!
//! Start at [`Grid`], then [`Transform`]. Conventions are those of theory.md, section 0: `f(r) = Σ_q f̃(q) e^{+i q·r}`,
//! `f̃(q) = (1/N) Σ_r f(r) e^{−i q·r}`, and the spectrum of a real field is stored by half, [`Grid::modes`] says in
//! which order. Not here: what a kernel means (`gfmd-green`), where a field comes from (`gfmd-surface`).
#![warn(missing_docs)]

mod grid;
mod line;
mod plane;
mod prefetch;
mod share;
mod transform;

pub use grid::{Grid, GridError, Mode};
pub use transform::{ShapeError, Transform, Workspace};
