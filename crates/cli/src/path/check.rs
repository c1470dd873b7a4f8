//! Check of a path file.

mod measured;

use gfmd_contact::{Boundary, Contact, Hardness, Load};
use gfmd_interface::LimitingPressure;
use gfmd_problem::{AnyState, Inelastic, WearBy};
use gfmd_record::StateContext;
use gfmd_relax::worst;
use gfmd_response::{FreeFullCompliance, FreeFullTransforms, FullResponse, FullTransforms};
use ndarray::{ArcArray2, Array2};
use std::path::PathBuf;

use super::args::StepArgs;
use super::{Args, memory, strain};
use crate::checking::{Checked, Checking, check_base, check_lower};
use crate::measuring::Conducting;
use gfmd_check::result::Comparison;
use gfmd_check::series::Stored;
use gfmd_check::statistics;
use gfmd_input::base::MovedBase;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_run::series::{Chosen, Prepared};

impl Checked for Args {
    /// Recomputes the states at the waypoints from the stored fields, and the drives of all steps.
    fn check(checking: Checking, comparison: &mut Comparison) -> Result<(), Failure> {
        let Checking { reader, session, .. } = checking;
        let args: Self = checking.problem(|args: &Self| args.around.boundary, comparison)?;
        let mut input = super::path_input(&args, session)?;
        input.prepared.take_units(reader);
        let prepared = &input.prepared;
        check_base(reader, prepared.lift(), comparison)?;
        check_lower(reader, prepared.lower.as_ref(), comparison);
        let waypoints = input.places.count(input.drives.len());
        let contact = prepared.pose(&args.source, &prepared.law)?;
        let stored = Stored::new(reader, prepared, &contact, args.steps.search.tolerance)?;
        let check = StepCheck { args: &args, stored: &stored, conducting: &input.conducting };
        let measured = check.statistics(waypoints)?;
        statistics::compare(reader, &prepared.facts, &measured, comparison)?;
        checking.layout_of_states((prepared, waypoints, Chosen::All), comparison, |mut file| {
            memory::lay_out(&mut file, prepared)?;
            strain::lay_out(&mut file, prepared, waypoints)?;
            file.archive().map_or(Ok(()), |archive| statistics::write(archive, prepared, &measured))?;
            file.finish(&[], input.drives.len(), None)
        })?;
        for (index, drive) in input.drives.iter().enumerate() {
            if !stored.compare_step(index, *drive, comparison) {
                continue;
            }
            check.columns(index, comparison);
            check.volume(index, comparison);
            let number = |name: &str| stored.number(name, index);
            comparison.number("/path/lateral_x", number("lateral_x"), drive.lateral[0], 0.0);
            comparison.number("/path/lateral_y", number("lateral_y"), drive.lateral[1], 0.0);
            if prepared.inelastic.relaxation.is_some() {
                comparison.number("/path/time", number("time"), drive.time, 0.0);
            }
            if prepared.inelastic.wear.is_some() {
                comparison.number("/path/distance", number("distance"), drive.distance, 0.0);
            }
            let Some(waypoint) = input.places.of(index) else { continue };
            check.lost_by_wear(waypoint, index, comparison)?;
            // A state with shear, of a body with a memory or of one that yields does not follow from its fields alone.
            if prepared.inelastic.relaxation.is_some() || prepared.facts.yields || prepared.facts.moves_sideways() {
                check.flow(waypoint, index, comparison)?;
                check.gas(waypoint, index, comparison)?;
                check.patches(waypoint, index, comparison)?;
                check.stiffness(waypoint, index, comparison)?;
                let is_last = index + 1 == input.drives.len();
                check.state((waypoint, index), is_last, comparison)?;
                strain::check_waypoint(&stored, (index, waypoint), *drive, comparison)?;
                if is_last {
                    let record = |state: &AnyState, at: StateContext| check.record(waypoint, state, at);
                    strain::check(&stored, (index, waypoint), *drive, args.stiffness, record, comparison)?;
                }
            } else {
                let record = |state: &AnyState, at: StateContext| check.record(waypoint, state, at);
                stored.compare_waypoint((index, waypoint), *drive, args.stiffness, record, comparison)?;
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
/// Losses of a step by cause.
const LOSSES: [&str; 5] = ["lost_relaxation", "lost_friction", "lost_wear", "lost_plastic", "lost_jumps"];

/// Work of the rigid surface in a step, by the trapezoidal rule.
#[derive(Clone, Copy, Debug, Default)]
struct Work {
    /// Work less the energy gained.
    missing: f64,
    /// Largest error of the rule for forces that change monotonically.
    spread: f64,
    /// Size of the terms.
    floor: f64,
}

/// Fields of one face of the body at a waypoint, as seen from outside.
struct Face {
    /// Beginning of the names of its fields and numbers.
    prefix: &'static str,
    /// Heights of the rigid surface, with the lift of a base that moves.
    heights: ArcArray2<f64>,
    pressure: Array2<f64>,
    /// Displacement out of the body, without the lift of a base that moves.
    displacement: Array2<f64>,
    gap: Array2<f64>,
    plastic_depth: Option<Array2<f64>>,
    wear_depth: Option<Array2<f64>>,
}

impl Face {
    /// Returns the gap of each point at zero approach.
    fn rooms(&self) -> impl Iterator<Item = f64> {
        let highest = self.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut rooms = self.heights.mapv(|height| highest - height) - &self.displacement;
        for depth in self.plastic_depth.iter().chain(&self.wear_depth) {
            rooms += depth;
        }
        rooms.into_iter()
    }

    /// Returns the approach that follows from the gaps.
    fn apart(&self) -> f64 {
        self.rooms().zip(&self.gap).map(|(room, gap)| room - gap).sum::<f64>() / self.gap.len() as f64
    }
}

/// Check of the numbers of a step that do not follow from its state alone.
struct StepCheck<'a> {
    args: &'a Args,
    stored: &'a Stored<'a>,
    conducting: &'a Conducting,
}

impl StepCheck<'_> {
    /// Compares the scalars of a converged step that follow from other scalars of this step and the previous one.
    fn columns(&self, step: usize, comparison: &mut Comparison) {
        let facts = &self.stored.prepared.facts;
        let now = |name: &str| self.stored.number(name, step);
        let causes = LOSSES.map(now);
        if causes.iter().any(|lost| lost.is_finite()) {
            let sum = causes.into_iter().filter(|lost| lost.is_finite()).sum();
            comparison.number("/path/dissipated", now("dissipated"), sum, now("elastic_energy"));
        }
        if now("extra_solves") != 0.0 {
            return;
        }
        let flows = facts.friction.is_some() || facts.hardness || facts.yields;
        let keeps = facts.relaxes.is_some() || facts.wear.is_some() || facts.yields;
        if keeps || flows && facts.has_law() {
            self.balance(step, comparison);
        } else if !flows && !facts.has_law() {
            comparison.number("/path/dissipated", now("dissipated"), 0.0, 0.0);
            comparison.number("/path/dissipated_error", now("dissipated_error"), 0.0, 0.0);
        } else if step > 0 && !flows && !now("interface_energy").is_nan() {
            // Energy is lost in jumps alone: without further solves, the loss is the balance of the work by the
            // trapezoidal rule and the energy.
            let Work { missing, spread, floor } = self.work(step);
            comparison.number("/path/dissipated", now("dissipated"), missing, floor);
            comparison.number("/path/dissipated_error", now("dissipated_error"), spread + missing.abs(), floor);
        }
    }

    /// Returns the depth lost in a step divided by the pressure at its end: the wear coefficient times the sliding
    /// distance. `None` if a point wears by another pressure or distance.
    fn rate(&self, step: usize) -> Option<f64> {
        let Prepared { facts, inelastic: Inelastic { wear, .. }, .. } = self.stored.prepared;
        let is_undivided = facts.friction.is_none() && self.stored.number("extra_solves", step) == 0.0;
        let is_known = facts.wear == Some(WearBy::Distance) && !facts.has_law() && is_undivided;
        let moved = self.stored.number("distance", step) - self.before("distance", step);
        wear.filter(|_| is_known).map(|wear| wear.by_distance * moved)
    }

    /// Returns a number of the previous step; zero before the first one.
    fn before(&self, name: &str, step: usize) -> f64 {
        if step == 0 { 0.0 } else { self.stored.number(name, step - 1) }
    }

    /// Compares the volume lost with the pressure and the distance of the step.
    fn volume(&self, step: usize, comparison: &mut Comparison) {
        let Some(rate) = self.rate(step) else { return };
        let found = self.before("wear_volume", step) + rate * self.stored.number("mean_pressure", step);
        comparison.number("/path/wear_volume", self.stored.number("wear_volume", step), found, 0.0);
    }

    /// Compares the energy lost by wear with the pressure at a waypoint.
    fn lost_by_wear(&self, waypoint: usize, step: usize, comparison: &mut Comparison) -> Result<(), Failure> {
        let Some(rate) = self.rate(step) else { return Ok(()) };
        let faces: &[&str] =
            if self.stored.prepared.lower.is_some() { &["pressure", "lower_pressure"] } else { &["pressure"] };
        let mut squares = 0.0;
        for name in faces {
            let field = self.stored.field(name, waypoint)?;
            squares += field.iter().map(|p| p * p).sum::<f64>() / field.len() as f64;
        }
        let [all, part] = ["dissipated", "lost_wear"].map(|name| self.stored.number(name, step));
        let (name, lost) = if part.is_nan() { ("dissipated", all) } else { ("lost_wear", part) };
        comparison.number(&format!("/path/{name}"), lost, rate * squares, 0.0);
        Ok(())
    }

    /// Returns the balance of work and energy of a step.
    fn work(&self, step: usize) -> Work {
        let now = |name: &str| self.stored.number(name, step);
        let before = |name: &str| self.before(name, step);
        let mut work = Work::default();
        for (force, coordinate) in
            [("mean_pressure", "approach"), ("mean_shear_x", "lateral_x"), ("mean_shear_y", "lateral_y")]
        {
            let moved = now(coordinate) - before(coordinate);
            work.missing += 0.5 * (now(force) + before(force)) * moved;
            work.spread += 0.5 * ((now(force) - before(force)) * moved).abs();
            work.floor +=
                0.5 * (now(force).abs() + before(force).abs()) * now(coordinate).abs().max(before(coordinate).abs());
        }
        let has_law = self.stored.prepared.facts.solves_a_law();
        let yields = self.stored.prepared.facts.yields;
        let part = |is_part: bool, at: &dyn Fn(&str) -> f64, name: &str| if is_part { at(name) } else { 0.0 };
        let energy = |at: &dyn Fn(&str) -> f64| {
            at("elastic_energy") + part(has_law, at, "interface_energy") + part(yields, at, "hardening_energy")
        };
        work.missing -= energy(&now) - energy(&before);
        work.floor = work.floor.max(energy(&now).abs()).max(energy(&before).abs());
        work
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

    /// Compares the balance of work and energy of a step that loses energy by several causes with its stated error.
    /// With a law, the work before the first step is unknown.
    fn balance(&self, step: usize, comparison: &mut Comparison) {
        let facts = &self.stored.prepared.facts;
        if facts.has_law() && step == 0 {
            return;
        }
        let now = |name: &str| self.stored.number(name, step);
        let before = |name: &str| self.before(name, step);
        let Work { missing, spread, floor } = self.work(step);
        let missing = missing - now("dissipated");
        let flows = facts.friction.is_some() || facts.hardness || facts.yields;
        // A sudden change of the load takes no time and no distance, and loses nothing by relaxation and wear.
        let same = |name: &str| now(name).is_nan() || now(name) == before(name);
        let is_at_once = same("time") && same("distance");
        // Only a law has jumps; the loss of a step with a jump closes the balance.
        let is_closed = facts.has_law() && now("lost_jumps") != 0.0;
        if is_closed {
            comparison.number("/path/dissipated (with jumps)", missing, 0.0, floor);
        }
        if facts.has_law() && is_at_once && !flows {
            // The balance itself gives the loss, in jumps alone.
            return;
        }
        let found = match () {
            () if is_closed => spread,
            () if is_at_once && !flows => 0.0,
            () => missing.abs(),
        };
        comparison.number("/path/work_imbalance", now("work_imbalance"), found, floor);
        if is_at_once && !flows && !is_closed {
            comparison.number("/path/dissipated", now("dissipated"), 0.0, floor);
            comparison.number("/path/dissipated_error", now("dissipated_error"), 0.0, floor);
        }
    }

    /// Compares the fields of a state with each other, with the numbers of its step, and of the last step with the
    /// memory of the body.
    fn state(
        &self,
        (waypoint, step): (usize, usize),
        is_last: bool,
        comparison: &mut Comparison,
    ) -> Result<(), Failure> {
        let (args, file) = (self.args, self.stored);
        let Prepared { facts, law, inelastic: Inelastic { shear, relaxation, .. }, .. } = file.prepared;
        let (number, height) = (|name: &str| file.number(name, step), file.height());
        let faces = self.faces(waypoint)?;
        let apart: Vec<f64> = faces.iter().map(Face::apart).collect();
        let levels = match faces.len() {
            1 => vec![number("approach")],
            2 => {
                comparison.number("/path/approach (of the gaps)", number("approach"), apart.iter().sum(), height);
                comparison.number("/path/lower_approach", number("lower_approach"), apart[1], height);
                apart
            }
            _ => apart,
        };
        for (face, level) in faces.iter().zip(levels) {
            self.face(face, level, step, comparison);
        }
        if facts.has_law() && !facts.shears_by_law() {
            let energy = faces.iter().map(|face| mean(&face.gap.mapv(|gap| law.opening_energy(gap)))).sum::<f64>();
            let size = number("elastic_energy").abs() + energy.abs();
            comparison.number("/path/interface_energy", number("interface_energy"), energy, size);
        }
        let Face { pressure, displacement, gap, .. } = &faces[0];
        if facts.yields {
            self.yielded((waypoint, step), (pressure, displacement), comparison)?;
        }
        if facts.moves_sideways() {
            let shears = self.shear(waypoint, step, comparison)?;
            if let Some(shear) = shear {
                let limit = |r: &f64, p: &f64| match shear.pressure {
                    LimitingPressure::Repulsion if *r > 0.0 => shear.limit.at(*r),
                    LimitingPressure::Net if *r > 0.0 => shear.limit.at(p.max(0.0)),
                    _ => 0.0,
                };
                let (repulsion, _) = self.repulsion(pressure, gap);
                let limits = ndarray::Zip::from(&repulsion).and(pressure).map_collect(limit);
                self.limits(&flat(&limits), &shears, comparison);
            }
            if relaxation.is_none() {
                self.elastic(step, (&shears, pressure, displacement), comparison)?;
            }
        } else if is_last && relaxation.is_some() {
            let fields: Vec<_> = faces.iter().map(|face| [&face.pressure, &face.displacement]).collect();
            let tolerance = 100.0 * args.steps.search.tolerance;
            memory::check(file.reader, file.prepared, (&fields, number("elastic_energy")), tolerance, comparison)?;
        }
        Ok(())
    }

    /// Reads the faces of the body at a waypoint, the upper one first.
    fn faces(&self, waypoint: usize) -> Result<Vec<Face>, Failure> {
        let Prepared { facts, surface, lower, .. } = self.stored.prepared;
        let base = self.stored.prepared.base.as_ref();
        let surfaces = [("", Some(surface)), ("lower_", lower.as_ref())];
        let mut faces = Vec::new();
        for (prefix, surface) in surfaces.into_iter().filter_map(|(prefix, surface)| Some((prefix, surface?))) {
            let field = |name: &str| self.stored.field(&format!("{prefix}{name}"), waypoint);
            let displacement = match base {
                Some(base) => field("displacement_z")? - &base.lift,
                None => field("displacement_z")?,
            };
            faces.push(Face {
                prefix,
                heights: MovedBase::under(base, &surface.heights),
                pressure: field("pressure")?,
                displacement: if prefix.is_empty() { displacement } else { -displacement },
                gap: field("gap")?,
                plastic_depth: facts.hardness.then(|| field("plastic_depth")).transpose()?,
                wear_depth: facts.wear.map(|_| field("wear_depth")).transpose()?,
            });
        }
        Ok(faces)
    }

    /// Compares the fields of a face with each other, with its `level`, its part of the approach, and with the numbers
    /// of its step.
    fn face(&self, face: &Face, level: f64, step: usize, comparison: &mut Comparison) {
        let (args, file) = (self.args, self.stored);
        let Prepared { facts, law, hardness, .. } = file.prepared;
        let Face { prefix, pressure, gap, .. } = face;
        let (tolerance, height) = (args.steps.search.tolerance, file.height());
        let number = |name: &str| file.number(&format!("{prefix}{name}"), step);
        let [field, column] = ["fields", "path"].map(|group| move |name: &str| format!("/{group}/{prefix}{name}"));
        for (kept, volume) in [(&face.plastic_depth, "plastic_volume"), (&face.wear_depth, "wear_volume")] {
            if let Some(kept) = kept {
                comparison.number(&column(volume), number(volume), mean(kept), 0.0);
            }
        }
        if let Some(worn) = &face.wear_depth {
            let deepest = worn.iter().copied().fold(0.0, f64::max);
            comparison.number(&column("max_wear"), number("max_wear"), deepest, 0.0);
        }
        let found: Vec<f64> = face.rooms().map(|room| room - level).collect();
        comparison.values(&field("gap"), &flat(gap), &found, height);
        let least = |values: &Array2<f64>| values.iter().copied().fold(0.0, f64::min);
        let (repulsion, floor) = self.repulsion(pressure, gap);
        let acts_alone = !facts.shears_by_law();
        if facts.has_law() && acts_alone {
            let touches = |gap: f64| law.has_wall() && gap <= 0.0;
            let law_pressure = gap.mapv(|gap| -law.traction(gap, [0.0; 2])[2]);
            let left = pressure.iter().zip(&law_pressure).zip(gap).map(|((p, of_law), gap)| {
                let left = p - of_law;
                if touches(*gap) { (-left).max(0.0) } else { left.abs() }
            });
            comparison.at_most(&field("pressure (of the law)"), worst(left) / floor, 100.0 * tolerance);
        }
        if !facts.has_law() && acts_alone {
            comparison.at_most(&field("pressure (tension)"), -least(pressure), 0.0);
            let pressed = pressure.sum();
            let closed = (pressure * gap).sum().abs();
            let open = if pressed > 0.0 { closed / (pressed * height) } else { 0.0 };
            comparison.at_most(&field("gap (in contact)"), open, tolerance);
        }
        if let Some(hardness) = hardness {
            let over = match hardness {
                Hardness::Uniform(hardness) => worst(pressure.iter().map(|p| (p / hardness - 1.0).max(0.0))),
                Hardness::Field(field) => worst(pressure.iter().zip(field).map(|(p, hard)| (p / hard - 1.0).max(0.0))),
            };
            comparison.at_most(&field("pressure (hardness)"), over, 100.0 * tolerance);
        }
        if law.has_wall() {
            comparison.at_most(&field("gap (penetration)"), -least(gap) / height, tolerance);
        }
        // The mean pressure follows from the law, or from both faces, the field from the displacement: they agree up to
        // the residual.
        match facts.has_law() || facts.shears_by_law() || facts.lower.is_some() {
            true => {
                let floor = if floor > 0.0 { floor } else { file.prepared.unit_pressure() };
                comparison.at_most(
                    &column("mean_pressure"),
                    (number("mean_pressure") - mean(pressure)).abs() / floor,
                    100.0 * tolerance,
                );
            }
            false => comparison.number(&column("mean_pressure"), number("mean_pressure"), mean(pressure), floor),
        }
        if acts_alone {
            if !number("max_pressure").is_nan() {
                let largest = repulsion.iter().copied().fold(0.0, f64::max);
                let stored = number("max_pressure");
                // Beside a law, the depths pressed in and worn off determine the repulsion up to the residual.
                if facts.has_law() && (facts.hardness || facts.wear.is_some()) {
                    let apart = (stored - largest).abs() / floor;
                    comparison.at_most(&column("max_pressure (of the fields)"), apart, 100.0 * tolerance);
                } else {
                    comparison.number(&column("max_pressure"), stored, largest, floor);
                }
            }
            // Where a law vanishes, its pressure has the sign of rounding errors.
            let touching =
                |least: f64| repulsion.iter().filter(|p| **p > least).count() as f64 / repulsion.len() as f64;
            let [fewest, most] = [touching(tolerance * floor), touching(0.0)];
            let area = number("area_fraction");
            comparison.number(&column("area_fraction"), area, area.clamp(fewest, most), 0.0);
        }
        let is_closed = !facts.has_law() && number("area_fraction") == 1.0;
        compare_gap((&column("mean_gap"), number("mean_gap"), mean(gap)), (is_closed, height, tolerance), comparison);
    }

    /// Compares the plastic displacement of a state with its numbers, and the rest of the displacement with the
    /// pressure.
    fn yielded(
        &self,
        (waypoint, step): (usize, usize),
        (pressure, displacement): (&Array2<f64>, &Array2<f64>),
        comparison: &mut Comparison,
    ) -> Result<(), Failure> {
        let (args, file) = (self.args, self.stored);
        let Prepared { body, surface, .. } = file.prepared;
        let plastic = file.field("plastic_displacement_z", waypoint)?;
        let lowest = plastic.iter().copied().fold(f64::INFINITY, f64::min);
        let mean = plastic.mean().unwrap_or(f64::NAN);
        for (name, found) in [("plastic_displacement_min", lowest), ("plastic_displacement_mean", mean)] {
            comparison.number(&format!("/path/{name}"), file.number(name, step), found, file.height() * 1e-6);
        }
        let elastic = Contact::new(body, &surface.grid, &surface.heights)
            .and_then(|contact| contact.certify(pressure, Load::Approach(0.0)))
            .map_err(|refusal| Failure::input("/surface/height", refusal))?;
        let rest: Vec<f64> = displacement.iter().zip(&plastic).map(|(u, plastic)| u - plastic).collect();
        let distance = apart(&flat(&elastic.displacement), &rest) / file.height();
        comparison.at_most("/fields/displacement_z", distance, 100.0 * args.steps.search.tolerance);
        Ok(())
    }

    /// Returns the shear, component by component, and compares its means.
    fn shear(&self, waypoint: usize, step: usize, comparison: &mut Comparison) -> Result<Vec<f64>, Failure> {
        let file = self.stored;
        let mut all = Vec::new();
        for name in if file.prepared.surface.grid.is_line() { &["shear_x"][..] } else { &["shear_x", "shear_y"] } {
            let shear = flat(&file.field(name, waypoint)?);
            let mean = shear.iter().sum::<f64>() / shear.len() as f64;
            let column = format!("mean_{name}");
            let (path, unit) = (format!("/path/{column}"), file.prepared.unit_pressure());
            comparison.number(&path, file.number(&column, step), mean, 1e-3 * unit);
            all.extend(shear);
        }
        Ok(all)
    }

    /// Recomputes the displacement of an elastic body from the tractions, and the energy.
    fn elastic(
        &self,
        step: usize,
        (shears, pressure, displacement): (&[f64], &Array2<f64>, &Array2<f64>),
        comparison: &mut Comparison,
    ) -> Result<(), Failure> {
        let (args, file) = (self.args, self.stored);
        let Prepared { surface, body, facts, .. } = file.prepared;
        let traction: Vec<f64> = shears.iter().copied().chain(pressure.iter().map(|p| -p)).collect();
        let mut found = vec![0.0; traction.len()];
        match surface.boundary {
            Boundary::Periodic => {
                let response = FullResponse::new(surface.grid, body).into();
                FullTransforms::of(&response).compliance(&traction, &mut found);
            }
            Boundary::Free => {
                let response = FreeFullCompliance::new(surface.grid, body);
                let response = response.map_err(|error| Failure::input("/surface/height", error))?.into();
                FreeFullTransforms::of(&response).compliance(&traction, &mut found);
            }
        }
        let distance = apart(&found[shears.len()..], &flat(displacement)) / file.height();
        comparison.at_most("/fields/displacement_z", distance, 100.0 * args.steps.search.tolerance);
        if facts.friction.is_some() && !facts.has_law() {
            let energy = traction.iter().zip(&found).map(|(t, u)| t * u).sum::<f64>() * 0.5 / pressure.len() as f64;
            comparison.number("/path/elastic_energy", file.number("elastic_energy", step), energy, 0.0);
        }
        Ok(())
    }

    /// Checks that the shear stays within its limit at each point.
    fn limits(&self, limits: &[f64], shear: &[f64], comparison: &mut Comparison) {
        let points = limits.len();
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

fn mean(field: &Array2<f64>) -> f64 {
    field.mean().unwrap_or(f64::NAN)
}

fn flat(field: &Array2<f64>) -> Vec<f64> {
    field.iter().copied().collect()
}

/// Compares a stored mean gap with the mean found, relative to heights of size `height`. In full contact behind a wall
/// the stored gap is zero, while the search leaves a gap within its tolerance.
fn compare_gap(
    (path, stored, found): (&str, f64, f64),
    (is_closed, height, tolerance): (bool, f64, f64),
    comparison: &mut Comparison,
) {
    if is_closed && stored == 0.0 {
        comparison.at_most(path, found.abs() / height, 10.0 * tolerance);
    } else {
        comparison.number(path, stored, found, height);
    }
}
