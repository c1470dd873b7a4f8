//! Contacts under a load.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use gfmd_cli::contact::{Args, measure, stiffness};
use gfmd_contact::{
    Boundary, Conductance, ConductanceError, Conductors, Cotangents, Drive, Fields as _, Load, Progress, Refusal,
};
use gfmd_green::Height;
use gfmd_interface::StoredFields;
use gfmd_law::{Kind, Law};
use gfmd_problem::options::flags::{self, keys, of_keys};
use gfmd_problem::options::{BodyArgs, ComplianceArgs, LawArgs, Row};
use gfmd_problem::{Accuracy, Facts, Posed, Rest};
use gfmd_record::{At, NOT_SOLVED, OnFinerGrid, Record, STATISTICS};
use gfmd_run::accuracy;
use gfmd_run::failure::{Failure, reached};
use gfmd_run::json;
use gfmd_run::series::{ContactArgs, Field, Finer, Prepared, Slopes, beside, check_drive, fields};
use gfmd_run::session::Session;
use gfmd_run::source::SourceArgs;
use gfmd_run::units::of_table;
use gfmd_unit::Quantity;
use ndarray::{Array2, ArrayView2};
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use toml::Table;

use crate::command::{arrays, kind_and_text, table};
use crate::failure::{failed, refused, unreached};
use crate::surface::grid;
use crate::worker::{quick, run};

type Array<'py> = Bound<'py, PyArray2<f64>>;

/// The keys of the options of a contact beside its surface and its body.
#[pyfunction]
pub(crate) fn options() -> Vec<String> {
    let others = [keys::<SourceArgs>(), keys::<BodyArgs>()].concat();
    keys::<ContactArgs>().into_iter().filter(|key| !others.contains(key)).collect()
}

/// A law by its name, its parameters and the rows of its table.
fn law_of(py: Python<'_>, name: &str, param: Vec<(String, f64)>, law_table: Vec<[f64; 2]>) -> PyResult<Box<dyn Law>> {
    let law: Kind = name.parse().map_err(|error| refused(py, &error))?;
    if law != Kind::Table && law_table.is_empty() {
        return law.with(&param).map_err(|error| refused(py, &error));
    }
    LawArgs { law, param, law_table, coarse: false }.build().map_err(|error| refused(py, &error))
}

/// Checks the name and the parameters of a law, or its table.
#[pyfunction]
pub(crate) fn check_law(
    py: Python<'_>,
    name: &str,
    parameters: Vec<(String, f64)>,
    table: Vec<[f64; 2]>,
) -> PyResult<()> {
    law_of(py, name, parameters, table).map(|_| ())
}

/// Checks the table of compliances of a body, and the compliance of its mean level.
#[pyfunction]
pub(crate) fn check_compliance(py: Python<'_>, table: Vec<Vec<f64>>, uniform: f64) -> PyResult<()> {
    let row = |row: Vec<f64>| match row[..] {
        [q, g] => Ok(Row::Wavenumber([q, g])),
        [x, y, g] => Ok(Row::WaveVector([x, y, g])),
        _ => Err(refused(py, &format!("compliance has a row of {} numbers; it must have 2 or 3", row.len()))),
    };
    let table = table.into_iter().map(row).collect::<PyResult<_>>()?;
    let args = ComplianceArgs { compliance: table, uniform_compliance: Some(uniform) };
    let body = BodyArgs { young: Some(1.0), ..BodyArgs::default() };
    args.body(&body).map(|_| ()).map_err(|error| refused(py, &error))
}

/// The normal traction of a law at gaps.
#[pyfunction]
pub(crate) fn law_traction(
    py: Python<'_>,
    name: &str,
    parameters: Vec<(String, f64)>,
    table: Vec<[f64; 2]>,
    gaps: Vec<f64>,
) -> PyResult<Vec<f64>> {
    let law = law_of(py, name, parameters, table)?;
    Ok(gaps.into_iter().map(|gap| law.opening(gap).traction).collect())
}

