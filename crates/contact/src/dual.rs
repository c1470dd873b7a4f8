//! The contact problem in terms of the pressure: minimise ½⟨p, G p⟩ + ⟨p, clearance − approach⟩ over p ≥ 0, or with
//! the mean of p prescribed and the approach as its multiplier (theory.md, section 7).

use std::borrow::Cow;
use std::ops::ControlFlow;

use gfmd_relax::{Iterate, MinimiseError, PolonskyKeer, PreconditionedCg, ProjectedCg, Quadratic, Target};
use gfmd_response::NormalResponse;

use crate::extension::{Extension, Known};
use crate::problem::{End, Ended, Transforms};
use crate::{Contact, ContactError, Control, Progress, Settings, Solver, Watch};

struct Dual<'a> {
    response: &'a NormalResponse,
    compliance: Cow<'a, [f64]>,
    /// Inverse of `compliance`, but finite at q = 0.
    stiffness: Cow<'a, [f64]>,
    linear: Cow<'a, [f64]>,
    transforms: Transforms,
    extension: Extension,
    /// E r, on the way through the preconditioner.
    displacement: Vec<f64>,
}

/// With prescribed approach, a half-space that keeps its mean level answers to a uniform displacement with any stiffness.
/// What the contact makes of it depends on its area; this many times the softest other mode is a guess for the
/// preconditioner.
const LEVEL: f64 = 4.0;

/// The lengths are those of the grid, by construction: a transform cannot refuse them.
const FITS: &str = "every field of a contact problem has the size of its grid";

impl Quadratic for Dual<'_> {
    fn linear(&self) -> &[f64] {
        &self.linear
    }

    fn apply(&mut self, x: &[f64], out: &mut [f64]) {
        self.transforms.singles += 2;
        self.response.transform().convolve(&self.compliance, x, out, &mut self.transforms.workspace).expect(FITS);
    }

    fn curvature(&mut self, direction: &[f64]) -> f64 {
        self.transforms.singles += 1;
        let mean =
            self.response.transform().quadratic_form(&self.compliance, direction, &mut self.transforms.workspace);
        mean.expect(FITS) * direction.len() as f64
    }

    /// Eᵀ K E with E the extension from the contact to the whole surface: (G on the contact)⁻¹ is the least of ⟨u, K u⟩
    /// over all displacements that agree on the contact, and E makes a good guess of the one that is least.
    fn precondition(&mut self, x: &[f64], gradient: &[f64], multiplier: f64, out: &mut [f64]) {
        self.transforms.singles += 2;
        let known = Known { x, gradient, level: multiplier };
        let Self { response, stiffness, transforms, extension, displacement, .. } = self;
        extension.extend(known, displacement);
        response.transform().convolve(stiffness, displacement, out, &mut transforms.workspace).expect(FITS);
        extension.transpose(known, displacement, out);
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
    let mean = match control {
        Control::MeanPressure(mean) => Some(mean),
        Control::Approach(_) => None,
    };
    let (compliance, stiffness, linear) = match control {
        Control::MeanPressure(_) => {
            (Cow::from(response.compliance()), Cow::from(response.stiffness()), Cow::from(&contact.clearance))
        }
        Control::Approach(approach) => {
            let (mut compliance, mut stiffness) = (response.compliance().to_vec(), response.stiffness().to_vec());
            compliance[0] = response.uniform_compliance();
            stiffness[0] =
                if compliance[0] > 0.0 { 1.0 / compliance[0] } else { LEVEL * response.stiffness_range()[0] };
            let linear: Vec<f64> = contact.clearance.iter().map(|c| c - approach).collect();
            (Cow::from(compliance), Cow::from(stiffness), Cow::from(linear))
        }
    };
    let points = response.grid().points();
    // Waves along the longer side.
    let stride = if points[0] >= points[1] { 1 } else { points[0] };
    let extension = Extension::new(points, mean.is_some(), |periods| response.stiffness()[periods * stride]);
    let transforms = Transforms::new(response);
    let mut dual = Dual { response, compliance, stiffness, linear, transforms, extension, displacement: vec![0.0; n] };
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
        Solver::ProjectedCg => ProjectedCg.minimise(&mut dual, &mut pressure, &target, &mut observe),
        _ => PreconditionedCg.minimise(&mut dual, &mut pressure, &target, &mut observe),
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
