//! Contacts under a load.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use gfmd_cli::contact::{Args, measure};
use gfmd_cli::kinds::kinds;
use gfmd_contact::{
    Boundary, Conductance, ConductanceError, Conductors, Cotangents, Drive, Fields as _, Load, Progress, Refusal,
};
use gfmd_green::Height;
use gfmd_input::base::MovedBase;
use gfmd_input::failure::{Failure, reached};
use gfmd_input::json;
use gfmd_input::session::Session;
use gfmd_input::source::SourceArgs;
use gfmd_input::units::of_table;
use gfmd_interface::StoredFields;
use gfmd_law::{Law, LawKind};
use gfmd_measure::{GapGas, Gas};
use gfmd_problem::options::flags::{self, keys, of_keys};
use gfmd_problem::options::{BodyArgs, ComplianceArgs, LawArgs, Row};
use gfmd_problem::{Accuracy, AnyState, Facts, Posed, Spelling, Written, key};
use gfmd_record::{NOT_SOLVED, OnFinerGrid, Record, StateContext, statistics_of};
use gfmd_run::accuracy;
use gfmd_run::series::{ContactArgs, Field, Finer, Prepared, Slopes, beside, check_drive, fields};
use gfmd_unit::Quantity;
use ndarray::ArrayView2;
use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use toml::Table;

use crate::command::{arrays, kind_and_text, table};
use crate::failure::{failed, refused, unreached, unusable};
use crate::surface::grid;
use crate::worker::{quick, run};

type Array<'py> = Bound<'py, PyArray2<f64>>;

/// Returns the keys of the contact options, without those for surface and body.
#[pyfunction]
pub(crate) fn options() -> Vec<String> {
    let others = [keys::<SourceArgs>(), keys::<BodyArgs>()].concat();
    keys::<ContactArgs>().into_iter().filter(|key| !others.contains(key)).collect()
}

/// Builds a law from its name, its parameters and the rows of its table.
fn law_of(py: Python<'_>, name: &str, param: Vec<(String, f64)>, law_table: Vec<[f64; 2]>) -> PyResult<Box<dyn Law>> {
    let law: LawKind = name.parse().map_err(|error| refused(py, &error))?;
    if law != LawKind::Table && law_table.is_empty() {
        return law.with(&param).map_err(|error| refused(py, &error));
    }
    LawArgs { law, param, law_table, coarse: false }.build().map_err(|error| unusable(py, error))
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

/// Checks the compliance table of a body, and the compliance of its mean level.
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
    args.body(&body).map(|_| ()).map_err(|error| unusable(py, error))
}

/// Returns the normal traction of a law at each gap.
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

/// Parses a contact from a dictionary with the keys of its options and a second one with its arrays; with the
/// quantities as they were written.
pub(crate) fn described(
    py: Python<'_>,
    problem: &Bound<'_, PyDict>,
    values: &Bound<'_, PyDict>,
) -> PyResult<(ContactArgs, Written)> {
    let (mut table, arrays) = (table(problem)?, arrays(values)?);
    let written = of_table("contact", &mut table, &arrays, kinds()).map_err(|failure| unusable(py, failure))?;
    let args = of_keys(table, arrays).map_err(|error| unusable(py, error.as_written(&written)))?;
    Ok((args, written))
}

/// Prepares the parts of a contact that was posed before, without repeating its warnings.
pub(crate) fn prepared(args: &ContactArgs) -> Result<Prepared, Failure> {
    let prepare = || Prepared::new(&args.asked()?, args.series(), &Session::embedded());
    tracing::subscriber::with_default(tracing::subscriber::NoSubscriber::new(), prepare)
}

/// Returns the numbers of a contact's attraction as JSON; `null` without attraction.
#[pyfunction]
pub(crate) fn adhesion(py: Python<'_>, problem: &Bound<'_, PyDict>, arrays: &Bound<'_, PyDict>) -> PyResult<String> {
    let (args, _) = described(py, problem, arrays)?;
    let found = quick(py, || prepared(&args).map(|prepared| prepared.adhesion))?;
    json::to_string(&found.map_err(|failure| failed(py, failure))?).map_err(|error| refused(py, &error))
}

