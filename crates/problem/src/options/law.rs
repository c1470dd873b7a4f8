//! The law across the gap.

use clap::Args;
use gfmd_law::{Law, LawError, LawKind as Kind, Tabulated};
use serde::{Deserialize, Serialize};

use super::values::parse_row;
use crate::options::{Kinds, Options};
use crate::{Unusable, key, setting, words};

/// The largest number of rows of a table.
pub(super) const LONGEST_TABLE: usize = 1000;

/// Flags that choose a law.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Interface law")]
pub struct LawArgs {
    /// Traction-separation law, one of [`Kind::ALL`].
    #[arg(
        long,
        default_value_t = Kind::HardWall,
        value_parser = parse_kind,
        value_name = "NAME",
        help = format!("Traction-separation law: {} (docs/laws)", Kind::names(|_| true))
    )]
    #[serde(with = "name")]
    pub law: Kind,
    /// Parameter of the law, NAME=VALUE; repeatable
    #[arg(
        long = "param",
        value_parser = parse_parameter,
        value_delimiter = ',',
        value_name = "NAME=VALUE",
        allow_hyphen_values = true
    )]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::PARAMETERS)]
    pub param: Vec<(String, f64)>,
    /// Table of the law `table`: FILE with the columns gap and traction, attraction positive, whose heads may have
    /// units, such as gap_nm or traction_MPa; or rows GAP:TRACTION,...
    #[arg(long, value_parser = parse_row, value_delimiter = ',', value_name = "FILE|ROWS", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::LAW_TABLE)]
    pub law_table: Vec<[f64; 2]>,
    /// Solve even if the process zone at a contact edge is narrower than a tenth of a grid step: single points then
    /// jump
    #[arg(long)]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub coarse: bool,
}

impl LawArgs {
    /// Returns the law with a range `factor` times as long and the same work; `None` for a law without a range.
    ///
    /// # Errors
    /// Returns an error if a parameter is out of range.
    pub fn with_range(&self, factor: f64) -> Result<Option<Box<dyn Law>>, Unusable> {
        let mut longer = self.clone();
        match longer.param.iter_mut().find(|(name, _)| name == "range") {
            Some((_, range)) => *range *= factor,
            None if self.law == Kind::Table => {
                longer
                    .law_table
                    .iter_mut()
                    .for_each(|[gap, traction]| (*gap, *traction) = (*gap * factor, *traction / factor));
            }
            None => return Ok(None),
        }
        longer.build().map(Some)
    }

    /// Builds the law.
    ///
    /// # Errors
    /// Returns an error if a parameter is unknown, missing or out of range, or a table is invalid or not for this law.
    pub fn build(&self) -> Result<Box<dyn Law>, Unusable> {
        if let Some(table) = self.tabulated()? {
            return Ok(Box::new(table));
        }
        self.law.with(&self.param).map_err(|error| Unusable::input(key("param"), error))
    }

    /// Returns the work of separation, stress × length; `None` for a law without one.
    pub(crate) fn work(&self) -> Option<f64> {
        let named = |name: &str| self.param.iter().find(|(other, _)| other == name).map(|(_, value)| *value);
        let of_table = || self.tabulated().ok().flatten().map(|table| table.work());
        named("gamma").or_else(|| named("phi_n")).or_else(of_table)
    }

    /// Returns the law of the table; `None` for other laws.
    fn tabulated(&self) -> Result<Option<Tabulated>, Unusable> {
        const TABLE: &str = "law_table";
        match (self.law, self.param.first(), self.law_table.len()) {
            (Kind::Table, Some((name, _)), _) => Err(Unusable::value(
                key("param"),
                name,
                words!["left out with ", setting("law", "table"), ", which has its rows"],
            )),
            (Kind::Table, None, 0) => Err(Unusable::input(key(TABLE), LawError::NoTable)),
            (Kind::Table, None, rows) if rows > LONGEST_TABLE => {
                Err(Unusable::value(key(TABLE), format!("{rows} rows"), format!("at most {LONGEST_TABLE}")))
            }
            (Kind::Table, None, _) => {
                Tabulated::new(&self.law_table).map(Some).map_err(|error| Unusable::input(key(TABLE), error))
            }
            (_, _, 0) => Ok(None),
            (law, ..) => {
                let (own, table) = (setting("law", law.name()), setting("law", "table"));
                Err(Unusable::value(key(TABLE), "given", words!["left out with ", own, "; ", table, " has it"]))
            }
        }
    }
}

fn parse_kind(name: &str) -> Result<Kind, LawError> {
    name.parse()
}

fn parse_parameter(text: &str) -> Result<(String, f64), String> {
    let wrong = || "it must be NAME=VALUE".to_owned();
    let (name, value) = text.split_once('=').ok_or_else(wrong)?;
    Ok((name.to_owned(), value.parse().map_err(|_| wrong())?))
}

/// A law in a configuration, by its name.
mod name {
    use gfmd_law::LawKind as Kind;
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
    pub(super) fn serialize<S: Serializer>(kind: &Kind, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(kind.name())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Kind, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}
