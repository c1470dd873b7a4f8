use gfmd_contact::Refusal;

/// Error of an unusable elastic-plastic contact, with the value found and the values allowed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlasticityError {
    /// The yield stress is not positive.
    #[error("the yield stress is {found}; it must be positive and finite")]
    YieldStress {
        /// Yield stress.
        found: f64,
    },
    /// The yield stress is so large that the strain at yield is not small.
    #[error("the yield stress is {found}; it must be less than {limit}, a tenth of Young's modulus")]
    YieldStrain {
        /// Yield stress.
        found: f64,
        /// A tenth of Young's modulus.
        limit: f64,
    },
    /// A hardening modulus is negative.
    #[error("the {what} hardening is {found}; it must be finite and not negative")]
    Modulus {
        /// `isotropic` or `kinematic`.
        what: &'static str,
        /// Hardening modulus.
        found: f64,
    },
    /// The hardening curve has too few points.
    #[error("the hardening curve has {found} points; it must have at least 2")]
    CurvePoints {
        /// Number of points.
        found: usize,
    },
    /// The hardening curve does not start at a plastic strain of zero.
    #[error("the first plastic strain of the hardening curve is {found}; it must be 0")]
    CurveStart {
        /// First plastic strain.
        found: f64,
    },
    /// The plastic strain of the hardening curve does not increase.
    #[error("the plastic strain of point {index} of the hardening curve is {found}; it must exceed {before}")]
    CurveStrain {
        /// Number of the point, from 0.
        index: usize,
        /// Plastic strain.
        found: f64,
        /// Plastic strain of the point before.
        before: f64,
    },
    /// The yield stress of the hardening curve decreases.
    #[error("the stress of point {index} of the hardening curve is {found}; it must be at least {before} and finite")]
    CurveStress {
        /// Number of the point, from 0.
        index: usize,
        /// Stress.
        found: f64,
        /// Stress of the point before.
        before: f64,
    },
    /// The number of materials with or without plasticity differs from the number of layers.
    #[error("hardening is given for {found} layers; the body has {layers}")]
    Layers {
        /// Number given.
        found: usize,
        /// Number of layers of the body.
        layers: usize,
    },
    /// No layer yields.
    #[error("no layer of the body yields; at least one must have a yield stress")]
    NothingYields,
    /// A material with cells is nearly incompressible.
    #[error("Poisson's ratio of a layer with cells is {found}; it must be at most {limit}")]
    Poisson {
        /// Poisson's ratio.
        found: f64,
        /// Largest value.
        limit: f64,
    },
    /// The body is given by a table of compliances.
    #[error(
        "the body is a table of compliances; it must have layers with moduli, since strains below the surface count"
    )]
    Tabulated,
    /// A cell is not positive in thickness.
    #[error("the thickness of cell {index} is {found}; it must be positive and finite")]
    Thickness {
        /// Number of the cell, from the surface.
        index: usize,
        /// Thickness.
        found: f64,
    },
    /// There is no cell.
    #[error("there are no cells; there must be at least one")]
    NoCells,
    /// The growth of the cells is out of range.
    #[error("the growth of the cells is {found}; it must be between 1 and 2")]
    Growth {
        /// Factor between neighbouring cells.
        found: f64,
    },
    /// The distance at which cells become coarser is out of range.
    #[error("the cells become coarser at {found} times their spacing; it must be 0, for never, or at least 1")]
    CoarseningDepth {
        /// Depth divided by the spacing.
        found: f64,
    },
    /// The cells end below the body.
    #[error("the cells end at a depth of {found}; the body ends at {height}")]
    BelowBody {
        /// Depth of the lowest cell.
        found: f64,
        /// Height of the body.
        height: f64,
    },
    /// A cell has two materials.
    #[error("a cell reaches from a depth of {top} to {bottom}; it must end at the interface at {interface}")]
    AcrossInterface {
        /// Depth of the top of the cell.
        top: f64,
        /// Depth of the bottom of the cell.
        bottom: f64,
        /// Depth of the interface.
        interface: f64,
    },
    /// The number of coarsenings differs from the number of cells.
    #[error("there are {found} coarsenings; there must be {cells}, one per cell")]
    Coarsenings {
        /// Number of coarsenings.
        found: usize,
        /// Number of cells.
        cells: usize,
    },
    /// A coarsening is not a power of two, or leaves too few points.
    #[error(
        "the coarsening of cell {index} is {found}; it must be a power of two that leaves at least {least} of \
             {points:?} points"
    )]
    Coarsening {
        /// Number of the cell, from the surface.
        index: usize,
        /// Coarsening.
        found: usize,
        /// Points of the grid.
        points: [usize; 2],
        /// Least number of points along a side.
        least: usize,
    },
    /// The contact is unusable.
    #[error(transparent)]
    Contact(#[from] Refusal),
}
