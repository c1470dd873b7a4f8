//! The contact problem in terms of the pressure: minimise ½⟨p, G p⟩ + ⟨p, clearance − approach⟩ over p ≥ 0, or with
//! the mean of p prescribed and the approach as its multiplier (theory.md, section 7).

use std::borrow::Cow;

use gfmd_relax::{Budget, Ending, PolonskyKeer, PreconditionedCg, ProjectedCg, Quadratic, RelaxError, Target};
use gfmd_relax::{Variables, Visit};

use crate::attempt::{Attempt, Ended};
use crate::compliance::Compliance;
use crate::pull_push::{Edges, Known, PullPush};
use crate::{Contact, Load};

/// The methods of conjugate gradients by name.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Gradients {
    /// Preconditioned, then projected if that takes too long.
    Auto,
    PolonskyKeer,
    Projected,
    Preconditioned,
}

/// Number of iterations without the preconditioner after which [`Solver::Auto`] returns to it. On cells a thousand times
/// longer than wide the method without it may not converge at all.
const LONGER_PATIENCE: u64 = 5000;

/// The quadratic function whose minimum is the pressure.
pub(crate) struct Dual<'a> {
    /// Of the periodic modes, as the stiffness; both have no use with free boundaries.
    compliance: Cow<'a, [f64]>,
    /// Inverse of `compliance`, but finite at q = 0.
    stiffness: Cow<'a, [f64]>,
    linear: Cow<'a, [f64]>,
    /// True if the approach is free, because the mean pressure is prescribed.
    floating: bool,
    /// The hardness, infinite without one.
    upper: f64,
    transforms: Compliance,
    extension: PullPush,
}

/// Stiffness of the uniform mode in the preconditioner, relative to the softest non-uniform mode. It is needed if the
/// approach on a half-space with a fixed mean level is prescribed; the effective stiffness then depends on the contact
/// area.
const LEVEL: f64 = 4.0;

/// Number of iterations after which [`Solver::Auto`] continues without the preconditioner. Some 30 are usually
/// sufficient; where the preconditioner is poor, as on incompressible layers thinner than the cell is wide, the method
/// without it is faster.
const PATIENCE: u64 = 100;

impl<'a> Dual<'a> {
    pub(crate) fn new(contact: &'a Contact, load: Load) -> Self {
        let Contact { response, scaled: surface, .. } = contact;
        let (mut compliance, mut stiffness) = (Cow::from(response.compliance()), Cow::from(response.stiffness()));
        let linear = match load {
            Load::MeanPressure(_) => Cow::from(surface.clearance()),
            Load::Approach(approach) => surface.clearance().iter().map(|c| c - approach).collect(),
        };
        if let (Load::Approach(_), None) = (load, &contact.free) {
            let uniform = response.uniform_compliance();
            compliance.to_mut()[0] = uniform;
            stiffness.to_mut()[0] = if uniform > 0.0 { 1.0 / uniform } else { LEVEL * response.stiffness_range()[0] };
        }
        let points = response.grid().points();
        // The waves along the longer side.
        let stride = if points[0] >= points[1] { 1 } else { points[0] };
        let floating = matches!(load, Load::MeanPressure(_));
        let edges = if contact.free.is_some() { Edges::Mirrored } else { Edges::Joined };
        let extension = PullPush::new(points, floating, edges, |periods| response.stiffness()[periods * stride]);
        let upper = contact.hardness.unwrap_or(f64::INFINITY);
        Self { compliance, stiffness, linear, floating, upper, transforms: Compliance::of(contact), extension }
    }

    /// `out` ← G `pressure`.
    pub(crate) fn displace(&mut self, pressure: &[f64], out: &mut [f64]) {
        self.transforms.apply(&self.compliance, pressure, out);
    }

    /// `out` ← about G⁻¹ (`displacement` − `level`) on the points where `touching` is positive, zero elsewhere.
    pub(crate) fn press(&mut self, touching: &[f64], displacement: &[f64], level: f64, out: &mut [f64]) {
        self.extend(Known { x: touching, gradient: displacement, level, upper: f64::INFINITY }, out);
    }

    /// `out` ← Eᵀ K E with E the extension of the known values.
    fn extend(&mut self, known: Known, out: &mut [f64]) {
        let Self { stiffness, floating, transforms, extension, .. } = self;
        extension.prepare(known);
        transforms.stiffness(stiffness, *floating, |i, row| extension.row(known, i, row), out);
        extension.transpose(known, out);
    }

    /// True if [`press`](Self::press) does not see constants, and its pressures have no sum.
    pub(crate) fn keeps_constants(&self) -> bool {
        self.extension.keeps_constants()
    }

    /// Transforms so far, in pairs.
    pub(crate) fn pairs(&self) -> f64 {
        self.transforms.pairs()
    }
}

