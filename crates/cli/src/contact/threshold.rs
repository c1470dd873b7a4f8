//! Loads at which the gap closes for a flow, found by bisection.

use gfmd_contact::{Drive, Equilibrium as _, Fields as _, Load, Watch};
use gfmd_files::{Archive, Dimension, Variable};
use gfmd_measure::{GridLimit, Patches};
use gfmd_problem::{AnyState, Facts, Posed, key};
use gfmd_record::{COLUMNS, Column, Record, StateContext};
use gfmd_unit::Units;
use ndarray::ArrayView2;
use serde::ser::SerializeMap as _;
use serde::{Serialize, Serializer};

use super::{Args, Loads};
use crate::progress::Progress;
use gfmd_input::failure::{Failure, reached};
use gfmd_input::processes::of_first;
use gfmd_input::rows;
use gfmd_input::session::Session;
use gfmd_input::source::Surface;
use gfmd_run::series::{Finer, Prepared, Watching};

/// Relative width of the interval at which the bisection ends.
const WIDTH: f64 = 1e-3;

/// Interval of loads in which the gap closes along one axis: highest load with an open gap, lowest with a closed one.
#[derive(Clone, Debug)]
pub struct Threshold {
    sides: Vec<(&'static Column, [f64; 2])>,
    /// Limit of each column on infinitely fine grids, if it was also found on a finer grid.
    limits: Option<Vec<GridLimit>>,
}

/// Thresholds of a flow along x and along y; `None` where the gap does not close between the loads.
type Thresholds = [Option<Threshold>; 2];

/// Names of its columns.
const NAMES: [&str; 6] =
    ["mean_pressure", "p_star", "approach", "area_fraction", "area_fraction_corrected", "mean_gap"];

/// Ends of the names of the numbers on infinitely fine grids, with their meanings.
const LIMITS: [(&str, &str); 3] = [
    ("limit", "limit on an infinitely fine grid, at its threshold: "),
    ("limit_error", "error bound (95 %) of the limit on an infinitely fine grid: "),
    ("grid_error", "grid error (95 %) of the interval midpoint: "),
];

/// Returns the columns, defined as for a load.
fn columns() -> impl Iterator<Item = &'static Column> {
    NAMES.iter().filter_map(|name| COLUMNS.iter().find(|column| column.name == *name))
}

impl Threshold {
    fn between(open: &Sample, closed: &Sample) -> Self {
        let both = |column: &'static Column| (column, [open, closed].map(|sample| sample.record.number(column.name)));
        Self { sides: columns().map(both).collect(), limits: None }
    }

    /// Returns the middle of the interval of a column, and half its width.
    fn middle(&self, column: usize) -> [f64; 2] {
        let [open, closed] = self.sides[column].1;
        [0.5 * (open + closed), 0.5 * (closed - open).abs()]
    }

    /// Adds the limits on infinitely fine grids from the thresholds on `finer` grids, with the heights of the tops of
    /// the surface above the highest points of both grids, from which approaches count.
    fn refined(self, finer: &[(&Self, [f64; 2])]) -> Self {
        let limit = |column: usize| {
            let each = finer.iter().map(|(fine, rises)| {
                let ([value, _], [fine, width]) = (self.middle(column), fine.middle(column));
                let is_approach = self.sides[column].0.name == "approach";
                let [rise, other] = if is_approach { *rises } else { [0.0; 2] };
                let found = GridLimit::of_two_grids(value + rise, fine + other);
                GridLimit { half_width: found.half_width + width, ..found }
            });
            GridLimit::between(&each.collect::<Vec<_>>())
        };
        let limits = (!finer.is_empty()).then(|| (0..self.sides.len()).map(limit).collect());
        Self { limits, ..self }
    }

    /// Returns the numbers of a column on infinitely fine grids, in the order of [`LIMITS`]; `None` without a finer
    /// grid.
    fn numbers(&self, column: usize) -> Option<[f64; 3]> {
        let limit = self.limits.as_ref()?.get(column)?;
        Some([limit.limit, limit.half_width, limit.error_of(self.middle(column)[0])])
    }

    /// Returns the limit of a column on infinitely fine grids, if it is known.
    pub fn limit_of(&self, name: &str) -> Option<GridLimit> {
        let place = self.sides.iter().position(|(column, _)| column.name == name)?;
        self.limits.as_ref()?.get(place).copied()
    }

