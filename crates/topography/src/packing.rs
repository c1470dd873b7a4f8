//! Conversion of stored numbers to values by the attributes of NetCDF and the CF conventions, for HDF5 and NetCDF
//! files: `scale_factor` and `add_offset`; `_FillValue` and `missing_value`; `valid_min`, `valid_max` and
//! `valid_range`; `_Unsigned`.

/// Kind of stored numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Kind {
    pub(crate) is_float: bool,
    pub(crate) is_signed: bool,
    pub(crate) bytes: u32,
}

/// Value of an attribute.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Numbers {
        numbers: Vec<f64>,
        is_float: bool,
    },
    Text(String),
    /// Reference or record.
    Other,
}

/// Conversion of stored numbers to values.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Packing {
    kind: Kind,
    factor: Option<f64>,
    offset: Option<f64>,
    /// Numbers for missing values.
    missing: Vec<f64>,
    valid: [f64; 2],
    /// True if the limits are values instead of stored numbers.
    valid_values: bool,
    /// Number added to negative numbers, if signed integers stand for unsigned ones.
    wrap: Option<f64>,
    /// Attributes that may scale the numbers in an unknown way.
    pub(crate) unknown: Vec<String>,
}

/// Value that NetCDF writes for floats that were never written.
const FLOAT_FILL: f64 = 9.969_209_968_386_869e36;

/// Words in names of attributes that scale numbers.
const SCALING: [&str; 15] = [
    "scale",
    "scaling",
    "offset",
    "multiplier",
    "factor",
    "gain",
    "slope",
    "intercept",
    "calibration",
    "sensitivity",
    "conversion",
    "lsb",
    "percount",
    "perbit",
    "perdigit",
];

/// Other spellings of `_FillValue`, in lower-case letters only.
const MISSING: [&str; 5] = ["fillvalue", "missingvalue", "nodata", "nodatavalue", "undefinedvalue"];

impl Packing {
    /// Determines the conversion of numbers of a kind from the attributes of their variable. NetCDF has fill values for
    /// numbers never written.
    ///
    /// # Errors
    /// An attribute of these names without a finite number; a factor of zero.
    pub(crate) fn of(kind: Kind, attributes: &[(String, Value)], is_netcdf: bool) -> Result<Self, String> {
        let mut found = Self {
            kind,
            factor: None,
            offset: None,
            missing: Vec::new(),
            valid: [f64::NEG_INFINITY, f64::INFINITY],
            valid_values: false,
            wrap: None,
            unknown: Vec::new(),
        };
        let (mut has_fill, mut float_limits) = (false, false);
        for (name, value) in attributes {
            let numbers = || value.numbers(name);
            let limit = |numbers: &[f64], index: usize, count: usize| match numbers {
                numbers if numbers.len() == count => Ok(numbers[index]),
                _ => Err(format!("the attribute {name} has {} numbers; it must have {count}", numbers.len())),
            };
            match name.as_str() {
                "scale_factor" | "add_offset" => {
                    let number = limit(&numbers()?, 0, 1)?;
                    if !number.is_finite() || (name == "scale_factor" && number == 0.0) {
                        let zero = if name == "scale_factor" { " and not zero" } else { "" };
                        return Err(format!("the attribute {name} is {number}; it must be finite{zero}"));
                    }
                    if name == "scale_factor" { found.factor = Some(number) } else { found.offset = Some(number) }
                }
                "_FillValue" | "missing_value" => {
                    has_fill |= name == "_FillValue";
                    found.missing.extend(numbers()?);
                }
                "valid_range" => {
                    found.valid = [limit(&numbers()?, 0, 2)?, limit(&numbers()?, 1, 2)?];
                    float_limits = value.is_float();
                }
                "valid_min" | "valid_max" => {
                    found.valid[usize::from(name == "valid_max")] = limit(&numbers()?, 0, 1)?;
                    float_limits = value.is_float();
                }
                "_Unsigned" if kind.is_signed && !kind.is_float => {
                    let is_set = matches!(value, Value::Text(text) if text.eq_ignore_ascii_case("true"));
                    found.wrap = is_set.then(|| 256_f64.powi(i32::try_from(kind.bytes).unwrap_or(0)));
                }
                _ => {
                    let letters = letters(name);
                    if let (true, Value::Numbers { numbers, .. }) = (MISSING.contains(&&*letters), value) {
                        found.missing.extend(numbers);
                    } else if matches!(value, Value::Numbers { .. }) && is_scaling(name) {
                        found.unknown.push(name.clone());
                    }
                }
            }
        }
        if !has_fill {
            found.missing.extend(kind.never_written(is_netcdf));
        }
        // Limits of a wider type than the numbers are values (NetCDF user's guide, attribute conventions).
        found.valid_values = float_limits && !kind.is_float && found.is_known();
        let stored = |number: f64| found.unsigned(number);
        let missing = found.missing.iter().map(|number| stored(*number)).collect();
        let valid = if found.valid_values { found.valid } else { found.valid.map(stored) };
        Ok(Self { missing, valid, ..found })
    }

