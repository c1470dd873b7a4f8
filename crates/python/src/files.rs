//! Result files: written as the program writes them, read array by array.

use std::path::Path;

use gfmd_cli::contact::{self, configuration, facts_of};
use gfmd_contact::{Boundary, Hardness};
use gfmd_files::{Output, Reader};
use gfmd_record::Record;
use gfmd_run::failure::Failure;
use gfmd_run::json;
use gfmd_run::series::{Chosen, StateFile};
use gfmd_run::session::Session;
use gfmd_run::source::Surface;
use gfmd_surface::Statistics;
use ndarray::{Array2, ArrayD, IxDyn};
use numpy::{IntoPyArray, PyArrayDyn, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::command::table;
use crate::failure::{failed, refused};
use crate::surface::grid;
use crate::worker::quick;

/// The scalars as JSON, and the fields, in the order of a file.
type Load<'py> = (String, Vec<PyReadonlyArray2<'py, f64>>);

/// A surface: heights, lengths, unit, description.
type Given<'py> = (PyReadonlyArray2<'py, f64>, [f64; 2], Option<String>, String);

/// The surface as a file has it.
fn surface_of(
    py: Python<'_>,
    (heights, lengths, unit, description): Given<'_>,
    boundary: Boundary,
) -> PyResult<Surface> {
    let heights = heights.as_array().to_owned();
    let grid = grid(py, heights.dim().into(), lengths)?;
    let statistics = quick(py, || Statistics::of(&heights, &grid))?;
    let statistics = statistics.map_err(|error| refused(py, &format!("surface: {error}")))?;
    let (share, scan, origin, second) = (grid.whole(), None, None, None);
    Ok(Surface { heights, grid, share, unit, statistics, boundary, description, scan, origin, second })
}

/// Writes contacts of one surface; `hardness` is given if it is a field, `lower` if there is a surface below the slab.
#[pyfunction]
#[pyo3(signature = (path, surface, loads, config, hardness=None, lower=None))]
pub(crate) fn save(
    py: Python<'_>,
    path: &str,
    surface: Given<'_>,
    loads: Vec<Load<'_>>,
    config: &Bound<'_, PyDict>,
    hardness: Option<PyReadonlyArray2<'_, f64>>,
    lower: Option<Given<'_>>,
) -> PyResult<()> {
    let config = toml::to_string(&table(config)?).map_err(|error| refused(py, &error))?;
    let line = surface.0.as_array().ncols() == 1;
    let facts = facts_of(&config, line).map_err(|failure| refused(py, &failure))?;
    let mut records = Vec::new();
    let mut fields: Vec<Vec<Array2<f64>>> = Vec::new();
    for (record, of_load) in loads {
        let record: serde_json::Value = serde_json::from_str(&record).map_err(|error| refused(py, &error))?;
        records.push(Record::from_json(&facts, &record).map_err(|error| refused(py, &error))?);
        fields.push(of_load.iter().map(|field| field.as_array().to_owned()).collect());
    }
    let boundary = facts.boundary;
    let hardness = hardness.map(|field| Hardness::Field(field.as_array().to_owned()));
    let surface = surface_of(py, surface, boundary)?;
    let lower = lower.map(|lower| surface_of(py, lower, boundary)).transpose()?;
    let written = quick(py, || {
        let output = Output::claim(Path::new(path)).map_err(|error| Failure::input("path", error))?;
        let session = Session::silent();
        let provenance = session.provenance(config);
        let mut file = StateFile::create(Some(&output), &provenance, &surface, records.len(), facts, Chosen::All)?;
        if let Some(lower) = &lower {
            file.write_lower(lower)?;
        }
        file.write_hardness(hardness.as_ref(), &surface)?;
        for (index, fields) in fields.iter().enumerate() {
            file.write_fields(index, fields.iter().map(|field| field.view().into()))?;
        }
        file.finish(&records, records.len(), None).map(|_| ())
    })?;
    written.map_err(|failure| failed(py, &failure))
}

/// An array of a file.
#[pyfunction]
pub(crate) fn read_array<'py>(py: Python<'py>, path: &str, name: &str) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let read = quick(py, || {
        let reader = Reader::open(path)?;
        Ok::<_, gfmd_files::FileError>((reader.shape(name)?, reader.values::<f64>(name)?))
    })?;
    let (shape, values) = read.map_err(|error| refused(py, &error))?;
    let array = ArrayD::from_shape_vec(IxDyn(&shape), values).map_err(|error| refused(py, &error))?;
    Ok(array.into_pyarray(py))
}

/// The scalars of each load in a file of a contact, as JSON.
#[pyfunction]
pub(crate) fn read_records(py: Python<'_>, path: &str) -> PyResult<Vec<String>> {
    let read = quick(py, || contact::records(&Reader::open(path)?))?;
    // A file that is not there is unusable input, like one of another kind.
    let records = read.map_err(|failure| refused(py, &failure))?;
    records.iter().map(|record| json::to_string(record).map_err(|error| refused(py, &error))).collect()
}

/// A text attribute of a file.
#[pyfunction]
pub(crate) fn read_text(py: Python<'_>, path: &str, group: &str, name: &str) -> PyResult<String> {
    quick(py, || Reader::open(path).and_then(|reader| reader.text(group, name)))?.map_err(|error| refused(py, &error))
}

/// The configuration of a result of `contact` as JSON: only keys and types that such results have.
#[pyfunction]
pub(crate) fn read_config(py: Python<'_>, path: &str) -> PyResult<String> {
    let read = quick(py, || configuration(&Reader::open(path)?))?;
    // A file that is not there is unusable input, like one of another kind.
    let table = read.map_err(|failure| refused(py, &failure))?;
    serde_json::to_string(&table).map_err(|error| refused(py, &error))
}
