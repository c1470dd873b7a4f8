use std::sync::Arc;

use gfmd_contact::{Effort, Fields, RigidSurface};
use gfmd_measure::{Scales, Summary};
use ndarray::{Array2, Array3, ArrayView2, Axis, CowArray, Ix2};

/// An interface in equilibrium. Fields are `[x, y]`, vectors `[component, x, y]` with z the last component.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Displacement of the elastic surface, length.
    pub displacement: Array3<f64>,
    /// Traction on the elastic surface from law and wall together, stress.
    pub traction: Array3<f64>,
    /// Distance between the surfaces, length.
    pub gap: Array2<f64>,
    /// Pressure of the hard wall, stress ≥ 0; 0 without a wall. It does not include attraction.
    pub wall_pressure: Array2<f64>,
    /// Depth by which the surfaces are pressed into each other beyond their state at the start of the search, where the
    /// pressure reaches the hardness, length ≥ 0; `None` without a hardness. The gap is 0 there.
    pub pressed_in: Option<Array2<f64>>,
    /// Mean of −t_z, stress; negative if the surfaces are pulled apart.
    pub mean_pressure: f64,
    /// Mean lateral traction on the elastic surface along x and y, stress.
    pub mean_shear: [f64; 2],
    /// Rigid approach beyond first touch of the undeformed surfaces, length.
    pub approach: f64,
    /// Lateral displacement of the rigid surface, length.
    pub lateral: [f64; 2],
    /// Elastic energy per area, stress × length.
    pub elastic_energy: f64,
    /// Energy of the law per area, stress × length; NaN if the law has none.
    pub interface_energy: f64,
    /// Fraction of points in contact: pressed by the wall, or repelled by a law without a wall.
    pub contact_fraction: f64,
    /// Distance from equilibrium, computed from the fields above.
    pub residual: Residual,
    /// Effort of the solve, including the transforms for the final fields.
    pub effort: Effort,
    /// True if the search from the start found directions of negative curvature. A jump always causes this; a long
    /// smooth step may. Dynamics does not compute curvatures and leaves it false.
    pub passed_instability: bool,
    /// Lowest curvature, relative to the preconditioner, found by conjugate gradients started from a force in all
    /// directions; positive in a stable state. 1 for a wall alone, NaN after dynamics.
    pub lowest_curvature: f64,
    /// True if the wall presses at some point.
    pub(crate) is_pressed: bool,
    /// Normal traction, in stress, that unbalanced forces or rounding errors can cause.
    pub(crate) noise: f64,
    pub(crate) surface: Arc<RigidSurface>,
    pub(crate) contact_modulus: f64,
}

/// Distance of a state from equilibrium; zero for the exact state. Stresses are divided by the largest traction, or by
/// the softest stiffness times the rms height if that is larger and there is a law besides a wall. Lengths are divided
/// by the rms height; for a flat surface they are in the unit of length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// Σ p g / (Σ p · h_rms) of the wall pressure p, in magnitude. It never exceeds the penetration.
    pub complementarity: f64,
    /// Largest unbalanced force per area.
    pub equilibrium: f64,
    /// max(0, −min gap) with a wall, else 0.
    pub penetration: f64,
    /// Largest tension required from the wall.
    pub wall_tension: f64,
    /// Mean pressure minus the prescribed value; 0 if the approach is prescribed.
    pub load: f64,
    /// Largest excess of the repulsion over its largest possible value; `None` without a hardness.
    pub saturation: Option<f64>,
}

impl Residual {
    /// Returns the residuals with their names; `saturation` only with a hardness.
    pub fn parts(&self) -> Vec<(&'static str, f64)> {
        let always = [
            ("complementarity", self.complementarity),
            ("equilibrium", self.equilibrium),
            ("penetration", self.penetration),
            ("wall_tension", self.wall_tension),
            ("load", self.load),
        ];
        always.into_iter().chain(self.saturation.map(|saturation| ("saturation", saturation))).collect()
    }

    /// Returns the largest residual; NaN if any residual is NaN.
    pub fn worst(&self) -> f64 {
        gfmd_relax::worst(self.parts().into_iter().map(|(_, residual)| residual))
    }
}

/// Ratio of mean to largest pressure below which κ is undefined: area divided by a vanishing load.
const LEAST_LOAD: f64 = 1e-6;

impl State {
    /// Multiplies all lengths and stresses by the given factors.
    #[must_use]
    pub fn times(mut self, length: f64, stress: f64) -> Self {
        let Self { displacement, traction, gap, wall_pressure, pressed_in, .. } = &mut self;
        displacement.mapv_inplace(|u| u * length);
        traction.mapv_inplace(|t| t * stress);
        gap.mapv_inplace(|g| g * length);
        wall_pressure.mapv_inplace(|p| p * stress);
        if let Some(depth) = pressed_in {
            depth.mapv_inplace(|depth| depth * length);
        }
        Self {
            mean_pressure: self.mean_pressure * stress,
            mean_shear: self.mean_shear.map(|t| t * stress),
            approach: self.approach * length,
            lateral: self.lateral.map(|u| u * length),
            elastic_energy: self.elastic_energy * stress * length,
            interface_energy: self.interface_energy * stress * length,
            noise: self.noise * stress,
            ..self
        }
    }

    fn normal_traction(&self) -> ArrayView2<'_, f64> {
        self.traction.index_axis(Axis(0), self.traction.len_of(Axis(0)) - 1)
    }
}

impl Fields for State {
    fn pressure(&self) -> CowArray<'_, f64, Ix2> {
        self.normal_traction().mapv(|t| -t).into()
    }

    /// Returns the repulsive pressure: the wall pressure or, if no wall presses, −t_z at points where it exceeds the
    /// unbalanced traction. Where a law vanishes, far from contact, rounding errors determine the sign of −t_z.
    fn repulsion(&self) -> CowArray<'_, f64, Ix2> {
        // The rows of one process may be without pressure.
        let is_pressed = match self.surface.share().is_whole() {
            true => self.wall_pressure.iter().any(|p| *p > 0.0),
            false => self.is_pressed,
        };
        if is_pressed {
            self.wall_pressure.view().into()
        } else {
            self.normal_traction().mapv(|t| if -t > self.noise { -t } else { 0.0 }).into()
        }
    }

    fn displacement_z(&self) -> ArrayView2<'_, f64> {
        self.displacement.index_axis(Axis(0), self.displacement.len_of(Axis(0)) - 1)
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
        self.residual.parts()
    }

    fn scales(&self) -> Scales {
        Scales { contact_modulus: self.contact_modulus, rms_gradient: self.surface.rms_gradient() }
    }

    /// Summarises the repulsive pressure; its points are in contact. κ is NaN if attraction carries the load, since
    /// area divided by pressure is then meaningless.
    fn summary_in(&self, scales: &Scales) -> Summary {
        let repulsion = self.repulsion();
        let fields = [repulsion.view(), self.displacement_z(), self.gap()];
        let (share, boundary) = (self.surface.share(), self.surface.boundary());
        let summary = Summary::distributed(share, fields, self.mean_pressure, scales, boundary);
        let is_closed = !share.any(self.wall_pressure.iter().any(|p| *p <= 0.0));
        let summary = if is_closed { summary.at_wall() } else { summary };
        let is_pressed = self.mean_pressure > LEAST_LOAD * summary.max_pressure;
        Summary {
            kappa: if is_pressed { summary.kappa } else { f64::NAN },
            kappa_corrected: if is_pressed { summary.kappa_corrected } else { f64::NAN },
            elastic_energy: self.elastic_energy,
            ..summary
        }
    }
}
