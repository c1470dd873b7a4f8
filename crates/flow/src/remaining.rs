//! Graph that remains while nodes are eliminated.

use crate::queue::{NONE, Queue};

/// Number of copies of an edge, each sampled separately; at most this number is kept between two nodes.
const COPIES: usize = 2;

/// One direction of an edge, in the list of the node where it starts. A removed edge has zero weight.
#[derive(Clone, Copy)]
struct Edge {
    end: u32,
    /// Next edge in the list.
    next: u32,
    weight: f64,
}

/// Neighbour of an eliminated node, and the edges to it.
pub(crate) struct Neighbour {
    pub(crate) node: u32,
    edges: [u32; COPIES],
    copies: u32,
    pub(crate) weight: f64,
    /// Sum of the weights up to and including this one.
    sum: f64,
}

/// Edge between two nodes that are not eliminated.
pub(crate) type KeptEdge = (u32, u32, f64);

/// Remaining graph. The two directions of an edge have the numbers 2k and 2k + 1. The nodes from `own` on are not
/// eliminated.
pub(crate) struct Remaining {
    edges: Vec<Edge>,
    firsts: Vec<u32>,
    degrees: Vec<u32>,
    own: usize,
    /// Edges between nodes that are not eliminated.
    pub(crate) kept: Vec<KeptEdge>,
    /// Number of samples taken, offset by the seed.
    samples: u64,
}

impl Remaining {
    /// Creates nodes without edges. The first `own` nodes are to be eliminated; `seed` starts the samples.
    pub(crate) fn new(own: usize, nodes: usize, seed: u64) -> Self {
        let (firsts, degrees) = (vec![NONE; nodes], vec![0; nodes]);
        Self { edges: Vec::new(), firsts, degrees, own, kept: Vec::new(), samples: seed << 40 }
    }

    /// Returns the number of nodes to be eliminated.
    pub(crate) fn own(&self) -> usize {
        self.own
    }

    /// Adds an edge.
    pub(crate) fn join(&mut self, a: usize, b: usize, weight: f64) {
        let weight = weight / COPIES as f64;
        if weight > 0.0 {
            for (here, there) in [[(a, b), (b, a)]; COPIES].into_iter().flatten() {
                let edge = Edge { end: there as u32, next: self.firsts[here], weight };
                self.firsts[here] = self.edges.len() as u32;
                self.edges.push(edge);
                self.degrees[here] += 1;
            }
        }
    }

    /// Sorts the nodes to be eliminated by their number of edges.
    pub(crate) fn queue(&self) -> Queue {
        Queue::new(self.degrees[..self.own].to_vec())
    }

    /// Collects the neighbours of a node, the most weakly connected first.
    pub(crate) fn collect(&mut self, node: usize, around: &mut Vec<Neighbour>, queue: &mut Queue) {
        around.clear();
        let mut next = self.firsts[node];
        while next != NONE {
            let (edge, Edge { end, next: after, weight }) = (next, self.edges[next as usize]);
            next = after;
            if weight == 0.0 {
                continue;
            }
            // With few edges, a linear search is faster than sorting.
            match around.iter_mut().find(|neighbour| neighbour.node == end) {
                None => around.push(Neighbour { node: end, edges: [edge; COPIES], copies: 1, weight, sum: 0.0 }),
                Some(kept) => {
                    kept.weight += weight;
                    if (kept.copies as usize) < COPIES {
                        kept.edges[kept.copies as usize] = edge;
                        kept.copies += 1;
                    } else {
                        self.remove(edge, end, queue);
                    }
                }
            }
        }
        around.sort_unstable_by(|a, b| a.weight.total_cmp(&b.weight).then(a.node.cmp(&b.node)));
        let mut sum = 0.0;
        for neighbour in around {
            sum += neighbour.weight;
            neighbour.sum = sum;
        }
    }

    /// Removes the opposite direction of an edge from the list of its other end `there`.
    fn remove(&mut self, edge: u32, there: u32, queue: &mut Queue) {
        self.edges[edge as usize ^ 1].weight = 0.0;
        self.count(there, -1, queue);
    }

    fn count(&self, node: u32, change: i32, queue: &mut Queue) {
        if (node as usize) < self.own {
            queue.add(node as usize, change);
        }
    }

    /// Eliminates the node with these neighbours and returns its weight.
    pub(crate) fn eliminate(&mut self, around: &[Neighbour], queue: &mut Queue) -> f64 {
        let Some((last, others)) = around.split_last() else { return 0.0 };
        for (place, neighbour) in others.iter().enumerate() {
            let (later, left) = (&around[place + 1..], last.sum - neighbour.sum);
            let weight = neighbour.weight * (left / last.sum) / f64::from(neighbour.copies);
            let first = self.draw();
            for copy in 0..neighbour.copies {
                // Draws one of the later neighbours by weight; the copies are spread evenly.
                let drawn = neighbour.sum + (first + f64::from(copy)) / f64::from(neighbour.copies) * left;
                let other = &later[later.partition_point(|other| other.sum < drawn).min(later.len() - 1)];
                self.turn(neighbour.edges[copy as usize], neighbour.node, other.node, weight, queue);
            }
        }
        last.edges[..last.copies as usize].iter().for_each(|edge| self.remove(*edge, last.node, queue));
        last.sum
    }

    /// Replaces an edge between an eliminated node and `node` by an edge between `node` and `other`.
    fn turn(&mut self, edge: u32, node: u32, other: u32, weight: f64, queue: &mut Queue) {
        let own = |node: u32| (node as usize) < self.own;
        if !own(node) && !own(other) {
            self.kept.push((node, other, weight));
            self.edges[edge as usize ^ 1].weight = 0.0;
            return;
        }
        let reverse = &mut self.edges[edge as usize ^ 1];
        (reverse.end, reverse.weight) = (other, weight);
        self.edges[edge as usize] = Edge { end: node, next: self.firsts[other as usize], weight };
        self.firsts[other as usize] = edge;
        self.count(other, 1, queue);
    }

    /// Returns the next number of a fixed sequence between 0 and 1 (Steele, Lea and Flood 2014).
    fn draw(&mut self) -> f64 {
        self.samples += 1;
        let mut bits = self.samples.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