impl Quadratic for Dual<'_> {
    fn linear(&self) -> &[f64] {
        &self.linear
    }

    fn upper(&self) -> f64 {
        self.upper
    }

    fn apply(&mut self, x: &[f64], out: &mut [f64]) {
        self.displace(x, out);
    }

    fn curvature(&mut self, direction: &[f64]) -> f64 {
        self.transforms.quadratic_form(&self.compliance, direction)
    }

    /// Applies Eᵀ K E with E the extension from the contact to the whole surface. The quadratic form of (G on the
    /// contact)⁻¹ is the minimum of ⟨u, K u⟩ over all displacements u with given values on the contact, and E
    /// approximates the u of this minimum.
    fn precondition(&mut self, x: &[f64], gradient: &[f64], multiplier: f64, out: &mut [f64]) {
        self.extend(Known { x, gradient, level: multiplier, upper: self.upper }, out);
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.count(self.transforms.counter());
    }
}

pub(crate) fn solve(mut attempt: Attempt, gradients: Gradients) -> Result<Ended, RelaxError> {
    let contact = attempt.contact;
    let mut dual = Dual::new(contact, attempt.load);
    let mean = match attempt.load {
        Load::MeanPressure(mean) => Some(mean),
        Load::Approach(_) => None,
    };
    let uniform = || vec![mean.unwrap_or(0.0); contact.scaled.clearance().len()];
    let mut pressure = attempt.start.take().unwrap_or_else(uniform);
    if let Some(hardness) = contact.hardness {
        pressure.iter_mut().for_each(|p| *p = p.min(hardness));
    }
    let x = &mut pressure;
    let target = Target { mean, gradient_scale: attempt.length_scale(), budget: attempt.budget };
    let minimum = match gradients {
        Gradients::PolonskyKeer => PolonskyKeer.minimise(&mut dual, x, &target, attempt.watch)?,
        Gradients::Projected => ProjectedCg.minimise(&mut dual, x, &target, attempt.watch)?,
        Gradients::Preconditioned => PreconditionedCg.minimise(&mut dual, x, &target, attempt.watch)?,
        // Only this method heeds the hardness.
        Gradients::Auto if contact.hardness.is_some() => {
            PreconditionedCg.minimise(&mut dual, x, &target, attempt.watch)?
        }
        Gradients::Auto => {
            // The parts of the search: preconditioned, without the preconditioner, and preconditioned again.
            let mut part = 0;
            if let Some(kept) = attempt.watch.recall() {
                attempt.effort.visit(kept);
                kept.small(&mut part);
            }
            loop {
                let Budget { tolerance, max_iterations } = attempt.budget_left();
                let limit = [PATIENCE, LONGER_PATIENCE].get(part as usize).copied().unwrap_or(u64::MAX);
                let budget = Budget { tolerance, max_iterations: max_iterations.min(limit) };
                let target = Target { budget, ..target };
                let plain = part == 1;
                let minimum = {
                    let mut onlooker = attempt.onlooker(|visitor| visitor.small(&mut part));
                    if plain {
                        ProjectedCg.minimise(&mut dual, x, &target, &mut onlooker)?
                    } else {
                        PreconditionedCg.minimise(&mut dual, x, &target, &mut onlooker)?
                    }
                };
                let is_over = part == 2 || plain && minimum.reached.iteration >= max_iterations;
                if is_over || !matches!(minimum.ending, Ending::GaveUp(_)) {
                    break minimum;
                }
                attempt.effort.iterations += minimum.reached.iteration;
                part += 1;
            }
        }
    };
    attempt.effort.iterations += minimum.reached.iteration;
    attempt.effort.transform_pairs += dual.transforms.pairs();
    Ok(Ended { pressure, effort: attempt.effort, ending: minimum.ending })
}

#[cfg(test)]
mod tests {
    use gfmd_field::Grid;
    use gfmd_green::{Body, Material};
    use gfmd_surface::{Discretisation, SelfAffine};

    use super::*;

    /// The quotients ⟨r, M r⟩ / ⟨r, G⁻¹ r⟩ on the fraction `share` of the highest points of a rough surface, for
    /// pressures p = G⁻¹ r from noise to smooth.
    fn quotients(body: &Body, share: f64) -> Vec<f64> {
        let grid = Grid::square(64, 1.0).unwrap();
        let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: 8.0, eps_c_inv: 4.0 };
        let heights = numbers
            .self_affine(1.0, SelfAffine { hurst: 0.3, ..SelfAffine::with_rms_gradient(0.1) })
            .heights(&grid, 1)
            .unwrap();
        let mut sorted: Vec<f64> = heights.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let cut = sorted[((1.0 - share) * sorted.len() as f64) as usize];
        let contact = Contact::new(body, &grid, &heights).unwrap();
        let mut dual = Dual::new(&contact, Load::MeanPressure(1.0));
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
                // No point is about to enter the contact.
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
