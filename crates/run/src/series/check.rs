//! The states of a file, made again from its fields, and compared with what the file says of them.

use gfmd_contact::{Boundary, Drive, Fields as _, Load};
use gfmd_files::Reader;
use gfmd_flow::Flow;
use gfmd_interface::{Quasistatic as _, Step};
use gfmd_problem::{GridError, Posed, Rest, Task};
use gfmd_record::{At, Column, Measured, Origin, Record, arrays};
use ndarray::{Array2, ArrayRef2};

use super::{Chosen, Parts, Prepared};
use crate::failure::Failure;
use crate::result::{Comparison, RESIDUAL_OF_A_PATCH};

/// The relative differences of the numbers of a law on a patch, over the tolerance of the solve.
pub(crate) const OF_A_PATCH: f64 = 100.0;

/// The file of a series, with the contact that it is about.
pub struct Stored<'a> {
    /// The file.
    pub reader: &'a Reader,
    /// The input that its configuration and its arrays give.
    pub prepared: &'a Prepared,
    /// The contact posed on it.
    pub contact: &'a Posed,
    /// The tolerance of its states.
    pub tolerance: f64,
    /// The columns of the file, part by part.
    records: Vec<Record>,
}

impl<'a> Stored<'a> {
    /// Reads the columns of a file.
    ///
    /// # Errors
    /// A file that cannot be read, or of another problem.
    pub fn new(
        reader: &'a Reader,
        prepared: &'a Prepared,
        contact: &'a Posed,
        tolerance: f64,
    ) -> Result<Self, Failure> {
        let records = super::records_of(reader, &prepared.facts)?;
        Ok(Self { reader, prepared, contact, tolerance, records })
    }

    /// The number of parts.
    pub fn count(&self) -> usize {
        self.records.len()
    }

    /// A number of a part; NaN without one.
    pub fn number(&self, name: &str, index: usize) -> f64 {
        self.records.get(index).map_or(f64::NAN, |record| record.number(name))
    }

    /// The path of a column.
    pub fn path(&self, name: &str) -> String {
        format!("{}/{name}", Parts::of(&self.prepared.facts).group)
    }

    /// The unit of length, the rms height.
    pub fn height(&self) -> f64 {
        self.prepared.surface.statistics.moments.rms_height().max(f64::MIN_POSITIVE)
    }

    /// True if a law acts on a patch, whose displacement outside of it is not in the file: states made again are then
    /// as exact as their search.
    pub(crate) fn is_law_on_patch(&self) -> bool {
        self.prepared.facts.solves_a_law() && self.prepared.facts.boundary == Boundary::Free
    }

    /// The largest residual of a state that converged, made again.
    pub fn allowed(&self) -> f64 {
        self.tolerance * if self.is_law_on_patch() { RESIDUAL_OF_A_PATCH } else { 1.0 }
    }

    /// A field at a place of the file.
    ///
    /// # Errors
    /// A field that the file does not have in this shape.
    pub fn field(&self, name: &str, place: usize) -> Result<Array2<f64>, Failure> {
        let values = self.reader.slab(&format!("/fields/{name}"), place)?;
        let made = Array2::from_shape_vec(self.prepared.surface.grid.points(), values);
        made.map_err(|error| Failure::input("/fields", error))
    }

    /// The state that the contact makes of the fields at a place; `None` of a part that was not solved, whose fields
    /// are NaN.
    ///
    /// # Errors
    /// Fields that cannot be read, or of which no state can be made.
    pub fn state(&self, place: usize, drive: Drive) -> Result<Option<Rest>, Failure> {
        let fields = self.contact.basis().iter().map(|name| match *name {
            // Without a hardness nothing gives way.
            "plastic_depth" if !self.prepared.facts.hardness => Ok(Array2::zeros(self.prepared.surface.grid.points())),
            name => self.field(name, place),
        });
        let fields = fields.collect::<Result<Vec<Array2<f64>>, Failure>>()?;
        if fields.iter().flatten().any(|value| !value.is_finite()) {
            return Ok(None);
        }
        let fields: Vec<&ArrayRef2<f64>> = fields.iter().map(|field| &**field).collect();
        self.contact.certify(&fields, drive).map(Some).map_err(|refusal| Failure::input("/surface/height", refusal))
    }

    /// Compares what a step of a path states of its drive: convergence, reduced load, load or approach. True if it
    /// converged, and the rest of it can be compared.
    pub fn compare_step(&self, index: usize, drive: Drive, comparison: &mut Comparison) -> bool {
        let number = |name: &str| self.number(name, index);
        let [residual, pressure, converged] = ["residual", "mean_pressure", "converged"].map(number);
        // A step that was not made has no numbers.
        if [residual, pressure, converged].iter().all(|number| number.is_nan()) {
            return false;
        }
        let (unit, is_at_rest) = (self.prepared.unit_pressure(), f64::from(u8::from(residual <= self.tolerance)));
        comparison.number(&self.path("converged"), converged, is_at_rest, 0.0);
        comparison.number(&self.path("p_star"), number("p_star"), pressure / unit, 0.0);
        if converged != 1.0 {
            return false;
        }
        comparison.at_most(&format!("residual of step {index}"), residual, self.tolerance);
        match drive.load {
            // The load is met to the tolerance.
            Load::MeanPressure(asked) => comparison.at_most(
                &format!("load of step {index}"),
                (pressure - asked).abs() / asked.abs().max(unit),
                10.0 * self.tolerance,
            ),
            Load::Approach(asked) => {
                comparison.number(&self.path("displacement"), number("displacement"), asked, 0.0);
            }
        }
        true
    }

