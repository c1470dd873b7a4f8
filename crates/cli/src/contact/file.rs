//! The HDF5 file of a contact.

use std::borrow::Cow;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use gfmd_contact::{Fields as _, Hardness};
use gfmd_field::Share;
use gfmd_files::{Archive, Dimension, Output, Provenance, Variable, axes, contiguous};
use gfmd_measure::Column;
use gfmd_problem::Rest;

use ndarray::{Array2, CowArray, Ix2};
use serde::{Serialize, Serializer};

use super::statistics::{self, Measured};
use super::threshold::{self, Threshold};
use crate::base::MovedBase;
use crate::convergence::NotConverged;
use crate::failure::Failure;
use crate::hardness;
use crate::load::{LoadRecord, Recording, Undefined, columns};
use crate::lower;
use crate::rows;
use crate::source::Surface;
use crate::trace::Trace;

/// The file of a contact: the surface is written at once, the fields load by load, the scalars at the end. Of several processes the
/// first one writes it; all make the same calls, and give their rows of the fields.
pub struct ContactFile<'a> {
    /// The file of the process that writes.
    archive: Option<Archive<'a>>,
    share: Share,
    recording: Recording,
    chosen: Chosen,
}

/// The fields of a load: path, units, meaning.
const FIELDS: [(&str, &str, &str); 10] = [
    ("/fields/pressure", "stress", "pressure on the elastic surface, compression positive; attraction is negative"),
    ("/fields/displacement_z", "length", "normal displacement of the elastic surface, negative downwards"),
    ("/fields/gap", "length", "distance between the surfaces"),
    ("/fields/plastic_depth", "length", "depth by which the surfaces are pressed into each other beyond touching"),
    ("/fields/displacement_x", "length", "displacement of the elastic surface along x"),
    ("/fields/displacement_y", "length", "displacement of the elastic surface along y"),
    ("/fields/lower_pressure", "stress", "pressure on the lower face of the slab"),
    ("/fields/lower_displacement_z", "length", "normal displacement of the lower face of the slab, positive upwards"),
    ("/fields/lower_gap", "length", "distance between the lower face of the slab and the lower surface"),
    ("/fields/repulsion", "stress", "repulsive pressure, without attraction; positive at the points in contact"),
];

/// The number of fields.
const COUNT: usize = FIELDS.len();

/// The fields of each load that go into a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chosen([bool; COUNT]);

/// Words that name no fields.
#[derive(Clone, Debug, thiserror::Error)]
#[error("it must be none, or some of {}, with commas between them", names().collect::<Vec<_>>().join(", "))]
pub struct ChosenError;

/// The names of the fields.
fn names() -> impl Iterator<Item = &'static str> {
    FIELDS.into_iter().map(|(path, ..)| path.trim_start_matches("/fields/"))
}

impl Recording {
    /// The fields that the loads have.
    fn fields(self) -> [bool; COUNT] {
        let Self { is_plastic, lateral, is_squeezed, .. } = self;
        let attracts = self.keeps_repulsion();
        [true, true, true, is_plastic, lateral > 0, lateral > 1, is_squeezed, is_squeezed, is_squeezed, attracts]
    }

    /// The name of the field whose positive values are those of the points in contact.
    pub(super) fn repulsion(self) -> &'static str {
        if self.keeps_repulsion() { "repulsion" } else { "pressure" }
    }
}

impl Chosen {
    /// All fields.
    pub const ALL: Self = Self([true; COUNT]);

