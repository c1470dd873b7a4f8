//! The numbers of a study of many contacts as a cube, and its file.

use gfmd_files::{Archive, Dimension, Reader, Variable};
use gfmd_input::failure::Failure;
use gfmd_unit::Units;
use serde::{Deserialize, Serialize};

/// Group of a study in its file.
pub const GROUP: &str = "/study";

/// Status of a member with all its numbers.
pub const SOLVED: &str = "solved";

/// Status of a member that failed.
pub const FAILED: &str = "failed";

/// Coordinates of the states of a member: its loads, steps or velocities.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StateAxis {
    /// Name of the dimension: `load`, `step` or `velocity`.
    pub name: String,
    /// Values; `None` for the indices from zero.
    pub values: Option<Vec<f64>>,
    /// Number of entries.
    pub length: usize,
    /// Unit of the values.
    pub units: String,
    /// Meaning in words.
    pub long_name: String,
}

/// Number of all members.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CubeNumber {
    /// Name, as in the file of a single contact.
    pub name: String,
    /// Unit.
    pub units: String,
    /// Meaning in words.
    pub long_name: String,
    /// Reasons why the number has no value in some members.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub undefined: String,
    /// Values, [surface, seed, body, states]; NaN without a value.
    pub values: Vec<f64>,
}

/// Study of many contacts: surfaces, seeds and bodies, all with the same loads.
#[derive(Clone, Debug, PartialEq)]
pub struct Cube {
    /// Command of the members.
    pub command: String,
    /// Names of the surfaces.
    pub surfaces: Vec<String>,
    /// Seeds.
    pub seeds: Vec<u64>,
    /// Names of the bodies.
    pub bodies: Vec<String>,
    /// Axes of the states, slowest first.
    pub axes: Vec<StateAxis>,
    /// Numbers.
    pub numbers: Vec<CubeNumber>,
    /// Reason why a member failed, [surface, seed, body]; empty for one that did not.
    pub errors: Vec<String>,
    /// Warnings of each member.
    pub warnings: Vec<String>,
    /// Complete configuration of each member as TOML.
    pub configs: Vec<String>,
    /// Unit of lengths and of stresses, if they are known.
    pub units: [Option<String>; 2],
}

/// Mean over realisations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct MeanOver {
    /// Mean.
    pub mean: f64,
    /// Standard error; `None` with a single value.
    pub standard_error: Option<f64>,
    /// Number of values.
    pub count: usize,
}

impl MeanOver {
    /// Returns the mean of the values that are not NaN; `None` without one.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let values: Vec<f64> = values.into_iter().filter(|value| !value.is_nan()).collect();
        let count = values.len();
        let mean = values.iter().sum::<f64>() / count as f64;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        let standard_error = (count > 1).then(|| (squares / (count - 1) as f64 / count as f64).sqrt());
        (count > 0).then_some(Self { mean, standard_error, count })
    }
}

impl Cube {
    /// Returns the number of members.
    pub fn members(&self) -> usize {
        self.surfaces.len() * self.seeds.len() * self.bodies.len()
    }

    /// Returns the number of states of a member.
    pub fn states(&self) -> usize {
        self.axes.iter().map(|axis| axis.length).product()
    }

    /// Returns the numbers of surface, seed and body of a member.
    pub fn place(&self, member: usize) -> [usize; 3] {
        let (seeds, bodies) = (self.seeds.len(), self.bodies.len());
        [member / (seeds * bodies), member / bodies % seeds, member % bodies]
    }

    /// Returns the units of the numbers.
    pub fn known_units(&self) -> Units {
        Units::new(self.units[0].as_deref(), self.units[1].as_deref())
    }

    /// Returns a number.
    pub fn number(&self, name: &str) -> Option<&CubeNumber> {
        self.numbers.iter().find(|number| number.name == name)
    }

    /// Returns the mean of a number over the seeds, at a surface, a body and a state.
    pub fn mean(&self, number: &CubeNumber, surface: usize, body: usize, state: usize) -> Option<MeanOver> {
        let (seeds, bodies, states) = (self.seeds.len(), self.bodies.len(), self.states());
        let at = |seed: usize| number.values[((surface * seeds + seed) * bodies + body) * states + state];
        MeanOver::of((0..seeds).map(at))
    }

