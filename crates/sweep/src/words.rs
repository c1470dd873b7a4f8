//! Fields of a configuration that are a number or a word.

use std::fmt;

use gfmd_contact::Solver;
use gfmd_green::{BaseKind, Height};
use serde::de::{Deserializer, Error, Visitor};
use serde::{Deserialize, Serialize, Serializer};

use crate::Alpha;

/// Visitor that accepts a number or one of `words`.
struct NumberOr<T: 'static> {
    words: &'static [(&'static str, T)],
    number: fn(f64) -> T,
}

impl<T: Copy> Visitor<'_> for NumberOr<T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number")?;
        self.words.iter().try_for_each(|(word, _)| write!(f, " or {word:?}"))
    }

    fn visit_f64<E: Error>(self, number: f64) -> Result<T, E> {
        Ok((self.number)(number))
    }

    fn visit_i64<E: Error>(self, number: i64) -> Result<T, E> {
        Ok((self.number)(number as f64))
    }

    fn visit_str<E: Error>(self, found: &str) -> Result<T, E> {
        let word = self.words.iter().find(|(word, _)| *word == found);
        word.map(|(_, value)| *value).ok_or_else(|| E::invalid_value(serde::de::Unexpected::Str(found), &self))
    }
}

impl<'de> Deserialize<'de> for Alpha {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let words =
            &[("free", Self::Free), ("none", Self::Without), ("self-affine", Self::SelfAffine), ("edge", Self::Edge)];
        deserializer.deserialize_any(NumberOr { words, number: Self::Fixed })
    }
}

impl Serialize for Alpha {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Fixed(alpha) => serializer.serialize_f64(*alpha),
            word => serializer.serialize_str(word.word()),
        }
    }
}

/// Format of a body height: a number or `"inf"`.
pub(crate) mod height {
    use super::*;

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Height, D::Error> {
        deserializer.deserialize_any(NumberOr { words: &[("inf", Height::Infinite)], number: Height::Finite })
    }

    pub(crate) fn serialize<S: Serializer>(height: &Height, serializer: S) -> Result<S::Ok, S::Error> {
        match height {
            Height::Finite(height) => serializer.serialize_f64(*height),
            Height::Infinite => serializer.serialize_str("inf"),
        }
    }
}

/// Format of a base: its name.
pub(crate) mod base {
    use super::*;

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<BaseKind, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }

    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
    pub(crate) fn serialize<S: Serializer>(base: &BaseKind, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(base.name())
    }
}

/// Format of a solver: its name.
pub(crate) mod solver {
    use super::*;

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Solver, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(D::Error::custom)
    }

    pub(crate) fn serialize<S: Serializer>(solver: &Solver, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(solver.name())
    }
}
