use ndarray::{Array3, Axis};

/// Solved state. Fields are `[component, x, y]` with the components x, y, z, or x, z on a line.
#[derive(Clone, Debug, PartialEq)]
pub struct MixedSolution {
    /// Displacement of the surface, in length: u = G t of `traction`, from fresh transforms. A mean that does not
    /// depend on the mean traction is zero.
    pub displacement: Array3<f64>,
    /// Traction on the surface, in stress; exactly the given one on free entries.
    pub traction: Array3<f64>,
    /// Largest deviation of `displacement` from the prescribed one on held entries, divided by the largest deviation
    /// that the given traction alone would leave (without a given traction, by the largest prescribed displacement).
    pub residual: f64,
    /// Number of iterations, or time steps.
    pub iterations: u64,
    /// Number of pairs of a forward and an inverse real transform of one component on the full grid: three for an
    /// application of stiffness or compliance, two on a line. The transforms for the final fields are included.
    pub transform_pairs: f64,
}

impl MixedSolution {
    /// Returns the mean traction over the whole surface, by component, in stress. The mean pressure is minus the last
    /// component.
    pub fn mean_traction(&self) -> Vec<f64> {
        // A grid has points, so each component has a mean.
        self.traction.axis_iter(Axis(0)).map(|component| component.mean().unwrap_or(0.0)).collect()
    }

    /// Returns the elastic energy per area of the surface, ½⟨t·u⟩, in stress × length (theory.md, section 0).
    pub fn elastic_energy(&self) -> f64 {
        let points = self.traction.len() / self.traction.len_of(Axis(0));
        let products = self.traction.iter().zip(&self.displacement).map(|(t, u)| t * u);
        0.5 * products.sum::<f64>() / points as f64
    }
}