    /// The first of the fields named that the loads do not have.
    pub(super) fn missing(&self, recording: Recording) -> Option<&'static str> {
        let named = self.0.map(|chosen| chosen && *self != Self::ALL);
        let mut fields = names().zip(named.into_iter().zip(recording.fields()));
        fields.find(|(_, (named, has))| *named && !has).map(|(name, _)| name)
    }

    /// The places among the chosen fields of those by which contact and gap are told apart, if both are chosen.
    pub(super) fn contact_and_gap(&self, recording: Recording) -> Option<[usize; 2]> {
        let place = |wanted: &str| {
            written(recording, self).position(|(path, ..)| path.trim_start_matches("/fields/") == wanted)
        };
        Some([place(recording.repulsion())?, place("gap")?])
    }

    /// The chosen ones of the items, one for each field.
    fn of<T>(&self, items: impl IntoIterator<Item = T>) -> impl Iterator<Item = T> {
        items.into_iter().zip(self.0).filter(|(_, chosen)| *chosen).map(|(item, _)| item)
    }

    /// The chosen ones of the fields that a state has, in the order of the file.
    pub(super) fn fields<'s>(
        &self,
        recording: Recording,
        state: &'s Rest,
        lift: Option<&Array2<f64>>,
    ) -> Vec<CowArray<'s, f64, Ix2>> {
        let displacement = match lift {
            Some(lift) => (&state.displacement_z() + lift).into(),
            None => state.displacement_z().into(),
        };
        let [x, y] = [0, 1].map(|axis| state.lateral().get(axis).map(|field| field.view().into()));
        let depth = state.plastic_depth().map(|depth| depth.view().into());
        let normal = [Some(state.pressure()), Some(displacement), Some(state.gap().into()), depth, x, y];
        let lower = match state.lower() {
            Some(lower) => {
                [lower.pressure.view().into(), (-&lower.displacement).into(), lower.gap.view().into()].map(Some)
            }
            None => [const { None }; 3],
        };
        let repulsion = recording.keeps_repulsion().then(|| state.repulsion());
        self.of(normal.into_iter().chain(lower).chain([repulsion])).flatten().collect()
    }
}

impl FromStr for Chosen {
    type Err = ChosenError;

    fn from_str(text: &str) -> Result<Self, ChosenError> {
        let mut chosen = [false; COUNT];
        if text == "none" {
            return Ok(Self(chosen));
        }
        for word in text.split(',') {
            chosen[names().position(|name| name == word).ok_or(ChosenError)?] = true;
        }
        Ok(Self(chosen))
    }
}

impl fmt::Display for Chosen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.of(names()).collect();
        f.write_str(&if names.is_empty() { "none".into() } else { names.join(",") })
    }
}

impl Serialize for Chosen {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// The fields that the loads have and that are chosen.
fn written(recording: Recording, chosen: &Chosen) -> impl Iterator<Item = (&'static str, &'static str, &'static str)> {
    chosen.of(FIELDS.into_iter().zip(recording.fields())).filter(|(_, has)| *has).map(|(field, _)| field)
}

/// A field of a state, named as in a file.
pub(super) struct Field<'s> {
    pub(super) name: &'static str,
    pub(super) units: &'static str,
    pub(super) values: CowArray<'s, f64, Ix2>,
}

/// All fields of a state; a base that moves adds `lift` to the displacement.
pub(super) fn fields<'s>(recording: Recording, state: &'s Rest, lift: Option<&Array2<f64>>) -> Vec<Field<'s>> {
    let all = written(recording, &Chosen::ALL).zip(Chosen::ALL.fields(recording, state, lift));
    let named =
        all.map(|((path, units, _), values)| Field { name: path.trim_start_matches("/fields/"), units, values });
    named.collect()
}

impl<'a> ContactFile<'a> {
    /// A file for `loads` loads of a surface; processes without an `output` only send their rows.
    ///
    /// # Errors
    /// A file that cannot be written, at the process that writes.
    pub fn create(
        output: Option<&'a Output>,
        provenance: &Provenance,
        surface: &Surface,
        loads: usize,
        recording: Recording,
        chosen: Chosen,
    ) -> Result<Self, Failure> {
        let (mut archive, failed) = match output.map(|output| Archive::create(output, provenance)).transpose() {
            Ok(archive) => (archive, Ok(())),
            Err(error) => (None, Err(error)),
        };
        let load = Dimension::index("load", loads, "load step");
        let unit = surface.unit();
        let [x, y] = axes(&surface.grid, unit);
        if surface.share.is_whole() {
            archive.as_mut().map_or(Ok(()), |archive| surface.write(archive, [&x, &y]))?;
        } else {
            // Its rows travel in any case.
            surface.write_shared(archive.as_mut(), [&x, &y])?;
        }
        failed?;
        if let Some(archive) = &mut archive {
            for (path, units, long_name) in written(recording, &chosen) {
                let units = if units == "length" { unit } else { units };
                archive.define(path, &Variable { dimensions: &[&load, &x, &y], units, long_name })?;
            }
        }
        Ok(Self { archive, share: surface.share.clone(), recording, chosen })
    }

