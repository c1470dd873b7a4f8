//! Flags of the loads: mean pressures, reduced pressures, forces, or approaches.

use clap::Args;
use gfmd_contact::Load;
use gfmd_input::failure::Failure;
use gfmd_problem::options::values::{Entry, as_numbers, from_numbers, numbers};
use gfmd_problem::options::{Kinds, Options};
use gfmd_problem::{key, words};
use gfmd_run::series::Prepared;
use serde::{Deserialize, Serialize};

/// Flags of the loads, or of the loads at waypoints. Exactly one is given.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[group(required = true, multiple = false)]
#[command(next_help_heading = "Load")]
pub(crate) struct LoadArgs {
    /// Mean pressures, stress; with a law a negative one pulls; A:B:N is N values from A to B in geometric steps
    #[arg(long, value_delimiter = ',', value_name = "P1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    #[option(kinds = Kinds::STRESS)]
    pressure: Vec<Entry>,
    /// Reduced pressures p/(E* g)
    #[arg(long, value_delimiter = ',', value_name = "P1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    p_star: Vec<Entry>,
    /// Forces on the whole surface, stress * length^2, such as 5N: mean pressures times the area of the cell or patch
    #[arg(long, value_delimiter = ',', value_name = "F1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    #[option(kinds = Kinds::FORCE)]
    force: Vec<Entry>,
    /// Rigid approaches beyond first touch, length; a negative one is a separation
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
    /// Surfaces that keep an imprint, which a load of zero leaves; approaches are positive.
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
                Sign::Positive | Sign::NotNegative => ("positive and finite", |value| value > 0.0),
                Sign::Any => ("finite", |_| true),
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
