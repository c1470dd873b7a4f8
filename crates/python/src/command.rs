//! Commands of the program, run in this process.

use std::collections::BTreeMap;
use std::io::Write as _;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use gfmd_cli::inputs::stay_in;
use gfmd_cli::path::Derivatives;
use gfmd_cli::program::{Command, status, tune_allocator};
use gfmd_contact::Cotangents;
use gfmd_files::{Draft, Memory, Output};
use gfmd_input::failure::{Failure, Outcome};
use gfmd_input::session::Session;
use gfmd_interface::PathGradient;
use gfmd_problem::options::given::{ArrayOption, Arrays, StoredLoad};
use ndarray::{Array2, Array3, ArrayD, Axis};
use numpy::{IntoPyArray, PyArray2, PyArrayDyn, PyReadonlyArray3, PyReadonlyArrayDyn};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyInt};
use toml::{Table, Value};

use crate::failure::{failed, refused, spelled, unusable};
use crate::worker::{self, Shared, quick};

/// Time between two checks for an interruption.
const PAUSE: Duration = Duration::from_millis(20);

/// Report as JSON, kind and text of a failure, fields of the result by name, and the rest of its file.
type Solved<'py> =
    (String, Option<(&'static str, String)>, BTreeMap<String, Bound<'py, PyArrayDyn<f64>>>, Option<FileDraft>);

/// Result file without its fields.
#[pyclass(frozen, module = "gfmd._gfmd")]
pub(crate) struct FileDraft(Draft);

#[pymethods]
impl FileDraft {
    /// Writes the file with `fields`, the fields of the result by name.
    fn write(&self, py: Python<'_>, path: &str, fields: BTreeMap<String, PyReadonlyArrayDyn<'_, f64>>) -> PyResult<()> {
        let whole = |field: PyReadonlyArrayDyn<'_, f64>| field.as_array().as_standard_layout().into_owned();
        let fields = fields.into_iter().map(|(name, field)| (format!("{FIELDS}{name}"), whole(field))).collect();
        let written = quick(py, || {
            let output = Output::claim(path).map_err(|error| Failure::input("path", error))?;
            self.0.write(&output, &fields).map_err(Failure::from)
        })?;
        written.map(|_| ()).map_err(|failure| failed(py, failure))
    }
}

/// Group of the fields in a file.
const FIELDS: &str = "/fields/";

/// Replaces the contents of a file.
#[pyfunction]
pub(crate) fn write_file(py: Python<'_>, path: &str, contents: &[u8]) -> PyResult<()> {
    let output = Output::claim(path).map_err(|error| refused(py, &format!("path: {error}")))?;
    output.write(|file| file.write_all(contents)).map_err(|error| failed(py, error.into()))
}

/// Solves the problem given as a dictionary with the keys of a command's flags; its arrays are in a second one. If
/// `out` is given, writes the result to that file, with `words` as the description of its surface.
#[pyfunction]
#[pyo3(signature = (command, problem, arrays=None, threads=0, tick=None, out=None, words=None))]
#[expect(clippy::too_many_arguments, reason = "keywords")]
pub(crate) fn solve<'py>(
    py: Python<'py>,
    command: &str,
    problem: &Bound<'py, PyDict>,
    arrays: Option<&Bound<'py, PyDict>>,
    threads: usize,
    tick: Option<Py<PyAny>>,
    out: Option<&str>,
    words: Option<&str>,
) -> PyResult<Solved<'py>> {
    let problem = table(problem)?;
    let named = out.map(|out| ("out".to_owned(), Value::from(out)));
    stay_in(&problem.clone().into_iter().chain(named).collect()).map_err(|failure| unusable(py, failure))?;
    let output = out.map(Output::claim).transpose().map_err(|error| refused(py, &format!("out: {error}")))?;
    let arrays = arrays.map_or_else(|| Ok(Arrays::new()), self::arrays)?;
    let (command, written) = Command::of(command, problem, arrays).map_err(|failure| unusable(py, failure))?;
    let memory = Memory::default();
    let session = Session::embedded().with_written(written);
    let session = if let Command::KappaSweep(_) | Command::Study(_) = command {
        session
    } else {
        session.in_memory(memory.clone())
    };
    let (result, raised) = worker::run(py, threads, tick.as_ref(), |shared| {
        stoppable(shared, &session, || {
            command
                .outcome(&session)
                .and_then(|Outcome { report, failure }| Ok((report.json(&session)?, failure.map(kind_and_text))))
        })
    })?;
    // An interruption keeps the result so far; any other exception of a signal handler is passed on to the caller.
    let raised = match raised {
        Some(error) if !error.is_instance_of::<PyKeyboardInterrupt>(py) => return Err(error),
        other => other,
    };
    let (text, failure) = result.map_err(|failure| failed(py, failure))?;
    let failure = failure.or_else(|| raised.map(|_| ("interrupted", "interrupted at the end".into())));
    let (fields, mut draft) = memory.take(FIELDS);
    if let Some(draft) = &mut draft {
        words.into_iter().for_each(|words| draft.replace("/surface", "description", words));
        if let Some(output) = &output {
            quick(py, || draft.write(output, &fields))?.map_err(|error| failed(py, error.into()))?;
        }
    }
    let field = |(path, values): (String, ArrayD<f64>)| (path.replacen(FIELDS, "", 1), values.into_pyarray(py));
    Ok((text, failure, fields.into_iter().map(field).collect(), draft.map(FileDraft)))
}

