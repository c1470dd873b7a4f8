//! Lists of numbers on the command line.

use std::fmt::Display;
use std::str::FromStr;

use serde::de::{Error, IgnoredAny};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The largest number of values of one entry.
const MOST: usize = 10_000;

/// One entry of a list: a number, or `A:B:N`, which is N numbers from A to B in geometric steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry(Vec<f64>);

impl FromStr for Entry {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parts: Vec<&str> = text.split(':').map(str::trim).collect();
        let number = |part: &str| part.parse::<f64>().map_err(|error| format!("{part:?}: {error}"));
        let [first, last, count] = parts[..] else {
            return match parts[..] {
                [_] => Ok(Self(vec![text.parse::<f64>().map_err(|error| error.to_string())?])),
                _ => Err("must be a number, or A:B:N, which is N numbers from A to B in geometric steps".into()),
            };
        };
        let (first, last) = (number(first)?, number(last)?);
        let usable = |value: f64| value.is_finite() && value != 0.0;
        if !(usable(first) && usable(last) && first.signum() == last.signum()) {
            return Err(format!("from {first} to {last}; both must be finite, not zero, and of one sign"));
        }
        let count = count.parse().ok().filter(|count| (2..=MOST).contains(count));
        let count: usize =
            count.ok_or_else(|| format!("N is {}; it must be a whole number from 2 to {MOST}", parts[2]))?;
        let steps = (count - 1) as f64;
        let values: Vec<f64> = (0..count)
            .map(|k| match k {
                0 => first,
                _ if k == count - 1 => last,
                _ => first * (last / first).powf(k as f64 / steps),
            })
            .collect();
        if values.iter().all(|value| usable(*value)) {
            Ok(Self(values))
        } else {
            Err(format!("from {first} to {last}; their ratio must be a finite number"))
        }
    }
}

/// Returns the numbers of all entries.
pub fn numbers(entries: &[Entry]) -> impl Iterator<Item = f64> {
    entries.iter().flat_map(|entry| entry.0.iter().copied())
}

/// Writes the numbers of all entries, as if each had been given.
///
/// # Errors
/// Returns an error of the serialiser.
pub fn as_numbers<S: Serializer>(entries: &[Entry], serializer: S) -> Result<S::Ok, S::Error> {
    numbers(entries).collect::<Vec<f64>>().serialize(serializer)
}

/// Reads numbers as single entries.
///
/// # Errors
/// Returns an error if the value is not a list of numbers.
pub fn from_numbers<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<Entry>, D::Error> {
    Ok(Vec::<f64>::deserialize(deserializer)?.into_iter().map(|number| Entry(vec![number])).collect())
}

/// Reads a list of one to `MOST` values.
///
/// # Errors
/// Returns an error for a list of another length.
pub fn up_to<'de, const MOST: usize, T: Deserialize<'de>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<T>, D::Error> {
    let values = Vec::deserialize(deserializer)?;
    match values.len() {
        1.. if values.len() <= MOST => Ok(values),
        found => Err(D::Error::custom(format!("it has {found} values; it must have 1 to {MOST}"))),
    }
}

/// Reads a value from its text.
///
/// # Errors
/// Returns an error if the text is not a value.
pub fn parsed<'de, T: FromStr<Err: Display>, D: Deserializer<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    String::deserialize(deserializer)?.parse().map(Some).map_err(D::Error::custom)
}

/// Reads a whole number from `LEAST` to `MOST`.
///
/// # Errors
/// Returns an error for any other number.
pub fn within<'de, const LEAST: u64, const MOST: u64, T: TryFrom<u64>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<T, D::Error> {
    let found = u64::deserialize(deserializer)?;
    let number = T::try_from(found).ok().filter(|_| (LEAST..=MOST).contains(&found));
    number.ok_or_else(|| D::Error::custom(format!("it must be a whole number from {LEAST} to {MOST}")))
}

/// Writes a list of one value as this value.
///
/// # Errors
/// Returns an error of the serialiser.
pub fn one_or_list<T: Serialize, S: Serializer>(values: &[T], serializer: S) -> Result<S::Ok, S::Error> {
    if let [one] = values { one.serialize(serializer) } else { values.serialize(serializer) }
}

