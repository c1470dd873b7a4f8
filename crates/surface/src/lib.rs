//! Rough surfaces and profiles: synthesis from a self-affine spectrum and a seed, and their measured statistics.
#![warn(missing_docs)]

mod discretisation;
mod error;
mod moments;
mod power;
mod random;
mod self_affine;
mod statistics;
mod synthesis;

pub use discretisation::Discretisation;
pub use error::SurfaceError;
pub use moments::{Dimension, Moments};
pub use power::{HurstFit, PowerSpectrum, RadialBin};
pub use self_affine::{Amplitudes, Normalisation, RollOff, Scaling, SelfAffine};
pub use statistics::{Seam, Statistics};