/// Does `work` in a session, which is interrupted when the caller asks to stop.
fn stoppable<T>(shared: &Shared, session: &Session, work: impl FnOnce() -> T) -> T {
    let (finished, wait) = channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            // The sender is dropped when the work ends, also by a panic.
            while wait.recv_timeout(PAUSE) == Err(RecvTimeoutError::Timeout) {
                if shared.show(session.meter().read()).is_break() {
                    session.interrupt();
                }
            }
        });
        let result = work();
        drop(finished);
        result
    })
}

/// Derivatives along a path, with the names of `PathGradient` in Python, and mean pressure and approach at the end of
/// each step of the path that was followed again.
#[derive(IntoPyObject)]
pub(crate) struct OfPath<'py> {
    heights: Bound<'py, PyArray2<f64>>,
    loads: Vec<f64>,
    lateral: Vec<[f64; 2]>,
    modulus: f64,
    friction: f64,
    shear_strength: f64,
    hardness: Option<Bound<'py, PyArray2<f64>>>,
    wear_by_distance: f64,
    wear_by_slip: f64,
    error: f64,
    reached: Vec<[f64; 2]>,
}

/// Returns the derivatives of a scalar along a path, which is followed again. The inputs are its derivatives with
/// respect to the fields at the waypoints and to the numbers of the steps.
#[pyfunction]
#[pyo3(signature = (problem, arrays, fields, numbers, threads=0, tick=None))]
pub(crate) fn path_vjp<'py>(
    py: Python<'py>,
    problem: &Bound<'py, PyDict>,
    arrays: &Bound<'py, PyDict>,
    fields: BTreeMap<String, PyReadonlyArray3<'py, f64>>,
    numbers: BTreeMap<String, Vec<f64>>,
    threads: usize,
    tick: Option<Py<PyAny>>,
) -> PyResult<OfPath<'py>> {
    let command = Command::of("path", table(problem)?, self::arrays(arrays)?);
    let (Command::Path(args), _) = command.map_err(|failure| unusable(py, failure))? else {
        return Err(refused(py, &"the command is no path"));
    };
    let fields: BTreeMap<String, Array3<f64>> =
        fields.into_iter().map(|(name, field)| (name, field.as_array().to_owned())).collect();
    let of = |step: usize, waypoint: Option<usize>| {
        let field = |name: &str| Some(fields.get(name)?.index_axis(Axis(0), waypoint?).to_owned());
        let number = |name: &str| numbers.get(name).and_then(|values| values.get(step)).copied().unwrap_or(0.0);
        Cotangents {
            pressure: field("pressure"),
            gap: field("gap"),
            approach: number("approach"),
            mean_pressure: number("mean_pressure"),
            mean_gap: number("mean_gap"),
            elastic_energy: number("elastic_energy"),
            plastic_depth: field("plastic_depth"),
            shear: stacked([field("shear_x"), field("shear_y")]),
            mean_shear: [number("mean_shear_x"), number("mean_shear_y")],
        }
    };
    let session = Session::embedded();
    let (found, raised) = worker::run(py, threads, tick.as_ref(), |shared| {
        // The warnings were given when the path was followed first.
        let silent = tracing::subscriber::NoSubscriber::new();
        tracing::subscriber::with_default(silent, || {
            stoppable(shared, &session, || gfmd_cli::path::derivatives(&args, of, &session))
        })
    })?;
    raised.map_or(Ok(()), Err)?;
    let Derivatives { gradient, reached } = found.map_err(|failure| failed(py, failure))?;
    let PathGradient { heights, loads, lateral, modulus, friction, shear_strength, hardness, wear, error, .. } =
        gradient;
    Ok(OfPath {
        heights: heights.into_pyarray(py),
        loads,
        lateral,
        modulus,
        friction,
        shear_strength,
        hardness: hardness.map(|by| by.into_pyarray(py)),
        wear_by_distance: wear.by_distance,
        wear_by_slip: wear.by_slip,
        error,
        reached,
    })
}

