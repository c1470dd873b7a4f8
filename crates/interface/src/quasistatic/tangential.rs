use std::ops::Range;

use gfmd_relax::OnConvexSet;
use gfmd_vector::{Share, add, for_each};

use super::response::Transforms;
use crate::numbers::higher;

/// Relative distance to the limit that is a rounding error.
const EDGE: f64 = 1e-12;

/// Tangential problem: ½⟨τ, G τ⟩ + ⟨τ, s₀⟩ → min over |τ| ≤ limit; s₀ is the slip without shear.
pub(super) struct TangentialProblem<'a> {
    pub(super) transforms: &'a mut Transforms,
    pub(super) limits: &'a Limits<'a>,
}

impl OnConvexSet for TangentialProblem<'_> {
    fn apply(&mut self, direction: &[f64], out: &mut [f64]) {
        let Self { transforms, limits: Limits { values, .. } } = self;
        transforms.lateral_compliance(direction, out);
        for out in out.chunks_exact_mut(values.len()) {
            let mask = |start: usize, [out]: [&mut [f64]; 1]| {
                for (out, limit) in out.iter_mut().zip(&values[start..]) {
                    *out = if *limit > 0.0 { *out } else { 0.0 };
                }
            };
            for_each([out], &mask);
        }
    }

    fn project(&self, x: &mut [f64]) {
        self.limits.project(x);
    }

    /// At a point that slips, the direction is tangential up to its curvature, and computed from the component of the
    /// slip across the shear: the sum of all slopes is negative to the last digit.
    fn direction(&self, x: &[f64], gradient: &[f64], length: f64, out: &mut [f64]) {
        let limits = &self.limits.values;
        let [points, components] = [limits.len(), x.len() / limits.len()];
        if components == 1 {
            for_each([out], &|start, [out]| {
                for (k, out) in out.iter_mut().enumerate() {
                    let (x, limit) = (x[start + k], limits[start + k]);
                    *out = (x - length * gradient[start + k]).clamp(-limit, limit) - x;
                }
            });
            return;
        }
        let (out_x, out_y) = out.split_at_mut(points);
        for_each([out_x, out_y], &|start, [out_x, out_y]| {
            for (k, (out_x, out_y)) in out_x.iter_mut().zip(out_y).enumerate() {
                let i = start + k;
                let (at, g, limit) = ([x[i], x[points + i]], [gradient[i], gradient[points + i]], limits[i]);
                let moved = [at[0] - length * g[0], at[1] - length * g[1]];
                let (size, reach) = (at[0].hypot(at[1]), moved[0].hypot(moved[1]));
                [*out_x, *out_y] = if reach <= limit {
                    [moved[0] - at[0], moved[1] - at[1]]
                } else if size < limit * (1.0 - EDGE) || moved[0] * at[0] + moved[1] * at[1] <= 0.0 {
                    [moved[0] * (limit / reach) - at[0], moved[1] * (limit / reach) - at[1]]
                } else {
                    let along = [at[0] / size, at[1] / size];
                    let sine = -length * (along[0] * g[1] - along[1] * g[0]) / reach;
                    let cosine_less_one = -sine * sine / (1.0 + (1.0 - sine * sine).max(0.0).sqrt());
                    [0, 1].map(|c| limit * (cosine_less_one * along[c] + sine * [-along[1], along[0]][c]))
                };
            }
        });
    }

    fn sums(&self, length: usize, of: &(dyn Fn(Range<usize>) -> [f64; 4] + Sync)) -> [f64; 4] {
        let Limits { values, share, .. } = self.limits;
        share.reduce_components(length / values.len(), &|range| of(range), &add)
    }

    fn residual(&self, x: &[f64], gradient: &[f64]) -> f64 {
        self.limits.mismatch(x, gradient)
    }
}

/// Largest shear traction allowed by friction at each point.
pub(super) struct Limits<'a> {
    /// Limits at the points of this process.
    pub(super) values: Vec<f64>,
    share: &'a Share,
    /// Largest limit, over all processes.
    pub(super) strongest: f64,
    /// Unit of slip, length.
    pub(super) length: f64,
}

impl<'a> Limits<'a> {
    pub(super) fn new(values: Vec<f64>, share: &'a Share, length: f64) -> Self {
        let strongest = share.each(values.iter().copied().fold(0.0, f64::max));
        Self { strongest: strongest.into_iter().fold(0.0, f64::max), values, share, length }
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
        let Self { values: limits, share, strongest, length } = self;
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
        share.reduce(&|range| range.fold(0.0, |worst, i| higher(worst, of_point(i))), &higher) / strongest
    }
}
