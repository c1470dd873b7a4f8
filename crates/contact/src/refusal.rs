use gfmd_field::ShapeError;
use gfmd_green::GreenError;
use gfmd_law::LawError;
use gfmd_relax::{RelaxError, ToleranceError};
use gfmd_vector::TooManyRanks;

use crate::Solver;

/// Reason why the input of a contact is invalid, with the value found and the values allowed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// The heights differ in shape from the elastic surface.
    #[error("the shape of the heights is {found:?}; it must be {expected:?}, the shape of the elastic surface")]
    Shape {
        /// Shape of the heights.
        found: [usize; 2],
        /// Shape of the grid.
        expected: [usize; 2],
    },
    /// A field cannot be continued between its points.
    #[error(transparent)]
    Field(#[from] ShapeError),
    /// The number of fields is not the number that determines a state.
    #[error("the state is made of {expected} fields; {found} are given")]
    Basis {
        /// Number of fields given.
        found: usize,
        /// Number of fields that determine a state.
        expected: usize,
    },
    /// The state to start from belongs to another kind of contact.
    #[error("the start is a state of another kind of contact; it must be one of the same problem")]
    OtherKind,
    /// A part of a problem is given but not among its facts, or the other way round.
    #[error("the {part} of the problem is given, or among its facts; it must be both or neither")]
    Part {
        /// Name of the part.
        part: &'static str,
    },
    /// The parts have too few or too many rigid surfaces.
    #[error("the parts have rigid surfaces for {found} faces; this contact has {expected}")]
    Faces {
        /// Number of rigid surfaces.
        found: usize,
        /// Number of faces of the contact.
        expected: usize,
    },
    /// A height is NaN or infinite.
    #[error("the height at {index:?} is {value}; it must be finite")]
    Height {
        /// Indices `[i, j]` of the height.
        index: [usize; 2],
        /// Height.
        value: f64,
    },
    /// The heights differ by more than the largest number.
    #[error("the rms height is {found}; it must be finite")]
    RmsHeight {
        /// Rms height.
        found: f64,
    },
    /// The heights are constant: any pressure closes the gap, and the residuals have no scale.
    #[error(
        "the heights are all equal; they must vary: a flat punch needs points around it that are lower, by more than \
         it sinks"
    )]
    Flat,
    /// The unit of stress, E* h_rms divided by the cell length, is out of the range of full precision.
    #[error(
        "E* times the rms height over the cell length is {found:e}; it must be between 1e-290 and 1e290, \
         which other units of stress or length make it"
    )]
    Unit {
        /// E* h_rms / L.
        found: f64,
    },
    /// A result is infinite, or too small for full precision.
    #[error("the {what} is {found:e}; it must be between 1e-290 and 1e290 in magnitude, which other units make it")]
    UnitOutOfRange {
        /// Name of the number.
        what: &'static str,
        /// Value found.
        found: f64,
    },
    /// The load or approach is so small that its square is zero.
    #[error(
        "the {what} is {found:e}; it must be at least {least:e} on this surface, since squares of smaller ones vanish"
    )]
    LoadUnderflows {
        /// Mean pressure or approach.
        what: &'static str,
        /// Value found.
        found: f64,
        /// Smallest possible value.
        least: f64,
    },
    /// The load or approach is so small that the displacement is below the rounding errors of the heights, and several
    /// points are as high as the highest within these errors.
    #[error(
        "the {what} is {found:e}; it must be at least {least:e} on this surface, since rounding errors of the heights \
         decide where smaller ones make contact"
    )]
    LoadBelowRoughnessRounding {
        /// Mean pressure or approach.
        what: &'static str,
        /// Value found.
        found: f64,
        /// Smallest possible value, approximately.
        least: f64,
    },
    /// The load or approach is so small that the tolerance, relative to h_rms, does not resolve it.
    #[error(
        "the {what} is {found:e}; it must be at least {least:e} on this surface, or the tolerance less than \
         {tolerance:e}, which does not resolve smaller ones"
    )]
    Unresolved {
        /// Mean pressure or approach.
        what: &'static str,
        /// Value found.
        found: f64,
        /// Smallest possible value.
        least: f64,
        /// Tolerance.
        tolerance: f64,
    },
    /// The tractions of a law are so large that a mean pressure of this size has no effect within the tolerance.
    #[error(
        "the mean pressure is {found:e}; it must be 0, or at least {least:e} in magnitude, since tractions up to \
         {traction:e} hide smaller ones at this tolerance"
    )]
    LoadBelowTractionRounding {
        /// Mean pressure.
        found: f64,
        /// Smallest possible magnitude.
        least: f64,
        /// Largest traction.
        traction: f64,
    },
    /// A load or approach, or the traction that it causes, is so large that its rounding errors exceed the tolerance.
    #[error(
        "the {what} is {found:e}; it must be at most {most:e} on this surface, since rounding errors of larger ones \
         exceed the tolerance {tolerance:e}"
    )]
    Rounding {
        /// Name of the number.
        what: &'static str,
        /// Value found.
        found: f64,
        /// Largest possible value.
        most: f64,
        /// Tolerance.
        tolerance: f64,
    },
    /// The tolerance is out of range.
    #[error(transparent)]
    Tolerance(#[from] ToleranceError),
    /// A load or a lateral displacement is not finite.
    #[error("the {what} is {found}; it must be finite")]
    NotFinite {
        /// Name of the number.
        what: &'static str,
        /// Value found.
        found: f64,
    },
    /// The mean pressure is not positive, and there is no attraction.
    #[error("the mean pressure is {found}; it must be positive and finite")]
    MeanPressure {
        /// Mean pressure.
        found: f64,
    },
    /// The hardness is not positive.
    #[error("the hardness is {found}; it must be positive and finite")]
    Hardness {
        /// Hardness.
        found: f64,
    },
    /// The hardness field differs in shape from the heights.
    #[error("the shape of the hardness is {found:?}; it must be {expected:?}, the shape of the heights")]
    HardnessShape {
        /// Shape of the hardness.
        found: [usize; 2],
        /// Shape of the heights.
        expected: [usize; 2],
    },
    /// The compliance of a spring is negative or not finite.
    #[error("the compliance of the springs is {found}; it must be finite and not negative")]
    Springs {
        /// Compliance.
        found: f64,
    },
    /// The field of springs differs in shape from the heights.
    #[error("the shape of the springs is {found:?}; it must be {expected:?}, the shape of the heights")]
    SpringsShape {
        /// Shape of the springs.
        found: [usize; 2],
        /// Shape of the heights.
        expected: [usize; 2],
    },
    /// A hardness or springs are given for an interface that cannot have them.
    #[error("{part} given; it must be left out with {with}")]
    NoWall {
        /// `a hardness is` or `a compliance of springs is`.
        part: &'static str,
        /// Part of the interface that excludes it.
        with: &'static str,
    },
    /// The mean pressure reaches the hardness.
    #[error("the mean pressure is {found}; it must be less than the {what} {hardness}")]
    BeyondHardness {
        /// Mean pressure.
        found: f64,
        /// `hardness`, or `mean hardness` of a field.
        what: &'static str,
        /// Value of the hardness.
        hardness: f64,
    },
    /// The mean pressure nearly makes a whole half-space yield.
    #[error("the mean pressure is {found}; it must be less than {limit}, near which the whole half-space yields")]
    YieldsUniformly {
        /// Mean pressure.
        found: f64,
        /// 0.95 of the pressure at which the half-space yields.
        limit: f64,
    },
    /// The approach gives no contact (without attraction), or is beyond full contact.
    #[error("the approach is {found}; it must be {}", approach_text(*found, *limit))]
    Approach {
        /// Approach.
        found: f64,
        /// The mean clearance, which gives full contact for a body with a fixed mean level (half-space, incompressible
        /// slab); `None` for other bodies.
        limit: Option<f64>,
    },
    /// The body cannot have this boundary.
    #[error(transparent)]
    Body(#[from] GreenError),
    /// More processes than can share the grid.
    #[error(transparent)]
    Ranks(#[from] TooManyRanks),
    /// The approach is prescribed, but only a mean pressure can be prescribed.
    #[error("the approach is prescribed; for this contact the mean pressure must be prescribed")]
    NoApproach,
    /// A viscoelastic body moves backwards in time.
    #[error("the time is {found}; it must be at least {least}, the time of the state before")]
    Time {
        /// Time.
        found: f64,
        /// Time of the previous state; 0 before the first one.
        least: f64,
    },
    /// Surfaces that wear slide backwards.
    #[error("the distance is {found}; it must be at least {least}, the distance of the state before")]
    Distance {
        /// Sliding distance.
        found: f64,
        /// Sliding distance of the previous state; 0 before the first one.
        least: f64,
    },
    /// The wear coefficient is not positive.
    #[error("the wear coefficient is {found}; it must be positive and finite")]
    WearCoefficient {
        /// Coefficient.
        found: f64,
    },
    /// Surfaces wear by their slip, but do not shear each other.
    #[error("the surfaces wear by their slip; there must be friction, without which slip is not known")]
    WearBySlip,
    /// Relaxation of the shear modulus alone is not implemented for the body or its boundary.
    #[error("the shear modulus alone relaxes; shear and bulk modulus must relax alike with {with}")]
    ShearAlone {
        /// Part of the body, or its boundary.
        with: &'static str,
    },
    /// Relaxation of a body beside an elastic second one, with a part for which it is not known.
    #[error("the body relaxes beside an elastic second body; it must be alone with {with}")]
    RelaxingPair {
        /// Other part of the contact.
        with: &'static str,
    },
    /// The pressure of a wave does no positive work on its displacement, so that a steady state is not unique.
    #[error(
        "the pressure of a wave leads its displacement by {found:.1} degrees; it must lead by less than 90, with less \
         friction, or a body that relaxes less"
    )]
    Lead {
        /// Angle, in degrees.
        found: f64,
    },
    /// A law moves all components of the displacement of a contact with other parts that need u_z alone.
    #[error(
        "the law moves all components of the displacement; it must move u_z alone with friction, a hardness, wear or \
         waves that relax by branches of their own"
    )]
    AllComponents,
    /// Another part needs a contact of u_z alone.
    #[error("all components of the displacement are unknown; u_z must be the only unknown with {with}")]
    NotNormal {
        /// Other part.
        with: &'static str,
    },
    /// Another part moves a surface that is held sideways.
    #[error("the surface is held sideways; it must be free to move sideways with {with}")]
    Held {
        /// Other part.
        with: &'static str,
    },
    /// A state to start from or to certify has the wrong size.
    #[error("the given state has {found} values; it must have {expected}")]
    Start {
        /// Number of values of the state.
        found: usize,
        /// Number of values of the problem.
        expected: usize,
    },
    /// The start pressure is negative or not finite.
    #[error("the start pressure at {index:?} is {value}; it must be finite and not negative")]
    StartPressure {
        /// Indices `[i, j]` of the pressure.
        index: [usize; 2],
        /// Pressure.
        value: f64,
    },
    /// The start pressure is zero.
    #[error("the start pressure is zero at all points; it must be positive at least at one")]
    StartApart,
    /// The solver cannot be used for this problem.
    #[error("the solver is {found}; it must be {}", one_of(allowed))]
    Solver {
        /// Solver.
        found: Solver,
        /// Solvers of this problem.
        allowed: &'static [Solver],
    },
    /// The traction of the law has no potential.
    #[error("the law has no potential with these parameters; Newton's method needs one, dynamics does not")]
    NoEnergy,
    /// Dynamics is used for a prescribed approach with a wall and a fixed mean of the surface.
    #[error(
        "the approach to a half-space with a wall is prescribed; dynamics needs the mean pressure, Newton's method \
         does not"
    )]
    NoDynamics,
    /// The parameters of the law are invalid.
    #[error(transparent)]
    Law(#[from] LawError),
    /// Numbers are so large or so small that the method cannot start.
    #[error("the search cannot start: {0}")]
    Search(#[from] RelaxError),
    /// The law overflows, as an exponential law does deep inside its surface.
    #[error(
        "the traction of the law is not finite in this search; it must be, and a start from a smaller load, or a \
         longer range of the law, may make it so"
    )]
    Overflow,
}

