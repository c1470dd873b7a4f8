//! The HDF5 file of a path.

use std::borrow::Cow;
use std::path::PathBuf;

use gfmd_files::{Archive, Dimension, Output, Variable, axes, contiguous};
use gfmd_problem::{Facts, Rest};
use gfmd_record::{Record, arrays};

use super::{Args, Prepared};
use crate::columns::write_columns;
use crate::convergence::NotConverged;
use crate::failure::Failure;
use crate::hardness;
use crate::session::Session;

/// The file of a path: the fields are written waypoint by waypoint, the scalars at the end.
pub(super) struct PathFile<'a> {
    archive: Archive<'a>,
    facts: Facts,
}

impl<'a> PathFile<'a> {
    pub(super) fn create(
        output: &'a Output,
        prepared: &Prepared,
        args: &Args,
        session: &Session,
    ) -> Result<Self, Failure> {
        let mut archive = Archive::create(output, &session.provenance(args.config()?))?;
        let unit = prepared.surface.unit();
        let [x, y] = axes(&prepared.surface.grid, unit);
        prepared.surface.write(&mut archive, [&x, &y])?;
        let steps = args.steps as usize;
        let waypoint = Dimension::index("waypoint", prepared.drives.len().div_ceil(steps), "waypoint of the path");
        let facts = prepared.facts;
        for array in arrays(&facts) {
            let units = if array.unit == "length" { unit } else { array.unit };
            let variable = Variable { dimensions: &[&waypoint, &x, &y], units, long_name: array.meaning(&facts) };
            archive.define(&format!("/fields/{}", array.name), &variable)?;
        }
        hardness::write(prepared.hardness.as_ref(), Some(&mut archive), &prepared.surface.share, [&x, &y])?;
        Ok(Self { archive, facts })
    }

    /// The fields of a state that the file has at a waypoint, in its order.
    pub(super) fn fields(&self, state: &Rest) -> Vec<Cow<'static, [f64]>> {
        let fields = arrays(&self.facts).filter_map(|array| (array.value)(state, &self.facts));
        fields.map(|field| contiguous(&field).into_owned().into()).collect()
    }

    pub(super) fn write(&mut self, waypoint: usize, fields: &[Cow<[f64]>]) -> Result<(), Failure> {
        for (array, field) in arrays(&self.facts).zip(fields) {
            self.archive.write_slab(&format!("/fields/{}", array.name), waypoint, field)?;
        }
        Ok(())
    }

    pub(super) fn finish(
        mut self,
        steps: &[Record],
        count: usize,
        not_converged: Option<&NotConverged>,
    ) -> Result<PathBuf, Failure> {
        let step = Dimension::index("step", count, "step of the path");
        write_columns(&mut self.archive, ("/path", &step, ["step", "steps"]), &self.facts, steps, count)?;
        not_converged.map_or(Ok(()), |unmet| unmet.write(&mut self.archive))?;
        Ok(self.archive.finish()?)
    }
}
