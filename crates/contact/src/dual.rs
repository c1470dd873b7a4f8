//! The contact problem in terms of the pressure: minimise ½⟨p, G p⟩ + ⟨p, clearance − approach⟩ over p ≥ 0, or with
//! the mean of p prescribed and the approach as its multiplier (theory.md, section 7).

use std::borrow::Cow;
use std::ops::ControlFlow;

use gfmd_relax::{Iterate, MinimiseError, PolonskyKeer, ProjectedCg, Quadratic, Target};

use crate::problem::{End, Ended, Transforms};
use crate::{Contact, ContactError, Control, Progress, Settings, Solver, SurfaceResponse, Watch};

struct Dual<'a> {
    response: &'a SurfaceResponse,
    compliance: Cow<'a, [f64]>,
    linear: Cow<'a, [f64]>,
    transforms: Transforms,
}

/// The lengths are those of the grid, by construction: a transform cannot refuse them.
const FITS: &str = "every field of a contact problem has the size of its grid";

impl Quadratic for Dual<'_> {
    fn linear(&self) -> &[f64] {
        &self.linear
    }

    fn apply(&mut self, x: &[f64], out: &mut [f64]) {
        self.transforms.singles += 2;
        self.response.transform.convolve(&self.compliance, x, out, &mut self.transforms.workspace).expect(FITS);
    }

    fn curvature(&mut self, direction: &[f64]) -> f64 {
        self.transforms.singles += 1;
        let mean = self.response.transform.quadratic_form(&self.compliance, direction, &mut self.transforms.workspace);
        mean.expect(FITS) * direction.len() as f64
    }

    fn precondition(&mut self, x: &[f64], out: &mut [f64]) {
        self.transforms.singles += 2;
        let workspace = &mut self.transforms.workspace;
        self.response.transform.convolve(&self.response.stiffness, x, out, workspace).expect(FITS);
    }
}

pub(crate) fn solve(
    contact: &Contact,
    control: Control,
    settings: &Settings,
    start: Option<Vec<f64>>,
    watch: Watch,
) -> Result<Ended, ContactError> {
    let response = contact.response;
    let n = contact.clearance.len();
    let (mean, compliance, linear) = match control {
        Control::MeanPressure(mean) => (Some(mean), Cow::from(&response.compliance), Cow::from(&contact.clearance)),
        Control::Approach(approach) => {
            let mut compliance = response.compliance.clone();
            compliance[0] = response.uniform_compliance;
            let linear: Vec<f64> = contact.clearance.iter().map(|c| c - approach).collect();
            (None, Cow::from(compliance), Cow::from(linear))
        }
    };
    let mut dual = Dual { response, compliance, linear, transforms: Transforms::new(response) };
    let mut pressure = start.unwrap_or_else(|| vec![mean.unwrap_or(0.0); n]);
    let target = Target {
        mean,
        gradient_scale: contact.rms_height,
        tolerance: settings.tolerance,
        max_iterations: usize::try_from(settings.max_iterations).unwrap_or(usize::MAX),
    };
    let mut observe = |now: &Iterate| -> ControlFlow<()> {
        watch(&Progress { iteration: now.iteration as u64, residual: now.optimality.worst() })
    };
    let outcome = match settings.solver {
        Solver::PolonskyKeer => PolonskyKeer.minimise(&mut dual, &mut pressure, &target, &mut observe),
        solver => {
            let preconditioned = solver != Solver::ProjectedCg;
            ProjectedCg { preconditioned }.minimise(&mut dual, &mut pressure, &target, &mut observe)
        }
    };
    let transform_pairs = dual.transforms.pairs();
    let (reached, end) = match outcome {
        Ok(reached) => (reached, End::Converged),
        Err(MinimiseError::Interrupted { reached }) => (reached, End::Interrupted),
        Err(MinimiseError::NotConverged { reached, .. }) => (reached, End::GaveUp("the iteration limit".into())),
        Err(MinimiseError::Breakdown { reached, reason }) => (reached, End::GaveUp(reason.into())),
        Err(error) => return Err(ContactError::Start { reason: error.to_string() }),
    };
    Ok(Ended { pressure, iterations: reached.iteration as u64, transform_pairs, end })
}