/// Returns the conductance of the touching points between two conductors with electrodes at depth `height`.
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
            Err(error) => Err(Failure::computation(error.to_string())),
        }
    })?;
    found.map_err(|failure| failed(py, failure))
}

/// Returns the conductivity in W/(m K) and the temperature-jump length in m of a gas, by its name, at a temperature in
/// K and a pressure in Pa; with the accommodation coefficients of engineering surfaces if none are given.
#[pyfunction]
pub(crate) fn gas_in_gap(
    py: Python<'_>,
    name: &str,
    temperature: Option<f64>,
    pressure: Option<f64>,
    accommodation: Option<[f64; 2]>,
) -> PyResult<(f64, f64)> {
    let Some(gas) = Gas::ALL.into_iter().find(|gas| gas.name() == name) else {
        let names: Vec<&str> = Gas::ALL.into_iter().map(Gas::name).collect();
        return Err(failed(py, Failure::value("gas", name, format!("one of {}", names.join(", ")))));
    };
    let (temperature, pressure) = (temperature.unwrap_or(Gas::TEMPERATURE), pressure.unwrap_or(Gas::PRESSURE));
    let found = gas.between(temperature, pressure, accommodation.unwrap_or([gas.accommodation(); 2]));
    let found = found.map_err(|error| failed(py, Failure::input("gas", error)))?;
    Ok((found.conductivity, found.jump))
}

/// Returns the conductance per area of a gas in the gap between the points that do not touch.
#[pyfunction]
pub(crate) fn gas_conductance(
    py: Python<'_>,
    touching: PyReadonlyArray2<'_, bool>,
    gap: PyReadonlyArray2<'_, f64>,
    conductivity: f64,
    jump: f64,
) -> PyResult<f64> {
    let touching = touching.as_array().mapv(|touches| f64::from(u8::from(touches)));
    let found = GapGas { conductivity, jump }.conductance(touching.view(), gap.as_array());
    found.map_err(|error| failed(py, Failure::input("gap", error)))
}

/// Contact problem of a surface and a body.
#[pyclass(frozen, module = "gfmd._gfmd")]
pub(crate) struct Problem {
    args: ContactArgs,
    prepared: Prepared,
    contact: Posed,
    finer: Mutex<Vec<Finer>>,
}

/// Solved load, which may serve as the start of the next one.
#[pyclass(frozen, module = "gfmd._gfmd")]
pub(crate) struct State {
    rest: AnyState,
    facts: Facts,
    /// Lift of a moved base.
    base: Option<MovedBase>,
    /// Numbers of a solved state; `None` for a recalled one.
    record: Option<Record>,
}

/// Measured array of a state.
#[derive(IntoPyObject)]
pub(crate) struct Measured {
    path: &'static str,
    kind: &'static str,
    meaning: &'static str,
    values: Vec<f64>,
    axis: Vec<f64>,
}

