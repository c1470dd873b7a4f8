//! Numbers and arrays measured for one state.

use std::borrow::Cow;

use gfmd_contact::Fields as _;
use gfmd_field::Share;
use gfmd_flow::{Flow, Wanted};
use gfmd_green::Height;
use gfmd_measure::Patches;
use gfmd_problem::AnyState;
use gfmd_record::{Measured, StateContext, Statistics};
use gfmd_run::flow::through;
use gfmd_run::series::{Chosen, Prepared};
use ndarray::{Array2, ArrayView2, CowArray, Ix2};

use super::{Conducting, MeasureArgs};
use gfmd_input::failure::Failure;
use gfmd_input::rows;
use gfmd_input::source::Surface;

/// Results of the states of one contact beside their scalars.
#[derive(Default)]
pub(crate) struct Gathered {
    /// Statistics of the states with a place in the file.
    pub(crate) states: Vec<Statistics>,
    /// Flow of the last state that has one.
    pub(crate) flow: Option<Flow>,
}

/// Measures the patches, distributions and spectra of a state by its repulsive pressure, zero out of contact.
///
/// # Errors
/// Returns an error if the fields do not fit the grid.
pub(crate) fn measured(
    surface: &Surface,
    repulsion: ArrayView2<f64>,
    gap: ArrayView2<f64>,
) -> Result<(Statistics, Patches), Failure> {
    let found = Statistics::of(&surface.grid, surface.boundary, repulsion, gap);
    found.map_err(|error| Failure::computation(error.to_string()))
}

/// Measures the statistics of a kept state again, from its chosen fields; `None` if they are not requested.
///
/// # Errors
/// Returns an error if the fields do not fit the grid.
pub(crate) fn recalled(
    Prepared { facts, surface, .. }: &Prepared,
    chosen: &Chosen,
    fields: &[Cow<[f64]>],
) -> Result<Option<Statistics>, Failure> {
    let places = chosen.contact_and_gap(facts).filter(|_| facts.statistics);
    let Some([repulsion, gap]) = places.and_then(|[p, g]| Some([fields.get(p)?, fields.get(g)?])) else {
        return Ok(None);
    };
    let field = |values| ArrayView2::from_shape(surface.grid.points(), values);
    let unusable = |error: ndarray::ShapeError| Failure::refused(error.to_string());
    let (repulsion, gap) = (field(repulsion).map_err(unusable)?, field(gap).map_err(unusable)?);
    let repulsion = repulsion.mapv(|p| p.max(0.0));
    Ok(Some(measured(surface, repulsion.view(), gap)?.0))
}

/// Two surfaces that touch: what the measurements take from a state.
pub(crate) struct Touching<'a> {
    /// Repulsive pressure, positive at points in contact.
    repulsion: CowArray<'a, f64, Ix2>,
    gap: CowArray<'a, f64, Ix2>,
    mean_gap: f64,
    has_converged: bool,
    stiffness: Option<f64>,
}

impl<'a> Touching<'a> {
    /// Returns the surfaces of a state, whose numbers so far are `at`.
    pub(crate) fn of(state: &'a AnyState, at: &StateContext) -> Self {
        Self::with_fields([state.repulsion(), state.gap().into()], at)
    }

    /// Returns the surfaces of a state with stored `fields`: repulsive pressure and gap.
    pub(crate) fn with_fields([repulsion, gap]: [CowArray<'a, f64, Ix2>; 2], at: &StateContext) -> Self {
        let stiffness = at.stiffness.as_ref().ok().map(|found| found.value);
        Self { repulsion, gap, mean_gap: at.summary.mean_gap, has_converged: at.has_converged(), stiffness }
    }

    /// Gathers the whole surfaces at the first process; returns `None` at the others.
    fn gathered(&self, share: &Share) -> Option<Touching<'static>> {
        let Self { repulsion, gap, mean_gap, has_converged, stiffness } = self;
        let [repulsion, gap] = [repulsion, gap].map(|field| rows::gathered(share, field.view()));
        let (repulsion, gap) = (repulsion?.into(), gap?.into());
        Some(Touching { repulsion, gap, mean_gap: *mean_gap, has_converged: *has_converged, stiffness: *stiffness })
    }
}

/// All requested measurements of one state.
#[derive(Default)]
pub(crate) struct Findings {
    /// Arrays of the statistics.
    pub(crate) arrays: Option<Statistics>,
    /// Flow through the gap.
    pub(crate) flow: Option<Flow>,
    patches: Option<Patches>,
    conductance: Option<Result<f64, &'static str>>,
    electrodes: bool,
}

impl Findings {
    /// Measures a state; `of_flow` says whether the flow needs fields, `warn` receives the code and text for each
    /// number that is less exact than it should be. The first of several processes measures whole fields, the others
    /// find nothing.
    ///
    /// # Errors
    /// Returns an error if the fields do not fit the grid, or if a flow or a conductance cannot be computed.
    pub(crate) fn of(
        args: &MeasureArgs,
        (surface, conducting): (&Surface, &Conducting),
        touching: &Touching,
        of_flow: Wanted,
        warn: impl FnMut(&'static str, String),
    ) -> Result<Self, Failure> {
        let share = &surface.share;
        if share.is_whole() || !(args.statistics || args.flow) {
            return Self::of_whole(args, (surface, conducting), touching, of_flow, warn);
        }
        let whole = touching.gathered(share);
        whole.map_or(Ok(Self::default()), |whole| Self::of_whole(args, (surface, conducting), &whole, of_flow, warn))
    }

    fn of_whole(
        args: &MeasureArgs,
        (surface, conducting): (&Surface, &Conducting),
        touching: &Touching,
        of_flow: Wanted,
        mut warn: impl FnMut(&'static str, String),
    ) -> Result<Self, Failure> {
        let (mut found, gap) = (Self::default(), touching.gap.view());
        if args.statistics {
            let Touching { repulsion, has_converged, stiffness, .. } = touching;
            let (conductance, warning) = conducting.measure(repulsion, *has_converged, *stiffness)?;
            found.conductance = Some(conductance);
            found.electrodes = args.conductor_height != Height::Infinite;
            if let Some(warning) = warning {
                warn("conductance", warning);
            }
        }
        if args.statistics || args.flow {
            // Repelled points are in contact.
            let repulsion: Array2<f64> = touching.repulsion.mapv(|p| p.max(0.0));
            if args.statistics {
                let (arrays, patches) = measured(surface, repulsion.view(), gap)?;
                (found.arrays, found.patches) = (Some(arrays), Some(patches));
            }
            if args.flow {
                let warn = |text| warn("flow", text);
                found.flow = Some(through(surface, [repulsion.view(), gap], touching.mean_gap, of_flow, warn)?);
            }
        }
        Ok(found)
    }

    /// Returns the findings in the form that the columns take.
    pub(crate) fn borrowed(&self) -> Measured<'_> {
        Measured {
            patches: self.patches.as_ref(),
            conductance: self.conductance.map(|found| found.map_err(Into::into)),
            electrodes: self.electrodes,
            flow: self.flow.as_ref(),
        }
    }
}
