//! Comparison of a file with the states that follow from its fields.

use gfmd_contact::{Boundary, Drive, Fields as _, Load};
use gfmd_files::Reader;
use gfmd_interface::{Quasistatic as _, Step};
use gfmd_problem::{AnyState, GridError, Posed, Sequence};
use gfmd_record::{Column, Origin, Record, StateContext, arrays, repulsion};
use ndarray::{Array2, ArrayRef2, CowArray, Ix2};

use crate::result::{Comparison, RESIDUAL_OF_A_PATCH};
use gfmd_input::failure::Failure;
use gfmd_run::series::{Chosen, Prepared, SeriesLayout, StiffnessArgs};

/// Allowed relative difference of the numbers of a law on a patch, divided by the solve tolerance.
pub(crate) const OF_A_PATCH: f64 = 100.0;

/// File of a series, with its contact.
pub struct Stored<'a> {
    /// File.
    pub reader: &'a Reader,
    /// Input given by its configuration and its arrays.
    pub prepared: &'a Prepared,
    /// Contact posed with this input.
    pub contact: &'a Posed,
    /// Tolerance of its states.
    pub tolerance: f64,
    /// Columns of the file, part by part.
    records: Vec<Record>,
}

impl<'a> Stored<'a> {
    /// Reads the columns of a file.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, or is of another problem.
    pub fn new(
        reader: &'a Reader,
        prepared: &'a Prepared,
        contact: &'a Posed,
        tolerance: f64,
    ) -> Result<Self, Failure> {
        let records = crate::stored::records_of(reader, &prepared.facts)?;
        Ok(Self { reader, prepared, contact, tolerance, records })
    }

    /// Returns the number of parts.
    pub fn count(&self) -> usize {
        self.records.len()
    }

    /// Returns a number of a part; NaN without one.
    pub fn number(&self, name: &str, index: usize) -> f64 {
        self.records.get(index).map_or(f64::NAN, |record| record.number(name))
    }

    /// Returns the path of a column.
    pub fn path(&self, name: &str) -> String {
        format!("{}/{name}", SeriesLayout::of(&self.prepared.facts).group)
    }

    /// Returns the unit of length, the rms height.
    pub fn height(&self) -> f64 {
        self.prepared.surface.statistics.moments.rms_height().max(f64::MIN_POSITIVE)
    }

    /// Returns true if a law acts on a patch. The file lacks the displacement outside the patch, so recomputed states
    /// are only as exact as their search.
    pub(crate) fn is_law_on_patch(&self) -> bool {
        self.prepared.facts.solves_a_law() && self.prepared.facts.boundary == Boundary::Free
    }

    /// Returns the largest allowed residual of a recomputed state that had converged.
    pub fn allowed(&self) -> f64 {
        self.tolerance * if self.is_law_on_patch() { RESIDUAL_OF_A_PATCH } else { 1.0 }
    }

    /// Reads a field at a place of the file.
    ///
    /// # Errors
    /// Returns an error if the file does not have the field in this shape.
    pub fn field(&self, name: &str, place: usize) -> Result<Array2<f64>, Failure> {
        let values = self.reader.slab(&format!("/fields/{name}"), place)?;
        let made = Array2::from_shape_vec(self.prepared.surface.grid.points(), values);
        made.map_err(|error| Failure::input("/fields", error))
    }

    /// Computes the state of the contact from the fields at a place; `None` for an unsolved part, which has NaN fields.
    ///
    /// # Errors
    /// Returns an error if fields cannot be read, or do not make a state.
    pub fn state(&self, place: usize, drive: Drive) -> Result<Option<AnyState>, Failure> {
        let fields = self.contact.basis().iter().map(|name| match *name {
            // Without a hardness there is no plastic depth.
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

    /// Compares convergence, reduced load, and load or approach of a path step with its drive. Returns true if the step
    /// converged and the rest of it can be compared.
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
                comparison.number(&self.path("approach"), number("approach"), asked, 0.0);
            }
        }
        true
    }

