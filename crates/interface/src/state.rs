use ndarray::{Array2, Array3};

/// An interface at rest. Fields are `[x, y]`, vectors `[component, x, y]` with z the last component.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Displacement of the elastic surface, length.
    pub displacement: Array3<f64>,
    /// Traction on the elastic surface, stress: that of the law and of the wall together.
    pub traction: Array3<f64>,
    /// Distance between the surfaces, length.
    pub gap: Array2<f64>,
    /// What the hard wall presses with, stress ≥ 0; 0 without a wall. Attraction is not part of it.
    pub wall_pressure: Array2<f64>,
    /// Mean of −t_z, stress: < 0 where the surfaces are pulled apart.
    pub mean_pressure: f64,
    /// Mean lateral traction on the elastic surface along x and y, stress.
    pub mean_shear: [f64; 2],
    /// Rigid approach beyond first touch of the undeformed surfaces, length.
    pub approach: f64,
    /// Lateral displacement of the rigid surface, length.
    pub lateral: [f64; 2],
    /// Elastic energy per area, stress × length.
    pub elastic_energy: f64,
    /// Energy of the law per area, stress × length; NaN of a law without one.
    pub interface_energy: f64,
    /// Share of the points in contact: pressed by the wall, or repelled by a law without one.
    pub contact_fraction: f64,
    /// Distance from equilibrium, computed from the fields above.
    pub residual: Residual,
    /// How it was reached.
    pub iterations: u64,
    /// Forward and inverse transforms of one component, in pairs, those that made the final fields included.
    pub transform_pairs: u64,
    /// Whether directions of negative curvature were met on the way from the state started from: after a jump they
    /// were, after a long smooth step they may have been. Dynamics does not look.
    pub passed_instability: bool,
    /// The lowest curvature, in units of the elastic one, that conjugate gradients see from a force in all directions: > 0
    /// in a stable state. 1 of a wall alone, NaN of dynamics.
    pub lowest_curvature: f64,
}

/// How far a state is from equilibrium; zero of the exact one. Stresses are in units of the largest traction, or of the
/// softest stiffness times the rms height where that is more; lengths in rms heights
/// (of a flat surface in units of length).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// Largest force per area that nothing balances.
    pub equilibrium: f64,
    /// max(0, −min gap), where there is a wall.
    pub penetration: f64,
    /// Largest tension that the wall would have to hold.
    pub wall_tension: f64,
    /// Mean pressure less the one asked for; 0 where the approach is prescribed.
    pub load: f64,
}

impl Residual {
    /// The largest of the four; NaN if any is.
    pub fn worst(&self) -> f64 {
        let Self { equilibrium, penetration, wall_tension, load } = *self;
        [equilibrium, penetration, wall_tension, load]
            .into_iter()
            .fold(0.0, |worst, part| if part.is_nan() || part > worst { part } else { worst })
    }
}
