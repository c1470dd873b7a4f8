/// Why a surface cannot be made or measured. Every message says what was found and what is allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A Hurst exponent outside \[0, 1\].
    #[error("the Hurst exponent must be from 0 to 1, found {0}")]
    Hurst(f64),
    /// The cut-offs are not two positive wavelengths in this order.
    #[error("the wavelengths must satisfy 0 < shortest <= longest, found shortest {shortest} and longest {longest}")]
    Wavelengths {
        /// Shortest wavelength λ_s, length.
        shortest: f64,
        /// Longest wavelength λ_l, length.
        longest: f64,
    },
    /// The longest wavelength does not fit into the cell.
    #[error("the longest wavelength must not exceed the cell length {length}, found {longest}")]
    LongerThanCell {
        /// Longest wavelength λ_l, length.
        longest: f64,
        /// The longer side of the cell.
        length: f64,
    },
    /// The shortest wavelength has less than two points on this grid.
    #[error("the shortest wavelength must be at least {allowed}, two grid spacings, found {shortest}")]
    BeyondNyquist {
        /// Shortest wavelength λ_s, length.
        shortest: f64,
        /// Twice the (larger) grid spacing.
        allowed: f64,
    },
    /// A roll-off wavelength that is not between the cut-offs.
    #[error("the roll-off wavelength must be from {shortest} to {longest}, found {found}")]
    RollOff {
        /// Roll-off wavelength λ_r, length.
        found: f64,
        /// Shortest wavelength λ_s.
        shortest: f64,
        /// Longest wavelength λ_l.
        longest: f64,
    },
    /// A size that must be positive and finite.
    #[error("the {what} must be positive and finite, found {found}")]
    NotPositive {
        /// Which quantity.
        what: &'static str,
        /// Its value.
        found: f64,
    },
    /// No mode of the cell lies between the cut-offs.
    #[error("no wave vector of this cell has a wavelength from {shortest} to {longest}")]
    NoModes {
        /// Shortest wavelength λ_s.
        shortest: f64,
        /// Longest wavelength λ_l.
        longest: f64,
    },
    /// A discretisation number that is too small, or not a number.
    #[error("{name} must be at least {least} and finite, found {found}")]
    Discretisation {
        /// `1/eps_t`, `1/eps_f` or `1/eps_c`.
        name: &'static str,
        /// Its value.
        found: f64,
        /// The smallest value allowed.
        least: f64,
    },
    /// The product of the discretisation numbers is no number of points.
    #[error("1/eps_t * 1/eps_f * 1/eps_c must be a whole number of points up to {most}, found {product}")]
    PointCount {
        /// The product.
        product: f64,
        /// The largest number of points along an axis.
        most: usize,
    },
    /// A profile that does not lie along x.
    #[error("a profile lies along x: [n, 1] points, found {0:?}")]
    ProfileAxis([usize; 2]),
    /// Heights of another shape than the grid.
    #[error("heights of shape {found:?} do not fit a grid of {expected:?} points")]
    Shape {
        /// Shape of the heights.
        found: [usize; 2],
        /// Points of the grid.
        expected: [usize; 2],
    },
    /// Heights that are NaN or infinite.
    #[error("{count} of {points} heights are missing or not finite, the first is {value} at [x, y] = {first:?}")]
    NotFinite {
        /// How many.
        count: usize,
        /// Of how many.
        points: usize,
        /// Index `[x, y]` of the first one in storage order.
        first: [usize; 2],
        /// The first one: NaN or an infinity.
        value: f64,
    },
    /// Too few points for what was asked.
    #[error("{what} needs at least {least} points along each axis it acts on, found {found:?}")]
    TooFewPoints {
        /// What was asked.
        what: &'static str,
        /// Points needed.
        least: usize,
        /// Shape of the heights.
        found: [usize; 2],
    },
    /// A fit of the Hurst exponent without enough different wavenumbers.
    #[error("a Hurst exponent needs modes of at least two wavelengths from {shortest} to {longest}, found {found}")]
    Fit {
        /// Shortest wavelength of the range.
        shortest: f64,
        /// Longest wavelength of the range.
        longest: f64,
        /// Number of different wavenumbers in the range that carry power.
        found: usize,
    },
    /// A taper that is not a fraction.
    #[error("the taper of a window must be from 0 to 1, found {0}")]
    Taper(f64),
    /// A name that no value has.
    #[error("the {subject} is {found:?}; it must be one of {allowed}")]
    Name {
        /// The kind of value.
        subject: &'static str,
        /// The name given.
        found: String,
        /// The names allowed.
        allowed: String,
    },
    /// A number of subdivisions that is zero or would not fit into memory.
    #[error("the number of subdivisions must be from 1 to {most}, found {found}")]
    Subdivisions {
        /// What was asked.
        found: u32,
        /// The most allowed.
        most: u32,
    },
    /// The grid itself.
    #[error(transparent)]
    Grid(#[from] gfmd_field::GridError),
    /// A field of the wrong size handed to a transform.
    #[error(transparent)]
    Field(#[from] gfmd_field::ShapeError),
}

/// `found` if it is positive and finite.
pub(crate) fn positive(what: &'static str, found: f64) -> Result<f64, SurfaceError> {
    if found.is_finite() && found > 0.0 { Ok(found) } else { Err(SurfaceError::NotPositive { what, found }) }
}
