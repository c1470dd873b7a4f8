//! The law across the gap.

use clap::Args;
use gfmd_law::{Kind, Law, LawError};
use serde::{Deserialize, Serialize};

use super::without_flags;
use crate::Unusable;

/// Flags that choose a law.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Interface law")]
pub struct LawArgs {
    /// Law of the tractions across the gap: hard-wall, xu-needleman, bsg, c3d, npb, npc, morse, exponential,
    /// harmonic-cosine, dugdale (docs/laws)
    #[arg(long, default_value = "hard-wall", value_parser = parse_kind, value_name = "NAME")]
    #[serde(with = "name")]
    pub law: Kind,
    /// Parameter of the law, NAME=VALUE; give the flag once for each parameter
    #[arg(long = "param", value_parser = parse_parameter, value_delimiter = ',', value_name = "NAME=VALUE", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub param: Vec<(String, f64)>,
    /// Solve a law whose process zone, at the edge of a contact, is narrower than a tenth of a grid step: single points jump
    #[arg(long)]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub coarse: bool,
}

impl Default for LawArgs {
    fn default() -> Self {
        without_flags()
    }
}

impl LawArgs {
    /// The law with a range that is `factor` times as long, and the same work. `None` for a law without a range.
    ///
    /// # Errors
    /// A parameter out of its range.
    pub fn with_range(&self, factor: f64) -> Result<Option<Box<dyn Law>>, Unusable> {
        let mut longer = self.clone();
        let Some((_, range)) = longer.param.iter_mut().find(|(name, _)| name == "range") else { return Ok(None) };
        *range *= factor;
        longer.build().map(Some)
    }

    /// Makes the law.
    ///
    /// # Errors
    /// A parameter that is unknown, missing or out of its range.
    pub fn build(&self) -> Result<Box<dyn Law>, Unusable> {
        self.law.with(&self.param).map_err(|error| Unusable::input("--param", error))
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
    use gfmd_law::Kind;
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
    pub(super) fn serialize<S: Serializer>(kind: &Kind, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(kind.name())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Kind, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }
}
