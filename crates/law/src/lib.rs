//! Laws of adhesion, cohesion and friction: traction as a function of separation, point by point
//! ([theory.md](../gfmd/theory/index.html), section 8).
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
//!
//! ```
//! use gfmd_law::{Law, LawKind, Npb, Separation};
//!
//! let separation = Separation { normal_work: 1.0, tangential_work: 0.8, normal_length: 0.2, tangential_length: 0.3 };
//! let law = Npb::new(separation)?;
//! // Slip does not weaken the repulsion of surfaces that are pressed into each other.
//! assert_eq!(law.response(-0.1, 0.0).traction[0], law.response(-0.1, 0.9).traction[0]);
//! assert!(law.mixed_mode().is_some_and(|properties| properties.all()));
//!
//! let law = LawKind::Morse.with(&[("gamma", 1.0), ("range", 0.2)])?;
//! assert!((law.traction(0.1, [0.0; 2])[2] - 2.386_512_185).abs() < 1e-9);
//! assert_eq!(LawKind::Morse.with(&[("gamma", 1.0)]).unwrap_err().to_string(),
//!     "the law morse needs the parameter range (length, positive)");
//! # Ok::<(), gfmd_law::LawError>(())
//! ```
//!
//! Surfaces, bodies and equilibrium are in `gfmd-interface`.

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
pub use normal::{Dugdale, Exponential, HardWall, HarmonicCosine, Morse};
pub use npc::Npc;
pub use separation::{LawError, Separation};
pub use tabulated::Tabulated;
pub use xu_needleman::XuNeedleman;
