//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! kappa(eps_t, eps_f, eps_c) = kappa_TFC + C_t eps_t^alpha_t + C_f eps_f^alpha_f + C_c eps_c^alpha_c, fitted to all
//! data of a sweep at once by weighted least squares; with [`Model::crossed`] the term in eps_t is C_t eps_t^alpha_t
//! eps_f^alpha_f. The crate uses no files, no clock and no terminal.
//!
//! - An axis with a single level has no term. kappa_TFC then contains the correction of that axis, with a warning.
//! - Data with common seeds (the same random modes at other discretisations) are compared surface by surface, which
//!   removes their common scatter. The rows of the fit are independent of each other.
//! - With [`Model::edge`], the continuum error is a multiple of a measured edge instead of a constant times eps_c. The
//!   expected factor is an additional observation.
//! - Intervals: the rows are resampled from their errors and all parameters are refitted. The percentiles are stretched
//!   by Student's t for few realisations and by √(χ²/degrees of freedom) where it is above one.
//! - The intervals do not contain errors of the form that χ² does not reveal. Check `kappa_tfc_without`, the profiles,
//!   and a second fit with other exponents.

mod datum;
mod error;
mod fit;
mod model;
mod projection;
mod report;
mod richardson;
mod rows;
mod student;
mod uncertainty;

pub use datum::{Axis, Datum};
pub use error::FitError;
pub use fit::fit;
pub use model::{COARSE, Edge, Exponent, Model, Settings, Weighting};
pub use projection::Parameters;
pub use report::{BootstrapReport, DatumReport, EdgeTerm, Estimate, Fit, ProfilePoint, Term, Uncertainty, Warning};
pub use richardson::{Richardson, RichardsonLimit};
pub use student::student_975;
