//! Wear of a rigid rough surface that slides on an elastic body, or of the body: by Archard's law the depth lost grows
//! in proportion to the pressure and to the sliding distance.
//!
//! - [`WearContact`]: a hard wall that wears. A [`Drive`](gfmd_contact::Drive) gives the distance at which its load, or
//!   approach, is reached; the previous state is the start. Steps are implicit and stable at any length.
//! - [`WearState`]: the fields at one distance, the depth lost so far, and the energies.
//!
//! A wave runs in until the pressure is uniform:
//!
//! ```
//! use gfmd_contact::{Contact, Drive, Equilibrium, Fields, Load};
//! use gfmd_field::Grid;
//! use gfmd_green::{Body, Material};
//! use gfmd_wear::WearContact;
//! use ndarray::Array2;
//!
//! let grid = Grid::square(32, 1.0)?;
//! let wave = |i: usize| (std::f64::consts::TAU * i as f64 / 32.0).cos();
//! let heights = Array2::from_shape_fn((32, 32), |(i, j)| 0.01 * wave(i) * wave(j));
//! let body = Body::half_space(Material::from_contact_modulus(1.0, 0.5)?);
//! let contact = WearContact::new(Contact::new(&body, &grid, &heights)?, 1e-3)?;
//!
//! let load = Load::MeanPressure(0.01);
//! let mut state = contact.press(load).solve()?;
//! let fresh = state.summary();
//! for step in 1..=50 {
//!     state = contact.press(Drive::from(load).after(100.0 * f64::from(step))).starting_from(Some(&state)).solve()?;
//! }
//! let worn = state.summary();
//! assert!(fresh.area_fraction < 0.5 && worn.area_fraction == 1.0);
//! assert!(worn.max_pressure / 0.01 - 1.0 < 1e-6);
//! // The volume is the coefficient times load times distance.
//! assert!((state.volume / (1e-3 * 0.01 * 5000.0) - 1.0).abs() < 1e-12);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Not here: friction and its heat, debris, and wear of a body that relaxes.

mod contact;
mod state;

pub use contact::WearContact;
pub use state::WearState;
