//! The loads at which the gap closes for a flow, by bisection.

use gfmd_contact::{Drive, Equilibrium as _, Fields as _, Load};
use gfmd_files::{Archive, Dimension, Variable};
use gfmd_measure::Patches;
use gfmd_problem::{Facts, Posed, Rest};
use gfmd_record::{At, Record};
use serde::Serialize;

use super::{Args, Loads};
use crate::progress::Progress;
use gfmd_run::failure::{Failure, reached};
use gfmd_run::series::{Prepared, Watching};
use gfmd_run::session::Session;

/// The relative width of the interval at which the bisection ends.
const WIDTH: f64 = 1e-3;

/// The interval of loads in which the gap closes along one axis: the highest load at which it was open, and the lowest at
/// which it was closed.
#[derive(Clone, Debug, Serialize)]
pub struct Threshold {
    pub mean_pressure: [f64; 2],
    pub p_star: [f64; 2],
    pub displacement: [f64; 2],
    pub area_fraction: [f64; 2],
    pub area_fraction_corrected: [f64; 2],
    pub mean_gap: [f64; 2],
}

impl Threshold {
    fn between(open: &Sample, closed: &Sample) -> Self {
        let both = |name: &str| [open, closed].map(|sample| sample.record.number(name));
        Self {
            mean_pressure: both("mean_pressure"),
            p_star: both("p_star"),
            displacement: both("displacement"),
            area_fraction: both("area_fraction"),
            area_fraction_corrected: both("area_fraction_corrected"),
            mean_gap: both("mean_gap"),
        }
    }
}

/// A load of the bisection.
struct Sample {
    asked: f64,
    record: Record,
    /// True along x (y) if something can flow.
    open: [bool; 2],
}

/// Checks that there is something to bisect.
///
/// # Errors
/// A single load.
pub(super) fn check(args: &Args) -> Result<(), Failure> {
    let given = args.control.given();
    let mut loads: Vec<f64> =
        given.into_iter().flat_map(|(_, values)| gfmd_problem::options::values::numbers(values)).collect();
    loads.sort_by(f64::total_cmp);
    loads.dedup();
    if loads.len() < 2 {
        let found =
            format!("--flow-threshold: one load, {loads:?}; it needs two loads or more, between which the flow stops");
        return Err(Failure::Input(found));
    }
    Ok(())
}

impl Loads {
    /// The loads at which the flow along x and along y stops; none where it does not do so between the lowest and the highest load.
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
        last: &mut Option<Rest>,
    ) -> Result<Sample, Failure> {
        let Prepared { facts, surface, .. } = &self.prepared;
        let load = if facts.approach { Load::Approach(asked) } else { Load::MeanPressure(asked) };
        let budget = args.problem.solver.budget();
        let place = format!("--flow-threshold, load {asked:e}");
        let mut watch = Watching::new(place.clone(), progress, session);
        let press = contact.press(load).solver(args.problem.solver.solver).budget(budget).starting_from(last.as_ref());
        let (state, stopped) = reached(press.watch(&mut watch).solve())?;
        if let Some(stopped) = stopped {
            return Err(stopped.at(&place));
        }
        // Neither statistics nor flow are measured on the way.
        let plain = Facts { statistics: false, flow: false, ..*facts };
        let scales = self.prepared.scales();
        let record = Record::of(&At::in_scales(&plain, &state, &scales, &surface.grid, budget.tolerance));
        let mut conducting = state.pressure().mapv(|p| p <= 0.0);
        conducting.zip_mut_with(&state.gap(), |open, gap| *open &= *gap > 0.0);
        let open = Patches::of(conducting.view(), surface.boundary.surroundings()).percolate();
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

/// Writes the loads at which the flow stops, NaN where it does not.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write(archive: &mut Archive, unit: &str, found: &[Option<Threshold>; 2]) -> Result<(), Failure> {
    let axis = Dimension::index("axis", 2, "axis of the flow: x, y");
    let side = Dimension::index("side", 2, "highest load at which the gap is open, lowest at which it is closed");
    let mut column = |name: &str, units: &str, long_name: &str, of: fn(&Threshold) -> [f64; 2]| {
        let values: Vec<f64> = found.iter().flat_map(|found| found.as_ref().map_or([f64::NAN; 2], of)).collect();
        let variable = Variable { dimensions: &[&axis, &side], units, long_name };
        archive.write(&format!("/flow_threshold/{name}"), &variable, &values)
    };
    column("mean_pressure", "stress", "mean pressure", |found| found.mean_pressure)?;
    column("p_star", "1", "reduced pressure", |found| found.p_star)?;
    column("displacement", unit, "approach", |found| found.displacement)?;
    column("area_fraction", "1", "contact area fraction", |found| found.area_fraction)?;
    column("area_fraction_corrected", "1", "contact area fraction, corrected", |found| found.area_fraction_corrected)?;
    column("mean_gap", unit, "mean gap", |found| found.mean_gap)?;
    Ok(())
}
