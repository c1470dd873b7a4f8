//! The HDF5 file of a contact.

use std::path::PathBuf;

use gfmd_contact::Fields;
use gfmd_files::{Archive, Dimension, Output, Variable, axes};
use gfmd_law::Kind;
use gfmd_measure::Column;

use super::{Args, Prepared};
use crate::failure::Failure;
use crate::load::{LoadRecord, columns};
use crate::session::Session;

/// The file of a contact: the surface is written at once, the fields load by load, the scalars at the end.
pub(super) struct ContactFile<'a> {
    archive: Archive<'a>,
    with_law: bool,
}

const FIELDS: [(&str, &str, &str); 3] = [
    ("/fields/pressure", "stress", "pressure on the elastic surface, compression positive; attraction is negative"),
    ("/fields/displacement_z", "length", "normal displacement of the elastic surface, negative downwards"),
    ("/fields/gap", "length", "distance between the surfaces"),
];

impl<'a> ContactFile<'a> {
    pub(super) fn create(
        output: &'a Output,
        prepared: &Prepared,
        args: &Args,
        session: &Session,
    ) -> Result<Self, Failure> {
        let resolved = Args { source: args.source.resolved()?, ..args.clone() };
        let config = toml::to_string(&resolved).map_err(|error| Failure::Computation(error.to_string()))?;
        let mut archive = Archive::create(output, &session.provenance(config))?;
        let load = Dimension::index("load", prepared.controls.len(), "load step");
        let unit = prepared.surface.unit();
        let [x, y] = axes(&prepared.surface.grid, unit);
        prepared.surface.write(&mut archive, [&x, &y])?;
        for (path, units, long_name) in FIELDS {
            let units = if units == "length" { unit } else { units };
            archive.define(path, &Variable { dimensions: &[&load, &x, &y], units, long_name })?;
        }
        Ok(Self { archive, with_law: args.law.law != Kind::HardWall })
    }

    pub(super) fn write(&mut self, index: usize, state: &impl Fields) -> Result<(), Failure> {
        let fields = [state.pressure(), state.displacement_z().into(), state.gap().into()];
        for ((path, ..), field) in FIELDS.iter().zip(fields) {
            self.archive.write_slab(path, index, field.as_standard_layout().as_slice().unwrap_or_default())?;
        }
        Ok(())
    }

    pub(super) fn finish(mut self, loads: &[LoadRecord], count: usize) -> Result<PathBuf, Failure> {
        let load = Dimension::index("load", count, "load step");
        for Column { name, units, long_name, value } in columns(self.with_law) {
            let values: Vec<f64> = (0..count).map(|i| loads.get(i).map_or(f64::NAN, value)).collect();
            self.archive.write(
                &format!("/loads/{name}"),
                &Variable { dimensions: &[&load], units, long_name },
                &values,
            )?;
        }
        Ok(self.archive.finish()?)
    }
}