/// The description of a contact: a dictionary with the keys of its options, and that of those that are arrays.
pub(crate) fn described(
    py: Python<'_>,
    problem: &Bound<'_, PyDict>,
    values: &Bound<'_, PyDict>,
) -> PyResult<ContactArgs> {
    let (mut table, arrays) = (table(problem)?, arrays(values)?);
    of_table("contact", &mut table, &arrays).map_err(|failure| refused(py, &failure))?;
    of_keys(table, arrays).map_err(|unusable| refused(py, &unusable))
}

/// The parts of a contact that was posed before, when all was told of them that is doubtful.
pub(crate) fn prepared(args: &ContactArgs) -> Result<Prepared, Failure> {
    let prepare = || Prepared::new(&args.asked()?, |line| args.facts(line), &Session::embedded());
    tracing::subscriber::with_default(tracing::subscriber::NoSubscriber::new(), prepare)
}

/// The numbers of the attraction of a contact, as JSON: `null` without one.
#[pyfunction]
pub(crate) fn adhesion(py: Python<'_>, problem: &Bound<'_, PyDict>, arrays: &Bound<'_, PyDict>) -> PyResult<String> {
    let args = described(py, problem, arrays)?;
    let found = quick(py, || prepared(&args).map(|prepared| prepared.adhesion))?;
    json::to_string(&found.map_err(|failure| failed(py, &failure))?).map_err(|error| refused(py, &error))
}

/// The conductance of the points that touch between two conductors with electrodes at this depth, or infinitely deep.
#[pyfunction]
pub(crate) fn conductance(
    py: Python<'_>,
    touching: PyReadonlyArray2<'_, bool>,
    lengths: [f64; 2],
    boundary: &str,
    height: f64,
) -> PyResult<f64> {
    let boundary: Boundary = boundary.parse().map_err(|error| refused(py, &error))?;
    let touching = touching.as_array().mapv(|touches| f64::from(u8::from(touches)));
    let grid = grid(py, touching.dim().into(), lengths)?;
    let height = if height == f64::INFINITY { Height::Infinite } else { Height::Finite(height) };
    let found = quick(py, || {
        let refuse = |error: Refusal| Failure::input("conductor_height", error);
        let conductors = Conductors::new(boundary, &grid, height).map_err(refuse)?;
        match &conductors.conductance(&touching) {
            Ok(Conductance { value, .. }) => Ok(*value),
            Err(inexact @ ConductanceError::Inexact { reached, .. }) => {
                tracing::warn!("{inexact}");
                Ok(reached.value)
            }
            Err(error) => Err(Failure::Computation(error.to_string())),
        }
    })?;
    found.map_err(|failure| failed(py, &failure))
}

/// A surface against a body.
#[pyclass(frozen, module = "gfmd._gfmd")]
pub(crate) struct Problem {
    args: ContactArgs,
    prepared: Prepared,
    contact: Posed,
    finer: Mutex<Vec<Finer>>,
}

/// A load at rest, to start the next one from.
#[pyclass(frozen, module = "gfmd._gfmd")]
pub(crate) struct State {
    rest: Rest,
    facts: Facts,
    /// The lift of a base that moves.
    lift: Option<Array2<f64>>,
    /// The numbers of a state that was solved.
    record: Option<Record>,
}

/// An array of a measured state.
#[derive(IntoPyObject)]
pub(crate) struct Measured {
    path: &'static str,
    kind: &'static str,
    meaning: &'static str,
    values: Vec<f64>,
    axis: Vec<f64>,
}

