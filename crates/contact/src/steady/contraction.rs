//! Fall-back of the Newton search, which converges for every material: contacts with the real part of the stiffness,
//! one after the other (theory.md, section 7.8).

use gfmd_relax::{Anderson, Budget, Ending, Watch, Why};
use gfmd_response::ComplexTransforms;
use gfmd_vector::{contiguous, lower, reduce, sum};
use ndarray::Array2;
use num_complex::Complex64;

use super::SteadyContact;
use crate::{Contact, Effort, Equilibrium as _, Fields as _, Load, Refusal, Solution, SolveError, Solver};

/// Number of images mixed in a step.
const DEPTH: usize = 8;
/// Tolerance of the first inner contact, and upper limit for the later ones.
const FIRST_INNER_TOLERANCE: f64 = 1e-3;
/// Tolerance of an inner contact divided by the last certified residual, at least this fraction of the tolerance.
const INNER_TOLERANCE_FACTOR: f64 = 0.1;
/// Number of steps within which the residual must halve.
const STEPS_TO_HALVE: u32 = 200;

/// Search for a steady state, in the units of the input.
pub(super) struct Contraction<'a> {
    steady: &'a SteadyContact,
    budget: Budget,
    /// Contact of the undeformed surface with the real part of the stiffness.
    storing: Contact,
    /// √A of each mode, with A = 1/Re S.
    root: Vec<Complex64>,
    /// (G − A)/√A of each mode.
    rest: Vec<Complex64>,
    transforms: ComplexTransforms<f64>,
    effort: Effort,
}

impl<'a> Contraction<'a> {
    pub(super) fn new(steady: &'a SteadyContact, budget: Budget) -> Self {
        let (contact, modulus) = (&steady.contact, &steady.modulus);
        let stored: Vec<f64> = modulus.iter().enumerate().map(|(k, m)| if k == 0 { 1.0 } else { m.re }).collect();
        let mut compliance = contact.response.compliance().to_vec();
        compliance[0] = contact.uniform_compliance();
        let unit = contact.units().stiffness();
        let root: Vec<f64> = compliance.iter().zip(&stored).map(|(g, stored)| (g / (unit * stored)).sqrt()).collect();
        let rest = root.iter().zip(&**modulus).zip(&stored).enumerate().map(|(index, ((root, modulus), stored))| {
            match index {
                0 => Complex64::ZERO,
                // G = A Re S/S.
                _ => root * (stored / modulus - 1.0),
            }
        });
        Self {
            storing: steady.storing(),
            rest: rest.collect(),
            root: root.iter().map(|root| Complex64::from(*root)).collect(),
            transforms: ComplexTransforms::new(*contact.surface().grid()),
            effort: Effort::default(),
            steady,
            budget,
        }
    }

    fn convolve(transforms: &mut ComplexTransforms<f64>, kernel: &[Complex64], field: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; field.len()];
        transforms.convolve(kernel, field, &mut out);
        out
    }

    /// Computes √A p for a pressure.
    fn image(&mut self, pressure: &Array2<f64>) -> Vec<f64> {
        Self::convolve(&mut self.transforms, &self.root, &contiguous(pressure))
    }

    /// Solves the contact with the real part of the stiffness; the imaginary part for `x` adds to the gap.
    fn inner(
        &mut self,
        x: &[f64],
        (load, tolerance): (Load, f64),
        start: Option<&Solution>,
        watch: &mut dyn Watch,
    ) -> Result<(Solution, bool), Refusal> {
        let added = Self::convolve(&mut self.transforms, &self.rest, x);
        let surface = self.steady.contact.surface();
        let clearance = surface.clearance();
        let least = |range: std::ops::Range<usize>| {
            range.fold(f64::INFINITY, |least, i| lower(least, clearance.at(i) + added[i]))
        };
        let touch = reduce(added.len(), &least, &lower);
        let points = surface.grid().points();
        let depth = Array2::from_shape_vec(points, added.iter().map(|added| added - touch).collect());
        let contact = self.storing.with_indentation(&depth.expect("every field has the size of the grid"))?;
        let none = || Array2::zeros(points);
        let load = match load {
            Load::Approach(approach) if approach <= touch => {
                return Ok((contact.certify(&none(), Load::Approach(approach - touch))?, false));
            }
            Load::Approach(approach) => Load::Approach(approach - touch),
            load => load,
        };
        let left = self.budget.max_iterations.saturating_sub(self.effort.iterations).max(1);
        let budget = Budget { tolerance, max_iterations: left };
        let start = start.filter(|start| start.mean_pressure > 0.0);
        let (solution, is_interrupted) = match contact.equilibrate(load.into(), Solver::Auto, &budget, start, watch) {
            Ok(solution) => (solution, false),
            Err(SolveError::Refused(refusal)) => return Err(refusal),
            Err(SolveError::Interrupted { state }) => (*state, true),
            // The certificate of the complete problem decides.
            Err(SolveError::NotConverged { state, .. } | SolveError::Detached { state, .. }) => (*state, false),
        };
        self.effort.add(solution.effort);
        Ok((solution, is_interrupted))
    }

    /// Returns the effort so far.
    fn effort(&self) -> Effort {
        let Effort { iterations, transform_pairs } = self.effort;
        Effort { iterations, transform_pairs: transform_pairs + self.transforms.pairs() }
    }

    /// Runs the search from the state `best`.
    pub(super) fn run(
        mut self,
        load: Load,
        mut best: Solution,
        watch: &mut dyn Watch,
    ) -> Result<(Solution, Ending), Refusal> {
        let tolerance = self.budget.tolerance;
        let mut x = self.image(&best.pressure);
        let mut warm = Some(best.clone());
        let mut inner = FIRST_INNER_TOLERANCE.max(tolerance);
        let mut mixing = Anderson::new(DEPTH);
        // An iterate whose image is not far, and this difference.
        let mut safe: Option<(Vec<f64>, f64)> = None;
        let (mut halved, mut since) = (f64::INFINITY, 0);
        loop {
            let (solution, is_interrupted) = self.inner(&x, (load, inner), warm.as_ref(), watch)?;
            let image = self.image(&solution.pressure);
            let certified = self.steady.certify(&solution.pressure, load)?;
            self.effort.transform_pairs += certified.effort.transform_pairs;
            let worst = certified.worst();
            warm = Some(certified.clone());
            if worst < best.worst() {
                best = certified;
            }
            best.effort = self.effort();
            if is_interrupted {
                return Ok((best, Ending::Interrupted));
            }
            if best.worst() <= tolerance {
                return Ok((best, Ending::Converged));
            }
            if self.effort.iterations >= self.budget.max_iterations {
                return Ok((best, Ending::GaveUp(Why::Iterations)));
            }
            since += 1;
            if worst <= 0.5 * halved {
                (halved, since) = (worst, 0);
            } else if since > STEPS_TO_HALVE {
                return Ok((best, Ending::GaveUp(Why::Certificate)));
            }
            inner = (INNER_TOLERANCE_FACTOR * worst)
                .clamp(INNER_TOLERANCE_FACTOR * tolerance, FIRST_INNER_TOLERANCE.max(tolerance));
            let apart: f64 = sum(x.len(), &|range| range.map(|i| (image[i] - x[i]).powi(2)).sum());
            match &safe {
                // The mixed step is worse than the last image; restart from that image with a plain step.
                Some((image, least)) if apart > *least => {
                    x.copy_from_slice(image);
                    mixing = Anderson::new(DEPTH);
                    safe = None;
                }
                _ => {
                    mixing.advance(&mut x, &image);
                    safe = Some((image, apart));
                }
            }
        }
    }
}
