//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! Fields are `[x, y]` arrays. Pressure is positive in compression and exactly zero out of contact. Formulas are
//! derived in theory.md.

mod area;
mod boundary;
mod distribution;
mod gas;
mod grid_error;
mod long_waves;
mod patches;
mod peak;
mod pressure;
mod quantile;
mod self_affine;
mod summary;
pub mod theory;

pub use area::{ContactArea, contact_area};
pub use boundary::{Boundary, UnknownBoundary};
pub use distribution::{Distribution, density_over_decades};
pub use gas::{GapGas, Gas, UnknownGasState};
pub use grid_error::{GridLimit, GridLimits, NoLimit, Refined};
pub use long_waves::{LEAST_LARGEST_LOAD, LongWaves};
pub use ndarray;
pub use patches::{Patch, Patches};
pub use peak::{Peak, top, top_inside, top_inside_of_shared, top_of_shared};
pub use pressure::{PressureStatistics, QUANTILE_LEVELS, ShapesDiffer, elastic_energy_density, pressure_statistics};
pub use quantile::quantile;
pub use self_affine::SelfAffineArea;
pub use summary::{Scales, Summary};

/// Returns the reduced pressure p* = p̄/(E* ḡ). `mean_pressure` and `contact_modulus` are in stress; `rms_gradient` is
/// the root mean square of |∇h| over the whole surface (theory.md, section 10).
pub fn reduced_pressure(mean_pressure: f64, contact_modulus: f64, rms_gradient: f64) -> f64 {
    mean_pressure / (contact_modulus * rms_gradient)
}

/// Returns the ratio κ = a_r/p* of contact area fraction to reduced pressure (theory.md, section 10).
pub fn kappa(area_fraction: f64, reduced_pressure: f64) -> f64 {
    area_fraction / reduced_pressure
}
