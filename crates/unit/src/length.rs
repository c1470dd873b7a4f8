//! Units of length and the factors between them.

use std::fmt;

/// Unit of length of size count·10^power metres. The first spelling is used in output.
pub(crate) struct Unit {
    spellings: &'static [&'static str],
    pub(crate) count: u32,
    pub(crate) power: i32,
}

const fn metric(spellings: &'static [&'static str], power: i32) -> Unit {
    Unit { spellings, count: 1, power }
}

/// Known units of length. Instruments write `um` with either letter mu, `~m`, and the variants of Å.
const UNITS: [Unit; 11] = [
    metric(&["m", "meter", "metre", "meters", "metres"], 0),
    metric(&["km"], 3),
    metric(&["cm"], -2),
    metric(&["mm", "millimeter", "millimetre"], -3),
    metric(&["µm", "μm", "um", "~m", "micron", "microns", "micrometer", "micrometre"], -6),
    metric(&["nm", "nanometer", "nanometre"], -9),
    metric(&["Å", "\u{212b}", "Ang", "Angstrom", "angstrom", "Angstroem"], -10),
    metric(&["pm"], -12),
    metric(&["fm"], -15),
    Unit { spellings: &["in", "inch"], count: 254, power: -4 },
    Unit { spellings: &["mil"], count: 254, power: -7 },
];

pub(crate) fn find(name: &str) -> Option<&'static Unit> {
    UNITS.iter().find(|unit| unit.spellings.contains(&name))
}

/// Returns true if `name` is a known unit of length.
pub fn is_length(name: &str) -> bool {
    find(name.trim()).is_some()
}

/// Returns the name of a unit as written in output; an unknown name is returned unchanged.
pub fn canonical(name: &str) -> &str {
    find(name.trim()).map_or(name, |unit| unit.spellings[0])
}

/// Conversion factor between two units, a quotient of two integers. One of them is 1 between metric units, so that a
/// conversion has one rounding error.
#[derive(Clone, Debug, PartialEq)]
pub struct Conversion {
    from: &'static str,
    to: &'static str,
    times: f64,
    over: f64,
}

impl Conversion {
    /// Returns the conversion between two units of length, or `None` if they are the same unit.
    ///
    /// # Errors
    /// An unknown name.
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "powers of ten that units have, and parts of u32"
    )]
    pub fn between(from: &str, to: &str) -> Result<Option<Self>, String> {
        if canonical(from) == canonical(to) {
            return Ok(None);
        }
        let unit = |name: &str| {
            find(name.trim()).ok_or_else(|| {
                let names: Vec<&str> = UNITS.iter().map(|unit| unit.spellings[0]).collect();
                format!("the unit is {name:?}; it must be one of {}", names.join(", "))
            })
        };
        let (from, to) = (unit(from)?, unit(to)?);
        let power = from.power - to.power;
        let (mut times, mut over) = if from.count == to.count { (1, 1) } else { (from.count, to.count) };
        // Cancel common factors of powers of ten and counts: an inch, 254·10⁻⁴ m, is 25400 µm and 127/5000 m.
        let ten = |power: i32| 10_f64.powi(power);
        let (mut up, mut down) = if power >= 0 { (ten(power), 1.0) } else { (1.0, ten(-power)) };
        if times > 1 && down > 1.0 {
            let common = gcd(u64::from(times), down as u64);
            (times, down) = ((u64::from(times) / common) as u32, down / common as f64);
        }
        if over > 1 && up > 1.0 {
            let common = gcd(u64::from(over), up as u64);
            (over, up) = ((u64::from(over) / common) as u32, up / common as f64);
        }
        let conversion = Self {
            from: from.spellings[0],
            to: to.spellings[0],
            times: up * f64::from(times),
            over: down * f64::from(over),
        };
        Ok(Some(conversion))
    }

    /// Converts a value to the new unit.
    pub fn apply(&self, value: f64) -> f64 {
        if self.over == 1.0 {
            value * self.times
        } else if self.times == 1.0 {
            value / self.over
        } else {
            value * self.times / self.over
        }
    }
}

impl fmt::Display for Conversion {
    /// Writes the factor exactly: `from nm to µm, 1000 nm = 1 µm`.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self { from, to, times, over } = self;
        write!(f, "from {from} to {to}, {over} {from} = {times} {to}")
    }
}

/// Converts lengths in place from one unit to another.
///
/// # Errors
/// An unknown unit, unless both are the same.
pub fn convert_lengths(values: &mut [f64], from: &str, to: &str) -> Result<(), String> {
    if let Some(conversion) = Conversion::between(from, to)? {
        values.iter_mut().for_each(|value| *value = conversion.apply(*value));
    }
    Ok(())
}

fn gcd(a: u64, b: u64) -> u64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_exact_and_said_so() {
        let says = |from: &str, to: &str| Conversion::between(from, to).unwrap().unwrap();
        assert_eq!(says("nm", "um").to_string(), "from nm to µm, 1000 nm = 1 µm");
        assert_eq!(says("mm", "\u{3bc}m").to_string(), "from mm to µm, 1 mm = 1000 µm");
        assert_eq!(says("Å", "nm").to_string(), "from Å to nm, 10 Å = 1 nm");
        assert_eq!(says("in", "µm").to_string(), "from in to µm, 1 in = 25400 µm");
        assert_eq!(says("µm", "in").to_string(), "from µm to in, 25400 µm = 1 in");
        assert_eq!(says("in", "m").to_string(), "from in to m, 5000 in = 127 m");
        assert_eq!(says("mil", "in").to_string(), "from mil to in, 1000 mil = 1 in");
        assert_eq!(says("km", "fm").to_string(), "from km to fm, 1 km = 1000000000000000000 fm");
        assert_eq!(says("nm", "µm").apply(7.0), 0.007);
        assert_eq!(says("in", "m").apply(1.0), 0.0254);
        assert_eq!(Conversion::between("um", "~m").unwrap(), None);
        assert!(Conversion::between("V", "V").unwrap().is_none());
        assert!(Conversion::between("V", "m").unwrap_err().starts_with("the unit is \"V\"; it must be one of m, km"));
    }
}
