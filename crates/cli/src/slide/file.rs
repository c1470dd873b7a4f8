//! The HDF5 file of steady sliding.

use std::borrow::Cow;
use std::path::PathBuf;

use gfmd_files::{Archive, Dimension, Output, Provenance, Variable, axes};
use gfmd_run::failure::Failure;
use gfmd_run::series::Prepared;
use gfmd_unit::Units;

use super::heat::{Heat, Source};
use super::report::State;

/// The name of a scalar, its unit, its definition, and its value.
type Scalar<T> = (&'static str, &'static str, &'static str, fn(&T) -> f64);

/// The scalars of a state.
pub(super) const SCALARS: &[Scalar<State>] = &[
    ("velocity", "length/time", "velocity of the rigid surface relative to the body", |s| s.velocity),
    ("mean_pressure", "stress", "mean pressure over the whole surface", |s| s.mean_pressure),
    ("p_star", "1", "reduced pressure p/(E* g)", |s| s.p_star),
    ("displacement", "length", "rigid approach beyond first touch", |s| s.displacement),
    ("area_fraction", "1", "points with pressure over all points", |s| s.area_fraction),
    ("mean_gap", "length", "mean distance between the surfaces", |s| s.mean_gap),
    ("max_pressure", "stress", "largest pressure", |s| s.max_pressure),
    ("friction", "1", "coefficient of friction, by the power lost in the body", |s| s.friction),
    ("friction_slope", "1", "coefficient of friction, by the pressure on the slopes", |s| s.friction_slope),
    ("dissipated_power", "stress*length/time", "power lost in the body, per area", |s| s.dissipated_power),
    ("persson_friction", "1", "coefficient of friction by Persson's theory", |s| s.persson.friction),
    ("persson_area_fraction", "1", "contact area by Persson's theory", |s| s.persson.area_fraction),
    ("iterations", "1", "iterations of the search", |s| s.iterations as f64),
    ("transform_pairs", "1", "pairs of transforms of the search", |s| s.transform_pairs),
    ("converged", "1", "1 if the residual is at most the tolerance", |s| f64::from(u8::from(s.converged))),
    ("residual", "1", "largest residual, recomputed from the pressure", |s| s.worst()),
    ("seconds", "s", "wall time", |s| s.seconds),
];

/// The scalars of the flash temperature, `/states/heat_...`.
pub(super) const OF_HEAT: &[Scalar<Heat>] = &[
    ("heat_mean_flux", "stress*length/time", "mean heat of friction, per area and time", |heat| heat.mean_flux),
    ("heat_fraction", "1", "part of the heat that flows into the body", |heat| heat.fraction),
    ("heat_max_rise", "temperature", "largest temperature in contact, above the mean of the surface", |h| h.max_rise),
    ("heat_mean_rise", "temperature", "mean temperature in contact, above the mean of the surface", |h| h.mean_rise),
    (
        "heat_residual",
        "1",
        "largest difference between the temperatures of both bodies over the largest rise",
        |heat| heat.residual,
    ),
];

/// The name of a field of a state, its unit and its definition.
type Field = (&'static str, &'static str, &'static str);

/// The fields of a state, with their units and definitions.
const FIELDS: [Field; 3] = [
    ("pressure", "stress", "pressure on the surface of the body"),
    ("displacement_z", "length", "normal displacement of the surface of the body, negative downwards"),
    ("gap", "length", "distance between the surfaces"),
];

const TEMPERATURE: Field = ("temperature", "temperature", "temperature of the body's surface, above its mean");
const HEAT_FLUX: Field = ("heat_flux", "stress*length/time", "heat that flows into the body, per area and time");

/// The fields of a state with this heat, in the order of a file.
pub(super) fn fields(heat: Option<&Source>) -> Vec<Field> {
    let shared = heat.filter(|heat| heat.is_shared()).map(|_| HEAT_FLUX);
    FIELDS.into_iter().chain(heat.map(|_| TEMPERATURE)).chain(shared).collect()
}

/// A file of states: the surface is written at once, the fields state by state, the scalars at the end.
pub(super) struct StatesFile<'a> {
    archive: Archive<'a>,
    units: Units,
    fields: Vec<Field>,
}

impl<'a> StatesFile<'a> {
    pub(super) fn new(
        output: &'a Output,
        provenance: &Provenance,
        prepared: &Prepared,
        heat: Option<&Source>,
        states: usize,
    ) -> Result<Self, Failure> {
        let mut archive = Archive::create(output, provenance)?;
        let [x, y] = axes(&prepared.surface.grid, prepared.surface.unit());
        prepared.surface.write(&mut archive, [&x, &y])?;
        let state = Dimension::index("state", states, "load and velocity");
        let (units, fields) = (prepared.surface.units(), fields(heat));
        for (name, kind, long_name) in &fields {
            let units = &*units.name(kind);
            archive
                .define(&format!("/fields/{name}"), &Variable { dimensions: &[&state, &x, &y], units, long_name })?;
        }
        Ok(Self { archive, units, fields })
    }

    /// Writes the fields of a state, in the order of [`fields`].
    pub(super) fn write<'f>(
        &mut self,
        index: usize,
        fields: impl IntoIterator<Item = &'f Cow<'f, [f64]>>,
    ) -> Result<(), Failure> {
        for ((name, ..), values) in self.fields.iter().zip(fields) {
            self.archive.write_slab(&format!("/fields/{name}"), index, values)?;
        }
        Ok(())
    }

    /// Writes the scalars of `count` states, NaN beyond those there are, and gives the file its name.
    pub(super) fn finish(mut self, states: &[State], count: usize) -> Result<PathBuf, Failure> {
        let dimension = Dimension::index("state", count, "load and velocity");
        let has_heat = self.fields.contains(&TEMPERATURE);
        let of_heat = OF_HEAT.iter().filter(|_| has_heat).map(|(name, kind, long_name, value)| {
            let value = |state: &State| state.heat.as_ref().map_or(f64::NAN, value);
            (name, kind, long_name, states.iter().map(value).collect::<Vec<f64>>())
        });
        let all = SCALARS.iter().map(|(name, kind, long_name, value)| {
            (name, kind, long_name, states.iter().map(value).collect::<Vec<f64>>())
        });
        for (name, kind, long_name, mut values) in all.chain(of_heat) {
            values.resize(count, f64::NAN);
            let variable = Variable { dimensions: &[&dimension], units: &self.units.name(kind), long_name };
            self.archive.write(&format!("/states/{name}"), &variable, &values)?;
        }
        Ok(self.archive.finish()?)
    }
}

