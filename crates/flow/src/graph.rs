//! Weighted graphs.

use rayon::prelude::*;

use crate::PART;

/// Graph with weighted edges, and conductances of its nodes to a reservoir.
#[derive(Clone, Debug)]
pub(crate) struct Graph {
    parts: Vec<Part>,
    nodes: usize,
}

/// Consecutive nodes of a graph.
#[derive(Clone, Debug, Default)]
struct Part {
    /// Starts of the edges of each node; node i of the part has the edges `starts[i]..starts[i + 1]`.
    starts: Vec<u32>,
    ends: Vec<u32>,
    weights: Vec<f64>,
    /// Weight of each node to the reservoir.
    outside: Vec<f64>,
}

impl Graph {
    /// Builds a graph. For each node, `edges` appends the neighbours with their weights and returns the weight to the
    /// reservoir.
    pub(crate) fn new(nodes: usize, edges: impl Fn(usize, &mut Vec<(u32, f64)>) -> f64 + Sync) -> Self {
        let made = |part: usize| {
            let mut made = Part { starts: vec![0], ..Part::default() };
            let mut row = Vec::new();
            for node in part * PART..((part + 1) * PART).min(nodes) {
                row.clear();
                made.outside.push(edges(node, &mut row));
                made.ends.extend(row.iter().map(|edge| edge.0));
                made.weights.extend(row.iter().map(|edge| edge.1));
                made.starts.push(made.ends.len() as u32);
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
        self.parts[node / PART].outside[node % PART]
    }

    /// Computes `out` = A x, the flow out of each node. It uses differences, which are exact where x varies little.
    /// Returns the products of the columns of x and A x.
    pub(crate) fn apply<const N: usize>(&self, x: &[[f64; N]], out: &mut [[f64; N]]) -> [f64; N] {
        let of_part = |(place, (part, rows)): (usize, (&Part, &mut [[f64; N]]))| {
            let mut products = [0.0; N];
            for (node, out) in rows.iter_mut().enumerate() {
                let here = x[place * PART + node];
                let mut sums = here.map(|x| part.outside[node] * x);
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
}

impl Part {
    fn row(&self, node: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.starts[node] as usize..self.starts[node + 1] as usize;
        self.ends[range.clone()].iter().map(|end| *end as usize).zip(self.weights[range].iter().copied())
    }
}

/// Adds the sums of the parts in order.
pub(crate) fn total<const N: usize>(parts: Vec<[f64; N]>) -> [f64; N] {
    parts.into_iter().fold([0.0; N], |sum, part| std::array::from_fn(|k| sum[k] + part[k]))
}
