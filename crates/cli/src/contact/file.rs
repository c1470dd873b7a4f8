//! The HDF5 file of a contact.

use std::borrow::Cow;
use std::path::PathBuf;

use gfmd_files::{Archive, Dimension, Output, Provenance, Variable, axes};
use gfmd_measure::Column;

use ndarray::{CowArray, Ix2};

use super::statistics::{self, Measured};
use crate::convergence::NotConverged;
use crate::failure::Failure;
use crate::load::{LoadRecord, Recorded, Recording, columns};
use crate::source::Surface;

/// The file of a contact: the surface is written at once, the fields load by load, the scalars at the end.
pub struct ContactFile<'a> {
    archive: Archive<'a>,
    recording: Recording,
}

const FIELDS: [(&str, &str, &str); 3] = [
    ("/fields/pressure", "stress", "pressure on the elastic surface, compression positive; attraction is negative"),
    ("/fields/displacement_z", "length", "normal displacement of the elastic surface, negative downwards"),
    ("/fields/gap", "length", "distance between the surfaces"),
];

/// With a hardness.
const PLASTIC_DEPTH: (&str, &str, &str) =
    ("/fields/plastic_depth", "length", "depth by which the surfaces are pressed into each other beyond touching");

/// The names of the fields, in the order of [`ContactFile::fields`].
fn paths() -> impl Iterator<Item = &'static str> {
    FIELDS.into_iter().chain([PLASTIC_DEPTH]).map(|(path, ..)| path)
}

impl<'a> ContactFile<'a> {
    /// A file for `loads` loads of a surface.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn create(
        output: &'a Output,
        provenance: &Provenance,
        surface: &Surface,
        loads: usize,
        recording: Recording,
    ) -> Result<Self, Failure> {
        let mut archive = Archive::create(output, provenance)?;
        let load = Dimension::index("load", loads, "load step");
        let unit = surface.unit();
        let [x, y] = axes(&surface.grid, unit);
        surface.write(&mut archive, [&x, &y])?;
        for (path, units, long_name) in FIELDS.into_iter().chain(recording.is_plastic.then_some(PLASTIC_DEPTH)) {
            let units = if units == "length" { unit } else { units };
            archive.define(path, &Variable { dimensions: &[&load, &x, &y], units, long_name })?;
        }
        Ok(Self { archive, recording })
    }

    /// Writes the fields of one state.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&mut self, index: usize, state: &impl Recorded) -> Result<(), Failure> {
        self.write_fields(index, Self::fields(state))
    }

    /// The fields of a state, in the order of the file: pressure, displacement and gap, with a hardness also plastic depth.
    pub fn fields(state: &impl Recorded) -> Vec<CowArray<'_, f64, Ix2>> {
        let mut fields = vec![state.pressure(), state.displacement_z().into(), state.gap().into()];
        fields.extend(state.plastic().map(|plastic| plastic.depth.view().into()));
        fields
    }

    /// As [`write`](Self::write), from the values of the fields row by row.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_values(&mut self, index: usize, fields: &[Cow<[f64]>]) -> Result<(), Failure> {
        for (path, field) in paths().zip(fields) {
            self.archive.write_slab(path, index, field)?;
        }
        Ok(())
    }

    /// Writes the fields of one load, in the order of [`fields`](Self::fields).
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_fields<'b>(
        &mut self,
        index: usize,
        fields: impl IntoIterator<Item = CowArray<'b, f64, Ix2>>,
    ) -> Result<(), Failure> {
        for (path, field) in paths().zip(fields) {
            self.archive.write_slab(path, index, field.as_standard_layout().as_slice().unwrap_or_default())?;
        }
        Ok(())
    }

    /// Writes patches, distributions and spectra of the loads.
    pub(super) fn write_statistics(&mut self, surface: &Surface, loads: &[Measured]) -> Result<(), Failure> {
        statistics::write(&mut self.archive, surface, loads)
    }

    /// Writes the scalars of `count` loads, NaN beyond those there are, and gives the file its name.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(
        mut self,
        loads: &[LoadRecord],
        count: usize,
        not_converged: Option<&NotConverged>,
    ) -> Result<PathBuf, Failure> {
        let load = Dimension::index("load", count, "load step");
        for Column { name, units, long_name, value } in columns(self.recording) {
            let values: Vec<f64> = (0..count).map(|i| loads.get(i).map_or(f64::NAN, value)).collect();
            self.archive.write(
                &format!("/loads/{name}"),
                &Variable { dimensions: &[&load], units, long_name },
                &values,
            )?;
        }
        not_converged.map_or(Ok(()), |unmet| unmet.write(&mut self.archive))?;
        Ok(self.archive.finish()?)
    }
}
