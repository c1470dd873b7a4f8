//! Weighted graphs of cells.

use rayon::prelude::*;

use crate::PART;
use crate::potential::Potential;

/// Graph with weighted edges, and conductances of its nodes to a reservoir.
#[derive(Clone, Debug)]
pub(crate) struct Graph {
    parts: Vec<Part>,
    nodes: usize,
}

/// Edge from a node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    pub(crate) end: u32,
    pub(crate) way: Way,
    pub(crate) weight: f64,
}

/// Way from a cell to another one, in cells along both axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Way(u8);

impl Way {
    /// Largest number of cells along an axis.
    const FAR: i8 = 2;
    const SIDE: i8 = 2 * Self::FAR + 1;
    /// Number of ways.
    pub(crate) const COUNT: usize = (Self::SIDE * Self::SIDE) as usize;

    pub(crate) fn of(cells: [i8; 2]) -> Self {
        Self((Self::SIDE * (cells[0] + Self::FAR) + cells[1] + Self::FAR) as u8)
    }

    /// Returns the numbers of cells along both axes.
    pub(crate) fn cells(self) -> [i8; 2] {
        let place = self.0 as i8;
        [place / Self::SIDE - Self::FAR, place % Self::SIDE - Self::FAR]
    }

    /// Iterates over all ways in order.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        (0..Self::COUNT as u8).map(Self)
    }
}

/// Drops of the mean gradients between two cells.
pub(crate) struct Drops<const N: usize> {
    /// Drop along each way.
    pub(crate) along: [[f64; N]; Way::COUNT],
    /// Drop from a cell at the far edge of a non-periodic field to the reservoir; negative at the near edge.
    pub(crate) outside: [f64; N],
}

/// Powers of a flow.
#[derive(Clone, Copy)]
pub(crate) struct Powers<const N: usize> {
    /// Power of each gradient.
    pub(crate) own: [f64; N],
    /// Power of the flow of the first gradient along the falls of the last one.
    pub(crate) shared: f64,
}

/// Consecutive nodes of a graph.
#[derive(Clone, Debug, Default)]
struct Part {
    /// Starts of the edges of each node; node i of the part has the edges `starts[i]..starts[i + 1]`.
    starts: Vec<u32>,
    ends: Vec<u32>,
    ways: Vec<Way>,
    weights: Vec<f64>,
    /// Weight of each node to the reservoir, negative at the near edge; empty if no node has one.
    outside: Vec<f64>,
}

impl Graph {
    /// Builds a graph. For each node, `edges` appends the edges and returns the weight to the reservoir, negative at
    /// the near edge.
    pub(crate) fn new(nodes: usize, edges: impl Fn(usize, &mut Vec<Edge>) -> f64 + Sync) -> Self {
        let made = |part: usize| {
            let range = part * PART..((part + 1) * PART).min(nodes);
            let room = range.len() * 8;
            let mut made = Part {
                starts: Vec::with_capacity(range.len() + 1),
                ends: Vec::with_capacity(room),
                ways: Vec::with_capacity(room),
                weights: Vec::with_capacity(room),
                outside: Vec::with_capacity(range.len()),
            };
            made.starts.push(0);
            let mut row = Vec::new();
            for node in range {
                row.clear();
                made.outside.push(edges(node, &mut row));
                made.ends.extend(row.iter().map(|edge| edge.end));
                made.ways.extend(row.iter().map(|edge| edge.way));
                made.weights.extend(row.iter().map(|edge| edge.weight));
                made.starts.push(made.ends.len() as u32);
            }
            if made.outside.iter().all(|weight| *weight == 0.0) {
                made.outside = Vec::new();
            }
            made
        };
        Self { parts: (0..nodes.div_ceil(PART)).into_par_iter().map(made).collect(), nodes }
    }

    pub(crate) fn len(&self) -> usize {
        self.nodes
    }

    /// Returns the neighbours of a node with the weights of the edges.
    pub(crate) fn row(&self, node: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.parts[node / PART].row(node % PART)
    }

