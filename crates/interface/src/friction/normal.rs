use gfmd_field::Workspace;
use gfmd_relax::Quadratic;
use gfmd_response::FullResponse;

/// The normal problem: ½⟨p, G_zz p⟩ + ⟨p, linear⟩ → min over p ≥ 0.
pub(super) struct NormalProblem<'a> {
    response: &'a FullResponse,
    workspace: Workspace,
    /// G_zz of every mode.
    compliance: Vec<f64>,
    /// The clearance less the u_z of the shear, and less the approach if it is prescribed.
    pub(super) linear: Vec<f64>,
    /// The number of transform pairs so far.
    pub(super) pairs: u64,
}

impl<'a> NormalProblem<'a> {
    pub(super) fn new(response: &'a FullResponse, clearance: &[f64]) -> Self {
        Self {
            response,
            workspace: response.compliance().transform().workspace(),
            compliance: response.compliance().matrices().iter().map(|matrix| matrix.zz).collect(),
            linear: clearance.to_vec(),
            pairs: 0,
        }
    }
}

impl Quadratic for NormalProblem<'_> {
    fn linear(&self) -> &[f64] {
        &self.linear
    }

    fn apply(&mut self, x: &[f64], out: &mut [f64]) {
        self.pairs += 1;
        let transform = self.response.compliance().transform();
        transform.convolve(&self.compliance, x, out, &mut self.workspace).expect(super::FITS);
    }

    fn curvature(&mut self, direction: &[f64]) -> f64 {
        self.pairs += 1;
        let transform = self.response.compliance().transform();
        let mean = transform.quadratic_form(&self.compliance, direction, &mut self.workspace);
        mean.expect(super::FITS) * direction.len() as f64
    }
}
