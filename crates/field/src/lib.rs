//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! A field is a `[x, y]` array in row-major order (y contiguous), passed as a flat slice of `grid.len()` values. A line
//! (plane strain) is a grid with one point along y, with the same types and calls.
//!
//! Start with [`Grid`], then [`Transform`]; [`Convolution`] and [`Cosines`] are for patches. The conventions are
//! `f(r) = Σ_q f̃(q) e^{+i q·r}` and `f̃(q) = (1/N) Σ_r f(r) e^{−i q·r}` (theory.md, section 0). Half of the spectrum
//! of a real field is stored, in the order of [`Grid::modes`].
//!
//! The spectrum of a cosine has one entry, and half a transform gives an energy:
//!
//! ```
//! use gfmd_field::{Complex64, Grid, Transform};
//!
//! let grid = Grid::line(32, 2.0)?;
//! let field: Vec<f64> = (0..32).map(|i| (std::f64::consts::TAU * 3.0 * f64::from(i) / 32.0).cos()).collect();
//! let transform = Transform::new(grid);
//! let mut ws = transform.workspace();
//! let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
//! transform.forward(&field, &mut spectrum, &mut ws)?;
//! for (mode, amplitude) in grid.modes().zip(&spectrum) {
//!     let expected = if mode.number[0].abs() == 3 { 0.5 } else { 0.0 };
//!     assert!((amplitude - expected).norm() < 1e-15);
//! }
//! // (1/2N) Σ f (K f) with K = |q|/2.
//! let kernel: Vec<f64> = grid.modes().map(|mode| mode.wavenumber() / 2.0).collect();
//! let energy = transform.quadratic_form(&kernel, &field, &mut ws)? / 2.0;
//! assert!((energy - 3.0 * std::f64::consts::PI / 8.0).abs() < 1e-13);
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
pub use num_complex::Complex64;
pub use plan::{ShapeError, Workspace};
pub use real::Real;
pub use spline::Spline;
pub use transform::Transform;
