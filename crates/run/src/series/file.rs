//! HDF5 file of a series.

use std::borrow::Cow;
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use gfmd_contact::Hardness;
use gfmd_field::Share;
use gfmd_files::{Archive, Dimension, Output, Provenance, Variable, axes, contiguous};
use gfmd_problem::{AnyState, Facts};
use gfmd_record::{ARRAYS, Array, Record, arrays, repulsion};
use gfmd_unit::Units;

use ndarray::{CowArray, Ix2};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::layout::SeriesLayout;
use super::prepared::Prepared;
use crate::columns::write_columns;
use crate::convergence::NotConverged;
use gfmd_input::base::MovedBase;
use gfmd_input::failure::Failure;
use gfmd_input::hardness;
use gfmd_input::lower;
use gfmd_input::rows;
use gfmd_input::session::Session;
use gfmd_input::source::Surface;

/// File of a series: the surface is written at once, the fields state by state, the scalars at the end. With several
/// processes, the first one writes it; all make the same calls, and give their rows of the fields.
pub struct StateFile<'a> {
    /// File at the writing process.
    archive: Option<Archive<'a>>,
    share: Share,
    facts: Facts,
    chosen: Chosen,
    units: Units,
}

/// Choice of fields of each state for the file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Chosen {
    /// All fields.
    #[default]
    All,
    /// Fields with these names.
    Named(Vec<&'static str>),
}

/// Error: words that do not name fields.
#[derive(Clone, Debug, thiserror::Error)]
#[error("it must be none, or some of {}, with commas between them", Chosen::listed(", "))]
pub struct ChosenError;

/// Returns the names of the fields that loads may have.
fn names() -> impl Iterator<Item = &'static str> {
    ARRAYS.iter().filter(|array| array.of_loads.is_some()).map(|array| array.name)
}

impl Chosen {
    /// Returns the chosen fields of a problem.
    fn of<'s>(&'s self, facts: &'s Facts) -> impl Iterator<Item = &'static Array> + 's {
        arrays(facts).filter(move |array| match self {
            Self::All => true,
            Self::Named(names) => names.contains(&array.name),
        })
    }

    /// Returns the number of chosen fields of a problem.
    pub fn count(&self, facts: &Facts) -> usize {
        self.of(facts).count()
    }

    /// Returns all names, separated by `between`.
    pub fn listed(between: &str) -> String {
        names().collect::<Vec<_>>().join(between)
    }

    /// Returns the first named field that the loads do not have.
    pub fn missing(&self, facts: &Facts) -> Option<&'static Array> {
        let Self::Named(names) = self else { return None };
        ARRAYS.iter().find(|array| names.contains(&array.name) && !(array.present)(facts))
    }

    /// Returns the places, among the chosen fields, of the two that separate contact from gap, if both are chosen.
    pub fn contact_and_gap(&self, facts: &Facts) -> Option<[usize; 2]> {
        let place = |wanted: &str| self.of(facts).position(|array| array.name == wanted);
        Some([place(repulsion(facts))?, place("gap")?])
    }

    /// Returns the chosen fields of a state, in file order; a moved `base` adds to the displacement.
    pub fn fields<'s>(
        &self,
        facts: &Facts,
        state: &'s AnyState,
        base: Option<&MovedBase>,
    ) -> Vec<CowArray<'s, f64, Ix2>> {
        let lifted = |array: &Array| {
            let field = (array.value)(state, facts)?;
            let moved = base.and_then(|base| match array.name {
                "displacement_z" => Some(&base.lift),
                "displacement_x" => base.sideways.first(),
                "displacement_y" => base.sideways.get(1),
                _ => None,
            });
            Some(match moved {
                Some(moved) => (&field + moved).into(),
                None => field,
            })
        };
        self.of(facts).filter_map(lifted).collect()
    }
}

impl FromStr for Chosen {
    type Err = ChosenError;

    fn from_str(text: &str) -> Result<Self, ChosenError> {
        if text == "none" {
            return Ok(Self::Named(Vec::new()));
        }
        let words: Vec<&str> = text.split(',').collect();
        if words.iter().any(|word| names().all(|name| name != *word)) {
            return Err(ChosenError);
        }
        Ok(Self::Named(names().filter(|name| words.contains(name)).collect()))
    }
}

impl<'de> Deserialize<'de> for Chosen {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}

impl fmt::Display for Chosen {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All => f.write_str(&Self::listed(",")),
            Self::Named(names) if names.is_empty() => f.write_str("none"),
            Self::Named(names) => f.write_str(&names.join(",")),
        }
    }
}

impl Serialize for Chosen {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Field of a state, named as in a file.
pub struct Field<'s> {
    /// Name.
    pub name: &'static str,
    /// Unit.
    pub units: &'static str,
    /// Values, `[x, y]`.
    pub values: CowArray<'s, f64, Ix2>,
}

/// Returns all fields of a state; a moved `base` adds to the displacement.
pub fn fields<'s>(facts: &Facts, state: &'s AnyState, base: Option<&MovedBase>) -> Vec<Field<'s>> {
    let values = Chosen::All.fields(facts, state, base);
    arrays(facts).zip(values).map(|(array, values)| Field { name: array.name, units: array.unit, values }).collect()
}

/// Returns the path of a field in a file.
fn path_of(array: &Array) -> String {
    format!("/fields/{}", array.name)
}

