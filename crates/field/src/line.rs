//! One-dimensional grids, a line or a single row: one transform on the calling thread.

use std::sync::Arc;

use gfmd_vector::Split;
use num_complex::Complex;
use realfft::{ComplexToReal, RealToComplex};

use crate::Real;
use crate::plane::energy;
use crate::real::square;

/// Number of modes in one partial sum of an energy.
const STRETCH: usize = 1 << 10;

/// Plans for one row. A field may fill only the first points; it is zero on the others.
pub(crate) struct Line<T> {
    points: usize,
    shown: usize,
    to_half: Arc<dyn RealToComplex<T>>,
    from_half: Arc<dyn ComplexToReal<T>>,
}

/// Working memory: a field and its spectrum.
#[derive(Default)]
pub(crate) struct Memory<T> {
    field: Vec<T>,
    half: Vec<Complex<T>>,
    scratch: Vec<Complex<T>>,
}

impl<T: Real> Line<T> {
    /// Creates plans for fields that fill the first `shown` points.
    pub(crate) fn new(points: usize, shown: usize) -> Self {
        let (to_half, from_half) = T::real(points);
        Self { points, shown, to_half, from_half }
    }

    pub(crate) fn memory(&self) -> Memory<T> {
        let scratch = self.to_half.get_scratch_len().max(self.from_half.get_scratch_len());
        Memory {
            field: vec![T::ZERO; self.points],
            half: vec![Complex::ZERO; self.points / 2 + 1],
            scratch: vec![Complex::ZERO; scratch],
        }
    }

    /// Computes the spectrum f̃ of the row that `source` fills.
    pub(crate) fn forward(
        &self,
        source: &impl Fn(usize, &mut [T]),
        spectrum: &mut [Complex<T>],
        memory: &mut Memory<T>,
    ) {
        self.ahead(source, memory);
        let scale = self.scale();
        for (to, from) in spectrum.iter_mut().zip(&memory.half) {
            *to = from * scale;
        }
    }

    /// Computes the field of the spectrum.
    pub(crate) fn inverse(&self, spectrum: &[Complex<T>], field: &mut [T], memory: &mut Memory<T>) {
        memory.half.copy_from_slice(spectrum);
        self.back(memory);
        field.copy_from_slice(&memory.field[..self.shown]);
    }

    /// Computes the half spectrum of K f for the row f that `source` fills from `input`.
    pub(crate) fn convolve<I: Split>(
        &self,
        kernel: &[T],
        input: I,
        source: &impl Fn(usize, I, &mut [T]),
        memory: &mut Memory<T>,
    ) {
        self.ahead(|i, row: &mut [T]| source(i, input, row), memory);
        let scale = self.scale();
        for (mode, k) in memory.half.iter_mut().zip(kernel) {
            *mode *= *k * scale;
        }
    }

    /// Transforms the half spectrum back and passes the row to `sink` with `output`.
    pub(crate) fn row_back<O: Split>(&self, output: O, sink: &impl Fn(usize, &mut [T], O), memory: &mut Memory<T>) {
        self.back(memory);
        sink(0, &mut memory.field[..self.shown], output);
    }

    /// Returns Σ_q w k |f̃|² for the row that `source` fills.
    pub(crate) fn quadratic_form(
        &self,
        kernel: &[T],
        source: &impl Fn(usize, &mut [T]),
        memory: &mut Memory<T>,
    ) -> f64 {
        self.ahead(source, memory);
        let stretches = memory.half.chunks(STRETCH).zip(kernel.chunks(STRETCH));
        let all: f64 = stretches.map(|(modes, kernel)| energy(modes, kernel)).sum();
        let last = self.points / 2;
        let alone = |number: usize| kernel[number].widened() * square(&memory.half[number]);
        let once = alone(0) + if last > 0 && self.points.is_multiple_of(2) { alone(last) } else { 0.0 };
        (2.0 * all - once) * (1.0 / self.points as f64).powi(2)
    }

    /// Computes the spectrum of an even kernel, for fields on the first points. `source` fills the values at the
    /// distances 0, 1, …; beyond these the kernel is zero.
    pub(crate) fn even(&self, source: &impl Fn(usize, &mut [T]), memory: &mut Memory<T>) -> Vec<T> {
        let (near, far) = memory.field.split_at_mut(self.shown);
        source(0, near);
        far.fill(T::ZERO);
        far.iter_mut().rev().zip(&near[1..]).for_each(|(far, near)| *far = *near);
        self.transform(memory);
        memory.half.iter().map(|mode| mode.re).collect()
    }

    fn ahead(&self, source: impl FnOnce(usize, &mut [T]), memory: &mut Memory<T>) {
        let (own, padding) = memory.field.split_at_mut(self.shown);
        source(0, own);
        padding.fill(T::ZERO);
        self.transform(memory);
    }

    fn transform(&self, memory: &mut Memory<T>) {
        let done = self.to_half.process_with_scratch(&mut memory.field, &mut memory.half, &mut memory.scratch);
        done.expect("lengths are those of the plan");
    }

    fn back(&self, memory: &mut Memory<T>) {
        memory.half[0].im = T::ZERO;
        if self.points.is_multiple_of(2) {
            memory.half[self.points / 2].im = T::ZERO;
        }
        let done = self.from_half.process_with_scratch(&mut memory.half, &mut memory.field, &mut memory.scratch);
        done.expect("lengths are those of the plan, edges are real");
    }

    fn scale(&self) -> T {
        T::nearest(1.0 / self.points as f64)
    }
}
