//! Periodic grids, real fields on them, and their half-spectrum Fourier transforms; [`Convolution`] and [`Cosines`] for
//! fields on a non-periodic patch.
//!
//! A field is a `[x, y]` array in row-major order (y contiguous), passed as a flat slice of `grid.len()` values. A line
//! (plane strain) is a grid with one point along y, with the same types and calls.
//!
//! Start with [`Grid`], then [`Transform`]. The conventions are `f(r) = Σ_q f̃(q) e^{+i q·r}` and
//! `f̃(q) = (1/N) Σ_r f(r) e^{−i q·r}` ([theory.md](../gfmd/theory/index.html), section 0). Half of the spectrum of a
//! real field is stored, in the order of [`Grid::modes`]. Other crates provide the kernels of elastic bodies
//! (`gfmd-green`) and rough surfaces (`gfmd-surface`).
//!
//! A cosine is one mode, and an operator that is diagonal in q multiplies it:
//!
//! ```
//! use gfmd_field::{Grid, Transform};
//! use num_complex::Complex64;
//!
//! let grid = Grid::new([32, 24], [2.0, 1.5])?;
//! let q = [3, -5].map(f64::from).map(|number| std::f64::consts::TAU * number);
//! let q = [q[0] / 2.0, q[1] / 1.5];
//! let [dx, dy] = grid.spacing();
//! let wave = |i: usize| (q[0] * (i / 24) as f64 * dx + q[1] * (i % 24) as f64 * dy).cos();
//! let field: Vec<f64> = (0..grid.len()).map(wave).collect();
//!
//! // Plans and memory are made once. The stored half has n ≥ 0, so this wave is found at the opposite numbers.
//! let transform = Transform::new(grid);
//! let mut ws = transform.workspace();
//! let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
//! transform.forward(&field, &mut spectrum, &mut ws)?;
//! for (mode, amplitude) in grid.modes().zip(&spectrum) {
//!     let expected = if mode.number == [-3, 5] { 0.5 } else { 0.0 };
//!     assert!((amplitude - expected).norm() < 1e-15);
//! }
//!
//! // K = |q|/2, without a spectrum in between; and the energy (1/2N) Σ f (K f) from half a transform.
//! let kernel: Vec<f64> = grid.modes().map(|mode| mode.wavenumber() / 2.0).collect();
//! let k = q[0].hypot(q[1]) / 2.0;
//! let mut out = vec![0.0; grid.len()];
//! transform.convolve(&kernel, &field, &mut out, &mut ws)?;
//! assert!(out.iter().zip(&field).all(|(u, f)| (u - k * f).abs() < 1e-13));
//! let energy = transform.quadratic_form(&kernel, &field, &mut ws)? / 2.0;
//! assert!((energy - k / 4.0).abs() < 1e-13);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Why not `ndrustfft`
//!
//! This crate calls the plans of RustFFT and `realfft` directly. `ndrustfft` also uses these plans, but gives no access
//! to them, allocates for every lane of a real transform, and gathers and scatters the slow axis value by value. A
//! convolution on a large grid then takes about twice the time. Tests and benchmarks compare with it.
#![warn(missing_docs)]

mod convolution;
mod cosines;
mod distribute;
mod grid;
mod line;
mod plan;
mod plane;
mod prefetch;
mod real;
mod shared;
mod spline;
mod transform;

pub use convolution::Convolution;
pub use cosines::{CosineWorkspace, Cosines};
pub use gfmd_vector::{Rows, Share, Split, contiguous};
pub use grid::{Grid, GridError, Mode};
pub use plan::{ShapeError, Workspace};
pub use real::Real;
pub use spline::Spline;
pub use transform::Transform;