impl<'a> StateFile<'a> {
    /// Creates a file for the fields of `states` states of a surface. Processes without `output` only send rows.
    ///
    /// # Errors
    /// Returns an error, at the writing process, if the file cannot be written.
    pub fn create(
        output: Option<&'a Output>,
        provenance: &Provenance,
        surface: &Surface,
        states: usize,
        facts: Facts,
        chosen: Chosen,
    ) -> Result<Self, Failure> {
        let (mut archive, failed) = match output.map(|output| Archive::create(output, provenance)).transpose() {
            Ok(archive) => (archive, Ok(())),
            Err(error) => (None, Err(error)),
        };
        let (name, meaning) = SeriesLayout::of(&facts).stored;
        let state = Dimension::index(name, states, meaning);
        let units = surface.units();
        let [x, y] = axes(&surface.grid, surface.unit());
        if surface.share.is_whole() {
            archive.as_mut().map_or(Ok(()), |archive| surface.write(archive, [&x, &y]))?;
        } else {
            // The rows travel in any case.
            surface.write_shared(archive.as_mut(), [&x, &y])?;
        }
        failed?;
        if let Some(archive) = &mut archive {
            for array in chosen.of(&facts) {
                let units = units.name(array.unit);
                let variable =
                    Variable { dimensions: &[&state, &x, &y], units: &units, long_name: array.meaning(&facts) };
                archive.define(&path_of(array), &variable)?;
            }
        }
        Ok(Self { archive, share: surface.share.clone(), facts, chosen, units })
    }

    /// Creates like [`create`](Self::create), with all fields in the input of a series.
    ///
    /// # Errors
    /// Returns an error, at all processes, if the file cannot be written.
    pub fn of(
        output: Option<&'a Output>,
        provenance: &Provenance,
        prepared: &Prepared,
        states: usize,
        (chosen, session): (Chosen, &Session),
    ) -> Result<Self, Failure> {
        let Prepared { facts, surface, base, lower, hardness, .. } = prepared;
        let mut file = session.agree(Self::create(output, provenance, surface, states, *facts, chosen))?;
        let [x, y] = axes(&surface.grid, surface.unit());
        if let Some(base) = base {
            session.agree(base.write(file.archive.as_mut(), &file.share, [&x, &y], &file.units))?;
        }
        session.agree(lower.as_ref().map_or(Ok(()), |lower| file.write_lower(lower)))?;
        session.agree(file.write_hardness(hardness.as_ref(), surface))?;
        Ok(file)
    }

    /// Writes the group `/lower`.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn write_lower(&mut self, lower: &Surface) -> Result<(), Failure> {
        let [x, y] = axes(&lower.grid, lower.unit());
        lower::write(lower, self.archive.as_mut(), [&x, &y])
    }

    /// Writes the hardness if it is a field.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn write_hardness(&mut self, hardness: Option<&Hardness>, surface: &Surface) -> Result<(), Failure> {
        let [x, y] = axes(&surface.grid, surface.unit());
        hardness::write(hardness, self.archive.as_mut(), &self.share, [&x, &y], &self.units)
    }

    /// Writes the fields of one state; a moved `base` adds to the displacement.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn write(&mut self, index: usize, state: &AnyState, base: Option<&MovedBase>) -> Result<(), Failure> {
        self.write_fields(index, self.chosen.fields(&self.facts, state, base))
    }

    /// Writes like [`write`](Self::write), from the field values row by row.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn write_values(&mut self, index: usize, fields: &[Cow<[f64]>]) -> Result<(), Failure> {
        let Some(archive) = &mut self.archive else { return Ok(()) };
        for (array, field) in self.chosen.of(&self.facts).zip(fields) {
            archive.write_slab(&path_of(array), index, field)?;
        }
        Ok(())
    }

    /// Writes rows of a field of one state, from its value number `start`; `place` is the number of the state, and the
    /// number of the field among the chosen ones.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn write_piece(&mut self, (index, field): (usize, usize), start: usize, values: &[f64]) -> Result<(), Failure> {
        let path = self.chosen.of(&self.facts).nth(field).map(path_of);
        let (Some(archive), Some(path)) = (&mut self.archive, path) else { return Ok(()) };
        Ok(archive.write_rows(&path, Some(index), start / self.share.columns(), values)?)
    }

    /// Writes the chosen fields of one state, in file order.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn write_fields<'b>(
        &mut self,
        index: usize,
        fields: impl IntoIterator<Item = CowArray<'b, f64, Ix2>>,
    ) -> Result<(), Failure> {
        let Self { archive, share, facts, chosen, .. } = self;
        let mut outcome = Ok(());
        for (array, field) in chosen.of(facts).zip(fields) {
            let path = &*path_of(array);
            let written = match archive {
                Some(archive) if share.is_whole() => Ok(archive.write_slab(path, index, &contiguous(&field))?),
                _ => rows::write(share, field.view(), archive.as_mut(), (path, Some(index)), |_| {}),
            };
            outcome = outcome.and(written);
        }
        outcome
    }

    /// Returns the file, for additions by a command; `None` at the processes that do not write.
    pub fn archive(&mut self) -> Option<&mut Archive<'a>> {
        self.archive.as_mut()
    }

    /// Writes the scalars of `count` parts, NaN beyond the given records, and gives the file its name; `None` at the
    /// processes that do not write.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn finish(
        self,
        records: &[Record],
        count: usize,
        not_converged: Option<&NotConverged>,
    ) -> Result<Option<PathBuf>, Failure> {
        let Some(mut archive) = self.archive else { return Ok(None) };
        let parts = SeriesLayout::of(&self.facts);
        let rows = Dimension::index(parts.name, count, parts.meaning);
        let names = [parts.name, parts.plural];
        write_columns(&mut archive, (parts.group, &rows, names), (&self.facts, &self.units), records, count)?;
        not_converged.map_or(Ok(()), |unmet| unmet.write(&mut archive))?;
        Ok(Some(archive.finish()?))
    }
}
