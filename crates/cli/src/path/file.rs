//! The HDF5 file of a path.

use std::borrow::Cow;
use std::path::PathBuf;

use gfmd_contact::Fields as _;
use gfmd_files::{Archive, Dimension, Output, Variable, axes, contiguous};
use gfmd_problem::Rest;

use super::record::scalars;
use super::{Args, Prepared, StepRecord};
use crate::convergence::NotConverged;
use crate::failure::Failure;
use crate::hardness;
use crate::load::Undefined;
use crate::session::Session;

/// The file of a path: the fields are written waypoint by waypoint, the scalars at the end.
pub(super) struct PathFile<'a> {
    archive: Archive<'a>,
    shears: &'static [&'static str],
    is_plastic: bool,
    has_friction: bool,
    /// True without attraction, where the pressure is that of the wall: exactly zero where nothing touches.
    is_wall: bool,
}

/// The fields that every state has.
const NORMAL: [&str; 3] = ["pressure", "gap", "displacement_z"];

/// The plastic depth, beside the pressure.
const PLASTIC_DEPTH: &str = "plastic_depth";

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
        let shears: &[&str] = match (prepared.facts.moves_sideways(), prepared.surface.grid.is_line()) {
            (false, _) => &[],
            (true, true) => &["shear_x"],
            (true, false) => &["shear_x", "shear_y"],
        };
        let fields = [
            ("pressure", "stress", "pressure on the elastic surface, compression positive; attraction is negative"),
            ("gap", unit, "distance between the surfaces"),
            ("displacement_z", unit, "normal displacement of the elastic surface, negative downwards"),
            ("shear_x", "stress", "shear traction on the elastic surface along x"),
            ("shear_y", "stress", "shear traction on the elastic surface along y"),
        ];
        let is_plastic = prepared.facts.hardness;
        let depth = (PLASTIC_DEPTH, unit, "depth by which the surfaces were pressed into each other so far");
        let fields = fields.into_iter().take(NORMAL.len() + shears.len()).chain(is_plastic.then_some(depth));
        for (name, units, long_name) in fields {
            archive
                .define(&format!("/fields/{name}"), &Variable { dimensions: &[&waypoint, &x, &y], units, long_name })?;
        }
        hardness::write(prepared.hardness.as_ref(), Some(&mut archive), &prepared.surface.share, [&x, &y])?;
        let has_friction = prepared.facts.friction.is_some();
        Ok(Self { archive, shears, is_plastic, has_friction, is_wall: !prepared.facts.has_law() })
    }

    /// The fields of a state that the file has at a waypoint, in its order.
    pub(super) fn fields(&self, state: &Rest) -> Vec<Cow<'static, [f64]>> {
        let shears = state.traction().into_iter().flat_map(|traction| traction.outer_iter().take(self.shears.len()));
        let normal = [
            contiguous(&if self.is_wall { state.repulsion() } else { state.pressure() }).into_owned(),
            contiguous(&state.gap()).into_owned(),
            contiguous(&state.displacement_z()).into_owned(),
        ];
        let depth = state.plastic_depth().map(|depth| contiguous(depth).into_owned());
        let shears = shears.map(|shear| contiguous(&shear).into_owned());
        normal.into_iter().chain(shears).chain(depth).map(Into::into).collect()
    }

    pub(super) fn write(&mut self, waypoint: usize, fields: &[Cow<[f64]>]) -> Result<(), Failure> {
        let depth = self.is_plastic.then_some(&PLASTIC_DEPTH);
        for (name, field) in NORMAL.iter().chain(self.shears).chain(depth).zip(fields) {
            self.archive.write_slab(&format!("/fields/{name}"), waypoint, field)?;
        }
        Ok(())
    }

    pub(super) fn finish(
        mut self,
        steps: &[StepRecord],
        count: usize,
        not_converged: Option<&NotConverged>,
    ) -> Result<PathBuf, Failure> {
        let step = Dimension::index("step", count, "step of the path");
        for scalar in scalars(self.is_plastic, self.has_friction) {
            let values: Vec<f64> = (0..count).map(|i| steps.get(i).map_or(f64::NAN, scalar.value)).collect();
            let variable = Variable { dimensions: &[&step], units: scalar.units, long_name: scalar.long_name };
            let path = format!("/path/{}", scalar.name);
            self.archive.write(&path, &variable, &values)?;
            let reasons = steps.iter().map(|step| &step.undefined);
            if let Some(reason) = Undefined::of_rows(reasons, scalar.name, ["step", "steps"]) {
                self.archive.attribute(&path, "undefined", &*reason)?;
            }
        }
        not_converged.map_or(Ok(()), |unmet| unmet.write(&mut self.archive))?;
        Ok(self.archive.finish()?)
    }
}