    /// Compares the numbers and fields of a step at a waypoint with the state that the contact makes of the fields, and
    /// returns the state; `None` of a step that was not solved. `flow` computes the flow through its gap, if it is
    /// asked for.
    ///
    /// # Errors
    /// The errors of [`state`](Self::state).
    pub fn compare_waypoint(
        &self,
        (index, place): (usize, usize),
        drive: Drive,
        flow: impl FnOnce(&Rest, &At<'_>) -> Result<Option<Flow>, Failure>,
        comparison: &mut Comparison,
    ) -> Result<Option<Rest>, Failure> {
        let Some(state) = self.state(place, drive)? else { return Ok(None) };
        self.compare_fields(place, &state, comparison)?;
        let (reading, step) = (self.contact.reading(&state), Step::default());
        let at = self.at(index, &state);
        let flow = flow(&state, &at)?;
        let measured = Measured { flow: flow.as_ref(), ..Measured::default() };
        let at = At { approach: reading.approach, step: Some((&step, reading)), measured, ..at };
        self.compare_record(index, (&Record::of(&at), &state), comparison);
        Ok(Some(state))
    }

    /// Compares the fields of a state with those at a place.
    ///
    /// # Errors
    /// Fields that cannot be read.
    pub fn compare_fields(&self, place: usize, state: &Rest, comparison: &mut Comparison) -> Result<(), Failure> {
        let facts = &self.prepared.facts;
        comparison.accurate_to(if self.is_law_on_patch() { OF_A_PATCH * self.tolerance } else { 0.0 });
        for (array, field) in arrays(facts).zip(Chosen::All.fields(facts, state, self.prepared.lift())) {
            let path = format!("/fields/{}", array.name);
            if self.reader.contains(&path) {
                let values: Vec<f64> = field.iter().copied().collect();
                comparison.values(
                    &path,
                    &self.reader.slab::<f64>(&path, place)?,
                    &values,
                    self.floor_of_field(array.name),
                );
            }
        }
        comparison.accurate_to(0.0);
        Ok(())
    }

    /// The least scale of a field. The gap of full contact is what rounding leaves.
    fn floor_of_field(&self, name: &str) -> f64 {
        let patch = self.is_law_on_patch();
        match name {
            "pressure" if patch => self.prepared.unit_pressure(),
            "displacement_z" if patch => self.height(),
            "gap" | "lower_gap" if self.prepared.facts.task == Task::Path => self.height(),
            _ => 0.0,
        }
    }

    /// The numbers of a state so far, whose residuals may be those that are [allowed](Self::allowed).
    pub fn at<'s>(&'s self, index: usize, state: &'s Rest) -> At<'s> {
        let allowed = if self.number("converged", index) == 1.0 { self.allowed() } else { self.tolerance };
        self.prepared.at(state, allowed)
    }

    /// Compares the numbers of a part that follow from its fields.
    pub fn compare_record(&self, index: usize, (record, state): (&Record, &Rest), comparison: &mut Comparison) {
        let patch = self.is_law_on_patch();
        let has_converged = self.number("converged", index) == 1.0;
        comparison.accurate_to(if patch { OF_A_PATCH * self.tolerance } else { 0.0 });
        let of_fields = |origin| matches!(origin, Origin::Fields | Origin::Grid | Origin::Residual);
        // What a finer grid told is not in the file.
        let is_refined = self.prepared.facts.grid_error == GridError::Refine;
        let is_told = |column: &Column| of_fields(column.origin) && !(is_refined && column.origin == Origin::Grid);
        for (column, cell) in record.cells().filter(|(column, _)| is_told(column)) {
            let path = self.path(column.name);
            // The layout tells what is missing.
            if !self.reader.contains(&path) {
                continue;
            }
            let (stored, found) = (self.number(column.name, index), cell.number());
            if patch && column.name.starts_with("residual") && record.is("converged") {
                comparison.at_most(&path, stored, self.tolerance);
                comparison.at_most(&path, found, self.allowed());
            } else {
                comparison.number(&path, stored, found, self.floor(column, record));
            }
        }
        comparison.accurate_to(0.0);
        if has_converged {
            let name = Parts::of(&self.prepared.facts).name;
            comparison.at_most(&format!("residual of {name} {index}"), state.worst(), self.allowed());
        }
    }

    /// The least scale of a number, below which a difference is one of rounding.
    fn floor(&self, column: &Column, record: &Record) -> f64 {
        let is_path = self.prepared.facts.task == Task::Path;
        match column.name {
            // Small beside 1, and made by rounding.
            _ if column.origin == Origin::Residual => 1e-3,
            // Equal pressures deviate, and closed gaps gape, by rounding.
            "pressure_deviation_in_contact" => record.number("max_pressure"),
            "mean_gap" | "lower_mean_gap" => self.height(),
            // A path goes through zero.
            _ if is_path && self.is_law_on_patch() => match column.unit {
                "stress" => self.prepared.unit_pressure(),
                "length" => self.height(),
                "stress*length" => self.prepared.unit_pressure() * self.height(),
                _ => 1.0,
            },
            // Repulsion and attraction cancel at the load zero.
            "mean_pressure" | "p_star" | "force" | "kappa" | "kappa_corrected" if self.prepared.adhesion.is_some() => {
                let [most, mean] = ["max_pressure", "mean_pressure"].map(|name| record.number(name));
                let scale = (record.number(column.name) * most / mean).abs();
                if scale.is_finite() { scale } else { most }
            }
            _ => 0.0,
        }
    }
}