impl Refusal {
    /// Multiplies all lengths and stresses by the given factors.
    #[must_use]
    pub fn times(mut self, length: f64, stress: f64) -> Self {
        let unit = |what: &str| if what == "approach" { length } else { stress };
        match &mut self {
            Self::LoadUnderflows { what, found, least }
            | Self::LoadBelowRoughnessRounding { what, found, least }
            | Self::Unresolved { what, found, least, .. }
            | Self::Rounding { what, found, most: least, .. } => {
                *found *= unit(what);
                *least *= unit(what);
            }
            Self::LoadBelowTractionRounding { found, least, traction } => {
                [found, least, traction].into_iter().for_each(|number| *number *= stress);
            }
            Self::BeyondHardness { found, hardness, .. } => {
                *found *= stress;
                *hardness *= stress;
            }
            Self::YieldsUniformly { found, limit } => {
                *found *= stress;
                *limit *= stress;
            }
            Self::MeanPressure { found } | Self::Hardness { found } => *found *= stress,
            Self::StartPressure { value, .. } => *value *= stress,
            Self::Approach { found, limit } => {
                *found *= length;
                *limit = limit.map(|limit| limit * length);
            }
            Self::Distance { found, least } => {
                *found *= length;
                *least *= length;
            }
            Self::UnitOutOfRange { found, .. } => *found *= stress,
            _ => {}
        }
        self
    }
}

fn approach_text(found: f64, limit: Option<f64>) -> String {
    let positive = if found > 0.0 { "" } else { "positive (first touch is 0)" };
    let below = limit.map_or_else(String::new, |limit| {
        format!("less than the mean clearance {limit}, where this body would be in full contact")
    });
    let and = if positive.is_empty() || below.is_empty() { "" } else { " and " };
    format!("{positive}{and}{below}")
}

/// Lists the names of the solvers in the form "a, b or c".
fn one_of(solvers: &[Solver]) -> String {
    let names: Vec<&str> = solvers.iter().map(|solver| solver.name()).collect();
    match names.split_last() {
        Some((last, [])) => (*last).to_owned(),
        Some((last, first)) => format!("{} or {last}", first.join(", ")),
        None => "none".to_owned(),
    }
}
