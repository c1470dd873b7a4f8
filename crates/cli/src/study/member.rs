//! Results of one member of a study, and the cube of all members.

use std::collections::BTreeMap;

use gfmd_check::study::{Cube, CubeNumber, StateAxis};
use serde::{Deserialize, Serialize};

use super::config::{Choice, StudyConfig};

/// Number of a member.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct MemberColumn {
    pub(super) name: String,
    pub(super) units: String,
    pub(super) long_name: String,
    pub(super) undefined: String,
    /// Values of the states so far; `None` without a value.
    pub(super) values: Vec<Option<f64>>,
}

/// Result of a member.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Member {
    /// Complete configuration as TOML; empty if it could not be read.
    pub(super) config: String,
    pub(super) axes: Vec<StateAxis>,
    pub(super) columns: Vec<MemberColumn>,
    /// Units of lengths and of stresses.
    pub(super) units: [Option<String>; 2],
    /// Reason why the member failed; empty if it did not.
    pub(super) error: String,
    /// True if the input of the member was refused, before anything was solved.
    pub(super) is_refused: bool,
    pub(super) warnings: String,
    /// Checksums of its input files.
    pub(super) files: BTreeMap<String, String>,
}

impl Member {
    /// Returns the reason why a stored member cannot belong to a study; `None` if it can.
    pub(super) fn refuse(&self) -> Option<String> {
        let states = states(&self.axes);
        let long = self.columns.iter().find(|column| column.values.len() > states)?;
        Some(format!("{} has {} values; it must have at most {states}", long.name, long.values.len()))
    }
}

fn states(axes: &[StateAxis]) -> usize {
    axes.iter().map(|axis| axis.length).product()
}

/// Returns the numbers of a member along the axes of a cube, NaN beyond its states.
pub(super) fn columns(member: &Member, axes: &[StateAxis]) -> BTreeMap<String, Vec<f64>> {
    let value = |column: &MemberColumn, state: usize| column.values.get(state).copied().flatten().unwrap_or(f64::NAN);
    let column =
        |column: &MemberColumn| (column.name.clone(), (0..states(axes)).map(|state| value(column, state)).collect());
    let is_axis = |column: &&MemberColumn| axes.iter().any(|axis| axis.name == column.name);
    member.columns.iter().filter(|column| !is_axis(column)).map(column).collect()
}

/// Returns the cube of all members. The first member with states decides on its axes and units; one with others is
/// recorded as failed.
pub(super) fn cube(config: &StudyConfig, mut members: Vec<Member>) -> Cube {
    let first = members.iter().find(|member| !member.columns.is_empty());
    let (mut axes, units) = first.map_or_else(Default::default, |first| (first.axes.clone(), first.units.clone()));
    for member in members.iter_mut().filter(|member| !member.columns.is_empty()) {
        // Steps are numbered, and a path may end early.
        let same_axes = member.axes.iter().zip(&axes).all(|(a, b)| a.values == b.values && a.units == b.units);
        if member.units != units || !same_axes {
            member.error = "its units differ from those of the first member; they must be the same".to_owned();
            member.columns.clear();
        } else {
            axes.iter_mut().zip(&member.axes).for_each(|(axis, other)| axis.length = axis.length.max(other.length));
        }
    }
    let states = states(&axes);
    let mut numbers: BTreeMap<String, CubeNumber> = BTreeMap::new();
    let count = members.len();
    for (index, member) in members.iter().enumerate() {
        // Velocities are coordinates.
        let columns = member.columns.iter().filter(|column| axes.iter().all(|axis| axis.name != column.name));
        for MemberColumn { name, units, long_name, undefined, values } in columns {
            let number = numbers.entry(name.clone()).or_insert_with(|| CubeNumber {
                name: name.clone(),
                units: units.clone(),
                long_name: long_name.clone(),
                undefined: String::new(),
                values: vec![f64::NAN; count * states],
            });
            if !undefined.is_empty() && !number.undefined.split('\n').any(|known| known == undefined) {
                number.undefined += if number.undefined.is_empty() { "" } else { "\n" };
                number.undefined += undefined;
            }
            let place = &mut number.values[index * states..(index + 1) * states];
            place.iter_mut().zip(values).for_each(|(place, value)| *place = value.unwrap_or(f64::NAN));
        }
    }
    let names = |choices: &[Choice]| choices.iter().map(|choice| choice.name.clone()).collect();
    let (mut errors, mut warnings, mut configs) = (Vec::new(), Vec::new(), Vec::new());
    for member in members {
        errors.push(member.error);
        warnings.push(member.warnings);
        configs.push(member.config);
    }
    Cube {
        command: config.command.name().into(),
        surfaces: names(&config.surfaces),
        seeds: config.seeds.clone(),
        bodies: names(&config.bodies),
        axes,
        numbers: numbers.into_values().collect(),
        errors,
        warnings,
        configs,
        units,
    }
}
