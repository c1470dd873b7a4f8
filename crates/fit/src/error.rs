//! Why there is no fit.

use crate::Axis;

/// Why there is no fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// There is nothing to fit.
    #[error("there are no data to fit; at least one is needed")]
    NoData,
    /// A datum without values.
    #[error("datum {datum} has no realisations; it must have at least one")]
    NoRealisations {
        /// Index of the datum.
        datum: usize,
    },
    /// A kappa that is not a number.
    #[error("datum {datum} has kappa = {found} for seed {seed}; finite numbers are allowed")]
    BadKappa {
        /// Index of the datum.
        datum: usize,
        /// The seed.
        seed: u64,
        /// What was found.
        found: f64,
    },
    /// An eps that is no ratio of lengths.
    #[error("datum {datum} has eps_{axis} = {found}; finite numbers above zero are allowed")]
    BadEps {
        /// Index of the datum.
        datum: usize,
        /// The axis.
        axis: Axis,
        /// What was found.
        found: f64,
    },
    /// Two data at one place.
    #[error("data {first} and {second} have the same eps_t, eps_f and eps_c; merge their realisations")]
    SameDatum {
        /// Index of the first.
        first: usize,
        /// Index of the second.
        second: usize,
    },
    /// An exponent or its bounds out of range.
    #[error("alpha_{axis} in [{min}, {max}] asked; 0 < min <= max <= 16 are allowed")]
    BadExponent {
        /// The axis.
        axis: Axis,
        /// Lower bound found.
        min: f64,
        /// Upper bound found.
        max: f64,
    },
    /// A prior below zero or not finite.
    #[error("weighting prior {found} asked; finite numbers >= 0 are allowed")]
    BadPrior {
        /// What was found.
        found: f64,
    },
    /// Fewer data than unknowns.
    #[error("{parameters} parameters but only {data} data; fix exponents, leave out terms or add data")]
    TooFewData {
        /// Number of unknowns.
        parameters: usize,
        /// Number of data.
        data: usize,
    },
    /// The levels of the axes vary together, so their terms cannot be told apart.
    #[error("the data do not tell the terms apart (levels of two axes vary together); vary one axis at a time")]
    Dependent,
}
