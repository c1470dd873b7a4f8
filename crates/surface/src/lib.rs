//! Rough surfaces and profiles: synthesis from a self-affine spectrum and a seed, and measured statistics
//! ([theory.md](../gfmd/theory/index.html), section 9).
//!
//! | question                                           | start at                                     |
//! |----------------------------------------------------|----------------------------------------------|
//! | a periodic surface with this spectrum              | [`SelfAffine`], then [`SelfAffine::heights`] |
//! | the grid for these ε_t, ε_f, ε_c                   | [`Discretisation`]                           |
//! | rms height, gradient, curvature, Nayak's parameter | [`Statistics`]                               |
//! | power spectral density, Hurst exponent, cut-offs   | [`PowerSpectrum`]                            |
//! | height parameters of ISO 25178                     | [`Areal`]                                    |
//! | autocorrelation, distributions, bearing curve      | [`Texture`]                                  |
//! | a measured scan: take out tilt, make it periodic   | [`remove`], [`periodise`]                    |
//! | two rough surfaces that face each other            | [`composite`]                                |
//! | points of a scan without a height                  | [`remove_from_defined`], [`fill`]            |
//! | the spectrum of a scan that is not periodic        | [`window`], then [`PowerSpectrum`]           |
//! | midpoint displacement, random addition             | [`RealSpace`]                                |
//!
//! Heights are `Array2<f64>` of shape `[nx, ny]`, index `[x, y]`; a profile is `[n, 1]`. Lengths are in any consistent
//! unit. Gradients are full gradients |∇h|, computed from the spectrum unless stated otherwise.
//!
//! ```
//! use gfmd_field::Grid;
//! use gfmd_surface::{Discretisation, PowerSpectrum, SelfAffine, Statistics};
//!
//! let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: 16.0, eps_c_inv: 4.0 };
//! let grid = Grid::square(numbers.points()?, 1.0)?; // 128 points along a side of length 1
//! let spectrum = SelfAffine { hurst: 0.8, ..SelfAffine::with_rms_gradient(0.1) };
//! let heights = numbers.self_affine(1.0, spectrum).heights(&grid, 42)?;
//!
//! let measured = Statistics::of(&heights, &grid)?;
//! assert!((measured.moments.rms_gradient() - 0.1).abs() < 1e-13);
//! let fit = PowerSpectrum::of(&heights, &grid)?.fit_hurst(1.0 / 2.0, 1.0 / 32.0)?;
//! assert!((fit.hurst - 0.8).abs() < 4.0 * fit.standard_error);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Related crates: `gfmd-files` reads files, `gfmd-contact` solves contacts, `gfmd-measure` evaluates them.
#![warn(missing_docs)]

mod discretisation;
mod self_affine;
mod synthesis;

mod real_space;

mod areal;
mod fill;
mod finer;
mod missing;
mod moments;
mod pair;
mod power;
mod preparation;
mod statistics;
mod texture;

mod error;
mod names;
mod random;

pub use areal::Areal;
pub use discretisation::Discretisation;
pub use error::SurfaceError;
pub use fill::{Fill, fill};
pub use finer::{Interpolation, finer};
pub use moments::{Dimension, Moments};
pub use pair::{composite, composite_inside};
pub use power::{HurstFit, PowerSpectrum, RadialBin};
pub use preparation::{Periodisation, Trend, periodise, remove, remove_from_defined, window};
pub use real_space::{Displaced, RealSpace};
pub use self_affine::{Amplitudes, Normalisation, RollOff, RollOffShape, Scaling, SelfAffine};
pub use statistics::{Seam, Statistics};
pub use texture::{Autocorrelation, Bearing, Core, CorrelationLengths, Density, Distributions, Scales, Texture};
