//! Equations without the cells of one colour of a chequerboard. No two of these cells are adjacent, so they are
//! eliminated exactly.

use std::ops::Range;

use rayon::prelude::*;

use crate::PART;
use crate::cells::{Cells, Links};
use crate::graph::Graph;

impl Cells<'_> {
    /// Builds the graph of the other cells. An eliminated cell leaves an edge between any two of its neighbours, like a
    /// star of conductances.
    pub(crate) fn graph(&self) -> Graph {
        let kept = self.numbering().kept();
        Graph::new(kept, |number, row| {
            let links = self.links(number);
            let mut outside = links.outside;
            for (beside, weight) in links.iter() {
                if beside < kept {
                    row.push((beside as u32, weight));
                    continue;
                }
                let gone = self.links(beside);
                let sum = gone.sum();
                outside += series(weight, gone.outside, sum);
                let others = gone.iter().filter(|(other, _)| *other != number);
                row.extend(others.map(|(other, to_other)| (other as u32, series(weight, to_other, sum))));
            }
            row.sort_unstable_by_key(|(end, _)| *end);
            row.dedup_by(|again, kept| {
                let same = again.0 == kept.0;
                if same {
                    kept.1 += again.1;
                }
                same
            });
            outside
        })
    }

    /// Computes the flow into the cells of the graph from the flow `missing` into all cells. Returns the power taken up
    /// by the eliminated cells.
    pub(crate) fn fold<const N: usize>(&self, missing: &[Vec<f64>; N], out: &mut [[f64; N]]) -> [f64; N] {
        let kept = self.numbering().kept();
        let of = |number: usize| -> [f64; N] { std::array::from_fn(|k| missing[k][number]) };
        out.par_chunks_mut(PART).enumerate().for_each(|(part, rows)| {
            for (number, out) in (part * PART..).zip(rows) {
                *out = of(number);
                for (beside, weight) in self.links(number).iter().filter(|(beside, _)| *beside >= kept) {
                    let share = weight / self.links(beside).sum();
                    let flow = of(beside);
                    (0..N).for_each(|k| out[k] += share * flow[k]);
                }
            }
        });
        let taken = |number: usize| {
            let sum = self.links(number).sum();
            of(number).map(|flow| if sum > 0.0 { flow * flow / sum } else { 0.0 })
        };
        let leaf =
            |range: Range<usize>| range.fold([0.0; N], |sum, number| gfmd_vector::add(sum, taken(kept + number)));
        gfmd_vector::reduce(self.len() - kept, &leaf, &gfmd_vector::add)
    }

    /// Computes the corrections of all cells from the corrections of the graph.
    pub(crate) fn expand<const N: usize>(&self, missing: &[Vec<f64>; N], corrections: &[[f64; N]]) -> Vec<[f64; N]> {
        let kept = self.numbering().kept();
        let of = |number: usize| {
            if number < kept {
                return corrections[number];
            }
            let links = self.links(number);
            let mut sums: [f64; N] = std::array::from_fn(|k| missing[k][number]);
            for (beside, weight) in links.iter() {
                (0..N).for_each(|k| sums[k] += weight * corrections[beside][k]);
            }
            let sum = links.sum();
            sums.map(|value| if sum > 0.0 { value / sum } else { 0.0 })
        };
        (0..self.len()).into_par_iter().with_min_len(PART).map(of).collect()
    }
}

impl Links {
    fn sum(&self) -> f64 {
        self.iter().fold(self.outside, |sum, (_, weight)| sum + weight)
    }
}

/// Returns the conductance between two neighbours of an eliminated cell with weights `a` and `b`.
fn series(a: f64, b: f64, sum: f64) -> f64 {
    a.min(b) * (a.max(b) / sum)
}
