//! Common imports: `use gfmd::prelude::*`.

pub use gfmd_body::Interior;
pub use gfmd_contact::{
    Budget, Contact, Drive, Effort, Equilibrium, Fields, Load, Progress, Refusal, SolveError, Solver, Watch,
};
pub use gfmd_field::Grid;
pub use gfmd_green::{Body, Material};
pub use gfmd_interface::{Interface, Parts, QuasistaticContact, Shear, Wear};
pub use gfmd_law::{Dugdale, Exponential, Law, Limit, Morse};
pub use gfmd_measure::Summary;
pub use gfmd_medium::{Prony, Relaxes};
pub use gfmd_mixed::{MixedProblem, Prescribed};
pub use gfmd_surface::{Discretisation, SelfAffine, Statistics};
pub use ndarray::{Array2, ArrayView2};
