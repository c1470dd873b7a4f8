use gfmd_measure::{Scales, Summary};
use ndarray::{ArrayView2, CowArray, Ix2};

use crate::Effort;

/// The state of a contact at rest, or of an unfinished search. Fields are `[x, y]`.
pub trait Fields {
    /// Normal pressure on the elastic surface, in stress; attraction is negative.
    fn pressure(&self) -> CowArray<'_, f64, Ix2>;

    /// The repulsive part of the pressure, in stress ≥ 0; its points are those in contact.
    fn repulsion(&self) -> CowArray<'_, f64, Ix2> {
        self.pressure().mapv(|p| p.max(0.0)).into()
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

/// The fields of a state whose [`Solution`](crate::Solution) is in `part`: the pressure, the displacement, the gap and the mean pressure.
macro_rules! fields_of {
    ($part:ident) => {
        fn pressure(&self) -> ndarray::CowArray<'_, f64, ndarray::Ix2> {
            $crate::Fields::pressure(&self.$part)
        }

        fn displacement_z(&self) -> ndarray::ArrayView2<'_, f64> {
            $crate::Fields::displacement_z(&self.$part)
        }

        fn gap(&self) -> ndarray::ArrayView2<'_, f64> {
            $crate::Fields::gap(&self.$part)
        }

        fn mean_pressure(&self) -> f64 {
            self.$part.mean_pressure
        }
    };
}
pub(crate) use fields_of;
