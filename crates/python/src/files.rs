//! Result files, written as the program writes them and read array by array.

use std::path::Path;

use gfmd_check::result::ResultKind;
use gfmd_cli::contact::{self, configuration};
use gfmd_files::{Output, Reader};
use gfmd_input::failure::Failure;
use gfmd_input::json;
use gfmd_input::session::Session;
use gfmd_record::{Record, SLIDING_FIELDS, arrays};
use gfmd_run::series::{Chosen, Prepared, StateFile};
use ndarray::{Array2, ArrayD, IxDyn};
use numpy::{IntoPyArray, PyArrayDyn, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::command::table;
use crate::contact::{described, prepared};
use crate::failure::{failed, refused, unusable};
use crate::worker::quick;

/// Scalars as JSON, and fields in file order.
type Load<'py> = (String, Vec<PyReadonlyArray2<'py, f64>>);

/// Unit and description of a surface.
type Words = (Option<String>, String);

/// Writes the loads of one problem, given in the form that [`Problem`](crate::contact::Problem) takes, with the unit
/// and description of its surface, and of the lower surface if there is one.
#[pyfunction]
pub(crate) fn save(
    py: Python<'_>,
    path: &str,
    problem: &Bound<'_, PyDict>,
    arrays: &Bound<'_, PyDict>,
    words: Vec<Words>,
    loads: Vec<Load<'_>>,
    config: &Bound<'_, PyDict>,
) -> PyResult<()> {
    let (args, _) = described(py, problem, arrays)?;
    let config = table(config)?;
    let approach = config.contains_key("approach");
    let config = toml::to_string(&config).map_err(|error| refused(py, &error))?;
    let prepared = quick(py, || prepared(&args))?;
    let mut prepared = prepared.map_err(|failure| failed(py, failure))?;
    let Prepared { surface, lower, facts, .. } = &mut prepared;
    facts.approach = approach;
    for (surface, (unit, description)) in std::iter::once(surface).chain(lower).zip(words) {
        (surface.unit, surface.description, surface.scan) = (unit, description, None);
    }
    let mut records = Vec::new();
    let mut fields: Vec<Vec<Array2<f64>>> = Vec::new();
    for (record, of_load) in loads {
        let record: serde_json::Value = serde_json::from_str(&record).map_err(|error| refused(py, &error))?;
        records.push(Record::from_json(&prepared.facts, &record).map_err(|error| refused(py, &error))?);
        fields.push(of_load.iter().map(|field| field.as_array().to_owned()).collect());
    }
    let written = quick(py, || {
        let output = Output::claim(Path::new(path)).map_err(|error| Failure::input("path", error))?;
        let session = Session::embedded();
        let provenance = session.provenance(config);
        let mut file = StateFile::of(Some(&output), &provenance, &prepared, records.len(), (Chosen::All, &session))?;
        for (index, fields) in fields.iter().enumerate() {
            file.write_fields(index, fields.iter().map(|field| field.view().into()))?;
        }
        file.finish(&records, records.len(), None).map(|_| ())
    })?;
    written.map_err(|failure| failed(py, failure))
}

/// Reads an array of a file.
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

/// Reads the scalars of each load in a contact file, as JSON, and the names of its fields.
#[pyfunction]
pub(crate) fn read_records(py: Python<'_>, path: &str) -> PyResult<(Vec<String>, Vec<&'static str>)> {
    let read = quick(py, || {
        let reader = Reader::open(path)?;
        let (facts, records) = contact::records(&reader)?;
        // Files of earlier versions have no repulsion.
        let there = |name: &&str| *name != "repulsion" || reader.contains(&format!("/fields/{name}"));
        Ok::<_, Failure>((records, arrays(&facts).map(|array| array.name).filter(there).collect()))
    })?;
    // A missing file is unusable input, like a file of another kind.
    let (records, fields) = read.map_err(|failure| unusable(py, failure))?;
    let texts = records.iter().map(|record| json::to_string(record).map_err(|error| refused(py, &error)));
    Ok((texts.collect::<PyResult<_>>()?, fields))
}

/// Reads the report of any result but a contact in a file, as JSON, and the names of its fields.
#[pyfunction]
pub(crate) fn read_report(py: Python<'_>, path: &str) -> PyResult<(String, Vec<String>)> {
    let read = quick(py, || {
        let reader = Reader::open(path)?;
        let session = Session::embedded();
        let there = |name: &&str| reader.contains(&format!("/fields/{name}"));
        let names = |names: &mut dyn Iterator<Item = &'static str>| names.filter(there).map(Into::into).collect();
        Ok::<_, Failure>(match ResultKind::of(&reader) {
            Some(ResultKind::Path) => {
                let report = gfmd_cli::path::stored(&reader, &session)?;
                (json::to_string(&report), names(&mut arrays(&report.facts).map(|array| array.name)))
            }
            Some(ResultKind::Slide) => {
                let report = gfmd_cli::slide::stored(&reader, &session)?;
                (json::to_string(&report), names(&mut SLIDING_FIELDS.iter().map(|field| field.name)))
            }
            Some(ResultKind::Punch) => {
                (json::to_string(&gfmd_cli::punch::stored(&reader, &session)?), reader.names("/fields"))
            }
            Some(ResultKind::Body) => (json::to_string(&gfmd_cli::body::stored(&reader)?), reader.names("/fields")),
            Some(ResultKind::KappaSweep) => (json::to_string(&gfmd_cli::kappa_sweep::report_of(&reader)?), Vec::new()),
            Some(ResultKind::Study) => (json::to_string(&gfmd_cli::study::report_of(&reader)?), Vec::new()),
            Some(ResultKind::Contact) | None => return Err(Failure::input(path, "it has no report of a command")),
        })
    })?;
    let (text, fields) = read.map_err(|failure| unusable(py, failure))?;
    Ok((text.map_err(|error| refused(py, &error))?, fields))
}

/// Reads the kind of a file, the name of its command; refuses a file that was damaged or changed.
#[pyfunction]
pub(crate) fn read_kind(py: Python<'_>, path: &str) -> PyResult<Option<&'static str>> {
    let read = quick(py, || {
        let reader = Reader::open(path).map_err(|error| Failure::refused(error.to_string()))?;
        let kind = ResultKind::of(&reader).map(ResultKind::name);
        let is_surface = || kind.is_none() && reader.contains("/surface/height");
        if reader.is_intact()? == Some(false) {
            return Err(Failure::input(path, "it is damaged, or was changed; gfmd check says where"));
        }
        Ok::<_, Failure>(if is_surface() { Some("surface") } else { kind })
    })?;
    read.map_err(|failure| unusable(py, failure))
}

/// Reads a text attribute of a file.
#[pyfunction]
pub(crate) fn read_text(py: Python<'_>, path: &str, group: &str, name: &str) -> PyResult<String> {
    quick(py, || Reader::open(path).and_then(|reader| reader.text(group, name)))?.map_err(|error| refused(py, &error))
}

/// Reads the configuration of a `contact` result as JSON. It has only keys and types that such results have.
#[pyfunction]
pub(crate) fn read_config(py: Python<'_>, path: &str) -> PyResult<String> {
    let read = quick(py, || configuration(&Reader::open(path)?))?;
    // A missing file is unusable input, like a file of another kind.
    let table = read.map_err(|failure| unusable(py, failure))?;
    serde_json::to_string(&table).map_err(|error| refused(py, &error))
}