    /// Returns the numbers of a column on both sides.
    pub fn of(&self, name: &str) -> [f64; 2] {
        self.sides.iter().find(|(column, _)| column.name == name).map_or([f64::NAN; 2], |(_, values)| *values)
    }
}

impl Serialize for Threshold {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        for (column, values) in &self.sides {
            map.serialize_entry(column.name, values)?;
        }
        for (place, (column, _)) in self.sides.iter().enumerate() {
            for ((end, _), number) in LIMITS.iter().zip(self.numbers(place).iter().flatten()) {
                map.serialize_entry(&format!("{}_{end}", column.name), number)?;
            }
        }
        map.end()
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

/// Bisection of the loads of one contact.
struct Bisection<'a> {
    /// Lowest and highest load.
    range: [f64; 2],
    facts: Facts,
    session: &'a Session,
    progress: &'a Progress,
}

impl Bisection<'_> {
    /// Returns the loads at which the flow along x and along y stops, from states that `reach` returns with a record.
    /// `warn` receives a remark for an axis along which it does not stop.
    fn run(
        &self,
        mut reach: impl FnMut(Load, &mut dyn Watch) -> Result<Sample, Failure>,
        warn: impl Fn(String),
    ) -> Result<Thresholds, Failure> {
        let mut sample = |asked: f64| {
            let load = if self.facts.approach { Load::Approach(asked) } else { Load::MeanPressure(asked) };
            let place = format!("flow threshold, load {asked:e}");
            let mut watch = Watching::new(place.clone(), self.progress, self.session);
            let sample = reach(load, &mut watch).map_err(|failure| failure.at(&place))?;
            let [p_star, area] = ["p_star", "area_fraction"].map(|name| sample.record.number(name));
            self.progress.advance(0.0, &format!("threshold of the flow: p* {p_star:.4e}, area {area:.4}"));
            Ok::<_, Failure>(Sample { asked, ..sample })
        };
        let [low, high] = self.range;
        let mut samples = vec![sample(low)?, sample(high)?];
        let mut found = [None, None];
        for (axis, found) in found.iter_mut().enumerate() {
            loop {
                let Some(closed) = samples.iter().position(|sample| !sample.open[axis]).filter(|first| *first > 0)
                else {
                    let state = if samples[0].open[axis] { "open at the highest" } else { "closed at the lowest" };
                    let name = ["x", "y"][axis];
                    warn(format!("the gap is {state} load for a flow along {name}"));
                    break;
                };
                let (open, closed_load) = (&samples[closed - 1], &samples[closed]);
                // Loads of a law may be negative; around zero a thousandth of the range counts.
                let is_narrow = match open.asked > 0.0 {
                    true => closed_load.asked <= (1.0 + WIDTH) * open.asked,
                    false => closed_load.asked - open.asked <= WIDTH * open.asked.abs().max(WIDTH * (high - low)),
                };
                if is_narrow {
                    *found = Some(Threshold::between(open, closed_load));
                    break;
                }
                let middle = match open.asked > 0.0 {
                    true => (open.asked * closed_load.asked).sqrt(),
                    false => 0.5 * (open.asked + closed_load.asked),
                };
                let sample = sample(middle)?;
                samples.insert(closed, sample);
            }
        }
        Ok(found)
    }
}

impl Sample {
    /// Measures a state of this surface; `at` has its numbers. The first of several processes finds the open paths.
    fn of(state: &AnyState, Surface { share, boundary, .. }: &Surface, at: StateContext) -> Self {
        // The samples need neither statistics nor flow.
        let plain = Facts { statistics: false, flow: false, leak: false, conducts: false, ..*at.facts };
        let record = Record::of(&StateContext { facts: &plain, ..at });
        let mut conducting = state.repulsion().mapv(|p| p <= 0.0);
        conducting.zip_mut_with(&state.gap(), |open, gap| *open &= *gap > 0.0);
        let open = |conducting: ArrayView2<bool>| Patches::of(conducting, *boundary).percolate();
        let open = match share.is_whole() {
            true => open(conducting.view()),
            false => {
                let whole = rows::gathered(share, conducting.mapv(f64::from).view());
                let found = whole.map_or([false; 2], |whole| open(whole.mapv(|open| open > 0.0).view()));
                of_first(share.ranks(), found.map(u64::from)).map(|open| open > 0)
            }
        };
        Self { asked: f64::NAN, record, open }
    }
}

