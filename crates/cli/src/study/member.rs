//! Results of one member of a study.

use std::collections::BTreeMap;

use gfmd_check::study::StateAxis;
use serde::{Deserialize, Serialize};

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

/// Returns the number of states along axes.
pub(super) fn states(axes: &[StateAxis]) -> usize {
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
