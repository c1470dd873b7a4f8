//! Measured quantities of contact fields, and closed forms for comparison.
//!
//! Fields are `[x, y]` arrays. Pressure is positive in compression and exactly zero out of contact. The fields may come
//! from a solver or from a file. Formulas are derived in [theory.md](../gfmd/theory/index.html).
//!
//! ```
//! use gfmd_measure::{Boundary, contact_area, kappa, theory};
//! use ndarray::array;
//!
//! let pressure = array![[0.0, 0.0, 0.0, 0.0], [0.0, 2.0, 1.0, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]];
//! let area = contact_area(pressure.view(), Boundary::Periodic);
//! assert_eq!(area.nodes, 2);
//! assert_eq!(area.fraction, 2.0 / 16.0);
//! assert_eq!(area.boundary_links, 6);
//!
//! // At vanishing load Persson's theory says a_r = √(8/π) p*.
//! let p_star = 1e-6;
//! assert!((kappa(theory::persson_area(p_star), p_star) - (8.0 / std::f64::consts::PI).sqrt()).abs() < 1e-9);
//! ```
//!
//! Related crates: solvers (`gfmd-contact`), extrapolation of kappa over many contacts (`gfmd-sweep`, `gfmd-fit`).

mod area;
mod boundary;
mod distribution;
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
pub use grid_error::{GridLimit, GridLimits, NoLimit, Refined};
pub use long_waves::{LEAST_LARGEST_LOAD, LongWaves};
pub use patches::{Patch, Patches};
pub use peak::{Peak, top};
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
