use std::fmt::Display;
use std::ops::RangeInclusive;

/// Error: an option that cannot be used, with the value found and the allowed values, or with the reason.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct Unusable(String);

impl Unusable {
    /// Returns the error of a value out of its range, "--dt is 2; it must be above 0 and below 1".
    pub fn value(name: &str, found: impl Display, allowed: impl Display) -> Self {
        Self(short(&format!("{name} is {found}; it must be {allowed}")))
    }

    /// Returns the error of an option, field or file, with the reason that a library states.
    pub fn input(name: &str, reason: impl Display) -> Self {
        Self(short(&format!("{name}: {reason}")))
    }

    /// Returns the error of options that contradict each other, in words that name them.
    pub fn of(words: impl Into<String>) -> Self {
        Self(words.into())
    }
}

/// Largest number of digits before a number is written as a power of ten.
const MOST_DIGITS: usize = 24;

/// Rewrites very long numbers in a text, such as 1 followed by three hundred zeros, as powers of ten.
fn short(text: &str) -> String {
    let is_number = |c: char| c.is_ascii_digit() || c == '.';
    let mut words = Vec::new();
    for word in text.split_inclusive(|c: char| !is_number(c)) {
        let digits = word.trim_end_matches(|c: char| !is_number(c));
        let number: Option<f64> = if digits.len() > MOST_DIGITS { digits.parse().ok() } else { None };
        words.push(number.map_or_else(|| word.to_owned(), |number| format!("{number:e}{}", &word[digits.len()..])));
    }
    words.concat()
}

/// Sizes of moduli, lengths and stresses with squares that keep all digits.
pub const SIZES: RangeInclusive<f64> = 1e-140..=1e140;

/// Checks the size of a number, which depends on its unit.
///
/// # Errors
/// Returns an error if the square of the size is too large or too small for a number.
pub fn check_size(option: &str, found: f64) -> Result<(), Unusable> {
    if SIZES.contains(&found) {
        return Ok(());
    }
    Err(Unusable::value(option, format!("{found:e}"), "between 1e-140 and 1e140, which another unit makes it"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_numbers_are_short_in_messages() {
        let message = |found: f64| Unusable::value("--young", found, "positive").to_string();
        assert_eq!(message(1e300), "--young is 1e300; it must be positive");
        assert_eq!(message(-2.5e-300), "--young is -2.5e-300; it must be positive");
        assert_eq!(message(0.1), "--young is 0.1; it must be positive");
        assert_eq!(Unusable::input("--out", "a.b/c-1.2.3").to_string(), "--out: a.b/c-1.2.3");
    }
}
