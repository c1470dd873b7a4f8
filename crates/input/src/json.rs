//! JSON with every float at 17 significant digits, so that it reads back to the same bits.

use std::io;

use gfmd_record::reason_for;
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

/// The keys of numbers that have a value whatever the input: they are `null` only if they are NaN or infinite.
const ALWAYS: [&str; 40] = [
    "approach",
    "area_fraction",
    "area_fraction_corrected",
    "complementarity",
    "critical_eta",
    "dt",
    "e_star",
    "effective_width",
    "elastic_energy",
    "eta",
    "height",
    "highest",
    "load",
    "lowest",
    "m0",
    "m2",
    "m4",
    "max_pressure",
    "mean",
    "mean_gap",
    "mean_pressure",
    "mean_pressure_in_contact",
    "mean_shear",
    "mean_traction",
    "p_star",
    "peak_to_valley",
    "penetration",
    "predicted_rate",
    "pressure_deviation_in_contact",
    "pressure_moment_2",
    "rms_curvature",
    "rms_gradient",
    "rms_height",
    "rms_laplacian",
    "sa",
    "sdr",
    "size",
    "sp",
    "sv",
    "traction",
];

/// The first key of a number that is `null` although it always has a value: the number is NaN or infinite.
pub fn undefined(report: &serde_json::Value) -> Option<&str> {
    fn find<'a>(key: &'a str, value: &'a serde_json::Value) -> Option<&'a str> {
        match value {
            serde_json::Value::Null => ALWAYS.contains(&key).then_some(key),
            serde_json::Value::Array(values) => values.iter().find_map(|value| find(key, value)),
            serde_json::Value::Object(entries) => {
                // Any of them may be missing in the request for a surface and in the record of a search.
                let parts =
                    entries.iter().filter(|(key, _)| !["asked", "not_converged", "input"].contains(&key.as_str()));
                let missing = |key: &str| {
                    // Without a law the ratio of area to load is defined.
                    let ratio = key == "kappa" && entries.contains_key("contact_nodes");
                    ratio && !entries.contains_key("interface_energy")
                };
                let has_reason = |key: &str| reason_for(value, key).is_some();
                parts.into_iter().find_map(|(key, part)| match part {
                    serde_json::Value::Null if has_reason(key) => None,
                    serde_json::Value::Null if missing(key) => Some(key.as_str()),
                    part => find(key, part),
                })
            }
            _ => None,
        }
    }
    find("", report)
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
        assert_eq!(undefined(r#"{"size":[1.0,null],"unit":null}"#), Some("size".into()));
        assert_eq!(undefined(r#"{"loads":[{"kappa":null,"contact_nodes":1}]}"#), Some("kappa".into()));
        let with_law = r#"{"loads":[{"kappa":null,"contact_nodes":1,"interface_energy":1.0}],"nayak":null}"#;
        assert_eq!(undefined(with_law), None);
        for reasons in [r#"{"no level":["gap","approach"]}"#, r#"{"approach":"no level"}"#] {
            let with_reason = format!(r#"{{"loads":[{{"kappa":1.0,"approach":null,"undefined":{reasons}}}]}}"#);
            assert_eq!(undefined(&with_reason), None);
        }
        assert_eq!(undefined(r#"{"asked":{"rms_height":null},"new_key":null}"#), None);
    }
}
