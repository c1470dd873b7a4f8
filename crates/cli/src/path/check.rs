//! The check of the file of a path.

use gfmd_contact::{Boundary, Drive, Fields, Load};
use gfmd_files::Reader;
use gfmd_interface::{Quasistatic as _, Step};
use gfmd_law::Limit;
use gfmd_problem::{Posed, Rest};
use gfmd_record::{At, Column, Origin, Record, columns};
use gfmd_response::{FreeFullCompliance, FreeFullTransforms, FullResponse, FullTransforms};
use ndarray::{Array2, ArrayRef2};
use std::path::Path;

use super::file::PathFile;
use super::{Args, Prepared};
use crate::failure::Failure;
use crate::result::{
    Comparison, Configuration, Kind as ResultKind, RESIDUAL_OF_A_PATCH, compare_heights, layout, regenerated,
    repeated_problem, stored_problem, stored_unit,
};
use crate::session::Session;

/// Recomputes the states at the waypoints from the stored fields, and the drives of all steps.
pub(crate) fn check(
    reader: &Reader,
    config: &Configuration,
    comparison: &mut Comparison,
    session: &Session,
) -> Result<(), Failure> {
    compare_heights(reader, comparison)?;
    let args: Args = stored_problem(reader, config)?;
    regenerated(reader, config, args.boundary, comparison, session)?;
    let mut prepared = Prepared::new(&args, session)?;
    // As it is spelt there.
    prepared.surface.unit = stored_unit(reader, "/surface");
    layout(ResultKind::Path, reader, comparison, |output| {
        let file = PathFile::create(output, &prepared, &args, session)?;
        file.finish(&[], prepared.drives.len(), None)
    })?;
    let names = columns(&prepared.facts).filter(|column| (column.in_file)(&prepared.facts)).map(|column| column.name);
    let columns = names.filter(|name| reader.contains(&format!("/path/{name}"))).map(|name| {
        let values = reader.values::<f64>(&format!("/path/{name}"))?;
        Ok((name, values))
    });
    let columns: Vec<(&str, Vec<f64>)> = columns.collect::<Result<_, Failure>>()?;
    let stored = |name: &str, step: usize| -> f64 {
        let column = columns.iter().find(|(other, _)| *other == name);
        column.and_then(|(_, values)| values.get(step).copied()).unwrap_or(f64::NAN)
    };
    let contact = prepared.pose(&args)?;
    let check = StateCheck { reader, args: &args, prepared: &prepared, contact: &contact };
    for (step, drive) in prepared.drives.iter().enumerate() {
        check.columns(step, &stored, comparison);
        if stored("converged", step) != 1.0 {
            continue;
        }
        comparison.at_most(&format!("residual of step {step}"), stored("residual", step), args.tol);
        match drive.load {
            // The load is met to the tolerance.
            Load::MeanPressure(asked) => comparison.at_most(
                &format!("load of step {step}"),
                (stored("mean_pressure", step) - asked).abs() / asked.abs().max(check.stress()),
                10.0 * args.tol,
            ),
            Load::Approach(asked) => comparison.number("/path/displacement", stored("displacement", step), asked, 0.0),
        }
        comparison.number("/path/lateral_x", stored("lateral_x", step), drive.lateral[0], 0.0);
        comparison.number("/path/lateral_y", stored("lateral_y", step), drive.lateral[1], 0.0);
        if step.is_multiple_of(args.steps as usize) {
            check.waypoint(step / args.steps as usize, *drive, comparison, &|name| stored(name, step))?;
        }
    }
    Ok(())
}

struct StateCheck<'a> {
    reader: &'a Reader,
    args: &'a Args,
    prepared: &'a Prepared,
    contact: &'a Posed,
}

