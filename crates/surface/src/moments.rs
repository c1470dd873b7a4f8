use std::f64::consts::TAU;
use std::ops::Range;

use gfmd_field::{Grid, Mode, Share};
use rayon::prelude::*;

/// Dimension of heights: a surface over the plane or a profile along a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// h(x): one point along y.
    Profile,
    /// h(x, y).
    Surface,
}

impl Dimension {
    /// Returns the dimension of heights on `grid`.
    pub fn of(grid: &Grid) -> Self {
        if grid.is_line() { Self::Profile } else { Self::Surface }
    }
}

/// Spectral moments: sums over all q ≠ 0 of the full spectrum (theory.md, section 9).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Surface or profile, which determines the profile moments and the curvature.
    pub dimension: Dimension,
    /// Mean square height, h_rms² = Σ |h̃|², length².
    pub mean_square_height: f64,
    /// Mean square of the full gradient |∇h|, ḡ² = Σ q²|h̃|², dimensionless.
    pub mean_square_gradient: f64,
    /// Mean square of the Laplacian ∇²h, Σ q⁴|h̃|², 1/length².
    pub mean_square_laplacian: f64,
    /// Contribution of waves shorter than four points to the mean square gradient.
    pub mean_square_gradient_of_short_waves: f64,
    /// Effective number of waves, (Σ g)²/Σ g², where g is the contribution of a wave to the mean square gradient: 1 for
    /// a single wave, hundreds for a rough surface; NaN for a flat one.
    pub waves: f64,
}

impl Moments {
    /// Returns the fraction of the mean square gradient in waves shorter than four points. Above 0.01 the grid does not
    /// resolve the surface, and contact results depend on the heights between the points.
    pub fn short_waves(&self) -> f64 {
        let short = self.mean_square_gradient_of_short_waves;
        if short > 0.0 { short / self.mean_square_gradient } else { 0.0 }
    }

    /// Returns the root-mean-square height h_rms, length.
    pub fn rms_height(&self) -> f64 {
        self.mean_square_height.sqrt()
    }

    /// Returns the root-mean-square ḡ of the full gradient |∇h| (h′ for a profile), dimensionless.
    pub fn rms_gradient(&self) -> f64 {
        self.mean_square_gradient.sqrt()
    }

    /// Returns the root-mean-square Laplacian ∇²h (h″ for a profile), 1/length.
    pub fn rms_laplacian(&self) -> f64 {
        self.mean_square_laplacian.sqrt()
    }

    /// Returns the root-mean-square mean curvature (h_xx + h_yy)/2 of a surface, half the rms Laplacian, or the
    /// root-mean-square h″ of a profile; 1/length.
    pub fn rms_curvature(&self) -> f64 {
        match self.dimension {
            Dimension::Profile => self.rms_laplacian(),
            Dimension::Surface => 0.5 * self.rms_laplacian(),
        }
    }

    /// Returns the moments m0, m2, m4 = Σ|h̃|², Σq²|h̃|², Σq⁴|h̃|² of a profile. For a surface, returns the moments of
    /// a straight cut, m0 = h_rms², m2 = ḡ²/2, m4 = (3/8) Σq⁴|h̃|², which hold for an isotropic surface.
    pub fn profile(&self) -> [f64; 3] {
        match self.dimension {
            Dimension::Profile => [self.mean_square_height, self.mean_square_gradient, self.mean_square_laplacian],
            Dimension::Surface => {
                [self.mean_square_height, self.mean_square_gradient / 2.0, 0.375 * self.mean_square_laplacian]
            }
        }
    }

    /// Returns Nayak's parameter α = m0 m4/m2² ≥ 1 (≥ 3/2 for an isotropic Gaussian surface); `None` if flat.
    pub fn nayak(&self) -> Option<f64> {
        let [m0, m2, m4] = self.profile();
        (m2 > 0.0).then(|| (m0 / m2) * (m4 / m2))
    }
}

