//! Flags whose values are the rows of a library's table: a name and a meaning each.

use crate::{GridError, KeptStrain, Moduli, Unknown, WearBy};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use gfmd_contact::{Boundary, Solver};
use gfmd_green::BaseKind;
use gfmd_interface::LimitingPressure;
use gfmd_measure::Gas;
use gfmd_medium::Relaxes;
use gfmd_surface::{Amplitudes, Fill, MotifEdges, Periodisation, RollOffShape};

/// A list of values that a library defines, each with a name and a meaning.
pub trait Choice: Copy + Send + Sync + 'static {
    /// Returns the values to choose from.
    fn all() -> &'static [Self];

    /// Returns the name on a command line and in the record of a run.
    fn name(self) -> &'static str;

    /// Returns the meaning in one line, for the help.
    fn meaning(self) -> &'static str;
}

macro_rules! choices {
    ($($type:ty: $all:expr;)+) => {$(
        impl Choice for $type {
            fn all() -> &'static [Self] {
                $all
            }

            fn name(self) -> &'static str {
                self.name()
            }

            fn meaning(self) -> &'static str {
                self.meaning()
            }
        }
    )+};
}

choices! {
    Amplitudes: Self::ALL;
    BaseKind: &Self::ALL;
    Boundary: &Self::ALL;
    Fill: Self::ALL;
    Gas: &Self::ALL;
    GridError: &Self::ALL;
    KeptStrain: &Self::ALL;
    Moduli: &Self::ALL;
    MotifEdges: Self::ALL;
    Periodisation: Self::ALL;
    Relaxes: &Self::ALL;
    RollOffShape: Self::ALL;
    Solver: &Self::ALL;
    LimitingPressure: &Self::ALL;
    Unknown: &Self::ALL;
    WearBy: &Self::ALL;
}

/// Parses the name of a choice; the help lists all names with their meanings.
pub fn parse_choice<T: Choice>() -> impl TypedValueParser<Value = T> {
    parse_choice_but(&[])
}

/// Parses the name of a choice; the help does not list the `refused` ones, which the command refuses with a reason.
pub fn parse_choice_but<T: Choice>(refused: &'static [&'static str]) -> impl TypedValueParser<Value = T> {
    let row = |value: &T| PossibleValue::new(value.name()).help(value.meaning()).hide(refused.contains(&value.name()));
    let rows = T::all().iter().map(row);
    PossibleValuesParser::new(rows).try_map(|name| {
        T::all().iter().copied().find(|value| value.name() == name).ok_or("it is not in the table of this flag")
    })
}

/// A choice in a configuration, by its name.
pub mod named {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    use super::Choice;

    /// Writes the name.
    ///
    /// # Errors
    /// Returns an error of the serialiser.
    pub fn serialize<T: Choice, S: Serializer>(choice: &T, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(choice.name())
    }

    /// Reads the name.
    ///
    /// # Errors
    /// Returns an error if no choice has this name.
    pub fn deserialize<'de, T: Choice, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
        let name = String::deserialize(deserializer)?;
        let allowed = || T::all().iter().map(|choice| choice.name()).collect::<Vec<_>>().join(", ");
        let found = T::all().iter().copied().find(|choice| choice.name() == name);
        found.ok_or_else(|| D::Error::custom(format!("it must be one of {}", allowed())))
    }
}

/// A choice in a configuration that may be absent, by its name.
pub mod named_if {
    use serde::{Deserializer, Serializer};

    use super::{Choice, named};

    /// Writes the name.
    ///
    /// # Errors
    /// Returns an error of the serialiser.
    pub fn serialize<T: Choice, S: Serializer>(choice: &Option<T>, serializer: S) -> Result<S::Ok, S::Error> {
        match choice {
            Some(choice) => named::serialize(choice, serializer),
            None => serializer.serialize_none(),
        }
    }

    /// Reads the name of a choice that is present.
    ///
    /// # Errors
    /// Returns an error if no choice has this name.
    pub fn deserialize<'de, T: Choice, D: Deserializer<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
        named::deserialize(deserializer).map(Some)
    }
}
