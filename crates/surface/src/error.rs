/// Reasons why a surface cannot be made or measured. Each message states the value found and the values allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SurfaceError {
    /// A Hurst exponent outside \[0, 1\].
    #[error("the Hurst exponent is {0}; it must be between 0 and 1")]
    Hurst(f64),
    /// Cut-offs that are not two positive wavelengths in ascending order.
    #[error(
        "the shortest wavelength is {shortest} and the longest {longest}; they must satisfy 0 < shortest <= longest"
    )]
    Wavelengths {
        /// Shortest wavelength λ_s, length.
        shortest: f64,
        /// Longest wavelength λ_l, length.
        longest: f64,
    },
    /// A longest wavelength that exceeds the cell.
    #[error("the longest wavelength is {longest}; it must be at most the cell length {length}")]
    LongerThanCell {
        /// Longest wavelength λ_l, length.
        longest: f64,
        /// Longer side of the cell.
        length: f64,
    },
    /// A shortest wavelength with fewer than two points on the grid.
    #[error("the shortest wavelength is {shortest}; it must be at least {allowed}, two grid spacings")]
    BeyondNyquist {
        /// Shortest wavelength λ_s, length.
        shortest: f64,
        /// Twice the (larger) grid spacing.
        allowed: f64,
    },
    /// A shortest wavelength of two grid spacings, whose phase a grid does not show.
    #[error(
        "the shortest wavelength is {shortest}, two grid spacings; with a distribution of the heights it must be longer"
    )]
    NoRoomForPhases {
        /// Shortest wavelength λ_s, length.
        shortest: f64,
    },
    /// A distribution of heights that no surface with these waves has.
    #[error(
        "the heights lie {:.0} % of their rms height away from the distribution; its tails or gaps must be such that \
         waves of this spectrum have them within 10 %", 100.0 * found
    )]
    Marginal {
        /// Root-mean-square distance in the order of the heights, relative to the rms height.
        found: f64,
    },
    /// A roll-off wavelength outside the cut-offs.
    #[error("the roll-off wavelength is {found}; it must be between {shortest} and {longest}")]
    RollOff {
        /// Roll-off wavelength λ_r, length.
        found: f64,
        /// Shortest wavelength λ_s.
        shortest: f64,
        /// Longest wavelength λ_l.
        longest: f64,
    },
    /// An aspect ratio below 1 or a direction that is not finite.
    #[error("the aspect ratio is {aspect} and the lay is {lay}; they must be finite, the ratio at least 1")]
    Anisotropy {
        /// Ratio of the correlation lengths along and across the lay.
        aspect: f64,
        /// Direction of the lay, degrees.
        lay: f64,
    },
    /// A direction of a profile.
    #[error("the profile has a preferred direction; it must have none")]
    DirectionOfProfile,
    /// A size that must be positive and finite.
    #[error("the {what} is {found}; it must be positive and finite")]
    NotPositive {
        /// Name of the quantity.
        what: &'static str,
        /// Value found.
        found: f64,
    },
    /// Cut-offs without a wave vector of the cell between them.
    #[error(
        "the wavelengths are limited to {shortest} to {longest}; at least one wave vector of the cell must lie in \
         between"
    )]
    NoModes {
        /// Shortest wavelength λ_s.
        shortest: f64,
        /// Longest wavelength λ_l.
        longest: f64,
    },
    /// A discretisation number that is too small or not finite.
    #[error("{name} is {found}; it must be at least {least} and finite")]
    Discretisation {
        /// `1/eps_t`, `1/eps_f` or `1/eps_c`.
        name: &'static str,
        /// Value found.
        found: f64,
        /// Smallest value allowed.
        least: f64,
    },
    /// Discretisation numbers with a product that is not a valid number of points.
    #[error("1/eps_t * 1/eps_f * 1/eps_c is {product}; it must be a whole number of points up to {most}")]
    PointCount {
        /// Product of the three numbers.
        product: f64,
        /// Largest number of points along an axis.
        most: usize,
    },
    /// A profile that does not lie along x.
    #[error("the profile has {0:?} points; it must lie along x with [n, 1] points")]
    ProfileAxis([usize; 2]),
    /// Heights that do not have the shape of the grid.
    #[error("the heights have shape {found:?}; they must have the shape {expected:?} of the grid")]
    Shape {
        /// Shape of the heights.
        found: [usize; 2],
        /// Number of grid points along x and y.
        expected: [usize; 2],
    },
    /// Heights that are NaN or infinite.
    #[error(
        "{count} of {points} heights are missing or not finite, the first is {value} at [x, y] = {first:?}; all must \
         be finite"
    )]
    NotFinite {
        /// Number of heights that are not finite.
        count: usize,
        /// Total number of heights.
        points: usize,
        /// Index `[x, y]` of the first height that is not finite, in storage order.
        first: [usize; 2],
        /// Its value: NaN or an infinity.
        value: f64,
    },
    /// Heights without a defined point.
    #[error("all of the {points} points are undefined; at least one must have a height")]
    Undefined {
        /// Number of points.
        points: usize,
    },
    /// Harmonic fill that did not converge.
    #[error("the harmonic fill has a relative residual of {residual:e}; it must be at most {allowed:e}")]
    Unsolved {
        /// Relative residual of the last iterate.
        residual: f64,
        /// Largest relative residual allowed.
        allowed: f64,
    },
    /// Too few points for an operation.
    #[error("the heights have {found:?} points; {what} needs at least {least} along each axis that it acts on")]
    TooFewPoints {
        /// Name of the operation.
        what: &'static str,
        /// Number of points needed.
        least: usize,
        /// Shape of the heights.
        found: [usize; 2],
    },
    /// A fit of the Hurst exponent with too few different wavenumbers.
    #[error("the heights have {found} wavelengths from {shortest} to {longest}; a Hurst exponent needs at least two")]
    Fit {
        /// Shortest wavelength of the range, length.
        shortest: f64,
        /// Longest wavelength of the range, length.
        longest: f64,
        /// Number of different wavenumbers with power in the range.
        found: usize,
    },
    /// A shift of one surface against another that is not finite or goes across a profile.
    #[error("the shift is {found:?}; it must be two finite numbers, the second 0 for a profile")]
    Shift {
        /// Shift along x and y, length.
        found: [f64; 2],
    },
    /// A shift by a fraction of a grid step for a surface that does not repeat.
    #[error(
        "the shift is {found:?} grid steps; it must be whole steps for surfaces that do not repeat, since nothing is \
         known between their points"
    )]
    PartOfStep {
        /// Shift along x and y, in grid steps.
        found: [f64; 2],
    },
    /// A shift that leaves too little overlap of two surfaces that do not repeat.
    #[error("the shift is {found:?}; it must leave at least two points in common along each side of {lengths:?}")]
    Apart {
        /// Shift along x and y, length.
        found: [f64; 2],
        /// Sides of the surfaces, length.
        lengths: [f64; 2],
    },
    /// A fraction outside \[0, 1\].
    #[error("the fraction of {what} is {found}; it must be between 0 and 1")]
    Fraction {
        /// Name of the operation.
        what: &'static str,
        /// Value found.
        found: f64,
    },
    /// Too many points for an operation.
    #[error("the heights have {found} points; {what} takes at most {most}")]
    TooManyPoints {
        /// Name of the operation.
        what: &'static str,
        /// Largest number allowed.
        most: usize,
        /// Number of points found.
        found: usize,
    },
    /// A taper outside \[0, 1\].
    #[error("the taper of the window is {0}; it must be between 0 and 1")]
    Taper(f64),
    /// An unknown name.
    #[error("the {subject} is {found:?}; it must be one of {allowed}")]
    Name {
        /// Kind of value.
        subject: &'static str,
        /// Name given.
        found: String,
        /// Names allowed.
        allowed: String,
    },
    /// A number of subdivisions that is zero or too large for memory.
    #[error("the number of subdivisions is {found}; it must be between 1 and {most}")]
    Subdivisions {
        /// Number given.
        found: u32,
        /// Largest number allowed.
        most: u32,
    },
    /// A grid that cannot be made.
    #[error(transparent)]
    Grid(#[from] gfmd_field::GridError),
    /// A field of the wrong size, passed to a transform.
    #[error(transparent)]
    Field(#[from] gfmd_field::ShapeError),
}

/// Returns `found` if it is positive and finite.
pub(crate) fn positive(what: &'static str, found: f64) -> Result<f64, SurfaceError> {
    if found.is_finite() && found > 0.0 { Ok(found) } else { Err(SurfaceError::NotPositive { what, found }) }
}
