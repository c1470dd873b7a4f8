//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! Start at [`Contact`]; use a free [`Boundary`] for a surface that does not repeat. Types common to all contacts are
//! [`RigidSurface`], [`Load`], [`Drive`], [`Solver`], [`Effort`], [`Equilibrium`] with its builder [`Press`],
//! [`Fields`] of a state, [`Refusal`] and [`SolveError`]. [`Quasistatic`] contacts can be followed along a path; states
//! of [`Resumable`] ones can be saved outside the process. [`Contact::in_all_components`] moves the surface sideways,
//! too, [`Contact::held_sideways`] holds it; [`Springs`] between the surfaces act point by point; [`Dynamics`] sets
//! time step and damping. [`SqueezedContact`] is a slab between two rigid surfaces, [`SteepContact`] allows finite
//! slopes, [`SteadyContact`] has a complex stiffness of each wave, and [`Conductors`] touch at the contact points of
//! any contact.
//!
//! | method                                  | unknown           | cost of a step     |
//! |-----------------------------------------|-------------------|--------------------|
//! | [`Solver::PreconditionedCg`] (default)  | pressure          | 2 transform pairs  |
//! | [`Solver::ProjectedCg`]                 | pressure          | 1½                 |
//! | [`Solver::PolonskyKeer`]                | pressure          | 1½                 |
//! | [`Solver::AugmentedLagrangian`]         | both              | 1                  |
//! | [`Solver::Verlet`], [`Solver::Fire`]    | displacement      | 1                  |
//! | [`Solver::VerletModes`]                 | displacement      | 2                  |

mod clearance;
mod effort;
mod equilibrium;
mod fields;
mod hardness;
mod load;
mod refusal;
mod rigid_surface;
mod solve_error;
mod solver;
mod springs;
mod units;

mod contact;
mod solution;

mod attempt;
mod compliance;
mod conductors;
mod dilute;
mod dual;
mod dynamics;
mod full;
mod gradient;
mod layer;
mod load_search;
mod pull_push;
mod quasistatic;
mod refine;
mod resumable;
mod solve;
mod squeezed;
mod steady;
mod steep;
mod stiffness;

pub use clearance::{Clearance, Heights};
pub use conductors::{Conductance, ConductanceError, Conductors};
pub use contact::Contact;
pub use dynamics::Dynamics;
pub use effort::Effort;
pub use equilibrium::{Equilibrium, Press};
pub use fields::{Fields, Solved};
pub use gfmd_field::Grid;
pub use gfmd_green::{Body, Material};
pub use gfmd_measure::{Boundary, UnknownBoundary};
pub use gfmd_relax::{Budget, Factors, MemoryCheckpoint, Progress, Variables, Visit, Watch, Why};
pub use gradient::{ClearanceGradient, Cotangents, Gradient, GradientError};
pub use hardness::Hardness;
pub use load::{Drive, Load};
pub use ndarray;
pub use quasistatic::{Loss, Losses, Quasistatic, Reading};
pub use refusal::Refusal;
pub use resumable::Resumable;
pub use rigid_surface::RigidSurface;
pub use solution::{Lateral, Plastic, Residual, Solution};
pub use solve_error::{SolveError, judge};
pub use solver::{Solver, UnknownSolver};
pub use springs::Springs;
pub use squeezed::{SqueezedContact, SqueezedSolution};
pub use steady::SteadyContact;
pub use steep::{SteepContact, SteepSolution};
pub use stiffness::Stiffness;
pub use units::Units;
