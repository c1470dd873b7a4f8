//! Steps on one row. Loops run over whole rows, without branches and with local constants, so that compilers vectorise
//! them, also for processors with wide vectors.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use gfmd_relax::Ceiling;
use multiversion::multiversion;

use super::BITS;

/// Values of the points of a row: x, gradient, and the upper bounds of x.
pub(super) type Points<'a> = (&'a [f64], &'a [f32], Ceiling<'a>);

/// Writes the weights of known points and their values times the weights. Sets a flag for each word of bits with a
/// point that is not zero.
#[multiversion(targets = "simd")]
pub(super) fn weigh_points(
    points: Points<'_>,
    level: f32,
    above: &[AtomicBool],
    weights: &mut [f32],
    values: &mut [f32],
) {
    let (x, gradient, upper) = points;
    let points = x.chunks(BITS).zip(gradient.chunks(BITS)).zip(above);
    let out = weights.chunks_mut(BITS).zip(values.chunks_mut(BITS));
    for (chunk, (((x, gradient), above), (weights, values))) in points.zip(out).enumerate() {
        let any = x.iter().fold(false, |any, x| any | (*x != 0.0));
        above.store(any, Ordering::Relaxed);
        if !any {
            weights.fill(0.0);
            values.fill(0.0);
            continue;
        }
        let upper = upper.part(chunk * BITS..chunk * BITS + x.len());
        let out = weights.iter_mut().zip(values);
        for (j, ((weight, value), (x, gradient))) in out.zip(x.iter().zip(gradient)).enumerate() {
            *weight = if (*x > 0.0) & (*x < upper.at(j)) { 1.0 } else { 0.0 };
            *value = *weight * (gradient - level);
        }
    }
}

/// Computes the weights of cells from their known weights, and the values times the weights.
#[multiversion(targets = "simd")]
pub(super) fn weigh(full: f32, cells: (&[f32], &[f32]), weights: &mut [f32], products: &mut [f32]) {
    let (known, values) = cells;
    for ((own, product), (known, value)) in weights.iter_mut().zip(products).zip(known.iter().zip(values)) {
        *own = weight(*known, full);
        *product = *own * value;
    }
}

/// Adds pairs of the row below; the last of an odd number is alone.
#[multiversion(targets = "simd")]
pub(super) fn add_pairs(line: &[f32], sums: &mut [f32]) {
    let (pairs, last) = line.as_chunks::<2>();
    for (sum, pair) in sums.iter_mut().zip(pairs) {
        *sum += pair[0] + pair[1];
    }
    if let (Some(sum), Some(last)) = (sums.last_mut(), last.first()) {
        *sum += last;
    }
}

/// Divides values by known weights; zero where nothing is known.
#[multiversion(targets = "simd")]
pub(super) fn divide(values: &mut [f32], known: &[f32]) {
    for (value, known) in values.iter_mut().zip(known) {
        *value = if *known > 0.0 { *value / *known } else { 0.0 };
    }
}

/// Interpolates the children of the inner cells of a row, from the nearest row and the next one, times these parts.
#[multiversion(targets = "simd")]
pub(super) fn interpolate(near: &[f32], far: &[f32], parts: [f32; 2], children: &mut [[f32; 2]]) {
    let windows = near.windows(3).zip(far.windows(3));
    for (pair, (near, far)) in children.iter_mut().zip(windows) {
        *pair = pair_of([near[0], near[1], near[2]], [far[0], far[1], far[2]], parts);
    }
}

/// Returns the two children of a cell, between three cells of two rows.
pub(super) fn pair_of(near: [f32; 3], far: [f32; 3], [close, distant]: [f32; 2]) -> [f32; 2] {
    let [before, own, after]: [f32; 3] = std::array::from_fn(|k| close * near[k] + distant * far[k]);
    [before, after].map(|other| 0.75 * own + 0.25 * other)
}

/// Computes the inner cells of a row of images, from a line of pairs of children: the transpose of [`interpolate`].
#[multiversion(targets = "simd")]
pub(super) fn gather(line: &[[f32; 2]], trust: f32, images: &mut [f32]) {
    for (image, window) in images.iter_mut().zip(line.windows(3)) {
        let [before, own, after] = [window[0], window[1], window[2]];
        *image = trust * (0.75 * (own[0] + own[1]) + 0.25 * (before[1] + after[0]));
    }
}

