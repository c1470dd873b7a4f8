//! Accuracy requested for numbers.

use std::str::FromStr;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Largest relative grid error (95 %) allowed for a number: `0.01`, or `1%`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy(f64);

/// Error: text that is not an accuracy.
#[derive(Clone, Debug, thiserror::Error)]
#[error("it must be a relative error from 1e-6 to 0.5, such as 0.01 or 1%")]
pub struct AccuracyError;

impl Accuracy {
    /// Returns the relative error.
    pub fn relative(self) -> f64 {
        self.0
    }
}

impl FromStr for Accuracy {
    type Err = AccuracyError;

    fn from_str(text: &str) -> Result<Self, AccuracyError> {
        let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |percent| (percent, 0.01));
        let found = number.trim().parse::<f64>().ok().map(|number| number * unit);
        found.filter(|found| (1e-6..=0.5).contains(found)).map(Self).ok_or(AccuracyError)
    }
}

impl Serialize for Accuracy {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_f64(self.0)
    }
}

impl<'de> Deserialize<'de> for Accuracy {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Given {
            Number(f64),
            Text(String),
        }
        let text = match Given::deserialize(deserializer)? {
            Given::Number(number) => number.to_string(),
            Given::Text(text) => text,
        };
        text.parse().map_err(D::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_accuracy_is_a_part_or_a_percentage() {
        let parsed = |text: &str| text.parse::<Accuracy>().map(Accuracy::relative).ok();
        assert_eq!(["0.01", "1%", " 1 %", "0.5"].map(parsed), [Some(0.01), Some(0.01), Some(0.01), Some(0.5)]);
        assert_eq!(["0", "-1%", "2", "NaN", "inf", "", "%", "1e-7"].map(parsed), [None; 8]);
    }
}
