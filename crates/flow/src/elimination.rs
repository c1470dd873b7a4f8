//! Approximate elimination of the nodes of a weighted graph, a preconditioner for its Laplacian. An exact elimination
//! connects all neighbours of a node with each other; here a few edges are sampled that have the same weights on
//! average (Kyng and Sachdeva, FOCS 2016, 573; ordering, merging and sampling as Gao, Kyng and Spielman, arXiv
//! 2303.00709). Weights may differ by any number of decades. The nodes inside blocks come first, each block on one
//! thread and in its cache; the borders between blocks come last.

use std::ops::Range;

use rayon::prelude::*;

use crate::graph::{Graph, total};
use crate::numbering::Numbering;
use crate::remaining::{KeptEdge, Remaining};

/// Usual number of neighbours of a node at its elimination.
const SHARES: usize = 5;

/// Factors of the elimination of some nodes, numbered from 0; higher numbers refer to further nodes outside.
#[derive(Default)]
struct Factors {
    /// Nodes in the order of elimination.
    order: Vec<u32>,
    /// Starts of the shares of each node; the k-th node has the shares `starts[k]..starts[k + 1]`.
    starts: Vec<u32>,
    /// Neighbours of a node, and the share of its flow that goes to each of them; the last neighbour gets the rest.
    shares: Vec<(u32, f32)>,
    /// Reciprocal weight of each node at its elimination; zero for the last node of a connected part.
    inverses: Vec<f64>,
}

/// Factors of a block.
struct Block {
    nodes: Range<usize>,
    factors: Factors,
    /// Places on the border of the further nodes of the block.
    border: Vec<u32>,
}

/// Factors of the approximate elimination of a graph. The reservoir has zero potential.
pub(crate) struct Elimination {
    blocks: Vec<Block>,
    /// Factors of the border; the reservoir is its only further node.
    border: Factors,
    /// First node on the border.
    start: usize,
}

/// Memory of [`Elimination::solve`]: the flows that blocks pass to the border.
pub(crate) struct Work<const N: usize>(Vec<Vec<[f64; N]>>);

impl Elimination {
    pub(crate) fn of(graph: &Graph, numbering: &Numbering) -> Self {
        let start = numbering.border();
        let ranges: Vec<Range<usize>> = numbering.blocks().collect();
        let made = |(place, nodes): (usize, Range<usize>)| Block::of(graph, nodes, start, place as u64 + 1);
        let made: Vec<(Block, Vec<KeptEdge>)> = ranges.into_par_iter().enumerate().map(made).collect();
        let size = graph.len() - start;
        let mut remaining = Remaining::new(size, size + 1, 0);
        for node in 0..size {
            let further = graph.row(start + node).filter(|(end, _)| *end > start + node);
            further.for_each(|(end, weight)| remaining.join(node, end - start, weight));
            remaining.join(node, size, graph.outside(start + node));
        }
        let mut blocks = Vec::with_capacity(made.len());
        for (block, kept) in made {
            kept.into_iter().for_each(|(a, b, weight)| remaining.join(a as usize, b as usize, weight));
            blocks.push(block);
        }
        Self { blocks, border: Factors::of(&mut remaining), start }
    }

    pub(crate) fn work<const N: usize>(&self) -> Work<N> {
        Work(self.blocks.iter().map(|block| vec![[0.0; N]; block.border.len()]).collect())
    }

    /// Computes `out` ≈ A⁻¹ `residual`. Returns the products of the columns of both.
    pub(crate) fn solve<const N: usize>(
        &self,
        residual: &[[f64; N]],
        out: &mut [[f64; N]],
        work: &mut Work<N>,
    ) -> [f64; N] {
        let (inside, border) = out.split_at_mut(self.start);
        let mut rest = inside;
        let parts = self.blocks.iter().zip(&mut work.0).map(|(block, further)| {
            let (own, others) = std::mem::take(&mut rest).split_at_mut(block.nodes.len());
            rest = others;
            (block, own, further)
        });
        let mut tasks: Vec<_> = parts.collect();
        tasks.par_iter_mut().for_each(|(block, own, further)| {
            own.copy_from_slice(&residual[block.nodes.clone()]);
            further.fill([0.0; N]);
            block.factors.forward(own, further);
        });
        border.copy_from_slice(&residual[self.start..]);
        for (block, _, further) in &tasks {
            for (place, flow) in block.border.iter().zip(further.iter()) {
                if let Some(sum) = border.get_mut(*place as usize) {
                    *sum = gfmd_vector::add(*sum, *flow);
                }
            }
        }
        let reservoir = &mut [[0.0; N]];
        self.border.forward(border, reservoir);
        reservoir.fill([0.0; N]);
        self.border.backward(border, reservoir);
        let border = &*border;
        let of_blocks = tasks.par_iter_mut().map(|(block, own, further)| {
            for (place, value) in block.border.iter().zip(further.iter_mut()) {
                // The place after the border is the reservoir, where the potential is zero.
                *value = border.get(*place as usize).copied().unwrap_or([0.0; N]);
            }
            block.factors.backward(own, further);
            products(own, &residual[block.nodes.clone()])
        });
        gfmd_vector::add(total(of_blocks.collect()), products(border, &residual[self.start..]))
    }
}

