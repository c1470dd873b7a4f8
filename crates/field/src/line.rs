//! One-dimensional grids, a line or a single row: one transform, on the calling thread.

use std::sync::Arc;

use num_complex::Complex64;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};

use crate::plane::energy;

/// The number of modes in one partial sum of an energy.
const STRETCH: usize = 1 << 10;

/// Plans for one row. A field may fill its first points only, and is zero on the others.
pub(crate) struct Line {
    points: usize,
    shown: usize,
    to_half: Arc<dyn RealToComplex<f64>>,
    from_half: Arc<dyn ComplexToReal<f64>>,
}

/// Working memory: a field and its spectrum.
#[derive(Default)]
pub(crate) struct Memory {
    field: Vec<f64>,
    half: Vec<Complex64>,
    scratch: Vec<Complex64>,
}

impl Line {
    pub(crate) fn new(points: usize) -> Self {
        Self::padded(points, points)
    }

    /// Plans for fields that fill the first `shown` points.
    pub(crate) fn padded(points: usize, shown: usize) -> Self {
        let mut planner = RealFftPlanner::new();
        Self { points, shown, to_half: planner.plan_fft_forward(points), from_half: planner.plan_fft_inverse(points) }
    }

    pub(crate) fn memory(&self) -> Memory {
        let scratch = self.to_half.get_scratch_len().max(self.from_half.get_scratch_len());
        Memory {
            field: vec![0.0; self.points],
            half: vec![Complex64::ZERO; self.points / 2 + 1],
            scratch: vec![Complex64::ZERO; scratch],
        }
    }

    /// Writes the spectrum f̃ of the row that `source` fills.
    pub(crate) fn forward(&self, source: &impl Fn(usize, &mut [f64]), spectrum: &mut [Complex64], memory: &mut Memory) {
        self.ahead(source, memory);
        let scale = self.scale();
        for (to, from) in spectrum.iter_mut().zip(&memory.half) {
            *to = from * scale;
        }
    }

    /// Writes the field of the spectrum.
    pub(crate) fn inverse(&self, spectrum: &[Complex64], field: &mut [f64], memory: &mut Memory) {
        memory.half.copy_from_slice(spectrum);
        self.back(field, memory);
    }

    /// Writes K f of the row that `source` fills; `sink` gets the result.
    pub(crate) fn convolve(
        &self,
        kernel: &[f64],
        source: &impl Fn(usize, &mut [f64]),
        out: &mut [f64],
        sink: &impl Fn(usize, &mut [f64]),
        memory: &mut Memory,
    ) {
        self.ahead(source, memory);
        let scale = self.scale();
        for (mode, k) in memory.half.iter_mut().zip(kernel) {
            *mode *= k * scale;
        }
        self.back(out, memory);
        sink(0, out);
    }

    /// Returns Σ_q w k |f̃|² of the row that `source` fills.
    pub(crate) fn quadratic_form(
        &self,
        kernel: &[f64],
        source: &impl Fn(usize, &mut [f64]),
        memory: &mut Memory,
    ) -> f64 {
        self.ahead(source, memory);
        let stretches = memory.half.chunks(STRETCH).zip(kernel.chunks(STRETCH));
        let all: f64 = stretches.map(|(modes, kernel)| energy(modes, kernel)).sum();
        let last = self.points / 2;
        let alone = |number: usize| kernel[number] * memory.half[number].norm_sqr();
        let once = alone(0) + if last > 0 && self.points.is_multiple_of(2) { alone(last) } else { 0.0 };
        (2.0 * all - once) * self.scale().powi(2)
    }

    /// The spectrum of an even kernel, for fields on the first points. `source` fills the values at the distances 0, 1, …;
    /// beyond these the kernel is zero.
    pub(crate) fn even(&self, source: &impl Fn(usize, &mut [f64]), memory: &mut Memory) -> Vec<f64> {
        let (near, far) = memory.field.split_at_mut(self.shown);
        source(0, near);
        far.fill(0.0);
        far.iter_mut().rev().zip(&near[1..]).for_each(|(far, near)| *far = *near);
        self.transform(memory);
        memory.half.iter().map(|mode| mode.re).collect()
    }

    fn ahead(&self, source: &impl Fn(usize, &mut [f64]), memory: &mut Memory) {
        let (own, padding) = memory.field.split_at_mut(self.shown);
        source(0, own);
        padding.fill(0.0);
        self.transform(memory);
    }

    fn transform(&self, memory: &mut Memory) {
        let done = self.to_half.process_with_scratch(&mut memory.field, &mut memory.half, &mut memory.scratch);
        done.expect("lengths are those of the plan");
    }

    fn back(&self, field: &mut [f64], memory: &mut Memory) {
        memory.half[0].im = 0.0;
        if self.points.is_multiple_of(2) {
            memory.half[self.points / 2].im = 0.0;
        }
        let is_whole = field.len() == self.points;
        let whole = if is_whole { &mut *field } else { &mut memory.field[..] };
        let done = self.from_half.process_with_scratch(&mut memory.half, whole, &mut memory.scratch);
        done.expect("lengths are those of the plan, edges are real");
        if !is_whole {
            field.copy_from_slice(&memory.field[..field.len()]);
        }
    }

    fn scale(&self) -> f64 {
        1.0 / self.points as f64
    }
}
