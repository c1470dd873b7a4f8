//! Readable units with an SI prefix that leaves one to three digits before the decimal point.

use std::fmt;

use crate::Dimension;

/// Readable unit.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayUnit {
    /// Factor from numbers of the problem to numbers in this unit.
    pub factor: f64,
    /// Name of the unit.
    pub name: String,
}

impl DisplayUnit {
    /// Formats a number of the problem in this unit, with up to six significant digits: `12.5 µm`.
    pub fn text(&self, value: f64) -> String {
        format!("{} {}", digits(value * self.factor), self.name)
    }

    /// Returns the name as a divisor, as in `length / µm`; in parentheses if it is a quotient itself.
    pub fn divisor(&self) -> String {
        if self.name.contains('/') { format!("({})", self.name) } else { self.name.clone() }
    }
}

/// Formats a number with up to six significant digits, a very small or large one with an exponent.
pub fn digits(value: f64) -> String {
    let decade = if value == 0.0 { 0.0 } else { value.abs().log10().floor() };
    match decade {
        -4.0..=5.0 => {
            let text = format!("{value:.*}", (5.0 - decade) as usize);
            if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
        }
        _ => format!("{:e}", format!("{value:.5e}").parse::<f64>().unwrap_or(value)),
    }
}

impl fmt::Display for DisplayUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

/// Prefixes in steps of a thousand, starting at 10^-15.
const PREFIXES: [&str; 10] = ["f", "p", "n", "µ", "m", "", "k", "M", "G", "T"];

/// Power of ten of the first prefix.
const FIRST_PREFIX_POWER: i32 = -15;

/// Returns the readable unit for numbers up to `largest` in a unit of `size` in Pa, m and s, or `None` without one.
pub(crate) fn of(dimension: Dimension, size: f64, largest: f64) -> Option<DisplayUnit> {
    // Times span many decades and are read in s.
    for (read, name) in
        [(Dimension { time: 1, ..Dimension::NONE }, "s"), (Dimension { temperature: 1, ..Dimension::NONE }, "K")]
    {
        if dimension == read {
            return Some(DisplayUnit { factor: size, name: name.into() });
        }
    }
    // Symbol that takes the prefix, its power, the rest of the name, and the size of the rest in SI.
    let (symbol, power, behind, over) = match (dimension.stress, dimension.length, dimension.time) {
        (1, 1, -1) if dimension.temperature == -1 => ("W", 1, "/(m² K)", 1.0),
        _ if dimension.temperature != 0 => return None,
        (0, power, 0) if power != 0 => ("m", power, "", 1.0),
        (power @ (1..=2 | -1), 0, 0) => ("Pa", power, "", 1.0),
        (1, 1, 0) => ("J", 1, "/m²", 1.0),
        (1, 2, 0) => ("N", 1, "", 1.0),
        (1, 3, 0) => ("J", 1, "", 1.0),
        (0, 1, -1) => ("m", 1, "/s", 1.0),
        // Leaks are read in ml/s.
        (0, 3, -1) => ("l", 1, "/s", 1e-3),
        (1, 1, -1) => ("W", 1, "/m²", 1.0),
        // Stress per length is shown per µm, which is more common than per metre.
        (1, -1, 0) => ("Pa", 1, "/µm", 1e6),
        _ => return None,
    };
    let value = largest.abs() * size / over;
    // Largest power of a thousand below the number, or below its root for a power of the unit.
    let root = value.log10() / f64::from(power) / 3.0;
    let thousands = match value.is_normal() {
        true if power > 0 => (root + 1e-9).floor() as i32,
        // An inverse unit leaves at least one: 1/µm for 10^6 to 10^9 per metre.
        true => (root - 1e-9).ceil() as i32,
        false => 0,
    };
    let index = (thousands - FIRST_PREFIX_POWER / 3).clamp(0, PREFIXES.len() as i32 - 1);
    let prefix = PREFIXES[index as usize];
    let tens = FIRST_PREFIX_POWER + 3 * index;
    let raised = match power.abs() {
        1 => "",
        2 => "²",
        3 => "³",
        _ => return None,
    };
    let name =
        if power < 0 { format!("1/{prefix}{symbol}{raised}") } else { format!("{prefix}{symbol}{raised}{behind}") };
    Some(DisplayUnit { factor: size / over * 10_f64.powi(-tens * power), name })
}

#[cfg(test)]
mod tests {
    use crate::Units;

    #[test]
    fn numbers_have_one_to_three_digits_before_the_point() {
        let shown = |units: [&str; 2], kind: &str, largest: f64| {
            let found = Units::new(Some(units[0]), Some(units[1])).shown(kind, largest).unwrap();
            (format!("{:.6}", largest * found.factor), found.name)
        };
        let si = ["m", "Pa"];
        for (units, kind, largest, text, name) in [
            (si, "stress", 7.1294e8, "712.940000", "MPa"),
            (si, "stress", 1e9, "1.000000", "GPa"),
            (si, "stress", 0.0, "0.000000", "Pa"),
            (si, "length", 3.2e-7, "320.000000", "nm"),
            (si, "length", 1e-6, "1.000000", "µm"),
            (["nm", "Pa"], "length", 3200.0, "3.200000", "µm"),
            (["nm", "Pa"], "stress*length", 0.05e9, "50.000000", "mJ/m²"),
            (["µm", "GPa"], "stress", 0.07, "70.000000", "MPa"),
            (si, "stress*length^2", 0.02, "20.000000", "mN"),
            (si, "stress/length", 3e14, "300.000000", "MPa/µm"),
            (si, "length^2", 4e-11, "40.000000", "µm²"),
            (si, "stress*length/time/temperature", 5e4, "50.000000", "kW/(m² K)"),
            (si, "length^3/time", 2.5e-6, "2.500000", "ml/s"),
            (["µm", "Pa"], "length^3/time", 7e6, "7.000000", "nl/s"),
            (si, "1/length", 2e6, "2.000000", "1/µm"),
            (si, "1/stress", 3e-15, "0.003000", "1/TPa"),
            (si, "1/stress", 2e-10, "200.000000", "1/TPa"),
            (si, "stress^2", 4e14, "400.000000", "MPa²"),
        ] {
            assert_eq!(shown(units, kind, largest), (text.into(), name.into()), "{kind} {largest}");
        }
        let found = Units::new(Some("m"), None);
        assert_eq!(found.shown("length", 1e-5).unwrap().text(1e-5), "10 µm");
        assert_eq!(found.shown("stress", 78.554_595_4e9).unwrap().text(78.554_595_4e9), "78.5546 GPa");
        assert_eq!(found.shown("stress/length", 1e15).unwrap().divisor(), "(GPa/µm)");
        assert!(Units::new(Some("nm"), None).shown("stress", 1.0).is_none());
        assert!(Units::new(Some("nm"), None).shown("length", 1.0).is_some());
        assert!(Units::default().shown("length", 1.0).is_none());
        assert!(Units::new(Some("m"), None).shown("1", 1.0).is_none());
    }
}
