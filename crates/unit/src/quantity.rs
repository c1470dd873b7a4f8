//! Numbers with a unit, from text.

use crate::Dimension;
use crate::length;

/// Number with a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// Text as given.
    text: String,
    /// Decimal digits of the number, without its power of ten.
    digits: String,
    /// Unit.
    unit: Unit,
}

/// Product of powers of units, of size count·10^power in Pa, m, s and K.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit {
    pub(crate) dimension: Dimension,
    pub(crate) power: i32,
    pub(crate) count: f64,
}

/// Error: the text is not a unit.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0:?} is no unit; it must be made of m, mm, µm (or um), nm, Å, pm, in, mil, Pa, bar, N, J, W, K, s, min, h, d, \
         yr, with prefixes, as in GPa, J/m^2, N/mm^2, Pa*s, W/(m K)"
)]
pub struct UnknownUnit(String);

/// Units that take an SI prefix: powers of stress, length, time and temperature, and the power of ten of the size.
const PREFIXED: [(&str, [i32; 4], i32); 7] = [
    ("Pa", [1, 0, 0, 0], 0),
    ("bar", [1, 0, 0, 0], 5),
    ("N", [1, 2, 0, 0], 0),
    ("J", [1, 3, 0, 0], 0),
    ("W", [1, 3, -1, 0], 0),
    ("s", [0, 0, 1, 0], 0),
    ("K", [0, 0, 0, 1], 0),
];

/// Units of time without a prefix, in s; a year is a Julian year.
const TIMES: [(&str, f64); 4] = [("min", 60.0), ("h", 3600.0), ("d", 86400.0), ("yr", 31_557_600.0)];

/// SI prefixes in use; micro is `u` or either letter mu.
const PREFIXES: [(&str, i32); 14] = [
    ("", 0),
    ("T", 12),
    ("G", 9),
    ("M", 6),
    ("k", 3),
    ("h", 2),
    ("c", -2),
    ("m", -3),
    ("µ", -6),
    ("μ", -6),
    ("u", -6),
    ("n", -9),
    ("p", -12),
    ("f", -15),
];

impl Quantity {
    /// Parses a number with a unit, such as `70GPa`, `1.5 µm`, `5e-2 J/m^2`, `0.4 N/mm²`. Returns `None` for a number
    /// without a unit, and for text that does not begin with a number.
    ///
    /// # Errors
    /// A number followed by words that are not a unit.
    pub fn parse(text: &str) -> Result<Option<Self>, UnknownUnit> {
        let trimmed = text.trim();
        let begins = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.');
        if !trimmed.starts_with(begins) {
            return Ok(None);
        }
        let is_number = |end: &usize| trimmed.get(..*end).is_some_and(|start| start.parse::<f64>().is_ok());
        // The longest number: `2E` of `2EPa` is not a number, `2e3` of `2e3Pa` is.
        let mut ends = trimmed.char_indices().map(|(index, _)| index).chain([trimmed.len()]);
        let Some(end) = ends.rfind(is_number) else { return Ok(None) };
        let (number, rest) = trimmed.split_at(end);
        let name = rest.trim();
        // The 1 of an inverse unit: `3e-15 1/Pa`.
        let name = name.strip_prefix('1').filter(|under| under.trim_start().starts_with('/')).unwrap_or(name);
        if name.is_empty() || name.starts_with(begins) {
            return Ok(None);
        }
        let unit = Unit::parse(name).ok_or_else(|| UnknownUnit(name.into()))?;
        let (digits, exponent) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
        let exponent: i32 = exponent.parse().map_err(|_| UnknownUnit(name.into()))?;
        let unit = Unit { power: unit.power.saturating_add(exponent), ..unit };
        Ok(Some(Self { text: trimmed.into(), digits: digits.into(), unit }))
    }

    /// Returns the text as given.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the dimension.
    pub fn dimension(&self) -> Dimension {
        self.unit.dimension
    }