/// Reads one whole number from `LEAST` to `MOST`, or a list of such numbers.
///
/// # Errors
/// Returns an error for anything else, and for an empty list.
pub fn one_or_all_within<'de, const LEAST: u64, const MOST: u64, T: TryFrom<u64>, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<T>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Form {
        One(u64),
        List(Vec<u64>),
        Other(IgnoredAny),
    }
    let found = match Form::deserialize(deserializer)? {
        Form::One(number) => vec![number],
        Form::List(numbers) => numbers,
        Form::Other(_) => Vec::new(),
    };
    let one = |number: u64| T::try_from(number).ok().filter(|_| (LEAST..=MOST).contains(&number));
    let numbers: Option<Vec<T>> = found.into_iter().map(one).collect();
    let wrong = || D::Error::custom(format!("it must be a whole number from {LEAST} to {MOST}, or a list of them"));
    numbers.filter(|numbers| !numbers.is_empty()).ok_or_else(wrong)
}

/// Parses a row of two numbers, `A:B`.
///
/// # Errors
/// Returns an error for any other text.
pub(super) fn parse_row(text: &str) -> Result<[f64; 2], String> {
    let wrong = || "it must be FILE, or rows A:B".to_owned();
    let (first, second) = text.split_once(':').ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse().map_err(|_| wrong());
    Ok([number(first)?, number(second)?])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Vec<f64>, String> {
        text.split(',').map(str::parse).collect::<Result<Vec<Entry>, _>>().map(|entries| numbers(&entries).collect())
    }

    #[test]
    fn steps_are_geometric_and_the_ends_exact() {
        assert_eq!(parsed("0.3").unwrap(), [0.3]);
        assert_eq!(parsed("0.1:0.7:2,5").unwrap(), [0.1, 0.7, 5.0]);
        let down = parsed("-3:-0.007:9").unwrap();
        assert_eq!((down[0], down[8]), (-3.0, -0.007));
        assert!(down.windows(2).all(|pair| pair[0] < pair[1]));
        let ratios: Vec<f64> = down.windows(2).map(|pair| pair[1] / pair[0]).collect();
        assert!(ratios.iter().all(|ratio| (ratio / ratios[0] - 1.0).abs() < 1e-13), "{ratios:?}");
        approx::assert_relative_eq!(parsed("1e-3:1:4").unwrap()[2], 0.1, max_relative = 1e-14);
    }

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Counts {
        #[serde(serialize_with = "one_or_list", deserialize_with = "one_or_all_within::<1, 9, _, _>")]
        count: Vec<u32>,
    }

    #[test]
    fn one_number_or_a_list_is_read_as_it_is_written() {
        for text in ["count = 7\n", "count = [7, 1]\n"] {
            assert_eq!(toml::to_string(&toml::from_str::<Counts>(text).unwrap()).unwrap(), text);
        }
        assert_eq!(toml::from_str::<Counts>("count = [7]").unwrap(), Counts { count: vec![7] });
        for wrong in ["0", "10", "-1", "1.5", "'x'", "[]", "[1, 0]", "[1, 'x']", "[[1]]"] {
            let error = toml::from_str::<Counts>(&format!("count = {wrong}")).unwrap_err().to_string();
            assert!(error.contains("it must be a whole number from 1 to 9, or a list of them"), "{wrong}: {error}");
        }
    }

    #[test]
    fn what_is_no_list_says_why() {
        let refused = [
            ("x", "invalid float"),
            ("1:2", "A:B:N"),
            ("1:2:3:4", "A:B:N"),
            ("0:1:3", "not zero"),
            ("1:0:3", "not zero"),
            ("-1:1:3", "of one sign"),
            ("1:inf:3", "finite"),
            ("nan:1:3", "finite"),
            ("1:2:1", "from 2"),
            ("1:2:1e3", "from 2"),
            ("1:2:99999999999", "from 2"),
            ("1e-300:1e300:3", "ratio"),
            ("1:y:3", "\"y\""),
        ];
        for (text, reason) in refused {
            assert!(parsed(text).is_err_and(|error| error.contains(reason)), "{text}: {:?}", parsed(text));
        }
    }
}