    /// Compares the numbers and fields of a step at a waypoint with the state computed from the fields. `record` makes
    /// the record of the state, given its numbers so far.
    ///
    /// # Errors
    /// Fails like [`state`](Self::state); also if the record cannot be made.
    pub fn compare_waypoint(
        &self,
        (index, place): (usize, usize),
        drive: Drive,
        stiffness: StiffnessArgs,
        record: impl FnOnce(&AnyState, StateContext<'_>) -> Result<Record, Failure>,
        comparison: &mut Comparison,
    ) -> Result<(), Failure> {
        let Some(state) = self.state(place, drive)? else { return Ok(()) };
        self.compare_fields(place, &state, comparison)?;
        let (reading, step) = (self.contact.reading(&state), Step::default());
        let stiffness = stiffness.of(self.contact, &state, |_| {});
        let at = self.at(index, &state);
        let at = StateContext { approach: reading.approach, step: Some((&step, reading)), stiffness, ..at };
        self.compare_record(index, (&record(&state, at)?, &state), comparison);
        Ok(())
    }

    /// Returns repulsive pressure and gap at a place, as stored: a number that rounding moves to another bin would be a
    /// difference. Fields that are not in the file are taken from the `state`, if it is known.
    ///
    /// # Errors
    /// Returns an error if a field cannot be read.
    pub fn contact_and_gap<'s>(
        &self,
        place: usize,
        state: Option<&'s AnyState>,
    ) -> Result<[CowArray<'s, f64, Ix2>; 2], Failure> {
        let field = |name: &str, made: Option<CowArray<'s, f64, Ix2>>| match made {
            Some(made) if !self.reader.contains(&format!("/fields/{name}")) => Ok(made),
            _ => self.field(name, place).map(Into::into),
        };
        let repulsion = field(repulsion(&self.prepared.facts), state.map(|state| state.repulsion()))?;
        Ok([repulsion, field("gap", state.map(|state| state.gap().into()))?])
    }

    /// Compares the fields of a state with the stored fields at a place.
    ///
    /// # Errors
    /// Returns an error if fields cannot be read.
    pub fn compare_fields(&self, place: usize, state: &AnyState, comparison: &mut Comparison) -> Result<(), Failure> {
        let facts = &self.prepared.facts;
        comparison.accurate_to(if self.is_law_on_patch() { OF_A_PATCH * self.tolerance } else { 0.0 });
        for (array, field) in arrays(facts).zip(Chosen::All.fields(facts, state, self.prepared.base.as_ref())) {
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

    /// Returns the least scale of a field. The gap of full contact is only rounding error.
    fn floor_of_field(&self, name: &str) -> f64 {
        let patch = self.is_law_on_patch();
        match name {
            "pressure" if patch => self.prepared.unit_pressure(),
            "displacement_z" if patch => self.height(),
            "gap" | "lower_gap" if self.prepared.facts.sequence == Sequence::Path => self.height(),
            _ => 0.0,
        }
    }

    /// Returns the numbers of a state so far; its residuals may be as large as [allowed](Self::allowed).
    pub fn at<'s>(&'s self, index: usize, state: &'s AnyState) -> StateContext<'s> {
        let allowed = if self.number("converged", index) == 1.0 { self.allowed() } else { self.tolerance };
        self.prepared.at(state, allowed)
    }

    /// Compares the numbers of a part that follow from its fields.
    pub fn compare_record(&self, index: usize, (record, state): (&Record, &AnyState), comparison: &mut Comparison) {
        let patch = self.is_law_on_patch();
        let has_converged = self.number("converged", index) == 1.0;
        comparison.accurate_to(if patch { OF_A_PATCH * self.tolerance } else { 0.0 });
        let of_fields = |origin| matches!(origin, Origin::Fields | Origin::Grid | Origin::Residual);
        // Numbers from a finer grid do not follow from the file.
        let is_refined = self.prepared.facts.grid_error == GridError::Refine;
        let is_told = |column: &Column| of_fields(column.origin) && !(is_refined && column.origin == Origin::Grid);
        for (column, cell) in record.cells().filter(|(column, _)| is_told(column)) {
            let path = self.path(column.name);
            // The layout shows missing columns.
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
            let name = SeriesLayout::of(&self.prepared.facts).name;
            comparison.at_most(&format!("residual of {name} {index}"), state.worst(), self.allowed());
        }
    }

    /// Returns the least scale of a number; smaller differences are rounding errors.
    fn floor(&self, column: &Column, record: &Record) -> f64 {
        let is_path = self.prepared.facts.sequence == Sequence::Path;
        match column.name {
            // Small beside 1, and caused by rounding.
            _ if column.origin == Origin::Residual => 1e-3,
            // Rounding makes equal pressures deviate and closed gaps open.
            "pressure_deviation_in_contact" => record.number("max_pressure"),
            "mean_gap" | "lower_mean_gap" => self.height(),
            // A path goes through zero.
            _ if is_path && self.is_law_on_patch() => match column.unit {
                "stress" => self.prepared.unit_pressure(),
                "length" => self.height(),
                "stress*length" => self.prepared.unit_pressure() * self.height(),
                _ => 1.0,
            },
            // Repulsion and attraction cancel at zero load.
            "mean_pressure" | "p_star" | "force" | "kappa" | "kappa_corrected" if self.prepared.adhesion.is_some() => {
                let [most, mean] = ["max_pressure", "mean_pressure"].map(|name| record.number(name));
                let scale = (record.number(column.name) * most / mean).abs();
                if scale.is_finite() { scale } else { most }
            }
            _ => 0.0,
        }
    }
}
