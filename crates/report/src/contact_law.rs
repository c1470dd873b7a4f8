//! Law of a rough contact for finite elements: nominal pressure against mean gap, area, stiffness, conductance and
//! transmissivity, in SI units, as text of a format.

mod power;
mod text;

use std::collections::BTreeMap;

use gfmd_files::legible;
use gfmd_record::{Cell, Record};
use gfmd_unit::Units;
use serde::Deserialize;

pub use power::PowerLaw;
pub use text::LawFormat;

/// Number of a law besides the pressure: name, SI unit, and the powers of stress and length in it.
pub struct LawNumber {
    /// Name, as of the column.
    pub name: &'static str,
    /// SI unit, as part of a head.
    pub unit: &'static str,
    powers: [i32; 2],
}

/// Numbers of a law, in order.
pub const LAW_NUMBERS: [LawNumber; 7] = [
    LawNumber { name: "mean_gap", unit: "m", powers: [0, 1] },
    LawNumber { name: "area_fraction", unit: "1", powers: [0, 0] },
    LawNumber { name: "stiffness", unit: "Pa/m", powers: [1, -1] },
    LawNumber { name: "conductance", unit: "1/m", powers: [0, -1] },
    LawNumber { name: "contact_conductance", unit: "W/(m2 K)", powers: [1, 1] },
    LawNumber { name: "transmissivity_x", unit: "m3", powers: [0, 3] },
    LawNumber { name: "transmissivity_y", unit: "m3", powers: [0, 3] },
];

/// Place of the mean gap and of the contact conductance in [`LAW_NUMBERS`].
const GAP: usize = 0;
const CONDUCTANCE: [usize; 2] = [4, 3];

/// Number of a load with its grid error, or the reason why it is missing.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum Given {
    /// Value and grid error, if that is known.
    Value(f64, Option<f64>),
    /// Reason.
    Missing(String),
}

/// Contacts of one surface under several loads, in the units of the problem.
#[derive(Clone, Debug, Deserialize)]
pub struct Realisation {
    /// Mean pressures.
    pub pressure: Vec<f64>,
    /// Mean gap at first touch.
    pub first_gap: f64,
    /// Numbers of each load, by name.
    pub loads: Vec<BTreeMap<String, Given>>,
}

/// Number of a row, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Known {
    /// Mean over the realisations.
    pub value: f64,
    /// Largest grid error of a realisation, if it is known for all.
    pub grid_error: Option<f64>,
    /// Standard error of the mean; `None` for one realisation.
    pub standard_error: Option<f64>,
}

/// Row of a law.
#[derive(Clone, Debug, PartialEq)]
pub struct LawRow {
    /// Mean pressure, Pa.
    pub pressure: f64,
    /// Numbers in the order of [`LAW_NUMBERS`].
    pub numbers: [Option<Known>; 7],
}

/// Law of a contact.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactLaw {
    /// Rows by increasing pressure, without first touch.
    pub rows: Vec<LawRow>,
    /// Mean gap at first touch, m.
    pub first_gap: f64,
    /// Number of realisations.
    pub realisations: usize,
    /// Name of the fitted conductance, and the fit h = c p^m, or the reason why there is none.
    pub fit: Result<(&'static str, PowerLaw), String>,
    /// Reasons for missing numbers, by name.
    pub missing: BTreeMap<&'static str, String>,
}

/// Reason why contacts have no law.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoLaw {
    /// The unit of lengths or of stresses is not known.
    #[error("lengths and stresses have no unit; they must have one for a law in SI units, such as um and 70GPa")]
    Units,
    /// Fewer than two loads.
    #[error("the contact has {0} load; it must have two or more for a law")]
    OneLoad(usize),
    /// Realisations with other loads.
    #[error("realisation {0} has other mean pressures than the first; all must have the same loads")]
    OtherLoads(usize),
    /// A load that does not press.
    #[error("the mean pressure is {0} Pa; it must be positive for a law")]
    Pull(f64),
    /// Pressures or gaps that do not rise and fall.
    #[error(
        "the mean gap is {1} m at {0} Pa and {3} m at {2} Pa; it must fall from load to load, without equal loads and \
         without full contact"
    )]
    NotFalling(f64, f64, f64, f64),
}

