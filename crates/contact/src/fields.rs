use gfmd_measure::{Scales, Summary};
use ndarray::{ArrayView2, CowArray, Ix2};

use crate::Effort;

/// State of a contact at rest, or of an unfinished search. Fields are `[x, y]`.
pub trait Fields {
    /// Returns the normal pressure on the elastic surface, in stress; attraction is negative.
    fn pressure(&self) -> CowArray<'_, f64, Ix2>;

    /// Returns the repulsive part of the pressure, in stress; it is ≥ 0, and positive at the points in contact.
    fn repulsion(&self) -> CowArray<'_, f64, Ix2> {
        let pressure = self.pressure();
        let is_repulsion = pressure.iter().all(|p| *p >= 0.0);
        if is_repulsion { pressure } else { pressure.mapv(|p| p.max(0.0)).into() }
    }

    /// Returns the normal displacement u_z of the elastic surface, in length; negative downwards.
    fn displacement_z(&self) -> ArrayView2<'_, f64>;

    /// Returns the distance between the surfaces, in length.
    fn gap(&self) -> ArrayView2<'_, f64>;

    /// Returns the mean pressure over the whole surface, in stress.
    fn mean_pressure(&self) -> f64;

    /// Returns the rigid approach beyond first touch of the undeformed surfaces, in length.
    fn approach(&self) -> f64;

    /// Returns the effort of the solve.
    fn effort(&self) -> Effort;

    /// Returns the residuals with their names, computed from the fields; zero for the exact state.
    fn residuals(&self) -> Vec<(&'static str, f64)>;

    /// Returns the largest residual; NaN if any residual is NaN.
    fn worst(&self) -> f64 {
        gfmd_relax::worst(self.residuals().into_iter().map(|(_, residual)| residual))
    }

    /// Returns the scales of reduced quantities, with the [rms gradient](crate::RigidSurface::rms_gradient).
    fn scales(&self) -> Scales;

    /// Returns the numbers that describe the contact, with reduced quantities in units of `scales`.
    fn summary_in(&self, scales: &Scales) -> Summary;

    /// Returns the numbers that describe the contact: area, kappa, pressure statistics, energy.
    fn summary(&self) -> Summary {
        self.summary_in(&self.scales())
    }
}

/// State that contains another one, such as a [`Solution`](crate::Solution), and shares its fields.
pub trait Solved {
    /// State contained.
    type Inner: Fields;

    /// Returns the state contained, with fields, loads, residuals and effort.
    fn solution(&self) -> &Self::Inner;

    /// Returns the additional residual with its name, if there is one.
    fn further_residual(&self) -> Option<(&'static str, f64)> {
        None
    }

    /// Returns the elastic energy per area, in stress × length, if it does not follow from pressure and displacement.
    fn stored_energy(&self) -> Option<f64> {
        None
    }

    /// Returns the scales of reduced quantities, if they differ from the scales of the state contained.
    fn reduced_by(&self) -> Option<Scales> {
        None
    }
}

impl<S: Solved> Fields for S {
    fn pressure(&self) -> CowArray<'_, f64, Ix2> {
        self.solution().pressure()
    }

    fn repulsion(&self) -> CowArray<'_, f64, Ix2> {
        self.solution().repulsion()
    }

    fn displacement_z(&self) -> ArrayView2<'_, f64> {
        self.solution().displacement_z()
    }

    fn gap(&self) -> ArrayView2<'_, f64> {
        self.solution().gap()
    }

    fn mean_pressure(&self) -> f64 {
        self.solution().mean_pressure()
    }

    fn approach(&self) -> f64 {
        self.solution().approach()
    }

    fn effort(&self) -> Effort {
        self.solution().effort()
    }

    fn residuals(&self) -> Vec<(&'static str, f64)> {
        self.solution().residuals().into_iter().chain(self.further_residual()).collect()
    }

    fn scales(&self) -> Scales {
        self.reduced_by().unwrap_or_else(|| self.solution().scales())
    }

    fn summary_in(&self, scales: &Scales) -> Summary {
        let summary = self.solution().summary_in(scales);
        Summary { elastic_energy: self.stored_energy().unwrap_or(summary.elastic_energy), ..summary }
    }
}
