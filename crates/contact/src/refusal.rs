use gfmd_law::LawError;
use gfmd_relax::{RelaxError, ToleranceError};

use crate::Solver;

/// The reason why a contact cannot be posed: unusable input, with what was found and what is allowed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Refusal {
    /// Heights on another grid than the elastic surface.
    #[error("the heights are {found:?} points, the elastic surface has {expected:?}")]
    Shape {
        /// Shape of the heights.
        found: [usize; 2],
        /// Shape of the grid.
        expected: [usize; 2],
    },
    /// A height that is NaN or infinite.
    #[error("the height at {index:?} is {value}; heights must be finite")]
    Height {
        /// Indices `[i, j]` of the height.
        index: [usize; 2],
        /// The height.
        value: f64,
    },
    /// Heights so different that their mean square is no number.
    #[error("the rms height is {found}; it must be finite")]
    RmsHeight {
        /// The rms height.
        found: f64,
    },
    /// Heights that do not vary: every pressure closes the gap at once and no residual has a scale.
    #[error("the heights are all equal; a contact needs a surface that varies")]
    Flat,
    /// A tolerance out of range.
    #[error(transparent)]
    Tolerance(#[from] ToleranceError),
    /// A load or a lateral displacement that is not finite.
    #[error("the {what} is {found}; it must be finite")]
    NotFinite {
        /// Name of the number.
        what: &'static str,
        /// Its value.
        found: f64,
    },
    /// A mean pressure that does not press, where nothing attracts.
    #[error("the mean pressure is {found}; it must be positive and finite")]
    MeanPressure {
        /// The mean pressure asked for.
        found: f64,
    },
    /// An approach without contact where nothing attracts, or beyond full contact.
    #[error("the approach is {found}; it must be {}", approach_text(*found, *limit))]
    Approach {
        /// The approach asked for.
        found: f64,
        /// The mean clearance, at which a body whose mean level is held (half-space, incompressible slab) would be in full
        /// contact; `None` for other bodies.
        limit: Option<f64>,
    },
    /// Friction without contact.
    #[error("the {what} is {found}; friction needs contact, it must be positive")]
    NotPressed {
        /// Mean pressure or approach.
        what: &'static str,
        /// Its value.
        found: f64,
    },
    /// A prescribed approach where only a mean pressure can be prescribed.
    #[error("the approach is prescribed; this contact needs a mean pressure")]
    NoApproach,
    /// A state, to start from or to certify, that has another size.
    #[error("the given state has {found} values, {expected} are needed")]
    Start {
        /// Its number of values.
        found: usize,
        /// That of this problem.
        expected: usize,
    },
    /// A pressure to start from that is negative or not finite.
    #[error("the pressure to start from is {value} at {index:?}; it must be finite and not negative")]
    StartPressure {
        /// Indices `[i, j]` of the pressure.
        index: [usize; 2],
        /// The pressure.
        value: f64,
    },
    /// A pressure to start from without contact.
    #[error("the pressure to start from is zero everywhere; it must be positive somewhere")]
    StartApart,
    /// A solver that cannot be used for this problem.
    #[error("the solver is {found}; it must be {}", one_of(allowed))]
    Solver {
        /// The solver asked for.
        found: Solver,
        /// The solvers of this problem.
        allowed: &'static [Solver],
    },
    /// A law whose traction is not the gradient of an energy.
    #[error("this law has no energy with these parameters; the Newton method needs one, dynamics does not")]
    NoEnergy,
    /// A mean that is held while points are held back at a wall.
    #[error(
        "dynamics cannot hold the mean of a half-space at a wall; prescribe the mean pressure, or use Newton's method"
    )]
    NoDynamics,
    /// Parameters that make no law.
    #[error(transparent)]
    Law(#[from] LawError),
    /// Numbers so large or so small that no method can be set up.
    #[error("the search cannot start: {0}")]
    Search(#[from] RelaxError),
}

fn approach_text(found: f64, limit: Option<f64>) -> String {
    let positive = if found > 0.0 { "" } else { "positive (first touch is 0)" };
    let below = limit.map_or_else(String::new, |limit| {
        format!("less than the mean clearance {limit}, where this body would be in full contact")
    });
    let and = if positive.is_empty() || below.is_empty() { "" } else { " and " };
    format!("{positive}{and}{below}")
}

/// "a, b or c".
fn one_of(solvers: &[Solver]) -> String {
    let names: Vec<&str> = solvers.iter().map(|solver| solver.name()).collect();
    match names.split_last() {
        Some((last, [])) => (*last).to_owned(),
        Some((last, first)) => format!("{} or {last}", first.join(", ")),
        None => "none".to_owned(),
    }
}
