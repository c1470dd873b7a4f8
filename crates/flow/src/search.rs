//! Potentials of cells by preconditioned conjugate gradients.

use gfmd_vector::pass;

use crate::cells::{Cells, larger};
use crate::elimination::{Elimination, Work};
use crate::graph::{Drops, Graph, Powers};
use crate::halved::drops;
use crate::potential::Potential;
use crate::tree::Tree;

/// Results that a flow is computed for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wanted {
    /// The conductivity alone. The flow in single cells may still be wrong by a tenth of the mean flow.
    Conductivity,
    /// Potential and flux of every cell, too, which take two to three times the iterations. The conductivity has the
    /// same bits as without them.
    Fields,
}

/// Largest [residual](crate::Flow::residual) of a converged flow.
pub const TOLERANCE: f64 = 1e-8;

/// Largest number of iterations; about 15 are usual, and 50 for fields.
const ITERATIONS: usize = 1000;

/// Largest number of rounds of iterations, each started from recomputed balances.
const ROUNDS: usize = 12;

/// Error reduction of a round at which rounding errors dominate.
const REDUCTION: f64 = 1e-12;

/// Fraction of the tolerated flow missing in a cell that the first round leaves; each further round leaves this
/// fraction of the previous value.
const MARGIN: f64 = 0.3;

/// Fraction of the tolerated distance between the bounds that the first round leaves.
const MARGIN_OF_BOUNDS: f64 = 0.9;

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
#[derive(Default)]
pub(crate) struct Found {
    /// Upper bound of the power per area when the bounds were close enough.
    pub(crate) power: f64,
    /// Distance to the lower bound, divided by the power.
    pub(crate) residual: f64,
    /// Potential of all cells, if fields are wanted, and its residual.
    pub(crate) fields: Option<(Vec<Potential>, f64)>,
}

/// Result of a search under several gradients.
pub(crate) struct Search<const N: usize> {
    pub(crate) found: [Found; N],
    /// Power per area of the flow of the first gradient along the falls of the last one.
    pub(crate) shared: f64,
    pub(crate) iterations: usize,
}

/// Solves for the potentials of cells with the same equations under different gradients until the bounds of their
/// powers are close, and then, for fields, until each cell is in balance under the gradients that lie along the
/// reservoirs. Conjugate gradients are restarted from recomputed balances.
pub(crate) fn search<const N: usize>(cells: [&Cells; N], wanted: Wanted) -> Search<N> {
    let area = cells[0].area();
    let mut round = Round::new(cells);
    let mut found = [(); N].map(|()| Found::default());
    let (mut rule, mut margin, mut iterations, mut shared) = (Rule::Bounds, MARGIN_OF_BOUNDS, 0, f64::NAN);
    for last in (0..=ROUNDS).rev() {
        let powers = round.balance();
        if rule == Rule::Bounds {
            let distances = round.bound();
            for (k, found) in found.iter_mut().enumerate() {
                (found.power, found.residual) = (powers.own[k] / area, distances[k] / round.scale(k, &powers.own));
            }
            shared = powers.shared / area;
            if found.iter().all(|found| found.residual <= TOLERANCE) {
                (rule, margin) = (Rule::Cells, MARGIN);
            }
        }
        let is_last = last == 0 || iterations >= ITERATIONS;
        let done = rule == Rule::Cells && wanted == Wanted::Conductivity;
        if wanted == Wanted::Fields && (is_last || rule == Rule::Cells) {
            for (k, found) in found.iter_mut().enumerate().filter(|(k, _)| !cells[*k].is_across()) {
                let potential = cells[k].expand(|number| round.potential[number][k]);
                let residual = cells[k].residual(&potential);
                found.fields = Some((potential, residual));
            }
        }
        let mut fields = found.iter().filter_map(|found| found.fields.as_ref());
        if done || is_last || rule == Rule::Cells && fields.all(|(_, residual)| *residual <= TOLERANCE) {
            break;
        }
        round.solve(powers.own, (rule, margin), &mut iterations);
        margin *= MARGIN;
    }
    Search { found, shared, iterations }
}

