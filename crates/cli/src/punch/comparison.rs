//! Comparison of the displacement under a punch with another code.

use gfmd_files::{Reader, npy, split_dataset};
use gfmd_mixed::MixedSolution;
use gfmd_problem::key;
use ndarray::{Array3, ArrayD, Axis, Slice};
use serde::Serialize;

use gfmd_input::failure::Failure;

/// The dataset in files of gfmd.
const DISPLACEMENT: &str = "/fields/displacement";

/// A displacement from a file, `[x, y, component]`. One of its grid and ours contains all points of the other.
#[derive(Clone, Debug)]
pub(super) struct Reference {
    pub(super) displacement: Array3<f64>,
}

/// The difference of two displacements.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Comparison {
    pub reference: String,
    /// Points along x and y that both grids have.
    pub compared_points: [usize; 2],
    /// √⟨(u_ref − u)²⟩ / depth of each component, over these points.
    pub error: Vec<f64>,
}

impl Reference {
    /// Reads `.npy` or `FILE.h5[:/dataset]` with the shape [m, m, 3], or [m, 2] or [m, 1, 2] of a line, to compare
    /// with a grid of `points`.
    pub(super) fn read(name: &str, points: [usize; 2], components: usize) -> Result<Self, Failure> {
        let fail = |reason: String| Failure::input(key("compare"), format!("{name}: {reason}"));
        let found = match split_dataset(name) {
            Some((path, "")) => dataset(path, DISPLACEMENT),
            Some((path, name)) => dataset(path, name),
            None if name.to_ascii_lowercase().ends_with(".npy") => npy::read(name),
            None => Err("it must be FILE.npy, FILE.h5 or FILE.h5:/dataset".into()),
        };
        let found = found.map_err(fail)?;
        let shape = match (found.shape(), points) {
            ([m, c], [_, 1]) => [*m, 1, *c],
            ([m, l, c], _) => [*m, *l, *c],
            _ => [0; 3],
        };
        let [n, _] = points;
        let [m, rows, _] = shape;
        let fits = rows == if points[1] == 1 { 1 } else { m } && shape[2] == components;
        let nested = m > 0 && (n.is_multiple_of(m) || m.is_multiple_of(n));
        if !(fits && nested) {
            let allowed = if points[1] == 1 { "[m, 2] or [m, 1, 2]" } else { "[m, m, 3]" };
            let found = found.shape();
            return Err(fail(format!(
                "the shape is {found:?}; it must be {allowed}, with m a divisor or a multiple of {n}"
            )));
        }
        if let Some(value) = found.iter().find(|value| !value.is_finite()) {
            return Err(fail(format!("a value is {value}; all values must be finite")));
        }
        let displacement = Array3::from_shape_vec(shape, found.into_iter().collect());
        Ok(Self { displacement: displacement.map_err(|error| fail(error.to_string()))? })
    }

    /// Ours less the reference on the points that both grids have, `[x, y, component]`.
    pub(super) fn difference(&self, solution: &MixedSolution) -> Array3<f64> {
        let ours = solution.displacement.view().permuted_axes([1, 2, 0]);
        let (n, m) = (ours.len_of(Axis(0)), self.displacement.len_of(Axis(0)));
        let every = |step: usize| {
            move |axis: ndarray::AxisDescription| match axis.axis {
                Axis(2) => Slice::from(..),
                _ if axis.len == 1 => Slice::from(..),
                _ => Slice::new(0, None, step as isize),
            }
        };
        let ours = ours.slice_each_axis(every(n.div_ceil(m)));
        let theirs = self.displacement.slice_each_axis(every(m.div_ceil(n)));
        &ours - &theirs
    }

    /// Compares on the points that both grids have.
    pub(super) fn compare(&self, name: &str, solution: &MixedSolution, depth: f64) -> Comparison {
        let squares = self.difference(solution).mapv(|difference| difference * difference);
        let (nx, ny, _) = squares.dim();
        let of_component = |squares: ndarray::ArrayView2<f64>| (squares.sum() / (nx * ny) as f64).sqrt() / depth;
        let error = squares.axis_iter(Axis(2)).map(of_component).collect();
        Comparison { reference: name.into(), compared_points: [nx, ny], error }
    }
}

/// Reads a dataset of an HDF5 file.
pub(super) fn dataset(path: &str, name: &str) -> Result<ArrayD<f64>, String> {
    let reader = Reader::open(path).map_err(|error| error.to_string())?;
    let shape = reader.shape(name).map_err(|error| error.to_string())?;
    let values = reader.values::<f64>(name).map_err(|error| error.to_string())?;
    ArrayD::from_shape_vec(shape, values).map_err(|error| error.to_string())
}
