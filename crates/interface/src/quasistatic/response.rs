use std::sync::Arc;

use gfmd_response::{Components, FreeFullCompliance, FreeFullTransforms, FullResponse, FullTransforms};

/// Response of the body with either boundary.
#[derive(Clone, Debug)]
pub(super) enum Response {
    Periodic(Arc<FullResponse>),
    Free(Arc<FreeFullCompliance>),
}

impl Response {
    pub(super) fn components(&self) -> Components {
        match self {
            Self::Periodic(response) => response.components(),
            Self::Free(response) => response.components(),
        }
    }

    /// Returns the smallest and largest stiffness, stress/length.
    pub(super) fn stiffness_range(&self) -> [f64; 2] {
        match self {
            Self::Periodic(response) => response.stiffness_range(),
            Self::Free(response) => response.stiffness_range(),
        }
    }

    pub(super) fn transforms(&self) -> Transforms {
        match self {
            Self::Periodic(response) => Transforms::Periodic(FullTransforms::of(response)),
            Self::Free(response) => Transforms::Free(FreeFullTransforms::of(response)),
        }
    }
}

/// Transforms of a [`Response`].
pub(super) enum Transforms {
    Periodic(FullTransforms),
    Free(FreeFullTransforms),
}

impl Transforms {
    /// Computes `displacement` = G `traction`.
    pub(super) fn compliance(&mut self, traction: &[f64], displacement: &mut [f64]) {
        match self {
            Self::Periodic(transforms) => transforms.compliance(traction, displacement),
            Self::Free(transforms) => transforms.compliance(traction, displacement),
        }
    }

    /// Computes the lateral displacement caused by a lateral traction.
    pub(super) fn lateral_compliance(&mut self, traction: &[f64], displacement: &mut [f64]) {
        match self {
            Self::Periodic(transforms) => transforms.lateral_compliance(traction, displacement),
            Self::Free(transforms) => transforms.lateral_compliance(traction, displacement),
        }
    }

    /// Computes the lateral traction of a lateral displacement without u_z; false with free boundaries, whose stiffness
    /// is not known.
    pub(super) fn lateral_stiffness(&mut self, displacement: &[f64], traction: &mut [f64]) -> bool {
        match self {
            Self::Periodic(transforms) => {
                transforms.lateral_stiffness(displacement, traction);
                true
            }
            Self::Free(_) => false,
        }
    }

    /// Returns the number of transform pairs so far, per component.
    pub(super) fn pairs(&self) -> f64 {
        match self {
            Self::Periodic(transforms) => transforms.pairs(),
            Self::Free(transforms) => transforms.pairs(),
        }
    }
}
