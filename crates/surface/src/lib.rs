//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! | question                                           | start at                                     |
//! |----------------------------------------------------|----------------------------------------------|
//! | a periodic surface with this spectrum              | [`SelfAffine`], then [`SelfAffine::heights`] |
//! | heights with this distribution                     | [`Marginal`]                                 |
//! | the grid for these ε_t, ε_f, ε_c                   | [`Discretisation`]                           |
//! | rms height, gradient, curvature, Nayak's parameter | [`Statistics`]                               |
//! | power spectral density, Hurst exponent, cut-offs   | [`PowerSpectrum`]                            |
//! | height parameters of ISO 25178                     | [`Areal`]                                    |
//! | autocorrelation, distributions, bearing curve      | [`Texture`]                                  |
//! | hills, dales, direction, profile parameters        | [`Features`], [`Direction`], [`ProfileNumbers`] |
//! | a measured scan: take out tilt, make it periodic   | [`remove`], [`periodise`]                    |
//! | two rough surfaces that face each other            | [`composite`]                                |
//! | points of a scan without a height                  | [`remove_from_defined`], [`fill`]            |
//! | the spectrum of a scan that is not periodic        | [`window`], then [`PowerSpectrum`]           |
//! | midpoint displacement, random addition             | [`RealSpace`]                                |
//! | a sphere, cone, punch, wave from its closed form   | [`Shape`]                                    |
//!
//! Heights are `Array2<f64>` of shape `[nx, ny]`, index `[x, y]`; a profile is `[n, 1]`. Lengths are in any consistent
//! unit. Gradients are full gradients |∇h|, computed from the spectrum unless stated otherwise.
#![warn(missing_docs)]

mod discretisation;
mod marginal;
mod self_affine;
mod synthesis;

mod real_space;
mod shape;

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
pub use finer::{Interpolation, centred, finer, finer_inside};
pub use gfmd_field::Grid;
pub use marginal::{Marginal, MarginalError};
pub use moments::{Dimension, Moments};
pub use pair::{composite, composite_inside};
pub use power::{HurstFit, PowerSpectrum, RadialBin};
pub use preparation::{Periodisation, Trend, periodise, remove, remove_from_defined, row_mean, window, window_rows};
pub use real_space::{Displaced, RealSpace};
pub use self_affine::{Amplitudes, Anisotropy, Normalisation, RollOff, RollOffShape, Scaling, SelfAffine};
pub use shape::{Along, Shape, ShapeError};
pub use statistics::{Seam, Statistics};
pub use texture::{
    Autocorrelation, Bearing, Core, CorrelationLengths, Density, Direction, Distributions, Features, MotifEdges,
    Motifs, ProfileNumbers, Scales, Texture, Volumes,
};