/// Returns the components of a vector as one field `[component, x, y]`; of one component if the second is left out.
fn stacked([x, y]: [Option<Array2<f64>>; 2]) -> Option<Array3<f64>> {
    let shape = x.as_ref().or(y.as_ref())?.raw_dim();
    let x = x.unwrap_or_else(|| Array2::zeros(shape));
    // A profile has no shear along y.
    let components = if y.is_some() || shape[1] > 1 { 2 } else { 1 };
    let fields = [Some(x), y];
    let mut all = Array3::zeros((components, shape[0], shape[1]));
    all.outer_iter_mut().zip(fields.into_iter().flatten()).for_each(|(mut own, field)| own.assign(&field));
    Some(all)
}

/// Returns the kind and the text of a failure with a state.
pub(crate) fn kind_and_text(failure: Failure) -> (&'static str, String) {
    let kind = if let Failure::Interrupted(_) = failure { "interrupted" } else { "not converged" };
    (kind, spelled(&failure))
}

/// Converts a dictionary of NumPy arrays, or of configuration and values of a contact. Skips `None`.
pub(crate) fn arrays(values: &Bound<'_, PyDict>) -> PyResult<Arrays> {
    let array = |value: &Bound<'_, PyAny>| -> PyResult<ArrayD<f64>> {
        Ok(value.extract::<PyReadonlyArrayDyn<'_, f64>>()?.as_array().as_standard_layout().into_owned())
    };
    let given = values.iter().filter(|(_, value)| !value.is_none());
    let given = given.map(|(key, value)| {
        let given = match value.extract::<(Bound<'_, PyDict>, BTreeMap<String, Bound<'_, PyAny>>)>() {
            Ok((config, values)) => {
                let values = values.into_iter().map(|(name, value)| Ok((name, array(&value)?)));
                ArrayOption::Load(Arc::new(StoredLoad {
                    config: table(&config)?,
                    values: values.collect::<PyResult<_>>()?,
                }))
            }
            Err(_) => ArrayOption::Array(Arc::new(array(&value)?)),
        };
        Ok((key.extract()?, given))
    });
    given.collect()
}

/// Converts a dictionary to a TOML table. Entries that are `None` are left out.
pub(crate) fn table(values: &Bound<'_, PyDict>) -> PyResult<Table> {
    let given = values.iter().filter(|(_, value)| !value.is_none());
    let entry = |(key, value): (Bound<'_, PyAny>, _)| {
        let key: String = key.extract()?;
        let value = entry(&key, &value)?;
        Ok((key, value))
    };
    given.map(entry).collect()
}

fn entry(key: &str, value: &Bound<'_, PyAny>) -> PyResult<Value> {
    if let Ok(flag) = value.extract::<bool>() {
        return Ok(flag.into());
    }
    if value.is_instance_of::<PyInt>() {
        let whole = value.extract::<i64>().map_err(|_| {
            let error = format!("{key} is {value}; it must be between {} and {}", i64::MIN, i64::MAX);
            refused(value.py(), &error)
        })?;
        return Ok(whole.into());
    }
    if let Ok(text) = value.extract::<String>() {
        return Ok(text.into());
    }
    if let Ok(inner) = value.cast::<PyDict>() {
        return table(inner).map(Value::Table);
    }
    match value.extract::<f64>() {
        Ok(number) => Ok(number.into()),
        Err(_) => {
            let values = value.try_iter().map_err(|_| {
                let found = value.get_type().name().map(|name| name.to_string()).unwrap_or_default();
                let error = format!("{key} has a value of type {found}; it must be a number, text, list or dictionary");
                refused(value.py(), &error)
            })?;
            Ok(Value::Array(values.map(|value| entry(key, &value?)).collect::<PyResult<_>>()?))
        }
    }
}

/// Writes the report page for a result file.
#[pyfunction]
pub(crate) fn write_page(py: Python<'_>, path: &str, page: &str) -> PyResult<()> {
    let files: toml::Table =
        [("file".to_owned(), Value::from(path)), ("out".to_owned(), page.into())].into_iter().collect();
    stay_in(&files).map_err(|failure| unusable(py, failure))?;
    let written = quick(py, || gfmd_cli::report::write_page(Path::new(path), Path::new(page), &Session::embedded()))?;
    written.map(|_| ()).map_err(|failure| failed(py, failure))
}

/// Returns the figures of the report page for a result file as SVG, by name.
#[pyfunction]
pub(crate) fn figures(py: Python<'_>, path: &str) -> PyResult<Vec<(String, String)>> {
    let drawn = quick(py, || gfmd_cli::report::figures(Path::new(path), &Session::embedded()))?;
    drawn.map_err(|failure| failed(py, failure))
}

/// Runs the program `gfmd` with `words`, starting with its name, and returns the exit status.
#[pyfunction]
pub(crate) fn program(py: Python<'_>, words: Vec<std::ffi::OsString>) -> u8 {
    tune_allocator(); // the process belongs to the program
    py.detach(|| status("gfmd", words, Command::run))
}