    /// Creates a conversion of numbers of a kind with a factor and an offset.
    pub(crate) fn linear(kind: Kind, factor: f64, offset: f64) -> Result<Self, String> {
        let number = |number: f64| Value::Numbers { numbers: vec![number], is_float: true };
        Self::of(kind, &[("scale_factor".into(), number(factor)), ("add_offset".into(), number(offset))], false)
    }

    /// Returns true if the file gives a factor or an offset.
    pub(crate) fn is_known(&self) -> bool {
        self.factor.is_some() || self.offset.is_some()
    }

    /// Converts a stored number to its value; NaN if it is missing or invalid.
    pub(crate) fn value(&self, number: f64) -> f64 {
        let number = self.unsigned(number);
        let valid = |number: f64| self.valid[0] <= number && number <= self.valid[1];
        if self.missing.iter().any(|missing| self.same(number, *missing)) || !(self.valid_values || valid(number)) {
            return f64::NAN;
        }
        let scaled = self.factor.map_or(number, |factor| number * factor);
        let value = self.offset.map_or(scaled, |offset| scaled + offset);
        if self.valid_values && !valid(value) { f64::NAN } else { value }
    }

    /// Returns the rounding error of values up to `largest`.
    pub(crate) fn rounding(&self, largest: f64) -> f64 {
        let digits = match (self.kind.is_float, self.kind.bytes) {
            (true, 2) => 11,
            (true, 4) => 24,
            _ => 53,
        };
        let step = if self.kind.is_float { 0.0 } else { 0.5 * self.factor.map_or(0.0, f64::abs) };
        step + largest.abs() * 0.5_f64.powi(digits)
    }

    /// Returns an error for heights stored as integers with an unknown scale.
    ///
    /// # Errors
    /// Integers in a unit of length without `scale_factor` or `add_offset`, or with attributes that may scale them.
    pub(crate) fn check(&self, name: &str, unit: Option<&str>) -> Result<(), String> {
        let write = "give scale_factor (and add_offset), or write the heights as floats";
        match (self.kind.is_float || self.is_known(), self.unknown.first(), unit) {
            (true, ..) | (false, None, None) => Ok(()),
            (false, Some(attribute), _) => Err(format!(
                "{name} has integers beside the attribute {attribute}, which has no meaning that is known; {write}"
            )),
            (false, None, Some(unit)) => {
                Err(format!("{name} has integers in {unit} without a scale that is known; {write}"))
            }
        }
    }

    fn unsigned(&self, number: f64) -> f64 {
        match self.wrap {
            Some(wrap) if number < 0.0 => number + wrap,
            _ => number,
        }
    }

    /// Returns true for equal numbers, up to the precision of the stored numbers.
    #[expect(clippy::cast_possible_truncation, reason = "attributes may have more digits than the numbers")]
    fn same(&self, number: f64, missing: f64) -> bool {
        number == missing || (self.kind.is_float && self.kind.bytes == 4 && number as f32 == missing as f32)
    }
}

impl Kind {
    /// Returns the number that stands for values never written.
    fn never_written(self, is_netcdf: bool) -> Option<f64> {
        match self {
            Self { is_float: true, bytes: 4 | 8, .. } => Some(FLOAT_FILL),
            Self { bytes: 2 | 4 | 8, is_float: false, is_signed } if is_netcdf => {
                let bits = i32::try_from(self.bytes).unwrap_or(0) * 8;
                Some(if is_signed {
                    if bits == 64 { -9_223_372_036_854_775_806.0 } else { 1.0 - 2_f64.powi(bits - 1) }
                } else if bits == 64 {
                    18_446_744_073_709_551_614.0
                } else {
                    2_f64.powi(bits) - 1.0
                })
            }
            _ => None,
        }
    }
}

impl Value {
    fn is_float(&self) -> bool {
        matches!(self, Self::Numbers { is_float: true, .. })
    }

    /// Returns the numbers of the attribute `name`, which some programs write as text.
    fn numbers(&self, name: &str) -> Result<Vec<f64>, String> {
        let found = match self {
            Self::Numbers { numbers, .. } => Some(numbers.clone()),
            Self::Text(text) => text.split_whitespace().map(|word| word.parse().ok()).collect(),
            Self::Other => None,
        };
        found
            .filter(|numbers| !numbers.is_empty())
            .ok_or_else(|| format!("the attribute {name} has no number; it must have one"))
    }
}

/// Returns the letters of a name in lower case.
fn letters(name: &str) -> String {
    name.chars().filter(|c| c.is_alphabetic()).collect::<String>().to_lowercase()
}