    /// Writes the group `/base`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(super) fn write_base(&mut self, base: &MovedBase, surface: &Surface) -> Result<(), Failure> {
        let [x, y] = axes(&surface.grid, surface.unit());
        base.write(self.archive.as_mut(), &self.share, [&x, &y], surface.unit())
    }

    /// Writes the group `/lower`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_lower(&mut self, lower: &Surface) -> Result<(), Failure> {
        let [x, y] = axes(&lower.grid, lower.unit());
        self.archive.as_mut().map_or(Ok(()), |archive| lower::write(lower, archive, [&x, &y]))
    }

    /// Writes the field of the hardness, if it is one.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_hardness(&mut self, hardness: Option<&Hardness>, surface: &Surface) -> Result<(), Failure> {
        let [x, y] = axes(&surface.grid, surface.unit());
        hardness::write(hardness, self.archive.as_mut(), &self.share, [&x, &y])
    }

    /// Writes the fields of one state; a base that moves adds `lift` to the displacement.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write(&mut self, index: usize, state: &Rest, lift: Option<&Array2<f64>>) -> Result<(), Failure> {
        self.write_fields(index, self.chosen.fields(self.recording, state, lift))
    }

    /// As [`write`](Self::write), from the values of the fields row by row.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_values(&mut self, index: usize, fields: &[Cow<[f64]>]) -> Result<(), Failure> {
        let Some(archive) = &mut self.archive else { return Ok(()) };
        for ((path, ..), field) in written(self.recording, &self.chosen).zip(fields) {
            archive.write_slab(path, index, field)?;
        }
        Ok(())
    }

    /// Writes the chosen fields of one load, in the order of the file.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn write_fields<'b>(
        &mut self,
        index: usize,
        fields: impl IntoIterator<Item = CowArray<'b, f64, Ix2>>,
    ) -> Result<(), Failure> {
        let Self { archive, share, recording, chosen } = self;
        let mut outcome = Ok(());
        for ((path, ..), field) in written(*recording, chosen).zip(fields) {
            let written = match archive {
                Some(archive) if share.is_whole() => Ok(archive.write_slab(path, index, &contiguous(&field))?),
                _ => rows::write(share, field.view(), archive.as_mut(), (path, Some(index)), |_| {}),
            };
            outcome = outcome.and(written);
        }
        outcome
    }

    /// Writes patches, distributions and spectra of the loads.
    pub(super) fn write_statistics(&mut self, surface: &Surface, loads: &[Measured]) -> Result<(), Failure> {
        self.archive.as_mut().map_or(Ok(()), |archive| statistics::write(archive, surface, loads))
    }

    /// Writes the record of the search for the load.
    pub(super) fn write_history(&mut self, history: &Trace, unit: &str) -> Result<(), Failure> {
        self.archive.as_mut().map_or(Ok(()), |archive| history.write(archive, unit))
    }

    /// Writes the loads at which the flow stops.
    pub(super) fn write_threshold(&mut self, unit: &str, found: &[Option<Threshold>; 2]) -> Result<(), Failure> {
        self.archive.as_mut().map_or(Ok(()), |archive| threshold::write(archive, unit, found))
    }

    /// Writes the scalars of `count` loads, NaN beyond those there are, and gives the file its name; `None` at the processes that do
    /// not write.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn finish(
        self,
        loads: &[LoadRecord],
        count: usize,
        not_converged: Option<&NotConverged>,
    ) -> Result<Option<PathBuf>, Failure> {
        let Some(mut archive) = self.archive else { return Ok(None) };
        let load = Dimension::index("load", count, "load step");
        for Column { name, units, long_name, value } in columns(self.recording) {
            let values: Vec<f64> = (0..count).map(|i| loads.get(i).map_or(f64::NAN, value)).collect();
            let path = format!("/loads/{name}");
            archive.write(&path, &Variable { dimensions: &[&load], units, long_name }, &values)?;
            if let Some(reason) = Undefined::of_column(loads.iter().map(|load| &load.undefined), name) {
                archive.attribute(&path, "undefined", &*reason)?;
            }
        }
        not_converged.map_or(Ok(()), |unmet| unmet.write(&mut archive))?;
        Ok(Some(archive.finish()?))
    }
}
