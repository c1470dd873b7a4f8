//! Units: parsing of quantities, and numbers in readable units.

use std::collections::BTreeMap;

use gfmd_law::LawKind;
use gfmd_problem::argument;
use gfmd_record::{ARRAYS, COLUMNS};
use gfmd_unit::{Conversion, Quantity, Units};
use numpy::{IntoPyArray, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::failure::refused;
use crate::surface::Array;

/// Converts a quantity of this kind to the units of a problem; `None` for a text without a unit.
#[pyfunction]
#[pyo3(signature = (name, text, kind, unit=None, stress=None))]
pub(crate) fn in_units(
    py: Python<'_>,
    name: &str,
    text: &str,
    kind: &str,
    unit: Option<&str>,
    stress: Option<&str>,
) -> PyResult<Option<f64>> {
    let refuse = |error: &dyn std::fmt::Display| refused(py, &format!("{name} is {text:?}: {error}"));
    let Some(quantity) = Quantity::parse(text).map_err(|error| refuse(&error))? else { return Ok(None) };
    let found = Units::new(unit, stress).value(&quantity, kind);
    found.map(Some).map_err(|error| refuse(&error))
}

/// Returns the unit name of a kind of quantity.
#[pyfunction]
#[pyo3(signature = (kind, unit=None, stress=None))]
pub(crate) fn unit_name(kind: &str, unit: Option<&str>, stress: Option<&str>) -> String {
    Units::new(unit, stress).name(kind)
}

/// Returns factor and name of a readable unit for numbers of a kind up to `largest`; `None` if it is not known.
#[pyfunction]
#[pyo3(signature = (kind, largest, unit=None, stress=None))]
pub(crate) fn readable(kind: &str, largest: f64, unit: Option<&str>, stress: Option<&str>) -> Option<(f64, String)> {
    Units::new(unit, stress).shown(kind, largest).map(|shown| (shown.factor, shown.name))
}

/// Formats a value with the digits that its grid error leaves certain.
#[pyfunction]
pub(crate) fn with_limit(value: f64, limit: f64, error: f64) -> String {
    gfmd_record::with_limit(value, limit, error)
}

/// Returns the canonical spelling of a unit of length; unknown names stay as they are.
#[pyfunction]
pub(crate) fn canonical(unit: &str) -> &str {
    gfmd_unit::canonical(unit)
}

/// Returns the kinds of quantity of the numbers and fields of a state, by name.
#[pyfunction]
pub(crate) fn kinds() -> Vec<(&'static str, &'static str)> {
    let columns = COLUMNS.iter().map(|column| (column.name, column.unit));
    columns.chain(ARRAYS.iter().map(|array| (array.name, array.unit))).collect()
}

/// Returns the kinds of quantity of the numbers of options, in turn, by argument.
#[pyfunction]
pub(crate) fn option_kinds() -> BTreeMap<&'static str, Vec<&'static str>> {
    gfmd_cli::kinds::kinds().iter().map(|(&key, kinds)| (argument(key), kinds.in_turn().to_vec())).collect()
}

/// Returns the kinds of quantity of the parameters of all laws, by name.
#[pyfunction]
pub(crate) fn law_kinds() -> Vec<(&'static str, &'static str)> {
    let all = LawKind::ALL.into_iter().flat_map(LawKind::parameters);
    all.map(|parameter| (parameter.name, parameter.units)).collect()
}

/// Converts heights and lengths to another unit.
#[pyfunction]
pub(crate) fn converted<'py>(
    py: Python<'py>,
    heights: PyReadonlyArray2<'py, f64>,
    lengths: [f64; 2],
    from: &str,
    to: &str,
) -> PyResult<(Array<'py>, [f64; 2], String)> {
    let conversion = Conversion::between(from, to).map_err(|error| refused(py, &error))?;
    let heights = heights.as_array();
    let (heights, lengths) = match conversion {
        Some(conversion) => {
            (heights.mapv(|height| conversion.apply(height)), lengths.map(|length| conversion.apply(length)))
        }
        None => (heights.to_owned(), lengths),
    };
    Ok((heights.into_pyarray(py), lengths, gfmd_unit::canonical(to).to_owned()))
}

/// Returns the fluids by name as JSON.
#[pyfunction]
pub(crate) fn fluids(py: Python<'_>) -> PyResult<String> {
    gfmd_input::json::to_string(gfmd_input::fluids::fluids()).map_err(|error| refused(py, &error))
}

/// Returns the materials by name as JSON.
#[pyfunction]
pub(crate) fn materials(py: Python<'_>) -> PyResult<String> {
    gfmd_input::json::to_string(gfmd_input::materials::materials()).map_err(|error| refused(py, &error))
}