impl Block {
    /// Eliminates some nodes. Also returns the edges between places on the border, which begins at node `start`.
    fn of(graph: &Graph, nodes: Range<usize>, start: usize, seed: u64) -> (Self, Vec<KeptEdge>) {
        let reservoir = (graph.len() - start) as u32;
        let to_border = |node: usize| {
            let outside = (graph.outside(node) > 0.0).then_some(reservoir);
            graph.row(node).filter(|(end, _)| *end >= start).map(|(end, _)| (end - start) as u32).chain(outside)
        };
        let mut border: Vec<u32> = nodes.clone().flat_map(to_border).collect();
        border.sort_unstable();
        border.dedup();
        let own = nodes.len();
        let further = |place: u32| own + border.partition_point(|other| *other < place);
        let mut remaining = Remaining::new(own, own + border.len(), seed);
        for node in nodes.clone() {
            let here = node - nodes.start;
            for (end, weight) in graph.row(node) {
                if end >= start {
                    remaining.join(here, further((end - start) as u32), weight);
                } else if end > node {
                    remaining.join(here, end - nodes.start, weight);
                }
            }
            if graph.outside(node) > 0.0 {
                remaining.join(here, further(reservoir), graph.outside(node));
            }
        }
        let factors = Factors::of(&mut remaining);
        let place = |node: u32| border[node as usize - own];
        let kept = remaining.kept.iter().map(|(a, b, weight)| (place(*a), place(*b), *weight)).collect();
        (Self { nodes, factors, border }, kept)
    }
}

impl Factors {
    /// Eliminates the nodes of a graph.
    fn of(remaining: &mut Remaining) -> Self {
        let mut queue = remaining.queue();
        let nodes = remaining.own();
        let mut factors = Self {
            order: Vec::with_capacity(nodes),
            starts: Vec::with_capacity(nodes + 1),
            shares: Vec::with_capacity(SHARES * nodes),
            inverses: Vec::with_capacity(nodes),
        };
        factors.starts.push(0);
        let mut around = Vec::new();
        while let Some(node) = queue.pop() {
            remaining.collect(node, &mut around, &mut queue);
            let weight = remaining.eliminate(&around, &mut queue);
            factors.shares.extend(around.iter().map(|other| (other.node, (other.weight / weight) as f32)));
            factors.order.push(node as u32);
            factors.inverses.push(if weight > 0.0 { 1.0 / weight } else { 0.0 });
            factors.starts.push(factors.shares.len() as u32);
        }
        factors.shares.shrink_to_fit();
        factors
    }

    /// Passes the flow into each node to its neighbours, in `further` for further nodes, and divides it by the weight.
    fn forward<const N: usize>(&self, own: &mut [[f64; N]], further: &mut [[f64; N]]) {
        for (place, node) in self.order.iter().enumerate() {
            let node = *node as usize;
            let Some((last, others)) = self.entries(place).split_last() else {
                own[node] = [0.0; N];
                continue;
            };
            let here = own[node];
            let mut left = here;
            let mut pass = |end: u32, flow: [f64; N]| {
                let end = end as usize;
                let end = if end < own.len() { &mut own[end] } else { &mut further[end - own.len()] };
                *end = gfmd_vector::add(*end, flow);
            };
            for &(end, share) in others {
                let flow = here.map(|here| f64::from(share) * here);
                (0..N).for_each(|k| left[k] -= flow[k]);
                pass(end, flow);
            }
            pass(last.0, left);
            own[node] = here.map(|here| here * self.inverses[place]);
        }
    }

    /// Adds to the value of each node the weighted mean of its neighbours' values.
    fn backward<const N: usize>(&self, own: &mut [[f64; N]], further: &[[f64; N]]) {
        for (place, node) in self.order.iter().enumerate().rev() {
            let Some((last, others)) = self.entries(place).split_last() else { continue };
            let of = |end: u32| {
                let end = end as usize;
                if end < own.len() { own[end] } else { further[end - own.len()] }
            };
            let level = of(last.0);
            let mut value = gfmd_vector::add(own[*node as usize], level);
            for &(end, share) in others {
                let (share, there) = (f64::from(share), of(end));
                (0..N).for_each(|k| value[k] += share * (there[k] - level[k]));
            }
            own[*node as usize] = value;
        }
    }

    fn entries(&self, place: usize) -> &[(u32, f32)] {
        &self.shares[self.starts[place] as usize..self.starts[place + 1] as usize]
    }
}

/// Returns the products of the columns of two vectors.
fn products<const N: usize>(a: &[[f64; N]], b: &[[f64; N]]) -> [f64; N] {
    gfmd_vector::pass(
        (a, b),
        &|_, (a, b): (&[[f64; N]], &[[f64; N]])| {
            let mut sums = [0.0; N];
            for (a, b) in a.iter().zip(b) {
                (0..N).for_each(|k| sums[k] += a[k] * b[k]);
            }
            sums
        },
        &gfmd_vector::add,
    )
}
