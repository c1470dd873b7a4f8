//! Numbers in a page.

use gfmd_files::legible;
use maud::{Markup, html};

/// Formats a number with five significant digits; a dash for NaN.
pub(crate) fn number(value: f64) -> Markup {
    with_digits(value, 5)
}

/// Formats a number with `digits` significant digits; very large and very small ones as powers of ten.
fn with_digits(value: f64, digits: usize) -> Markup {
    if !value.is_finite() {
        return html! { "–" };
    }
    let scientific = format!("{value:.*e}", digits - 1);
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let power: i32 = exponent.parse().unwrap_or(0);
    if value == 0.0 || (-3..6).contains(&power) {
        let decimals = usize::try_from(digits as i32 - 1 - power).unwrap_or(0);
        let text = if value == 0.0 { "0".into() } else { format!("{value:.decimals$}") };
        return html! { (text.replace('-', "−")) };
    }
    html! { (mantissa.replace('-', "−")) " × 10" sup { (power.to_string().replace('-', "−")) } }
}

/// Formats a number of a text table with a superscript power of ten.
pub(crate) fn powers(shown: &str) -> Markup {
    let shown = shown.replace('-', "−");
    match shown.split_once('e') {
        Some((mantissa, power)) => {
            let (power, rough) = power.strip_suffix('~').map_or((power, ""), |power| (power, "~"));
            html! { (mantissa) " × 10" sup { (power) } (rough) }
        }
        None => html! { (shown) },
    }
}

/// Formats a given number with its own digits, at most six.
pub(crate) fn given(value: f64) -> Markup {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    if !rounded.is_finite() {
        return html! { "–" };
    }
    if rounded == 0.0 {
        return html! { "0" };
    }
    if (1e-3..1e6).contains(&rounded.abs()) {
        return html! { (rounded.to_string().replace('-', "−")) };
    }
    let scientific = format!("{rounded:e}").replace('-', "−");
    let (mantissa, power) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    html! { @if mantissa != "1" { (mantissa) " × " } "10" sup { (power) } }
}

/// Formats the number of transform pairs; several small transforms count as a fraction.
pub(crate) fn transforms(count: f64) -> Markup {
    if count.is_finite() && count.fract() != 0.0 {
        html! { (format!("{count:.1}")) }
    } else {
        whole(count)
    }
}

/// Formats a count.
pub(crate) fn whole(value: f64) -> Markup {
    if value.is_finite() {
        html! { (format!("{value:.0}")) }
    } else {
        html! { "–" }
    }
}

/// Formats an interval; a dash if there is none.
pub(crate) fn interval([low, high]: [f64; 2]) -> Markup {
    if !(low.is_finite() && high.is_finite()) {
        return html! { "–" };
    }
    html! { "[" (with_digits(low, 4)) ", " (with_digits(high, 4)) "]" }
}

/// Longest text of a file in a page, in characters.
const LONGEST: usize = 20_000;

/// Returns a text with a capital letter at its start.
pub(crate) fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// Makes a text of a file safe for a page: removes control characters and truncates it if it is too long.
pub(crate) fn text(found: &str) -> String {
    let end = found.char_indices().nth(LONGEST).map_or(found.len(), |(end, _)| end);
    let (start, rest) = found.split_at(end);
    let mut text = legible::lines(start);
    let rest = rest.chars().count();
    if rest > 0 {
        text.push_str(&format!("… ({rest} more characters)"));
    }
    text
}

/// Returns a number of a configuration; NaN if it has no number of this name.
pub(crate) fn of(table: &toml::Table, name: &str) -> f64 {
    let value = table.get(name).and_then(|value| value.as_float().or(value.as_integer().map(|i| i as f64)));
    value.unwrap_or(f64::NAN)
}

/// Quotes a word of a command for a shell.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.into();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_their_digits_and_no_meaning_is_a_dash() {
        let shown = |value: f64| number(value).into_string();
        assert_eq!(shown(2.250_04), "2.2500");
        assert_eq!(shown(-0.012_345_6), "−0.012346");
        assert_eq!(shown(123_456.7), "123457");
        assert_eq!(shown(0.0), "0");
        assert_eq!(shown(1.234_56e-9), "1.2346 × 10<sup>−9</sup>");
        assert_eq!(shown(-9.999_999e11), "−1.0000 × 10<sup>12</sup>");
        assert_eq!(shown(f64::NAN), "–");
        assert_eq!(interval([1.0, f64::INFINITY]).into_string(), "–");
        assert_eq!(interval([2.2431, 2.2562]).into_string(), "[2.243, 2.256]");
        let asked = |value: f64| given(value).into_string();
        assert_eq!([0.1, 256.0, 0.0, -0.0, -1.27].map(asked), ["0.1", "256", "0", "0", "−1.27"]);
        assert_eq!(
            [1e-8, 7e10, 0.1 + 0.2, f64::NAN].map(asked),
            ["10<sup>−8</sup>", "7 × 10<sup>10</sup>", "0.3", "–"]
        );
        assert_eq!([45.0, 45.5, f64::NAN].map(|count| transforms(count).into_string()), ["45", "45.5", "–"]);
        assert_eq!(whole(12.0).into_string(), "12");
    }

    #[test]
    fn texts_of_a_file_neither_steer_the_display_nor_fill_the_page() {
        assert_eq!(text("a\u{0}b\u{202e}c\nd"), "a\u{fffd}b\u{fffd}c\nd");
        let long = text(&"é".repeat(LONGEST + 7));
        assert!(long.ends_with("… (7 more characters)") && long.chars().count() < LONGEST + 40);
    }

    #[test]
    fn words_of_a_command_are_quoted_for_a_shell() {
        assert_eq!(quoted("--p-star=0.01,0.02"), "--p-star=0.01,0.02");
        assert_eq!(quoted("it's; rm"), r"'it'\''s; rm'");
        assert_eq!(quoted(""), "''");
    }
}
