//! Loads at which the gap closes for a flow, found by bisection.

use gfmd_contact::{Drive, Equilibrium as _, Fields as _, Load};
use gfmd_files::{Archive, Dimension, Variable};
use gfmd_measure::Patches;
use gfmd_problem::{AnyState, Facts, Posed, key};
use gfmd_record::{COLUMNS, Column, Record, StateContext};
use gfmd_unit::Units;
use serde::{Serialize, Serializer};

use super::{Args, Loads};
use crate::progress::Progress;
use gfmd_input::failure::{Failure, reached};
use gfmd_input::session::Session;
use gfmd_run::series::{Prepared, Watching};

/// Relative width of the interval at which the bisection ends.
const WIDTH: f64 = 1e-3;

/// Interval of loads in which the gap closes along one axis: highest load with an open gap, lowest with a closed one.
#[derive(Clone, Debug)]
pub struct Threshold(Vec<(&'static Column, [f64; 2])>);

/// Names of its columns.
const NAMES: [&str; 6] =
    ["mean_pressure", "p_star", "approach", "area_fraction", "area_fraction_corrected", "mean_gap"];

/// Returns the columns, defined as for a load.
fn columns() -> impl Iterator<Item = &'static Column> {
    NAMES.iter().filter_map(|name| COLUMNS.iter().find(|column| column.name == *name))
}

impl Threshold {
    fn between(open: &Sample, closed: &Sample) -> Self {
        let both = |column: &'static Column| (column, [open, closed].map(|sample| sample.record.number(column.name)));
        Self(columns().map(both).collect())
    }

    /// Returns the numbers of a column on both sides.
    pub fn of(&self, name: &str) -> [f64; 2] {
        self.0.iter().find(|(column, _)| column.name == name).map_or([f64::NAN; 2], |(_, values)| *values)
    }
}

impl Serialize for Threshold {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(column, values)| (column.name, values)))
    }
}

/// Load of the bisection.
struct Sample {
    asked: f64,
    record: Record,
    /// True along x (y) if the gap is open for a flow.
    open: [bool; 2],
}

/// Checks that there are at least two loads to bisect.
///
/// # Errors
/// Returns an error for a single load.
pub(super) fn check(args: &Args) -> Result<(), Failure> {
    let mut loads = args.control.given_values();
    loads.sort_by(f64::total_cmp);
    loads.dedup();
    if loads.len() < 2 {
        let why = format!("one load, {loads:?}; it needs two loads or more, between which the flow stops");
        return Err(Failure::input(key("flow_threshold"), why));
    }
    Ok(())
}

impl Loads {
    /// Returns the loads at which the flow along x and along y stops; `None` if it does not stop between the lowest and
    /// the highest load.
    pub(super) fn threshold(
        &self,
        contact: &Posed,
        args: &Args,
        session: &Session,
        progress: &Progress,
    ) -> Result<[Option<Threshold>; 2], Failure> {
        let asked = |drive: &Drive| match drive.load {
            Load::MeanPressure(value) | Load::Approach(value) => value,
        };
        let values = self.drives.iter().map(asked);
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
        let mut last = None;
        let mut sample = |asked: f64| self.sample(asked, (contact, args), session, progress, &mut last);
        let mut samples = vec![sample(low)?, sample(high)?];
        let mut found = [None, None];
        for (axis, found) in found.iter_mut().enumerate() {
            loop {
                let Some(closed) = samples.iter().position(|sample| !sample.open[axis]).filter(|first| *first > 0)
                else {
                    let state = if samples[0].open[axis] { "open at the highest" } else { "closed at the lowest" };
                    let name = ["x", "y"][axis];
                    session.warn("flow-threshold", format!("the gap is {state} load for a flow along {name}"));
                    break;
                };
                let (open, closed_load) = (&samples[closed - 1], &samples[closed]);
                if closed_load.asked <= (1.0 + WIDTH) * open.asked {
                    *found = Some(Threshold::between(open, closed_load));
                    break;
                }
                let middle = (open.asked * closed_load.asked).sqrt();
                let sample = sample(middle)?;
                samples.insert(closed, sample);
            }
        }
        Ok(found)
    }

    fn sample(
        &self,
        asked: f64,
        (contact, args): (&Posed, &Args),
        session: &Session,
        progress: &Progress,
        last: &mut Option<AnyState>,
    ) -> Result<Sample, Failure> {
        let Prepared { facts, surface, .. } = &self.prepared;
        let load = if facts.approach { Load::Approach(asked) } else { Load::MeanPressure(asked) };
        let budget = args.problem.solver.search.budget();
        let place = format!("flow threshold, load {asked:e}");
        let mut watch = Watching::new(place.clone(), progress, session);
        let press = contact.press(load).solver(args.problem.solver.solver).budget(budget).starting_from(last.as_ref());
        let (state, stopped) = reached(press.watch(&mut watch).solve())?;
        if let Some(stopped) = stopped {
            return Err(stopped.at(&place));
        }
        // The samples need neither statistics nor flow.
        let plain = Facts { statistics: false, flow: false, ..*facts };
        let record = Record::of(&StateContext { facts: &plain, ..self.prepared.at(&state, budget.tolerance) });
        let mut conducting = state.pressure().mapv(|p| p <= 0.0);
        conducting.zip_mut_with(&state.gap(), |open, gap| *open &= *gap > 0.0);
        let open = Patches::of(conducting.view(), surface.boundary).percolate();
        progress.advance(
            0.0,
            &format!(
                "threshold of the flow: p* {:.4e}, area {:.4}",
                record.number("p_star"),
                record.number("area_fraction")
            ),
        );
        *last = Some(state);
        Ok(Sample { asked, record, open })
    }
}

/// Writes the loads at which the flow stops, NaN if it does not.
///
/// # Errors
/// Returns an error if the file cannot be written.
pub(super) fn write(
    archive: &mut Archive,
    units: &Units,
    facts: &Facts,
    found: &[Option<Threshold>; 2],
) -> Result<(), Failure> {
    let axis = Dimension::index("axis", 2, "axis of the flow: x, y");
    let side = Dimension::index("side", 2, "highest load at which the gap is open, lowest at which it is closed");
    for column in columns() {
        let values: Vec<f64> = found
            .iter()
            .flat_map(|found| found.as_ref().map_or([f64::NAN; 2], |found| found.of(column.name)))
            .collect();
        let units = units.name(column.unit);
        let variable = Variable { dimensions: &[&axis, &side], units: &units, long_name: column.meaning(facts) };
        archive.write(&format!("/flow_threshold/{}", column.name), &variable, &values)?;
    }
    Ok(())
}
