use gfmd_field::Grid;
use gfmd_response::Components;
use ndarray::{Array3, ArrayView2, ArrayView3};

use crate::MixedError;

/// Boundary conditions: the displacement (held) or the traction (free) at each point and component.
#[derive(Clone, Debug, PartialEq)]
pub struct Prescribed {
    pub(crate) shape: [usize; 3],
    pub(crate) held: Vec<bool>,
    pub(crate) values: Vec<f64>,
}

impl Prescribed {
    /// Makes boundary conditions from `values`: the displacement (length) of `held` entries, the traction (stress) of
    /// free ones; both arrays are `[component, x, y]`.
    ///
    /// # Errors
    /// Arrays of different shapes; a value that is not finite.
    pub fn new(held: ArrayView3<bool>, values: ArrayView3<f64>) -> Result<Self, MixedError> {
        let shape = shape_of(&held);
        check_shape("values", shape_of(&values), shape)?;
        check_finite(&values)?;
        Ok(Self { shape, held: held.iter().copied().collect(), values: values.iter().copied().collect() })
    }

    /// Holds `points` in all components, displaced rigidly by `displacement` (x, y, z; y has no meaning on a line). All
    /// other points are free of traction.
    ///
    /// # Errors
    /// Points on another grid; a displacement that is not finite.
    pub fn sticking(grid: &Grid, points: ArrayView2<bool>, displacement: [f64; 3]) -> Result<Self, MixedError> {
        Self::rigid(grid, points, displacement, |_| true)
    }

    /// Holds `points` at u_z = `displacement`, without lateral traction. All other points are free of traction.
    ///
    /// # Errors
    /// Points on another grid; a displacement that is not finite.
    pub fn frictionless(grid: &Grid, points: ArrayView2<bool>, displacement: f64) -> Result<Self, MixedError> {
        Self::rigid(grid, points, [0.0, 0.0, displacement], |axis| axis == 2)
    }

    /// Prescribes `traction` (stress, `[component, x, y]`) on all free entries; its values on held entries are ignored.
    ///
    /// # Errors
    /// A traction that differs in shape, or is not finite.
    pub fn with_traction(mut self, traction: ArrayView3<f64>) -> Result<Self, MixedError> {
        check_shape("traction", shape_of(&traction), self.shape)?;
        check_finite(&traction)?;
        for ((value, held), traction) in self.values.iter_mut().zip(&self.held).zip(&traction) {
            if !held {
                *value = *traction;
            }
        }
        Ok(self)
    }

    fn rigid(
        grid: &Grid,
        points: ArrayView2<bool>,
        displacement: [f64; 3],
        holds: impl Fn(usize) -> bool,
    ) -> Result<Self, MixedError> {
        let axes = Components::of(grid).axes();
        let [nx, ny] = grid.points();
        check_shape("points", [axes.len(), points.dim().0, points.dim().1], [axes.len(), nx, ny])?;
        let shape = (axes.len(), nx, ny);
        let held = Array3::from_shape_fn(shape, |(c, i, j)| holds(axes[c]) && points[[i, j]]);
        let values = Array3::from_shape_fn(shape, |at| if held[at] { displacement[axes[at.0]] } else { 0.0 });
        Self::new(held.view(), values.view())
    }

    /// Returns the number of components, of points along x, and of points along y.
    pub fn shape(&self) -> [usize; 3] {
        self.shape
    }

    /// Returns true for each entry with a prescribed displacement, `[component, x, y]` row-major.
    pub fn held(&self) -> &[bool] {
        &self.held
    }

    /// Returns the displacement of held entries and the traction of free ones, `[component, x, y]` row-major.
    pub fn values(&self) -> &[f64] {
        &self.values
    }
}

fn shape_of<T>(field: &ArrayView3<T>) -> [usize; 3] {
    field.dim().into()
}

fn check_shape(what: &'static str, found: [usize; 3], expected: [usize; 3]) -> Result<(), MixedError> {
    if found == expected { Ok(()) } else { Err(MixedError::Shape { what, found, expected }) }
}

fn check_finite(field: &ArrayView3<f64>) -> Result<(), MixedError> {
    let Some(((c, i, j), &value)) = field.indexed_iter().find(|(_, value)| !value.is_finite()) else { return Ok(()) };
    Err(MixedError::Value { index: [c, i, j], value })
}