/// Relative difference up to which pressures of realisations are equal.
const SAME: f64 = 1e-6;

impl Realisation {
    /// Takes the numbers of solved loads.
    pub fn of(records: &[Record], first_gap: f64) -> Self {
        let load = |record: &Record| -> BTreeMap<String, Given> {
            LAW_NUMBERS.iter().map(|number| (number.name.to_owned(), of(record, number.name))).collect()
        };
        Self {
            pressure: records.iter().map(|record| record.number("mean_pressure")).collect(),
            first_gap,
            loads: records.iter().map(load).collect(),
        }
    }
}

/// Returns a number of a record.
fn of(record: &Record, name: &str) -> Given {
    let number = |name: &str| match record.get(name) {
        Some(Cell::Undefined(reason)) => Err(reason.clone().into_owned()),
        Some(cell) if cell.number().is_finite() => Ok(cell.number()),
        Some(_) => Err("it is not finite".to_owned()),
        None => Err("it was not measured".to_owned()),
    };
    let error = |name: &str| number(&format!("{name}_grid_error")).ok();
    let found = match name {
        "transmissivity_x" | "transmissivity_y" => {
            let axis = &name[name.len() - 1..];
            let flow = format!("flow_{axis}{axis}");
            // A closed gap lets nothing through, whatever its conductivity.
            let is_closed = record.get(&format!("flow_percolates_{axis}")) == Some(&Cell::Flag(false));
            let conductivity = if is_closed { Ok(0.0) } else { number(&flow) };
            conductivity.and_then(|conductivity| {
                let gap = number("mean_gap")?;
                let value = conductivity * gap.powi(3) / 12.0;
                // The relative errors of a product add up.
                let relative = error(&flow).zip(error("mean_gap"));
                let relative = relative.map(|(of_flow, of_gap)| of_flow / conductivity + 3.0 * of_gap / gap);
                Ok((value, relative.filter(|relative| relative.is_finite()).map(|relative| relative * value)))
            })
        }
        name => number(name).map(|value| (value, error(name))),
    };
    found.map_or_else(Given::Missing, |(value, error)| Given::Value(value, error))
}

