use std::borrow::Cow;

use serde::{Serialize, Serializer};

/// A number of a record, or the reason why there is none.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A number.
    Real(f64),
    /// A count.
    Count(u64),
    /// A flag, 1 or 0 in a file.
    Flag(bool),
    /// No value, and the reason: `null` in JSON, NaN in a file.
    Undefined(Cow<'static, str>),
}

impl Cell {
    /// No value, for this reason.
    pub fn undefined(reason: impl Into<Cow<'static, str>>) -> Self {
        Self::Undefined(reason.into())
    }

    /// The number in a file; NaN without a value.
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
