use gfmd_vector::{add, pass, reduce};
use ndarray::{Array2, ArrayView2};

use crate::{ContactError, Control, Residual, Solution};

/// The rigid surface.
pub(crate) struct Wall {
    pub(crate) points: [usize; 2],
    /// Distance from its highest point down to it: max h − h ≥ 0.
    pub(crate) clearance: Vec<f64>,
    pub(crate) mean_clearance: f64,
    pub(crate) rms_height: f64,
}

impl Wall {
    pub(crate) fn new(expected: [usize; 2], heights: ArrayView2<f64>) -> Result<Self, ContactError> {
        let found = heights.dim().into();
        if found != expected {
            return Err(ContactError::Shape { found, expected });
        }
        if let Some(((i, j), &value)) = heights.indexed_iter().find(|(_, h)| !h.is_finite()) {
            return Err(ContactError::Height { index: [i, j], value });
        }
        let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let clearance: Vec<f64> = heights.iter().map(|h| highest - h).collect();
        let n = clearance.len() as f64;
        let mean_clearance = gfmd_vector::sum(clearance.len(), &|range| clearance[range].iter().sum()) / n;
        let squares = gfmd_vector::sum(clearance.len(), &|range| {
            clearance[range].iter().map(|c| (c - mean_clearance).powi(2)).sum()
        });
        let rms_height = (squares / n).sqrt();
        if rms_height == 0.0 {
            return Err(ContactError::Flat { value: highest });
        }
        Ok(Self { points: expected, clearance, mean_clearance, rms_height })
    }

    /// The state that belongs to `pressure` and to the displacement u_z that follows from it, with its residuals.
    pub(crate) fn certify(
        &self,
        pressure: Vec<f64>,
        displacement: Vec<f64>,
        control: Control,
    ) -> Result<Solution, ContactError> {
        let n = pressure.len();
        let [sum, touching] = reduce(
            n,
            &|range| pressure[range].iter().fold([0.0; 2], |sums, p| add(sums, [*p, f64::from(*p > 0.0)])),
            &add,
        );
        let mean_pressure = sum / n as f64;
        let approach = match control {
            // The mean of clearance − u_z over the contact is where the rigid surface must be.
            Control::MeanPressure(_) => {
                let room = |i: usize| if pressure[i] > 0.0 { self.clearance[i] - displacement[i] } else { 0.0 };
                gfmd_vector::sum(n, &|range| range.map(room).sum()) / touching
            }
            Control::Approach(approach) => approach,
        };
        let mut gap = vec![0.0; n];
        let sums = pass(
            [&mut gap],
            &|start, [gap]| {
                let mut sums = (0.0, f64::INFINITY, f64::INFINITY);
                let others = self.clearance[start..].iter().zip(&displacement[start..]).zip(&pressure[start..]);
                for (gap, ((c, u), p)) in gap.iter_mut().zip(others) {
                    *gap = c - u - approach;
                    sums = (sums.0 + p * *gap, lower(sums.1, *gap), lower(sums.2, *p));
                }
                sums
            },
            &|a, b| (a.0 + b.0, lower(a.1, b.1), lower(a.2, b.2)),
        );
        let residual = Residual {
            complementarity: if sum == 0.0 { 0.0 } else { (sums.0 / (sum * self.rms_height)).abs() },
            penetration: positive(-sums.1) / self.rms_height,
            negative_pressure: if sum == 0.0 { 0.0 } else { positive(-sums.2) / mean_pressure },
            load: match control {
                Control::MeanPressure(asked) => (mean_pressure - asked).abs() / asked,
                Control::Approach(_) => 0.0,
            },
        };
        let shape = self.points;
        let field = |what, values: Vec<f64>| {
            let found = values.len();
            let shape_error = move |_| gfmd_field::ShapeError { what, found, expected: shape[0] * shape[1] };
            Array2::from_shape_vec(shape, values).map_err(shape_error)
        };
        Ok(Solution {
            pressure: field("pressure", pressure)?,
            displacement: field("displacement", displacement)?,
            gap: field("gap", gap)?,
            mean_pressure,
            approach,
            residual,
            iterations: 0,
            transform_pairs: 1.0,
        })
    }
}

/// The smaller of two, NaN if either is.
fn lower(a: f64, b: f64) -> f64 {
    if a.is_nan() || a < b { a } else { b }
}

/// The positive part, NaN of NaN.
fn positive(a: f64) -> f64 {
    if a <= 0.0 { 0.0 } else { a }
}