    /// Returns the coordinates of a state along each axis.
    pub fn coordinates(&self, state: usize) -> Vec<f64> {
        let mut rest = state;
        let mut found: Vec<f64> = Vec::new();
        for axis in self.axes.iter().rev() {
            let index = rest % axis.length.max(1);
            rest /= axis.length.max(1);
            found.push(axis.values.as_ref().map_or(index as f64, |values| values[index]));
        }
        found.reverse();
        found
    }

    /// Writes the group of the study.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn write(&self, archive: &mut Archive) -> Result<(), Failure> {
        let labels = |name: &str, labels: &[String], long_name: &str| {
            Dimension::labels(name, &labels.iter().map(String::as_str).collect::<Vec<_>>(), long_name)
        };
        let surface = labels("surface", &self.surfaces, "surface");
        let seed = self.seeds.iter().map(|seed| *seed as f64).collect();
        let seed = Dimension::values("seed", seed, "1", "random seed");
        let body = labels("body", &self.bodies, "body");
        let states = self.axes.iter().map(|axis| match &axis.values {
            Some(values) => Dimension::values(&axis.name, values.clone(), &axis.units, &axis.long_name),
            None => Dimension::index(&axis.name, axis.length, &axis.long_name),
        });
        let states: Vec<Dimension> = states.collect();
        let member = [&surface, &seed, &body];
        let all: Vec<&Dimension> = member.into_iter().chain(&states).collect();
        archive.attribute(GROUP, "command", &*self.command)?;
        for (name, unit) in ["unit", "stress_unit"].into_iter().zip(&self.units) {
            unit.as_deref().map_or(Ok(()), |unit| archive.attribute(GROUP, name, unit))?;
        }
        for CubeNumber { name, units, long_name, undefined, values } in &self.numbers {
            let path = format!("{GROUP}/{name}");
            archive.write(&path, &Variable { dimensions: &all, units, long_name }, values)?;
            if !undefined.is_empty() {
                archive.attribute(&path, "undefined", &**undefined)?;
            }
        }
        let status: Vec<String> = self.errors.iter().map(|error| status(error).to_owned()).collect();
        for (name, long_name, texts) in [
            ("status", "solved or failed", &status),
            ("error", "reason why the member failed; empty otherwise", &self.errors),
            ("warnings", "warnings of the member, one per line", &self.warnings),
            ("config", "complete configuration of the member as TOML", &self.configs),
        ] {
            let variable = Variable { dimensions: &member, units: "1", long_name };
            archive.write_text(&format!("{GROUP}/{name}"), &variable, texts)?;
        }
        Ok(())
    }

    /// Reads the group of the study.
    ///
    /// # Errors
    /// Returns an error for a file without a study, or with variables of other shapes.
    pub fn read(reader: &Reader) -> Result<Self, Failure> {
        let path = |name: &str| format!("{GROUP}/{name}");
        let attribute = |name: &str, of: &str| reader.text(&path(name), of).unwrap_or_default();
        let texts = |name: &str| reader.texts(&path(name));
        let surfaces = texts("surface")?;
        let bodies = texts("body")?;
        let seeds = reader.values::<f64>(&path("seed"))?;
        if let Some(seed) = seeds.iter().find(|seed| **seed < 0.0 || seed.fract() != 0.0) {
            return Err(Failure::input(path("seed"), format!("it has {seed:?}; seeds must be whole numbers")));
        }
        let seeds = seeds.into_iter().map(|seed| seed as u64).collect();
        let mut axes = Vec::new();
        for name in ["load", "step", "velocity"].into_iter().filter(|name| reader.contains(&path(name))) {
            let values = reader.values::<f64>(&path(name))?;
            let is_index = name == "step";
            axes.push(StateAxis {
                name: name.into(),
                length: values.len(),
                values: (!is_index).then_some(values),
                units: attribute(name, "units"),
                long_name: attribute(name, "long_name"),
            });
        }
        let mut cube = Self {
            command: reader.text(GROUP, "command")?,
            surfaces,
            seeds,
            bodies,
            axes,
            numbers: Vec::new(),
            errors: texts("error")?,
            warnings: texts("warnings")?,
            configs: texts("config")?,
            units: ["unit", "stress_unit"].map(|name| reader.text(GROUP, name).ok()),
        };
        let (members, states) = (cube.members(), cube.states());
        let shape = |name: &str, found: usize, allowed: usize| {
            let reason = format!("it has {found} values; it must have {allowed}");
            if found == allowed { Ok(()) } else { Err(Failure::input(path(name), reason)) }
        };
        for (name, texts) in [("error", &cube.errors), ("warnings", &cube.warnings), ("config", &cube.configs)] {
            shape(name, texts.len(), members)?;
        }
        for name in reader.names(GROUP) {
            let Ok(values) = reader.values::<f64>(&path(&name)) else { continue };
            if reader.is_coordinate(&path(&name)) {
                continue;
            }
            shape(&name, values.len(), members * states)?;
            let [units, long_name, undefined] = ["units", "long_name", "undefined"].map(|of| attribute(&name, of));
            cube.numbers.push(CubeNumber { name, units, long_name, undefined, values });
        }
        Ok(cube)
    }
}

