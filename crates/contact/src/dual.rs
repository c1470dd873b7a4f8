//! The contact problem in terms of the pressure: minimise ½⟨p, G p⟩ + ⟨p, clearance − approach⟩ over p ≥ 0, or with
//! the mean of p prescribed and the approach as its multiplier (theory.md, section 7).

use std::borrow::Cow;
use std::cell::Cell;
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
}

/// With prescribed approach, a half-space that keeps its mean level answers to a uniform displacement with any stiffness.
/// What the contact makes of it depends on its area; this many times the softest other mode is a guess for the
/// preconditioner.
const LEVEL: f64 = 4.0;

/// Iterations after which [`Solver::Auto`] goes on without the preconditioner. Some 30 are the rule; where its guess is bad,
/// as on incompressible layers thinner than the grid is wide, the plain method is faster.
const PATIENCE: usize = 100;

/// The lengths are those of the grid, by construction: a transform cannot refuse them.
const FITS: &str = "every field of a contact problem has the size of its grid";

impl<'a> Dual<'a> {
    fn new(contact: &'a Contact, control: Control) -> Self {
        let response = contact.response;
        let (compliance, stiffness, linear) = match control {
            Control::MeanPressure(_) => {
                (Cow::from(response.compliance()), Cow::from(response.stiffness()), Cow::from(&contact.wall.clearance))
            }
            Control::Approach(approach) => {
                let (mut compliance, mut stiffness) = (response.compliance().to_vec(), response.stiffness().to_vec());
                let uniform = response.uniform_compliance();
                compliance[0] = uniform;
                stiffness[0] = if uniform > 0.0 { 1.0 / uniform } else { LEVEL * response.stiffness_range()[0] };
                let linear: Vec<f64> = contact.wall.clearance.iter().map(|c| c - approach).collect();
                (Cow::from(compliance), Cow::from(stiffness), Cow::from(linear))
            }
        };
        let points = response.grid().points();
        // Waves along the longer side.
        let stride = if points[0] >= points[1] { 1 } else { points[0] };
        let floating = matches!(control, Control::MeanPressure(_));
        let extension = Extension::new(points, floating, |periods| response.stiffness()[periods * stride]);
        Self { response, compliance, stiffness, linear, transforms: Transforms::new(response), extension }
    }
}

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
        let Self { response, stiffness, transforms, extension, .. } = self;
        extension.prepare(known);
        let rows = |i: usize, row: &mut [f64]| extension.row(known, i, row);
        response.transform().convolve_rows(stiffness, rows, out, |_, _| {}, &mut transforms.workspace).expect(FITS);
        extension.transpose(known, out);
    }
}

pub(crate) fn solve(
    contact: &Contact,
    control: Control,
    settings: &Settings,
    start: Option<Vec<f64>>,
    watch: Watch,
) -> Result<Ended, ContactError> {
    let mut dual = Dual::new(contact, control);
    let n = contact.wall.clearance.len();
    let mean = match control {
        Control::MeanPressure(mean) => Some(mean),
        Control::Approach(_) => None,
    };
    let mut pressure = start.unwrap_or_else(|| vec![mean.unwrap_or(0.0); n]);
    let target = Target {
        mean,
        gradient_scale: contact.wall.rms_height,
        tolerance: settings.tolerance,
        max_iterations: usize::try_from(settings.max_iterations).unwrap_or(usize::MAX),
    };
    let before = Cell::new(0);
    let mut observe = |now: &Iterate| -> ControlFlow<()> {
        watch(&Progress { iteration: before.get() + now.iteration as u64, residual: now.optimality.worst() })
    };
    let (problem, x, observe) = (&mut dual, &mut pressure, &mut observe);
    let outcome = match settings.solver {
        Solver::PolonskyKeer => PolonskyKeer.minimise(problem, x, &target, observe),
        Solver::ProjectedCg => ProjectedCg.minimise(problem, x, &target, observe),
        Solver::Auto => {
            let patience = Target { max_iterations: target.max_iterations.min(PATIENCE), ..target };
            match PreconditionedCg.minimise(problem, x, &patience, observe) {
                Err(MinimiseError::NotConverged { reached, .. } | MinimiseError::Breakdown { reached, .. }) => {
                    before.set(reached.iteration as u64);
                    let rest = Target { max_iterations: target.max_iterations - reached.iteration, ..target };
                    ProjectedCg.minimise(problem, x, &rest, observe)
                }
                outcome => outcome,
            }
        }
        _ => PreconditionedCg.minimise(problem, x, &target, observe),
    };
    let transform_pairs = dual.transforms.pairs();
    let (reached, end) = match outcome {
        Ok(reached) => (reached, End::Converged),
        Err(MinimiseError::Interrupted { reached }) => (reached, End::Interrupted),
        Err(MinimiseError::NotConverged { reached, .. }) => (reached, End::GaveUp("the iteration limit".into())),
        Err(MinimiseError::Breakdown { reached, reason }) => (reached, End::GaveUp(reason.into())),
        Err(error) => return Err(ContactError::Start { reason: error.to_string() }),
    };
    Ok(Ended { pressure, iterations: before.get() + reached.iteration as u64, transform_pairs, end })
}

