//! Units of a problem.

use crate::display_unit::{self, DisplayUnit, digits};
use crate::quantity::Unit;
use crate::{Dimension, Quantity};

/// Units of length and stress of a problem, as far as they are known. All numbers of the problem are in these units; an
/// energy per area is in their product. If lengths have a unit, times are in s and temperatures in K.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Units {
    length: Option<String>,
    stress: Option<String>,
}

/// Error: a quantity has no value in the units of a problem.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoValue {
    /// The quantity is of another kind.
    #[error("it is {found}; it must be {allowed}")]
    Kind {
        /// Kind of the quantity.
        found: Dimension,
        /// Required kind.
        allowed: Dimension,
    },
    /// The problem has no unit of length.
    #[error(
        "it has a unit, and the lengths have none; name their unit, or leave this one out: a number is then in the \
             units of the other numbers"
    )]
    NoLength,
    /// The unit of length is unknown.
    #[error("it has a unit, and the unit of the lengths, {0}, is not known")]
    Length(String),
}

impl Units {
    /// Default unit of stress, used if a stress has a unit.
    pub const PASCAL: &str = "Pa";

    /// Creates the units of a problem from their names.
    pub fn new(length: Option<&str>, stress: Option<&str>) -> Self {
        Self { length: length.map(str::to_owned), stress: stress.map(str::to_owned) }
    }

    /// Returns the name of the unit of length.
    pub fn length(&self) -> Option<&str> {
        self.length.as_deref()
    }

    /// Returns the name of the unit of stress: Pa if lengths are in metres and no other is named.
    pub fn stress(&self) -> Option<&str> {
        self.stress.as_deref().or_else(|| (self.length() == Some("m")).then_some(Self::PASCAL))
    }

    /// Returns true if `name` is a unit of stress.
    pub fn is_stress(name: &str) -> bool {
        Unit::parse(name).is_some_and(|unit| unit.dimension == Dimension { stress: 1, ..Dimension::NONE })
    }

    /// Returns the unit of stress in Pa, or `None` if unknown.
    pub fn pascals(&self) -> Option<f64> {
        Some(self.stress_unit()?.size())
    }

    /// Returns the unit of length in m, or `None` if unknown.
    pub fn metres(&self) -> Option<f64> {
        Some(Unit::parse(self.length()?)?.size())
    }

    fn stress_unit(&self) -> Option<Unit> {
        Unit::parse(self.stress()?)
    }

    /// Returns the value of a quantity of this kind in the units of the problem. Stresses are in Pa unless another unit
    /// is named.
    ///
    /// # Errors
    /// Another kind of quantity; lengths without a unit, or with an unknown one.
    pub fn value(&self, quantity: &Quantity, kind: &str) -> Result<f64, NoValue> {
        let allowed = Dimension::of(kind).unwrap_or_default();
        let found = quantity.dimension();
        if found != allowed {
            return Err(NoValue::Kind { found, allowed });
        }
        // A problem without a unit of length has no unit of stress either: its numbers are in any consistent units.
        let name = self.length().ok_or(NoValue::NoLength)?;
        let length = Unit::parse(name).ok_or_else(|| NoValue::Length(name.into()))?;
        let stress = self.stress_unit().or_else(|| Unit::parse(Self::PASCAL)).unwrap_or(Unit::ONE);
        let unit = Unit::ONE.times(stress, allowed.stress).and_then(|unit| unit.times(length, allowed.length));
        Ok(quantity.over(&unit.unwrap_or(Unit::ONE)))
    }

    /// Returns the unit of a kind of quantity as written in files: `Pa*µm` for `stress*length`. Returns the kind itself
    /// if a unit is unknown.
    pub fn name(&self, kind: &str) -> String {
        let Some(dimension) = Dimension::of(kind).filter(|found| *found != Dimension::NONE) else { return kind.into() };
        let (stress, length) = (self.stress(), self.length());
        // If lengths have a unit, times are in s and temperatures in K.
        let needs_length = dimension.length != 0 || dimension.time != 0 || dimension.temperature != 0;
        if (dimension.stress != 0 && stress.is_none()) || (needs_length && length.is_none()) {
            return kind.into();
        }
        let whole = |name: &str| if name.contains(['/', '*', ' ', '·']) { format!("({name})") } else { name.into() };
        let named = kind.replace("stress", &whole(stress.unwrap_or_default()));
        named.replace("length", &whole(length.unwrap_or_default())).replace("time", "s").replace("temperature", "K")
    }

