//! Laws of contacts for finite elements.

use gfmd_report::contact_law::{ContactLaw, LawFormat, Realisation};
use gfmd_unit::Units;
use pyo3::prelude::*;

use crate::failure::refused;

/// Returns the law of realisations, given as JSON in the units of their problem, as text of a format.
#[pyfunction]
#[pyo3(signature = (realisations, unit, stress, format))]
pub(crate) fn law_text(
    py: Python<'_>,
    realisations: &str,
    unit: Option<&str>,
    stress: Option<&str>,
    format: &str,
) -> PyResult<String> {
    let format = LawFormat::named(format)
        .ok_or_else(|| refused(py, &format!("format is {format:?}; it must be csv, abaqus or ansys")))?;
    let given: Vec<Realisation> = serde_json::from_str(realisations).map_err(|error| refused(py, &error))?;
    let law = ContactLaw::new(&given, &Units::new(unit, stress)).map_err(|reason| refused(py, &reason))?;
    Ok(law.text(format, &format!("gfmd {}", env!("CARGO_PKG_VERSION"))))
}