#[cfg(test)]
mod tests {
    use gfmd_field::Grid;
    use gfmd_green::{Body, Material};
    use gfmd_surface::{Discretisation, SelfAffine};

    use super::*;

    /// ⟨r, M r⟩ / ⟨r, G⁻¹ r⟩ on the part `share` of the highest points of a rough surface, for a pressure p = G⁻¹ r that is
    /// noise, smooth, or in between.
    fn quotients(body: &Body, share: f64) -> Vec<f64> {
        let grid = Grid::square(64, 1.0).unwrap();
        let response = NormalResponse::new(grid, body);
        let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: 8.0, eps_c_inv: 4.0 };
        let heights = numbers
            .self_affine(1.0, SelfAffine { hurst: 0.3, ..SelfAffine::with_rms_gradient(0.1) })
            .heights(&grid, 1)
            .unwrap();
        let mut sorted: Vec<f64> = heights.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let cut = sorted[((1.0 - share) * sorted.len() as f64) as usize];
        let contact = Contact::new(&response, heights.view()).unwrap();
        let mut dual = Dual::new(&contact, Control::MeanPressure(1.0));
        let x: Vec<f64> = heights.iter().map(|h| f64::from(*h > cut)).collect();
        let touching: f64 = x.iter().sum();
        (0..12)
            .map(|k| {
                let wave = |i: usize| (0.37 + 0.1 * (2.0_f64).powi(k) * i as f64).sin();
                let mut p: Vec<f64> = x.iter().enumerate().map(|(i, x)| x * wave(i)).collect();
                let mean = p.iter().sum::<f64>() / touching;
                p.iter_mut().zip(&x).for_each(|(p, x)| *p -= mean * x);
                let mut gradient = vec![0.0; x.len()];
                dual.apply(&p, &mut gradient);
                let exact: f64 = gradient.iter().zip(&p).map(|(g, p)| g * p).sum();
                // Nothing is about to enter.
                gradient.iter_mut().zip(&x).filter(|(_, x)| **x == 0.0).for_each(|(g, _)| *g = 1e9);
                let mut z = vec![0.0; x.len()];
                dual.precondition(&x, &gradient, 0.0, &mut z);
                assert!(z.iter().sum::<f64>().abs() < 1e-9 * z.iter().map(|z| z.abs()).sum::<f64>(), "keeps the load");
                gradient.iter().zip(&z).map(|(g, z)| g * z).sum::<f64>() / exact
            })
            .collect()
    }

    #[test]
    fn the_preconditioner_is_an_upper_bound_of_the_inverse_and_near_it() {
        let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap());
        for share in [0.02, 0.1, 0.4, 0.8, 0.99] {
            let quotients = quotients(&body, share);
            assert!(quotients.iter().all(|q| (1.0 - 1e-9..1.5).contains(q)), "{share}: {quotients:?}");
        }
    }
}
