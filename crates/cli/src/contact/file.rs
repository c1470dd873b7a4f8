//! The HDF5 file of a contact.

use std::borrow::Cow;
use std::path::PathBuf;

use gfmd_contact::Fields;
use gfmd_files::{Archive, Dimension, Output, Provenance, Variable, axes};
use gfmd_measure::Column;

use ndarray::{CowArray, Ix2};

use crate::convergence::NotConverged;
use crate::failure::Failure;
use crate::load::{LoadRecord, columns};
use crate::source::Surface;

/// The file of a contact: the surface is written at once, the fields load by load, the scalars at the end.
pub struct ContactFile<'a> {
    archive: Archive<'a>,
    with_law: bool,
}

const FIELDS: [(&str, &str, &str); 3] = [
    ("/fields/pressure", "stress", "pressure on the elastic surface, compression positive; attraction is negative"),
    ("/fields/displacement_z", "length", "normal displacement of the elastic surface, negative downwards"),
    ("/fields/gap", "length", "distance between the surfaces"),
];

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
        with_law: bool,
    ) -> Result<Self, Failure> {
        let mut archive = Archive::create(output, provenance)?;
        let load = Dimension::index("load", loads, "load step");
        let unit = surface.unit();
        let [x, y] = axes(&surface.grid, unit);
        surface.write(&mut archive, [&x, &y])?;
        for (path, units, long_name) in FIELDS {
            let units = if units == "length" { unit } else { units };
            archive.define(path, &Variable { dimensions: &[&load, &x, &y], units, long_name })?;
        }
        Ok(Self { archive, with_law })
    }

    /// Writes the fields of one state.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&mut self, index: usize, state: &impl Fields) -> Result<(), Failure> {
        self.write_fields(index, Self::fields(state))
    }

    /// The fields of a state, in the order of the file: pressure, displacement and gap.
    pub fn fields(state: &impl Fields) -> [CowArray<'_, f64, Ix2>; 3] {
        [state.pressure(), state.displacement_z().into(), state.gap().into()]
    }

    /// As [`write`](Self::write), from the values of the fields row by row.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_values(&mut self, index: usize, fields: &[Cow<[f64]>]) -> Result<(), Failure> {
        for ((path, ..), field) in FIELDS.iter().zip(fields) {
            self.archive.write_slab(path, index, field)?;
        }
        Ok(())
    }

    /// Writes pressure, displacement and gap of one load.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_fields(&mut self, index: usize, fields: [CowArray<'_, f64, Ix2>; 3]) -> Result<(), Failure> {
        for ((path, ..), field) in FIELDS.iter().zip(fields) {
            self.archive.write_slab(path, index, field.as_standard_layout().as_slice().unwrap_or_default())?;
        }
        Ok(())
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
        for Column { name, units, long_name, value } in columns(self.with_law) {
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