impl ContactLaw {
    /// Makes the law of contacts in these units: the mean over the realisations.
    ///
    /// # Errors
    /// Returns the reason why there is no law.
    pub fn new(realisations: &[Realisation], units: &Units) -> Result<Self, NoLaw> {
        let (metres, pascals) = units.metres().zip(units.pascals()).ok_or(NoLaw::Units)?;
        let Some(first) = realisations.first() else { return Err(NoLaw::OneLoad(0)) };
        let count = first.pressure.len();
        if count < 2 {
            return Err(NoLaw::OneLoad(count));
        }
        let is_same = |one: &f64, other: &f64| (one / other - 1.0).abs() <= SAME;
        let others = |other: &Realisation| {
            other.pressure.len() != count || !other.pressure.iter().zip(&first.pressure).all(|(a, b)| is_same(a, b))
        };
        if let Some(index) = realisations.iter().position(others) {
            return Err(NoLaw::OtherLoads(index));
        }
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by(|one, other| first.pressure[*one].total_cmp(&first.pressure[*other]));
        let mut missing = BTreeMap::new();
        let row = |load: usize, missing: &mut BTreeMap<&'static str, String>| LawRow {
            pressure: first.pressure[load] * pascals,
            numbers: std::array::from_fn(|which| {
                let LawNumber { name, powers: [stress, length], .. } = &LAW_NUMBERS[which];
                let scale = pascals.powi(*stress) * metres.powi(*length);
                match mean(realisations.iter().map(|found| found.loads.get(load).and_then(|load| load.get(*name)))) {
                    Ok(known) => Some(known.times(scale)),
                    Err(reason) => {
                        missing.entry(*name).or_insert(reason);
                        None
                    }
                }
            }),
        };
        let rows: Vec<LawRow> = order.into_iter().map(|load| row(load, &mut missing)).collect();
        let gaps = realisations.iter().map(|found| found.first_gap).sum::<f64>() / realisations.len() as f64;
        let first_gap = gaps * metres;
        let gap = |row: &LawRow| row.numbers[GAP].map_or(f64::NAN, |known| known.value);
        let touch = (0.0, first_gap);
        let places = std::iter::once(touch).chain(rows.iter().map(|row| (row.pressure, gap(row)))).collect::<Vec<_>>();
        if let Some((pressure, _)) = places[1..].iter().find(|(pressure, _)| pressure.is_nan() || *pressure <= 0.0) {
            return Err(NoLaw::Pull(*pressure));
        }
        if let Some(pair) = places.windows(2).find(|pair| !(pair[1].0 > pair[0].0 && pair[1].1 < pair[0].1)) {
            return Err(NoLaw::NotFalling(pair[0].0, pair[0].1, pair[1].0, pair[1].1));
        }
        Ok(Self { fit: fitted(&rows, &missing), rows, first_gap, realisations: realisations.len(), missing })
    }

    /// Returns the law as text of a format; `heading` describes the contacts in one line.
    pub fn text(&self, format: LawFormat, heading: &str) -> String {
        text::write(self, format, &legible::line(heading))
    }
}

impl Known {
    fn times(self, factor: f64) -> Self {
        Self {
            value: self.value * factor,
            grid_error: self.grid_error.map(|error| error * factor),
            standard_error: self.standard_error.map(|error| error * factor),
        }
    }
}

/// Returns the mean of a number over realisations.
///
/// # Errors
/// Returns the reason if a realisation does not have it.
fn mean<'a>(all: impl Iterator<Item = Option<&'a Given>>) -> Result<Known, String> {
    let found = all.map(|given| match given {
        Some(Given::Value(value, error)) if value.is_finite() => Ok((*value, error.filter(|error| error.is_finite()))),
        Some(Given::Missing(reason)) => Err(reason.clone()),
        Some(Given::Value(..)) => Err("it is not finite".to_owned()),
        None => Err("it was not measured".to_owned()),
    });
    let found = found.collect::<Result<Vec<_>, _>>()?;
    let count = found.len() as f64;
    let value = found.iter().map(|(value, _)| value).sum::<f64>() / count;
    let square = found.iter().map(|(other, _)| (other - value).powi(2)).sum::<f64>() / (count - 1.0) / count;
    let errors = found.iter().map(|(_, error)| *error).collect::<Option<Vec<f64>>>();
    Ok(Known {
        value,
        grid_error: errors.map(|errors| errors.into_iter().fold(0.0, f64::max)),
        standard_error: (found.len() > 1).then(|| square.sqrt()),
    })
}

/// Fits the conductance: with the conductivities if they are known.
fn fitted(rows: &[LawRow], missing: &BTreeMap<&'static str, String>) -> Result<(&'static str, PowerLaw), String> {
    let points = |which: usize| -> Vec<(f64, f64)> {
        rows.iter()
            .filter_map(|row| Some((row.pressure, row.numbers[which]?.value)))
            .filter(|(_, h)| *h > 0.0)
            .collect()
    };
    let which = CONDUCTANCE.into_iter().find(|which| !points(*which).is_empty());
    let Some(which) = which else {
        let name = LAW_NUMBERS[CONDUCTANCE[1]].name;
        return Err(missing.get(name).cloned().unwrap_or_else(|| format!("no load has a {name}")));
    };
    PowerLaw::fit(&points(which)).map(|fit| (LAW_NUMBERS[which].name, fit))
}

#[cfg(test)]
mod tests;