/// State, scalars as JSON; the kind and the text of a failure; an exception of a signal's handler.
type Solved = (State, String, Option<(&'static str, String)>, Option<Py<PyAny>>);

#[pymethods]
impl Problem {
    #[new]
    fn new(py: Python<'_>, problem: &Bound<'_, PyDict>, arrays: &Bound<'_, PyDict>, threads: usize) -> PyResult<Self> {
        let args = described(py, problem, arrays)?;
        let (made, raised) = run(py, threads, None, |_| {
            let (prepared, contact) = args.pose(&Session::embedded())?;
            let finer = Finer::pose(&args, &prepared)?;
            Ok::<_, Failure>((prepared, contact, Mutex::new(finer)))
        })?;
        raised.map_or(Ok(()), Err)?;
        // Nothing was computed yet: every refusal is one of the input.
        let (prepared, contact, finer) = made.map_err(|failure| refused(py, &failure))?;
        Ok(Self { args, prepared, contact, finer })
    }

    /// Brings the contact to rest under one load, which has the key `control`, from a state, or as the options ask.
    fn solve(
        &self,
        py: Python<'_>,
        control: &str,
        value: f64,
        start: Option<&State>,
        threads: usize,
        tick: Option<Py<PyAny>>,
    ) -> PyResult<Solved> {
        let Self { args, prepared, contact, finer } = self;
        let drive: Drive = match control {
            "pressure" => Load::MeanPressure(value),
            "p_star" => Load::MeanPressure(value * prepared.unit_pressure()),
            _ => Load::Approach(value),
        }
        .into();
        let (solved, raised) = run(py, threads, tick.as_ref(), |shared| {
            let mut watch = |now: &Progress| shared.see(now.iteration, now.residual);
            let tolerance = args.solver.tol;
            check_drive(contact, drive, &format!("--{}", control.replace('_', "-")), tolerance)?;
            let mut finer = finer.lock().unwrap_or_else(PoisonError::into_inner);
            if !finer.is_empty() {
                Facts { approach: matches!(drive.load, Load::Approach(_)), ..prepared.facts }.check()?;
                if start.is_some() && prepared.facts.has_law() && finer.iter().any(|finer| !finer.has_started()) {
                    let found = "refine, with start and a law, whose state on the finer grid is not known";
                    return Err(Failure::value("--grid-error", found, "none or estimate"));
                }
            }
            let first = match start {
                Some(_) => None,
                None => args.after_longer_ranges(prepared, drive, &mut watch)?,
            };
            let started = Instant::now();
            let start = start.map(|state| &state.rest).or(first.as_ref());
            let (state, failure) = reached(args.press(contact, drive).starting_from(start).watch(&mut watch).solve())?;
            let stiffness = match &failure {
                Some(_) => Err(NOT_SOLVED),
                None => stiffness(contact, &state, args.stiffness_tol, |text| tracing::warn!("{text}")),
            };
            let finer = finer.iter_mut().map(|finer| match &failure {
                Some(_) => Ok(Err(NOT_SOLVED.to_owned())),
                None => beside(finer.reach(drive, &mut watch).map(|(.., at)| OnFinerGrid::of(&at))),
            });
            let finer = finer.collect::<Result<_, Failure>>()?;
            let at = prepared.at(&state, tolerance);
            if let (None, Some(doubt)) = (&failure, prepared.doubt_of_edge(&state)) {
                tracing::warn!("{doubt}");
            }
            let (stiffness, seconds) = (stiffness.map_err(Into::into), started.elapsed().as_secs_f64());
            let facts = Facts { approach: matches!(drive.load, Load::Approach(_)), ..prepared.facts };
            let record = Record::of(&At { facts: &facts, stiffness, seconds, finer, ..at });
            Ok::<_, Failure>((state, record, failure))
        })?;
        let ((rest, record, failure), raised) = match (solved, raised) {
            (Ok(solved), raised) => (solved, raised),
            (Err(_), Some(raised)) if !raised.is_instance_of::<PyKeyboardInterrupt>(py) => return Err(raised),
            // Without a state, the load was refused, or one of a longer range was not reached.
            (Err(failure), _) => return Err(unreached(py, &failure)),
        };
        let text = json::to_string(&record).map_err(|error| refused(py, &error))?;
        let raised = raised.map(|error| error.into_value(py).into_any());
        Ok((self.state(rest, Some(record)), text, failure.map(kind_and_text), raised))
    }

    /// The number of a quantity with a unit, of this kind, in the units of the problem.
    fn value(&self, py: Python<'_>, name: &str, text: &str, kind: &str) -> PyResult<f64> {
        let refuse = |error: &dyn std::fmt::Display| refused(py, &format!("{name} is {text:?}: {error}"));
        let quantity = Quantity::parse(text).map_err(|error| refuse(&error))?;
        let quantity = quantity.ok_or_else(|| refuse(&"it must be a number, or a quantity with a unit"))?;
        self.prepared.surface.units().value(&quantity, kind).map_err(|error| refuse(&error))
    }

    /// The unit of stresses, if it is known.
    #[getter]
    fn stress_unit(&self) -> Option<String> {
        self.prepared.surface.stress().map(str::to_owned)
    }

    /// The warnings of units that are mixed up, of loads up to this one with the key `control`.
    fn doubts(&self, control: &str, largest: f64) -> Vec<String> {
        let mut doubts = self.prepared.doubts(self.prepared.adhesion.as_ref());
        let p_star = match control {
            "pressure" => largest / self.prepared.unit_pressure(),
            "p_star" => largest,
            _ => 0.0,
        };
        doubts.extend(self.prepared.doubt_of_load(p_star, &format!("--{}", control.replace('_', "-"))));
        doubts
    }

    /// The numbers that the statistics and the flow of a state add, as JSON, and its patches, distributions and
    /// spectra: their path, axis,
    /// kind, meaning, values and the points of the axis. `options` have the keys of `gfmd contact`.
    fn measure<'py>(
        &self,
        py: Python<'py>,
        state: &State,
        options: &Bound<'py, PyDict>,
    ) -> PyResult<(String, Vec<Measured>)> {
        let mut table = Table::try_from(&self.args).map_err(|error| refused(py, &error))?;
        // The error of the grid, and the load, are those of the state.
        table.remove("grid_error");
        table.insert("pressure".into(), vec![1.0].into());
        table.extend(crate::command::table(options)?);
        let args: Args = flags::of_table(table).map_err(|error| refused(py, &error))?;
        let (measured, raised) = run(py, 0, None, |_| {
            measure(&args, &self.prepared, &self.contact, &state.rest, |text| tracing::warn!("{text}"))
        })?;
        raised.map_or(Ok(()), Err)?;
        let (record, arrays) = measured.map_err(|failure| failed(py, &failure))?;
        let grid = &self.prepared.surface.grid;
        let arrays = arrays.iter().flat_map(|found| {
            STATISTICS.iter().map(move |statistic| Measured {
                path: statistic.path,
                kind: statistic.unit.unwrap_or("length"),
                meaning: statistic.meaning,
                values: (statistic.values)(found, 0),
                axis: found.axis(statistic.along, grid),
            })
        });
        Ok((json::to_string(&record).map_err(|error| refused(py, &error))?, arrays.collect()))
    }

    /// The derivatives of a number with respect to heights, load, modulus, and their relative error: from its own
    /// derivatives by the fields and numbers of a state under a mean pressure, or under an approach if that
    /// `is_driven`.
    fn vjp<'py>(
        &self,
        py: Python<'py>,
        state: &State,
        is_driven: bool,
        fields: BTreeMap<String, PyReadonlyArray2<'py, f64>>,
        numbers: BTreeMap<String, f64>,
    ) -> PyResult<(Array<'py>, f64, f64, f64)> {
        let field = |name: &str| fields.get(name).map(|field| field.as_array().to_owned());
        let number = |name: &str| numbers.get(name).copied().unwrap_or(0.0);
        let of = Cotangents {
            pressure: field("pressure"),
            gap: field("gap"),
            approach: number("approach"),
            mean_pressure: number("mean_pressure"),
            mean_gap: number("mean_gap"),
            elastic_energy: number("elastic_energy"),
        };
        let load = if is_driven {
            Load::Approach(state.rest.approach())
        } else {
            Load::MeanPressure(state.rest.mean_pressure())
        };
        let found = quick(py, || {
            self.prepared.facts.check_gradient()?;
            self.contact.gradient(&state.rest, load, &of)
        })?;
        let found = found.map_err(|error| refused(py, &error))?;
        Ok((found.heights.into_pyarray(py), found.load, found.modulus, found.error))
    }

    /// The options with their defaults, as JSON, but those of the surface beside its size.
    #[getter]
    fn description(&self, py: Python<'_>) -> PyResult<String> {
        let of_surface = keys::<SourceArgs>();
        let mut table = Table::try_from(&self.args).map_err(|error| refused(py, &error))?;
        table.retain(|key, _| matches!(key, "length" | "stress_unit") || !of_surface.iter().any(|of| of == key));
        json::to_string(&table).map_err(|error| refused(py, &error))
    }

    /// Checks that a finer grid makes the numbers more exact, and that this is known.
    fn check_accuracy(&self, py: Python<'_>, accuracy: &str, control: &str) -> PyResult<()> {
        let asked = accuracy.parse::<Accuracy>();
        let asked = asked.map_err(|error| refused(py, &format!("accuracy is {accuracy}; {error}")))?;
        accuracy::check(asked, &self.prepared, control == "displacement").map_err(|failure| refused(py, &failure))
    }

    /// The warning of strain that is not small at an approach; `None` if it is.
    fn strain(&self, approach: f64) -> Option<String> {
        self.prepared.doubt_of_strain(approach)
    }

    /// The warning of slopes that are not small, with the largest pressure of the loads; `None` if they are.
    fn slopes(&self, largest: f64) -> Option<String> {
        let Prepared { facts, surface, body, .. } = &self.prepared;
        let slopes = Slopes::of(surface.rms_gradient(), || surface.max_slope(), facts)?;
        Some(slopes.message(largest / body.contact_modulus()))
    }

    /// The state of a contact with these fields, to start from.
    fn recall(
        &self,
        py: Python<'_>,
        fields: BTreeMap<String, PyReadonlyArray2<'_, f64>>,
        approach: f64,
    ) -> PyResult<State> {
        let field = |name: &str| fields.get(name).map(PyReadonlyArray2::as_array);
        let missing = || refused(py, &"start has no fields");
        let pressure = field("pressure").ok_or_else(missing)?;
        let displacement = field("displacement_z").ok_or_else(missing)?;
        let gap = field("gap").ok_or_else(missing)?;
        let lower = field("lower_pressure");
        let made = quick(py, || {
            let own = self.prepared.lift().map(|lift| &displacement - lift);
            let displacement = own.as_ref().map_or(displacement, |own| own.view());
            let kept = StoredFields { pressure: &pressure, displacement_z: &displacement, gap: &gap, approach };
            self.contact.recall(kept, lower.as_deref()).map_err(|error: Refusal| Failure::input("start", error))
        })?;
        made.map(|rest| self.state(rest, None)).map_err(|failure| failed(py, &failure))
    }

    fn __repr__(&self) -> String {
        let [nx, ny] = self.prepared.surface.grid.points();
        format!("<a contact of {nx} x {ny} points>")
    }
}