    /// Returns the weight of a node to the reservoir.
    pub(crate) fn outside(&self, node: usize) -> f64 {
        self.parts[node / PART].outside.get(node % PART).map_or(0.0, |weight| weight.abs())
    }

    /// Computes `out` = A x, the flow out of each node. It uses differences, which are exact where x varies little.
    /// Returns the products of the columns of x and A x.
    pub(crate) fn apply<const N: usize>(&self, x: &[[f64; N]], out: &mut [[f64; N]]) -> [f64; N] {
        let of_part = |(place, (part, rows)): (usize, (&Part, &mut [[f64; N]]))| {
            let mut products = [0.0; N];
            for (node, out) in rows.iter_mut().enumerate() {
                let here = x[place * PART + node];
                let outside = part.outside.get(node).map_or(0.0, |weight| weight.abs());
                let mut sums = here.map(|x| outside * x);
                for (end, weight) in part.row(node) {
                    let there = &x[end];
                    (0..N).for_each(|k| sums[k] += weight * (here[k] - there[k]));
                }
                (0..N).for_each(|k| products[k] += here[k] * sums[k]);
                *out = sums;
            }
            products
        };
        let parts = self.parts.par_iter().zip(out.par_chunks_mut(PART)).enumerate();
        total(parts.map(of_part).collect())
    }

    /// Computes the flow `missing` in the balance of each node, and returns the powers of the flow.
    pub(crate) fn balance<const N: usize>(
        &self,
        potential: &[[Potential; N]],
        drops: &Drops<N>,
        missing: &mut [[f64; N]],
    ) -> Powers<N> {
        let of_part = |(place, (part, rows)): (usize, (&Part, &mut [[f64; N]]))| {
            let (mut own, mut shared) = ([0.0; N], [0.0]);
            for (node, missing) in rows.iter_mut().enumerate() {
                let here = &potential[place * PART + node];
                let mut sums = [0.0; N];
                // An inner edge belongs to two nodes.
                let mut add = |weight: f64, share: f64, falls: [f64; N]| {
                    for k in 0..N {
                        let out = weight * falls[k];
                        sums[k] += out;
                        own[k] += share * out * falls[k];
                    }
                    shared[0] += share * weight * falls[0] * falls[N - 1];
                };
                let range = part.range(node);
                let edges = part.ends[range.clone()].iter().zip(&part.ways[range.clone()]).zip(&part.weights[range]);
                for ((end, way), weight) in edges {
                    let (there, drop) = (&potential[*end as usize], &drops.along[way.0 as usize]);
                    add(*weight, 0.5, std::array::from_fn(|k| here[k].over(there[k], drop[k])));
                }
                if let Some(weight) = part.outside.get(node).filter(|weight| **weight != 0.0) {
                    let drop = |k: usize| drops.outside[k].copysign(drops.outside[k] * *weight);
                    add(weight.abs(), 1.0, std::array::from_fn(|k| here[k].over(Potential::default(), drop(k))));
                }
                *missing = sums.map(|out| -out);
            }
            (own, shared)
        };
        let parts = self.parts.par_iter().zip(missing.par_chunks_mut(PART)).enumerate();
        let (own, shared): (Vec<_>, Vec<_>) = parts.map(of_part).unzip();
        let [shared] = total(shared);
        Powers { own: total(own), shared }
    }
}

impl Part {
    fn range(&self, node: usize) -> std::ops::Range<usize> {
        self.starts[node] as usize..self.starts[node + 1] as usize
    }

    fn row(&self, node: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.range(node);
        self.ends[range.clone()].iter().map(|end| *end as usize).zip(self.weights[range].iter().copied())
    }
}

/// Adds the sums of the parts in order.
pub(crate) fn total<const N: usize>(parts: Vec<[f64; N]>) -> [f64; N] {
    parts.into_iter().fold([0.0; N], |sum, part| std::array::from_fn(|k| sum[k] + part[k]))
}
