//! The check of the file of a contact.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;

use gfmd_contact::{Boundary, Fields as _, Load, Refusal, Stiffness};
use gfmd_files::Reader;
use gfmd_law::Kind;
use gfmd_measure::Scales;
use gfmd_problem::{NoStiffness, Posed, Rest};
use gfmd_record::{At, NOT_SOLVED, Origin, Record, arrays, repulsion};
use ndarray::{Array2, ArrayRef2, ArrayView2};

use super::file::{Chosen, ContactFile};
use super::statistics::{self, Findings, Measured, Stored};
use super::{Args, Prepared};
use crate::base::MovedBase;
use crate::failure::Failure;
use crate::result::{
    Comparison, Configuration, Kind as ResultKind, RESIDUAL_OF_A_PATCH, compare_heights, layout, regenerated,
    repeated_problem, stored_problem, stored_unit,
};
use crate::session::Session;

/// The relative differences of the numbers of a law on a patch, over the tolerance of the solve.
const OF_A_PATCH: f64 = 100.0;

/// Recomputes every load of a file from its surface, body and pressure, or gap: fields, residuals, area, energy.
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
    if let Some(lower) = &mut prepared.lower {
        lower.unit = stored_unit(reader, "/lower");
    }
    let Prepared { surface, body, base, lower, controls, .. } = &prepared;
    let heights = &*MovedBase::under(base.as_ref(), &surface.heights);
    let scales = Scales { contact_modulus: body.contact_modulus(), rms_gradient: surface.rms_gradient() };
    let count = reader.shape("/loads/mean_pressure")?.first().copied().unwrap_or(0);
    if count != controls.len() {
        comparison
            .differ("/loads/mean_pressure", format!("it has {count} loads; the configuration has {}", controls.len()));
    }
    let loads = &controls[..count.min(controls.len())];
    let others = [(args.law.law != Kind::HardWall, "/fields/gap"), (lower.is_some(), "/fields/lower_pressure")];
    let others = others.into_iter().filter_map(|(needed, field)| needed.then_some(field));
    let mut needed = ["/fields/pressure"].into_iter().chain(others);
    if let (Some(missing), true) = (needed.find(|needed| !reader.contains(needed)), args.fields.is_some()) {
        session.warn(
            "fields-missing",
            format!("the file has no {missing}, from which loads are recomputed; --rerun solves them"),
        );
        return Ok(());
    }
    if let Some(base) = base {
        let lift: Vec<f64> = base.lift.iter().copied().collect();
        comparison.values("/base/lift", &reader.values::<f64>("/base/lift")?, &lift, 0.0);
    }
    let tolerance = args.solver.tol;
    let facts = prepared.facts;
    let mut file = Checked {
        reader,
        args: &args,
        prepared: &prepared,
        lift: base.as_ref().map(|base| &base.lift),
        scales,
        tolerance,
        measured: Vec::new(),
        records: Vec::new(),
    };
    if let Some(lower) = lower
        && let Ok(stated) = reader.text("/lower", "height_sha256")
        && lower.checksum() != stated
    {
        comparison.differ("/lower/height", "its checksum does not hold".into());
    }
    let contact = prepared.pose(&args, heights, Arc::clone(&prepared.law))?;
    file.compare_all(&contact, loads, comparison)?;
    let Checked { measured, records, .. } = file;
    layout(ResultKind::Contact, reader, comparison, |output| {
        let chosen = args.fields.clone().unwrap_or_default();
        let provenance = session.provenance(String::new());
        let count = controls.len();
        let mut file = ContactFile::create(Some(output), &provenance, surface, count, facts, chosen)?;
        base.as_ref().map_or(Ok(()), |base| file.write_base(base, surface))?;
        lower.as_ref().map_or(Ok(()), |lower| file.write_lower(lower))?;
        file.write_hardness(prepared.hardness.as_ref(), surface)?;
        if facts.statistics {
            file.write_statistics(surface, &measured)?;
        }
        let path = file.finish(&records, count, None)?;
        path.ok_or_else(|| Failure::Computation("the layout was not written".into()))
    })
}

/// False for the fields of a load that was not solved, which are NaN.
fn is_solved(field: &Array2<f64>) -> bool {
    field.iter().all(|value| value.is_finite())
}

/// The file of a contact, and what its loads must have.
struct Checked<'a> {
    reader: &'a Reader,
    args: &'a Args,
    prepared: &'a Prepared,
    /// The lift that a base that moves adds to the displacement.
    lift: Option<&'a Array2<f64>>,
    scales: Scales,
    tolerance: f64,
    /// The statistics of the loads so far, from the fields of the file.
    measured: Vec<Measured>,
    /// The records of the loads.
    records: Vec<Record>,
}

