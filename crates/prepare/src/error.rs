/// Reasons why heights cannot be prepared. Each message states the value found and the values allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PrepareError {
    /// A number outside its range.
    #[error("the {what} is {found}; it must be {allowed}")]
    Value {
        /// Name of the number.
        what: &'static str,
        /// Number found, as text.
        found: String,
        /// Numbers allowed.
        allowed: String,
    },
    /// Too many points that stand out.
    #[error(
        "{found} of {points} defined points stand out; at most a tenth may: the surface has a sharp lay, or a grid \
         coarser than its roughness, and a larger threshold takes fewer points"
    )]
    TooManySpikes {
        /// Number of points found.
        found: usize,
        /// Number of defined points.
        points: usize,
    },
    /// Heights without the points that an operation needs.
    #[error("{what} needs {needed}; there are {found}")]
    TooFewPoints {
        /// Name of the operation.
        what: &'static str,
        /// Points needed.
        needed: String,
        /// Points found.
        found: usize,
    },
    /// Points that do not determine all terms of a polynomial.
    #[error("the points of the fit do not determine all terms of a polynomial of degree {degree}; a lower degree may")]
    Undetermined {
        /// Degree of the polynomial.
        degree: usize,
    },
    /// A combination that has no meaning.
    #[error("{found}; it must be {allowed}")]
    Combination {
        /// Combination found.
        found: &'static str,
        /// Allowed combination.
        allowed: &'static str,
    },
}

/// Returns the error of a number outside its range.
pub(crate) fn value(what: &'static str, found: impl ToString, allowed: impl Into<String>) -> PrepareError {
    PrepareError::Value { what, found: found.to_string(), allowed: allowed.into() }
}
