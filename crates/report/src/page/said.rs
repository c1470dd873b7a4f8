//! Numbers of options and results in a page, with their units if known.

use gfmd_problem::options::{Kinds, KindsByKey};
use gfmd_unit::Units;
use maud::{Markup, html};
use toml::Value;

use super::write::{given, text};

/// Formats a number of a kind with its unit.
pub(crate) fn with_unit(value: f64, kind: &str, units: &Units) -> Markup {
    let (factor, unit) = unit_for(value, kind, units);
    html! { (given(value * factor)) (unit) }
}

/// Formats numbers of one kind with their unit after the last.
pub(crate) fn list(numbers: &[f64], kind: &str, units: &Units) -> Markup {
    let largest = numbers.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
    let (factor, unit) = unit_for(largest, kind, units);
    html! { (joined(numbers.iter().map(|value| given(value * factor)), ", ")) (unit) }
}

/// Returns the factor to the readable unit for numbers of a kind up to `largest`, and their suffix: a space and the
/// unit, or nothing if the unit is unknown.
pub(crate) fn unit_for(largest: f64, kind: &str, units: &Units) -> (f64, String) {
    match units.shown(kind, largest) {
        Some(unit) => (unit.factor, format!(" {}", unit.name)),
        None => {
            let name = units.name(kind);
            (1.0, if name == kind { String::new() } else { format!(" {}", plain(&name)) })
        }
    }
}

/// Returns the name of a unit in the usual notation.
pub(crate) fn plain(unit: &str) -> String {
    unit.replace('*', "·").replace("^2", "²")
}

/// Formats the value of the configuration option `key` with the units of its kinds.
pub(crate) fn option((key, all): (&str, &KindsByKey), value: &Value, units: &Units) -> Markup {
    numbers(Kinds::of(key, all), value, units)
}

fn numbers(kinds: Kinds, value: &Value, units: &Units) -> Markup {
    let kind = |column: usize, length: usize| kinds.in_row(column, length);
    match value {
        Value::String(words) => html! { (text(words)) },
        Value::Array(entries) => {
            let numbers: Option<Vec<f64>> = entries.iter().map(number).collect();
            match numbers {
                Some(numbers) if kinds.in_turn().len() == 1 => list(&numbers, kind(0, 1), units),
                Some(numbers) => {
                    let length = numbers.len();
                    let numbers = numbers.iter().enumerate();
                    joined(numbers.map(|(column, value)| with_unit(*value, kind(column, length), units)), ", ")
                }
                None => joined(entries.iter().map(|entry| row(kinds, entry, units)), "; "),
            }
        }
        value => match number(value) {
            Some(value) => with_unit(value, kind(0, 1), units),
            None => html! { (text(&value.to_string())) },
        },
    }
}

/// Formats a row of numbers of several kinds.
fn row(kinds: Kinds, entry: &Value, units: &Units) -> Markup {
    let Value::Array(entries) = entry else { return numbers(kinds, entry, units) };
    let cell = |(column, entry): (usize, &Value)| match number(entry) {
        Some(value) => with_unit(value, kinds.in_row(column, entries.len()), units),
        None => html! { (text(entry.as_str().unwrap_or_default())) },
    };
    joined(entries.iter().enumerate().map(cell), " : ")
}

fn number(value: &Value) -> Option<f64> {
    value.as_float().or(value.as_integer().map(|whole| whole as f64))
}

fn joined(parts: impl Iterator<Item = Markup>, between: &str) -> Markup {
    html! { @for (index, part) in parts.enumerate() { @if index > 0 { (between) } (part) } }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_have_their_units() {
        let kinds = KindsByKey::from([
            ("velocity", Kinds::VELOCITY),
            ("pressure", Kinds::STRESS),
            ("hardness", Kinds::HARDNESS),
            ("prony", Kinds::PRONY),
            ("coefficient", Kinds::WEAR),
            ("lateral", Kinds::LENGTH),
            ("second_body", Kinds::LAYER),
            ("heat", Kinds::HEAT),
        ]);
        let said = |units: &Units, line: &str| {
            let (key, value) = line.parse::<toml::Table>().unwrap().into_iter().next().unwrap();
            option((&*key, &kinds), &value, units).into_string()
        };
        let (si, none) = (Units::new(Some("m"), Some("Pa")), Units::default());
        for (line, known, unknown) in [
            ("velocity = [1.0, 9.999999999999998]", "1, 10 m/s", "1, 10"),
            ("velocity = [0.001, 0.01]", "1, 10 mm/s", "0.001, 0.01"),
            ("pressure = [1e4, 2e4]", "10, 20 kPa", "10000, 20000"),
            ("hardness = 2e9", "2 GPa", "2 × 10<sup>9</sup>"),
            ("hardness = \"h.npy\"", "h.npy", "h.npy"),
            ("prony = [[0.1, 0.5], [10.0, 0.25]]", "0.1 s : 0.5; 10 s : 0.25", "0.1 : 0.5; 10 : 0.25"),
            ("coefficient = 1e-12", "1 1/TPa", "10<sup>−12</sup>"),
            ("lateral = [0.0, -2e-9]", "0, −2 nm", "0, −2 × 10<sup>−9</sup>"),
            ("second_body = [3e9, 0.3, 2e-6]", "3 GPa, 0.3, 2 µm", "3 × 10<sup>9</sup>, 0.3, 2 × 10<sup>−6</sup>"),
            ("heat = [0.2, 1e-7]", "0.2 Pa·m²/s/K, 10<sup>−7</sup> m²/s", "0.2, 10<sup>−7</sup>"),
            ("p_star = [0.05]", "0.05", "0.05"),
            ("steps = 8", "8", "8"),
        ] {
            assert_eq!((said(&si, line).as_str(), said(&none, line).as_str()), (known, unknown), "{line}");
        }
    }
}