/// State, scalars as JSON, kind and text of a failure, and an exception raised by a signal handler.
type Solved = (State, String, Option<(&'static str, String)>, Option<Py<PyAny>>);

#[pymethods]
impl Problem {
    #[new]
    fn new(py: Python<'_>, problem: &Bound<'_, PyDict>, arrays: &Bound<'_, PyDict>, threads: usize) -> PyResult<Self> {
        let (args, written) = described(py, problem, arrays)?;
        let (made, raised) = run(py, threads, None, |_| {
            let session = Session::embedded();
            let (prepared, contact) = args.pose(&session)?;
            let finer = Finer::pose(&args, &prepared, &session)?;
            Ok::<_, Failure>((prepared, contact, Mutex::new(finer)))
        })?;
        raised.map_or(Ok(()), Err)?;
        // Nothing was computed yet, so every failure is unusable input.
        let (prepared, contact, finer) = made.map_err(|failure| unusable(py, failure.as_written(&written)))?;
        Ok(Self { args, prepared, contact, finer })
    }

    /// Solves the contact under one load with the key `control`, starting from `start` or as the options ask.
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
        let unit = prepared.unit_of_load(control).map_err(|failure| unusable(py, failure))?;
        let load = if control == "approach" { Load::Approach } else { Load::MeanPressure };
        let drive: Drive = load(value * unit).into();
        let (solved, raised) = run(py, threads, tick.as_ref(), |shared| {
            let mut watch = |now: &Progress| shared.see(now.iteration, now.residual);
            let tolerance = args.solver.search.tolerance;
            check_drive(contact, drive, key(control), tolerance)?;
            let mut finer = finer.lock().unwrap_or_else(PoisonError::into_inner);
            if !finer.is_empty() {
                Facts { approach: matches!(drive.load, Load::Approach(_)), ..prepared.facts }.check()?;
                if start.is_some() && prepared.facts.has_law() && finer.iter().any(|finer| !finer.has_started()) {
                    let found = "refine, with start and a law, whose state on the finer grid is not known";
                    return Err(Failure::value(key("grid_error"), found, "none or estimate"));
                }
            }
            let first = match start {
                Some(_) => None,
                None => args.after_longer_ranges(prepared, drive, &mut watch)?,
            };
            let started = Instant::now();
            let start = start.map(|state| &state.rest).or(first.as_ref());
            let solved = args.press(contact, drive).starting_from(start).watch(&mut watch).solve();
            let (state, failure) = reached(solved, &prepared.surface.units())?;
            let stiffness = match &failure {
                Some(_) => Err(NOT_SOLVED.into()),
                None => args.stiffness.of(contact, &state, |text| tracing::warn!("{text}")),
            };
            let finer = finer.iter_mut().map(|finer| match &failure {
                Some(_) => Ok(Err(NOT_SOLVED.to_owned())),
                None => beside(finer.reach(drive, &mut watch).map(|(.., at)| OnFinerGrid::of(&at))),
            });
            let finer = finer.collect::<Result<_, Failure>>()?;
            let at = prepared.at(&state, tolerance);
            if let (None, Some(warning)) = (&failure, prepared.edge_warning(&state)) {
                tracing::warn!("{warning}");
            }
            let (stiffness, seconds) = (stiffness, started.elapsed().as_secs_f64());
            let facts = Facts { approach: matches!(drive.load, Load::Approach(_)), ..prepared.facts };
            let record = Record::of(&StateContext { facts: &facts, stiffness, seconds, finer, ..at });
            Ok::<_, Failure>((state, record, failure))
        })?;
        let ((rest, record, failure), raised) = match (solved, raised) {
            (Ok(solved), raised) => (solved, raised),
            (Err(_), Some(raised)) if !raised.is_instance_of::<PyKeyboardInterrupt>(py) => return Err(raised),
            // Without a state, the load was refused, or a load of a longer range was not reached.
            (Err(failure), _) => return Err(unreached(py, failure)),
        };
        let text = json::to_string(&record).map_err(|error| refused(py, &error))?;
        let raised = raised.map(|error| error.into_value(py).into_any());
        Ok((self.state(rest, Some(record)), text, failure.map(kind_and_text), raised))
    }

    /// Converts a quantity with a unit to a number in the units of the problem.
    fn value(&self, py: Python<'_>, name: &str, text: &str, kind: &str) -> PyResult<f64> {
        let refuse = |error: &dyn std::fmt::Display| refused(py, &format!("{name} is {text:?}: {error}"));
        let quantity = Quantity::parse(text).map_err(|error| refuse(&error))?;
        let quantity = quantity.ok_or_else(|| refuse(&"it must be a number, or a quantity with a unit"))?;
        self.prepared.surface.units().value(&quantity, kind).map_err(|error| refuse(&error))
    }

    /// Returns the unit of stress, if known.
    #[getter]
    fn stress_unit(&self) -> Option<String> {
        self.prepared.surface.stress().map(str::to_owned)
    }

    /// Returns warnings about mixed-up units for loads up to `largest` with the key `control`.
    fn unit_warnings(&self, control: &str, largest: f64) -> Vec<String> {
        let mut warnings = self.prepared.unit_warnings(self.prepared.adhesion.as_ref());
        let p_star = match self.prepared.unit_of_load(control) {
            Ok(unit) if control != "approach" => largest * unit / self.prepared.unit_pressure(),
            _ => 0.0,
        };
        warnings.extend(self.prepared.load_warning(p_star, control));
        warnings.into_iter().map(|doubt| doubt.spelled(Spelling::Argument)).collect()
    }

    /// Returns the numbers that statistics and flow add to a state, as JSON, and its patches, distributions and
    /// spectra: path, kind, meaning, values and axis of each. `options` have the keys of `gfmd contact`.
    fn measure<'py>(
        &self,
        py: Python<'py>,
        state: &State,
        options: &Bound<'py, PyDict>,
    ) -> PyResult<(String, Vec<Measured>)> {
        let mut table = Table::try_from(&self.args).map_err(|error| refused(py, &error))?;
        // The grid error and the load belong to the state.
        table.remove("grid_error");
        table.insert("pressure".into(), vec![1.0].into());
        table.extend(crate::command::table(options)?);
        let args: Args = flags::of_table(table).map_err(|error| refused(py, &error))?;
        let (measured, raised) = run(py, 0, None, |_| {
            measure(&args, &self.prepared, &self.contact, &state.rest, |text| tracing::warn!("{text}"))
        })?;
        raised.map_or(Ok(()), Err)?;
        let (record, arrays) = measured.map_err(|failure| failed(py, failure))?;
        let grid = &self.prepared.surface.grid;
        let arrays = arrays.iter().flat_map(|found| {
            statistics_of(&self.prepared.facts).map(move |statistic| Measured {
                path: statistic.path,
                kind: statistic.unit.unwrap_or("length"),
                meaning: statistic.meaning,
                values: (statistic.values)(found, 0),
                axis: found.axis(statistic.along, grid),
            })
        });
        Ok((json::to_string(&record).map_err(|error| refused(py, &error))?, arrays.collect()))
    }

    /// Returns the derivatives of a scalar with respect to heights, load, modulus and hardness, and their relative
    /// error. The inputs are its derivatives with respect to the fields and numbers of a state under a mean pressure,
    /// or under an approach if `is_driven`.
    fn vjp<'py>(
        &self,
        py: Python<'py>,
        state: &State,
        is_driven: bool,
        fields: BTreeMap<String, PyReadonlyArray2<'py, f64>>,
        numbers: BTreeMap<String, f64>,
    ) -> PyResult<(Array<'py>, f64, f64, Option<Array<'py>>, f64)> {
        let field = |name: &str| fields.get(name).map(|field| field.as_array().to_owned());
        let number = |name: &str| numbers.get(name).copied().unwrap_or(0.0);
        let of = Cotangents {
            pressure: field("pressure"),
            gap: field("gap"),
            approach: number("approach"),
            mean_pressure: number("mean_pressure"),
            mean_gap: number("mean_gap"),
            elastic_energy: number("elastic_energy"),
            plastic_depth: field("plastic_depth"),
            ..Cotangents::default()
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
        let hardness = found.hardness.map(|by| by.into_pyarray(py));
        Ok((found.heights.into_pyarray(py), found.load, found.modulus, hardness, found.error))
    }

    /// Returns the options with their defaults as JSON; the surface contributes only length and unit of stress.
    #[getter]
    fn description(&self, py: Python<'_>) -> PyResult<String> {
        let of_surface = keys::<SourceArgs>();
        let mut table = Table::try_from(&self.args).map_err(|error| refused(py, &error))?;
        table.retain(|key, _| matches!(key, "size" | "stress_unit") || !of_surface.iter().any(|of| of == key));
        json::to_string(&table).map_err(|error| refused(py, &error))
    }

    /// Checks that an accuracy can be requested: the grid errors are known, and a finer grid reduces them.
    fn check_accuracy(&self, py: Python<'_>, accuracy: &str, control: &str) -> PyResult<()> {
        let asked = accuracy.parse::<Accuracy>();
        let asked = asked.map_err(|error| refused(py, &format!("accuracy is {accuracy}; {error}")))?;
        accuracy::check(asked, &self.prepared, control == "approach").map_err(|failure| unusable(py, failure))
    }

    /// Returns the warning about large strain at an approach; `None` if the strain is small.
    fn strain(&self, approach: f64) -> Option<String> {
        self.prepared.strain_warning(approach)
    }

    /// Returns the warning about steep slopes, with the largest pressure of the loads; `None` if they are small.
    fn slopes(&self, largest: f64) -> Option<String> {
        let Prepared { facts, surface, body, .. } = &self.prepared;
        let slopes = Slopes::of(surface.rms_gradient(), || surface.max_slope(), facts)?;
        Some(slopes.message(largest / body.contact_modulus()).spelled(Spelling::Argument))
    }

    /// Restores a state from its fields, as a start.
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
        let lower = ["lower_pressure", "lower_displacement_z", "lower_gap"].map(field);
        let made = quick(py, || {
            let own = self.prepared.lift().map(|lift| &displacement - lift);
            let displacement = own.as_ref().map_or(displacement, |own| own.view());
            let kept = StoredFields { pressure: &pressure, displacement_z: &displacement, gap: &gap, approach };
            let below = lower[1].map(|displacement| -&displacement);
            let lower = match (&lower, &below) {
                ([Some(pressure), _, Some(gap)], Some(displacement)) => {
                    Some(StoredFields { pressure, displacement_z: displacement, gap, approach: f64::NAN })
                }
                _ => None,
            };
            self.contact.recall(kept, lower).map_err(|error: Refusal| Failure::input("start", error))
        })?;
        made.map(|rest| self.state(rest, None)).map_err(|failure| failed(py, failure))
    }

    fn __repr__(&self) -> String {
        let [nx, ny] = self.prepared.surface.grid.points();
        format!("<a contact of {nx} x {ny} points>")
    }
}

