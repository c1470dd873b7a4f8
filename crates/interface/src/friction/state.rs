use ndarray::{Array2, Array3};

use crate::numbers::higher;

/// A frictional contact at rest. Fields are `[x, y]`, vectors `[component, x, y]` with z the last component.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionState {
    /// Displacement of the elastic surface, length.
    pub displacement: Array3<f64>,
    /// Traction on the elastic surface, stress; its z component is −pressure.
    pub traction: Array3<f64>,
    /// Distance between the surfaces, length.
    pub gap: Array2<f64>,
    /// How far the elastic surface slipped over the rigid one in this increment, length; x, or x and y.
    pub slip: Array3<f64>,
    /// Mean pressure over the whole surface, stress.
    pub mean_pressure: f64,
    /// Mean shear traction on the elastic surface along x and y, stress.
    pub mean_shear: [f64; 2],
    /// Rigid approach beyond first touch of the undeformed surfaces, length.
    pub approach: f64,
    /// Lateral displacement of the rigid surface, length.
    pub lateral: [f64; 2],
    /// Share of the points that are pressed.
    pub contact_fraction: f64,
    /// Share of the points that are pressed and stick.
    pub stick_fraction: f64,
    /// Elastic energy per area, stress × length.
    pub elastic_energy: f64,
    /// Work done against friction in this increment, per area.
    pub dissipated: f64,
    /// Distance from equilibrium, computed from the fields above.
    pub residual: FrictionResidual,
    /// Steps of both solvers.
    pub iterations: u64,
    /// Forward and inverse transforms of one component, in pairs.
    pub transform_pairs: u64,
}

/// How far a state is from satisfying the conditions of contact and friction; zero of the exact one. p is the pressure, τ
/// the shear on the elastic surface, s the slip of the increment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionResidual {
    /// Σ p g / (Σ p · h_rms), in magnitude.
    pub complementarity: f64,
    /// max(0, −min g) / h_rms.
    pub penetration: f64,
    /// |p̄ − asked| / asked; 0 where the approach is prescribed.
    pub load: f64,
    /// Largest |τ − P(τ − c s)| over the largest limit, P the projection on |τ| ≤ limit of the point and c the largest limit
    /// over h_rms: slip where the surfaces should stick, or not against the shear.
    pub friction: f64,
    /// Largest excess of |τ| over its limit, over the largest limit.
    pub excess: f64,
}

impl FrictionResidual {
    /// The largest; NaN if any is.
    pub fn worst(&self) -> f64 {
        let Self { complementarity, penetration, load, friction, excess } = *self;
        [complementarity, penetration, load, friction, excess].into_iter().fold(0.0, higher)
    }
}

impl std::fmt::Display for FrictionResidual {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { complementarity, penetration, load, friction, excess } = self;
        write!(
            f,
            "complementarity {complementarity:.2e}, penetration {penetration:.2e}, load {load:.2e}, \
             friction {friction:.2e}, excess {excess:.2e}"
        )
    }
}
