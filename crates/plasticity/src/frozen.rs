//! Change of the pressure with the displacement of the surface, at fixed points in contact.

use std::sync::Arc;

use gfmd_field::{Rows, Share};
use gfmd_response::{NormalResponse, RoundedTransforms};
use gfmd_vector::for_each;

/// Contact with fixed points in contact: G dp = du + dδ on these points, with dp = 0 elsewhere, for a change du of the
/// displacement without pressure. Under a load dp has no mean, otherwise the approach does not change, dδ = 0.
pub(crate) struct FrozenContact {
    /// Rows of this process.
    share: Share,
    transforms: RoundedTransforms,
    columns: usize,
    floating: bool,
    /// One at the points in contact, zero elsewhere.
    touching: Vec<f32>,
    count: f64,
    residual: Vec<f32>,
    direction: Vec<f32>,
    image: Vec<f32>,
}

/// Largest error of the change of the pressure relative to its start, in the norm of the preconditioner.
const TOLERANCE: f64 = 1e-2;

/// Largest number of iterations; 3 to 8 are usual.
const ITERATIONS: usize = 30;

/// Stiffness of the uniform mode in the preconditioner, relative to the softest wave, if the mean level is fixed.
const LEVEL: f64 = 4.0;

impl FrozenContact {
    pub(crate) fn new(response: &Arc<NormalResponse>, floating: bool) -> Self {
        let compliance = response.uniform_compliance();
        let stiffness = if compliance > 0.0 { 1.0 / compliance } else { LEVEL * response.stiffness_range()[0] };
        let (share, n) = (response.share().clone(), response.share().own().len());
        Self {
            share,
            transforms: RoundedTransforms::of(response, (!floating).then_some([compliance, stiffness])),
            columns: response.grid().rows()[1],
            floating,
            touching: vec![0.0; n],
            count: 0.0,
            residual: vec![0.0; n],
            direction: vec![0.0; n],
            image: vec![0.0; n],
        }
    }

    /// Returns the number of transforms so far, in pairs.
    pub(crate) fn pairs(&self) -> f64 {
        self.transforms.pairs()
    }

    /// Returns the counter of single transforms, for a step that continues an earlier one.
    pub(crate) fn counter(&mut self) -> &mut u64 {
        self.transforms.counter()
    }

    /// Sets the points in contact: points with a pressure.
    pub(crate) fn freeze(&mut self, pressure: &[f64]) {
        for_each((&mut self.touching[..], pressure), &|_, (touching, pressure)| {
            touching.iter_mut().zip(pressure).for_each(|(t, p)| *t = if *p > 0.0 { 1.0 } else { 0.0 });
        });
        self.count = self.share.total_of(&self.touching);
    }

    /// Keeps the points in contact, and subtracts their mean if the load is prescribed.
    fn project(share: &Share, floating: bool, (touching, count): (&[f32], f64), field: &mut [f32]) {
        let mean = if floating {
            let total = share
                .sum(&|range| field[range.clone()].iter().zip(&touching[range]).map(|(f, t)| f64::from(f * t)).sum());
            (total / count) as f32
        } else {
            0.0
        };
        for_each((field, touching), &|_, (field, touching)| {
            field.iter_mut().zip(touching).for_each(|(f, t)| *f = t * (*f - mean));
        });
    }

    /// Computes `image` = K `residual`, projected.
    fn precondition(&mut self) {
        let Self { share, transforms, columns, floating, touching, count, residual, image, .. } = self;
        let input = Rows(&residual[..], *columns);
        transforms.stiffness_ahead(input, |_, Rows(r, _), row| row.copy_from_slice(r));
        transforms.rows(Rows(&mut image[..], *columns), |_, row, Rows(out, _): Rows<&mut [f32]>| {
            out.copy_from_slice(row);
        });
        Self::project(share, *floating, (touching, *count), image);
    }

    /// Computes `image` = G `direction`, projected.
    fn displace(&mut self) {
        let Self { share, transforms, columns, floating, touching, count, direction, image, .. } = self;
        let input = Rows(&direction[..], *columns);
        transforms.compliance(input, |_, Rows(d, _), row| row.copy_from_slice(d));
        transforms.rows(Rows(&mut image[..], *columns), |_, row, Rows(out, _): Rows<&mut [f32]>| {
            out.copy_from_slice(row);
        });
        Self::project(share, *floating, (touching, *count), image);
    }

    /// Computes the change of the `pressure` for a change of the displacement without pressure.
    pub(crate) fn solve(&mut self, displacement: &[f32], pressure: &mut [f32]) {
        pressure.fill(0.0);
        if self.count == 0.0 || (self.floating && self.count == 1.0) {
            return;
        }
        self.residual.copy_from_slice(displacement);
        Self::project(&self.share, self.floating, (&self.touching, self.count), &mut self.residual);
        self.precondition();
        self.direction.copy_from_slice(&self.image);
        let unit = self.transforms.unit();
        let start = self.share.dot(&self.residual, &self.image);
        let mut slope = start;
        for _ in 0..ITERATIONS {
            let moving = slope.is_finite() && slope > 0.0;
            if !moving {
                break;
            }
            self.displace();
            // Compliances are in units of `unit`, stiffnesses in units of its inverse.
            let step = (slope / self.share.dot(&self.direction, &self.image)) as f32;
            let Self { residual, direction, image, .. } = self;
            for_each((&mut residual[..], &image[..]), &|_, (residual, image)| {
                residual.iter_mut().zip(image).for_each(|(r, g)| *r -= step * g);
            });
            for_each((&mut *pressure, &direction[..]), &|_, (pressure, direction)| {
                pressure.iter_mut().zip(direction).for_each(|(p, d)| *p += step * d);
            });
            self.precondition();
            let next = self.share.dot(&self.residual, &self.image);
            if next <= TOLERANCE * TOLERANCE * start {
                break;
            }
            let beta = (next / slope) as f32;
            let Self { direction, image, .. } = self;
            for_each((&mut direction[..], &image[..]), &|_, (direction, image)| {
                direction.iter_mut().zip(image).for_each(|(d, z)| *d = z + beta * *d);
            });
            slope = next;
        }
        let factor = (1.0 / unit) as f32;
        for_each([pressure], &|_, [pressure]| pressure.iter_mut().for_each(|p| *p *= factor));
    }
}
