use std::borrow::Cow;
use std::cell::OnceCell;

use gfmd_contact::{Effort, Fields as _, Stiffness};
use gfmd_field::{Grid, Share};
use gfmd_flow::{Flow, Fluid};
use gfmd_interface::{Quasistatic as _, Reading, Step};
use gfmd_measure::{GapGas, Patches, Peak, Scales, Summary};
use gfmd_problem::{AnyState, Facts, Posed};

use crate::Record;

/// Reason why a load without a state at rest has no stiffness.
pub const NOT_SOLVED: &str = "the load is not solved";

/// Input from which the columns of a state are computed.
#[derive(Clone)]
pub struct StateContext<'a> {
    /// Parts of the problem.
    pub facts: &'a Facts,
    /// State; `None` for numbers that do not need it.
    pub rest: Option<&'a AnyState>,
    /// Lengths of the cell or patch.
    pub lengths: [f64; 2],
    /// Distance between points along x and y, length.
    pub spacing: [f64; 2],
    /// Number of points.
    pub points: usize,
    /// Share of the mean square gradient of the surface in waves shorter than four points; NaN if unknown.
    pub short_waves: f64,
    /// Number of waves that share the mean square gradient of the surface; NaN if unknown.
    pub waves: f64,
    /// Rms slopes of the surface along x and y, from differences; NaN if unknown.
    pub slopes: [f64; 2],
    /// Height of the surface's top above the highest grid point, length; `None` if unknown.
    pub rise: Option<f64>,
    /// Rows of this process; `None` if it has all.
    pub share: Option<Share>,
    /// Process zone of the law at a contact edge, divided by the zone needed to resolve this law; `None` without a
    /// process zone.
    pub process_zone: Option<f64>,
    /// Records of the same load on a grid with twice as many points along each side: one, or two for two ways of
    /// interpolating between known heights. An error is the reason why a record is missing.
    pub finer: Vec<Result<OnFinerGrid, String>>,
    /// Peak of the pressure, computed on first use.
    pub peak: OnceCell<Option<Peak>>,
    /// True if a point at the rim is pressed, found on first use.
    pub rim: OnceCell<Option<bool>>,
    /// Scales of reduced quantities.
    pub scales: Scales,
    /// Summary in these scales.
    pub summary: Summary,
    /// Rigid approach, length.
    pub approach: f64,
    /// Effort of the search.
    pub effort: Effort,
    /// Residuals by name.
    pub residuals: Vec<(&'static str, f64)>,
    /// Tolerance of the residuals.
    pub tolerance: f64,
    /// Wall time, s.
    pub seconds: f64,
    /// Stiffness, or the reason why there is none.
    pub stiffness: Result<Stiffness, Cow<'static, str>>,
    /// Measurements of the contact and its gap.
    pub measured: Measured<'a>,
    /// Conductivity of both conductors in series, 1/(1/k1 + 1/k2), if it is given.
    pub conductivity: Option<f64>,
    /// Gas in the gap, if its conductance is computed.
    pub gas: Option<GapGas>,
    /// Fluid that flows through the gap, if its leak is computed.
    pub fluid: Option<Fluid>,
    /// Step of a path that led to the state, with the forces and energies of the state.
    pub step: Option<(&'a Step, Reading)>,
}

/// Load on a grid with twice as many points along each side.
#[derive(Clone)]
pub struct OnFinerGrid {
    /// Numbers of the load.
    pub record: Record,
    /// Height of the surface's top above the highest point of that grid, length; `None` if unknown.
    pub rise: Option<f64>,
}

impl OnFinerGrid {
    /// Returns the numbers of a state on the finer grid.
    pub fn of(at: &StateContext) -> Self {
        Self { record: Record::of(at), rise: at.rise }
    }
}

/// Optional measurements of a contact.
#[derive(Clone, Default)]
pub struct Measured<'a> {
    /// Patches of points in contact.
    pub patches: Option<&'a Patches>,
    /// Conductance, 1/length, or the reason why there is none.
    pub conductance: Option<Result<f64, Cow<'static, str>>>,
    /// True if the electrodes lie at a finite depth.
    pub electrodes: bool,
    /// Flow through the gap.
    pub flow: Option<&'a Flow>,
}