    /// Formats a number of a kind with up to six significant digits and its unit, if known.
    pub fn words(&self, value: f64, kind: &str) -> String {
        match self.shown(kind, value) {
            Some(unit) => unit.text(value),
            None => {
                let name = self.name(kind);
                if name == kind { digits(value) } else { format!("{} {name}", digits(value)) }
            }
        }
    }

    /// Returns the readable unit for numbers of a kind up to `largest`, or `None` without one or if a unit is unknown.
    pub fn shown(&self, kind: &str, largest: f64) -> Option<DisplayUnit> {
        let dimension = Dimension::of(kind)?;
        let mut size = Unit::ONE;
        if dimension.stress != 0 {
            size = size.times(self.stress_unit()?, dimension.stress)?;
        }
        if dimension.length != 0 {
            size = size.times(Unit::parse(self.length()?)?, dimension.length)?;
        }
        // Times are in s and temperatures in K if lengths have a unit.
        if dimension.time != 0 || dimension.temperature != 0 {
            self.metres()?;
        }
        display_unit::of(dimension, size.size(), largest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(units: &Units, text: &str, kind: &str) -> Result<f64, String> {
        units.value(&Quantity::parse(text).unwrap().unwrap(), kind).map_err(|error| error.to_string())
    }

    #[test]
    fn names_divide_by_each_factor() {
        let micro = Units::new(Some("µm"), Some("Pa"));
        assert_eq!(micro.name("stress*length/time/temperature"), "Pa*µm/s/K");
        let (name, kind) = (micro.name("stress*length^2/time/temperature"), "stress*length^2/time/temperature");
        assert_eq!(value(&micro, &format!("3 {name}"), kind), Ok(3.0));
    }

    #[test]
    fn quantities_become_numbers_of_the_problem() {
        let si = Units::new(Some("m"), None);
        let nano = Units::new(Some("nm"), None);
        let giga = Units::new(Some("µm"), Some("GPa"));
        assert_eq!(value(&si, "70GPa", "stress"), Ok(70e9));
        assert_eq!(value(&nano, "70GPa", "stress"), Ok(70e9));
        assert_eq!(value(&giga, "70GPa", "stress"), Ok(70.0));
        assert_eq!(value(&si, "0.05J/m^2", "stress*length"), Ok(0.05));
        assert_eq!(value(&nano, "0.05J/m^2", "stress*length"), Ok(0.05e9));
        assert_eq!(value(&giga, "0.05J/m^2", "stress*length"), Ok(0.05e-3));
        assert_eq!(value(&giga, "2 nm", "length"), Ok(2e-3));
        assert_eq!(value(&Units::new(Some("in"), None), "2.54cm", "length"), Ok(1.0));
        // Heat flux is in stress·length/time, so that temperature is in K.
        assert_eq!(value(&giga, "0.2 W/(m K)", "stress*length^2/time/temperature"), Ok(0.2e3));
        assert_eq!(value(&giga, "1e-7 m^2/s", "length^2/time"), Ok(1e5));
    }

    #[test]
    fn refusals_say_what_to_do() {
        let says = |units: &Units, text: &str, kind: &str, words: &str| {
            let error = value(units, text, kind).unwrap_err();
            assert!(error.contains(words), "{error}");
        };
        let known = Units::new(Some("nm"), None);
        says(&known, "2 nm", "stress", "it is a length (such as µm); it must be a stress (such as MPa)");
        says(&known, "2 N", "1", "it is a force (such as N); it must be a number without a unit");
        says(&Units::default(), "1MPa", "stress", "name their unit");
        says(&Units::new(Some("sigma"), None), "1MPa", "stress", "sigma, is not known");
    }

    #[test]
    fn names_of_units_are_those_of_the_problem() {
        let known = Units::new(Some("µm"), Some("Pa"));
        assert_eq!(known.name("stress*length"), "Pa*µm");
        assert_eq!(known.name("1/length"), "1/µm");
        assert_eq!(known.name("1"), "1");
        assert_eq!(
            (known.name("temperature"), Units::default().name("temperature")),
            ("K".into(), "temperature".into())
        );
        assert_eq!(Units::new(Some("µm"), Some("N/mm^2")).name("stress/length"), "(N/mm^2)/µm");
        let half = Units::new(Some("nm"), None);
        assert_eq!((half.name("length").as_str(), half.name("stress*length").as_str()), ("nm", "stress*length"));
        assert_eq!(Units::default().name("stress"), "stress");
        assert_eq!(Units::new(Some("m"), None).name("stress"), "Pa");
    }
}
