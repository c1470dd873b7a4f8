//! Potentials of cells by preconditioned conjugate gradients.

use gfmd_vector::pass;

use crate::cells::{Balance, Cells, Potential, larger};
use crate::elimination::{Elimination, Work};
use crate::flow::Wanted;
use crate::graph::Graph;
use crate::tree::Tree;

/// Largest [residual](crate::Flow::residual) of a converged flow.
pub const TOLERANCE: f64 = 1e-8;

/// Largest number of iterations; about 15 are usual, and 50 for fields.
const ITERATIONS: usize = 1000;

/// Largest number of rounds of iterations, each started from recomputed balances.
const ROUNDS: usize = 12;

/// Error reduction of a round at which rounding errors dominate.
const REDUCTION: f64 = 1e-12;

/// Fraction of the tolerance left by the first round; each further round leaves this fraction of the previous value.
const MARGIN: f64 = 0.3;

/// The bound along the tree is computed when this fraction of its last value, in proportion, would be enough.
const CAUTION: f64 = 0.5;

/// Least ratio of a bound along the tree to the product of residual and step one iteration before.
const LEAST_RATIO: f64 = 0.02;

/// Quantity that ends a search.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rule {
    /// Distance between the bounds of the conductivity.
    Bounds,
    /// Flow missing in single cells.
    Cells,
}

/// Result of a search for a gradient.
pub(crate) struct Found {
    pub(crate) potential: Vec<Potential>,
    pub(crate) balance: Balance,
    /// Upper bound of the power per area when the bounds were close enough.
    pub(crate) power: f64,
    /// Distance to the lower bound, as a fraction of the tolerated distance over the tolerance.
    pub(crate) residual: f64,
}

/// Result of a search under several gradients.
pub(crate) struct Search<const N: usize> {
    pub(crate) found: [Found; N],
    /// Power per area of the flow of the first gradient along the falls of the last one.
    pub(crate) shared: f64,
    pub(crate) iterations: usize,
}

/// Solves for the potentials of cells with the same equations under different gradients until the bounds of their
/// powers are close, and then, for fields, until each cell is in balance under the first gradients that lie along the
/// reservoirs. Conjugate gradients are restarted from recomputed balances.
pub(crate) fn search<const N: usize>(cells: [&Cells; N], wanted: Wanted) -> Search<N> {
    let mut round = Round::new(cells);
    let mut found = cells.map(|cells| {
        let potential = vec![Potential::default(); cells.len()];
        Found { balance: cells.balance(&potential), potential, power: f64::NAN, residual: f64::NAN }
    });
    let power_of_both = |found: &[Found; N]| {
        let [first, last] = [0, N - 1].map(|k| &found[k].potential);
        cells[0].shared(first, cells[N - 1], last)
    };
    let (mut rule, mut margin, mut iterations, mut shared) = (Rule::Bounds, MARGIN, 0, None);
    for last in (0..=ROUNDS).rev() {
        let missing = found.each_mut().map(|found| std::mem::take(&mut found.balance.missing));
        let power = found.each_ref().map(|found| found.balance.power);
        let taken = round.start(&missing);
        if rule == Rule::Bounds {
            let distances = gfmd_vector::add(taken, round.bound());
            for k in 0..N {
                found[k].power = power[k];
                found[k].residual = distances[k] / round.scale(k, &power);
            }
            if found.iter().all(|found| found.residual <= TOLERANCE) {
                shared = Some(power_of_both(&found));
                (rule, margin) = (Rule::Cells, MARGIN);
            }
        }
        let balanced = |(cells, found): (&&Cells, &Found)| cells.is_across() || found.balance.residual <= TOLERANCE;
        let done = rule == Rule::Cells && (wanted == Wanted::Conductivity || cells.iter().zip(&found).all(balanced));
        if done || last == 0 || iterations >= ITERATIONS {
            break;
        }
        let corrections = round.solve(&missing, taken, power, (rule, margin), &mut iterations);
        for (k, (cells, found)) in cells.iter().zip(&mut found).enumerate() {
            pass(
                (&mut found.potential[..], &corrections[..]),
                &|_, (potential, corrections): (&mut [Potential], &[[f64; N]])| {
                    potential.iter_mut().zip(corrections).for_each(|(potential, by)| potential.add(by[k]));
                },
                &|(), ()| (),
            );
            found.balance = cells.balance(&found.potential);
        }
        margin *= MARGIN;
    }
    Search { shared: shared.unwrap_or_else(|| power_of_both(&found)), found, iterations }
}

/// Equations of a round and its vectors, with one column per gradient.
struct Round<'a, const N: usize> {
    cells: [&'a Cells<'a>; N],
    graph: Graph,
    factors: Elimination,
    tree: Tree,
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
        let (factors, tree) = rayon::join(|| Elimination::of(&graph, cells[0].numbering()), || Tree::of(&graph));
        let work = factors.work();
        let [residual, step, direction, image, correction] = std::array::from_fn(|_| vec![[0.0; N]; graph.len()]);
        Self { cells, graph, factors, tree, work, residual, step, direction, image, correction }
    }

    /// Starts from the flow `missing` into each cell; returns the power taken up by the eliminated cells.
    fn start(&mut self, missing: &[Vec<f64>; N]) -> [f64; N] {
        self.cells[0].fold(missing, &mut self.residual)
    }

    /// Returns upper bounds of the power that the remaining flow into the cells costs.
    fn bound(&mut self) -> [f64; N] {
        self.tree.bound(&self.residual, &mut self.image)
    }

    /// Returns the power that the distance between the bounds of gradient `k` is compared with. Across the reservoirs
    /// the flow may vanish.
    fn scale(&self, k: usize, power: &[f64; N]) -> f64 {
        self.cells[0].area() * if self.cells[k].is_across() { larger(power[0], power[k]) } else { power[k] }
    }

    /// Computes corrections for the flow `missing` into each cell. `power` is the power before the corrections, and
    /// `taken` the part that the eliminated cells take up.
    fn solve(
        &mut self,
        missing: &[Vec<f64>; N],
        taken: [f64; N],
        mut power: [f64; N],
        (rule, margin): (Rule, f64),
        iterations: &mut usize,
    ) -> Vec<[f64; N]> {
        let area = self.cells[0].area();
        // Each iteration lowers the power by a known amount. The remaining power gives the flow, and hence the flow
        // that may be missing in a cell.
        (0..N).for_each(|k| power[k] -= taken[k] / area);
        self.correction.fill([0.0; N]);
        let (mut first, mut last) = ([0.0; N], [0.0; N]);
        // Bounds from the tree, over the products of residual and step one iteration before.
        let mut ratios = [LEAST_RATIO; N];
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
            let exhausted = |k: usize| slope[k] <= REDUCTION * REDUCTION * first[k];
            let allowed: [f64; N] = std::array::from_fn(|k| margin * TOLERANCE * self.scale(k, &power));
            let enough = match rule {
                Rule::Bounds => {
                    (0..N).all(|k| ratios[k] * slope[k] <= allowed[k]) && {
                        let bounds = self.bound();
                        ratios = std::array::from_fn(|k| larger(LEAST_RATIO, CAUTION * quotient(bounds[k], slope[k])));
                        (0..N).all(|k| bounds[k] <= allowed[k])
                    }
                }
                Rule::Cells => (0..N).all(|k| {
                    let allowed = margin * TOLERANCE * power[k] * self.cells[k].width();
                    self.cells[k].is_across() || exhausted(k) || largest[k] <= allowed
                }),
            };
            if enough || (0..N).all(exhausted) {
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
