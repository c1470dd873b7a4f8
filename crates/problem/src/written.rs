//! Quantities as they were written, for messages about the numbers in their place.

/// Quantities of options as they were written, and the numbers in their place.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Written(Vec<(String, String, f64)>);

/// Characters of numbers.
fn is_of_number(c: char) -> bool {
    c.is_ascii_digit() || "+-.eE".contains(c)
}

/// Returns the pieces of a text; numbers have their value.
fn pieces(text: &str) -> Vec<(&str, Option<f64>)> {
    let (mut pieces, mut rest, mut is_in_word) = (Vec::new(), text, false);
    while let Some(first) = rest.chars().next() {
        let run = &rest[..rest.find(|c| !is_of_number(c)).unwrap_or(rest.len())];
        let number = (1..=run.len()).rev().find_map(|end| Some((end, run[..end].parse().ok()?)));
        let (end, value) = match number.filter(|_| !is_in_word) {
            Some((end, value)) => (end, Some(value)),
            None => (first.len_utf8(), None),
        };
        pieces.push((&rest[..end], value));
        rest = &rest[end..];
        is_in_word = value.is_some() || first.is_alphanumeric() || "_.-".contains(first);
    }
    pieces
}

impl Written {
    /// Adds a quantity of an option with its number.
    pub fn add(&mut self, option: &str, text: &str, number: f64) {
        self.0.push((option.to_owned(), text.to_owned(), number));
    }

    /// Returns the quantity of an option, or of any, that has this number.
    fn quantity(&self, option: Option<&str>, number: f64) -> Option<&str> {
        let mut of = self.0.iter().filter(|(key, ..)| option.is_none_or(|option| option == key));
        of.find(|(.., other)| *other == number).map(|(_, text, _)| &**text)
    }

    /// Returns true if a text has a number other than zero that was not written with a unit for this option.
    pub(crate) fn has_others(&self, option: Option<&str>, text: &str) -> bool {
        let numbers = pieces(text).into_iter().filter_map(|(_, number)| number);
        numbers.into_iter().any(|number| number != 0.0 && self.quantity(option, number).is_none())
    }

    /// Returns a text with the quantities of an option as they were written; before their numbers if these must stay.
    pub(crate) fn replaced(&self, option: Option<&str>, text: &str, stays: bool) -> String {
        let piece = |(piece, number): (&str, Option<f64>)| match number.and_then(|of| self.quantity(option, of)) {
            Some(written) if stays => format!("{written} = {piece}"),
            Some(written) => written.to_owned(),
            None => piece.to_owned(),
        };
        pieces(text).into_iter().map(piece).collect()
    }

    /// Returns a message with all quantities as they were written.
    pub fn in_text(&self, text: &str) -> String {
        self.replaced(None, text, false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Unusable, key};

    #[test]
    fn messages_have_quantities_as_they_were_written() {
        let mut written = Written::default();
        for (option, text, number) in [("force", "-5N", -5e12), ("size", "-1 mm", -1000.0), ("filter", "2um", 2.0)] {
            written.add(option, text, number);
        }
        let said = |unusable: Unusable| unusable.as_written(&written).to_string();
        let value = |option: &'static str, found: f64| said(Unusable::value(key(option), found, "positive"));
        assert_eq!(value("force", -5e12), "--force is -5N; it must be positive");
        // The number of another option, and another number of this option.
        assert_eq!(value("young", -1000.0), "--young is -1000; it must be positive");
        assert_eq!(value("size", -1.0), "--size is -1; it must be positive");
        let both = Unusable::input(key("size"), "the lengths are [-1000.0, -1e3]; they must be above 0");
        assert_eq!(said(both), "--size: the lengths are [-1 mm, -1 mm]; they must be above 0");
        // Numbers in the units of the problem stand beside others of these.
        let range = Unusable::input(key("filter"), "the index of s2 is 2; it must be between 6.25, two steps, and 100");
        let found = "--filter: the index of s2 is 2um = 2; it must be between 6.25, two steps, and 100";
        assert_eq!(said(range), found);
        assert_eq!(written.in_text("invalid value 's:R=2e0' for '--shape'"), "invalid value 's:R=2um' for '--shape'");
    }
}
