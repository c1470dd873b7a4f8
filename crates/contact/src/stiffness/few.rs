//! Linear problem of the stiffness on few points, with compliance and approximate stiffness between these only.

use gfmd_response::{LANES, Scattered};
use gfmd_vector::{Share, dot, total};

use crate::dilute::{Gaps, Points, are_few, at_points, gathered, own_blocks};
use crate::{Contact, Effort};

/// Largest fraction of points in blocks with which this takes less time than transforms of the whole surface.
const MAX_BLOCK_FRACTION: f64 = 0.15;

/// Least square of the residual after one correction, relative to the start. Images between the points have errors of
/// 4e-4.
const TOLERANCE: f64 = 1e-8;

/// Largest number of iterations of one correction.
const ITERATIONS: usize = 60;

/// Points in contact, in blocks that every process knows.
pub(super) struct Few {
    points: Points,
    share: Share,
    /// 1 for points in contact, else 0.
    touching: Vec<f32>,
    /// M 1 on the contact, with the preconditioner M, unless it is zero.
    constant: Option<Vec<f32>>,
    /// Displacement of the contact minus a constant, in the unit of the points.
    residual: Vec<f32>,
    images: u64,
}

impl Few {
    /// Selects the points of the own rows with positive `pressure`; `None` if they are too many, or if the contact has
    /// free boundaries, a hardness, or springs that differ between points.
    pub(super) fn of(contact: &Contact, pressure: &[f64]) -> Option<Self> {
        if contact.free.is_some() || contact.hardness.is_some() || contact.springs.is_some() {
            return None;
        }
        let scattered = Scattered::of(&contact.response, [0.0; 2])?;
        let share = contact.share.clone();
        let first = share.own().start / LANES;
        let touches = |(_, values): &(usize, &[f64; LANES])| values.iter().any(|p| *p > 0.0);
        let own = pressure.as_chunks().0.iter().enumerate().filter(touches).map(|(place, _)| first + place);
        let places = gathered(&share, own.collect::<Vec<_>>());
        if !are_few(&places, MAX_BLOCK_FRACTION, share.total()) {
            return None;
        }
        let mut points = Points::new(contact, scattered, true, places);
        let touches = |p: f64| if p > 0.0 { 1.0 } else { 0.0 };
        let touching: Vec<f32> = at_points(points.blocks(), &share, pressure).into_iter().map(touches).collect();
        let constant = (!points.keeps_constants()).then(|| {
            let mut constant = vec![0.0; touching.len()];
            points.press(gaps(&touching, &touching), &mut constant);
            constant
        });
        let residual = vec![0.0; touching.len()];
        Some(Self { points, share, touching, constant, residual, images: 0 })
    }

    pub(super) fn effort(&self) -> Effort {
        Effort { iterations: self.images, transform_pairs: self.points.pairs() }
    }

    /// Sets the residual to the displacement of the contact under a `uniform` pressure.
    pub(super) fn start(&mut self, uniform: f64) {
        let Self { points, touching, residual, .. } = self;
        let uniform: Vec<f32> = touching.iter().map(|touches| touches * uniform as f32).collect();
        points.displace(&uniform, residual);
        keep(residual, touching);
        self.images += 1;
    }

    /// Sets the residual from the own rows, in this `unit` of compliances. Returns ⟨r, M r⟩.
    pub(super) fn take(&mut self, residual: &[f32], unit: f64) -> f64 {
        let factor = unit / self.points.unit();
        let mut residual = self.at_points(residual);
        residual.iter_mut().for_each(|r| *r = (f64::from(*r) * factor) as f32);
        self.level(&mut residual);
        let mut image = vec![0.0; residual.len()];
        self.precondition(&residual, &mut image);
        let slope = dot(&residual, &image) * self.points.unit();
        self.residual = residual;
        slope
    }

    /// Adds to `pressure` of the own rows a correction without a sum. Its displacement is opposite to the residual on
    /// the contact, up to a constant, to the relative square `tolerance`.
    pub(super) fn correct(&mut self, tolerance: f64, pressure: &mut [f32]) {
        let tolerance = tolerance.max(TOLERANCE);
        let mut residual = std::mem::take(&mut self.residual);
        let n = residual.len();
        let (mut correction, mut direction, mut image) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let [mut first, mut last] = [0.0, f64::INFINITY];
        for iteration in 0..ITERATIONS {
            self.level(&mut residual);
            self.precondition(&residual, &mut image);
            let slope = dot(&residual, &image);
            if iteration == 0 {
                first = slope;
            }
            let goes_on = slope > tolerance * first;
            if !goes_on {
                break;
            }
            let beta = (slope / last) as f32;
            direction.iter_mut().zip(&image).for_each(|(d, z)| *d = z + beta * *d);
            self.points.displace(&direction, &mut image);
            keep(&mut image, &self.touching);
            self.images += 1;
            let step = (slope / dot(&direction, &image)) as f32;
            correction.iter_mut().zip(&direction).for_each(|(q, d)| *q -= step * d);
            residual.iter_mut().zip(&image).for_each(|(r, g)| *r -= step * g);
            last = slope;
        }
        for (values, row) in own_blocks(self.points.blocks(), &self.share) {
            pressure[row].iter_mut().zip(&correction[values]).for_each(|(p, q)| *p += q);
        }
    }

    /// Gathers the values at the points of the blocks from the `own` rows; zero outside the contact.
    fn at_points(&self, own: &[f32]) -> Vec<f32> {
        let values = at_points(self.points.blocks(), &self.share, own).into_iter().zip(&self.touching);
        values.map(|(value, touching)| if *touching > 0.0 { value } else { 0.0 }).collect()
    }

    /// Removes the mean over the contact.
    fn level(&self, residual: &mut [f32]) {
        let mean = (total(residual) / total(&self.touching)) as f32;
        residual.iter_mut().zip(&self.touching).for_each(|(r, touching)| *r -= mean * touching);
    }

    /// Computes `out` = (M − M 1 1ᵀM/(1ᵀM 1)) `residual`, which has no sum.
    fn precondition(&mut self, residual: &[f32], out: &mut [f32]) {
        let Self { points, touching, constant, .. } = self;
        points.press(gaps(touching, residual), out);
        if let Some(constant) = constant {
            let level = (total(out) / total(constant)) as f32;
            out.iter_mut().zip(constant).for_each(|(out, constant)| *out -= level * *constant);
        }
    }
}

/// Returns the gaps of each block, with flags for points in contact.
fn gaps(touching: &[f32], gap: &[f32]) -> impl Fn(usize) -> Gaps + Sync {
    let (touching, gap) = (touching.as_chunks().0, gap.as_chunks().0);
    move |block| Gaps { touches: touching[block].map(|touches: f32| touches > 0.0), gap: gap[block] }
}

/// Sets values outside the contact to zero.
fn keep(values: &mut [f32], touching: &[f32]) {
    values.iter_mut().zip(touching).for_each(|(value, touching)| *value *= touching);
}
