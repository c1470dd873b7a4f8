//! Findings of a case: complaints, and the number of compared numbers.

use std::collections::BTreeMap;

use gfmd_record::reason_for;
use serde_json::Value;

#[derive(Default)]
pub(crate) struct Found {
    pub(crate) complaints: Vec<String>,
    pub(crate) compared: usize,
    /// Numbers that are null with a reason.
    pub(crate) undefined: BTreeMap<String, usize>,
    /// Numbers of events worth counting.
    pub(crate) noted: BTreeMap<String, usize>,
}

/// Returns the number at a place, NaN if it is null.
pub(crate) fn number(of: &Value, key: &str) -> f64 {
    of.pointer(&format!("/{}", key.replace('.', "/"))).map_or(f64::NAN, |value| match value {
        Value::Bool(flag) => f64::from(u8::from(*flag)),
        value => value.as_f64().unwrap_or(f64::NAN),
    })
}

impl Found {
    pub(crate) fn complain(&mut self, text: String) {
        self.complaints.push(text);
    }

    /// Counts an event.
    pub(crate) fn note(&mut self, event: String) {
        *self.noted.entry(event).or_default() += 1;
    }

    pub(crate) fn must(&mut self, holds: bool, text: impl FnOnce() -> String) {
        self.compared += 1;
        if !holds {
            self.complaints.push(text());
        }
    }

    /// Compares a number with its definition, within an absolute tolerance.
    pub(crate) fn near(&mut self, name: &str, found: f64, expected: f64, tolerance: f64) {
        self.must((found - expected).abs() <= tolerance || found == expected, || {
            format!("{name} is {found:e}; by definition {expected:e}, which may differ by {tolerance:.1e}")
        });
    }

    /// Compares the number of a load or a step with its definition, within a relative tolerance. A null needs its
    /// reason.
    pub(crate) fn is(&mut self, record: &Value, key: &str, expected: f64, tolerance: f64) {
        let found = number(record, key);
        if found.is_nan() {
            self.null(record, key);
        } else {
            self.near(key, found, expected, tolerance * expected.abs());
        }
    }

    /// Checks that a null number has a reason.
    pub(crate) fn null(&mut self, record: &Value, key: &str) {
        self.compared += 1;
        match reason_for(record, key) {
            Some(reason) if reason.len() > 10 => *self.undefined.entry(format!("{key}: {reason}")).or_default() += 1,
            _ => self.complaints.push(format!("{key} is null without a reason")),
        }
    }

    /// Checks that every null of a record has a reason, and every reason a null, by the names in the file. Numbers in
    /// `absent` have no meaning for this case.
    pub(crate) fn nulls(&mut self, record: &Value, absent: &[&str]) {
        let mut all = BTreeMap::new();
        super::outlets::flat(record, "", &mut all);
        for (name, value) in &all {
            match value.is_nan() {
                true if absent.contains(&name.as_str()) => {}
                true => self.null(record, name),
                false => self.must(value.is_finite(), || format!("{name} is {value}")),
            }
        }
        let named =
            record["undefined"].as_object().into_iter().flatten().flat_map(|(_, names)| names.as_array().unwrap());
        for name in named.map(|name| name.as_str().unwrap()) {
            self.must(all.get(name).is_some_and(|value| value.is_nan()), || {
                format!("{name} has a reason to be null, and is not")
            });
        }
    }
}