impl Problem {
    fn state(&self, rest: Rest, record: Option<Record>) -> State {
        State { rest, record, facts: self.prepared.facts, lift: self.prepared.lift().cloned() }
    }
}

#[pymethods]
impl State {
    /// The points along each side over those of the state that its numbers need for an accuracy; 1 if they are that
    /// exact.
    fn times(&self, py: Python<'_>, accuracy: &str) -> PyResult<u64> {
        let asked: Accuracy = accuracy.parse().map_err(|error| refused(py, &error))?;
        let worst = self.record.as_ref().and_then(|record| accuracy::worst(std::slice::from_ref(record), asked));
        Ok(worst.map_or(1, |worst| worst.times))
    }

    /// The fields with their names, in the order of a file. Those that the state has are without a copy: the arrays
    /// keep it alive.
    #[getter]
    fn fields(this: Bound<'_, Self>) -> Vec<(&'static str, Array<'_>)> {
        let Self { rest, facts, lift, .. } = this.get();
        let array = |Field { name, values, .. }: Field<'_>| {
            let array = if values.is_view() {
                lent(&this, &values.view())
            } else {
                values.into_owned().into_pyarray(this.py())
            };
            (name, array)
        };
        fields(facts, rest, lift.as_ref()).into_iter().map(array).collect()
    }
}

/// A field of a state as a read-only array.
fn lent<'py>(state: &Bound<'py, State>, field: &ArrayView2<'_, f64>) -> Array<'py> {
    #[expect(unsafe_code, reason = "the array lends the memory of the state")]
    // SAFETY: the state is the base of the array, and, being frozen, never moves or changes its fields.
    let array = unsafe { PyArray2::borrow_from_array(field, state.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    array
}
