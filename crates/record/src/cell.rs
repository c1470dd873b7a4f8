use std::borrow::Cow;

use serde::{Serialize, Serializer};

/// Number of a record, or the reason why there is none.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Real number.
    Real(f64),
    /// Count.
    Count(u64),
    /// Flag, 1 or 0 in a file.
    Flag(bool),
    /// Missing value with its reason: `null` in JSON, NaN in a file.
    Undefined(Cow<'static, str>),
}

impl Cell {
    /// Returns a cell without a value, for this reason.
    pub fn undefined(reason: impl Into<Cow<'static, str>>) -> Self {
        Self::Undefined(reason.into())
    }

    /// Returns the number in a file; NaN without a value.
    pub fn number(&self) -> f64 {
        match self {
            Self::Real(value) => *value,
            Self::Count(value) => *value as f64,
            Self::Flag(value) => f64::from(u8::from(*value)),
            Self::Undefined(_) => f64::NAN,
        }
    }
}

impl From<f64> for Cell {
    fn from(value: f64) -> Self {
        Self::Real(value)
    }
}

impl From<u64> for Cell {
    fn from(value: u64) -> Self {
        Self::Count(value)
    }
}

impl From<bool> for Cell {
    fn from(value: bool) -> Self {
        Self::Flag(value)
    }
}

impl<T: Into<Cell>, R: Into<Cow<'static, str>>> From<Result<T, R>> for Cell {
    fn from(value: Result<T, R>) -> Self {
        value.map_or_else(Self::undefined, Into::into)
    }
}

impl Serialize for Cell {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Real(value) => serializer.serialize_f64(*value),
            Self::Count(value) => serializer.serialize_u64(*value),
            Self::Flag(value) => serializer.serialize_bool(*value),
            Self::Undefined(_) => serializer.serialize_none(),
        }
    }
}
