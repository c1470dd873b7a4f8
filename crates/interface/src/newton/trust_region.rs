//! Conjugate gradients that stop at the edge of a trust region, or at a negative curvature (Steihaug 1983).

use gfmd_vector::{dot, for_each};

/// A quadratic function ½⟨d, A d⟩ − ⟨r, d⟩ on a subspace. A is symmetric, not necessarily positive definite.
pub(crate) trait Model {
    /// `out` ← A `vector`.
    fn apply(&mut self, vector: &[f64], out: &mut [f64]);

    /// `out` ← M⁻¹ `residual` with the preconditioner M⁻¹, positive definite on the subspace. `scratch` is overwritten.
    fn precondition(&mut self, residual: &[f64], scratch: &mut [f64], out: &mut [f64]);

    /// `vector` ← its projection on the subspace.
    fn project(&self, vector: &mut [f64]);
}

/// The region in which the model is trusted, and the memory of a search within it. Lengths are in the metric M.
pub(crate) struct TrustRegion {
    /// The radius; infinite before the first step.
    pub(crate) radius: f64,
    /// The step that was found.
    pub(crate) direction: Vec<f64>,
    /// The length of `direction`.
    pub(crate) length: f64,
    /// r before a search, r − A d after it.
    pub(crate) residual: Vec<f64>,
    preconditioned: Vec<f64>,
    conjugate: Vec<f64>,
    image: Vec<f64>,
}

/// The largest number of iterations of one search.
const ITERATIONS: usize = 200;
/// The first radius over the length of the preconditioned gradient.
const FIRST_RADIUS: f64 = 1.0;

impl TrustRegion {
    pub(crate) fn new(size: usize) -> Self {
        let zeros = || vec![0.0; size];
        Self {
            radius: f64::INFINITY,
            direction: zeros(),
            length: 0.0,
            residual: zeros(),
            preconditioned: zeros(),
            conjugate: zeros(),
            image: zeros(),
        }
    }

    /// `direction` ← A⁻¹ `residual` to the relative accuracy `accuracy`, or up to the edge of the region. Returns the lowest
    /// curvature ⟨p, A p⟩/⟨p, M p⟩ that was met.
    pub(crate) fn step(&mut self, model: &mut impl Model, accuracy: f64) -> f64 {
        self.search(model, accuracy, Some(self.radius))
    }

    /// As [`step`](Self::step), without a limit of length. It ends at the first direction of negative curvature, which
    /// becomes `direction`.
    pub(crate) fn probe(&mut self, model: &mut impl Model, accuracy: f64) -> f64 {
        self.search(model, accuracy, None)
    }

    fn search(&mut self, model: &mut impl Model, accuracy: f64, radius: Option<f64>) -> f64 {
        let Self { direction, residual, preconditioned, conjugate, image, .. } = self;
        model.project(residual);
        direction.fill(0.0);
        model.precondition(residual, image, preconditioned);
        conjugate.copy_from_slice(preconditioned);
        let mut product = dot(residual, preconditioned);
        let aim = accuracy * accuracy * product;
        let radius = radius.map(|radius| if radius.is_finite() { radius } else { FIRST_RADIUS * product.sqrt() });
        self.radius = radius.unwrap_or(self.radius);
        let square = radius.unwrap_or(f64::INFINITY).powi(2);
        // The products ⟨d, M d⟩, ⟨d, M p⟩, ⟨p, M p⟩.
        let (mut dd, mut dp, mut pp) = (0.0, 0.0, product);
        let mut lowest = f64::INFINITY;
        for _ in 0..ITERATIONS {
            if product <= aim || product.is_nan() {
                break;
            }
            model.apply(conjugate, image);
            let curvature = dot(conjugate, image);
            lowest = lowest.min(curvature / pp);
            let step = product / curvature;
            let edge = dd + 2.0 * step * dp + step * step * pp >= square;
            if curvature <= 0.0 || edge {
                if radius.is_none() {
                    direction.copy_from_slice(conjugate);
                } else {
                    let to_edge = ((dp * dp + pp * (square - dd)).max(0.0).sqrt() - dp) / pp;
                    add_multiple(direction, to_edge, conjugate);
                    dd = square;
                }
                break;
            }
            add_multiple(direction, step, conjugate);
            add_multiple(residual, -step, image);
            model.project(residual);
            dd += 2.0 * step * dp + step * step * pp;
            model.precondition(residual, image, preconditioned);
            let next = dot(residual, preconditioned);
            let turn = next / product;
            product = next;
            let add_turned = |start: usize, [p]: [&mut [f64]; 1]| {
                p.iter_mut().zip(&preconditioned[start..]).for_each(|(p, z)| *p = z + turn * *p);
            };
            for_each([&mut conjugate[..]], &add_turned);
            dp = turn * (dp + step * pp);
            pp = product + turn * turn * pp;
        }
        self.length = dd.sqrt();
        lowest
    }
}

/// `y` ← `y` + `factor` `x`.
fn add_multiple(y: &mut [f64], factor: f64, x: &[f64]) {
    for_each([y], &|start, [y]| y.iter_mut().zip(&x[start..]).for_each(|(y, x)| *y += factor * x));
}
