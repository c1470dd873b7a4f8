//! Flags of the loads: mean pressures, reduced pressures, forces, or approaches.

use clap::Args;
use gfmd_contact::Load;
use gfmd_field::Grid;
use gfmd_input::failure::Failure;
use gfmd_problem::options::values::{Entry, as_numbers, from_numbers, numbers};
use gfmd_problem::options::{Kinds, Options};
use gfmd_problem::{key, words};
use gfmd_run::series::{Prepared, unit_of_load};
use serde::{Deserialize, Serialize};

/// Flags of the loads, or of the loads at waypoints. Exactly one is given.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[group(required = true, multiple = false)]
#[command(next_help_heading = "Load")]
pub(crate) struct LoadArgs {
    /// Mean pressures, stress, negative for tension (with a law); A:B:N is N values from A to B in geometric steps
    #[arg(long, value_delimiter = ',', value_name = "P1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    #[option(kinds = Kinds::STRESS)]
    pressure: Vec<Entry>,
    /// Reduced pressures p/(E* g)
    #[arg(long, value_delimiter = ',', value_name = "P1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    p_star: Vec<Entry>,
    /// Total forces, stress * length^2, such as 5N: mean pressures times the area of the cell or patch
    #[arg(long, value_delimiter = ',', value_name = "F1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    #[option(kinds = Kinds::FORCE)]
    force: Vec<Entry>,
    /// Rigid approaches beyond first touch, length, negative for separation (with a law, or along a path)
    #[arg(
        long,
        alias = "displacement",
        value_delimiter = ',',
        value_name = "D1|A:B:N,..",
        allow_negative_numbers = true
    )]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    #[option(kinds = Kinds::LENGTH)]
    approach: Vec<Entry>,
}

/// Allowed signs of loads and approaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Sign {
    /// Surfaces that only touch under a load.
    Positive,
    /// Surfaces along a path, which may part and touch again: any approach.
    NotNegative,
    /// Surfaces that may be pulled.
    Any,
}

impl LoadArgs {
    /// Returns the keys of the loads with their values.
    fn given(&self) -> [(&'static str, &Vec<Entry>); 4] {
        [("pressure", &self.pressure), ("p_star", &self.p_star), ("force", &self.force), ("approach", &self.approach)]
    }

    /// Returns the key of the given loads.
    pub(crate) fn option(&self) -> &'static str {
        self.given().into_iter().find(|(_, values)| !values.is_empty()).map_or("approach", |(option, _)| option)
    }

    /// Returns true if approaches are given.
    pub(crate) fn is_approach(&self) -> bool {
        self.option() == "approach"
    }

    /// Returns the given values; reduced pressures and forces are not yet pressures.
    pub(crate) fn given_values(&self) -> Vec<f64> {
        self.given().into_iter().flat_map(|(_, values)| numbers(values)).collect()
    }

    /// Checks that the loads have an allowed sign.
    ///
    /// # Errors
    /// Returns an error unless exactly one option is given, with values that can be used.
    pub(crate) fn check(&self, sign: Sign) -> Result<(), Failure> {
        let given = self.given();
        if given.iter().filter(|(_, values)| !values.is_empty()).count() != 1 {
            let names = words![key("pressure"), ", ", key("p_star"), ", ", key("force"), ", ", key("approach")];
            let found = "loads are given by none or several of ";
            return Err(Failure::refused(words![found, names, "; it must be one of them"]));
        }
        for (option, values) in given {
            let (allowed, has_sign): (&str, fn(f64) -> bool) = match sign {
                Sign::NotNegative if option != "approach" => ("finite and not negative", |value| value >= 0.0),
                Sign::Positive => ("positive and finite", |value| value > 0.0),
                Sign::NotNegative | Sign::Any => ("finite", |_| true),
            };
            if let Some(bad) = numbers(values).find(|value| !(value.is_finite() && has_sign(*value))) {
                return Err(Failure::value(key(option), bad, allowed));
            }
        }
        Ok(())
    }

    /// Returns the values, with mean pressures in place of reduced pressures and forces.
    ///
    /// # Errors
    /// Returns an error for a force on a profile.
    pub(crate) fn values(&self, prepared: &Prepared) -> Result<Vec<f64>, Failure> {
        let unit = prepared.unit_of_load(self.option())?;
        Ok(self.given_values().into_iter().map(|value| value * unit).collect())
    }

