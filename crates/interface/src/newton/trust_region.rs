//! Conjugate gradients that stop at the edge of a trust region or at a negative curvature (Steihaug 1983).

use gfmd_relax::Visit;
use gfmd_vector::{Share, for_each};

use super::reaction::Reaction;
use crate::numbers::reduce;

/// Number type of a search, in double or single precision.
pub(crate) trait Number: Copy + Default + Send + Sync + Into<f64> {
    /// Best accuracy of a search, relative to the force.
    const FINEST: f64;

    /// Returns the nearest number.
    fn of(x: f64) -> Self;
}

impl Number for f64 {
    const FINEST: f64 = 0.0;

    fn of(x: f64) -> Self {
        x
    }
}

impl Number for f32 {
    const FINEST: f64 = 1e-5;

    fn of(x: f64) -> Self {
        x as f32
    }
}

/// Quadratic function ½⟨d, A d⟩ − ⟨r, d⟩ on a subspace, with A = K + J times the [unit](Self::unit) of compliances. A
/// is symmetric, not necessarily positive definite. The preconditioner M⁻¹ is positive definite on the subspace.
pub(crate) trait Model {
    /// Number type of the search vectors.
    type Value: Number;

    /// Returns the factor of the stiffness, a power of two in length/stress.
    fn unit(&self) -> f64;

    /// Projects r on the subspace.
    fn project(&mut self, residual: &mut [Self::Value]);

    /// Computes d ← d + `step` p, r ← r − `step` A p on the subspace, and z ← M⁻¹ r; returns ⟨r, z⟩.
    fn advance(&mut self, vectors: &mut Vectors<Self::Value>, step: f64) -> f64;

    /// Computes p ← z + `turn` p and A p with the J of `reaction`; returns ⟨p, A p⟩.
    fn turn(&mut self, vectors: &mut Vectors<Self::Value>, reaction: &Reaction, turn: f64) -> f64;

    /// Returns the weight of each point in the preconditioner; 0 for points held by the wall, which are not in the
    /// subspace.
    fn weight(&mut self) -> &mut [Self::Value];

    /// Restores a held mean by the points with a larger weight than `least`, if any, instead of all free points. Other
    /// points, at springs stiffer than the body, hardly move.
    fn hold_mean_above(&mut self, _least: f64) {}

    /// Computes `traction` ← K w in double precision.
    fn elastic(&mut self, w: &[f64], traction: &mut [f64]);

    /// Returns the number of transform pairs so far.
    fn pairs(&self) -> f64;

    /// Visits the transform counters.
    fn count(&mut self, visitor: &mut dyn Visit);
}

/// Vectors of a search.
pub(crate) struct Vectors<T> {
    /// d, the resulting step.
    pub(crate) direction: Vec<T>,
    /// r before a search, r − A d after it.
    pub(crate) residual: Vec<T>,
    /// z = M⁻¹ r.
    pub(crate) preconditioned: Vec<T>,
    /// p.
    pub(crate) conjugate: Vec<T>,
    /// A p.
    pub(crate) image: Vec<T>,
}

/// Trust region and the buffers of a search within it. Lengths are in the metric M.
pub(crate) struct TrustRegion<T> {
    /// Radius; infinite before the first step.
    pub(crate) radius: f64,
    /// Length of the resulting step.
    pub(crate) length: f64,
    /// Unit of the direction, length.
    pub(crate) unit: f64,
    pub(crate) vectors: Vectors<T>,
}

/// Maximum number of iterations of one search.
const ITERATIONS: usize = 200;
/// First radius divided by the length of the preconditioned gradient.
const FIRST_RADIUS: f64 = 1.0;

impl<T: Number> TrustRegion<T> {
    pub(crate) fn new(size: usize) -> Self {
        let zeros = || vec![T::default(); size];
        let vectors = Vectors {
            direction: zeros(),
            residual: zeros(),
            preconditioned: zeros(),
            conjugate: zeros(),
            image: zeros(),
        };
        Self { radius: f64::INFINITY, length: 0.0, unit: 1.0, vectors }
    }

