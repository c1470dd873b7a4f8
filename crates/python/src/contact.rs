//! Contacts under a load.

use std::sync::Arc;

use gfmd_contact::{
    Boundary, Budget, Conductance, ConductanceError, Conductors, Hardness, Load, Progress, Refusal, Solver,
};
use gfmd_field::Grid;
use gfmd_green::Height;
use gfmd_interface::Kept;
use gfmd_law::{Kind, Law};
use gfmd_measure::Scales;
use gfmd_problem::options::body_of;
use gfmd_problem::{Adhesion, options::LawArgs};
use gfmd_problem::{Facts, Given as Parts, Lower, Unknown};
use gfmd_run::failure::Failure;
use gfmd_run::json;
use gfmd_run::memory;
use gfmd_run::series::Slopes;
use gfmd_surface::{Moments, PowerSpectrum, Statistics};
use ndarray::{Array2, ArrayRef2, ArrayView2};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::command::table;
use crate::failure::{failed, refused};
use crate::loads::{Loads, Rest};
use crate::surface::grid;
use crate::worker::{quick, run};

type Array<'py> = Bound<'py, PyArray2<f64>>;

/// Names of the solvers.
#[pyfunction]
pub(crate) fn solvers() -> Vec<&'static str> {
    Solver::ALL.map(Solver::name).to_vec()
}

/// Checks the name and the parameters of a law.
#[pyfunction]
pub(crate) fn check_law(py: Python<'_>, name: &str, parameters: Vec<(String, f64)>) -> PyResult<()> {
    law(py, name, &parameters).map(|_| ())
}

fn law(py: Python<'_>, name: &str, parameters: &[(String, f64)]) -> PyResult<(LawArgs, Arc<dyn Law>)> {
    let kind: Kind = name.parse().map_err(|error| refused(py, &error))?;
    let law = kind.with(parameters).map_err(|error| refused(py, &error))?;
    Ok((LawArgs { law: kind, param: parameters.to_vec(), coarse: false }, law.into_shared()))
}

/// The numbers of an attraction on a surface and a body, as JSON: `null` without one.
#[pyfunction]
pub(crate) fn adhesion(
    py: Python<'_>,
    heights: PyReadonlyArray2<'_, f64>,
    lengths: [f64; 2],
    body: &Bound<'_, PyDict>,
    law: (String, Vec<(String, f64)>),
) -> PyResult<String> {
    let (args, law) = self::law(py, &law.0, &law.1)?;
    let heights = heights.as_array();
    let grid = grid(py, heights.dim().into(), lengths)?;
    let body = table(body)?;
    let found = quick(py, || {
        let modulus = body_of(body)?.body()?.contact_modulus();
        let (_, moments) = gradient(&heights, &grid, Boundary::Periodic)?;
        Ok::<_, Failure>(Adhesion::of(&args, &law, &grid, &moments, modulus))
    })?;
    json::to_string(&found.map_err(|failure| refused(py, &failure))?).map_err(|error| refused(py, &error))
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
    loads: Loads,
    grid: Grid,
    scales: Scales,
    /// E* times the rms gradient, as the program multiplies them.
    unit_pressure: f64,
    /// Slopes that are not small.
    slopes: Option<Slopes>,
}

/// A hardness, one or that of each point.
#[derive(FromPyObject)]
enum Given<'py> {
    Number(f64),
    Field(PyReadonlyArray2<'py, f64>),
}

impl From<Given<'_>> for Hardness {
    fn from(given: Given<'_>) -> Self {
        match given {
            Given::Number(hardness) => Self::Uniform(hardness),
            Given::Field(field) => Self::Field(field.as_array().to_owned()),
        }
    }
}

/// A load at rest, to start the next one from.
#[pyclass(frozen, module = "gfmd._gfmd")]
pub(crate) struct State {
    rest: Rest,
}