    /// Returns the loads.
    ///
    /// # Errors
    /// Returns an error as [`values`](Self::values).
    pub(crate) fn loads(&self, prepared: &Prepared) -> Result<impl Iterator<Item = Load>, Failure> {
        Ok(self.values(prepared)?.into_iter().map(self.kind()))
    }

    /// Returns the function from a value to its load.
    pub(crate) fn kind(&self) -> fn(f64) -> Load {
        if self.is_approach() { Load::Approach } else { Load::MeanPressure }
    }
}

/// Flags of the loads of a theory, which needs no approach. At most one is given.
#[derive(Args, Options, Clone, Debug, Deserialize)]
#[serde(default)]
#[group(multiple = false)]
#[command(next_help_heading = "Load")]
pub(crate) struct PressingArgs {
    /// Mean pressures, stress; A:B:N is N values from A to B in geometric steps
    #[arg(long, value_delimiter = ',', value_name = "P1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(deserialize_with = "from_numbers")]
    #[option(kinds = Kinds::STRESS)]
    pressure: Vec<Entry>,
    /// Reduced pressures p/(E* g) [default: 0.001,0.01,0.05,0.1,0.3,1]
    #[arg(long, value_delimiter = ',', value_name = "P1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(deserialize_with = "from_numbers")]
    p_star: Vec<Entry>,
    /// Total forces, stress * length^2, such as 5N: mean pressures times the area of the cell
    #[arg(long, value_delimiter = ',', value_name = "F1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(deserialize_with = "from_numbers")]
    #[option(kinds = Kinds::FORCE)]
    force: Vec<Entry>,
}

/// Reduced pressures of a theory without a load.
const REDUCED: [f64; 6] = [0.001, 0.01, 0.05, 0.1, 0.3, 1.0];

impl PressingArgs {
    /// Returns the key of the given loads and their values; the default loads if there are none.
    ///
    /// # Errors
    /// Returns an error if several options are given, or a value is not positive.
    pub(crate) fn given(&self) -> Result<(&'static str, Vec<f64>), Failure> {
        let all = [("pressure", &self.pressure), ("p_star", &self.p_star), ("force", &self.force)];
        let mut given = all.into_iter().filter(|(_, values)| !values.is_empty());
        let (option, values) = match (given.next(), given.next()) {
            (None, _) => return Ok(("p_star", REDUCED.to_vec())),
            (Some((option, values)), None) => (option, numbers(values).collect::<Vec<f64>>()),
            (Some(_), Some(_)) => {
                let names = words![key("pressure"), ", ", key("p_star"), ", ", key("force")];
                return Err(Failure::refused(words![
                    "loads are given by several of ",
                    names,
                    "; it must be one of them"
                ]));
            }
        };
        match values.iter().find(|value| !(**value > 0.0 && value.is_finite())) {
            Some(found) => Err(Failure::value(key(option), found, "positive")),
            None => Ok((option, values)),
        }
    }

    /// Returns the reduced pressures on a surface on `grid` with the `unit` of pressures, E* times the rms gradient.
    ///
    /// # Errors
    /// Returns an error as [`given`](Self::given), for a force on a profile, and for a load so small or so large that
    /// the pressure has lost digits.
    pub(crate) fn reduced(&self, unit: f64, grid: &Grid) -> Result<Vec<f64>, Failure> {
        let (option, values) = self.given()?;
        let factor = match option {
            "p_star" => 1.0,
            option => unit_of_load(option, grid, unit)? / unit,
        };
        for value in &values {
            let p_star = value * factor;
            let pressure = p_star * unit;
            if unit > 0.0 && !(pressure.is_normal() && p_star.is_normal()) {
                let bounds = [1.0, 1.0 / unit].map(|unit| [f64::MIN_POSITIVE * unit, f64::MAX * unit]);
                let [least, most] =
                    [bounds[0][0].max(bounds[1][0]), bounds[0][1].min(bounds[1][1])].map(|p| p / factor);
                let allowed = format!("from {least:e} to {most:e} (the pressure p* E* g is {pressure:e})");
                return Err(Failure::value(key(option), value, &allowed));
            }
        }
        Ok(values.into_iter().map(|value| value * factor).collect())
    }
}
