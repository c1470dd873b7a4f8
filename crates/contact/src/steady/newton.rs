//! Semismooth Newton search (theory.md, section 7.8).

use std::ops::ControlFlow;

use gfmd_relax::{Budget, Ending, Progress, Upper, Watch, Why};
use gfmd_response::ComplexTransforms;
use gfmd_vector::{add, for_each, pass, reduce, total};
use num_complex::Complex64;

use super::SteadyContact;
use super::krylov::Krylov;
use crate::attempt::MARGIN;
use crate::{Contact, Effort, Fields as _, Load, Solution};

/// Number of steps within which the residual must halve.
const STEPS_TO_HALVE: u32 = 10;
/// Residual, relative to its value when the displacement was last computed from the pressure, at which it is computed
/// anew: rounding errors of single precision are relative to the steps.
const REFRESH: f64 = 1e-4;
/// Largest number of passes that raise free pressures to a load without exceeding the hardness.
const RAISES: usize = 20;

/// Relative error of a load that counts as rounding.
const ROUNDING: f64 = 1e-14;

/// Search for a steady state, in the units of the contact.
pub(super) struct Newton<'a> {
    contact: &'a Contact,
    load: Load,
    upper: Upper,
    /// Complex compliance of each mode, with the uniform mode if it takes part.
    compliance: Vec<Complex64>,
    /// Stiffness of the uniform mode in the preconditioner, with its compliance, if it takes part.
    uniform: Option<[f64; 2]>,
    transforms: ComplexTransforms<f64>,
    pressure: Vec<f64>,
    /// Downward displacement.
    indentation: Vec<f64>,
    /// 1 at free points, where the gap must close, and 0 elsewhere.
    free: Vec<f64>,
    iterations: u64,
}

impl<'a> Newton<'a> {
    pub(super) fn new(steady: &'a SteadyContact, load: Load, pressure: Vec<f64>) -> Self {
        let contact = &steady.contact;
        let mut compliance = steady.compliance();
        let uniform = contact.level_under(load);
        if let Some([uniform, _]) = uniform {
            compliance[0] = uniform.into();
        }
        Self {
            contact,
            load,
            upper: contact.upper(),
            compliance,
            uniform,
            transforms: ComplexTransforms::new(*contact.response.grid()),
            indentation: vec![0.0; pressure.len()],
            free: vec![0.0; pressure.len()],
            pressure,
            iterations: 0,
        }
    }

    /// Returns the state of the pressure, from fresh transforms.
    pub(super) fn certified(mut self) -> Solution {
        self.indent();
        self.state()
    }

    /// Computes the displacement of the pressure.
    fn indent(&mut self) {
        self.transforms.convolve(&self.compliance, &self.pressure, &mut self.indentation);
    }

    /// Returns the state of pressure and displacement, with its residuals.
    fn state(&self) -> Solution {
        let sinking = match self.load {
            Load::Approach(_) => 0.0,
            Load::MeanPressure(_) => self.contact.uniform_compliance() * self.mean(),
        };
        let displacement = self.indentation.iter().map(|indentation| -indentation).collect();
        let mut state = self.contact.state_of((self.pressure.clone(), displacement), sinking, self.load);
        state.effort = Effort { iterations: self.iterations, transform_pairs: self.transforms.pairs() };
        state
    }

    fn mean(&self) -> f64 {
        total(&self.pressure) / self.pressure.len() as f64
    }

    /// Returns the number of free points, and the approach: the mean of clearance and displacement over them, unless
    /// it is prescribed.
    fn level(&self) -> (f64, f64) {
        let (clearance, indentation, free) = (self.contact.scaled.clearance(), &self.indentation, &self.free);
        let [count, room] = reduce(
            free.len(),
            &|range| range.fold([0.0; 2], |sums, i| add(sums, [free[i], free[i] * (clearance.at(i) + indentation[i])])),
            &add,
        );
        match self.load {
            Load::Approach(approach) => (count, approach),
            Load::MeanPressure(_) => (count, room / count),
        }
    }

    /// Moves the points between open, free and full, and the pressure to its bounds and the load. Returns true if the
    /// displacement belongs to another pressure.
    fn sort(&mut self) -> bool {
        let (_, approach) = self.level();
        let Self { contact, upper, pressure, indentation, free, .. } = self;
        let clearance = contact.scaled.clearance();
        let (indentation, upper) = (&indentation[..], upper.ceiling());
        let moved = pass(
            (&mut pressure[..], &mut free[..]),
            &|start, (pressure, free)| {
                let mut moved = false;
                for (k, (p, free)) in pressure.iter_mut().zip(free).enumerate() {
                    let (i, before) = (start + k, *p);
                    let (gap, most) = (clearance.at(i) + indentation[i] - approach, upper.at(i));
                    *p = p.clamp(0.0, most);
                    let is_free = match *free == 1.0 {
                        true => *p > 0.0 && *p < most,
                        false if *p == 0.0 => gap < 0.0,
                        false => gap > 0.0 || *p < most,
                    };
                    *free = if is_free { 1.0 } else { 0.0 };
                    moved |= *p != before;
                }
                moved
            },
            &|a, b| a | b,
        );
        self.meet_load(moved)
    }

