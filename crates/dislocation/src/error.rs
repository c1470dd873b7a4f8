use gfmd_field::{GridError, ShapeError};
use gfmd_green::GreenError;
use gfmd_mixed::MixedError;

/// Reasons why dislocations cannot be placed, moved, or brought to equilibrium with the surface.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DislocationError {
    /// A body with layers, a base that is not bonded, or a second body.
    #[error(
        "the body has layers, a base that is not bonded, or a second body; it must be a half-space or one bonded slab"
    )]
    Body,
    /// An even number of points. The shortest wave on it is its own mirror image.
    #[error("the line has {found} points; their number must be odd and at least 3")]
    Points {
        /// Number of points.
        found: usize,
    },
    /// A parameter out of range.
    #[error("the {what} is {found}; it must be {allowed}")]
    Value {
        /// Name of the parameter.
        what: &'static str,
        /// Value given.
        found: f64,
        /// Values allowed.
        allowed: &'static str,
    },
    /// A dislocation, source or obstacle that is not inside the body.
    #[error(
        "the place {found} along slip plane {plane} is outside the body; it must be between {lowest} and 0, both \
         excluded"
    )]
    Place {
        /// Index of the slip plane.
        plane: usize,
        /// Position along the slip direction from the surface.
        found: f64,
        /// Position of the base.
        lowest: f64,
    },
    /// A slip plane that does not exist.
    #[error("slip plane {found} does not exist; there are {planes}")]
    Plane {
        /// Index given.
        found: usize,
        /// Number of slip planes.
        planes: usize,
    },
    /// An invalid grid.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// A mask or field of another grid.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// An invalid place.
    #[error(transparent)]
    Green(#[from] GreenError),
    /// A surface that does not reach equilibrium.
    #[error(transparent)]
    Surface(#[from] MixedError),
}
