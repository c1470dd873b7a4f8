use std::sync::Arc;

use gfmd_contact::{Effort, Fields, RigidSurface};
use gfmd_measure::{Scales, Summary};
use ndarray::{Array2, Array3, ArrayView2, Axis, CowArray, Ix2};

/// A frictional contact in equilibrium. Fields are `[x, y]`, vectors `[component, x, y]` with z the last component.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionState {
    /// Displacement of the elastic surface, length.
    pub displacement: Array3<f64>,
    /// Traction on the elastic surface, stress; its z component is −pressure.
    pub traction: Array3<f64>,
    /// Distance between the surfaces, length.
    pub gap: Array2<f64>,
    /// Slip of the elastic surface relative to the rigid one in this increment, length; x, or x and y.
    pub slip: Array3<f64>,
    /// Mean pressure over the whole surface, stress.
    pub mean_pressure: f64,
    /// Mean shear traction on the elastic surface along x and y, stress.
    pub mean_shear: [f64; 2],
    /// Rigid approach beyond first touch of the undeformed surfaces, length.
    pub approach: f64,
    /// Lateral displacement of the rigid surface, length.
    pub lateral: [f64; 2],
    /// Fraction of points under pressure.
    pub contact_fraction: f64,
    /// Fraction of points under pressure that stick, relative to all points.
    pub stick_fraction: f64,
    /// Elastic energy per area, stress × length.
    pub elastic_energy: f64,
    /// Work done against friction in this increment, per area: the slip of each point times the mean of its limits at
    /// the start and the end.
    pub dissipated: f64,
    /// Distance from equilibrium, computed from the fields above.
    pub residual: FrictionResidual,
    /// Effort of the solve, summed over both problems.
    pub effort: Effort,
    pub(super) surface: Arc<RigidSurface>,
    pub(super) contact_modulus: f64,
}

/// Violation of the conditions of contact and friction; zero for the exact state. h_rms is the rms height, or the
/// length scale of a very small [approach](RigidSurface::length_scale) or [displacement](RigidSurface::finer_scale). p
/// is the pressure, τ the shear on the elastic surface, s the slip of the increment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionResidual {
    /// Σ p g / (Σ p · h_rms), in magnitude.
    pub complementarity: f64,
    /// max(0, −min g) / h_rms.
    pub penetration: f64,
    /// |p̄ − p̄₀| / p̄₀ for the prescribed p̄₀; 0 if the approach is prescribed.
    pub load: f64,
    /// Largest |τ − P(τ − c s)| divided by the largest limit. P is the projection on |τ| ≤ limit at the point, c the
    /// largest limit divided by h_rms. It measures slip below the limit, and slip that is not opposite to the shear.
    pub friction: f64,
    /// Largest excess of |τ| over its limit, divided by the largest limit.
    pub excess: f64,
}

impl FrictionResidual {
    /// Returns the residuals with their names.
    pub fn parts(&self) -> [(&'static str, f64); 5] {
        [
            ("complementarity", self.complementarity),
            ("penetration", self.penetration),
            ("load", self.load),
            ("friction", self.friction),
            ("excess", self.excess),
        ]
    }

    /// Returns the largest residual; NaN if any residual is NaN.
    pub fn worst(&self) -> f64 {
        gfmd_relax::worst(self.parts().map(|(_, residual)| residual))
    }
}

impl FrictionState {
    /// Multiplies all lengths and stresses by the given powers of two.
    pub(super) fn times(mut self, length: f64, stress: f64) -> Self {
        let Self { displacement, traction, gap, slip, .. } = &mut self;
        displacement.mapv_inplace(|u| u * length);
        traction.mapv_inplace(|t| t * stress);
        gap.mapv_inplace(|g| g * length);
        slip.mapv_inplace(|s| s * length);
        Self {
            mean_pressure: self.mean_pressure * stress,
            mean_shear: self.mean_shear.map(|t| t * stress),
            approach: self.approach * length,
            lateral: self.lateral.map(|u| u * length),
            elastic_energy: self.elastic_energy * stress * length,
            dissipated: self.dissipated * stress * length,
            ..self
        }
    }

    /// Returns the index of the normal component.
    fn z(&self) -> usize {
        self.traction.len_of(Axis(0)) - 1
    }
}

impl Fields for FrictionState {
    fn pressure(&self) -> CowArray<'_, f64, Ix2> {
        self.traction.index_axis(Axis(0), self.z()).mapv(|t| -t).into()
    }

    fn displacement_z(&self) -> ArrayView2<'_, f64> {
        self.displacement.index_axis(Axis(0), self.z())
    }

    fn gap(&self) -> ArrayView2<'_, f64> {
        self.gap.view()
    }

    fn mean_pressure(&self) -> f64 {
        self.mean_pressure
    }

    fn approach(&self) -> f64 {
        self.approach
    }

    fn effort(&self) -> Effort {
        self.effort
    }

    fn residuals(&self) -> Vec<(&'static str, f64)> {
        self.residual.parts().into()
    }

    fn scales(&self) -> Scales {
        Scales { contact_modulus: self.contact_modulus, rms_gradient: self.surface.rms_gradient() }
    }

    fn summary_in(&self, scales: &Scales) -> Summary {
        let pressure = self.pressure();
        let (displacement, gap, boundary) = (self.displacement_z(), self.gap(), self.surface.boundary());
        let summary = Summary::of(pressure.view(), displacement, gap, self.mean_pressure, scales, boundary);
        Summary { elastic_energy: self.elastic_energy, ..summary.at_wall() }
    }
}
