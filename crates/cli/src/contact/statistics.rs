//! Parts of a load added by `--statistics` and `--flow`: patches, distributions, spectra, flow through the gap.

use gfmd_contact::Fields as _;
use gfmd_flow::{Flow, Wanted};
use gfmd_green::Height;
use gfmd_measure::Patches;
use gfmd_problem::{AnyState, MemoryNeed, Posed};
use gfmd_record::{Record, StateContext, Statistics};
use ndarray::ArrayView2;

use super::{Args, Conducting};
use gfmd_input::failure::Failure;
use gfmd_input::memory;
use gfmd_input::source::Surface;
use gfmd_run::flow::through;
use gfmd_run::series::Prepared;

/// Results of the loads of one contact beside their scalars.
#[derive(Default)]
pub(super) struct Gathered {
    pub(super) loads: Vec<Statistics>,
    /// Flow of the last load that has one.
    pub(super) flow: Option<Flow>,
}

/// Measures the patches, distributions and spectra of a load.
///
/// # Errors
/// Returns an error if the fields do not fit the grid.
pub(super) fn measured(
    surface: &Surface,
    repulsion: ArrayView2<f64>,
    gap: ArrayView2<f64>,
) -> Result<(Statistics, Patches), Failure> {
    let found = Statistics::of(&surface.grid, surface.boundary, repulsion, gap);
    found.map_err(|error| Failure::computation(error.to_string()))
}

/// Returns the record of a single state with the measurements requested by the flags, and its patches, distributions
/// and spectra. `warn` receives a text for each number that is less exact than it should be.
///
/// # Errors
/// Returns an error if the contact lacks a measurement, or if one cannot be computed or needs too much memory.
pub fn measure(
    args: &Args,
    prepared: &Prepared,
    contact: &Posed,
    state: &AnyState,
    mut warn: impl FnMut(String),
) -> Result<(Record, Option<Statistics>), Failure> {
    let facts = args.facts(prepared.surface.grid.is_line());
    facts.check()?;
    if args.flow {
        memory::fits(MemoryNeed::FLOW_ALONE, "flow", prepared.surface.grid.points())?;
    }
    let conducting = Conducting::new(args, &prepared.body, &prepared.surface)?;
    let stiffness = args.problem.stiffness.of(contact, state, &mut warn);
    let gas = args.gas.given()?.map(|gas| gas.in_units(&prepared.surface.units())).transpose()?;
    let at = StateContext { facts: &facts, stiffness, gas, ..prepared.at(state, args.problem.solver.search.tolerance) };
    let fields = [state.repulsion(), state.gap().into()];
    let [repulsion, gap] = [0, 1].map(|index| fields[index].view());
    let surface = (&prepared.surface, &conducting);
    let warn = |_: &str, text: String| warn(text);
    let findings = Findings::of(args, surface, [repulsion, gap], &at, Wanted::Conductivity, warn)?;
    let record = Record::of(&StateContext { measured: findings.borrowed(), ..at });
    Ok((record, findings.arrays))
}

/// All requested measurements of one load.
#[derive(Default)]
pub(super) struct Findings {
    pub(super) arrays: Option<Statistics>,
    pub(super) flow: Option<Flow>,
    patches: Option<Patches>,
    conductance: Option<Result<f64, &'static str>>,
    electrodes: bool,
}

impl Findings {
    /// Measures a load by its repulsive pressure and its gap. `at` has its summary, residuals and stiffness; `of_flow`
    /// says whether the flow needs fields; `warn` receives the code and text for each number that is less exact than it
    /// should be.
    ///
    /// # Errors
    /// Returns an error if the fields do not fit the grid, or if a flow or a conductance cannot be computed.
    pub(super) fn of(
        args: &Args,
        (surface, conducting): (&Surface, &Conducting),
        [repulsion, gap]: [ArrayView2<f64>; 2],
        at: &StateContext,
        of_flow: Wanted,
        mut warn: impl FnMut(&'static str, String),
    ) -> Result<Self, Failure> {
        let mut found = Self::default();
        if args.statistics {
            let stiffness = at.stiffness.as_ref().ok().map(|found| found.value);
            let (conductance, warning) = conducting.measure(&repulsion, at.has_converged(), stiffness)?;
            found.conductance = Some(conductance);
            found.electrodes = args.conductor_height != Height::Infinite;
            if let Some(warning) = warning {
                warn("conductance", warning);
            }
        }
        if args.statistics || args.flow {
            // Repelled points are in contact.
            let repulsion = repulsion.mapv(|p| p.max(0.0));
            if args.statistics {
                let (arrays, patches) = measured(surface, repulsion.view(), gap)?;
                (found.arrays, found.patches) = (Some(arrays), Some(patches));
            }
            if args.flow {
                let (fields, warn) = ([repulsion.view(), gap], |text| warn("flow", text));
                found.flow = Some(through(surface, fields, at.summary.mean_gap, of_flow, warn)?);
            }
        }
        Ok(found)
    }

    /// Returns the findings in the form that the columns take.
    pub(super) fn borrowed(&self) -> gfmd_record::Measured<'_> {
        gfmd_record::Measured {
            patches: self.patches.as_ref(),
            conductance: self.conductance.map(|found| found.map_err(Into::into)),
            electrodes: self.electrodes,
            flow: self.flow.as_ref(),
        }
    }
}
