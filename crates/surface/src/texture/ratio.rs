use rayon::prelude::*;

/// Height difference that counts as rounding, as a fraction of the range.
const ROUNDING_OF_HEIGHT: f64 = 1e-9;

/// Width of the window through which the core line is fitted.
const WINDOW: f64 = 0.4;

/// Material ratios between which core volumes lie (ISO 25178-2 defaults p and q).
const OF_CORE: [f64; 2] = [0.1, 0.8];

/// Material ratios between which the extreme peak height lies.
const OF_PEAKS: [f64; 2] = [0.025, 0.5];

/// Heights in descending order at equal steps of the material ratio from 0 to 1, joined by straight lines. Integrals of
/// this polygon are exact.
pub(crate) struct MaterialRatio {
    heights: Vec<f64>,
}

/// Parameters of the bearing curve of ISO 25178-2, 4.5. The core is the least-squares line through the window of 40 %
/// with the smallest fall, the first one if several fall equally.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Core {
    /// Height of the core line above the mean at the ratio 0, length.
    pub top: f64,
    /// Sk: height of the core, between the ends of its line at the ratios 0 and 1, length.
    pub sk: f64,
    /// Spk: reduced height of the peaks above the core, the height of a triangle of equal area; length.
    pub spk: f64,
    /// Svk: reduced depth of the valleys below the core, length.
    pub svk: f64,
    /// Smr1: material ratio between peaks and core.
    pub smr1: f64,
    /// Smr2: material ratio between core and valleys.
    pub smr2: f64,
    /// Spkx: highest peak above the core, length.
    pub spkx: f64,
    /// Svkx: deepest valley below the core, length.
    pub svkx: f64,
}

/// Volumes per area of ISO 25178-2, 4.5, at the material ratios 10 % and 80 %, and height differences of the curve; all
/// lengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volumes {
    /// Vmp: volume of the material above the height at 10 %.
    pub vmp: f64,
    /// Vmc: volume of the material between the heights at 10 % and 80 %.
    pub vmc: f64,
    /// Vvc: volume of the voids between the heights at 10 % and 80 %.
    pub vvc: f64,
    /// Vvv: volume of the voids below the height at 80 %.
    pub vvv: f64,
    /// Sxp: height at 2.5 % minus the height at 50 %.
    pub sxp: f64,
    /// Sdc: height at 10 % minus the height at 80 %.
    pub sdc: f64,
}

impl MaterialRatio {
    /// Sorts heights and subtracts their mean. Returns `None` if all heights are equal.
    pub(crate) fn of(heights: &[f64]) -> Option<Self> {
        let mut sorted = heights.to_vec();
        sorted.par_sort_unstable_by(|a, b| b.total_cmp(a));
        let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
        sorted.iter_mut().for_each(|height| *height -= mean);
        match (sorted.first(), sorted.last()) {
            (Some(highest), Some(lowest)) if highest > lowest => Some(Self { heights: sorted }),
            _ => None,
        }
    }

    fn range(&self) -> f64 {
        self.heights[0] - self.heights[self.last()]
    }

    fn last(&self) -> usize {
        self.heights.len() - 1
    }

    fn ratio(&self, k: usize) -> f64 {
        k as f64 / self.last() as f64
    }

    /// Returns the height at a ratio: Smc of the standard.
    pub(crate) fn height(&self, ratio: f64) -> f64 {
        let position = ratio.clamp(0.0, 1.0) * self.last() as f64;
        let k = (position as usize).min(self.last() - 1);
        let [above, below] = [self.heights[k], self.heights[k + 1]];
        above + (position - k as f64) * (below - above)
    }

    /// Returns the ratio at a height: Smr of the standard.
    pub(crate) fn ratio_at(&self, height: f64) -> f64 {
        match self.heights.partition_point(|own| *own > height) {
            0 => 0.0,
            _ if height <= self.heights[self.last()] => 1.0,
            above => {
                let [high, low] = [self.heights[above - 1], self.heights[above]];
                self.ratio(above - 1) + (high - height) / (high - low) / self.last() as f64
            }
        }
    }

