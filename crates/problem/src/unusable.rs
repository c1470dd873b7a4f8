use std::fmt::{self, Display};
use std::ops::RangeInclusive;

use crate::{Spelling, Words, Written, key, words};

/// Error: input that cannot be used, with the value found and the allowed values, or with the reason.
///
/// Its text names options as flags; [`spelled`](Self::spelled) gives other spellings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unusable {
    /// The option, field or file; empty if `why` names it.
    pub name: Words,
    /// Value found.
    pub found: Option<String>,
    /// Allowed values.
    pub allowed: Option<Words>,
    /// Reason.
    pub why: Option<Words>,
}

impl Unusable {
    /// Returns the error of a value out of its range, "--dt is 2; it must be above 0 and below 1".
    pub fn value(name: impl Into<Words>, found: impl Display, allowed: impl Into<Words>) -> Self {
        Self { name: name.into(), found: Some(found.to_string()), allowed: Some(allowed.into()), why: None }
    }

    /// Returns the error of a value that contradicts other input, "--n is 64; with --eps-t-inv 2 ...".
    pub fn contradicts(name: impl Into<Words>, found: impl Display, why: impl Into<Words>) -> Self {
        Self { name: name.into(), found: Some(found.to_string()), allowed: None, why: Some(why.into()) }
    }

    /// Returns the error of an option that is left out, "--time is missing; it is needed with --prony".
    pub fn missing(name: &'static str, why: impl Into<Words>) -> Self {
        Self::contradicts(key(name), "missing", why)
    }

    /// Returns the error of an option, field or file, with the reason that a library states.
    pub fn input(name: impl Into<Words>, reason: impl Display) -> Self {
        Self { name: name.into(), found: None, allowed: None, why: Some(reason.to_string().into()) }
    }

    /// Returns the error of input in words that name it.
    pub fn of(words: impl Into<Words>) -> Self {
        Self { name: Words::default(), found: None, allowed: None, why: Some(words.into()) }
    }

    /// Puts the name of the option, field or file in front.
    #[must_use]
    pub fn at(self, name: impl Into<Words>) -> Self {
        Self { name: name.into(), ..self }
    }

    /// Adds the reason why other values are refused.
    #[must_use]
    pub fn because(self, why: impl Into<Words>) -> Self {
        Self { why: Some(why.into()), ..self }
    }

    /// Shows the found quantities of the option as they were written, not in the units of the problem.
    #[must_use]
    pub fn as_written(self, written: &Written) -> Self {
        let option = self.key().map(str::to_owned);
        let of = option.as_deref();
        let stays = written.has_others(of, &self.words().spelled(Spelling::Flag));
        let shown = |text: &str| written.replaced(of, text, stays);
        Self { found: self.found.as_deref().map(shown), why: self.why.map(|why| why.with_texts(shown)), ..self }
    }

    /// Returns the key of the option to which the error belongs.
    pub fn key(&self) -> Option<&str> {
        self.name.key().or_else(|| self.why.as_ref()?.key())
    }

    /// Returns the whole message.
    pub fn words(&self) -> Words {
        let (name, why) = (self.name.clone(), self.why.clone().unwrap_or_default());
        match (&self.found, self.allowed.clone(), &self.why) {
            (Some(found), Some(allowed), None) => words![name, format!(" is {found}; it must be "), allowed],
            (Some(found), Some(allowed), _) => {
                words![name, format!(" is {found}; it must be "), allowed, " (", why, ")"]
            }
            (Some(found), None, _) => words![name, format!(" is {found}; "), why],
            (None, ..) if name.is_empty() => why,
            (None, ..) => words![name, ": ", why],
        }
    }

    /// Returns the message with its options spelled as flags or as arguments.
    pub fn spelled(&self, spelling: Spelling) -> String {
        short(&self.words().spelled(spelling))
    }
}

impl Display for Unusable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.spelled(Spelling::Flag))
    }
}

impl std::error::Error for Unusable {}

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

/// Checks the size of the number of an option, which depends on its unit.
///
/// # Errors
/// Returns an error if the square of the size is too large or too small for a number.
pub fn check_size(option: &'static str, found: f64) -> Result<(), Unusable> {
    if SIZES.contains(&found) {
        return Ok(());
    }
    let allowed = "between 1e-140 and 1e140, which another unit makes it";
    Err(Unusable::value(key(option), format!("{found:e}"), allowed))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_numbers_are_short_in_messages() {
        let message = |found: f64| Unusable::value(key("young"), found, "positive").to_string();
        assert_eq!(message(1e300), "--young is 1e300; it must be positive");
        assert_eq!(message(-2.5e-300), "--young is -2.5e-300; it must be positive");
        assert_eq!(message(0.1), "--young is 0.1; it must be positive");
        assert_eq!(Unusable::input(key("out"), "a.b/c-1.2.3").to_string(), "--out: a.b/c-1.2.3");
    }

    #[test]
    fn messages_are_spelled_for_their_outlet() {
        let missing = Unusable::missing("base_young", words!["it is needed with ", crate::setting("base", "free")]);
        assert_eq!(missing.to_string(), "--base-young is missing; it is needed with --base free");
        assert_eq!(missing.spelled(Spelling::Argument), "base_young is missing; it is needed with base=\"free\"");
        assert_eq!(missing.key(), Some("base_young"));
        let value = Unusable::value(key("dt"), 2, "below 1").because("not implemented");
        assert_eq!(value.to_string(), "--dt is 2; it must be below 1 (not implemented)");
    }
}
