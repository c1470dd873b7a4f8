//! Flash temperature: the surface temperature of a body under a steadily sliding heat source.
//!
//! - [`Thermal`]: conductivity and diffusivity of a body.
//! - [`Flash`]: a source that moves over a body. With a second body, in which the source rests, the heat is shared such
//!   that both surfaces have the same temperature at every heated point.
//! - [`Heated`]: heat flux into the body, temperature, and scalar results.
//!
//! In the frame of the source, a wave q of the heat flux Q (per area and time) causes the temperature
//! Q/(k √(q² − i q·v/α)), where the root has a positive real part (theory.md, section 7.11). A uniform flux has no
//! steady state: temperatures are relative to the mean of the surface.
//!
//! ```
//! use gfmd_field::Grid;
//! use gfmd_heat::{Flash, Thermal};
//! use gfmd_relax::Budget;
//! use ndarray::Array2;
//!
//! // A strip that is heated and moves along x: it is warmest at its trailing end.
//! let grid = Grid::line(256, 1.0)?;
//! let flux = Array2::from_shape_fn((256, 1), |(i, _)| if (96..160).contains(&i) { 1.0 } else { 0.0 });
//! let steel = Thermal::new(50.0, 1.0)?;
//! let state = Flash::new(grid, [400.0, 0.0], steel, None)?.heat(&flux, &Budget::default(), &mut ())?;
//! assert!(state.temperature[[96, 0]] > 2.0 * state.temperature[[150, 0]]);
//! assert_eq!(state.fraction, 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Other crates compute the pressure and the friction that produce the heat (`gfmd-viscoelastic`).

mod error;
mod flash;
mod memory;
mod search;
mod thermal;

pub use error::HeatError;
pub use flash::{Flash, Heated};
pub use gfmd_relax::{Budget, Watch};
pub use thermal::Thermal;
