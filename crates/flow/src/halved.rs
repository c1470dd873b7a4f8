//! Equations without the cells of one colour of a chequerboard. No two of these cells are adjacent, so they are
//! eliminated exactly: a star of conductances is equal to edges between any two of its ends.

use rayon::prelude::*;

use crate::PART;
use crate::cells::Cells;
use crate::graph::{Drops, Edge, Graph, Way};
use crate::potential::Potential;

impl Cells<'_> {
    /// Builds the graph of the other cells.
    pub(crate) fn graph(&self) -> Graph {
        let (kept, conductances) = (self.numbering().kept(), self.conductances());
        Graph::new(kept, |number, row| {
            let links = self.links(number, &conductances);
            for link in links.iter() {
                if (link.end as usize) < kept {
                    row.push(*link);
                    continue;
                }
                let gone = self.links(link.end as usize, &conductances);
                let sum: f64 = gone.iter().map(|other| other.weight).sum();
                let [x, y] = link.way.cells();
                for other in gone.iter().filter(|other| other.end as usize != number) {
                    let [further_x, further_y] = other.way.cells();
                    let way = Way::of([x + further_x, y + further_y]);
                    row.push(Edge { end: other.end, way, weight: series(link.weight, other.weight, sum) });
                }
            }
            row.sort_unstable_by_key(|edge| (edge.end, edge.way));
            row.dedup_by(|again, kept| {
                let same = (again.end, again.way) == (kept.end, kept.way);
                if same {
                    kept.weight += again.weight;
                }
                same
            });
            links.outside
        })
    }

    /// Computes the potentials of all cells from the potentials of the graph.
    pub(crate) fn expand(&self, kept: impl Fn(usize) -> Potential + Sync) -> Vec<Potential> {
        let of = |number: usize| {
            if number < self.numbering().kept() {
                return kept(number);
            }
            let faces = || self.faces_of(number).filter_map(|part| Some((kept(part.2.beside? as usize), part)));
            let sum: f64 = faces().map(|(_, (_, _, face))| face.conductance).sum();
            let strongest = faces().max_by(|a, b| a.1.2.conductance.total_cmp(&b.1.2.conductance));
            let mut own = strongest.map_or(Potential::default(), |(beside, _)| beside);
            // The second time removes the rounding error of the first one.
            for _ in 0..2 {
                let out: f64 = faces().map(|(beside, part)| part.2.conductance * self.fall(own, beside, &part)).sum();
                own.add(if sum > 0.0 { -out / sum } else { 0.0 });
            }
            own
        };
        (0..self.len()).into_par_iter().with_min_len(PART).map(of).collect()
    }
}

/// Returns the drops of the gradients of these cells.
pub(crate) fn drops<const N: usize>(cells: [&Cells; N]) -> Drops<N> {
    let mut along = [[0.0; N]; Way::COUNT];
    for (drops, way) in along.iter_mut().zip(Way::all()) {
        *drops = std::array::from_fn(|k| cells[k].drop_along(way));
    }
    Drops { along, outside: std::array::from_fn(|k| cells[k].drop_outside()) }
}

/// Returns the conductance between two neighbours of an eliminated cell with weights `a` and `b`.
fn series(a: f64, b: f64, sum: f64) -> f64 {
    a.min(b) * (a.max(b) / sum)
}
