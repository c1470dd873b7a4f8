use std::borrow::Cow;
use std::cell::OnceCell;

use gfmd_contact::{Effort, Fields as _, Stiffness};
use gfmd_field::Grid;
use gfmd_flow::Flow;
use gfmd_interface::{Quasistatic as _, Reading, Step};
use gfmd_measure::{Patches, Peak, Scales, Summary};
use gfmd_problem::{Facts, Posed, Rest};

use crate::Record;

/// The reason why a load without a state at rest has no stiffness.
pub const NOT_SOLVED: &str = "the load is not solved";

/// All from which the columns of a state are computed.
#[derive(Clone)]
pub struct At<'a> {
    /// The parts of the problem.
    pub facts: &'a Facts,
    /// The state; none for a number that does not need it.
    pub rest: Option<&'a Rest>,
    /// Lengths of the cell or patch.
    pub lengths: [f64; 2],
    /// Distance between points along x and along y, length.
    pub spacing: [f64; 2],
    /// Number of points.
    pub points: usize,
    /// The share of the mean square gradient of the surface in waves shorter than four points; NaN if it is not known.
    pub short_waves: f64,
    /// The number of waves that share the mean square gradient of the surface; NaN if it is not known.
    pub waves: f64,
    /// The rms slopes of the surface along x and y, by differences; NaN if they are not known.
    pub slopes: [f64; 2],
    /// Height of the surface's top above the highest point of the grid, length; `None` if it is not known.
    pub rise: Option<f64>,
    /// The process zone of the law at the edge of a contact over the one that this law needs to be resolved; `None`
    /// without one.
    pub process_zone: Option<f64>,
    /// The records of the same load on a grid of twice as many points along each side: one, or one for each of two ways
    /// to place heights between those that are known; in place of a record, the reason why there is none.
    pub finer: Vec<Result<OnFinerGrid, String>>,
    /// The peak of the pressure, found when it is first asked for.
    pub peak: OnceCell<Option<Peak>>,
    /// The scales of reduced quantities.
    pub scales: Scales,
    /// The summary, in these scales.
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

/// A load on a grid of twice as many points along each side.
#[derive(Clone)]
pub struct OnFinerGrid {
    /// Its numbers.
    pub record: Record,
    /// Height of the surface's top above the highest point of that grid, length; `None` if it is not known.
    pub rise: Option<f64>,
}

impl OnFinerGrid {
    /// The numbers of a state there.
    pub fn of(at: &At) -> Self {
        Self { record: Record::of(at), rise: at.rise }
    }
}

/// Measurements of a contact that are made if they are asked for.
#[derive(Clone, Default)]
pub struct Measured<'a> {
    /// The patches of points in contact.
    pub patches: Option<&'a Patches>,
    /// The conductance, 1/length, or the reason why there is none.
    pub conductance: Option<Result<f64, Cow<'static, str>>>,
    /// True if its electrodes lie at a finite depth.
    pub electrodes: bool,
    /// The flow through the gap.
    pub flow: Option<&'a Flow>,
}

impl<'a> At<'a> {
    /// A state of a problem whose surface has this `grid`, reduced by its own scales. It has no stiffness yet.
    pub fn new(facts: &'a Facts, rest: &'a Rest, problem: &Posed, grid: &Grid, tolerance: f64) -> Self {
        let reading = problem.reading(rest);
        Self { approach: reading.approach, ..Self::in_scales(facts, rest, &rest.scales(), grid, tolerance) }
            .stiff(problem, Stiffness::TOLERANCE)
    }

    /// A state in these scales, without a stiffness.
    pub fn in_scales(facts: &'a Facts, rest: &'a Rest, scales: &Scales, grid: &Grid, tolerance: f64) -> Self {
        Self {
            rest: Some(rest),
            lengths: grid.lengths(),
            spacing: grid.spacing(),
            points: grid.len(),
            scales: *scales,
            approach: rest.approach(),
            effort: rest.effort(),
            residuals: rest.residuals(),
            tolerance,
            ..Self::of_summary(facts, rest.summary_in(scales))
        }
    }

    /// The numbers of a state of which no more is known; they are taken as converged.
    pub fn of_summary(facts: &'a Facts, summary: Summary) -> Self {
        Self {
            facts,
            rest: None,
            lengths: [f64::NAN; 2],
            spacing: [f64::NAN; 2],
            points: 0,
            short_waves: f64::NAN,
            waves: f64::NAN,
            slopes: [f64::NAN; 2],
            rise: None,
            process_zone: None,
            finer: Vec::new(),
            peak: OnceCell::new(),
            scales: Scales { contact_modulus: f64::NAN, rms_gradient: f64::NAN },
            summary,
            approach: f64::NAN,
            effort: Effort::default(),
            residuals: Vec::new(),
            tolerance: f64::INFINITY,
            seconds: f64::NAN,
            stiffness: Err(NOT_SOLVED.into()),
            measured: Measured::default(),
            step: None,
        }
    }

    /// The peak of the pressure; `None` if the whole field is not there.
    pub(crate) fn peak(&self) -> Option<Peak> {
        *self.peak.get_or_init(|| {
            let pressure = self.rest?.pressure();
            if pressure.len() == self.points { Peak::of(pressure.view()) } else { None }
        })
    }

    /// True if a point at the rim of the grid is pressed; `None` if the whole field is not there.
    pub(crate) fn reaches_rim(&self) -> Option<bool> {
        let pressure = self.rest?.pressure();
        let (nx, ny) = pressure.dim();
        let is_rim = |(i, j): (usize, usize)| i == 0 || j == 0 || i + 1 == nx || j + 1 == ny;
        let mut points = pressure.indexed_iter();
        (pressure.len() == self.points).then(|| points.any(|(place, pressure)| is_rim(place) && *pressure > 0.0))
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

    /// The same with its stiffness, that of the problem of the state, to this relative error.
    #[must_use]
    pub fn stiff(self, problem: &Posed, tolerance: f64) -> Self {
        use gfmd_problem::NoStiffness::{Inexact, Undefined};
        let stiffness = match self.rest.map(|rest| problem.stiffness(rest, tolerance)) {
            Some(Ok(stiffness) | Err(Inexact(stiffness, _))) => Ok(stiffness),
            Some(Err(Undefined(reason))) => Err(reason.into()),
            None => Err(NOT_SOLVED.into()),
        };
        Self { stiffness, ..self }
    }
}