impl StateCheck<'_> {
    /// The unit of stress, E* times the rms gradient.
    fn stress(&self) -> f64 {
        self.prepared.body.contact_modulus() * self.prepared.surface.rms_gradient()
    }

    /// Compares the scalars of a step that follow from others, of this step and of the one before.
    fn columns(&self, step: usize, stored: &dyn Fn(&str, usize) -> f64, comparison: &mut Comparison) {
        let now = |name: &str| stored(name, step);
        let [residual, pressure] = ["residual", "mean_pressure"].map(now);
        // A step that was not made has no numbers.
        if pressure.is_nan() && residual.is_nan() && now("converged").is_nan() {
            return;
        }
        let converged = f64::from(u8::from(residual <= self.args.tol));
        comparison.number("/path/converged", now("converged"), converged, 0.0);
        comparison.number("/path/p_star", now("p_star"), pressure / self.stress(), 0.0);
        // Without further solves the loss is the balance of the work, by the trapezoidal rule, and the energy.
        let has_energy = self.prepared.solves_a_law() && !now("interface_energy").is_nan();
        if step == 0 || !has_energy || now("extra_solves") != 0.0 || now("converged") != 1.0 {
            return;
        }
        let before = |name: &str| stored(name, step - 1);
        let [mut work, mut spread, mut floor] = [0.0_f64; 3];
        for (force, way) in
            [("mean_pressure", "displacement"), ("mean_shear_x", "lateral_x"), ("mean_shear_y", "lateral_y")]
        {
            let moved = now(way) - before(way);
            work += 0.5 * (now(force) + before(force)) * moved;
            spread += 0.5 * ((now(force) - before(force)) * moved).abs();
            floor += 0.5 * (now(force).abs() + before(force).abs()) * now(way).abs().max(before(way).abs());
        }
        let energy = |at: &dyn Fn(&str) -> f64| at("elastic_energy") + at("interface_energy");
        let missing = work - (energy(&now) - energy(&before));
        floor = floor.max(energy(&now).abs()).max(energy(&before).abs());
        comparison.number("/path/dissipated", now("dissipated"), missing, floor);
        comparison.number("/path/dissipated_error", now("dissipated_error"), spread + missing.abs(), floor);
    }

    /// The unit of length, the rms height.
    fn height(&self) -> f64 {
        self.prepared.surface.heights.std(0.0).max(f64::MIN_POSITIVE)
    }

    fn is_law_on_patch(&self) -> bool {
        self.prepared.solves_a_law() && self.prepared.surface.boundary == Boundary::Free
    }

    /// The largest residual that may follow from the fields of the file.
    fn allowed(&self) -> f64 {
        self.args.tol * if self.is_law_on_patch() { RESIDUAL_OF_A_PATCH } else { 1.0 }
    }

    fn field(&self, name: &str, waypoint: usize) -> Result<Array2<f64>, Failure> {
        let [nx, ny] = self.prepared.surface.grid.points();
        let values = self.reader.slab(&format!("/fields/{name}"), waypoint)?;
        Array2::from_shape_vec((nx, ny), values).map_err(|error| Failure::input("/fields", error))
    }

    fn waypoint(
        &self,
        waypoint: usize,
        drive: Drive,
        comparison: &mut Comparison,
        stored: &dyn Fn(&str) -> f64,
    ) -> Result<(), Failure> {
        let Self { args, prepared, contact, .. } = self;
        let gap = self.field("gap", waypoint)?;
        if prepared.facts.moves_sideways() {
            return self.tractions(waypoint, &gap, comparison, stored);
        }
        let pressure = self.field("pressure", waypoint)?;
        let fields = contact.basis().iter().map(|name| match *name {
            // Without a hardness nothing gives way.
            "plastic_depth" if !prepared.facts.hardness => Ok(Array2::zeros(pressure.dim())),
            name => self.field(name, waypoint),
        });
        let fields = fields.collect::<Result<Vec<Array2<f64>>, Failure>>()?;
        let fields: Vec<&ArrayRef2<f64>> = fields.iter().map(|field| &**field).collect();
        let state = contact.certify(&fields, drive).map_err(|error| Failure::input("/surface/height", error))?;
        if self.is_law_on_patch() {
            let found = flat(&self.pressure(&state));
            let worst = farthest(&flat(&pressure), &found) / self.stress();
            comparison.at_most("/fields/pressure", worst, 100.0 * args.tol);
            let displacement = flat(&self.field("displacement_z", waypoint)?);
            let worst = farthest(&displacement, &flat(&state.displacement_z().to_owned())) / self.height();
            comparison.at_most("/fields/displacement_z", worst, 100.0 * args.tol);
        } else {
            if prepared.solves_a_law() {
                comparison.values("/fields/pressure", &flat(&pressure), &flat(&self.pressure(&state)), 0.0);
            } else {
                comparison.values("/fields/gap", &flat(&gap), &flat(&state.gap().to_owned()), self.height());
            }
            self.displacement(waypoint, &state, comparison)?;
        }
        let reading = contact.reading(&state);
        let at =
            At::in_scales(&prepared.facts, &state, &self.prepared.scales(), &prepared.surface.grid, self.allowed());
        let step = Step::default();
        let record = Record::of(&At { approach: reading.approach, step: Some((&step, reading)), ..at });
        self.scalars(&record, comparison, stored);
        Ok(())
    }

    /// The pressure in the file: without attraction that of the wall.
    fn pressure(&self, state: &Rest) -> Array2<f64> {
        if self.prepared.facts.has_law() { state.pressure() } else { state.repulsion() }.into_owned()
    }

    /// Compares the displacement with that of a state.
    fn displacement(&self, waypoint: usize, state: &impl Fields, comparison: &mut Comparison) -> Result<(), Failure> {
        let found: Vec<f64> = state.displacement_z().iter().copied().collect();
        comparison.values("/fields/displacement_z", &flat(&self.field("displacement_z", waypoint)?), &found, 0.0);
        Ok(())
    }

    /// Compares the scalars that follow from a state.
    fn scalars(&self, record: &Record, comparison: &mut Comparison, stored: &dyn Fn(&str) -> f64) {
        let in_file = |column: &Column| (column.in_file)(&self.prepared.facts);
        let of_state = |origin| matches!(origin, Origin::Fields | Origin::Residual);
        for (column, cell) in record.cells().filter(|(column, _)| in_file(column) && of_state(column.origin)) {
            let (path, stored, found) = (format!("/path/{}", column.name), stored(column.name), cell.number());
            match column.name {
                "residual" if self.is_law_on_patch() => {
                    comparison.at_most(&path, stored, self.args.tol);
                    comparison.at_most(&path, found, self.allowed());
                }
                "residual" => comparison.number(&path, stored, found, 1e-3),
                _ if self.is_law_on_patch() => {
                    let unit = match column.unit {
                        "stress" => self.stress(),
                        "length" => self.height(),
                        "stress*length" => self.stress() * self.height(),
                        _ => 1.0,
                    };
                    if stored.to_bits() != found.to_bits() {
                        let apart = (stored - found).abs() / stored.abs().max(unit);
                        comparison.at_most(&path, apart, 100.0 * self.args.tol);
                    }
                }
                "mean_gap" => comparison.number(&path, stored, found, self.height()),
                _ => comparison.number(&path, stored, found, 0.0),
            }
        }
    }

    /// Recomputes the displacement from the tractions, and from it gap and energy.
    fn tractions(
        &self,
        waypoint: usize,
        gap: &Array2<f64>,
        comparison: &mut Comparison,
        stored: &dyn Fn(&str) -> f64,
    ) -> Result<(), Failure> {
        let Self { args, prepared: Prepared { surface, body, .. }, .. } = self;
        let points = surface.grid.len();
        let pressure = self.field("pressure", waypoint)?;
        let mut traction = Vec::new();
        for name in if surface.grid.is_line() { &["shear_x"][..] } else { &["shear_x", "shear_y"] } {
            let shear = flat(&self.field(name, waypoint)?);
            let mean = shear.iter().sum::<f64>() / points as f64;
            let column = format!("mean_{name}");
            comparison.number(&format!("/path/{column}"), stored(&column), mean, self.stress() * 1e-3);
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
        // The mean displacement of a half-space is a matter of convention, so that the gap is compared up to its mean.
        let highest = surface.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let found: Vec<f64> =
            surface.heights.iter().zip(&displacement[lateral..]).map(|(h, u)| highest - h - u).collect();
        let height = self.height();
        let stored_displacement = flat(&self.field("displacement_z", waypoint)?);
        comparison.at_most("/fields/gap", apart(&found, &flat(gap)) / height, 100.0 * args.tol);
        let worst = apart(&displacement[lateral..], &stored_displacement) / height;
        comparison.at_most("/fields/displacement_z", worst, 100.0 * args.tol);
        let law = self.prepared.limit.is_none().then_some(&self.prepared.law);
        if law.is_none_or(|law| law.has_wall()) {
            let below = -gap.iter().copied().fold(0.0, f64::min) / height;
            comparison.at_most("/fields/gap (penetration)", below, args.tol);
        }
        let mean_pressure = pressure.mean().unwrap_or(f64::NAN);
        match law {
            // The mean pressure is that of the law, the field that of the displacement: equal to the residual.
            Some(_) => comparison.at_most(
                "/path/mean_pressure",
                (stored("mean_pressure") - mean_pressure).abs() / self.stress(),
                100.0 * args.tol,
            ),
            None => comparison.number("/path/mean_pressure", stored("mean_pressure"), mean_pressure, 0.0),
        }
        comparison.number("/path/mean_gap", stored("mean_gap"), gap.mean().unwrap_or(f64::NAN), height);
        let energy = 0.5 * traction.iter().zip(&displacement).map(|(t, u)| t * u).sum::<f64>() / points as f64;
        let approaches =
            surface.heights.iter().zip(&stored_displacement).zip(gap).map(|((h, u), gap)| highest - h - u - gap);
        let approach = approaches.sum::<f64>() / points as f64;
        comparison.at_most("/path/displacement", (stored("displacement") - approach).abs() / height, args.tol);
        if let Some(limit) = self.prepared.limit {
            comparison.number("/path/elastic_energy", stored("elastic_energy"), energy, 0.0);
            let touching = pressure.iter().filter(|p| **p > 0.0).count() as f64 / points as f64;
            comparison.number("/path/area_fraction", stored("area_fraction"), touching, 0.0);
            self.limits(limit, &pressure, &traction[..lateral], comparison);
        }
        Ok(())
    }

    /// The shear stays within its limit.
    fn limits(&self, limit: Limit, pressure: &Array2<f64>, shear: &[f64], comparison: &mut Comparison) {
        let points = pressure.len();
        let limits: Vec<f64> = pressure.iter().map(|p| if *p > 0.0 { limit.at(*p) } else { 0.0 }).collect();
        let strongest = limits.iter().copied().fold(0.0, f64::max);
        let magnitude = |i: usize| shear.chunks_exact(points).map(|s| s[i] * s[i]).sum::<f64>().sqrt();
        let excess = (0..points).map(|i| magnitude(i) - limits[i]).fold(0.0, f64::max);
        if strongest > 0.0 {
            comparison.at_most("/fields/shear (limit)", excess / strongest, self.args.tol);
        }
    }
}

/// The largest distance of two fields, each less its mean. NaN if there is one.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let mean = |field: &[f64]| field.iter().sum::<f64>() / field.len() as f64;
    let shift = mean(a) - mean(b);
    let distances = a.iter().zip(b).map(|(a, b)| (a - b - shift).abs());
    distances.fold(0.0, |worst: f64, distance| if distance > worst || distance.is_nan() { distance } else { worst })
}

/// The largest distance of two fields. NaN if there is one.
fn farthest(a: &[f64], b: &[f64]) -> f64 {
    let distances = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    distances.fold(0.0, |worst: f64, distance| if distance > worst || distance.is_nan() { distance } else { worst })
}

fn flat(field: &Array2<f64>) -> Vec<f64> {
    field.iter().copied().collect()
}

/// Runs the configuration of a file again, with the output `out`.
pub(crate) fn again(reader: &Reader, config: &Configuration, out: &Path, session: &Session) -> Result<bool, Failure> {
    let args: Args = repeated_problem(reader, config)?;
    super::run(&Args { out: Some(out.into()), ..args }, session)?;
    Ok(true)
}