    /// Raises or lowers the free pressures to the load.
    fn meet_load(&mut self, moved: bool) -> bool {
        let Load::MeanPressure(mean) = self.load else { return moved };
        let (upper, n) = (self.upper.clone(), self.pressure.len());
        if !upper.ceiling().is_finite() {
            // The displacement is proportional to the pressure.
            let factor = mean / self.mean();
            for_each((&mut self.pressure[..], &mut self.indentation[..]), &|_, (pressure, indentation)| {
                pressure.iter_mut().chain(indentation).for_each(|value| *value *= factor);
            });
            return moved;
        }
        let mut moved = moved;
        for _ in 0..RAISES {
            let (pressure, free) = (&self.pressure, &self.free);
            let [all, of_free] = reduce(
                n,
                &|range| range.fold([0.0; 2], |sums, i| add(sums, [pressure[i], free[i] * pressure[i]])),
                &add,
            );
            let missing = mean * n as f64 - all;
            if missing.abs() <= ROUNDING * all || of_free == 0.0 {
                break;
            }
            let factor = 1.0 + missing / of_free;
            // The full points alone carry more than the load.
            let all_yield = factor <= 0.0;
            let factor = if all_yield { mean * n as f64 / all } else { factor };
            let ceiling = upper.ceiling();
            for_each((&mut self.pressure[..], &mut self.free[..]), &|start, (pressure, free)| {
                for (k, (p, free)) in pressure.iter_mut().zip(free).enumerate() {
                    if *free == 1.0 || all_yield {
                        *p = (*p * factor).min(ceiling.at(start + k));
                        *free = if *p > 0.0 && *p < ceiling.at(start + k) || *p == 0.0 { *free } else { 0.0 };
                    }
                    if all_yield && *p > 0.0 {
                        *free = 1.0;
                    }
                }
            });
            moved = true;
        }
        moved
    }

    /// Returns the residual gap at the free points divided by its norm, and the norm.
    fn residual(&self) -> (Vec<f32>, f64) {
        let (_, approach) = self.level();
        let (clearance, indentation, free) = (self.contact.scaled.clearance(), &self.indentation, &self.free);
        let gap = |i: usize| free[i] * (clearance.at(i) + indentation[i] - approach);
        let norm = gfmd_vector::sum(free.len(), &|range| range.map(|i| gap(i).powi(2)).sum()).sqrt();
        let mut residual = vec![0.0_f32; free.len()];
        for_each(&mut residual[..], &|start, residual: &mut [f32]| {
            residual.iter_mut().enumerate().for_each(|(k, r)| *r = (gap(start + k) / norm) as f32);
        });
        (residual, norm)
    }

    /// Marks the points between the bounds as free.
    fn mark(&mut self) {
        let upper = self.upper.ceiling();
        for_each((&mut self.free[..], &self.pressure[..]), &|start, (free, pressure)| {
            for (k, (free, p)) in free.iter_mut().zip(pressure).enumerate() {
                *free = if *p > 0.0 && *p < upper.at(start + k) { 1.0 } else { 0.0 };
            }
        });
    }

    /// Runs the search. It gives up by [`Why::Certificate`] if the residual does not halve.
    pub(super) fn run(&mut self, budget: &Budget, watch: &mut dyn Watch) -> (Solution, Ending) {
        let mut krylov = Krylov::new(self.contact, self.load, &self.compliance, self.uniform);
        self.mark();
        if self.meet_load(self.has_relief()) {
            self.indent();
        }
        // True if the displacement was computed from the pressure, and the residual when it last was.
        let (mut is_fresh, mut from) = (true, f64::INFINITY);
        let (mut halved, mut since) = (f64::INFINITY, 0);
        let mut best: Option<Solution> = None;
        let ending = loop {
            if self.sort() {
                self.indent();
                is_fresh = true;
            }
            let mut state = self.state();
            if !is_fresh && state.worst() <= (MARGIN * budget.tolerance).max(REFRESH * from) {
                self.indent();
                (state, is_fresh) = (self.state(), true);
            }
            let worst = state.worst();
            if is_fresh {
                from = worst;
                if best.as_ref().is_none_or(|best| worst < best.worst()) {
                    best = Some(state);
                }
                if worst <= budget.tolerance {
                    break Ending::Converged;
                }
            }
            let progress = Progress { iteration: self.iterations, residual: worst };
            if let ControlFlow::Break(()) = watch.see(&progress) {
                break Ending::Interrupted;
            }
            if self.iterations >= budget.max_iterations {
                break Ending::GaveUp(Why::Iterations);
            }
            since += 1;
            if worst <= 0.5 * halved {
                (halved, since) = (worst, 0);
            } else if since > STEPS_TO_HALVE {
                break Ending::GaveUp(Why::Certificate);
            }
            let (residual, norm) = self.residual();
            if norm > 0.0 {
                let step = krylov.step(&self.free, residual);
                step.add(-norm, &mut self.pressure, &mut self.indentation);
                self.iterations += step.vectors() as u64;
                is_fresh = false;
            }
        };
        if !is_fresh {
            self.indent();
        }
        let last = self.state();
        let mut state = best.filter(|best| best.worst() <= last.worst() || last.worst().is_nan()).unwrap_or(last);
        state.effort.iterations = self.iterations;
        state.effort.transform_pairs = self.transforms.pairs() + krylov.pairs();
        (state, ending)
    }

    /// Returns true if the pressure makes a displacement other than the uniform one, which a load ignores.
    fn has_relief(&self) -> bool {
        let first = self.pressure[0];
        let differs = |range: std::ops::Range<usize>| range.into_iter().any(|i| self.pressure[i] != first);
        first != 0.0 && matches!(self.load, Load::Approach(_)) || reduce(self.pressure.len(), &differs, &|a, b| a | b)
    }
}
