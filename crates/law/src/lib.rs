//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! | law                                        | modes              | energy          | hard wall |
//! |--------------------------------------------|--------------------|-----------------|-----------|
//! | [`HardWall`]                               | normal             | yes             | yes       |
//! | [`Morse`], [`HarmonicCosine`]              | normal             | yes             | no        |
//! | [`Exponential`], [`Dugdale`]               | normal             | yes             | yes       |
//! | [`Tabulated`]                              | normal             | yes             | if it begins at gap 0 |
//! | [`XuNeedleman`]                            | normal, tangential | yes             | no        |
//! | [`BoschSchreursGeers`], [`Npc`]            | normal, tangential | if φ_n = φ_t    | no        |
//! | [`CoupledExponential`] (C3D), [`Npb`]      | normal, tangential | no              | no        |
//! | [`Friction`]: Coulomb, Tresca              | tangential         | needs a history |           |
//!
//! The separation is measured from the elastic to the rigid surface: normal Δ_n = gap, open > 0; tangential Δ_t. The
//! traction acts *on the elastic surface*: T_n > 0 attracts, T_t points along Δ_t; T = ∂Φ/∂Δ if a potential Φ (energy
//! per area) exists. All laws are isotropic: T_t is parallel to Δ_t and depends on its magnitude.

mod bosch_schreurs_geers;
mod coupled_exponential;
mod friction;
mod in_units;
mod kind;
mod law;
mod normal;
mod npc;
mod separation;
mod tabulated;
mod xu_needleman;

pub use bosch_schreurs_geers::BoschSchreursGeers;
pub use coupled_exponential::{CoupledExponential, Npb};
pub use friction::{Friction, Limit, Rate, Sliding};
pub use in_units::InUnits;
pub use kind::{Allowed, LawKind, Parameter};
pub use law::{Jacobian, Law, MixedMode, Opening, Response};
pub use normal::*;
pub use npc::Npc;
pub use separation::{LawError, Separation};
pub use tabulated::Tabulated;
pub use xu_needleman::XuNeedleman;