impl Problem {
    fn state(&self, rest: AnyState, record: Option<Record>) -> State {
        State { rest, record, facts: self.prepared.facts, base: self.prepared.base.clone() }
    }
}

#[pymethods]
impl State {
    /// Returns the refinement factor of each side that the state needs for an accuracy; 1 if it is accurate enough.
    fn times(&self, py: Python<'_>, accuracy: &str) -> PyResult<u64> {
        let asked: Accuracy = accuracy.parse().map_err(|error| refused(py, &error))?;
        let worst = self.record.as_ref().and_then(|record| accuracy::worst(std::slice::from_ref(record), asked));
        Ok(worst.map_or(1, |worst| worst.times))
    }

    /// Returns the fields with their names, in file order. Fields that the state stores are not copied: the arrays keep
    /// it alive.
    #[getter]
    fn fields(this: Bound<'_, Self>) -> Vec<(&'static str, Array<'_>)> {
        let Self { rest, facts, base, .. } = this.get();
        let array = |Field { name, values, .. }: Field<'_>| {
            let array = if values.is_view() {
                lent(&this, &values.view())
            } else {
                values.into_owned().into_pyarray(this.py())
            };
            (name, array)
        };
        fields(facts, rest, base.as_ref()).into_iter().map(array).collect()
    }
}

/// Returns a field of a state as a read-only array without a copy.
fn lent<'py>(state: &Bound<'py, State>, field: &ArrayView2<'_, f64>) -> Array<'py> {
    #[expect(unsafe_code, reason = "the array lends the memory of the state")]
    // SAFETY: the state is the base of the array, and, being frozen, never moves or changes its fields.
    let array = unsafe { PyArray2::borrow_from_array(field, state.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    array
}