    /// Returns the number in a unit of the same dimension, correctly rounded if both are powers of ten in SI.
    pub(crate) fn over(&self, unit: &Unit) -> f64 {
        let power = self.unit.power.saturating_sub(unit.power);
        let times_ten = |digits: &str| format!("{digits}e{power}").parse().unwrap_or(f64::NAN);
        match self.digits.parse::<f64>() {
            Ok(number) if self.unit.count != unit.count => {
                times_ten(&(number * self.unit.count / unit.count).to_string())
            }
            _ => times_ten(&self.digits),
        }
    }
}

impl Unit {
    pub(crate) const ONE: Self = Self { dimension: Dimension::NONE, power: 0, count: 1.0 };

    /// Parses a product of powers of units. A slash divides by the next unit only, or by all units in parentheses.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let mut found = Self::ONE;
        let mut rest = text.trim();
        let mut sign = 1;
        // The remainder of `1/m` after the 1.
        if let Some(under) = rest.strip_prefix('/') {
            (sign, rest) = (-1, under.trim_start());
        }
        loop {
            let (factor, behind) = match rest.strip_prefix('(') {
                Some(rest) => {
                    let (inside, behind) = rest.split_once(')')?;
                    (Self::parse(inside)?, behind)
                }
                None => {
                    let ends = |c: char| matches!(c, '*' | '·' | '/') || c.is_whitespace();
                    let (factor, behind) = rest.split_at(rest.find(ends).unwrap_or(rest.len()));
                    (Self::factor(factor)?, behind)
                }
            };
            found = found.times(factor, sign)?;
            let behind = behind.trim_start();
            let Some(next) = behind.chars().next() else { return Some(found) };
            (sign, rest) = match next {
                '/' => (-1, behind[1..].trim_start()),
                '*' | '·' => (1, behind[next.len_utf8()..].trim_start()),
                _ => (1, behind),
            };
        }
    }

    /// Parses one unit to a power: `m`, `mm^2`, `µm²`, `s^-1`.
    fn factor(text: &str) -> Option<Self> {
        const RAISED: [(char, char); 4] = [('²', '2'), ('³', '3'), ('¹', '1'), ('⁻', '-')];
        let is_power =
            |c: char| c == '^' || c == '-' || c.is_ascii_digit() || RAISED.iter().any(|(raised, _)| *raised == c);
        let (name, power) = text.split_at(text.find(is_power).unwrap_or(text.len()));
        let plain = |c: char| RAISED.iter().find(|(raised, _)| *raised == c).map_or(c, |(_, plain)| *plain);
        let digits: String = power.strip_prefix('^').unwrap_or(power).chars().map(plain).collect();
        let power = if power.is_empty() { 1 } else { digits.parse().ok().filter(|power: &i32| power.abs() < 10)? };
        Self::ONE.times(Self::named(name)?, power)
    }

    fn named(name: &str) -> Option<Self> {
        if let Some(unit) = length::find(name) {
            let dimension = Dimension { length: 1, ..Dimension::NONE };
            return Some(Self { dimension, power: unit.power, count: f64::from(unit.count) });
        }
        if let Some((_, count)) = TIMES.iter().find(|(known, _)| *known == name) {
            return Some(Self { dimension: Dimension { time: 1, ..Dimension::NONE }, power: 0, count: *count });
        }
        PREFIXED.iter().find_map(|(symbol, [stress, length, time, temperature], power)| {
            let prefix = name.strip_suffix(symbol)?;
            let (_, tens) = PREFIXES.iter().find(|(known, _)| *known == prefix)?;
            let dimension = Dimension { stress: *stress, length: *length, time: *time, temperature: *temperature };
            Some(Self { dimension, power: power + tens, count: 1.0 })
        })
    }

    /// Returns the product of this unit and `other` to a power, or `None` on overflow of the power of ten.
    pub(crate) fn times(self, other: Self, power: i32) -> Option<Self> {
        Some(Self {
            dimension: self.dimension.times(other.dimension, power),
            power: self.power.checked_add(other.power.checked_mul(power)?)?,
            count: self.count * other.count.powi(power),
        })
    }

    /// Returns the size in Pa, m, s and K.
    pub(crate) fn size(&self) -> f64 {
        self.count * 10_f64.powi(self.power)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_si(text: &str) -> (f64, (i32, i32, i32, i32)) {
        let found = Quantity::parse(text).unwrap().unwrap_or_else(|| panic!("{text}"));
        let Dimension { stress, length, time, temperature } = found.dimension();
        (found.over(&Unit { dimension: found.dimension(), ..Unit::ONE }), (stress, length, time, temperature))
    }

    #[test]
    fn quantities_are_rounded_once() {
        for (text, value, powers) in [
            ("70GPa", 70e9, (1, 0, 0, 0)),
            (" 70 GPa ", 70e9, (1, 0, 0, 0)),
            ("-2.1 nm", -2.1e-9, (0, 1, 0, 0)),
            ("2.3um", 2.3e-6, (0, 1, 0, 0)),
            ("2.3 μm", 2.3e-6, (0, 1, 0, 0)),
            ("0.05 J/m^2", 0.05, (1, 1, 0, 0)),
            ("50mJ/m²", 0.05, (1, 1, 0, 0)),
            ("50 mN/m", 0.05, (1, 1, 0, 0)),
            ("1e3 N/mm^2", 1e9, (1, 0, 0, 0)),
            ("1E3N mm^-2", 1e9, (1, 0, 0, 0)),
            ("0.1 J m-2", 0.1, (1, 1, 0, 0)),
            ("2 mbar", 200.0, (1, 0, 0, 0)),
            ("1.5 hPa", 150.0, (1, 0, 0, 0)),
            ("1 mPa*s", 1e-3, (1, 0, 1, 0)),
            ("2 mPa·s", 2e-3, (1, 0, 1, 0)),
            ("4 N", 4.0, (1, 2, 0, 0)),
            ("5 µJ", 5e-6, (1, 3, 0, 0)),
            ("3 N/m/s", 3.0, (1, 1, -1, 0)),
            ("+.5e-3mm", 0.5e-6, (0, 1, 0, 0)),
            ("1 in", 0.0254, (0, 1, 0, 0)),
            ("3 ms", 3e-3, (0, 0, 1, 0)),
            ("3 m*s", 3.0, (0, 1, 1, 0)),
            ("1/µm", 1e6, (0, -1, 0, 0)),
            ("0.2 W/(m K)", 0.2, (1, 2, -1, -1)),
            ("0.2W/m/K", 0.2, (1, 2, -1, -1)),
            ("5mW/(mm·K)", 5.0, (1, 2, -1, -1)),
            ("0.1 mm^2/s", 1e-7, (0, 2, -1, 0)),
            ("20 K", 20.0, (0, 0, 0, 1)),
            ("3e-15 1/Pa", 3e-15, (-1, 0, 0, 0)),
            ("2e-6 mm^3/N/m", 2e-15, (-1, 0, 0, 0)),
        ] {
            assert_eq!(in_si(text), (value, powers), "{text}");
        }
    }

    #[test]
    fn numbers_without_a_unit_are_none() {
        for text in ["70e9", "1", "-0.5", "1e-3:1:4", "inf", "nan", "", "x.npy", "-", "1e", "1,2", "0.2 0.3", "1-2"] {
            assert!(matches!(Quantity::parse(text), Ok(None) | Err(_)), "{text}");
        }
        assert_eq!(Quantity::parse("70e9"), Ok(None));
        assert_eq!(Quantity::parse("scan.npy"), Ok(None));
    }

    #[test]
    fn words_that_are_no_unit_are_named() {
        for text in [
            "70 GPaa",
            "1 V",
            "2 gpa",
            "3 m^",
            "3 J//m",
            "5 m^99",
            "1 Pa*",
            "3px",
            "1 e",
            "2 EPa",
            "1 W/(m K",
            "1 W/(m)K)",
        ] {
            let error = Quantity::parse(text).expect_err(text).to_string();
            assert!(error.contains("is no unit; it must be made of m, mm"), "{text}: {error}");
        }
    }
}
