use std::collections::VecDeque;

use gfmd_field::Transform;
use gfmd_relax::{Ending, Progress, Watch, Why};
use gfmd_vector::{dot, for_each, reduce};
use num_complex::Complex64;

use crate::memory::{Memory, higher};

/// Search for the flux Q₁ into the body at the heated points: (K₁ + K₂) Q₁ = K₂ Q there, with the kernels K₁ of the
/// body and K₂ of the indenter.
///
/// The matrix is positive definite, but not symmetric. The method is generalised conjugate residuals: each direction is
/// conjugate to the previous ones, and the step along it minimises the residual in the norm of a symmetric
/// preconditioner. The preconditioned matrix is positive definite in this norm, hence every step reduces the residual,
/// however many directions are kept (Eisenstat, Elman, Schultz, SIAM J. Numer. Anal. 20 (1983) 345).
pub(crate) struct Search<'a> {
    memory: Memory<'a>,
    body: &'a [Complex64],
    indenter: &'a [f64],
    /// Indices of the heated points.
    points: Vec<usize>,
    /// Temperature of the indenter if all heat flows into it.
    alone: Vec<f64>,
    /// Flux into the body.
    taken: Vec<f64>,
    /// Temperature of the indenter minus temperature of the body.
    residual: Vec<f64>,
    /// Preconditioned residual.
    ahead: Vec<f64>,
    /// Preconditioner of the uniform flux, equal to the value for the longest wave.
    uniform: f64,
    kept: VecDeque<Direction>,
    pub(crate) iterations: u64,
    pub(crate) transform_pairs: f64,
}

/// Direction: step, change of the residual along it, preconditioned change, and scalar product of both changes.
#[derive(Default)]
struct Direction {
    step: Vec<f64>,
    change: Vec<f64>,
    conditioned: Vec<f64>,
    square: f64,
}

/// Number of directions to which the next one is conjugate.
const DEPTH: usize = 12;
/// Number of steps within which the residual must halve.
const STEPS_TO_HALVE: u64 = 200;

impl<'a> Search<'a> {
    /// Starts a search for the part of a `flux` that flows into the body, from zero.
    pub(crate) fn new(transform: &'a Transform, body: &'a [Complex64], indenter: &'a [f64], flux: &[f64]) -> Self {
        let points: Vec<usize> = (0..flux.len()).filter(|i| flux[*i] > 0.0).collect();
        let grid = transform.grid();
        let longest = (1..grid.spectrum_len())
            .min_by(|a, b| grid.mode_at(*a).wavenumber().total_cmp(&grid.mode_at(*b).wavenumber()));
        let mut search = Self {
            memory: Memory::new(transform),
            taken: vec![0.0; points.len()],
            residual: Vec::new(),
            ahead: vec![0.0; points.len()],
            alone: points.iter().map(|i| flux[*i]).collect(),
            uniform: longest.map_or(1.0, |i| conditioner(body[i], indenter[i])),
            points,
            body,
            indenter,
            kept: VecDeque::new(),
            iterations: 0,
            transform_pairs: 0.0,
        };
        let mut alone = search.alone.clone();
        search.convolve(&search.alone.clone(), &mut alone, &|i| indenter[i].into());
        (search.residual, search.alone) = (alone.clone(), alone);
        search
    }

    /// Returns the largest temperature of the indenter if all heat flows into it.
    pub(crate) fn largest(&self) -> f64 {
        largest(&self.alone)
    }

    /// Returns the flux into the body at all points.
    pub(crate) fn at_all_points(&self) -> Vec<f64> {
        let mut field = vec![0.0; self.memory.field.len()];
        self.points.iter().zip(&self.taken).for_each(|(place, taken)| field[*place] = *taken);
        field
    }

    /// Recomputes the residual.
    pub(crate) fn restart(&mut self) {
        let (body, indenter) = (self.body, self.indenter);
        let (taken, mut both) = (std::mem::take(&mut self.taken), std::mem::take(&mut self.residual));
        self.convolve(&taken, &mut both, &|i| body[i] + indenter[i]);
        for_each((&mut both[..], &self.alone[..]), &|_, (both, alone)| {
            both.iter_mut().zip(alone).for_each(|(both, alone)| *both = alone - *both);
        });
        (self.taken, self.residual) = (taken, both);
    }

