//! Augmented Lagrangian: a force replaces the bounds, so that the inertia may be a matrix.

use gfmd_vector::{for_each, pass};

use crate::{
    Bounds, Landscape, Visit,
    bounds::{Wall, within},
};

/// Convex energy U(u) = ½⟨u, K u⟩ − ⟨b, u⟩ with bounds on u. Together with springs of stiffness ϱ on every entry, it
/// can be minimised directly.
pub trait Proximal {
    /// Returns the number of entries of u.
    fn len(&self) -> usize;

    /// Returns true if there are no entries.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the allowed values of u.
    fn bounds(&self) -> Bounds<'_>;

    /// Returns the stiffness ϱ of the springs, best chosen between the softest and the stiffest mode.
    fn penalty(&self) -> f64;

    /// Writes (K + ϱ)⁻¹ (b + ϱ `anchor`), the minimum of U + ϱ/2 |u − anchor|² without bounds, into `u`.
    fn settle(&mut self, anchor: &[f64], u: &mut [f64]);

    /// Returns the dimensionless distance from the solution, computed from the difference between the positions u and w
    /// of [`AugmentedLagrangian`].
    fn residual(&self, mismatch: &[f64]) -> f64;

    /// Visits the variables that the problem itself changes during a search, for example an effort counter.
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let _ = visitor;
    }
}

/// [`Proximal`] problem as a [`Landscape`] without bounds, with inertia K + ϱ and a force in place of the bounds. It is
/// the augmented Lagrangian with the multiplier λ = ϱ (v − w) updated in every step (theory.md, section 6.3).
///
/// The position is w = Π v; v exceeds the bounds by λ/ϱ, with the reaction λ. The force M⁻¹ (b − K w − λ), with M = K +
/// ϱ, equals u − w with u = M⁻¹ (b + ϱ (w − λ/ϱ)) and needs M⁻¹ only once. If it vanishes, b − K w = λ: free entries
/// have no force, and entries at a bound are pressed against it. Steps v + τ M⁻¹ f with 0 < τ < 2 converge from any
/// start for every ϱ (Douglas and Rachford 1956, Lions and Mercier 1979); [`Nesterov`](crate::Nesterov) accelerates
/// them. There is no energy; the substitute ½ ϱ |u − w|² decreases in every step without momentum.
#[derive(Clone, Debug)]
pub struct AugmentedLagrangian<P> {
    problem: P,
    anchor: Vec<f64>,
}

impl<P: Proximal> AugmentedLagrangian<P> {
    /// Creates the augmented Lagrangian of `problem`.
    pub fn new(problem: P) -> Self {
        let anchor = vec![0.0; problem.len()];
        Self { problem, anchor }
    }

    /// Returns the problem.
    pub fn problem(&self) -> &P {
        &self.problem
    }

    /// Returns the problem for changes that preserve its solution.
    pub fn problem_mut(&mut self) -> &mut P {
        &mut self.problem
    }

    /// Returns the reaction λ = ϱ (v − Π v) of the bounds, positive at an upper bound.
    pub fn reaction(&self, v: &[f64]) -> Vec<f64> {
        let mut reaction = v.to_vec();
        self.problem.bounds().project(&mut reaction);
        let penalty = self.problem.penalty();
        reaction.iter_mut().zip(v).for_each(|(w, v)| *w = penalty * (v - *w));
        reaction
    }
}

impl<P: Proximal> Landscape for AugmentedLagrangian<P> {
    fn len(&self) -> usize {
        self.problem.len()
    }

    fn force(&mut self, v: &[f64], force: &mut [f64]) -> f64 {
        fn reflect(wall: impl Wall, v: &[f64], anchor: &mut [f64]) {
            let leaf = |start: usize, [anchor]: [&mut [f64]; 1]| {
                let wall = wall.stretch(start..start + anchor.len());
                for (k, (anchor, &v)) in anchor.iter_mut().zip(&v[start..]).enumerate() {
                    *anchor = 2.0 * wall.clip(k, v) - v;
                }
            };
            for_each([anchor], &leaf);
        }
        fn mismatch(wall: impl Wall, v: &[f64], u: &mut [f64]) -> f64 {
            let leaf = |start: usize, [u]: [&mut [f64]; 1]| {
                let wall = wall.stretch(start..start + u.len());
                let mut sum = 0.0;
                for (k, (u, &v)) in u.iter_mut().zip(&v[start..]).enumerate() {
                    *u -= wall.clip(k, v);
                    sum += *u * *u;
                }
                sum
            };
            pass([u], &leaf, &|a, b| a + b)
        }
        let Self { problem, anchor } = self;
        within!(problem.bounds(), wall => reflect(wall, v, anchor));
        problem.settle(anchor, force);
        let squares = within!(problem.bounds(), wall => mismatch(wall, v, force));
        0.5 * problem.penalty() * squares
    }

    fn residual(&self, _: &[f64], force: &[f64]) -> f64 {
        self.problem.residual(force)
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        self.problem.visit(visitor);
    }
}
