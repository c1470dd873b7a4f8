//! Powers of stress, length, time and temperature.

use std::fmt;

/// Dimension of a quantity: its powers of stress, length, time and temperature.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dimension {
    /// Power of stress.
    pub stress: i32,
    /// Power of length.
    pub length: i32,
    /// Power of time.
    pub time: i32,
    /// Power of temperature.
    pub temperature: i32,
}

impl Dimension {
    /// Dimensionless.
    pub const NONE: Self = Self { stress: 0, length: 0, time: 0, temperature: 0 };

    /// Parses a kind of quantity as written in results: `1`, `stress`, `stress*length^2`, `1/length`. A slash divides
    /// by the next factor. Returns `None` for other words.
    pub fn of(kind: &str) -> Option<Self> {
        let mut found = Self::NONE;
        let factors = kind.split('/').enumerate().flat_map(|(place, over)| {
            over.split('*')
                .enumerate()
                .map(move |(index, factor)| (factor, if place > 0 && index == 0 { -1 } else { 1 }))
        });
        for (factor, sign) in factors {
            let (name, power) = factor.split_once('^').map_or((factor, "1"), |parts| parts);
            let power = sign * power.parse::<i32>().ok()?;
            match name {
                "1" => {}
                "stress" => found.stress += power,
                "length" => found.length += power,
                "time" => found.time += power,
                "temperature" => found.temperature += power,
                _ => return None,
            }
        }
        Some(found)
    }

    /// Returns the product of this dimension and `other` to a power.
    pub(crate) fn times(self, other: Self, power: i32) -> Self {
        Self {
            stress: self.stress + power * other.stress,
            length: self.length + power * other.length,
            time: self.time + power * other.time,
            temperature: self.temperature + power * other.temperature,
        }
    }

    /// Returns the kind in words and an example unit.
    fn words(self) -> (&'static str, &'static str) {
        match (self.stress, self.length, self.time, self.temperature) {
            (0, 0, 0, 0) => ("a number without a unit", "1"),
            (1, 0, 0, 0) => ("a stress", "MPa"),
            (0, 1, 0, 0) => ("a length", "µm"),
            (0, 2, 0, 0) => ("an area", "µm^2"),
            (1, 1, 0, 0) => ("an energy per area", "J/m^2"),
            (1, 2, 0, 0) => ("a force", "N"),
            (1, 3, 0, 0) => ("an energy", "J"),
            (1, -1, 0, 0) => ("a stress per length", "Pa/m"),
            (-1, 1, 0, 0) => ("a length per stress", "m/Pa"),
            (-1, 0, 0, 0) => ("an inverse stress", "1/GPa"),
            (0, -1, 0, 0) => ("a wavenumber", "nm^-1"),
            (0, 0, 1, 0) => ("a time", "s"),
            (1, 0, 1, 0) => ("a viscosity", "Pa*s"),
            (0, 1, -1, 0) => ("a velocity", "mm/s"),
            (0, 2, -1, 0) => ("a diffusivity", "m^2/s"),
            (0, 0, 0, 1) => ("a temperature", "K"),
            (1, 2, -1, -1) => ("a thermal conductivity", "W/(m K)"),
            (1, 1, -1, -1) => ("a thermal conductance per area", "W/(m^2 K)"),
            _ => ("another quantity", ""),
        }
    }
}

impl fmt::Display for Dimension {
    /// Writes the kind of quantity in words: `a stress (such as MPa)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (words, example) = self.words();
        f.write_str(words)?;
        if matches!(example, "" | "1") { Ok(()) } else { write!(f, " (such as {example})") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_of_results_have_dimensions() {
        let of =
            |kind: &str| Dimension::of(kind).map(|found| (found.stress, found.length, found.time, found.temperature));
        for (kind, powers) in [
            ("1", (0, 0, 0, 0)),
            ("stress", (1, 0, 0, 0)),
            ("stress*length", (1, 1, 0, 0)),
            ("stress*length^2", (1, 2, 0, 0)),
            ("stress/length", (1, -1, 0, 0)),
            ("1/length", (0, -1, 0, 0)),
            ("1/length^2", (0, -2, 0, 0)),
            ("stress^2*length^2", (2, 2, 0, 0)),
            ("1/time^2", (0, 0, -2, 0)),
            ("stress*length^2/time/temperature", (1, 2, -1, -1)),
            ("temperature", (0, 0, 0, 1)),
        ] {
            assert_eq!(of(kind), Some(powers), "{kind}");
        }
        assert_eq!(of("force on the patch"), None);
        assert_eq!(of("stress^x"), None);
    }
}