/// Returns true for the name of an attribute that may scale numbers.
pub(crate) fn is_scaling(name: &str) -> bool {
    let name = letters(name);
    SCALING.iter().any(|word| name.contains(word))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHORT: Kind = Kind { is_float: false, is_signed: true, bytes: 2 };
    const SINGLE: Kind = Kind { is_float: true, is_signed: true, bytes: 4 };

    fn packing(kind: Kind, attributes: &[(&str, &[f64], bool)]) -> Result<Packing, String> {
        let value = |numbers: &[f64], is_float| Value::Numbers { numbers: numbers.to_vec(), is_float };
        let all: Vec<(String, Value)> =
            attributes.iter().map(|(name, numbers, float)| ((*name).to_owned(), value(numbers, *float))).collect();
        Packing::of(kind, &all, true)
    }

    #[test]
    fn numbers_become_values_by_the_conventions() {
        let scale: [(&str, &[f64], bool); 2] = [("scale_factor", &[0.5], true), ("add_offset", &[10.0], true)];
        let with = |more: &[(&str, &[f64], bool)]| packing(SHORT, &[&scale[..], more].concat()).unwrap();
        assert_eq!(with(&[]).value(-4.0), 8.0);
        let holes = with(&[("_FillValue", &[-1.0], false), ("missing_value", &[7.0, 8.0], false)]);
        assert_eq!([-1.0, 7.0, 8.0, 9.0].map(|number| holes.value(number).is_nan()), [true, true, true, false]);
        // Limits of the stored type apply to stored numbers, float limits to values.
        let stored = with(&[("valid_range", &[-4.0, 4.0], false)]);
        assert_eq!([-5.0, -4.0, 4.0, 5.0].map(|number| stored.value(number).is_nan()), [true, false, false, true]);
        let values = with(&[("valid_min", &[8.0], true), ("valid_max", &[12.0], true)]);
        assert_eq!([-5.0, -4.0, 4.0, 5.0].map(|number| values.value(number).is_nan()), [true, false, false, true]);
        // Never written, unless another fill value is given.
        assert!(with(&[]).value(-32767.0).is_nan() && !holes.value(-32767.0).is_nan());
        assert!(packing(SINGLE, &[]).unwrap().value(f64::from(9.969_21e36_f32)).is_nan());
        let tenth = packing(SINGLE, &[("_FillValue", &[-9999.1], true)]).unwrap();
        assert!(tenth.value(f64::from(-9999.1_f32)).is_nan() && tenth.value(-9999.0) == -9999.0);
        for (name, numbers, says) in [
            ("scale_factor", &[0.0][..], "the attribute scale_factor is 0; it must be finite and not zero"),
            ("scale_factor", &[1.0, 2.0], "the attribute scale_factor has 2 numbers; it must have 1"),
            ("add_offset", &[f64::NAN], "the attribute add_offset is NaN; it must be finite"),
            ("valid_range", &[1.0], "the attribute valid_range has 1 numbers; it must have 2"),
            ("_FillValue", &[], "the attribute _FillValue has no number; it must have one"),
        ] {
            assert_eq!(packing(SHORT, &[(name, numbers, true)]).unwrap_err(), says);
        }
    }

    #[test]
    fn signed_integers_may_stand_for_unsigned_ones() {
        let number = |numbers: &[f64]| Value::Numbers { numbers: numbers.to_vec(), is_float: false };
        let bytes = Kind { is_float: false, is_signed: true, bytes: 1 };
        let all = [
            ("_Unsigned".to_owned(), Value::Text("true".into())),
            ("scale_factor".to_owned(), Value::Text("2.0".into())),
            ("_FillValue".to_owned(), number(&[-1.0])),
            ("valid_range".to_owned(), number(&[0.0, -6.0])),
        ];
        let found = Packing::of(bytes, &all, true).unwrap();
        assert_eq!([3.0, -128.0, -6.0].map(|byte| found.value(byte)), [6.0, 256.0, 500.0]);
        assert!(found.value(-1.0).is_nan() && found.value(-2.0).is_nan());
    }

    #[test]
    fn integers_need_a_scale() {
        let plain = packing(SHORT, &[]).unwrap();
        assert!(plain.check("z", None).is_ok() && packing(SINGLE, &[]).unwrap().check("z", Some("m")).is_ok());
        assert!(packing(SHORT, &[("add_offset", &[0.0], true)]).unwrap().check("z", Some("m")).is_ok());
        assert!(plain.check("z", Some("m")).unwrap_err().starts_with("z has integers in m without a scale that is"));
        let gain = packing(SHORT, &[("z_gain", &[2.0], true)]).unwrap().check("z", None).unwrap_err();
        assert!(gain.starts_with("z has integers beside the attribute z_gain, which has no meaning that is known"));
    }
}
