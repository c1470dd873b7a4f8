//! Conjugate gradients that stop at the edge of a trust region, or at a negative curvature (Steihaug 1983).

use gfmd_relax::Visit;
use gfmd_vector::{for_each, reduce};

use super::reaction::Reaction;

/// A number of the steps of a search, in double or single precision.
pub(crate) trait Number: Copy + Default + Send + Sync + Into<f64> {
    /// The smallest accuracy to which a search can solve, relative to the force.
    const FINEST: f64;

    /// The nearest number.
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

/// A quadratic function ½⟨d, A d⟩ − ⟨r, d⟩ on a subspace, with A = K + J times the [unit](Self::unit) of compliances. A
/// is symmetric, not necessarily positive definite. The preconditioner M⁻¹ is positive definite on the subspace.
pub(crate) trait Model {
    /// The numbers of the vectors of a search.
    type Value: Number;

    /// A power of two, in length/stress, by which the stiffness is multiplied.
    fn unit(&self) -> f64;

    /// r ← its projection on the subspace.
    fn project(&mut self, residual: &mut [Self::Value]);

    /// d ← d + `step` p, r ← r − `step` A p on the subspace, z ← M⁻¹ r; returns ⟨r, z⟩.
    fn advance(&mut self, vectors: &mut Vectors<Self::Value>, step: f64) -> f64;

    /// p ← z + `turn` p and A p with the J of `reaction`; returns ⟨p, A p⟩.
    fn turn(&mut self, vectors: &mut Vectors<Self::Value>, reaction: &Reaction, turn: f64) -> f64;

    /// The weight of each point in the preconditioner; 0 for the points that the wall holds, which are not part of the
    /// subspace.
    fn weight(&mut self) -> &mut [Self::Value];

    /// `traction` ← K w in double precision.
    fn elastic(&mut self, w: &[f64], traction: &mut [f64]);

    /// Transforms so far, in pairs.
    fn pairs(&self) -> f64;

    /// Visits the counters of transforms.
    fn count(&mut self, visitor: &mut dyn Visit);
}

/// The vectors of a search.
pub(crate) struct Vectors<T> {
    /// The step that was found, d.
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

/// The region in which the model is trusted, and the memory of a search within it. Lengths are in the metric M.
pub(crate) struct TrustRegion<T> {
    /// The radius; infinite before the first step.
    pub(crate) radius: f64,
    /// The length of the step that was found.
    pub(crate) length: f64,
    /// The unit of the direction, length.
    pub(crate) unit: f64,
    pub(crate) vectors: Vectors<T>,
}

/// The largest number of iterations of one search.
const ITERATIONS: usize = 200;
/// The first radius over the length of the preconditioned gradient.
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

    /// `direction` ← A⁻¹ `residual` to the relative accuracy `accuracy`, or up to the edge of the region, for a
    /// residual in this unit of stress. Returns the lowest curvature ⟨p, A p⟩/⟨p, M p⟩ that was met.
    pub(crate) fn step<M: Model<Value = T>>(
        &mut self,
        model: &mut M,
        reaction: &Reaction,
        stress: f64,
        accuracy: f64,
    ) -> f64 {
        self.search(model, reaction, stress, accuracy, Some(self.radius))
    }

    /// As [`step`](Self::step), without a limit of length. It ends at the first direction of negative curvature, which
    /// becomes `direction`.
    pub(crate) fn probe<M: Model<Value = T>>(&mut self, model: &mut M, reaction: &Reaction, accuracy: f64) -> f64 {
        self.search(model, reaction, 1.0, accuracy, None)
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
        // A length in the units of the search.
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
        // The products ⟨d, M d⟩, ⟨d, M p⟩, ⟨p, M p⟩.
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

    /// The largest entry of the direction, in magnitude, length.
    pub(crate) fn longest(&self) -> f64 {
        let direction = &self.vectors.direction;
        let longest = |range: std::ops::Range<usize>| {
            direction[range].iter().fold(0.0, |longest: f64, d| longest.max((*d).into().abs()))
        };
        self.unit * reduce(direction.len(), &longest, &f64::max)
    }
}

/// `y` ← `y` + `factor` `x`.
fn add_multiple<T: Number>(y: &mut [T], factor: f64, x: &[T]) {
    for_each([y], &|start, [y]| {
        y.iter_mut().zip(&x[start..]).for_each(|(y, x)| *y = T::of((*y).into() + factor * (*x).into()));
    });
}
