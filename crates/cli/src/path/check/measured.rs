//! Check of the measurements at the waypoints.

use gfmd_flow::Wanted;
use gfmd_measure::Summary;
use gfmd_problem::AnyState;
use gfmd_record::{Record, StateContext, Statistics};
use ndarray::{Array2, ArrayRef2};

use super::StepCheck;
use crate::measuring::{Findings, Touching, measured};
use gfmd_check::result::Comparison;
use gfmd_input::failure::Failure;
use gfmd_run::flow::through;
use gfmd_run::series::Prepared;

/// Numbers of the points in contact.
const PATCHES: [&str; 6] =
    ["patches", "largest_patch_fraction", "percolates_x", "percolates_y", "conductance", "contact_conductance"];

impl StepCheck<'_> {
    /// Measures the statistics of all solved waypoints, if they are requested.
    pub(super) fn statistics(&self, waypoints: usize) -> Result<Vec<Statistics>, Failure> {
        let Prepared { facts, surface, .. } = self.stored.prepared;
        let mut found = Vec::new();
        for place in (0..waypoints).filter(|_| facts.statistics) {
            let [repulsion, gap] = self.stored.contact_and_gap(place, None)?;
            // A waypoint that was not reached has no numbers.
            if repulsion.iter().chain(&gap).all(|value| value.is_finite()) {
                found.push(measured(surface, repulsion.mapv(|p| p.max(0.0)).view(), gap.view())?.0);
            }
        }
        Ok(found)
    }

    /// Returns the record of the state at a waypoint, given its numbers so far, with the measurements of the stored
    /// fields.
    pub(super) fn record(&self, waypoint: usize, state: &AnyState, at: StateContext) -> Result<Record, Failure> {
        let touching = Touching::with_fields(self.stored.contact_and_gap(waypoint, Some(state))?, &at);
        let surface = (&self.stored.prepared.surface, self.conducting);
        let findings = Findings::of(&self.args.measure, surface, &touching, Wanted::Conductivity, |_, _| {})?;
        Ok(Record::of(&StateContext { measured: findings.borrowed(), ..at }))
    }

    /// Compares the flow with the flow through the stored gap.
    pub(super) fn flow(&self, waypoint: usize, step: usize, comparison: &mut Comparison) -> Result<(), Failure> {
        let file = self.stored;
        let (number, Prepared { facts, surface, .. }) = (|name: &str| file.number(name, step), file.prepared);
        let mean_gap = number("mean_gap");
        if !facts.flow || mean_gap <= 0.0 {
            return Ok(());
        }
        let [pressure, gap] = [file.field("pressure", waypoint)?, file.field("gap", waypoint)?];
        let (mut repulsion, floor) = self.repulsion(&pressure, &gap);
        let least = self.args.steps.search.tolerance * floor;
        repulsion.mapv_inplace(|p| if p > least { p } else { 0.0 });
        let found = through(surface, [repulsion.view(), gap.view()], mean_gap, Wanted::Conductivity, |_| {})?;
        for (row, column, name) in [(0, 0, "flow_xx"), (0, 1, "flow_xy"), (1, 0, "flow_yx"), (1, 1, "flow_yy")] {
            comparison.number(&format!("/path/{name}"), number(name), found.conductivity[row][column], 1e-3);
        }
        if let Some(fluid) = self.args.asked()?.fluid {
            for (axis, name) in ["leak_x", "leak_y"].into_iter().enumerate() {
                let through = if found.percolates[axis] { found.conductivity[axis][axis] } else { 0.0 };
                let leak = fluid.leak(axis, through, mean_gap, surface.grid.lengths());
                comparison.number(&format!("/path/{name}"), number(name), leak, 1e-3);
            }
        }
        Ok(())
    }

    /// Compares the conductance of the gas with its value in the stored gap.
    pub(super) fn gas(&self, waypoint: usize, step: usize, comparison: &mut Comparison) -> Result<(), Failure> {
        let file = self.stored;
        let Some(gas) = self.args.asked()?.gas else { return Ok(()) };
        let gas = gas.in_units(&file.prepared.surface.units())?;
        let [pressure, gap] = [file.field("pressure", waypoint)?, file.field("gap", waypoint)?];
        let (repulsion, floor) = self.repulsion(&pressure, &gap);
        let least = self.args.steps.search.tolerance * floor;
        let repulsion = repulsion.mapv(|p| if p > least { p } else { 0.0 });
        let found = gas.conductance(repulsion.view(), gap.view());
        let found = found.map_err(|error| Failure::refused(error.to_string()))?;
        comparison.number("/path/gas_conductance", file.number("gas_conductance", step), found, 1e-3);
        Ok(())
    }

    /// Compares patches and conductance with their values for the stored points in contact.
    pub(super) fn patches(&self, waypoint: usize, step: usize, comparison: &mut Comparison) -> Result<(), Failure> {
        let file = self.stored;
        let Prepared { facts, surface, .. } = file.prepared;
        if !facts.statistics {
            return Ok(());
        }
        let fields = file.contact_and_gap(waypoint, None)?;
        let none = Array2::zeros((0, 0));
        let [repulsion, gap] = fields.each_ref().map(|field| field.view());
        let (mean, scales) = (file.number("mean_pressure", step), file.prepared.scales());
        let summary = Summary::of(repulsion, none.view(), gap, mean, &scales, surface.boundary);
        let at = StateContext::of_summary(facts, summary);
        let measure = self.args.measure.without_flow();
        let touching = Touching::with_fields(fields, &at);
        let findings = Findings::of(&measure, (surface, self.conducting), &touching, Wanted::Conductivity, |_, _| {})?;
        let conductivity = self.args.asked()?.conductivity;
        let at = StateContext { points: surface.grid.len(), conductivity, measured: findings.borrowed(), ..at };
        let found = Record::of(&at);
        for name in PATCHES.into_iter().filter(|name| found.has(name)) {
            comparison.number(&file.path(name), file.number(name, step), found.number(name), 0.0);
        }
        Ok(())
    }

    /// Compares the stiffness with its value from the stored pressure and gap. Beside a law that shears the surfaces it
    /// also depends on their lateral displacement, which is not stored.
    pub(super) fn stiffness(&self, waypoint: usize, step: usize, comparison: &mut Comparison) -> Result<(), Failure> {
        let file = self.stored;
        if file.prepared.facts.shears_by_law() {
            return Ok(());
        }
        let faces = self.faces(waypoint)?;
        let fields: Vec<[&ArrayRef2<f64>; 2]> = faces.iter().map(|face| [&*face.pressure, &*face.gap]).collect();
        let found = self.args.stiffness.of_fields(file.contact, &fields);
        // Infinite in full contact, which a file says by its reason, without a value or an error.
        let found = found.ok().filter(|found| found.value.is_finite());
        let [value, error] = found.map_or([f64::NAN; 2], |found| [found.value, found.error]);
        comparison.number("/path/stiffness", file.number("stiffness", step), value, 0.0);
        comparison.number("/path/stiffness_error", file.number("stiffness_error", step), error, 1e-3);
        Ok(())
    }
}
