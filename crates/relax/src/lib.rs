//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! | method                            | required of the problem          | suitable for                            |
//! |-----------------------------------|----------------------------------|-----------------------------------------|
//! | [`Verlet`], [`ModeDamped`]        | force, softest and stiffest mode | convex problems; [`Damping`] has rates  |
//! | [`Nesterov`]                      | force, stiffest mode             | convex problems                         |
//! | [`Fire`]                          | force, stiffest mode             | landscapes that are not convex          |
//! | [`PolonskyKeer`], [`ProjectedCg`] | action of a positive matrix      | [`Quadratic`], non-negative variables   |
//! | [`PreconditionedCg`]              | the same, and its near inverse   | [`Preconditioned`], [`Paired`] fields   |
//!
//! For all methods except conjugate gradients, a problem is a [`Landscape`]: energy, force, [`Bounds`], and a
//! dimensionless residual. A [`Method`] holds parameters, a [`State`] all variables. [`relax`] makes steps until
//! [`Stop`] is satisfied or an [`Observer`] ends the run. A [`Watch`] can keep checkpoints: every search visits its
//! variables ([`Visit`]) and resumes from them bit for bit. Results are bitwise equal for any number of threads.
//!
//! Example: a chain of springs between two fixed ends with a weight on every node, first free, then above a table:
//!
//! ```
//! use gfmd_relax::{Bounds, Landscape, Method, Outcome, Stop, Verlet, relax};
//!
//! struct Chain { weight: f64, table: Option<Vec<f64>>, length: usize }
//!
//! impl Landscape for Chain {
//!     fn len(&self) -> usize { self.length }
//!
//!     // U = ½ Σ (uᵢ₊₁ − uᵢ)² − weight Σ uᵢ, with u counted downwards.
//!     fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
//!         let at = |i: Option<usize>| i.and_then(|i| u.get(i)).copied().unwrap_or(0.0);
//!         let mut energy = 0.0;
//!         for (i, f) in force.iter_mut().enumerate() {
//!             *f = at(i.checked_sub(1)) - 2.0 * u[i] + at(Some(i + 1)) + self.weight;
//!             energy -= 0.5 * u[i] * (*f + self.weight);
//!         }
//!         energy
//!     }
//!
//!     fn bounds(&self) -> Bounds<'_> {
//!         self.table.as_deref().map_or(Bounds::Free, Bounds::Upper)
//!     }
//!
//!     fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
//!         self.bounds().natural_residual(u, force, self.weight, 1.0)
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let n = 9;
//! let mut chain = Chain { weight: 0.1, table: None, length: n };
//! // The modes of the chain: k = 4 sin²(π m / 2 (n + 1)), m = 1 … n.
//! let k = |m: usize| 4.0 * (std::f64::consts::PI * m as f64 / (2 * (n + 1)) as f64).sin().powi(2);
//! let method = Verlet::optimal(k(1), k(n))?;
//! let stop = Stop { residual: 1e-12, settled: 20, max_steps: 1000 };
//!
//! let mut state = method.start(&mut chain, vec![0.0; n])?;
//! assert!(matches!(relax(&mut chain, &method, &mut state, &stop, &mut ())?, Outcome::Converged(_)));
//! // A parabola: u = ½ weight i (n + 1 − i).
//! assert!((state.u[4] - 0.5 * 0.1 * 25.0).abs() < 1e-10);
//!
//! chain.table = Some(vec![0.8; n]);
//! let mut state = method.start(&mut chain, state.u)?;
//! relax(&mut chain, &method, &mut state, &stop, &mut ())?;
//! // Left of the table, half a parabola that touches it at i = 4: u = 0.8 − ½ weight (4 − i)².
//! assert!((state.u[0] - (0.8 - 0.05 * 9.0)).abs() < 1e-10 && state.u[3] == 0.8);
//! # Ok(())
//! # }
//! ```
//!
//! The mass is 1 for all entries. With an inertia matrix close to the stiffness matrix, convergence does not depend on
//! the problem size, but with projection the motion stops at a wrong point (theory.md, section 6.3). A [`Landscape`]
//! with bounds therefore has no inertia matrix: [`Smooth`] problems have no bounds, and [`AugmentedLagrangian`]
//! replaces bounds by a force.

mod anderson;
mod augmented_lagrangian;
mod bounds;
mod budget;
mod ceiling;
mod damping;
mod ending;
mod error;
mod fire;
mod harmonic;
mod inertia;
mod landscape;
mod memory_checkpoint;
mod mode_damped;
mod nesterov;
mod observer;
mod polonsky_keer;
mod preconditioned;
mod preconditioned_cg;
mod projected_cg;
mod quadratic;
mod run;
mod spectral_projected_gradient;
mod until;
mod verlet;
mod visit;
mod watch;
mod worst;

pub use anderson::Anderson;
pub use augmented_lagrangian::{AugmentedLagrangian, Proximal};
pub use bounds::Bounds;
pub use budget::{Budget, ToleranceError};
pub use ceiling::{Ceiling, Upper};
pub use damping::{Damping, Factors, Motion};
pub use ending::{Ending, Why};
pub use error::{Divergence, RelaxError};
pub use fire::{Fire, FireState, Flight, Uphill};
pub use harmonic::Harmonic;
pub use inertia::{Inertial, Smooth};
pub use landscape::Landscape;
pub use memory_checkpoint::MemoryCheckpoint;
pub use mode_damped::{ModeDamped, damped_by_parts};
pub use nesterov::{Momentum, Nesterov};
pub use observer::{Every, Observer};
pub use polonsky_keer::PolonskyKeer;
pub use preconditioned::{BLOCK, Preconditioned};
pub use preconditioned_cg::{Paired, PreconditionedCg};
pub use projected_cg::ProjectedCg;
pub use quadratic::{Iterate, Minimum, Optimality, Quadratic, Target};
pub use run::{Method, Outcome, State, Status, Stop, relax};
pub use spectral_projected_gradient::{Descended, OnConvexSet, SpectralProjectedGradient};
pub use until::relax_until;
pub use verlet::{OnRise, Trail, Verlet, VerletState};
pub use visit::{Variables, Visit};
pub use watch::{InnerWatch, Progress, Watch};
pub use worst::worst;
