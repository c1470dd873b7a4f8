//! Model of u_z alone. Steps are in single precision; sums and products are computed in the row loops of the
//! transforms.

use std::borrow::Cow;
use std::sync::Arc;

use gfmd_field::Rows;
use gfmd_relax::Visit;
use gfmd_response::{NormalResponse, RoundedTransforms, Transforms};
use gfmd_vector::{add, add_times, for_each};
use multiversion::multiversion;

use super::reaction::Reaction;
use super::trust_region::{Model, Vectors};
use crate::frame::Frame;
use crate::numbers::reduce;

/// Matrix K + J on the points not held by the wall.
pub(super) struct OneComponent<'a> {
    /// Transforms in double precision, for the energy and the force.
    transforms: Transforms,
    rounded: RoundedTransforms,
    frame: &'a Frame<'a>,
    /// Number of points in a row.
    row: usize,
    /// Weight of each point in the preconditioner; 0 for points held by the wall.
    weight: Vec<f32>,
    /// Weight above which points restore a held mean: 0, for all points not held by the wall, but for stiff springs.
    soft: f32,
    /// Number of points that restore the mean; counted only if it is held.
    free: f64,
    /// Values to be subtracted, 0 if the mean is not held: from z at the points that restore the mean, so that its sum
    /// vanishes; and from A p at all free points, so that its mean over the points that restore the mean vanishes.
    of_preconditioned: f32,
    of_image: f32,
    /// Two sums per row of this process.
    sums: Vec<[f64; 2]>,
}

impl<'a> OneComponent<'a> {
    pub(super) fn new(
        response: &Arc<NormalResponse>,
        transforms: Transforms,
        frame: &'a Frame<'a>,
        uniform_compliance: f64,
    ) -> Self {
        let row = response.grid().rows()[1];
        Self {
            transforms,
            rounded: RoundedTransforms::of(response, Some([uniform_compliance, frame.uniform_stiffness[0]])),
            frame,
            row,
            weight: vec![0.0; frame.points()],
            soft: 0.0,
            free: 0.0,
            of_preconditioned: 0.0,
            of_image: 0.0,
            sums: vec![[0.0; 2]; frame.points() / row],
        }
    }

    /// Returns a sum divided by the number of points that restore the mean; 0 if the mean is not held.
    fn mean(&self, sum: f64) -> f32 {
        if self.frame.held[0] && self.free > 0.0 { (sum / self.free) as f32 } else { 0.0 }
    }

    /// Returns the sums over the rows of all processes.
    fn total(&self) -> [f64; 2] {
        let share = self.frame.share;
        let all = if share.is_whole() {
            Cow::from(&self.sums)
        } else {
            let lengths: Vec<usize> = share.all_rows().iter().map(|rows| rows.len()).collect();
            share.collect(&self.sums, &lengths).into()
        };
        gfmd_vector::reduce(all.len(), &|range| all[range].iter().copied().fold([0.0; 2], add), &add)
    }
}

impl Model for OneComponent<'_> {
    type Value = f32;

    fn unit(&self) -> f64 {
        self.rounded.unit()
    }

    fn project(&mut self, vector: &mut [f32]) {
        (self.of_preconditioned, self.of_image) = (0.0, 0.0);
        let mut mean = 0.0;
        if self.frame.held[0] {
            let (weight, soft) = (&self.weight, self.soft);
            let of = |range: std::ops::Range<usize>| {
                let free = weight[range.clone()].iter().filter(|w| **w > soft).count() as f64;
                [sum_above(soft, &vector[range.clone()], &weight[range]), free]
            };
            let [sum, free] = reduce(self.frame.share, vector.len(), &of, &add);
            self.free = free;
            mean = self.mean(sum);
        }
        let weight = &self.weight;
        let keep = |start: usize, [field]: [&mut [f32]; 1]| {
            for (v, weight) in field.iter_mut().zip(&weight[start..]) {
                *v = if *weight > 0.0 { *v - mean } else { 0.0 };
            }
        };
        for_each([vector], &keep);
    }

    fn advance(&mut self, vectors: &mut Vectors<f32>, step: f64) -> f64 {
        let Vectors { direction, residual, preconditioned, conjugate, image } = vectors;
        let Self { rounded, weight, row, sums, of_image, frame, .. } = self;
        let (step, mean, is_held, row) = (step as f32, *of_image, frame.held[0], *row);
        let (p, q, w) = (&conjugate[..], &image[..], &weight[..]);
        let input = Rows((&mut direction[..], &mut residual[..], p, q, w), row);
        let source = |_: usize, Rows((d, r, p, q, w), _): Rows<Moved>, out: &mut [f32]| {
            add_times(d, step, p);
            lessen(step, (q, mean), w, r);
            multiply(r, w, out);
        };
        rounded.compliance(input, source);
        let output = (Rows((&mut preconditioned[..], &residual[..], w), row), &mut sums[..]);
        let sink = |_: usize, made: &mut [f32], (Rows((z, r, w), _), sum): (Rows<Weighed>, &mut [[f64; 2]])| {
            multiply(made, w, z);
            sum[0] = [product(r, z), if is_held { sum_above(0.0, z, w) } else { 0.0 }];
        };
        rounded.rows(output, sink);
        let [square, sum] = self.total();
        self.of_preconditioned = self.mean(sum);
        square
    }

    fn turn(&mut self, vectors: &mut Vectors<f32>, reaction: &Reaction, turn: f64) -> f64 {
        let Vectors { preconditioned, conjugate, image, .. } = vectors;
        let unit = self.unit();
        let Self { rounded, weight, soft, row, sums, of_preconditioned, frame, .. } = self;
        let (turn, mean, soft, is_held, row) = (turn as f32, *of_preconditioned, *soft, frame.held[0], *row);
        let (z, w) = (&preconditioned[..], &weight[..]);
        let source = |_: usize, Rows((p, z, w), _): Rows<Weighed>, out: &mut [f32]| {
            conjugate_to(turn, (z, mean), (w, soft), p);
            out.copy_from_slice(p);
        };
        rounded.stiffness_ahead(Rows((&mut conjugate[..], z, w), row), source);
        let output = (Rows((&mut image[..], &conjugate[..], w, reaction.diagonal(0)), row), &mut sums[..]);
        let sink = |_: usize, made: &mut [f32], (Rows((q, p, w, j), _), sum): (Rows<Curved>, &mut [[f64; 2]])| {
            add_diagonal(made, (j, unit), p, q);
            sum[0] = [product(p, q), if is_held { sum_above(soft, q, w) } else { 0.0 }];
        };
        rounded.rows(output, sink);
        let [square, sum] = self.total();
        self.of_image = self.mean(sum);
        square
    }

    fn weight(&mut self) -> &mut [f32] {
        &mut self.weight
    }

    fn hold_mean_above(&mut self, least: f64) {
        let is_above =
            self.frame.held[0] && self.frame.share.any(self.weight.iter().any(|weight| f64::from(*weight) > least));
        self.soft = if is_above { least as f32 } else { 0.0 };
    }

    fn elastic(&mut self, w: &[f64], traction: &mut [f64]) {
        self.transforms.stiffness(w, &self.frame.uniform_stiffness, traction);
    }

    fn pairs(&self) -> f64 {
        self.transforms.pairs() + self.rounded.pairs()
    }

    fn count(&mut self, visitor: &mut dyn Visit) {
        visitor.count(self.transforms.counter());
        visitor.count(self.rounded.counter());
    }
}

