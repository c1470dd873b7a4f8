use std::borrow::Cow;

use gfmd_contact::{Effort, Fields as _, Stiffness};
use gfmd_field::Grid;
use gfmd_flow::Flow;
use gfmd_interface::{Quasistatic as _, Reading, Step};
use gfmd_measure::{Patches, Scales, Summary};
use gfmd_problem::{Facts, Posed, Rest};

/// The reason why a load without a state at rest has no stiffness.
pub const NOT_SOLVED: &str = "the load is not solved";

/// All from which the columns of a state are computed.
#[derive(Clone)]
pub struct At<'a> {
    /// The parts of the problem.
    pub facts: &'a Facts,
    /// The state; none for a number that does not need it.
    pub rest: Option<&'a Rest>,
    /// Lengths of the cell or patch, and number of points.
    pub lengths: [f64; 2],
    /// Number of points.
    pub points: usize,
    /// The summary, in reduced quantities of the problem.
    pub summary: Summary,
    /// Rigid approach, length.
    pub approach: f64,
    /// Effort of the search.
    pub effort: Effort,
    /// The residuals by name.
    pub residuals: Vec<(&'static str, f64)>,
    /// Tolerance of the residuals.
    pub tolerance: f64,
    /// Wall time, s.
    pub seconds: f64,
    /// The stiffness, or the reason why there is none.
    pub stiffness: Result<Stiffness, Cow<'static, str>>,
    /// The measurements of the contact and its gap.
    pub measured: Measured<'a>,
    /// The step of a path that led to the state, and the forces and energies of the state.
    pub step: Option<(&'a Step, Reading)>,
}

/// Measurements of a contact that are made if they are asked for.
#[derive(Clone, Default)]
pub struct Measured<'a> {
    /// The patches of points in contact.
    pub patches: Option<&'a Patches>,
    /// The conductance, 1/length, or the reason why there is none.
    pub conductance: Option<Result<f64, Cow<'static, str>>>,
    /// The flow through the gap.
    pub flow: Option<&'a Flow>,
    /// The reason why the error of the flow by the grid is not known.
    pub not_calibrated: Option<String>,
}

impl<'a> At<'a> {
    /// A state of a problem whose surface has this `grid`, reduced by its own scales. It has no stiffness yet.
    pub fn new(facts: &'a Facts, rest: &'a Rest, problem: &Posed, grid: &Grid, tolerance: f64) -> Self {
        let reading = problem.reading(rest);
        Self { approach: reading.approach, ..Self::in_scales(facts, rest, &rest.scales(), grid, tolerance) }
            .stiff(problem)
    }

    /// A state in these scales, without a stiffness.
    pub fn in_scales(facts: &'a Facts, rest: &'a Rest, scales: &Scales, grid: &Grid, tolerance: f64) -> Self {
        Self {
            facts,
            rest: Some(rest),
            lengths: grid.lengths(),
            points: grid.len(),
            summary: rest.summary_in(scales),
            approach: rest.approach(),
            effort: rest.effort(),
            residuals: rest.residuals(),
            tolerance,
            seconds: f64::NAN,
            stiffness: Err(NOT_SOLVED.into()),
            measured: Measured::default(),
            step: None,
        }
    }

    /// The largest residual; NaN if one is NaN.
    pub fn worst(&self) -> f64 {
        self.residuals.iter().fold(0.0, |worst: f64, (_, residual)| {
            if residual.is_nan() || worst.is_nan() { f64::NAN } else { worst.max(*residual) }
        })
    }

    /// True if all residuals are at most the tolerance.
    pub fn has_converged(&self) -> bool {
        self.worst() <= self.tolerance
    }

    /// The residual of this name; NaN if the state has none.
    pub(crate) fn residual(&self, name: &str) -> f64 {
        self.residuals.iter().find(|(other, _)| *other == name).map_or(f64::NAN, |(_, residual)| *residual)
    }

    fn stiff(self, problem: &Posed) -> Self {
        use gfmd_problem::NoStiffness::{Inexact, Undefined};
        let stiffness = match self.rest.map(|rest| problem.stiffness(rest)) {
            Some(Ok(stiffness) | Err(Inexact(stiffness, _))) => Ok(stiffness),
            Some(Err(Undefined(reason))) => Err(reason.into()),
            None => Err(NOT_SOLVED.into()),
        };
        Self { stiffness, ..self }
    }
}
