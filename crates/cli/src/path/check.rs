//! Check of a path file.

use gfmd_contact::Boundary;
use gfmd_interface::Shear;
use gfmd_law::Limit;
use gfmd_problem::AnyState;
use gfmd_record::StateContext;
use gfmd_relax::worst;
use gfmd_response::{FreeFullCompliance, FreeFullTransforms, FullResponse, FullTransforms};
use ndarray::Array2;
use std::path::PathBuf;

use super::{Args, memory};
use crate::checking::{Checked, Checking};
use crate::course::{StepArgs, leak};
use gfmd_check::result::Comparison;
use gfmd_check::series::Stored;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_run::flow::through;
use gfmd_run::series::{Chosen, Prepared};

impl Checked for Args {
    /// Recomputes the states at the waypoints from the stored fields, and the drives of all steps.
    fn check(checking: Checking, comparison: &mut Comparison) -> Result<(), Failure> {
        let Checking { reader, session, .. } = checking;
        let args: Self = checking.problem(|args: &Self| args.around.boundary, comparison)?;
        let mut input = super::path_input(&args, session)?;
        input.prepared.take_units(reader);
        let prepared = &input.prepared;
        let waypoints = input.places.count(input.drives.len());
        checking.layout_of_states((prepared, waypoints, Chosen::All), comparison, |mut file| {
            memory::lay_out(&mut file, prepared)?;
            file.finish(&[], input.drives.len(), None)
        })?;
        let contact = prepared.pose(&args.source, &prepared.law)?;
        let stored = Stored::new(reader, prepared, &contact, args.steps.search.tolerance)?;
        let check = StepCheck { args: &args, stored: &stored };
        for (index, drive) in input.drives.iter().enumerate() {
            if !stored.compare_step(index, *drive, comparison) {
                continue;
            }
            check.columns(index, comparison);
            let number = |name: &str| stored.number(name, index);
            comparison.number("/path/lateral_x", number("lateral_x"), drive.lateral[0], 0.0);
            comparison.number("/path/lateral_y", number("lateral_y"), drive.lateral[1], 0.0);
            if prepared.prony.is_some() {
                comparison.number("/path/time", number("time"), drive.time, 0.0);
            }
            let Some(waypoint) = input.places.of(index) else { continue };
            if prepared.prony.is_some() || prepared.facts.moves_sideways() {
                check.flow(waypoint, index, comparison)?;
            }
            if prepared.prony.is_some() {
                check.relaxing((waypoint, index), index + 1 == input.drives.len(), comparison)?;
            } else if prepared.facts.moves_sideways() {
                check.tractions(waypoint, index, comparison)?;
            } else {
                let flow = |state: &AnyState, at: &StateContext| leak(prepared, state, at, |_| {});
                stored.compare_waypoint((index, waypoint), *drive, flow, comparison)?;
            }
        }
        Ok(())
    }

    fn write(self, out: PathBuf, session: &Session) -> Result<(), Failure> {
        let steps = StepArgs { out: Some(out), ..self.steps };
        super::run(&Self { steps, ..self }, session).map(|_| ())
    }
}

/// Smallest stress scale for comparing tractions of a law, in units of E* times the rms gradient.
const OF_LAW: f64 = 1e-3;
/// Largest rounding error of a closed energy balance, relative to its largest part.
const CLOSED: f64 = 1e-9;

/// Check of the numbers of a step that do not follow from its state alone.
struct StepCheck<'a> {
    args: &'a Args,
    stored: &'a Stored<'a>,
}

