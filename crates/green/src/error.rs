use gfmd_field::GridError;

use crate::BaseKind;

/// Reasons to refuse a material, a body, or a place in it.
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
    /// A table of compliances with points that no curve can have.
    #[error("{}", of_table(.0))]
    Table(gfmd_curve::CurveError),
    /// A wavenumber or a compliance of a table that is not positive.
    #[error(
        "row {row} of the table of compliances has {found}; wavenumbers and compliances must be positive and finite"
    )]
    Compliance {
        /// The row, from 1.
        row: usize,
        /// The number.
        found: f64,
    },
    /// A wave vector of a table that is zero or not finite.
    #[error("row {row} of the table of compliances has the wave vector {found:?}; it must be finite and not zero")]
    WaveVector {
        /// The row, from 1.
        row: usize,
        /// The wave vector.
        found: [f64; 2],
    },
    /// A table by wave vector whose directions do not fit.
    #[error(
        "the table of compliances has {found} rows with the smallest wavenumber, and {rows} in all; it must have 4 or \
         more directions of the wave vector, and all of them at every wavenumber"
    )]
    Directions {
        /// The number of directions at the smallest wavenumber.
        found: usize,
        /// The number of rows.
        rows: usize,
    },
    /// A row of such a table that is elsewhere.
    #[error(
        "row {row} of the table of compliances has the wavenumber {q:.6e} at {angle:.3} degrees; each wavenumber must \
         have {directions} directions, at multiples of 180/{directions} degrees from the x axis"
    )]
    Direction {
        /// The row, from 1.
        row: usize,
        /// The length of the wave vector.
        q: f64,
        /// Its angle to the x axis, in degrees from 0 to 180.
        angle: f64,
        /// The number of directions at the smallest wavenumber.
        directions: usize,
    },
    /// The compliance of the uniform mode is negative or not finite.
    #[error("the uniform compliance is {0}; it must be 0 or positive, and finite")]
    UniformCompliance(f64),
    /// The thickness of a layer is zero, negative or not finite.
    #[error("the height of the slab is {0}; it must be positive and finite")]
    Height(f64),
    /// A base was given to a half-space, which has none.
    #[error("the body is a half-space; a base needs a slab of finite height")]
    HalfSpaceBase,
    /// A stack without layers.
    #[error("the stack has no layers; it must have at least one")]
    NoLayer,
    /// A half-space below without its material, or a material for another base.
    #[error("the base is {0}; a material of the base must be given for half-space, and for no other base")]
    BaseMaterial(BaseKind),
    /// Two bodies with their surfaces on each other, below a slab.
    #[error("the body below a slab is a pair of bodies; it must be one body")]
    PairBelow,
    /// A half-space or a pair of bodies, pressed on both faces.
    #[error("the body is {0}; a body that is pressed on both faces must be a slab or a stack of layers")]
    Plate(&'static str),
    /// Shear of a patch with free boundaries on a body whose base leaves it free sideways.
    #[error("the base does not hold the body sideways; with free boundaries and shear it must be bonded or half-space")]
    FreeSliding,
    /// A patch with free boundaries on a body whose base leaves it free along z.
    #[error("nothing holds the plate; with free boundaries the base must be bonded, sliding or half-space")]
    FreePlate,
    /// Layers that are too thin for a patch.
    #[error(
        "the height of the top layer is {found}; with free boundaries it must be at least {least:.3e} on this grid: \
         about 1/200 of the diagonal of the patch or of the profile, and 1/4 of the spacing"
    )]
    ThinLayer {
        /// The height.
        found: f64,
        /// The least height.
        least: f64,
    },
    /// A patch that cannot be doubled.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// Shear of a profile with free boundaries.
    #[error(
        "the grid is a profile; shear with free boundaries needs a surface, since the lateral displacement of a \
         profile is known up to a constant"
    )]
    LineShear,
    /// The compliance of a patch whose table has entries that are rounding errors.
    #[error(
        "the compliance of the patch is between {least:e} and {largest:e}; the least must be above 1e-12 of the \
         largest (a body that is incompressible and thin cannot be had with free boundaries and a law)"
    )]
    PatchStiffness {
        /// The least compliance of a wave.
        least: f64,
        /// The largest.
        largest: f64,
    },
    /// A height above the base, for a half-space, which has none.
    #[error("the height above the base is {0}, but a half-space has no base; give the depth below the surface")]
    HalfSpaceHeight(f64),
    /// A place outside the body.
    #[error("the {what} is {found}; it must be between 0 and {largest}")]
    Outside {
        /// The measure: the height above the base, or the depth below the surface.
        what: &'static str,
        /// The value given.
        found: f64,
        /// The largest value inside the body.
        largest: f64,
    },
}

/// The words on a table of compliances that no curve can have.
fn of_table(error: &gfmd_curve::CurveError) -> String {
    let between = if matches!(error, gfmd_curve::CurveError::Few { .. }) { " has" } else { ":" };
    format!("the table of compliances{between} {error}")
}