    /// Returns the integrals of z and of (q − middle) z, where z is the height above `level`, over ratios q.
    fn integrals(&self, [from, to]: [f64; 2], level: f64, middle: f64) -> [f64; 2] {
        let inner = |ratio: f64| ratio * self.last() as f64;
        let inside = (inner(from) as usize + 1)..(inner(to).ceil() as usize).max(inner(from) as usize + 1);
        let knots = inside.map(|k| (self.ratio(k), self.heights[k]));
        let end = std::iter::once((to, self.height(to)));
        let (mut sums, mut before) = ([0.0; 2], (from, self.height(from)));
        for (ratio, height) in knots.chain(end) {
            let (width, [a, b]) = (ratio - before.0, [before.1 - level, height - level]);
            sums[0] += 0.5 * width * (a + b);
            sums[1] += width * (0.5 * (before.0 - middle) * (a + b) + width * (a / 6.0 + b / 3.0));
            before = (ratio, height);
        }
        sums
    }

    /// Returns the start of the window with the smallest fall. The fall is least where one end lies on a point.
    fn window(&self) -> f64 {
        let fits = |start: &f64| (0.0..=1.0 - WINDOW).contains(start);
        let starts = || {
            let ratios = || (0..=self.last()).map(|k| self.ratio(k));
            ratios().chain(ratios().map(|ratio| ratio - WINDOW)).chain([1.0 - WINDOW]).filter(fits)
        };
        let fall = |start: f64| self.height(start) - self.height(start + WINDOW);
        let least = starts().map(fall).fold(f64::INFINITY, f64::min) + ROUNDING_OF_HEIGHT * self.range();
        starts().filter(|start| fall(*start) <= least).fold(1.0 - WINDOW, f64::min)
    }

    /// Computes the core and what lies beyond it.
    pub(crate) fn core(&self) -> Core {
        let start = self.window();
        let middle = start + 0.5 * WINDOW;
        let [area, moment] = self.integrals([start, start + WINDOW], 0.0, middle);
        let sk = -12.0 * moment / WINDOW.powi(3);
        let top = area / WINDOW + sk * middle;
        let bottom = top - sk;
        let [spkx, svkx] = [self.heights[0] - top, bottom - self.heights[self.last()]]
            .map(|beyond| if beyond > ROUNDING_OF_HEIGHT * self.range() { beyond } else { 0.0 });
        let smr1 = if spkx > 0.0 { self.ratio_at(top) } else { 0.0 };
        let smr2 = if svkx > 0.0 { self.ratio_at(bottom) } else { 1.0 };
        let [peaks, _] = self.integrals([0.0, smr1], top, 0.0);
        let [valleys, _] = self.integrals([smr2, 1.0], bottom, 0.0);
        let triangle = |area: f64, base: f64| if base > 0.0 { 2.0 * area / base } else { 0.0 };
        Core { top, sk, spk: triangle(peaks, smr1), svk: triangle(-valleys, 1.0 - smr2), smr1, smr2, spkx, svkx }
    }

    /// Computes the volumes and height differences.
    pub(crate) fn volumes(&self) -> Volumes {
        let material = |ratio: f64| self.integrals([0.0, ratio], self.height(ratio), 0.0)[0];
        let void = |ratio: f64| -self.integrals([ratio, 1.0], self.height(ratio), 0.0)[0];
        let between = |[from, to]: [f64; 2]| self.height(from) - self.height(to);
        let [p, q] = OF_CORE;
        Volumes {
            vmp: material(p),
            vmc: material(q) - material(p),
            vvc: void(p) - void(q),
            vvv: void(q),
            sxp: between(OF_PEAKS),
            sdc: between(OF_CORE),
        }
    }
}
