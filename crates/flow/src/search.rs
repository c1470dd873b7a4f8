//! Potentials of cells by preconditioned conjugate gradients.

use gfmd_vector::pass;

use crate::cells::{Balance, Cells, Potential, larger};
use crate::elimination::{Elimination, Work};
use crate::graph::Graph;

/// Largest [residual](crate::Flow::residual) of a converged flow.
pub const TOLERANCE: f64 = 1e-8;

/// Largest number of iterations; about 50 are usual.
const ITERATIONS: usize = 1000;

/// Largest number of rounds of iterations, each started from recomputed balances.
const ROUNDS: usize = 12;

/// Error reduction of a round at which rounding errors dominate.
const REDUCTION: f64 = 1e-12;

/// Fraction of the tolerance left by the first round; each further round leaves this fraction of the previous value.
const MARGIN: f64 = 0.3;

/// Result of a search.
pub(crate) struct Found {
    pub(crate) potential: Vec<Potential>,
    pub(crate) balance: Balance,
}

/// Solves for the potentials of cells with the same equations under different gradients, and returns them with the
/// number of iterations. Conjugate gradients are restarted from recomputed balances.
pub(crate) fn search<const N: usize>(cells: [&Cells; N]) -> ([Found; N], usize) {
    let mut round = Round::new(cells);
    let mut found = cells.map(|cells| {
        let potential = vec![Potential::default(); cells.len()];
        Found { balance: cells.balance(&potential), potential }
    });
    let (mut margin, mut iterations) = (MARGIN, 0);
    for _ in 0..ROUNDS {
        let missing = found.each_mut().map(|found| std::mem::take(&mut found.balance.missing));
        let power = found.each_ref().map(|found| found.balance.power);
        let corrections = round.solve(&missing, power, margin, &mut iterations);
        let mut done = true;
        for (k, (cells, found)) in cells.iter().zip(&mut found).enumerate() {
            pass(
                (&mut found.potential[..], &corrections[..]),
                &|_, (potential, corrections): (&mut [Potential], &[[f64; N]])| {
                    potential.iter_mut().zip(corrections).for_each(|(potential, by)| potential.add(by[k]));
                },
                &|(), ()| (),
            );
            found.balance = cells.balance(&found.potential);
            done &= found.balance.residual <= TOLERANCE;
        }
        margin *= MARGIN;
        if done || iterations >= ITERATIONS {
            break;
        }
    }
    (found, iterations)
}

/// Equations of a round and its vectors, with one column per gradient.
struct Round<'a, const N: usize> {
    cells: [&'a Cells<'a>; N],
    graph: Graph,
    factors: Elimination,
    work: Work<N>,
    residual: Vec<[f64; N]>,
    step: Vec<[f64; N]>,
    direction: Vec<[f64; N]>,
    image: Vec<[f64; N]>,
    correction: Vec<[f64; N]>,
}

impl<'a, const N: usize> Round<'a, N> {
    fn new(cells: [&'a Cells<'a>; N]) -> Self {
        let graph = cells[0].graph();
        let factors = Elimination::of(&graph, cells[0].numbering());
        let work = factors.work();
        let [residual, step, direction, image, correction] = std::array::from_fn(|_| vec![[0.0; N]; graph.len()]);
        Self { cells, graph, factors, work, residual, step, direction, image, correction }
    }

    /// Computes corrections for the flow `missing` into each cell. `power` is the power before the corrections.
    fn solve(
        &mut self,
        missing: &[Vec<f64>; N],
        mut power: [f64; N],
        margin: f64,
        iterations: &mut usize,
    ) -> Vec<[f64; N]> {
        let area = self.cells[0].area();
        let taken = self.cells[0].fold(missing, &mut self.residual);
        // Each iteration lowers the power by a known amount. The remaining power gives the flow, and hence the flow
        // that may be missing in a cell.
        (0..N).for_each(|k| power[k] -= taken[k] / area);
        self.correction.fill([0.0; N]);
        let (mut first, mut last) = ([0.0; N], [0.0; N]);
        while *iterations < ITERATIONS {
            let slope = self.factors.solve(&self.residual, &mut self.step, &mut self.work);
            if last == [0.0; N] {
                first = slope;
                self.direction.copy_from_slice(&self.step);
            } else {
                self.turn(std::array::from_fn(|k| quotient(slope[k], last[k])));
            }
            last = slope;
            let work_done = self.graph.apply(&self.direction, &mut self.image);
            let length = std::array::from_fn(|k| quotient(slope[k], work_done[k]));
            let largest = self.advance(length);
            *iterations += 1;
            (0..N).for_each(|k| power[k] -= length[k] * slope[k] / area);
            let enough = |k: usize| {
                let allowed = margin * TOLERANCE * power[k] * self.cells[k].width();
                slope[k] <= REDUCTION * REDUCTION * first[k] || largest[k] <= allowed
            };
            if (0..N).all(enough) {
                break;
            }
        }
        self.cells[0].expand(missing, &self.correction)
    }

    /// Computes the next direction: the step plus `parts` times the last direction.
    fn turn(&mut self, parts: [f64; N]) {
        pass(
            (&mut self.direction[..], &self.step[..]),
            &|_, (directions, steps): (&mut [[f64; N]], &[[f64; N]])| {
                for (direction, step) in directions.iter_mut().zip(steps) {
                    (0..N).for_each(|k| direction[k] = step[k] + parts[k] * direction[k]);
                }
            },
            &|(), ()| (),
        );
    }

    /// Moves by `lengths` along the direction; returns the largest magnitudes of the remaining flow into a cell.
    fn advance(&mut self, lengths: [f64; N]) -> [f64; N] {
        type Rows<'a, const N: usize> = &'a [[f64; N]];
        pass(
            (&mut self.correction[..], &mut self.residual[..], &self.direction[..], &self.image[..]),
            &|_, (corrections, residuals, directions, images): (&mut [[f64; N]], &mut [[f64; N]], Rows<N>, Rows<N>)| {
                let mut largest = [0.0; N];
                let changed = corrections.iter_mut().zip(residuals);
                for ((correction, residual), (direction, image)) in changed.zip(directions.iter().zip(images)) {
                    for k in 0..N {
                        correction[k] += lengths[k] * direction[k];
                        residual[k] -= lengths[k] * image[k];
                        largest[k] = larger(largest[k], residual[k].abs());
                    }
                }
                largest
            },
            &|a: [f64; N], b: [f64; N]| std::array::from_fn(|k| larger(a[k], b[k])),
        )
    }
}

/// Divides two positive numbers; returns 0 if `b` is zero, when the solution has been found.
fn quotient(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { 0.0 }
}