type Moved<'a> = (&'a mut [f32], &'a mut [f32], &'a [f32], &'a [f32], &'a [f32]);
type Weighed<'a> = (&'a mut [f32], &'a [f32], &'a [f32]);
type Curved<'a> = (&'a mut [f32], &'a [f32], &'a [f32], &'a [f64]);

/// Computes r ← r − `step` (q − mean) on the free points, where w > 0; zero elsewhere.
#[multiversion(targets = "simd")]
fn lessen(step: f32, image: (&[f32], f32), w: &[f32], r: &mut [f32]) {
    let (q, mean) = image;
    for (r, (q, w)) in r.iter_mut().zip(q.iter().zip(w)) {
        *r = if *w > 0.0 { *r - step * (q - mean) } else { 0.0 };
    }
}

/// Computes out ← a b.
#[multiversion(targets = "simd")]
fn multiply(a: &[f32], b: &[f32], out: &mut [f32]) {
    out.iter_mut().zip(a.iter().zip(b)).for_each(|(out, (a, b))| *out = a * b);
}

/// Computes p ← z + `turn` p, with the mean subtracted from z at the points with a weight above `soft`.
#[multiversion(targets = "simd")]
fn conjugate_to(turn: f32, preconditioned: (&[f32], f32), weight: (&[f32], f32), p: &mut [f32]) {
    let ((z, mean), (w, soft)) = (preconditioned, weight);
    for (p, (z, w)) in p.iter_mut().zip(z.iter().zip(w)) {
        *p = z - if *w > soft { mean } else { 0.0 } + turn * *p;
    }
}

/// Computes q ← `made` + J p, with J in the given unit.
#[multiversion(targets = "simd")]
fn add_diagonal(made: &[f32], diagonal: (&[f64], f64), p: &[f32], q: &mut [f32]) {
    let (j, unit) = diagonal;
    for ((q, made), (p, j)) in q.iter_mut().zip(made).zip(p.iter().zip(j)) {
        *q = made + (j * unit) as f32 * p;
    }
}

/// Number of parallel sums.
const LANES: usize = 8;

/// Computes Σ a b in double precision.
fn product(a: &[f32], b: &[f32]) -> f64 {
    sum_of(a, b, |a, b| f64::from(a) * f64::from(b))
}

/// Sums the values with a weight above `least`, in double precision.
fn sum_above(least: f32, values: &[f32], weight: &[f32]) -> f64 {
    sum_of(values, weight, |value, weight| if weight > least { value.into() } else { 0.0 })
}

#[multiversion(targets = "simd")]
fn sum_of<F: Fn(f32, f32) -> f64>(a: &[f32], b: &[f32], term: F) -> f64 {
    let mut lanes = [0.0; LANES];
    let (blocks, others) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = blocks.remainder().iter().zip(others.remainder()).map(|(a, b)| term(*a, *b)).sum();
    for (a, b) in blocks.zip(others) {
        for (lane, (a, b)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += term(*a, *b);
        }
    }
    lanes.iter().sum::<f64>() + rest
}
