//! Approximate elimination of the nodes of a weighted graph, a preconditioner for its Laplacian: where an exact elimination connects
//! all neighbours of a node with each other, a tree is sampled that has the same weights on average (Kyng and Sachdeva, FOCS 2016, 573;
//! ordering, merging and sampling as Gao, Kyng and Spielman, arXiv 2303.00709). Weights may differ by any number of decades.

use crate::graph::{Graph, zip};

/// No edge, no node.
const NONE: u32 = u32::MAX;

/// One direction of an edge, in the list of the node from which it is seen. A weight of zero: the edge is gone.
#[derive(Clone, Copy)]
struct Edge {
    end: u32,
    /// The next in the list.
    next: u32,
    weight: f64,
}

/// The nodes that are left, by their number of edges.
struct Queue {
    /// The first node with each number of edges; the last entry has all larger ones.
    firsts: Vec<u32>,
    degrees: Vec<u32>,
    before: Vec<u32>,
    after: Vec<u32>,
    lowest: usize,
}

impl Queue {
    /// Numbers of edges that are told apart.
    const LISTS: usize = 64;

    fn new(degrees: Vec<u32>) -> Self {
        let n = degrees.len();
        let firsts = vec![NONE; Self::LISTS];
        let mut queue = Self { firsts, degrees, before: vec![NONE; n], after: vec![NONE; n], lowest: 0 };
        (0..n).rev().for_each(|node| queue.insert(node));
        queue
    }

    fn list(&self, node: usize) -> usize {
        (self.degrees[node] as usize).min(Self::LISTS - 1)
    }

    fn insert(&mut self, node: usize) {
        let list = self.list(node);
        let first = self.firsts[list];
        (self.before[node], self.after[node]) = (NONE, first);
        if first != NONE {
            self.before[first as usize] = node as u32;
        }
        self.firsts[list] = node as u32;
        self.lowest = self.lowest.min(list);
    }

    fn remove(&mut self, node: usize) {
        let (before, after) = (self.before[node], self.after[node]);
        if before == NONE {
            let list = self.list(node);
            self.firsts[list] = after;
        } else {
            self.after[before as usize] = after;
        }
        if after != NONE {
            self.before[after as usize] = before;
        }
    }

    /// Adds to the number of edges of a node.
    fn add(&mut self, node: usize, change: i32) {
        let degree = self.degrees[node].saturating_add_signed(change);
        if (degree as usize).min(Self::LISTS - 1) == self.list(node) {
            self.degrees[node] = degree;
            return;
        }
        self.remove(node);
        self.degrees[node] = degree;
        self.insert(node);
    }

    /// Takes a node with the least number of edges.
    fn pop(&mut self) -> Option<usize> {
        while self.lowest < Self::LISTS {
            let first = self.firsts[self.lowest];
            if first != NONE {
                self.remove(first as usize);
                return Some(first as usize);
            }
            self.lowest += 1;
        }
        None
    }
}

/// The factors of the approximate elimination. The last node stands for the reservoir.
pub(crate) struct Elimination {
    /// The nodes in the order in which they are eliminated.
    order: Vec<u32>,
    /// The shares of the k-th node are `starts[k]..starts[k + 1]`.
    starts: Vec<usize>,
    /// The neighbours of a node, and of what is left of it the part that goes to each of them; the last gets the rest.
    shares: Vec<(u32, f32)>,
    /// The reciprocal of the weight of each node when it is eliminated; zero for the last of its part of the graph.
    inverses: Vec<f64>,
}

impl Elimination {
    pub(crate) fn of(graph: &Graph) -> Self {
        let n = graph.len();
        let mut remaining = Remaining::of(graph);
        let mut queue = Queue::new(std::mem::take(&mut remaining.degrees));
        let (mut order, mut starts) = (Vec::with_capacity(n + 1), vec![0]);
        let (mut shares, mut inverses) = (Vec::with_capacity(3 * n), Vec::with_capacity(n + 1));
        let mut around = Vec::new();
        while let Some(node) = queue.pop() {
            remaining.collect(node, &mut around, &mut queue);
            let weight = remaining.eliminate(&around, &mut queue, &mut shares);
            order.push(node as u32);
            inverses.push(if weight > 0.0 { 1.0 / weight } else { 0.0 });
            starts.push(shares.len());
        }
        Self { order, starts, shares, inverses }
    }

