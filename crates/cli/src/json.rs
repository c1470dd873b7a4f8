//! JSON with every float at 17 significant digits, so that it reads back to the same bits.

use std::io;

use serde::Serialize;
use serde_json::ser::{CompactFormatter, Formatter, Serializer};

struct SeventeenDigits(CompactFormatter);

impl Formatter for SeventeenDigits {
    fn write_f64<W: ?Sized + io::Write>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        write!(writer, "{value:.16e}")
    }
}

/// Writes one JSON object on one line. Values that are not finite become `null`.
///
/// # Errors
/// An error of the serialisation of the value.
pub fn to_string(value: &impl Serialize) -> serde_json::Result<String> {
    let mut text = Vec::new();
    value.serialize(&mut Serializer::with_formatter(&mut text, SeventeenDigits(CompactFormatter)))?;
    String::from_utf8(text).map_err(serde::ser::Error::custom)
}

/// The keys that may be `null`, because the number has no meaning for some input (docs/interface.md). `[][]` are the
/// entries of matrices, which are infinite for the uniform mode of some bodies.
const NULLABLE: [&str; 35] = [
    "asked",
    "ci95",
    "coefficient_ci95",
    "compliance",
    "dissipated",
    "dissipated_error",
    "displacement_transfer",
    "energy",
    "exponent_ci95",
    "friction_coefficient",
    "hurst",
    "hurst_error",
    "interface_energy",
    "kappa_sem",
    "kappa_tfc_standard_error",
    "longest_wavelength",
    "lowest_curvature",
    "lowest_mean_pressure",
    "max_displacement",
    "max_von_mises",
    "mean_energy_density",
    "mixed_mode",
    "nayak",
    "normal_compliance",
    "normal_stiffness",
    "order",
    "out",
    "parted_at",
    "seam",
    "shortest_wavelength",
    "steps_to_1e8",
    "stick_fraction",
    "stiffness",
    "stress_transfer",
    "uncertainty",
];

/// The first key whose value is `null` although its number always has a meaning: the number is NaN or infinite.
pub fn undefined(report: &serde_json::Value) -> Option<&str> {
    fn find<'a>(key: &'a str, value: &'a serde_json::Value) -> Option<&'a str> {
        match value {
            serde_json::Value::Null => Some(key),
            serde_json::Value::Array(values) => values.iter().find_map(|value| find(key, value)),
            serde_json::Value::Object(entries) => {
                // With a law, the ratio of area to load is undefined if attraction carries the load.
                let with_law = entries.contains_key("interface_energy");
                let nullable = |key: &str| {
                    NULLABLE.contains(&key) || key == "unit" || with_law && ["kappa", "kappa_corrected"].contains(&key)
                };
                let mut entries = entries.iter().filter(|(key, _)| !nullable(key));
                entries.find_map(|(key, value)| find(key, value))
            }
            _ => None,
        }
    }
    find("the result", report)
}

#[cfg(test)]
mod tests {
    #[test]
    fn floats_have_seventeen_digits_and_read_back_to_the_same_bits() {
        for value in [0.1_f64, -1.0 / 3.0, 6.02e23, 5e-324, 0.0] {
            let text = super::to_string(&value).unwrap();
            assert_eq!(text.trim_start_matches('-').split('e').next().unwrap().len(), 18, "{text}");
            let back: f64 = serde_json::from_str(&text).unwrap();
            assert_eq!(back.to_bits(), value.to_bits());
        }
        assert_eq!(super::to_string(&[f64::NAN, f64::INFINITY]).unwrap(), "[null,null]");
    }

    #[test]
    fn numbers_that_are_not_finite_are_told_from_those_without_a_meaning() {
        let undefined = |text: &str| super::undefined(&serde_json::from_str(text).unwrap()).map(str::to_owned);
        assert_eq!(undefined(r#"{"loads":[{"kappa":1.0,"max_pressure":null}]}"#), Some("max_pressure".into()));
        assert_eq!(undefined(r#"{"length":[1.0,null],"unit":null}"#), Some("length".into()));
        assert_eq!(undefined(r#"{"loads":[{"kappa":null}]}"#), Some("kappa".into()));
        assert_eq!(undefined(r#"{"loads":[{"kappa":null,"interface_energy":1.0}],"nayak":null}"#), None);
    }
}
