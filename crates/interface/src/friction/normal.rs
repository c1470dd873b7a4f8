use std::sync::Arc;

use gfmd_field::{Convolution, ShapeError, Workspace};
use gfmd_relax::Quadratic;
use gfmd_response::FullResponse;

use super::FITS;
use super::response::Response;

/// Normal problem: ½⟨p, G_zz p⟩ + ⟨p, linear⟩ → min over p ≥ 0.
pub(super) struct NormalProblem {
    compliance: Compliance,
    workspace: Workspace,
    /// Clearance minus the u_z of the shear, and minus the approach if prescribed.
    pub(super) linear: Vec<f64>,
    /// Number of transform pairs so far.
    pub(super) pairs: u64,
}

/// G_zz of every mode, or between two points.
enum Compliance {
    Periodic(Arc<FullResponse>, Vec<f64>),
    Free(Arc<Convolution>),
}

impl NormalProblem {
    pub(super) fn new(response: &Response, clearance: &[f64]) -> Self {
        let compliance = match response {
            Response::Periodic(response) => {
                let normal = response.compliance().matrices().iter().map(|matrix| matrix.zz).collect();
                Compliance::Periodic(Arc::clone(response), normal)
            }
            Response::Free(response) => Compliance::Free(Arc::clone(response.normal())),
        };
        let workspace = match &compliance {
            Compliance::Periodic(response, _) => response.compliance().transform().workspace(),
            Compliance::Free(convolution) => convolution.workspace(),
        };
        Self { compliance, workspace, linear: clearance.to_vec(), pairs: 0 }
    }
}

impl Quadratic for NormalProblem {
    fn linear(&self) -> &[f64] {
        &self.linear
    }

    fn apply(&mut self, x: &[f64], out: &mut [f64]) {
        self.pairs += 1;
        let Self { compliance, workspace, .. } = self;
        let applied: Result<(), ShapeError> = match compliance {
            Compliance::Periodic(response, normal) => {
                response.compliance().transform().convolve(normal, x, out, workspace)
            }
            Compliance::Free(convolution) => convolution.apply(x, out, workspace),
        };
        applied.expect(FITS);
    }

    fn curvature(&mut self, direction: &[f64]) -> f64 {
        self.pairs += 1;
        let Self { compliance, workspace, .. } = self;
        let sum = match compliance {
            Compliance::Periodic(response, normal) => {
                let mean = response.compliance().transform().quadratic_form(normal, direction, workspace);
                mean.map(|mean| mean * direction.len() as f64)
            }
            Compliance::Free(convolution) => convolution.quadratic_form(direction, workspace),
        };
        sum.expect(FITS)
    }
}
