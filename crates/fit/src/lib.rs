//! Extrapolation to the thermodynamic, fractal and continuum limit (theory.md, section 11).
//!
//! kappa(eps_t, eps_f, eps_c) = kappa_TFC + C_t eps_t^alpha_t + C_f eps_f^alpha_f + C_c eps_c^alpha_c, fitted to all
//! data of a sweep at once by weighted least squares. Numbers in, numbers out: no files, no clocks, no printing.
//!
//! - An axis with a single level has no term: kappa_TFC then still contains that axis' correction, and a warning says
//!   so.
//! - Intervals come from a bootstrap over realisations: seeds are resampled, the data computed on one seed stay
//!   together (common random numbers), and everything is refitted. With few realisations the percentile interval is
//!   stretched by Student's t and (n / (n - 1))^(1/2), because the bare percentiles are then too narrow.
//! - Misfit of the model is not in these intervals. Look at `chi_squared`, at `kappa_tfc_without`, at the profiles, and
//!   at a second fit with other exponents.
//!
//! ```
//! use gfmd_fit::{Datum, Exponent, Model, Settings, fit};
//!
//! // kappa = 2 + 1.5 eps_c, four levels, the same three surfaces (seeds) at each.
//! let data: Vec<Datum> = [0.5, 0.25, 0.125, 0.0625]
//!     .iter()
//!     .map(|&eps_c| Datum {
//!         eps_t: 0.5,
//!         eps_f: 0.1,
//!         eps_c,
//!         kappa: [(7, -0.01), (8, 0.0), (9, 0.01)].map(|(seed, noise)| (seed, 2.0 + 1.5 * eps_c + noise)).into(),
//!     })
//!     .collect();
//! let free = Model { c: Some(Exponent::Free { min: 0.25, max: 4.0 }), ..Model::default() };
//! let fit = fit(&data, &Settings { model: free, ..Settings::default() }).unwrap();
//! assert!((fit.kappa_tfc.value - 2.0).abs() < 1e-8 && (fit.terms[0].exponent.value - 1.0).abs() < 1e-8);
//! ```

mod datum;
mod error;
mod fit;
mod model;
mod projection;
mod report;
mod resample;
mod richardson;
mod uncertainty;

pub use datum::{Axis, Datum};
pub use error::FitError;
pub use fit::fit;
pub use model::{Exponent, Model, Settings, Weighting};
pub use projection::Parameters;
pub use report::{BootstrapReport, DatumReport, Estimate, Fit, ProfilePoint, Term, Uncertainty, Warning};
pub use richardson::{Richardson, RichardsonLimit};
