//! Stiffness of contacts of few points, from the compliance and its approximate inverse between these only.

use gfmd_response::{BlockRows, LANES, Scattered};
use gfmd_vector::{dot, total};

use super::middle_of;
use crate::compliance::Compliance;
use crate::dilute::{Gaps, Points, are_few, at_points, gathered};
use crate::{Contact, Effort};

/// Least and largest excess of the compliance divided by ⟨r, M r⟩; M may be smaller than the inverse of G by some 15 %.
/// Measured: 0.9 to 1.2 (256² and 1024², H = 0 and 0.8, half-space and slab, p* to 0.05).
pub(super) const RANGE: [f64; 2] = [0.5, 1.5];

/// Largest number of corrections.
const CORRECTIONS: usize = 3;

/// Largest fraction of points in blocks with which this takes less time than transforms of the whole surface.
const MAX_BLOCK_FRACTION: f64 = 0.15;

/// Least square of the residual after one correction, relative to the start. Images between the points have errors of
/// 4e-4.
const TOLERANCE: f64 = 1e-8;

/// Largest number of iterations of one correction.
const ITERATIONS: usize = 60;

/// Pressure with mean 1 that displaces all points in contact by the same amount, on the points in contact, in blocks
/// that every process knows.
pub(super) struct Few<'a> {
    contact: &'a Contact,
    points: Points,
    transforms: Compliance,
    /// 1 for points in contact, else 0.
    touching: Vec<f32>,
    /// M 1 on the contact, with the preconditioner M, unless it is zero.
    constant: Option<Vec<f32>>,
    /// Pressure minus its mean over the contact.
    variation: Vec<f32>,
    /// Displacement of the contact minus a constant, in the unit of the points.
    residual: Vec<f32>,
    images: u64,
}

impl<'a> Few<'a> {
    /// Selects the points of the own rows with positive `pressure`; `None` if they are too many, or if the contact has
    /// free boundaries, a hardness, or springs that differ between points.
    pub(super) fn of(contact: &'a Contact, pressure: &[f64]) -> Option<Self> {
        if contact.free.is_some() || contact.hardness.is_some() || contact.springs.is_some() {
            return None;
        }
        let scattered = Scattered::of(&contact.response, [0.0; 2])?;
        let share = &contact.share;
        let first = share.own().start / LANES;
        let touches = |(_, values): &(usize, &[f64; LANES])| values.iter().any(|p| *p > 0.0);
        let own = pressure.as_chunks().0.iter().enumerate().filter(touches).map(|(place, _)| first + place);
        let places = gathered(share, own.collect::<Vec<_>>());
        if !are_few(&places, MAX_BLOCK_FRACTION, share.total()) {
            return None;
        }
        let mut points = Points::new(contact, scattered, true, places);
        let touches = |p: f64| if p > 0.0 { 1.0 } else { 0.0 };
        let touching: Vec<f32> = at_points(points.blocks(), share, pressure).into_iter().map(touches).collect();
        let constant = (!points.keeps_constants()).then(|| {
            let mut constant = vec![0.0; touching.len()];
            points.press(gaps(&touching, &touching), &mut constant);
            constant
        });
        Some(Self {
            contact,
            points,
            transforms: Compliance::of(contact),
            constant,
            variation: vec![0.0; touching.len()],
            residual: vec![0.0; touching.len()],
            touching,
            images: 0,
        })
    }

    pub(super) fn effort(&self) -> Effort {
        Effort { iterations: self.images, transform_pairs: self.points.pairs() + self.transforms.pairs() }
    }

    /// Corrects the pressure, each time to some 4e-4 of its error. If the `tolerance` is reached, returns ⟨q, G q⟩ from
    /// fresh transforms in double precision, and ⟨r, M r⟩ with the preconditioner of the few points.
    pub(super) fn solve(&mut self, tolerance: f64) -> Option<[f64; 2]> {
        self.start();
        let enough = tolerance / middle_of(RANGE)[1];
        (0..CORRECTIONS).find_map(|_| {
            self.correct(enough);
            let work = self.refresh();
            let slope = self.slope();
            (slope.abs() <= enough * work).then_some([work, slope])
        })
    }

    /// Returns the mean pressure over the contact.
    fn uniform(&self) -> f64 {
        self.contact.share.total() as f64 / total(&self.touching)
    }

    /// Sets the residual to the displacement of the contact under a uniform pressure.
    fn start(&mut self) {
        let uniform = self.uniform() as f32;
        let Self { points, touching, residual, .. } = self;
        let uniform: Vec<f32> = touching.iter().map(|touches| touches * uniform).collect();
        points.displace(&uniform, residual);
        keep(residual, touching);
        self.images += 1;
    }

    /// Sets the residual to the displacement of the contact under the pressure, in double precision. Returns ⟨q, G q⟩.
    fn refresh(&mut self) -> f64 {
        let uniform = self.uniform();
        let Self { contact, points, transforms, touching, variation, residual, .. } = self;
        let (share, compliance) = (&contact.share, contact.response.compliance());
        let (blocks, unit, rows) = (points.blocks(), points.unit(), share.rows());
        // Rounding errors have changed the sum.
        let mean = 1.0 + total(variation) / share.total() as f64;
        let points = variation.iter().zip(&*touching);
        let pressure = points.map(|(v, t)| if *t > 0.0 { (uniform + f64::from(*v)) / mean } else { 0.0 });
        let pressure: Vec<f64> = pressure.collect();
        let own = blocks.values_in(&rows);
        let (mut displacement, mut works) = (vec![0.0; own.len()], vec![0.0; rows.len()]);
        let pressure = || blocks.split_rows(&rows, &pressure[own.clone()]);
        let source = |i: usize, BlockRows { values, .. }: BlockRows<&[f64]>, row: &mut [f64]| {
            blocks.write_row(rows.start + i, values, row);
        };
        type Parts<'a> = (BlockRows<'a, &'a [f64]>, BlockRows<'a, &'a mut [f32]>, &'a mut [f64]);
        let sink = |i: usize, row: &mut [f64], (pressure, residual, work): Parts| {
            let columns = blocks.columns_in_row(rows.start + i).flatten();
            for ((column, q), r) in columns.zip(pressure.values).zip(residual.values) {
                *r = (row[column] / unit) as f32;
                work[0] += row[column] * q;
            }
        };
        let output = (pressure(), blocks.split_rows(&rows, &mut displacement[..]), &mut works[..]);
        transforms.apply_rows(compliance, (pressure(), source), (output, sink));
        *residual = gathered(share, displacement);
        keep(residual, touching);
        let lengths: Vec<usize> = share.all_rows().iter().map(|rows| rows.len()).collect();
        share.collect(&works, &lengths).iter().sum()
    }

    /// Returns ⟨r, M r⟩, and removes the mean of the residual r over the contact.
    fn slope(&mut self) -> f64 {
        let mut residual = std::mem::take(&mut self.residual);
        self.level(&mut residual);
        let mut image = vec![0.0; residual.len()];
        self.precondition(&residual, &mut image);
        let slope = dot(&residual, &image) * self.points.unit();
        self.residual = residual;
        slope
    }

    /// Adds to the pressure a correction without a sum. Its displacement is opposite to the residual on the contact, up
    /// to a constant, to the relative square `tolerance`.
    fn correct(&mut self, tolerance: f64) {
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
        self.variation.iter_mut().zip(&correction).for_each(|(q, change)| *q += change);
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
