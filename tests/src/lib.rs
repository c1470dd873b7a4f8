//! Shared by the validation tests: reference data, and short ways to pose a contact problem.

use std::ops::ControlFlow;
use std::path::PathBuf;

use gfmd_contact::{Contact, ContactError, Control, Settings, Solution, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_response::NormalResponse;
use ndarray::{Array2, ArrayView2};
use serde_json::Value;

/// Every method that can be asked for by name.
pub const SOLVERS: [Solver; 6] = [
    Solver::PolonskyKeer,
    Solver::ProjectedCg,
    Solver::PreconditionedCg,
    Solver::Verlet,
    Solver::VerletCritical,
    Solver::Fire,
];

/// The file `name` of `data/reference`.
pub fn reference_path(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../data/reference").join(name)
}

/// A reference file as JSON.
///
/// # Panics
/// If it is missing or not JSON.
pub fn reference(name: &str) -> Value {
    let text = std::fs::read_to_string(reference_path(name)).expect(name);
    serde_json::from_str(&text).expect(name)
}

/// A reference array.
///
/// # Panics
/// If it is missing or not a two-dimensional array of doubles.
pub fn reference_array(name: &str) -> Array2<f64> {
    ndarray_npy::read_npy(reference_path(name)).expect(name)
}

/// The number under `key`.
///
/// # Panics
/// If there is none.
pub fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("no number {key} in {value}"))
}

/// A half-space of contact modulus 1.
pub fn unit_half_space() -> Body {
    Body::half_space(Material::from_contact_modulus(1.0, 0.0).expect("a valid material"))
}

/// Solves without watching.
///
/// # Errors
/// As [`Contact::solve`].
pub fn press(
    response: &NormalResponse,
    heights: ArrayView2<f64>,
    control: Control,
    settings: &Settings,
) -> Result<Solution, ContactError> {
    Contact::new(response, heights)?.solve(control, settings, None, &mut |_| ControlFlow::Continue(()))
}

/// Presses `heights` on the unit half-space over a square cell of length 1, by the default method.
///
/// # Panics
/// If it does not converge.
pub fn press_on_half_space(heights: ArrayView2<f64>, mean_pressure: f64, tolerance: f64) -> Solution {
    let (nx, ny) = heights.dim();
    let grid = Grid::new([nx, ny], [1.0, 1.0]).expect("a valid grid");
    let settings = Settings { tolerance, ..Settings::default() };
    let response = NormalResponse::new(grid, &unit_half_space());
    press(&response, heights, Control::MeanPressure(mean_pressure), &settings).expect("converges")
}
