//! Errors of a fit.

use crate::Axis;

/// Reason why a fit is impossible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// There are no data.
    #[error("the number of data is 0; it must be at least 1")]
    NoData,
    /// A datum has no realisations.
    #[error("datum {datum} has 0 realisations; it must have at least 1")]
    NoRealisations {
        /// Index of the datum.
        datum: usize,
    },
    /// A kappa is not finite.
    #[error("kappa of datum {datum}, seed {seed}, is {found}; it must be finite")]
    BadKappa {
        /// Index of the datum.
        datum: usize,
        /// Seed of the realisation.
        seed: u64,
        /// Value of kappa.
        found: f64,
    },
    /// An eps is not positive and finite.
    #[error("eps_{axis} of datum {datum} is {found}; it must be finite and above zero")]
    BadEps {
        /// Index of the datum.
        datum: usize,
        /// Axis of the eps.
        axis: Axis,
        /// Value of eps.
        found: f64,
    },
    /// Two data have equal eps on all axes.
    #[error("data {first} and {second} have equal eps_t, eps_f and eps_c; merge their realisations into one datum")]
    SameDatum {
        /// Index of the first datum.
        first: usize,
        /// Index of the second datum.
        second: usize,
    },
    /// An exponent or its bounds are out of range.
    #[error("the range of alpha_{axis} is [{min}, {max}]; it must be increasing, above 0 and at most 16")]
    BadExponent {
        /// Axis of the term.
        axis: Axis,
        /// Lower bound.
        min: f64,
        /// Upper bound.
        max: f64,
    },
    /// The model has terms in both eps_c and the measured edge.
    #[error("the model has a term in eps_c and one of the measured edge; it must have at most one of them")]
    TwoContinuumTerms,
    /// A realisation has no measured edge, but the model has the edge term.
    #[error("datum {datum} has no edge for some of its seeds; every realisation must have one")]
    NoEdge {
        /// Index of the datum.
        datum: usize,
    },
    /// The expected edge factor is not finite, its standard error is not positive, or the standard error of f' is
    /// negative or infinite.
    #[error(
        "the expected factor of the edge is {factor} ± {standard_error}, and on coarse grids ± {coarse} more; it must \
         be finite, its standard error above zero, the other one finite and not negative"
    )]
    BadEdge {
        /// Expected factor f.
        factor: f64,
        /// Standard error of f.
        standard_error: f64,
        /// Standard error of f'.
        coarse: f64,
    },
    /// A prior is negative or not finite.
    #[error("the weighting prior is {found}; it must be finite and not negative")]
    BadPrior {
        /// Value of the prior.
        found: f64,
    },
    /// There are fewer data than parameters.
    #[error(
        "the number of data is {data}; it must be at least the number of parameters, {parameters}: fix exponents, \
         leave out terms or add data"
    )]
    TooFewData {
        /// Number of parameters.
        parameters: usize,
        /// Number of data.
        data: usize,
    },
    /// The levels of two axes vary together, so that their terms cannot be separated.
    #[error("the data do not separate the terms: the levels of two axes vary together; vary one axis at a time")]
    Dependent,
}