    /// Computes `direction` ← A⁻¹ `residual` to the relative accuracy `accuracy`, or up to the edge of the region;
    /// `stress` is the unit of the residual. Returns the lowest curvature ⟨p, A p⟩/⟨p, M p⟩ encountered.
    pub(crate) fn step<M: Model<Value = T>>(
        &mut self,
        model: &mut M,
        reaction: &Reaction,
        stress: f64,
        accuracy: f64,
    ) -> f64 {
        self.search(model, reaction, stress, accuracy, Some(self.radius))
    }

    /// Searches as [`step`](Self::step), without a length limit. It ends at the first direction of negative curvature,
    /// which becomes `direction`.
    pub(crate) fn probe<M: Model<Value = T>>(&mut self, model: &mut M, reaction: &Reaction, accuracy: f64) -> f64 {
        self.search(model, reaction, 1.0, accuracy, None)
    }

    /// Projects `residual` on the subspace and returns ⟨r, M⁻¹ r⟩.
    pub(crate) fn slope<M: Model<Value = T>>(&mut self, model: &mut M) -> f64 {
        model.project(&mut self.vectors.residual);
        model.advance(&mut self.vectors, 0.0)
    }

    fn search<M: Model<Value = T>>(
        &mut self,
        model: &mut M,
        reaction: &Reaction,
        stress: f64,
        accuracy: f64,
        radius: Option<f64>,
    ) -> f64 {
        let vectors = &mut self.vectors;
        // Length in the units of the search.
        let metric = stress * model.unit().sqrt();
        self.unit = stress * model.unit();
        model.project(&mut vectors.residual);
        for cleared in [&mut vectors.direction, &mut vectors.conjugate, &mut vectors.image] {
            for_each([&mut cleared[..]], &|_, [cleared]| cleared.fill(T::default()));
        }
        let mut product = model.advance(vectors, 0.0);
        let accuracy = accuracy.max(T::FINEST);
        let aim = accuracy * accuracy * product;
        let radius =
            radius.map(|radius| if radius.is_finite() { radius / metric } else { FIRST_RADIUS * product.sqrt() });
        self.radius = radius.map_or(self.radius, |radius| radius * metric);
        let square = radius.unwrap_or(f64::INFINITY).powi(2);
        // Products ⟨d, M d⟩, ⟨d, M p⟩, ⟨p, M p⟩.
        let (mut dd, mut dp, mut pp) = (0.0, 0.0, product);
        let (mut lowest, mut turn) = (f64::INFINITY, 0.0);
        for _ in 0..ITERATIONS {
            if product <= aim || product.is_nan() {
                break;
            }
            let curvature = model.turn(vectors, reaction, turn);
            lowest = lowest.min(curvature / pp);
            let step = product / curvature;
            let edge = dd + 2.0 * step * dp + step * step * pp >= square;
            if curvature <= 0.0 || edge {
                let Vectors { direction, conjugate, .. } = vectors;
                if radius.is_none() {
                    direction.copy_from_slice(conjugate);
                } else {
                    let to_edge = ((dp * dp + pp * (square - dd)).max(0.0).sqrt() - dp) / pp;
                    add_multiple(direction, to_edge, conjugate);
                    dd = square;
                }
                break;
            }
            dd += 2.0 * step * dp + step * step * pp;
            let next = model.advance(vectors, step);
            turn = next / product;
            product = next;
            dp = turn * (dp + step * pp);
            pp = product + turn * turn * pp;
        }
        self.length = dd.sqrt() * metric;
        lowest
    }

    /// Returns the largest magnitude in the direction, length.
    pub(crate) fn longest(&self, share: &Share) -> f64 {
        let direction = &self.vectors.direction;
        let longest = |range: std::ops::Range<usize>| {
            direction[range].iter().fold(0.0, |longest: f64, d| longest.max((*d).into().abs()))
        };
        self.unit * reduce(share, direction.len(), &longest, &f64::max)
    }
}

/// Computes `y` ← `y` + `factor` `x`.
fn add_multiple<T: Number>(y: &mut [T], factor: f64, x: &[T]) {
    for_each([y], &|start, [y]| {
        y.iter_mut().zip(&x[start..]).for_each(|(y, x)| *y = T::of((*y).into() + factor * (*x).into()));
    });
}