/// State, scalars as JSON; the kind and the text of a failure; an exception of a signal's handler.
type Solved = (State, String, Option<(&'static str, String)>, Option<Py<PyAny>>);

#[pymethods]
impl Problem {
    /// `body` has the keys of the flags of a body.
    #[new]
    #[expect(clippy::too_many_arguments, reason = "keywords")]
    fn new(
        py: Python<'_>,
        heights: PyReadonlyArray2<'_, f64>,
        lengths: [f64; 2],
        body: &Bound<'_, PyDict>,
        law: (String, Vec<(String, f64)>),
        hardness: Option<Given<'_>>,
        lower: Option<PyReadonlyArray2<'_, f64>>,
        finite_slope: bool,
        coarse: Option<bool>,
        boundary: &str,
        components: &str,
        solver: &str,
        threads: usize,
    ) -> PyResult<Self> {
        let boundary: Boundary = boundary.parse().map_err(|error| refused(py, &error))?;
        let unknown: Unknown = components.parse().map_err(|error| refused(py, &error))?;
        let body = body_of(table(body)?).map_err(|failure| refused(py, &failure))?;
        let (args, law) = self::law(py, &law.0, &law.1)?;
        let solver: Solver = solver.parse().map_err(|error| refused(py, &error))?;
        let heights = heights.as_array();
        let grid = grid(py, heights.dim().into(), lengths)?;
        let hardness = hardness.map(Hardness::from);
        let lower: Option<Array2<f64>> = lower.map(|heights| heights.as_array().to_owned());
        let facts = Facts {
            law: args.law,
            hardness: hardness.is_some(),
            boundary,
            unknown,
            finite_slope,
            lower: lower.as_ref().map(|_| Lower::Surface),
            line: grid.is_line(),
            ..body.facts()
        };
        let (made, raised) = run(py, threads, None, |_| {
            facts.check()?;
            let body = body.body()?;
            let (lower, law) = (lower.as_deref(), Arc::clone(&law));
            let given = Parts { lower, law, hardness, ..Parts::new(facts, &body, &grid, &heights) };
            Self::pose(&given, solver, (&args, coarse))
        })?;
        raised.map_or(Ok(()), Err)?;
        // Nothing was computed yet: every refusal is one of the input.
        made.map_err(|failure| refused(py, &failure))
    }

    /// Brings the contact to rest under one load.
    #[expect(clippy::too_many_arguments, reason = "keywords")]
    fn solve(
        &self,
        py: Python<'_>,
        control: &str,
        value: f64,
        tolerance: f64,
        max_iterations: u64,
        start: Option<&State>,
        threads: usize,
        tick: Option<Py<PyAny>>,
    ) -> PyResult<Solved> {
        let load = match control {
            "mean_pressure" => Load::MeanPressure(value),
            "p_star" => Load::MeanPressure(value * self.unit_pressure),
            _ => Load::Approach(value),
        };
        let budget = Budget { tolerance, max_iterations };
        let start = start.map(|state| &state.rest);
        let (solved, raised) = run(py, threads, tick.as_ref(), |shared| {
            self.loads.solve(load, &budget, &self.scales, start, &mut |now: &Progress| {
                shared.see(now.iteration, now.residual)
            })
        })?;
        // Without a state, the load was refused.
        let (rest, failure) = solved.map_err(|failure| refused(py, &failure))?;
        let record = json::to_string(&rest.record).map_err(|error| refused(py, &error))?;
        let failure = failure.map(|failure| match failure {
            Failure::Interrupted(text) => ("interrupted", text),
            Failure::Input(text) | Failure::Computation(text) => ("not converged", text),
        });
        let raised = raised.map(|error| error.into_value(py).into_any());
        Ok((State { rest }, record, failure, raised))
    }

    /// The warning of slopes that are not small, with the largest pressure of the loads; `None` if they are.
    fn slopes(&self, largest: f64) -> Option<String> {
        self.slopes.map(|slopes| slopes.told(largest / self.scales.contact_modulus))
    }

    /// The state of a contact with these fields, to start from.
    fn recall(
        &self,
        py: Python<'_>,
        pressure: PyReadonlyArray2<'_, f64>,
        displacement: PyReadonlyArray2<'_, f64>,
        gap: PyReadonlyArray2<'_, f64>,
        approach: f64,
        lower_pressure: Option<PyReadonlyArray2<'_, f64>>,
    ) -> PyResult<State> {
        let (pressure, displacement, gap) = (pressure.as_array(), displacement.as_array(), gap.as_array());
        let kept = Kept { pressure: &pressure, displacement_z: &displacement, gap: &gap, approach };
        let lower = lower_pressure.as_ref().map(|lower| lower.as_array());
        let made = quick(py, || self.loads.recalled(kept, lower.as_deref()))?;
        made.map(|rest| State { rest }).map_err(|failure| failed(py, &failure))
    }

    fn __repr__(&self) -> String {
        let [nx, ny] = self.grid.points();
        format!("<a contact of {nx} x {ny} points>")
    }
}

#[pymethods]
impl State {
    /// Pressure, displacement, gap, without a copy: the arrays keep the state alive.
    #[getter]
    fn fields(this: Bound<'_, Self>) -> Option<[Array<'_>; 3]> {
        this.get().rest.fields().map(|fields| fields.map(|field| lent(&this, &field)))
    }

    /// The lateral displacement, if it was unknown, without a copy.
    #[getter]
    fn lateral(this: Bound<'_, Self>) -> Vec<Array<'_>> {
        this.get().rest.lateral().iter().map(|field| lent(&this, &field.view())).collect()
    }

    /// Pressure, displacement, gap of the lower face of a slab between two surfaces, without a copy.
    #[getter]
    fn lower(this: Bound<'_, Self>) -> Option<[Array<'_>; 3]> {
        this.get().rest.lower().map(|fields| fields.map(|field| lent(&this, &field)))
    }

    /// The pressure of the wall of a law that has one, without a copy.
    #[getter]
    fn repulsion(this: Bound<'_, Self>) -> Option<Array<'_>> {
        this.get().rest.repulsion().map(|field| lent(&this, &field))
    }

    /// The plastic depth of a contact with a hardness, without a copy.
    #[getter]
    fn plastic_depth(this: Bound<'_, Self>) -> Option<Array<'_>> {
        this.get().rest.plastic_depth().map(|field| lent(&this, &field))
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

/// The rms gradient by which loads are reduced, and the moments of a surface.
fn gradient(heights: &ArrayRef2<f64>, grid: &Grid, boundary: Boundary) -> Result<(f64, Moments), Failure> {
    let refuse = |error| Failure::input("surface", error);
    match boundary {
        Boundary::Periodic => {
            let moments = PowerSpectrum::of(heights, grid).map_err(refuse)?.moments();
            Ok((moments.rms_gradient(), moments))
        }
        Boundary::Free => {
            let statistics = Statistics::of(&heights.to_owned(), grid).map_err(refuse)?;
            Ok((statistics.rms_gradient_inside, statistics.moments))
        }
    }
}

impl Problem {
    /// `coarse` is `None` for a problem whose grid is not judged.
    fn pose(given: &Parts<'_>, solver: Solver, (args, coarse): (&LawArgs, Option<bool>)) -> Result<Self, Failure> {
        let Parts { facts, body, grid, heights, lower, law, .. } = given;
        // The states of former loads are in memory already, as is the surface, which is part of the need.
        memory::fits_with(size_of_val(*heights) as u64, facts.held(true), "the grid", grid.points())?;
        let (rms_gradient, moments) = gradient(heights, grid, facts.boundary)?;
        if lower.is_some() && heights.iter().all(|height| *height == heights[[0, 0]]) {
            return Err(Failure::Input(
                "surface: the heights are all equal; with a lower surface only that may be flat".into(),
            ));
        }
        let refuse = |error: Refusal| match error {
            Refusal::Solver { .. } => Failure::input("solver", error),
            Refusal::Hardness { .. } | Refusal::HardnessShape { .. } => Failure::input("hardness", error),
            Refusal::Body(_) if lower.is_some() => Failure::input("lower_surface", error),
            Refusal::Body(_) => Failure::input("boundary free", error),
            _ => Failure::input("surface", error),
        };
        let loads = Loads::new(given, solver).map_err(refuse)?;
        if let Some(coarse) = coarse {
            let advice = Adhesion::of(args, law, grid, &moments, body.contact_modulus());
            if let Some(advice) = &advice {
                advice.check(coarse)?;
                tracing::info!("{advice}");
            }
            if let Some(trapping) = loads.trapping() {
                tracing::warn!("{trapping}");
            } else if let Some(unresolved) = advice.and_then(|advice| advice.unresolved()) {
                tracing::warn!("{unresolved}");
            }
        }
        let scales = Scales { contact_modulus: body.contact_modulus(), rms_gradient };
        let steepest = || Statistics::of(&(**heights).to_owned(), grid).map_or(f64::NAN, |found| found.max_slope);
        let slopes = Slopes::of(rms_gradient, steepest, facts);
        Ok(Self { loads, grid: **grid, scales, unit_pressure: body.contact_modulus() * rms_gradient, slopes })
    }
}