impl StepCheck<'_> {
    /// Compares the scalars of a converged step that follow from other scalars of this step and the previous one.
    fn columns(&self, step: usize, comparison: &mut Comparison) {
        let now = |name: &str| self.stored.number(name, step);
        let facts = &self.stored.prepared.facts;
        let is_at_once = || step > 0 && now("time") == self.stored.number("time", step - 1);
        if facts.relaxes.is_some() && !(facts.has_law() && is_at_once()) {
            if now("extra_solves") == 0.0 {
                self.balance(step, comparison);
            }
            return;
        }
        // In a step of zero time, a relaxing body with a law loses energy in jumps only. Without further solves, the
        // loss is the balance of the work by the trapezoidal rule and the energy.
        let has_energy = (facts.solves_a_law() || facts.relaxes.is_some()) && !now("interface_energy").is_nan();
        if step == 0 || !has_energy || now("extra_solves") != 0.0 {
            return;
        }
        let before = |name: &str| self.stored.number(name, step - 1);
        let [mut work, mut spread, mut floor] = [0.0_f64; 3];
        for (force, coordinate) in
            [("mean_pressure", "approach"), ("mean_shear_x", "lateral_x"), ("mean_shear_y", "lateral_y")]
        {
            let moved = now(coordinate) - before(coordinate);
            work += 0.5 * (now(force) + before(force)) * moved;
            spread += 0.5 * ((now(force) - before(force)) * moved).abs();
            floor +=
                0.5 * (now(force).abs() + before(force).abs()) * now(coordinate).abs().max(before(coordinate).abs());
        }
        let energy = |at: &dyn Fn(&str) -> f64| at("elastic_energy") + at("interface_energy");
        let missing = work - (energy(&now) - energy(&before));
        floor = floor.max(energy(&now).abs()).max(energy(&before).abs());
        comparison.number("/path/dissipated", now("dissipated"), missing, floor);
        comparison.number("/path/dissipated_error", now("dissipated_error"), spread + missing.abs(), floor);
    }

    /// Compares the flow with the flow through the stored gap.
    fn flow(&self, waypoint: usize, step: usize, comparison: &mut Comparison) -> Result<(), Failure> {
        let Self { stored: file, .. } = self;
        let (number, Prepared { facts, surface, .. }) = (|name: &str| file.number(name, step), file.prepared);
        let mean_gap = number("mean_gap");
        if !facts.flow || mean_gap <= 0.0 {
            return Ok(());
        }
        let [pressure, gap] = [file.field("pressure", waypoint)?, file.field("gap", waypoint)?];
        let (mut repulsion, floor) = self.repulsion(&pressure, &gap);
        let least = self.args.steps.search.tolerance * floor;
        repulsion.mapv_inplace(|p| if p > least { p } else { 0.0 });
        let found = through(surface, [repulsion.view(), gap.view()], mean_gap, |_| {})?;
        for (row, column, name) in [(0, 0, "flow_xx"), (0, 1, "flow_xy"), (1, 0, "flow_yx"), (1, 1, "flow_yy")] {
            comparison.number(&format!("/path/{name}"), number(name), found.conductivity[row][column], 1e-3);
        }
        Ok(())
    }

    /// Returns the pressure of the wall or of a repulsive law, and the stress scale of the tractions that a search may
    /// leave where the surfaces are apart, zero without a law.
    fn repulsion(&self, pressure: &Array2<f64>, gap: &Array2<f64>) -> (Array2<f64>, f64) {
        let Prepared { facts, law, .. } = self.stored.prepared;
        if !facts.has_law() {
            return (pressure.clone(), 0.0);
        }
        let least = OF_LAW * self.stored.prepared.unit_pressure();
        let floor = pressure.iter().fold(least, |most: f64, p| most.max(p.abs()));
        let of_wall = |p: f64, gap: f64| if gap <= 0.0 { p + law.traction(gap, [0.0; 2])[2] } else { 0.0 };
        let repulsion = ndarray::Zip::from(pressure).and(gap).map_collect(|p, gap| match law.has_wall() {
            true => of_wall(*p, *gap),
            false => *p,
        });
        (repulsion, floor)
    }

    /// Compares the balance of work and energy of a viscoelastic step with its stated error. With a law, the work
    /// before the first step is unknown.
    fn balance(&self, step: usize, comparison: &mut Comparison) {
        let has_law = self.stored.prepared.facts.has_law();
        if has_law && step == 0 {
            return;
        }
        let now = |name: &str| self.stored.number(name, step);
        let before = |name: &str| if step == 0 { 0.0 } else { self.stored.number(name, step - 1) };
        let work = 0.5 * (now("mean_pressure") + before("mean_pressure")) * (now("approach") - before("approach"));
        let mut missing = work - (now("elastic_energy") - before("elastic_energy")) - now("dissipated");
        let mut floor = now("elastic_energy").abs().max(before("elastic_energy").abs()).max(work.abs());
        if has_law {
            missing -= now("interface_energy") - before("interface_energy");
            floor = floor.max(now("interface_energy").abs()).max(before("interface_energy").abs());
        }
        // Only a law has jumps; the loss of a step with a jump closes the balance.
        let spread = (now("mean_pressure") - before("mean_pressure")) * (now("approach") - before("approach"));
        let is_closed = has_law && missing.abs() <= CLOSED * floor && now("work_imbalance") > CLOSED * floor;
        // A sudden change of the load takes no time and loses nothing in the dashpots.
        let is_at_once = now("time") == before("time");
        let found = match () {
            () if is_closed => 0.5 * spread.abs(),
            () if is_at_once => 0.0,
            () => missing.abs(),
        };
        comparison.number("/path/work_imbalance", now("work_imbalance"), found, floor);
        if is_at_once && !is_closed {
            comparison.number("/path/dissipated", now("dissipated"), 0.0, floor);
            comparison.number("/path/dissipated_error", now("dissipated_error"), 0.0, floor);
        }
    }

    /// Compares the fields of a viscoelastic body with each other, and with its memory at the last step.
    fn relaxing(
        &self,
        (waypoint, step): (usize, usize),
        is_last: bool,
        comparison: &mut Comparison,
    ) -> Result<(), Failure> {
        let Self { args, stored: file } = self;
        let field = |name: &str| file.field(name, waypoint);
        let [pressure, displacement, gap] = [field("pressure")?, field("displacement_z")?, field("gap")?];
        let (number, height) = (|name: &str| file.number(name, step), file.height());
        let heights = &file.prepared.surface.heights;
        let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let approach = number("approach");
        let found: Vec<f64> = heights.iter().zip(&displacement).map(|(h, u)| highest - h - u - approach).collect();
        comparison.values("/fields/gap", &flat(&gap), &found, height);
        let least = |values: &Array2<f64>| values.iter().copied().fold(0.0, f64::min);
        let mean = |field: &Array2<f64>| field.mean().unwrap_or(f64::NAN);
        let Prepared { facts, law, .. } = file.prepared;
        let (repulsion, floor) = self.repulsion(&pressure, &gap);
        if facts.has_law() {
            let touches = |gap: f64| law.has_wall() && gap <= 0.0;
            let law_pressure = gap.mapv(|gap| -law.traction(gap, [0.0; 2])[2]);
            let left = pressure.iter().zip(&law_pressure).zip(&gap).map(|((p, of_law), gap)| {
                let left = p - of_law;
                if touches(*gap) { (-left).max(0.0) } else { left.abs() }
            });
            comparison.at_most(
                "/fields/pressure (of the law)",
                worst(left) / floor,
                100.0 * args.steps.search.tolerance,
            );
            let energy = mean(&gap.mapv(|gap| law.opening_energy(gap)));
            let size = number("elastic_energy").abs() + energy.abs();
            comparison.number("/path/interface_energy", number("interface_energy"), energy, size);
        } else {
            comparison.at_most("/fields/pressure (tension)", -least(&pressure), 0.0);
            let pressed = pressure.sum();
            let closed = (&pressure * &gap).sum().abs();
            let open = if pressed > 0.0 { closed / (pressed * height) } else { 0.0 };
            comparison.at_most("/fields/gap (in contact)", open, args.steps.search.tolerance);
        }
        if !facts.has_law() || law.has_wall() {
            comparison.at_most("/fields/gap (penetration)", -least(&gap) / height, args.steps.search.tolerance);
        }
        let largest = repulsion.iter().copied().fold(0.0, f64::max);
        match facts.has_law() {
            // The mean pressure follows from the law, the field from the displacement: they agree up to the residual.
            true => comparison.at_most(
                "/path/mean_pressure",
                (number("mean_pressure") - mean(&pressure)).abs() / floor,
                100.0 * args.steps.search.tolerance,
            ),
            false => comparison.number("/path/mean_pressure", number("mean_pressure"), mean(&pressure), floor),
        }
        comparison.number("/path/max_pressure", number("max_pressure"), largest, floor);
        // Where a law vanishes, its pressure has the sign of rounding errors.
        let touching = |least: f64| repulsion.iter().filter(|p| **p > least).count() as f64 / repulsion.len() as f64;
        let [fewest, most] = [touching(args.steps.search.tolerance * floor), touching(0.0)];
        let area = number("area_fraction");
        comparison.number("/path/area_fraction", area, area.clamp(fewest, most), 0.0);
        let is_closed = !facts.has_law() && area == 1.0;
        compare_gap(comparison, number("mean_gap"), mean(&gap), (is_closed, height, args.steps.search.tolerance));
        if is_last {
            let fields = (&pressure, &displacement, number("elastic_energy"));
            memory::check(file.reader, file.prepared, fields, 100.0 * args.steps.search.tolerance, comparison)?;
        }
        Ok(())
    }

    /// Recomputes the displacement from the tractions, then gap and energy.
    fn tractions(&self, waypoint: usize, step: usize, comparison: &mut Comparison) -> Result<(), Failure> {
        let Self { args, stored: file } = self;
        let Prepared { surface, body, shear, law, .. } = file.prepared;
        let (field, unit_pressure) = (|name: &str| file.field(name, waypoint), file.prepared.unit_pressure());
        let stored = |name: &str| file.number(name, step);
        let gap = field("gap")?;
        let points = surface.grid.len();
        let pressure = field("pressure")?;
        let mut traction = Vec::new();
        for name in if surface.grid.is_line() { &["shear_x"][..] } else { &["shear_x", "shear_y"] } {
            let shear = flat(&field(name)?);
            let mean = shear.iter().sum::<f64>() / points as f64;
            let column = format!("mean_{name}");
            comparison.number(&format!("/path/{column}"), stored(&column), mean, unit_pressure * 1e-3);
            traction.extend(shear);
        }
        let lateral = traction.len();
        traction.extend(pressure.iter().map(|p| -p));
        let mut displacement = vec![0.0; traction.len()];
        match surface.boundary {
            Boundary::Periodic => {
                let response = FullResponse::new(surface.grid, body).into();
                FullTransforms::of(&response).compliance(&traction, &mut displacement);
            }
            Boundary::Free => {
                let response = FreeFullCompliance::new(surface.grid, body);
                let response = response.map_err(|error| Failure::input("/surface/height", error))?.into();
                FreeFullTransforms::of(&response).compliance(&traction, &mut displacement);
            }
        }
        // The mean displacement of a half-space is a convention, so compare the gap up to its mean.
        let highest = surface.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let found: Vec<f64> =
            surface.heights.iter().zip(&displacement[lateral..]).map(|(h, u)| highest - h - u).collect();
        let height = file.height();
        let stored_displacement = flat(&field("displacement_z")?);
        comparison.at_most("/fields/gap", apart(&found, &flat(&gap)) / height, 100.0 * args.steps.search.tolerance);
        let distance = apart(&displacement[lateral..], &stored_displacement) / height;
        comparison.at_most("/fields/displacement_z", distance, 100.0 * args.steps.search.tolerance);
        let law = shear.is_none().then_some(law);
        if law.is_none_or(|law| law.has_wall()) {
            let below = -gap.iter().copied().fold(0.0, f64::min) / height;
            comparison.at_most("/fields/gap (penetration)", below, args.steps.search.tolerance);
        }
        let mean_pressure = pressure.mean().unwrap_or(f64::NAN);
        match law {
            // The mean pressure follows from the law, the field from the displacement: they agree up to the residual.
            Some(_) => comparison.at_most(
                "/path/mean_pressure",
                (stored("mean_pressure") - mean_pressure).abs() / unit_pressure,
                100.0 * args.steps.search.tolerance,
            ),
            None => comparison.number("/path/mean_pressure", stored("mean_pressure"), mean_pressure, 0.0),
        }
        let is_closed = law.is_none() && stored("area_fraction") == 1.0;
        let mean_gap = gap.mean().unwrap_or(f64::NAN);
        compare_gap(comparison, stored("mean_gap"), mean_gap, (is_closed, height, args.steps.search.tolerance));
        let energy = 0.5 * traction.iter().zip(&displacement).map(|(t, u)| t * u).sum::<f64>() / points as f64;
        let approaches =
            surface.heights.iter().zip(&stored_displacement).zip(gap).map(|((h, u), gap)| highest - h - u - gap);
        let approach = approaches.sum::<f64>() / points as f64;
        comparison.at_most(
            "/path/approach",
            (stored("approach") - approach).abs() / height,
            args.steps.search.tolerance,
        );
        if let Some(Shear { limit, .. }) = *shear {
            comparison.number("/path/elastic_energy", stored("elastic_energy"), energy, 0.0);
            let touching = pressure.iter().filter(|p| **p > 0.0).count() as f64 / points as f64;
            comparison.number("/path/area_fraction", stored("area_fraction"), touching, 0.0);
            self.limits(limit, &pressure, &traction[..lateral], comparison);
        }
        Ok(())
    }

    /// Checks that the shear stays within its limit.
    fn limits(&self, limit: Limit, pressure: &Array2<f64>, shear: &[f64], comparison: &mut Comparison) {
        let points = pressure.len();
        let limits: Vec<f64> = pressure.iter().map(|p| if *p > 0.0 { limit.at(*p) } else { 0.0 }).collect();
        let strongest = limits.iter().copied().fold(0.0, f64::max);
        let magnitude = |i: usize| shear.chunks_exact(points).map(|s| s[i] * s[i]).sum::<f64>().sqrt();
        let excess = (0..points).map(|i| magnitude(i) - limits[i]).fold(0.0, f64::max);
        if strongest > 0.0 {
            comparison.at_most("/fields/shear (limit)", excess / strongest, self.args.steps.search.tolerance);
        }
    }
}

/// Returns the largest distance of two fields after subtracting their means; NaN if any distance is NaN.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let mean = |field: &[f64]| field.iter().sum::<f64>() / field.len() as f64;
    let shift = mean(a) - mean(b);
    let distances = a.iter().zip(b).map(|(a, b)| (a - b - shift).abs());
    worst(distances)
}

fn flat(field: &Array2<f64>) -> Vec<f64> {
    field.iter().copied().collect()
}

/// Compares the mean gap, relative to heights of size `height`. In full contact behind a wall the stored gap is zero,
/// while the search leaves a gap within its tolerance.
fn compare_gap(comparison: &mut Comparison, stored: f64, found: f64, (is_closed, height, tolerance): (bool, f64, f64)) {
    if is_closed && stored == 0.0 {
        comparison.at_most("/path/mean_gap", found.abs() / height, 10.0 * tolerance);
    } else {
        comparison.number("/path/mean_gap", stored, found, height);
    }
}
