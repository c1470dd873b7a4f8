//! The HDF5 file of steady sliding.

use std::borrow::Cow;
use std::path::PathBuf;

use gfmd_files::{Archive, Dimension, Output, Provenance, Variable, axes};
use gfmd_input::failure::Failure;
use gfmd_input::hardness;
use gfmd_record::{Record, SLIDING_FIELDS, Sliding, SlidingFacts, SlidingField};
use gfmd_run::columns::write_columns;
use gfmd_run::series::Prepared;
use gfmd_unit::Units;

/// Returns the fields of the states of a problem, in the order of a file.
pub(super) fn fields(facts: SlidingFacts) -> impl Iterator<Item = &'static SlidingField> {
    SLIDING_FIELDS.iter().filter(move |field| (field.present)(&facts))
}

/// A file of states: the surface is written at once, the fields state by state, the scalars at the end.
pub(super) struct StatesFile<'a> {
    archive: Archive<'a>,
    units: Units,
    facts: SlidingFacts,
}

impl<'a> StatesFile<'a> {
    pub(super) fn new(
        output: &'a Output,
        provenance: &Provenance,
        prepared: &Prepared,
        facts: SlidingFacts,
        states: usize,
    ) -> Result<Self, Failure> {
        let mut archive = Archive::create(output, provenance)?;
        let [x, y] = axes(&prepared.surface.grid, prepared.surface.unit());
        prepared.surface.write(&mut archive, [&x, &y])?;
        let units = prepared.surface.units();
        let share = &prepared.surface.share;
        hardness::write(prepared.hardness.as_ref(), Some(&mut archive), share, [&x, &y], &units)?;
        let state = Dimension::index("state", states, "load and velocity");
        for field in fields(facts) {
            let units = &*units.name(field.unit);
            let variable = Variable { dimensions: &[&state, &x, &y], units, long_name: field.meaning };
            archive.define(&format!("/fields/{}", field.name), &variable)?;
        }
        Ok(Self { archive, units, facts })
    }

    /// Writes the fields of a state, in the order of [`fields`].
    pub(super) fn write<'f>(
        &mut self,
        index: usize,
        values: impl IntoIterator<Item = &'f Cow<'f, [f64]>>,
    ) -> Result<(), Failure> {
        for (field, values) in fields(self.facts).zip(values) {
            self.archive.write_slab(&format!("/fields/{}", field.name), index, values)?;
        }
        Ok(())
    }

    /// Writes the scalars of `count` states, NaN after the last one, and gives the file its name.
    pub(super) fn finish(mut self, states: &[Record<Sliding>], count: usize) -> Result<PathBuf, Failure> {
        let dimension = Dimension::index("state", count, "load and velocity");
        let group = ("/states", &dimension, ["state", "states"]);
        write_columns(&mut self.archive, group, (&self.facts, &self.units), states, count)?;
        Ok(self.archive.finish()?)
    }
}
