use ndarray::Array2;

/// An equilibrated contact. Fields are `[x, y]`; the displacement of the surface is negative downwards.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Contact pressure, ≥ 0, in stress; exactly 0 out of contact.
    pub pressure: Array2<f64>,
    /// Normal displacement u_z of the elastic surface, in length.
    pub displacement: Array2<f64>,
    /// Distance between the surfaces, in length; in contact it vanishes to within the residuals.
    pub gap: Array2<f64>,
    /// Mean pressure over the whole surface.
    pub mean_pressure: f64,
    /// Rigid approach beyond first touch of the undeformed surfaces.
    pub approach: f64,
    /// Distance from the exact solution, computed from the fields above.
    pub residual: Residual,
    /// Iterations, or time steps, of the solver.
    pub iterations: u64,
    /// Forward and inverse real transforms of the full grid, in pairs; those that made the final fields included.
    pub transform_pairs: f64,
}

/// How far a state is from satisfying the contact conditions; zero for the exact solution. Never carried along by a
/// solver: computed from the final pressure with fresh transforms. h_rms is the rms height of the rigid surface.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// Σ p g / (Σ p · h_rms), in magnitude.
    pub complementarity: f64,
    /// max(0, −min g) / h_rms.
    pub penetration: f64,
    /// max(0, −min p) / p̄.
    pub negative_pressure: f64,
    /// |p̄ − asked| / asked; 0 where the approach is prescribed.
    pub load: f64,
}

impl Residual {
    /// The largest of the four; NaN if any is.
    pub fn worst(&self) -> f64 {
        gfmd_relax::worst([self.complementarity, self.penetration, self.negative_pressure, self.load])
    }
}