    /// Computes `out` at the heated points from `values` there, with each mode multiplied by its factor.
    fn convolve(&mut self, values: &[f64], out: &mut [f64], factor: &(impl Fn(usize) -> Complex64 + Sync)) {
        let Self { memory, points, .. } = self;
        memory.field.fill(0.0);
        points.iter().zip(values).for_each(|(place, value)| memory.field[*place] = *value);
        memory.apply(factor);
        for_each((&mut *out, &points[..]), &|_, (out, points)| {
            out.iter_mut().zip(points).for_each(|(out, place)| *out = memory.field[*place]);
        });
        self.transform_pairs += 1.0;
    }

    fn precondition(&mut self, values: &[f64], out: &mut [f64]) {
        let (body, indenter, uniform) = (self.body, self.indenter, self.uniform);
        self.convolve(values, out, &|i| if i == 0 { uniform } else { conditioner(body[i], indenter[i]) }.into());
    }

    /// Iterates until the largest residual is at most `target`.
    pub(crate) fn run(&mut self, target: f64, most: u64, watch: &mut dyn Watch) -> Ending {
        let (body, indenter) = (self.body, self.indenter);
        let mut ahead = std::mem::take(&mut self.ahead);
        let residual = std::mem::take(&mut self.residual);
        self.precondition(&residual, &mut ahead);
        (self.ahead, self.residual) = (ahead, residual);
        let (mut halved, mut since) = (f64::INFINITY, 0);
        loop {
            let found = largest(&self.residual);
            if found <= target {
                return Ending::Converged;
            }
            let now = Progress { iteration: self.iterations, residual: found / self.largest() };
            if watch.see(&now).is_break() {
                return Ending::Interrupted;
            }
            if self.iterations >= most {
                return Ending::GaveUp(Why::Iterations);
            }
            since += 1;
            if found <= 0.5 * halved {
                (halved, since) = (found, 0);
            } else if since > STEPS_TO_HALVE {
                return Ending::GaveUp(Why::Rounding);
            }
            let mut next = if self.kept.len() == DEPTH { self.kept.pop_front() } else { None }.unwrap_or_default();
            next.step.clone_from(&self.ahead);
            next.change.resize(self.points.len(), 0.0);
            next.conditioned.resize(self.points.len(), 0.0);
            self.convolve(&next.step, &mut next.change, &|i| body[i] + indenter[i]);
            self.precondition(&next.change, &mut next.conditioned);
            for old in &self.kept {
                next.less(old, dot(&next.change, &old.conditioned) / old.square);
            }
            next.square = dot(&next.change, &next.conditioned);
            let length = dot(&self.residual, &next.conditioned) / next.square;
            if !(next.square > 0.0 && length.is_finite()) {
                return Ending::GaveUp(Why::Direction);
            }
            let vectors = ([&mut self.taken[..], &mut self.residual[..], &mut self.ahead[..]], next.vectors());
            for_each(vectors, &|_, ([taken, residual, ahead], [step, change, conditioned])| {
                taken.iter_mut().zip(step).for_each(|(taken, step)| *taken += length * step);
                residual.iter_mut().zip(change).for_each(|(residual, change)| *residual -= length * change);
                ahead.iter_mut().zip(conditioned).for_each(|(ahead, by)| *ahead -= length * by);
            });
            self.kept.push_back(next);
            self.iterations += 1;
        }
    }
}

impl Direction {
    fn vectors(&self) -> [&[f64]; 3] {
        [&self.step, &self.change, &self.conditioned]
    }

    /// Subtracts `times` times another direction.
    fn less(&mut self, other: &Self, times: f64) {
        let own = [&mut self.step[..], &mut self.change[..], &mut self.conditioned[..]];
        for_each((own, other.vectors()), &|_, (own, other)| {
            for (own, other) in own.into_iter().zip(other) {
                own.iter_mut().zip(other).for_each(|(own, other)| *own -= times * other);
            }
        });
    }
}

/// Returns the preconditioner of a mode: the real part of 1/(K₁ + K₂).
fn conditioner(body: Complex64, indenter: f64) -> f64 {
    (1.0 / (body + indenter)).re
}

fn largest(values: &[f64]) -> f64 {
    reduce(values.len(), &|range| range.map(|i| values[i].abs()).fold(0.0, higher), &higher)
}