/// Returns the status of a member with this error.
pub fn status(error: &str) -> &'static str {
    if error.is_empty() { SOLVED } else { FAILED }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gfmd_files::{Output, Provenance};

    fn cube() -> Cube {
        let values: Vec<f64> = (0..24).map(|k| if k == 7 { f64::NAN } else { f64::from(k) / 3.0 }).collect();
        Cube {
            command: "contact".into(),
            surfaces: vec!["a".into(), "b".into()],
            seeds: vec![1, 7, 9],
            bodies: vec!["steel".into(), "rubber".into()],
            axes: vec![StateAxis {
                name: "load".into(),
                values: Some(vec![0.01, 0.1]),
                length: 2,
                units: "1".into(),
                long_name: "reduced pressure".into(),
            }],
            numbers: vec![CubeNumber {
                name: "area_fraction".into(),
                units: "1".into(),
                long_name: "area".into(),
                undefined: "a reason".into(),
                values,
            }],
            errors: (0..12).map(|member| if member == 3 { "not converged".into() } else { String::new() }).collect(),
            warnings: vec![String::new(); 12],
            configs: vec!["n = 8".into(); 12],
            units: [None, Some("Pa".into())],
        }
    }

    #[test]
    fn a_cube_is_read_back_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::claim(folder.path().join("s.h5")).unwrap();
        let mut archive = Archive::create(&output, &Provenance::default()).unwrap();
        cube().write(&mut archive).unwrap();
        let found = Cube::read(&Reader::open(archive.finish().unwrap()).unwrap()).unwrap();
        let bits = |cube: &Cube| cube.numbers[0].values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&found), bits(&cube()));
        assert_eq!(format!("{found:?}"), format!("{:?}", cube()));
    }

    #[test]
    fn means_are_over_the_seeds_and_leave_out_missing_values() {
        let cube = cube();
        let number = &cube.numbers[0];
        // Members 0, 2 and 4 are the seeds of the first surface and body; 12 values apart per surface.
        let found = cube.mean(number, 0, 0, 1).unwrap();
        assert_eq!((found.mean, found.count), ((1.0 + 5.0 + 9.0) / 9.0, 3));
        let expected = ((16.0_f64 + 16.0) / 9.0 / 2.0 / 3.0).sqrt();
        assert!((found.standard_error.unwrap() - expected).abs() < 1e-15);
        assert_eq!(cube.mean(number, 0, 1, 1).unwrap().count, 2);
        assert_eq!(MeanOver::of([f64::NAN]), None);
        assert_eq!(MeanOver::of([2.0]), Some(MeanOver { mean: 2.0, standard_error: None, count: 1 }));
        assert_eq!(cube.place(7), [1, 0, 1]);
        assert_eq!(cube.coordinates(1), [0.1]);
    }
}
