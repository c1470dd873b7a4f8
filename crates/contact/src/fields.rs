use gfmd_measure::{Scales, Summary};
use ndarray::{ArrayView2, CowArray, Ix2};

use crate::Effort;

/// The state of a contact at rest, or of an unfinished search. Fields are `[x, y]`.
pub trait Fields {
    /// Normal pressure on the elastic surface, in stress; attraction is negative.
    fn pressure(&self) -> CowArray<'_, f64, Ix2>;

    /// The repulsive part of the pressure, in stress ≥ 0; its points are those in contact.
    fn repulsion(&self) -> CowArray<'_, f64, Ix2> {
        let pressure = self.pressure();
        let is_repulsion = pressure.iter().all(|p| *p >= 0.0);
        if is_repulsion { pressure } else { pressure.mapv(|p| p.max(0.0)).into() }
    }

    /// Normal displacement u_z of the elastic surface, in length; negative downwards.
    fn displacement_z(&self) -> ArrayView2<'_, f64>;

    /// Distance between the surfaces, in length.
    fn gap(&self) -> ArrayView2<'_, f64>;

    /// Mean pressure over the whole surface, in stress.
    fn mean_pressure(&self) -> f64;

    /// Rigid approach beyond first touch of the undeformed surfaces, in length.
    fn approach(&self) -> f64;

    /// The effort of the solve.
    fn effort(&self) -> Effort;

    /// The residuals with their names, computed from the fields; zero for the exact state.
    fn residuals(&self) -> Vec<(&'static str, f64)>;

    /// The largest of the residuals; NaN if any is NaN.
    fn worst(&self) -> f64 {
        gfmd_relax::worst(self.residuals().into_iter().map(|(_, residual)| residual))
    }

    /// The scales of reduced quantities. The rms gradient is the spectral one of the rigid surface.
    fn scales(&self) -> Scales;

    /// The numbers that describe the contact, with reduced quantities in units of `scales`.
    fn summary_in(&self, scales: &Scales) -> Summary;

    /// The numbers that describe the contact: area, kappa, pressure statistics, energy.
    fn summary(&self) -> Summary {
        self.summary_in(&self.scales())
    }
}

/// A state whose fields are those of another one that it contains, such as a [`Solution`](crate::Solution).
pub trait Solved {
    /// The state that it contains.
    type Inner: Fields;

    /// Fields, loads, residuals and effort.
    fn solution(&self) -> &Self::Inner;

    /// The residual beside those of the solution, with its name.
    fn further_residual(&self) -> Option<(&'static str, f64)> {
        None
    }

    /// Elastic energy per area, in stress × length, where it is not that of pressure and displacement.
    fn stored_energy(&self) -> Option<f64> {
        None
    }

    /// The scales of reduced quantities, where they are not those of the solution.
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