impl Checked<'_> {
    fn field(&self, name: &str, index: usize) -> Result<Array2<f64>, Failure> {
        let values = self.reader.slab(&format!("/fields/{name}"), index)?;
        let made = Array2::from_shape_vec(self.prepared.surface.grid.points(), values);
        made.map_err(|error| Failure::input("/fields", error))
    }

    /// Compares all loads with the states that the contact makes of their fields, and then the statistics.
    fn compare_all(&mut self, contact: &Posed, loads: &[Load], comparison: &mut Comparison) -> Result<(), Failure> {
        let refuse = |error: Refusal| Failure::input("/surface/height", error);
        for (index, load) in loads.iter().enumerate() {
            let fields = contact.basis().iter().map(|name| self.field(name, index));
            let fields = fields.collect::<Result<Vec<Array2<f64>>, Failure>>()?;
            if fields.iter().all(is_solved) {
                let fields: Vec<&ArrayRef2<f64>> = fields.iter().map(|field| &**field).collect();
                let state = contact.certify(&fields, (*load).into()).map_err(refuse)?;
                let stiffness = match contact.stiffness(&state) {
                    Ok(stiffness) | Err(NoStiffness::Inexact(stiffness, _)) => Ok(stiffness),
                    Err(NoStiffness::Undefined(reason)) => Err(reason.into()),
                };
                self.compare(index, *load, &state, stiffness, comparison)?;
            }
        }
        self.compare_statistics(comparison)
    }

    fn compare(
        &mut self,
        index: usize,
        load: Load,
        state: &Rest,
        stiffness: Result<Stiffness, Cow<'static, str>>,
        comparison: &mut Comparison,
    ) -> Result<(), Failure> {
        let Self { reader, prepared, ref scales, tolerance, .. } = *self;
        let Prepared { facts, surface, .. } = prepared;
        let is_law_on_patch = facts.has_law() && facts.boundary == Boundary::Free;
        let allowed = match reader.values::<f64>("/loads/converged")?.get(index) {
            Some(1.0) if is_law_on_patch => RESIDUAL_OF_A_PATCH * tolerance,
            _ => tolerance,
        };
        comparison.accurate_to(if is_law_on_patch { OF_A_PATCH * tolerance } else { 0.0 });
        for (array, field) in arrays(facts).zip(Chosen::All.fields(facts, state, self.lift)) {
            let path = format!("/fields/{}", array.name);
            if reader.contains(&path) {
                let values: Vec<f64> = field.iter().copied().collect();
                comparison.values(&path, &reader.slab::<f64>(&path, index)?, &values, 0.0);
            }
        }
        let at = At::in_scales(facts, state, scales, &surface.grid, allowed);
        let stiffness = if at.has_converged() { stiffness } else { Err(NOT_SOLVED.into()) };
        let at = At { stiffness, ..at };
        // From the fields of the file: a number that rounding moves to another bin would be a difference.
        let stored = |name: &str, made: ArrayView2<f64>| {
            if reader.contains(&format!("/fields/{name}")) { self.field(name, index) } else { Ok(made.to_owned()) }
        };
        let repulsion = stored(repulsion(facts), state.repulsion().view())?.mapv(|p| p.max(0.0));
        let gap = stored("gap", state.gap())?;
        let findings = Findings::of((self.args, prepared), [repulsion.view(), gap.view()], &at, |_, _| {})?;
        let record = Record::of(&At { measured: findings.borrowed(), ..at });
        self.measured.extend(findings.arrays);
        for (column, cell) in record.cells() {
            let (name, found) = (column.name, cell.number());
            if matches!(column.origin, Origin::Way | Origin::Clock) {
                continue;
            }
            let path = format!("/loads/{name}");
            // The layout tells what is missing.
            if !reader.contains(&path) {
                continue;
            }
            let stored: Vec<f64> = reader.values(&path)?;
            // Residuals are small beside 1, and rounding makes them.
            // Equal pressures deviate, and closed gaps gape, by rounding.
            let floor = match name {
                _ if column.origin == Origin::Residual => 1e-3,
                "pressure_deviation_in_contact" => record.number("max_pressure"),
                "mean_gap" | "lower_mean_gap" => surface.statistics.moments.rms_height(),
                _ => 0.0,
            };
            let stored = stored.get(index).copied().unwrap_or(f64::NAN);
            if is_law_on_patch && name.starts_with("residual_") && record.is("converged") {
                comparison.at_most(&path, stored, tolerance);
                comparison.at_most(&path, found, allowed);
            } else {
                comparison.number(&path, stored, found, floor);
            }
            if name == "converged" && stored == 1.0 {
                comparison.at_most(&format!("residual of load {index}"), state.worst(), allowed);
            }
        }
        if let Load::Approach(asked) = load {
            comparison.number("/loads/displacement", asked, record.number("displacement"), 0.0);
        }
        comparison.accurate_to(0.0);
        self.records.push(record);
        Ok(())
    }

    /// Compares the arrays of the statistics of all loads.
    fn compare_statistics(&self, comparison: &mut Comparison) -> Result<(), Failure> {
        for Stored { path, values } in statistics::arrays(&self.measured) {
            if self.reader.contains(path) {
                comparison.values(path, &self.reader.values::<f64>(path)?, &values, 0.0);
            } else if !values.is_empty() {
                comparison.differ(path, "it is missing".into());
            }
        }
        Ok(())
    }
}

/// Runs the configuration of a file again, with the output `out`.
pub(crate) fn again(reader: &Reader, config: &Configuration, out: &Path, session: &Session) -> Result<bool, Failure> {
    let args: Args = repeated_problem(reader, config)?;
    super::run(&Args { out: Some(out.into()), ..args }, session)?;
    Ok(true)
}
