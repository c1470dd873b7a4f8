//! Measurements of a single state, for Python.

use gfmd_flow::Wanted;
use gfmd_problem::{AnyState, MemoryNeed, Posed};
use gfmd_record::{Record, StateContext, Statistics};

use super::Args;
use crate::measuring::{Conducting, Findings, Touching};
use gfmd_input::failure::Failure;
use gfmd_input::memory;
use gfmd_run::series::Prepared;

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
    let facts = args.asked()?.facts(args.series(), prepared.surface.grid.is_line());
    facts.check()?;
    if args.measure.flow {
        memory::fits(MemoryNeed::FLOW_ALONE, "flow", prepared.surface.grid.points())?;
    }
    let conducting = Conducting::new(&args.measure, prepared, args.problem.solver.solver)?;
    let stiffness = args.problem.stiffness.of(contact, state, &mut warn);
    let gas = args.measure.gas.given()?.map(|gas| gas.in_units(&prepared.surface.units())).transpose()?;
    let at = StateContext { facts: &facts, stiffness, gas, ..prepared.at(state, args.problem.solver.search.tolerance) };
    let surface = (&prepared.surface, &conducting);
    let warn = |_: &str, text: String| warn(text);
    let findings = Findings::of(&args.measure, surface, &Touching::of(state, &at), Wanted::Conductivity, warn)?;
    let record = Record::of(&StateContext { measured: findings.borrowed(), ..at });
    Ok((record, findings.arrays))
}