impl<'a> StateContext<'a> {
    /// Describes a state of `problem` on `grid`, reduced by its own scales, with its stiffness.
    pub fn new(facts: &'a Facts, rest: &'a AnyState, problem: &Posed, grid: &Grid, tolerance: f64) -> Self {
        let reading = problem.reading(rest);
        Self { approach: reading.approach, ..Self::in_scales(facts, rest, &rest.scales(), grid, tolerance) }
            .stiff(problem, Stiffness::TOLERANCE)
    }

    /// Describes a state in the given scales, without a stiffness.
    pub fn in_scales(facts: &'a Facts, rest: &'a AnyState, scales: &Scales, grid: &Grid, tolerance: f64) -> Self {
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

    /// Describes a state by its summary alone; it counts as converged.
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
            share: None,
            process_zone: None,
            finer: Vec::new(),
            peak: OnceCell::new(),
            rim: OnceCell::new(),
            scales: Scales { contact_modulus: f64::NAN, rms_gradient: f64::NAN },
            summary,
            approach: f64::NAN,
            effort: Effort::default(),
            residuals: Vec::new(),
            tolerance: f64::INFINITY,
            seconds: f64::NAN,
            stiffness: Err(NOT_SOLVED.into()),
            measured: Measured::default(),
            conductivity: None,
            gas: None,
            fluid: None,
            step: None,
        }
    }

    /// Returns the peak of the pressure; `None` without a state.
    pub(crate) fn peak(&self) -> Option<Peak> {
        *self.peak.get_or_init(|| {
            let pressure = self.rest?.pressure();
            match &self.share {
                Some(share) => Peak::distributed(share, pressure.view()),
                None => Peak::of(pressure.view()),
            }
        })
    }

    /// Returns true if a point at the rim of the grid is pressed; `None` without the whole field.
    pub(crate) fn reaches_rim(&self) -> Option<bool> {
        *self.rim.get_or_init(|| {
            let pressure = self.rest?.pressure();
            let shared = self.share.as_ref().filter(|share| !share.is_whole());
            let (first, nx) = shared.map_or((0, pressure.nrows()), |share| {
                (share.rows().start, share.all_rows().last().map_or(0, |rows| rows.end))
            });
            let ny = pressure.ncols();
            // A profile has one row, and ends at two points.
            let is_side = |j: usize| ny > 1 && (j == 0 || j + 1 == ny);
            let is_rim = |(i, j): (usize, usize)| first + i == 0 || first + i + 1 == nx || is_side(j);
            let is_pressed = pressure.indexed_iter().any(|(place, pressure)| is_rim(place) && *pressure > 0.0);
            let is_pressed = shared.map_or(is_pressed, |share| share.any(is_pressed));
            (nx * ny == self.points).then_some(is_pressed)
        })
    }

    /// Returns the largest residual; NaN if one is NaN.
    pub fn worst(&self) -> f64 {
        self.residuals.iter().fold(0.0, |worst: f64, (_, residual)| {
            if residual.is_nan() || worst.is_nan() { f64::NAN } else { worst.max(*residual) }
        })
    }

    /// Returns true if no residual exceeds the tolerance.
    pub fn has_converged(&self) -> bool {
        self.worst() <= self.tolerance
    }

    /// Returns the residual of this name; NaN if the state has none.
    pub(crate) fn residual(&self, name: &str) -> f64 {
        self.residuals.iter().find(|(other, _)| *other == name).map_or(f64::NAN, |(_, residual)| *residual)
    }

    /// Adds the contact stiffness of the state, computed to the relative error `tolerance`.
    #[must_use]
    pub fn stiff(self, problem: &Posed, tolerance: f64) -> Self {
        use gfmd_problem::NoStiffness::{Inexact, Undefined};
        let stiffness = match self.rest.map(|rest| problem.stiffness(rest, tolerance)) {
            Some(Ok(stiffness) | Err(Inexact(stiffness, _))) => Ok(stiffness),
            Some(Err(Undefined(reason))) => Err(reason),
            None => Err(NOT_SOLVED.into()),
        };
        Self { stiffness, ..self }
    }
}