#[cfg(test)]
#[path = "../../../record/tests/suite/classes.rs"]
mod classes;

#[cfg(test)]
mod tests {
    use super::classes::{Property, class, compare, quantity};
    use super::{FIELDS, HEAT_FLUX, OF_HEAT, SCALARS, TEMPERATURE};

    const HEAD: &str = r#""""The numbers and fields of states that slide steadily, with their units and definitions.

Made from crates/cli/src/slide/file.rs by `GFMD_DOCS=write cargo test -p gfmd-cli --lib`.
"""

# mypy: no-warn-return-any

from __future__ import annotations

from typing import Any

import numpy.typing as npt

from ._check import Array
from ._record import Record
"#;

    #[test]
    fn the_classes_of_python_have_the_scalars_and_fields() {
        let number = |name: &str, unit: &str, meaning: &str, only: &str| {
            let of = if ["iterations", "converged"].contains(&name) { "npt.NDArray[Any]" } else { "Array" };
            Property::of_record(
                name.to_owned(),
                of,
                format!("{} [state]: {}{only}.", quantity(unit), meaning.replace("1 if", "true if")),
            )
        };
        // Python has the residuals one by one.
        let all = SCALARS.iter().filter(|(name, ..)| *name != "residual");
        let all = all.map(|(name, unit, meaning, _)| number(name, unit, meaning, ""));
        let heat = OF_HEAT.iter().map(|(name, unit, meaning, _)| number(name, unit, meaning, ". With `heat` only"));
        let field = |(name, unit, meaning): &super::Field, only: &str| {
            let text = format!("{} [state, x, y]: {meaning}{only}. Read-only.", quantity(unit));
            Property::of_record((*name).to_owned(), "Array", text)
        };
        let warm = [field(&TEMPERATURE, ". With `heat` only"), field(&HEAT_FLUX, ". With `heat` of both bodies only")];
        let fields: Vec<Property> = FIELDS.iter().map(|of| field(of, "")).chain(warm).collect();
        let numbers: Vec<Property> = all.chain(heat).collect();
        let (numbers, fields) = (
            class("States", "(Record)", "The numbers of states that slide steadily.", &numbers),
            class("StateFields", "(Record)", "The fields of states that slide steadily.", &fields),
        );
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../python/python/gfmd/_states.py");
        compare(file, &format!("{HEAD}{numbers}{fields}"));
    }
}