/// Number of modes in a task, fixed to make sums bitwise identical for any number of threads and processes.
pub(crate) const MODES_PER_TASK: usize = 1 << 13;

/// Returns the first mode of the first task that begins in the range `own`, or the end of the range if none does.
pub(crate) fn first_task(own: &Range<usize>) -> usize {
    own.start.next_multiple_of(MODES_PER_TASK).min(own.end)
}

/// Returns the modes in the lanes of this process as indices in storage order.
pub(crate) fn own_modes(grid: &Grid, lanes: Range<usize>) -> Range<usize> {
    let [_, positions] = grid.spectrum_shape();
    lanes.start * positions..lanes.end * positions
}

/// Running sums of the four moments and of the squared contributions to the mean square gradient. Each task has
/// separate sums, which are added in task order.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums([f64; 5]);

/// Returns the squared largest wavenumber of waves with four or more points, along the axis with the larger spacing.
pub(crate) fn resolved(grid: &Grid) -> f64 {
    let [dx, dy] = grid.spacing();
    let spacing = if grid.is_line() { dx } else { dx.max(dy) };
    (TAU / (4.0 * spacing) * (1.0 + 1e-9)).powi(2)
}

impl Sums {
    /// Adds a mode of the half spectrum with |h̃|² = `square`. It counts as a short wave if it exceeds [resolved].
    pub(crate) fn add(&mut self, mode: &Mode, square: f64, resolved: f64) {
        let [x, y] = mode.wavevector;
        let q2 = x * x + y * y;
        let weighed = mode.weight * square;
        let part = weighed * q2;
        let short = if q2 > resolved { part } else { 0.0 };
        // A wave with both modes in the half spectrum is split equally between them.
        let of_wave = part * part * (2.0 / mode.weight);
        for (sum, term) in self.0.iter_mut().zip([weighed, part, weighed * q2 * q2, short, of_wave]) {
            *sum += term;
        }
    }

    /// Returns the sums of all modes, task by task, from |h̃|² of the `own` modes of this process, given as indices in
    /// storage order. All processes get all sums.
    pub(crate) fn of_power(grid: &Grid, share: &Share, own: &Range<usize>, power: &[f64]) -> Vec<Self> {
        let (first, resolved) = (first_task(own), resolved(grid));
        // Modes before the first task belong to the last task of a previous process.
        let (head, rest) = power.split_at(first - own.start);
        let lengths = share.each(head.len());
        let heads = share.collect(head, &lengths);
        let behind = &heads[lengths[..=share.ranks().rank()].iter().sum()..];
        let sums = rest.par_chunks(MODES_PER_TASK).enumerate().map(|(task, chunk)| {
            let mut sums = Self::default();
            let all = chunk.iter().chain(&behind[..behind.len().min(MODES_PER_TASK - chunk.len())]);
            for (mode, square) in grid.modes_from(first + task * MODES_PER_TASK).zip(all) {
                if !mode.is_uniform() {
                    sums.add(&mode, *square, resolved);
                }
            }
            sums
        });
        Self::of_all(share, sums.collect())
    }

    /// Gathers the sums of the tasks of all processes.
    pub(crate) fn of_all(share: &Share, own: Vec<Self>) -> Vec<Self> {
        if share.is_whole() {
            return own;
        }
        let words: Vec<[f64; 5]> = own.iter().map(|sums| sums.0).collect();
        share.collect(&words, &share.each(words.len())).into_iter().map(Self).collect()
    }

    /// Returns the moments from the sums of all tasks, multiplied by `factor`.
    pub(crate) fn moments(parts: &[Self], grid: &Grid, factor: f64) -> Moments {
        let sum = |k: usize| parts.iter().map(|part| part.0[k]).sum::<f64>();
        let total = |k: usize| factor * sum(k);
        Moments {
            dimension: Dimension::of(grid),
            mean_square_height: total(0),
            mean_square_gradient: total(1),
            mean_square_laplacian: total(2),
            mean_square_gradient_of_short_waves: total(3),
            waves: sum(1).powi(2) / sum(4),
        }
    }
}
