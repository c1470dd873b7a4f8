use gfmd_field::GridError;
use gfmd_vector::TooManyRanks;

use crate::BaseKind;

/// Error of an invalid material, body, or position in a body.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GreenError {
    /// Young's modulus is zero, negative or not finite.
    #[error("Young's modulus is {0}; it must be positive and finite")]
    Young(f64),
    /// The contact modulus is zero, negative or not finite.
    #[error("the contact modulus E* is {0}; it must be positive and finite")]
    ContactModulus(f64),
    /// Poisson's ratio is outside the range of stable isotropic materials.
    #[error("Poisson's ratio is {0}; it must be above -1 and at most 0.5")]
    Poisson(f64),
    /// Table of compliances with invalid curve points.
    #[error("{}", of_table(.0))]
    Table(gfmd_curve::CurveError),
    /// Wavenumber or compliance of a table that is not positive and finite.
    #[error(
        "row {row} of the table of compliances has {found}; wavenumbers and compliances must be positive and finite"
    )]
    Compliance {
        /// Row number, from 1.
        row: usize,
        /// Value found.
        found: f64,
    },
    /// Wave vector of a table that is zero or not finite.
    #[error("row {row} of the table of compliances has the wave vector {found:?}; it must be finite and not zero")]
    WaveVector {
        /// Row number, from 1.
        row: usize,
        /// Wave vector found.
        found: [f64; 2],
    },
    /// Table by wave vector with too few or unequal numbers of directions.
    #[error(
        "the table of compliances has {found} rows with the smallest wavenumber, and {rows} in all; it must have 4 or \
         more directions of the wave vector, and all of them at every wavenumber"
    )]
    Directions {
        /// Number of directions at the smallest wavenumber.
        found: usize,
        /// Number of rows.
        rows: usize,
    },
    /// Row of a table by wave vector at a wrong wavenumber or angle.
    #[error(
        "row {row} of the table of compliances has the wavenumber {q:.6e} at {angle:.3} degrees; each wavenumber must \
         have {directions} directions, at multiples of 180/{directions} degrees from the x axis"
    )]
    Direction {
        /// Row number, from 1.
        row: usize,
        /// Length of the wave vector.
        q: f64,
        /// Angle to the x axis, in degrees from 0 to 180.
        angle: f64,
        /// Number of directions at the smallest wavenumber.
        directions: usize,
    },
    /// The compliance of the uniform mode is negative or not finite.
    #[error("the uniform compliance is {0}; it must be 0 or positive, and finite")]
    UniformCompliance(f64),
    /// The thickness of a layer is zero, negative or not finite.
    #[error("the height of the slab is {0}; it must be positive and finite")]
    Height(f64),
    /// Base given for a half-space, which has none.
    #[error("the body is a half-space; a base needs a slab of finite height")]
    HalfSpaceBase,
    /// Stack without layers.
    #[error("the stack has no layers; it must have at least one")]
    NoLayer,
    /// Half-space as a base without its material, or a material given for another base.
    #[error("the base is {0}; a material of the base must be given for half-space, and for no other base")]
    BaseMaterial(BaseKind),
    /// Pair of bodies below a slab.
    #[error("the body below a slab is a pair of bodies; it must be one body")]
    PairBelow,
    /// Half-space or pair of bodies pressed on both faces.
    #[error("the body is {0}; a body that is pressed on both faces must be a slab or a stack of layers")]
    Plate(&'static str),
    /// Shear of a patch with free boundaries on a body with a laterally free base.
    #[error("the base does not hold the body sideways; with free boundaries and shear it must be bonded or half-space")]
    FreeSliding,
    /// Patch with free boundaries on a body with a base that is free along z.
    #[error("nothing holds the plate; with free boundaries the base must be bonded, sliding or half-space")]
    FreePlate,
    /// Layers too thin for a patch.
    #[error(
        "the height of the top layer is {found}; with free boundaries it must be at least {least:.3e} on this grid: \
         about 1/200 of the diagonal of the patch or of the profile, and 1/4 of the spacing"
    )]
    ThinLayer {
        /// Height found.
        found: f64,
        /// Smallest allowed height.
        least: f64,
    },
    /// Patch that cannot be doubled.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// Cell of a patch with rows that several processes cannot share.
    #[error(transparent)]
    Share(#[from] TooManyRanks),
    /// Shear of a profile with free boundaries.
    #[error(
        "the grid is a profile; shear with free boundaries needs a surface, since the lateral displacement of a \
         profile is known up to a constant"
    )]
    LineShear,
    /// Compliance table of a patch with entries that are rounding errors.
    #[error(
        "the compliance of the patch is between {least:e} and {largest:e}; the least must be above 1e-12 of the \
         largest (with free boundaries and a law a body cannot be incompressible and thin, nor, if all components \
         move, have a Poisson's ratio near -1)"
    )]
    PatchStiffness {
        /// Smallest compliance of a wave.
        least: f64,
        /// Largest compliance of a wave.
        largest: f64,
    },
    /// Height above the base given for a half-space, which has no base.
    #[error("the height above the base is {0}, but a half-space has no base; give the depth below the surface")]
    HalfSpaceHeight(f64),
    /// Position outside the body.
    #[error("the {what} is {found}; it must be between 0 and {largest}")]
    Outside {
        /// Measure: height above the base or depth below the surface.
        what: &'static str,
        /// Value found.
        found: f64,
        /// Largest value inside the body.
        largest: f64,
    },
}

/// Formats the error of a table of compliances with invalid curve points.
fn of_table(error: &gfmd_curve::CurveError) -> String {
    let between = if matches!(error, gfmd_curve::CurveError::Few { .. }) { " has" } else { ":" };
    format!("the table of compliances{between} {error}")
}
