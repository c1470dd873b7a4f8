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
}
