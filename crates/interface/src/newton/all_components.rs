//! Model of all components, or of both faces of a plate, in double precision.

use gfmd_relax::Visit;
use gfmd_response::Transforms;
use gfmd_vector::for_each;

use super::reaction::Reaction;
use super::trust_region::{Model, Vectors};
use crate::frame::Frame;
use crate::numbers::{dot, mean_where, total};

/// Matrix K + J on the points not held by the wall.
pub(super) struct AllComponents<'a> {
    transforms: Transforms,
    frame: &'a Frame<'a>,
    /// Weight of each point in the preconditioner; 0 for points held by the wall.
    weight: Vec<f64>,
    /// Share of each point in a shift that restores a held mean, in u_z alone; empty if all free points have the same.
    share: Vec<f64>,
    /// Compliance of the uniform mode in the preconditioner.
    uniform_compliance: Vec<f64>,
}

impl<'a> AllComponents<'a> {
    pub(super) fn new(transforms: Transforms, frame: &'a Frame<'a>, uniform_compliance: Vec<f64>) -> Self {
        let weight = vec![0.0; frame.components() * frame.points()];
        Self { transforms, frame, weight, share: Vec::new(), uniform_compliance }
    }

    /// Sets the share of each point in a shift that restores a held mean, in u_z alone; 0 for points held by the wall.
    pub(super) fn restore_mean_by(&mut self, share: Vec<f64>) {
        self.share = share;
    }

    /// Returns the share of each point in a shift that restores a held mean, if the points differ.
    pub(super) fn share(&self) -> Option<&[f64]> {
        (!self.share.is_empty()).then_some(&self.share)
    }

    /// Returns the mean of a component over the points that restore a held mean.
    pub(super) fn mean_of(&self, c: usize, field: &[f64]) -> f64 {
        let weight = &self.weight[c * field.len()..][..field.len()];
        match self.share.is_empty() {
            true => mean_where(self.frame.share, field, |i| weight[i] > 0.0),
            false => dot(self.frame.share, &self.share, field) / total(self.frame.share, &self.share),
        }
    }

    fn precondition(&mut self, residual: &[f64], scratch: &mut [f64], out: &mut [f64]) {
        let Self { transforms, weight, uniform_compliance, .. } = self;
        let weigh = |start: usize, [weighted]: [&mut [f64]; 1]| {
            let factors = residual[start..].iter().zip(&weight[start..]);
            weighted.iter_mut().zip(factors).for_each(|(weighted, (r, w))| *weighted = r * w);
        };
        for_each([&mut *scratch], &weigh);
        transforms.compliance(scratch, uniform_compliance, out);
        for_each([&mut *out], &|start, [out]| {
            out.iter_mut().zip(&weight[start..]).for_each(|(out, w)| *out *= w);
        });
        if self.share.is_empty() || !self.frame.held[0] {
            return self.project(out);
        }
        // The transpose of the projection, which keeps the preconditioner symmetric.
        let shift = total(self.frame.share, out) / total(self.frame.share, &self.share);
        for_each([out], &|start, [out]| {
            out.iter_mut().zip(&self.share[start..]).for_each(|(out, share)| *out -= shift * share);
        });
    }
}

impl Model for AllComponents<'_> {
    type Value = f64;

    fn unit(&self) -> f64 {
        1.0
    }

    /// Sets the values at the points held by the wall to 0, and also the mean over the free points in components with a
    /// held mean.
    fn project(&mut self, vector: &mut [f64]) {
        let points = self.frame.points();
        for (c, (field, held)) in vector.chunks_exact_mut(points).zip(&self.frame.held).enumerate() {
            let weight = &self.weight[c * points..][..points];
            let mean = if *held { self.mean_of(c, field) } else { 0.0 };
            let keep = |start: usize, [field]: [&mut [f64]; 1]| {
                for (v, weight) in field.iter_mut().zip(&weight[start..]) {
                    *v = if *weight > 0.0 { *v - mean } else { 0.0 };
                }
            };
            for_each([field], &keep);
        }
    }

    fn advance(&mut self, vectors: &mut Vectors<f64>, step: f64) -> f64 {
        let Vectors { direction, residual, preconditioned, conjugate, image } = vectors;
        let add = |start: usize, [d, r]: [&mut [f64]; 2]| {
            let along = conjugate[start..].iter().zip(&image[start..]);
            for ((d, r), (p, q)) in d.iter_mut().zip(r).zip(along) {
                *d += step * p;
                *r -= step * q;
            }
        };
        for_each([&mut direction[..], &mut residual[..]], &add);
        self.project(residual);
        self.precondition(residual, image, preconditioned);
        dot(self.frame.share, residual, preconditioned)
    }

    fn turn(&mut self, vectors: &mut Vectors<f64>, reaction: &Reaction, turn: f64) -> f64 {
        let Vectors { preconditioned, conjugate, image, .. } = vectors;
        let add_turned = |start: usize, [p]: [&mut [f64]; 1]| {
            p.iter_mut().zip(&preconditioned[start..]).for_each(|(p, z)| *p = z + turn * *p);
        };
        for_each([&mut conjugate[..]], &add_turned);
        self.transforms.stiffness(conjugate, &self.frame.uniform_stiffness, image);
        reaction.add_product(conjugate, image);
        dot(self.frame.share, conjugate, image)
    }

    fn weight(&mut self) -> &mut [f64] {
        &mut self.weight
    }

    fn elastic(&mut self, w: &[f64], traction: &mut [f64]) {
        self.transforms.stiffness(w, &self.frame.uniform_stiffness, traction);
    }

    fn pairs(&self) -> f64 {
        self.transforms.pairs()
    }

    fn count(&mut self, visitor: &mut dyn Visit) {
        visitor.count(self.transforms.counter());
    }
}
