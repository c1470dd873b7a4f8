/// What makes a material, a body, or a place in it impossible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GreenError {
    /// Young's modulus is zero, negative or not finite.
    #[error("Young's modulus must be positive and finite, found {0}")]
    Young(f64),
    /// The contact modulus is zero, negative or not finite.
    #[error("the contact modulus E* must be positive and finite, found {0}")]
    ContactModulus(f64),
    /// Poisson's ratio is outside the range of stable isotropic materials.
    #[error("Poisson's ratio must be above -1 and at most 0.5, found {0}")]
    Poisson(f64),
    /// The thickness of a layer is zero, negative or not finite.
    #[error("the height of a slab must be positive and finite, found {0}")]
    Height(f64),
    /// A base was given to a half-space, which has none.
    #[error("a half-space has no base: only a slab of finite height can stand on one")]
    HalfSpaceBase,
    /// A height above the base was asked of a half-space.
    #[error("a half-space has no base to measure the height {0} from: give the depth below its surface")]
    HalfSpaceHeight(f64),
    /// A place outside the body.
    #[error("the {what} must be between 0 and {largest}, found {found}")]
    Outside {
        /// Which measure: the height above the base, or the depth below the surface.
        what: &'static str,
        /// What was given.
        found: f64,
        /// The largest that is inside the body.
        largest: f64,
    },
}