impl Loads {
    /// Returns the loads at which the flow along x and along y stops; `None` if it does not stop between the lowest and
    /// the highest load. With finer grids, each finds its own, and the differences give the limits.
    pub(super) fn threshold<'a>(
        &self,
        contact: &Posed,
        args: &Args,
        session: &Session,
        progress: &Progress,
        finer: impl Iterator<Item = &'a mut Finer>,
    ) -> Result<Thresholds, Failure> {
        let Prepared { facts, surface, .. } = &self.prepared;
        let asked = |drive: &Drive| match drive.load {
            Load::MeanPressure(value) | Load::Approach(value) => value,
        };
        let values = self.drives.iter().map(asked);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
        let bisection = Bisection { range: [low, high], facts: *facts, session, progress };
        let warn = |text: String| session.warn("flow-threshold", text);
        let budget = args.problem.solver.search.budget();
        let mut last: Option<AnyState> = None;
        let reach = |load: Load, watch: &mut dyn Watch| {
            let press = contact.press(load).solver(args.problem.solver.solver).budget(budget);
            // Under a law, contacts that grow and contacts that shrink differ: all loads are reached by growing ones.
            let start = last.as_ref().filter(|_| !facts.has_law());
            let (state, stopped) = reached(press.starting_from(start).watch(watch).solve(), &surface.units())?;
            if let Some(stopped) = stopped {
                return Err(stopped);
            }
            let sample = Sample::of(&state, surface, self.prepared.at(&state, budget.tolerance));
            last = Some(state);
            Ok(sample)
        };
        let mut found = bisection.run(reach, warn)?;
        let mut others: Vec<(Thresholds, [f64; 2])> = Vec::new();
        for finer in finer {
            let rises = [self.prepared.rise, finer.prepared.rise];
            let reach = |load: Load, watch: &mut dyn Watch| {
                if facts.has_law() {
                    finer.forget();
                }
                let (state, surface, at) = finer.reach(load.into(), watch)?;
                Ok(Sample::of(state, surface, at))
            };
            let of_finer = |text: String| warn(format!("no limit is known: on the finer grid {text}"));
            match bisection.run(reach, of_finer) {
                Ok(thresholds) => others.push((thresholds, rises)),
                Err(failure @ Failure::Interrupted(_)) => return Err(failure),
                // The thresholds of the coarser grid stay.
                Err(failure) => {
                    warn(format!("no limit is known: {failure}"));
                    return Ok(found);
                }
            }
        }
        for (axis, found) in found.iter_mut().enumerate() {
            let all = others.iter().map(|(thresholds, rises)| Some((thresholds[axis].as_ref()?, *rises)));
            if let Some(all) = all.collect::<Option<Vec<_>>>() {
                *found = found.take().map(|found| found.refined(&all));
            }
        }
        Ok(found)
    }
}

/// Writes the loads at which the flow stops, NaN if it does not.
///
/// # Errors
/// Returns an error if the file cannot be written.
pub(super) fn write(archive: &mut Archive, units: &Units, facts: &Facts, found: &Thresholds) -> Result<(), Failure> {
    let axis = Dimension::index("axis", 2, "flow axis: x, y");
    let side = Dimension::index("side", 2, "highest load with an open gap, lowest load with a closed gap");
    for column in columns() {
        let values: Vec<f64> = found
            .iter()
            .flat_map(|found| found.as_ref().map_or([f64::NAN; 2], |found| found.of(column.name)))
            .collect();
        let units = units.name(column.unit);
        let variable = Variable { dimensions: &[&axis, &side], units: &units, long_name: column.meaning(facts) };
        archive.write(&format!("/flow_threshold/{}", column.name), &variable, &values)?;
    }
    if found.iter().flatten().all(|found| found.limits.is_none()) {
        return Ok(());
    }
    for (place, column) in columns().enumerate() {
        for (k, (end, meaning)) in LIMITS.iter().enumerate() {
            let number = |found: &Option<Threshold>| Some(found.as_ref()?.numbers(place)?[k]);
            let values = found.each_ref().map(|found| number(found).unwrap_or(f64::NAN));
            let (units, long_name) = (units.name(column.unit), format!("{meaning}{}", column.meaning(facts)));
            let variable = Variable { dimensions: &[&axis], units: &units, long_name: &long_name };
            archive.write(&format!("/flow_threshold/{}_{end}", column.name), &variable, &values)?;
        }
    }
    Ok(())
}
