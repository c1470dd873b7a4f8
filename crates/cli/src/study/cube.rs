//! The cube of all members of a study.

use std::collections::BTreeMap;

use gfmd_check::study::{Cube, CubeNumber};

use super::config::{Choice, StudyConfig};
use super::member::{Member, MemberColumn, states};

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
