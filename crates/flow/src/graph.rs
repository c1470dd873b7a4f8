//! Weighted graphs, and passes over vectors with several columns.

use rayon::prelude::*;

/// Rows of a part of a vector. Sums are formed for each part first, so that they do not depend on the number of threads.
const PART: usize = 1 << 14;

/// A graph with weights on its edges, and conductances of its nodes to a reservoir.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    /// The edges of node i are `starts[i]..starts[i + 1]`.
    starts: Vec<usize>,
    ends: Vec<u32>,
    weights: Vec<f64>,
    /// The weight of each node to the reservoir.
    pub(crate) outside: Vec<f64>,
}

impl Graph {
    /// The graph of nodes that `edges` gives one by one, for each node its neighbours with weights (a neighbour may occur
    /// twice), and its weight to the reservoir.
    pub(crate) fn new(nodes: usize, mut edges: impl FnMut(usize, &mut Vec<(u32, f64)>) -> f64) -> Self {
        let mut graph = Self { starts: vec![0], ..Self::default() };
        let mut row = Vec::new();
        for node in 0..nodes {
            row.clear();
            let outside = edges(node, &mut row);
            graph.outside.push(outside);
            graph.ends.extend(row.iter().map(|edge| edge.0));
            graph.weights.extend(row.iter().map(|edge| edge.1));
            graph.starts.push(graph.ends.len());
        }
        graph
    }

    pub(crate) fn len(&self) -> usize {
        self.outside.len()
    }

    pub(crate) fn row(&self, node: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.starts[node]..self.starts[node + 1];
        self.ends[range.clone()].iter().map(|end| *end as usize).zip(self.weights[range].iter().copied())
    }

    /// `out` ← A x, which is what flows out of each node: of differences, which are exact where x varies little.
    pub(crate) fn apply<const N: usize>(&self, x: &[[f64; N]], out: &mut [[f64; N]]) {
        out.par_chunks_mut(PART).enumerate().for_each(|(part, rows)| {
            for (node, out) in (part * PART..).zip(rows) {
                let here = x[node];
                *out = here.map(|x| self.outside[node] * x);
                for (end, weight) in self.row(node) {
                    let there = &x[end];
                    (0..N).for_each(|k| out[k] += weight * (here[k] - there[k]));
                }
            }
        });
    }
}

/// The products of the columns of two vectors.
pub(crate) fn dot<const N: usize>(a: &[[f64; N]], b: &[[f64; N]]) -> [f64; N] {
    let of_part = |(a, b): (&[[f64; N]], &[[f64; N]])| {
        let mut sums = [0.0; N];
        for (a, b) in a.iter().zip(b) {
            (0..N).for_each(|k| sums[k] += a[k] * b[k]);
        }
        sums
    };
    let parts: Vec<[f64; N]> = a.par_chunks(PART).zip(b.par_chunks(PART)).map(of_part).collect();
    parts.into_iter().fold([0.0; N], |sum, part| std::array::from_fn(|k| sum[k] + part[k]))
}

/// Changes the rows of `a`, each with that of `b`.
pub(crate) fn zip<const N: usize>(
    a: &mut [[f64; N]],
    b: &[[f64; N]],
    change: impl Fn(&mut [f64; N], &[f64; N]) + Sync,
) {
    a.par_chunks_mut(PART)
        .zip(b.par_chunks(PART))
        .for_each(|(a, b)| a.iter_mut().zip(b).for_each(|(a, b)| change(a, b)));
}

/// The largest magnitude in a column; NaN if there is one.
pub(crate) fn largest<const N: usize>(a: &[[f64; N]], column: usize) -> f64 {
    a.iter().fold(0.0, |largest, row| {
        let value = row[column].abs();
        if value > largest || value.is_nan() { value } else { largest }
    })
}
