//! Units of length in file headers.

pub(crate) use gfmd_unit::canonical;
pub use gfmd_unit::{Conversion, convert_lengths, is_length};

/// Length along an axis, and its unit if the file has one.
pub(crate) type Side = (f64, Option<String>);

/// Size of a map in one unit.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Sides {
    pub lengths: [f64; 2],
    /// Unit along x, and along y after the conversion.
    pub unit: Option<String>,
    /// Conversion in words, if any.
    pub notes: Vec<String>,
}

impl Sides {
    /// Combines the sides along x and y; a profile has no side along y. A side along y in another unit is converted.
    ///
    /// # Errors
    /// A unit along only one axis; an unknown unit, if the units differ.
    pub(crate) fn of(x: Side, y: Option<Side>) -> Result<Self, String> {
        let (x, unit) = x;
        let Some((mut y, unit_y)) = y else { return Ok(Self { lengths: [x, 1.0], unit, notes: Vec::new() }) };
        let mut notes = Vec::new();
        match (&unit, &unit_y) {
            (Some(to), Some(from)) => {
                if let Some(conversion) = Conversion::between(from, to)? {
                    y = conversion.apply(y);
                    notes.push(format!("the length along y converted {conversion}"));
                }
            }
            (None, None) => {}
            (Some(unit), None) => return Err(alone("x", unit, "y")),
            (None, Some(unit)) => return Err(alone("y", unit, "x")),
        }
        Ok(Self { lengths: [x, y], unit, notes })
    }
}

/// Returns the error message for a unit that only one of two lengths has.
pub(crate) fn alone(with: &str, unit: &str, without: &str) -> String {
    format!("the unit of {with} is {unit} but {without} has no unit; both or neither must have one")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sides_of_a_map_have_one_unit() {
        let side = |length: f64, unit: &str| (length, Some(unit).filter(|unit| !unit.is_empty()).map(str::to_owned));
        let sides = |x: &str, y: &str| Sides::of(side(2.0, x), Some(side(3.0, y)));
        let found = sides("µm", "nm").unwrap();
        assert_eq!((found.lengths, found.unit.as_deref()), ([2.0, 0.003], Some("µm")));
        assert_eq!(found.notes, ["the length along y converted from nm to µm, 1000 nm = 1 µm"]);
        let plain = Sides { lengths: [2.0, 3.0], ..Sides::default() };
        assert_eq!(sides("", ""), Ok(plain));
        assert_eq!(sides("um", "~m").unwrap().lengths, [2.0, 3.0]);
        for (x, y, says) in [
            ("m", "", "the unit of x is m but y has no unit"),
            ("", "m", "the unit of y is m but x has no unit"),
            ("m", "px", "the unit is \"px\""),
        ] {
            assert!(sides(x, y).unwrap_err().starts_with(says), "{x} {y}");
        }
        assert_eq!(Sides::of(side(2.0, "m"), None).unwrap().lengths, [2.0, 1.0]);
    }
}