/// Blends the values of cells with the level above, as far as they are not known.
#[multiversion(targets = "simd")]
pub(super) fn blend(full: f32, known: &[f32], pushed: &[f32], values: &mut [f32]) {
    for ((value, known), pushed) in values.iter_mut().zip(known).zip(pushed) {
        let weight = weight(*known, full);
        *value = weight * *value + (1.0 - weight) * pushed;
    }
}

/// Replaces the extended values in `out` by own values at the points that keep them, and sets one bit for each of them.
#[multiversion(targets = "simd")]
pub(super) fn keep(points: Points<'_>, level: f32, above: &[AtomicBool], kept: &[AtomicU64], out: &mut [f32]) {
    let (x, gradient, upper) = points;
    let all = out.chunks_mut(BITS).zip(x.chunks(BITS).zip(gradient.chunks(BITS))).zip(above.iter().zip(kept));
    for (chunk, ((out, (x, gradient)), (above, kept))) in all.enumerate() {
        // Zeros need not be read.
        let is_zero = !above.load(Ordering::Relaxed);
        let x = if is_zero { &[0.0; BITS][..x.len()] } else { x };
        let mut bits = 0;
        for (j, (out, (x, gradient))) in out.iter_mut().zip(x.iter().zip(gradient)).enumerate() {
            let own = gradient - level;
            let full = *x >= upper.at(chunk * BITS + j);
            let enters = if full { (own > 0.0) & (own > *out) } else { (own < 0.0) & (own < *out) };
            let keeps = ((*x > 0.0) & !full) | enters;
            *out = if keeps { own } else { *out };
            bits |= u64::from(keeps) << j;
        }
        kept.store(bits, Ordering::Relaxed);
    }
}

/// Adds `part` times the entries of points that did not keep their value to `line`.
#[multiversion(targets = "simd")]
pub(super) fn accumulate_points(t: &[f32], kept: &[AtomicU64], part: f32, line: &mut [f32]) {
    for ((line, t), kept) in line.chunks_mut(BITS).zip(t.chunks(BITS)).zip(kept) {
        let kept = kept.load(Ordering::Relaxed);
        for (j, (line, t)) in line.iter_mut().zip(t).enumerate() {
            *line += if kept >> j & 1 == 0 { part * t } else { 0.0 };
        }
    }
}

/// Adds to `line` `part` times the values that cells with these images pass to the level above.
#[multiversion(targets = "simd")]
pub(super) fn accumulate_cells(full: f32, cells: (&[f32], &[f32]), part: f32, line: &mut [f32]) {
    let (known, images) = cells;
    for (line, (image, known)) in line.iter_mut().zip(images.iter().zip(known)) {
        *line += part * (1.0 - weight(*known, full)) * image;
    }
}

/// Computes the shares of the two children of each cell in its image.
#[multiversion(targets = "simd")]
pub(super) fn split(known: &[f32], images: &[f32], shares: &mut [[f32; 2]]) {
    for (pair, (image, known)) in shares.iter_mut().zip(images.iter().zip(known)) {
        *pair = [if *known > 0.0 { image / known } else { 0.0 }; 2];
    }
}

/// Adds the shares in the level above to `images`, and multiplies by the weights of the cells.
#[multiversion(targets = "simd")]
pub(super) fn receive(full: f32, known: &[f32], shares: &[f32], images: &mut [f32]) {
    for ((image, known), share) in images.iter_mut().zip(known).zip(shares) {
        *image = weight(*known, full) * (*image + share);
    }
}

/// Adds the shares of known points to `t`, and sets points that did not keep their value to zero.
#[multiversion(targets = "simd")]
pub(super) fn finish(x: &[f64], upper: Ceiling<'_>, kept: &[AtomicU64], shares: &[f32], t: &mut [f32]) {
    let points = shares.chunks(BITS).zip(x.chunks(BITS));
    for (chunk, ((t, (shares, x)), kept)) in t.chunks_mut(BITS).zip(points).zip(kept).enumerate() {
        let kept = kept.load(Ordering::Relaxed);
        if kept == 0 {
            t.fill(0.0);
            continue;
        }
        for (j, (t, (share, x))) in t.iter_mut().zip(shares.iter().zip(x)).enumerate() {
            let known = (*x > 0.0) & (*x < upper.at(chunk * BITS + j));
            let whole = *t + if known { *share } else { 0.0 };
            *t = if kept >> j & 1 == 0 { 0.0 } else { whole };
        }
    }
}

pub(super) fn weight(known: f32, full: f32) -> f32 {
    if known < full { known / full } else { 1.0 }
}