/// Equations of a round and its vectors, with one column per gradient.
struct Round<'a, const N: usize> {
    cells: [&'a Cells<'a>; N],
    graph: Graph,
    drops: Drops<N>,
    factors: Elimination,
    tree: Tree,
    work: Work<N>,
    potential: Vec<[Potential; N]>,
    residual: Vec<[f64; N]>,
    direction: Vec<[f64; N]>,
    /// Step, image of the direction, or flow along the tree.
    step: Vec<[f64; N]>,
}

impl<'a, const N: usize> Round<'a, N> {
    fn new(cells: [&'a Cells<'a>; N]) -> Self {
        let graph = cells[0].graph();
        let (factors, tree) = rayon::join(|| Elimination::of(&graph, cells[0].numbering()), || Tree::of(&graph));
        let (work, drops) = (factors.work(), drops(cells));
        let [residual, step, direction] = std::array::from_fn(|_| vec![[0.0; N]; graph.len()]);
        let potential = vec![[Potential::default(); N]; graph.len()];
        Self { cells, graph, drops, factors, tree, work, potential, residual, direction, step }
    }

    /// Computes the flow that is missing in each balance, and returns the powers.
    fn balance(&mut self) -> Powers<N> {
        self.graph.balance(&self.potential, &self.drops, &mut self.residual)
    }

    /// Returns upper bounds of the power that the missing flow costs.
    fn bound(&mut self) -> [f64; N] {
        self.tree.bound(&self.residual, &mut self.step)
    }

    /// Returns the power that the distance between the bounds of gradient `k` is compared with. Across the reservoirs
    /// the flow may vanish.
    fn scale(&self, k: usize, power: &[f64; N]) -> f64 {
        if self.cells[k].is_across() { larger(power[0], power[k]) } else { power[k] }
    }

    /// Moves the potentials from a balance with this `power` towards the solution.
    fn solve(&mut self, mut power: [f64; N], (rule, margin): (Rule, f64), iterations: &mut usize) {
        let area = self.cells[0].area();
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
            let work_done = self.graph.apply(&self.direction, &mut self.step);
            let length = std::array::from_fn(|k| quotient(slope[k], work_done[k]));
            let largest = self.advance(length);
            *iterations += 1;
            // Each iteration lowers the power by a known amount. The remaining power gives the flow, and hence what may
            // be missing.
            (0..N).for_each(|k| power[k] -= length[k] * slope[k]);
            let exhausted = |k: usize| slope[k] <= REDUCTION * REDUCTION * first[k];
            let enough = match rule {
                Rule::Bounds => {
                    let allowed: [f64; N] = std::array::from_fn(|k| margin * TOLERANCE * self.scale(k, &power));
                    (0..N).all(|k| ratios[k] * slope[k] <= allowed[k]) && {
                        let bounds = self.bound();
                        ratios = std::array::from_fn(|k| larger(LEAST_RATIO, CAUTION * quotient(bounds[k], slope[k])));
                        (0..N).all(|k| bounds[k] <= allowed[k])
                    }
                }
                Rule::Cells => (0..N).all(|k| {
                    let allowed = margin * TOLERANCE * power[k] / area * self.cells[k].width();
                    self.cells[k].is_across() || exhausted(k) || largest[k] <= allowed
                }),
            };
            if enough || (0..N).all(exhausted) {
                break;
            }
        }
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
        type Moved<'a, const N: usize> = (&'a mut [[Potential; N]], &'a mut [[f64; N]], Rows<'a, N>, Rows<'a, N>);
        pass(
            (&mut self.potential[..], &mut self.residual[..], &self.direction[..], &self.step[..]),
            &|_, (potentials, residuals, directions, images): Moved<N>| {
                let mut largest = [0.0; N];
                let changed = potentials.iter_mut().zip(residuals);
                for ((potential, residual), (direction, image)) in changed.zip(directions.iter().zip(images)) {
                    for k in 0..N {
                        potential[k].add(lengths[k] * direction[k]);
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