    /// `out` ← about A⁻¹ `residual`. `work` is memory.
    pub(crate) fn solve<const N: usize>(&self, residual: &[[f64; N]], out: &mut [[f64; N]], work: &mut Vec<[f64; N]>) {
        let rest = residual.iter().fold([0.0; N], |sum, r| std::array::from_fn(|k| sum[k] - r[k]));
        // Nodes keep their numbers, by which neighbours lie close together.
        work.clear();
        work.extend_from_slice(residual);
        work.push(rest);
        for (place, node) in self.order.iter().enumerate() {
            let node = *node as usize;
            let Some((last, others)) = self.entries(place).split_last() else {
                work[node] = [0.0; N];
                continue;
            };
            let mut left = work[node];
            for &(end, share) in others {
                let (share, end) = (f64::from(share), &mut work[end as usize]);
                for k in 0..N {
                    end[k] += share * left[k];
                    left[k] *= 1.0 - share;
                }
            }
            let end = &mut work[last.0 as usize];
            (0..N).for_each(|k| end[k] += left[k]);
            work[node] = left.map(|left| left * self.inverses[place]);
        }
        for (place, node) in self.order.iter().enumerate().rev() {
            let Some((last, others)) = self.entries(place).split_last() else { continue };
            let (mut value, end) = (work[*node as usize], work[last.0 as usize]);
            (0..N).for_each(|k| value[k] += end[k]);
            for &(end, share) in others.iter().rev() {
                let (share, end) = (f64::from(share), work[end as usize]);
                (0..N).for_each(|k| value[k] = (1.0 - share) * value[k] + share * end[k]);
            }
            work[*node as usize] = value;
        }
        let level = work[residual.len()];
        zip(out, work, |out, value| (0..N).for_each(|k| out[k] = value[k] - level[k]));
    }

    fn entries(&self, place: usize) -> &[(u32, f32)] {
        &self.shares[self.starts[place]..self.starts[place + 1]]
    }
}

/// A neighbour of a node that is eliminated, and the edge to it.
struct Neighbour {
    node: u32,
    edge: u32,
    weight: f64,
    /// The sum of the weights up to this one.
    sum: f64,
}

/// The graph that is left. The two directions of an edge have the numbers 2k and 2k + 1.
struct Remaining {
    edges: Vec<Edge>,
    firsts: Vec<u32>,
    degrees: Vec<u32>,
    /// Number of samples taken.
    samples: u64,
}

impl Remaining {
    fn of(graph: &Graph) -> Self {
        let n = graph.len();
        let mut remaining = Self { edges: Vec::new(), firsts: vec![NONE; n + 1], degrees: vec![0; n + 1], samples: 0 };
        for node in 0..n {
            graph.row(node).filter(|(end, _)| *end > node).for_each(|(end, weight)| remaining.join(node, end, weight));
            remaining.join(node, n, graph.outside[node]);
        }
        remaining
    }

    fn join(&mut self, a: usize, b: usize, weight: f64) {
        if weight > 0.0 {
            for (here, there) in [(a, b), (b, a)] {
                let edge = Edge { end: there as u32, next: self.firsts[here], weight };
                self.firsts[here] = self.edges.len() as u32;
                self.edges.push(edge);
                self.degrees[here] += 1;
            }
        }
    }

    /// The neighbours of a node, the most weakly connected first.
    fn collect(&mut self, node: usize, around: &mut Vec<Neighbour>, queue: &mut Queue) {
        around.clear();
        let mut next = self.firsts[node];
        while next != NONE {
            let Edge { end, next: after, weight } = self.edges[next as usize];
            if weight > 0.0 {
                around.push(Neighbour { node: end, edge: next, weight, sum: 0.0 });
            }
            next = after;
        }
        around.sort_by_key(|neighbour| neighbour.node);
        around.dedup_by(|again, kept| {
            let same = again.node == kept.node;
            if same {
                kept.weight += again.weight;
                self.edges[again.edge as usize ^ 1].weight = 0.0;
                queue.add(kept.node as usize, -1);
            }
            same
        });
        around.sort_by(|a, b| a.weight.total_cmp(&b.weight));
        let mut sum = 0.0;
        for neighbour in around {
            sum += neighbour.weight;
            neighbour.sum = sum;
        }
    }

    /// Eliminates the node with these neighbours; returns its weight.
    fn eliminate(&mut self, around: &[Neighbour], queue: &mut Queue, shares: &mut Vec<(u32, f32)>) -> f64 {
        let Some(last) = around.last() else { return 0.0 };
        let (mut left, mut scale) = (last.sum, 1.0);
        for (place, neighbour) in around[..around.len() - 1].iter().enumerate() {
            let share = neighbour.weight * scale / left;
            // One of the later neighbours, by weight.
            let drawn = neighbour.sum + self.draw() * (last.sum - neighbour.sum);
            let later = &around[place + 1..];
            let other = &later[later.partition_point(|other| other.sum < drawn).min(later.len() - 1)];
            let weight = share * (1.0 - share) * left;
            let (edge, first) = (neighbour.edge, self.firsts[other.node as usize]);
            let reverse = &mut self.edges[edge as usize ^ 1];
            (reverse.end, reverse.weight) = (other.node, weight);
            self.edges[edge as usize] = Edge { end: neighbour.node, next: first, weight };
            self.firsts[other.node as usize] = edge;
            queue.add(other.node as usize, 1);
            scale *= 1.0 - share;
            left *= (1.0 - share) * (1.0 - share);
            shares.push((neighbour.node, share as f32));
        }
        self.edges[last.edge as usize ^ 1].weight = 0.0;
        queue.add(last.node as usize, -1);
        shares.push((last.node, 1.0));
        last.weight * scale
    }

    /// The next of a fixed sequence of numbers between 0 and 1 (Steele, Lea and Flood 2014).
    fn draw(&mut self) -> f64 {
        self.samples += 1;
        let mut bits = self.samples.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }
}
