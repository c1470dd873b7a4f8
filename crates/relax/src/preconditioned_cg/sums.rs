//! Sums over an iterate, block by block.

use std::ops::Range;

use gfmd_vector::{Serialise, Share, lower, lowest, reduce};
use multiversion::multiversion;

use super::active::{Flags, is_idle};
use crate::preconditioned::BLOCK;
use crate::quadratic::Optimality;
use crate::{Ceiling, Visit};

/// Sums over one iterate; gradients are relative to the previous multiplier.
#[derive(Clone, Copy)]
pub(super) struct Sums {
    pub(super) x: f64,
    pub(super) x_gradient: f64,
    pub(super) positive: usize,
    pub(super) positive_gradient: f64,
    pub(super) lowest: f64,
    /// Highest gradient at the upper bound.
    pub(super) highest: f64,
    /// ⟨g, step⟩ at the end of the step.
    pub(super) slope: f64,
    /// Number of variables brought to a bound by the step.
    pub(super) clipped: usize,
}

impl Sums {
    pub(super) const EMPTY: Self = Self {
        x: 0.0,
        x_gradient: 0.0,
        positive: 0,
        positive_gradient: 0.0,
        lowest: f64::INFINITY,
        highest: f64::NEG_INFINITY,
        slope: 0.0,
        clipped: 0,
    };

    /// Returns the change of the multiplier to the mean gradient of the variables between the bounds; if there are
    /// none, to the middle between the extreme gradients at the two bounds.
    pub(super) fn shift(&self) -> f64 {
        if self.positive > 0 {
            self.positive_gradient / self.positive as f64
        } else {
            match (self.lowest.is_finite(), self.highest.is_finite()) {
                (true, true) => 0.5 * (self.lowest + self.highest),
                (true, false) => self.lowest,
                (false, _) => self.highest,
            }
        }
    }

    pub(super) fn optimality(&self, shift: f64, scale: f64) -> Optimality {
        let complementarity = if self.x > 0.0 { (self.x_gradient / self.x - shift) / scale } else { 0.0 };
        let violation =
            if self.lowest.is_nan() { f64::NAN } else { (shift - self.lowest).max(self.highest - shift).max(0.0) };
        let violation = violation / scale;
        Optimality { complementarity, violation }
    }

    pub(super) fn visit(&mut self, visitor: &mut dyn Visit) {
        let Self { x, x_gradient, positive, positive_gradient, lowest, highest, slope, clipped } = self;
        visitor.numbers(&mut [x, x_gradient, positive_gradient, lowest, highest, slope]);
        for number in [positive, clipped] {
            let mut count = *number as u64;
            visitor.count(&mut count);
            *number = count as usize;
        }
    }

    /// Returns the sums over all stretches of all processes; `parts` are the sums of this process.
    pub(super) fn all(share: &Share, parts: &[Self]) -> Self {
        if share.is_whole() {
            return Self::joined(parts);
        }
        let stretches: Vec<usize> = share.all_rows().iter().map(Range::len).collect();
        Self::joined(&share.collect(parts, &stretches))
    }

    fn joined(parts: &[Self]) -> Self {
        reduce(
            parts.len(),
            &|range| parts[range].iter().fold(Self::EMPTY, |all, part| Self::merge(all, *part)),
            &Self::merge,
        )
    }

    pub(super) fn see(&mut self, x: f64, gradient: f64, step: f64, upper: f64) {
        self.slope += gradient * step;
        // A diverging search may reach infinity, which is no bound.
        if x >= upper && x.is_finite() {
            self.highest = self.highest.max(gradient);
            self.clipped += usize::from(step > 0.0);
            return;
        }
        self.lowest = lower(self.lowest, gradient);
        if x > 0.0 {
            self.x += x;
            self.x_gradient += x * gradient;
            self.positive += 1;
            self.positive_gradient += gradient;
        } else if step < 0.0 {
            self.clipped += 1;
        }
    }

    pub(super) fn merge(a: Self, b: Self) -> Self {
        Self {
            x: a.x + b.x,
            x_gradient: a.x_gradient + b.x_gradient,
            positive: a.positive + b.positive,
            positive_gradient: a.positive_gradient + b.positive_gradient,
            lowest: lower(a.lowest, b.lowest),
            highest: a.highest.max(b.highest),
            slope: a.slope + b.slope,
            clipped: a.clipped + b.clipped,
        }
    }
}

impl Serialise for Sums {
    const WORDS: usize = 8;

    fn put(&self, words: &mut [u64]) {
        let Self { x, x_gradient, positive, positive_gradient, lowest, highest, slope, clipped } = *self;
        ([x, x_gradient, positive_gradient, lowest, highest, slope], [positive, clipped]).put(words);
    }

    fn get(words: &[u64]) -> Self {
        let ([x, x_gradient, positive_gradient, lowest, highest, slope], [positive, clipped]) = Serialise::get(words);
        Self { x, x_gradient, positive, positive_gradient, lowest, highest, slope, clipped }
    }
}

/// Factors from single-precision values to values of the problem.
#[derive(Clone, Copy)]
pub(super) struct View {
    /// Unit of gradients.
    pub(super) gradient: f64,
    /// Unit of steps.
    pub(super) step: f64,
    /// Multiplier minus the level, in the unit of gradients.
    pub(super) offset: f64,
    pub(super) level: f64,
}

