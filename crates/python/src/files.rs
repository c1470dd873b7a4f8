//! Result files, written as the program writes them and read array by array.

use std::path::Path;

use gfmd_check::result::ResultKind;
use gfmd_cli::contact::{self, configuration};
use gfmd_files::{FileError, Output, Reader};
use gfmd_input::failure::Failure;
use gfmd_input::json;
use gfmd_input::session::Session;
use gfmd_input::source::stored_unit;
use gfmd_record::{Record, SLIDING_FIELDS, arrays};
use gfmd_run::series::{Chosen, Prepared, StateFile};
use ndarray::{Array2, ArrayD, IxDyn};
use numpy::{IntoPyArray, PyArrayDyn, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

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

/// Open result file.
#[pyclass(frozen, module = "gfmd._gfmd")]
pub(crate) struct StoredFile(Reader);

/// Groups of the arrays that a result in memory has.
const IN_MEMORY: [&str; 4] = ["/fields/", "/surface/", "/lower/", "/base/"];

#[pymethods]
impl StoredFile {
    #[new]
    fn open(py: Python<'_>, path: &str) -> PyResult<Self> {
        let reader = quick(py, || Reader::open(path))?;
        // A missing file is unusable input, like a file of another kind.
        reader.map(Self).map_err(|error| refused(py, &error))
    }

    /// Name of the file.
    #[getter]
    fn path(&self) -> String {
        self.0.path().display().to_string()
    }

    /// Kind of the file, the name of its command.
    #[getter]
    fn kind(&self) -> Option<&'static str> {
        let kind = ResultKind::of(&self.0).map(ResultKind::name);
        if kind.is_none() && self.0.contains("/surface/height") { Some("surface") } else { kind }
    }

    /// Refuses a file that was damaged or changed. Keeps the arrays, which `array` then gives without a second read.
    fn check(&self, py: Python<'_>) -> PyResult<()> {
        let is_array = |path: &str| IN_MEMORY.iter().any(|group| path.starts_with(group));
        match quick(py, || self.0.is_intact_keeping(&is_array))?.map_err(Failure::from) {
            Ok(Some(false)) => {
                Err(unusable(py, Failure::input(self.path(), "it is damaged, or was changed; gfmd check says where")))
            }
            found => found.map(|_| ()).map_err(|failure| unusable(py, failure)),
        }
    }

    /// Reads an array.
    fn array<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
        let read = quick(py, || Ok::<_, FileError>((self.0.shape(name)?, self.0.take(name)?)))?;
        let (shape, values) = read.map_err(|error| refused(py, &error))?;
        let array = ArrayD::from_shape_vec(IxDyn(&shape), values).map_err(|error| refused(py, &error))?;
        Ok(array.into_pyarray(py))
    }

    /// Reads lengths and unit of the cell of a surface, which are in its group.
    fn cell(&self, py: Python<'_>, group: &str) -> PyResult<([f64; 2], Option<String>)> {
        let length = |name| self.0.number(group, name).map_err(|error| refused(py, &error));
        Ok(([length("size_x")?, length("size_y")?], stored_unit(&self.0, group)))
    }

    /// Reads a text attribute.
    fn text(&self, py: Python<'_>, group: &str, name: &str) -> PyResult<String> {
        self.0.text(group, name).map_err(|error| refused(py, &error))
    }

    /// Reads all bytes.
    fn bytes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let bytes = quick(py, || self.0.bytes())?.map_err(|error| refused(py, &error))?;
        Ok(PyBytes::new(py, &bytes))
    }

    /// Reads the configuration of a `contact` result as JSON. It has only keys and types that such results have.
    fn config(&self, py: Python<'_>) -> PyResult<String> {
        let table = quick(py, || configuration(&self.0))?.map_err(|failure| unusable(py, failure))?;
        serde_json::to_string(&table).map_err(|error| refused(py, &error))
    }

    /// Reads the scalars of each load of a contact, as JSON, and the names of its fields.
    fn records(&self, py: Python<'_>) -> PyResult<(Vec<String>, Vec<&'static str>)> {
        let reader = &self.0;
        let read = quick(py, || {
            let (facts, records) = contact::records(reader)?;
            // Files of earlier versions have no repulsion.
            let there = |name: &&str| *name != "repulsion" || reader.contains(&format!("/fields/{name}"));
            Ok::<_, Failure>((records, arrays(&facts).map(|array| array.name).filter(there).collect()))
        })?;
        let (records, fields) = read.map_err(|failure| unusable(py, failure))?;
        let texts = records.iter().map(|record| json::to_string(record).map_err(|error| refused(py, &error)));
        Ok((texts.collect::<PyResult<_>>()?, fields))
    }

    /// Reads the report of any result but a contact, as JSON, and the names of its fields.
    fn report(&self, py: Python<'_>) -> PyResult<(String, Vec<String>)> {
        let reader = &self.0;
        let read = quick(py, || {
            let session = Session::embedded();
            let there = |name: &&str| reader.contains(&format!("/fields/{name}"));
            let names = |names: &mut dyn Iterator<Item = &'static str>| names.filter(there).map(Into::into).collect();
            Ok::<_, Failure>(match ResultKind::of(reader) {
                Some(ResultKind::Path) => {
                    let report = gfmd_cli::path::stored(reader, &session)?;
                    (json::to_string(&report), names(&mut arrays(&report.facts).map(|array| array.name)))
                }
                Some(ResultKind::Slide) => {
                    let report = gfmd_cli::slide::stored(reader, &session)?;
                    (json::to_string(&report), names(&mut SLIDING_FIELDS.iter().map(|field| field.name)))
                }
                Some(ResultKind::Punch) => {
                    (json::to_string(&gfmd_cli::punch::stored(reader, &session)?), reader.names("/fields"))
                }
                Some(ResultKind::Body) => (json::to_string(&gfmd_cli::body::stored(reader)?), reader.names("/fields")),
                Some(ResultKind::KappaSweep) => {
                    (json::to_string(&gfmd_cli::kappa_sweep::report_of(reader)?), Vec::new())
                }
                Some(ResultKind::Study) => (json::to_string(&gfmd_cli::study::report_of(reader)?), Vec::new()),
                Some(ResultKind::Contact) | None => {
                    return Err(Failure::input(reader.path().display().to_string(), "it has no report of a command"));
                }
            })
        })?;
        let (text, fields) = read.map_err(|failure| unusable(py, failure))?;
        Ok((text.map_err(|error| refused(py, &error))?, fields))
    }
}
