//! Comparison of numbers with recomputed ones.

use std::collections::BTreeMap;

use serde::Serialize;

/// Largest difference, relative to the scale of a variable, that another processor may cause by rounding.
const ROUNDING_OF_PROCESSORS: f64 = 1e-9;

/// Returns a text of a file in one line, without terminal control characters.
pub fn printable(text: &str) -> String {
    text.escape_debug().to_string()
}

/// Variable that differs.
#[derive(Clone, Debug, Serialize)]
pub struct Difference {
    /// Name of the variable.
    pub name: String,
    /// Number of differing values.
    pub values: u64,
    /// Stored value with the largest difference.
    pub stored: f64,
    /// Recomputed value in its place.
    pub recomputed: f64,
    /// Difference in words, if it is not numeric.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub remark: Option<String>,
}

/// Comparison of a file.
pub struct Comparison {
    /// Largest difference, relative to the scale of a variable, that does not count.
    accuracy: f64,
    compared: u64,
    rounded: u64,
    differences: BTreeMap<String, (f64, Difference)>,
}

impl Default for Comparison {
    fn default() -> Self {
        Self { accuracy: ROUNDING_OF_PROCESSORS, compared: 0, rounded: 0, differences: BTreeMap::new() }
    }
}

impl Comparison {
    /// Treats the following values as accurate to this relative difference, but not better than rounding.
    pub(crate) fn accurate_to(&mut self, relative: f64) {
        self.accuracy = ROUNDING_OF_PROCESSORS.max(relative);
    }

    /// Compares the values of a variable. `floor` is the least scale for relative differences.
    pub fn values(&mut self, name: &str, stored: &[f64], recomputed: &[f64], floor: f64) {
        if stored.len() != recomputed.len() {
            let words = format!("it has {} values; recomputed are {}", stored.len(), recomputed.len());
            return self.differ(name, words);
        }
        let largest = |values: &[f64]| values.iter().filter(|v| v.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()));
        let scale = largest(stored).max(largest(recomputed)).max(floor);
        for (stored, recomputed) in stored.iter().zip(recomputed) {
            self.compared += 1;
            if stored.to_bits() == recomputed.to_bits() || (stored.is_nan() && recomputed.is_nan()) {
                continue;
            }
            let distance = (stored - recomputed).abs();
            if distance <= self.accuracy * scale {
                self.rounded += u64::from(stored != recomputed);
                continue;
            }
            let rank = if distance.is_nan() { f64::INFINITY } else { distance };
            let name = printable(name);
            let (worst, difference) = self.differences.entry(name.clone()).or_insert_with(|| {
                let difference = Difference { name, values: 0, stored: f64::NAN, recomputed: f64::NAN, remark: None };
                (f64::NEG_INFINITY, difference)
            });
            difference.values += 1;
            if rank > *worst {
                *worst = rank;
                (difference.stored, difference.recomputed) = (*stored, *recomputed);
            }
        }
    }

    /// Compares one number.
    pub fn number(&mut self, name: &str, stored: f64, recomputed: f64, floor: f64) {
        self.values(name, &[stored], &[recomputed], floor);
    }

    /// Counts an equal value that is not a number.
    pub fn count(&mut self) {
        self.compared += 1;
    }

    /// Compares a residual with its largest allowed value.
    pub fn at_most(&mut self, name: &str, found: f64, allowed: f64) {
        self.compared += 1;
        if found.is_nan() || found > allowed {
            self.differ(name, format!("it is {found:.1e}; it must be at most {allowed:.1e}"));
        }
    }

    /// Notes a difference in words.
    pub fn differ(&mut self, name: &str, remark: String) {
        let (stored, recomputed) = (f64::NAN, f64::NAN);
        let name = printable(name);
        let difference = Difference { name: name.clone(), values: 1, stored, recomputed, remark: Some(remark) };
        self.differences.insert(name, (f64::INFINITY, difference));
    }

    /// Returns the numbers of compared, rounded and differing values.
    pub fn counts(&self) -> (u64, u64, u64) {
        (self.compared, self.rounded, self.differences.values().map(|(_, difference)| difference.values).sum())
    }

    /// Returns the differences, ordered by name.
    pub fn into_differences(self) -> Vec<Difference> {
        self.differences.into_values().map(|(_, difference)| difference).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn differences_beyond_rounding_are_found() {
        let mut comparison = Comparison::default();
        comparison.values("same", &[1.0, f64::NAN, 0.0, f64::INFINITY], &[1.0, f64::NAN, -0.0, f64::INFINITY], 0.0);
        comparison.values("rounded", &[1.0, 1e-12], &[1.0 + 1e-12, 0.0], 0.0);
        assert!(comparison.differences.is_empty());
        assert_eq!(comparison.counts(), (6, 2, 0));
        comparison.values("field", &[1.0, 2.0, 3.0], &[1.0, 2.1, 3.5], 0.0);
        comparison.values("nan", &[1.0], &[f64::NAN], 0.0);
        comparison.values("length", &[1.0], &[], 0.0);
        comparison.number("small", 1e-12, 0.0, 0.0);
        comparison.number("residual", 1e-12, 0.0, 1e-3);
        comparison.at_most("certificate", f64::NAN, 1e-8);
        comparison.differ("evil\n\u{1b}[2J\u{202e}", String::new());
        assert!(comparison.differences.remove("evil\\n\\u{1b}[2J\\u{202e}").is_some());
        let names: Vec<&str> = comparison.differences.keys().map(String::as_str).collect();
        assert_eq!(names, ["certificate", "field", "length", "nan", "small"]);
        let (_, field) = &comparison.differences["field"];
        assert_eq!((field.values, field.stored, field.recomputed), (2, 3.0, 3.5));
    }
}