impl View {
    /// Returns the gradient minus the multiplier.
    pub(super) fn own(&self, gradient: f32) -> f64 {
        (f64::from(gradient) - self.offset) * self.gradient
    }

    pub(super) fn step(&self, step: f32) -> f64 {
        f64::from(step) * self.step
    }
}

/// Gradients, variables, steps, upper bounds and active blocks of a stretch.
type Stretch<'a, G> = (&'a [G], &'a [f64], &'a [f32], Ceiling<'a>, Flags<'a>);

/// Returns the sums over a stretch after a step; `own` returns the gradient minus the multiplier.
#[multiversion(targets = "simd")]
pub(super) fn measure<G: Copy + PartialOrd + From<f32>, F: Fn(G) -> f64>(
    view: View,
    own: F,
    stretch: Stretch<'_, G>,
) -> Sums {
    let (gradient, x, step, upper, flags) = stretch;
    let mut sums = Sums::EMPTY;
    let blocks = gradient.chunks(BLOCK).zip(x.chunks(BLOCK)).zip(step.chunks(BLOCK));
    for (block, ((g, x), s)) in blocks.enumerate() {
        if flags.idle(block) || is_idle(x, s) {
            sums.lowest = lower(sums.lowest, own(lowest(g)));
        } else if upper.is_finite() {
            let upper = upper.part(block * BLOCK..block * BLOCK + x.len());
            let all = x.iter().zip(g).zip(s).enumerate();
            all.for_each(|(i, ((x, g), s))| sums.see(*x, own(*g), view.step(*s), upper.at(i)));
        } else {
            sums.lowest = lower(sums.lowest, own(lowest(g)));
            let [x_sum, x_gradient, positive, positive_gradient, slope, clipped] =
                block_sums((x, g, s, s), |x, g, s, _| {
                    let (own, s) = (own(g), view.step(s));
                    let touches = if x > 0.0 { 1.0 } else { 0.0 };
                    let leaves = if (x <= 0.0) & (s < 0.0) { 1.0 } else { 0.0 };
                    [x, x * own, touches, touches * own, own * s, leaves]
                });
            sums.x += x_sum;
            sums.x_gradient += x_gradient;
            sums.positive += positive as usize;
            sums.positive_gradient += positive_gradient;
            sums.slope += slope;
            sums.clipped += clipped as usize;
        }
    }
    sums
}

/// Returns the sums of terms over a block, in pairwise order for vectorisation.
#[multiversion(targets = "simd")]
pub(super) fn block_sums<A: Copy, B: Copy, C: Copy, D: Copy, F: Fn(A, B, C, D) -> [f64; K], const K: usize>(
    fields: (&[A], &[B], &[C], &[D]),
    terms: F,
) -> [f64; K] {
    let (a, b, c, d) = fields;
    let whole = a.first_chunk::<BLOCK>().zip(b.first_chunk::<BLOCK>());
    let whole = whole.zip(c.first_chunk::<BLOCK>().zip(d.first_chunk::<BLOCK>()));
    const HALF: usize = BLOCK / 2;
    let mut values = [[0.0; HALF]; K];
    if let Some(((a, b), (c, d))) = whole {
        // The compiler vectorises a loop of known length.
        for half in [0, HALF] {
            for i in 0..HALF {
                let terms = terms(a[half + i], b[half + i], c[half + i], d[half + i]);
                for k in 0..K {
                    values[k][i] += terms[k];
                }
            }
        }
    } else {
        for i in 0..a.len() {
            let terms = terms(a[i], b[i], c[i], d[i]);
            for k in 0..K {
                values[k][i % HALF] += terms[k];
            }
        }
    }
    let mut sums = [0.0; K];
    for (sum, values) in sums.iter_mut().zip(&values) {
        let by_16: [f64; 16] = std::array::from_fn(|i| values[i] + values[i + 16]);
        let by_8: [f64; 8] = std::array::from_fn(|i| by_16[i] + by_16[i + 8]);
        let by_4: [f64; 4] = std::array::from_fn(|i| by_8[i] + by_8[i + 4]);
        *sum = (by_4[0] + by_4[1]) + (by_4[2] + by_4[3]);
    }
    sums
}

#[cfg(test)]
mod tests {
    use std::hint::black_box;

    use super::*;

    /// The order does not depend on the vector length of the processor.
    #[test]
    fn a_block_has_the_sums_of_its_terms_in_one_order() {
        for length in [BLOCK, BLOCK - 1, 40, 1] {
            let field = |seed: f64| (0..length).map(|i| ((i as f64 + 1.0) * seed).sin()).collect::<Vec<f64>>();
            let (a, b) = (field(0.618), field(1.414));
            let [products, squares] = block_sums((&a, &b, &a, &a), |a, b, _, _| [a * b, a * a]);
            let mut sums = [[0.0; BLOCK / 2]; 2];
            for i in 0..length {
                sums[0][i % (BLOCK / 2)] += black_box(a[i] * b[i]);
                sums[1][i % (BLOCK / 2)] += black_box(a[i] * a[i]);
            }
            for half in [16, 8, 4] {
                for i in 0..half {
                    sums.iter_mut().for_each(|sum| sum[i] = black_box(sum[i] + sum[i + half]));
                }
            }
            let all = sums.map(|sum| black_box(sum[0] + sum[1]) + black_box(sum[2] + sum[3]));
            assert_eq!([products, squares], all, "{length}");
        }
    }
}
