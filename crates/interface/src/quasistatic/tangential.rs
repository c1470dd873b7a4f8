use gfmd_relax::OnConvexSet;
use gfmd_vector::{for_each, reduce};

use super::response::Transforms;
use crate::numbers::higher;

/// Tangential problem: ½⟨τ, G τ⟩ + ⟨τ, s₀⟩ → min over |τ| ≤ limit; s₀ is the slip without shear.
pub(super) struct TangentialProblem<'a> {
    pub(super) transforms: &'a mut Transforms,
    pub(super) limits: &'a Limits,
    /// Buffers for a traction and a displacement with all components; the normal component of the traction is 0.
    pub(super) traction: Vec<f64>,
    pub(super) displacement: &'a mut [f64],
}

impl OnConvexSet for TangentialProblem<'_> {
    fn apply(&mut self, direction: &[f64], out: &mut [f64]) {
        let Self { transforms, limits: Limits { values, .. }, traction, displacement } = self;
        traction[..direction.len()].copy_from_slice(direction);
        transforms.compliance(traction, displacement);
        let points = values.len();
        for (out, image) in out.chunks_exact_mut(points).zip(displacement.chunks_exact(points)) {
            let mask = |start: usize, [out]: [&mut [f64]; 1]| {
                for ((out, image), limit) in out.iter_mut().zip(&image[start..]).zip(&values[start..]) {
                    *out = if *limit > 0.0 { *image } else { 0.0 };
                }
            };
            for_each([out], &mask);
        }
    }

    fn project(&self, x: &mut [f64]) {
        self.limits.project(x);
    }

    fn residual(&self, x: &[f64], gradient: &[f64]) -> f64 {
        self.limits.mismatch(x, gradient)
    }
}

/// Largest shear traction allowed by friction at each point.
pub(super) struct Limits {
    pub(super) values: Vec<f64>,
    /// Largest limit.
    pub(super) strongest: f64,
    /// Unit of slip, length.
    pub(super) length: f64,
}

impl Limits {
    pub(super) fn new(values: Vec<f64>, length: f64) -> Self {
        Self { strongest: values.iter().copied().fold(0.0, f64::max), values, length }
    }

    /// Reduces the shear to its limit, point by point.
    pub(super) fn project(&self, shear: &mut [f64]) {
        let limits = &self.values;
        let factor = |square: f64, limit: f64| {
            let magnitude = square.sqrt();
            if magnitude > limit { limit / magnitude } else { 1.0 }
        };
        let (x, y) = shear.split_at_mut(limits.len());
        if y.is_empty() {
            let leaf = |start: usize, [x]: [&mut [f64]; 1]| {
                x.iter_mut().zip(&limits[start..]).for_each(|(x, limit)| *x *= factor(*x * *x, *limit));
            };
            for_each([x], &leaf);
        } else {
            let leaf = |start: usize, [x, y]: [&mut [f64]; 2]| {
                for ((x, y), limit) in x.iter_mut().zip(y).zip(&limits[start..]) {
                    let factor = factor(*x * *x + *y * *y, *limit);
                    *x *= factor;
                    *y *= factor;
                }
            };
            for_each([x, y], &leaf);
        }
    }

    /// Returns the largest |τ − P(τ − c s)| divided by the largest limit; c is the largest limit divided by the unit of
    /// slip. 0 if all limits are 0. (The sum of limit |s| + τ·s is of second order in errors of direction.)
    pub(super) fn mismatch(&self, shear: &[f64], slip: &[f64]) -> f64 {
        let Self { values: limits, strongest, length } = self;
        if *strongest == 0.0 {
            return 0.0;
        }
        let n = limits.len();
        let components = slip.len() / n;
        let stiffness = strongest / length;
        let of_point = |i: usize| {
            let mut moved = [0.0; 2];
            for c in 0..components {
                moved[c] = shear[c * n + i] - stiffness * slip[c * n + i];
            }
            let magnitude = moved[0].hypot(moved[1]);
            let factor = if magnitude > limits[i] { limits[i] / magnitude } else { 1.0 };
            let off: f64 = (0..components).map(|c| (shear[c * n + i] - factor * moved[c]).powi(2)).sum();
            off.sqrt()
        };
        reduce(n, &|range| range.fold(0.0, |worst, i| higher(worst, of_point(i))), &higher) / strongest
    }
}
