//! Bound of the energy that a flow misses, by a flow along a tree.

use crate::graph::Graph;

/// Bits of a weight that order the edges: sign, exponent and the first seven bits of the mantissa.
const SHIFT: u32 = 45;

/// Spanning tree of the strongest edges of a graph, one for each connected part. The reservoir is the root of the parts
/// that it touches.
pub(crate) struct Tree {
    /// Nodes other than the roots, children before their parents.
    steps: Vec<Step>,
    /// Number of nodes, and of the reservoir.
    nodes: usize,
}

/// Edge from a node to its parent.
struct Step {
    node: u32,
    parent: u32,
    /// Reciprocal weight.
    resistance: f64,
}

impl Tree {
    /// Builds the tree. Edges are taken from the strongest to the weakest, to about 1 % of their weight.
    pub(crate) fn of(graph: &Graph) -> Self {
        let nodes = graph.len();
        let mut links = Links::new(nodes + 1);
        let mut groups: Vec<u32> = (0..=nodes as u32).collect();
        for [a, b] in sorted(graph) {
            let (of_a, of_b) = (root(&mut groups, a), root(&mut groups, b));
            if of_a != of_b {
                groups[of_a.max(of_b) as usize] = of_a.min(of_b);
                links.join(a, b, weight(graph, a as usize, b as usize));
            }
        }
        drop(groups);
        Self { steps: links.stripped(nodes), nodes }
    }

    /// Returns upper bounds of the energies rᵀ A⁻¹ r of the flows `missing` into the nodes: the powers of flows along
    /// the tree that supply them. `flows` is overwritten.
    pub(crate) fn bound<const N: usize>(&self, missing: &[[f64; N]], flows: &mut [[f64; N]]) -> [f64; N] {
        flows.copy_from_slice(missing);
        let mut powers = [0.0; N];
        for Step { node, parent, resistance } in &self.steps {
            let flow = flows[*node as usize];
            (0..N).for_each(|k| powers[k] += flow[k] * flow[k] * resistance);
            if (*parent as usize) < self.nodes {
                let sum = &mut flows[*parent as usize];
                (0..N).for_each(|k| sum[k] += flow[k]);
            }
        }
        powers
    }
}

/// Degrees of the nodes of a forest, and for each node the exclusive or of its neighbours and of the weights of its
/// edges: a node of degree 1 knows its neighbour.
struct Links {
    degrees: Vec<u32>,
    ends: Vec<u32>,
    weights: Vec<u64>,
}

impl Links {
    fn new(nodes: usize) -> Self {
        Self { degrees: vec![0; nodes], ends: vec![0; nodes], weights: vec![0; nodes] }
    }

    fn join(&mut self, a: u32, b: u32, weight: f64) {
        for (here, there) in [(a, b), (b, a)] {
            let here = here as usize;
            self.degrees[here] += 1;
            self.ends[here] ^= there;
            self.weights[here] ^= weight.to_bits();
        }
    }

    /// Strips the leaves one after the other, except for the node `kept`.
    fn stripped(mut self, kept: usize) -> Vec<Step> {
        let mut steps = Vec::with_capacity(kept);
        for first in 0..kept {
            let mut node = first;
            while node != kept && self.degrees[node] == 1 {
                let (parent, weight) = (self.ends[node], self.weights[node]);
                steps.push(Step { node: node as u32, parent, resistance: f64::from_bits(weight).recip() });
                self.degrees[node] = 0;
                let above = parent as usize;
                self.degrees[above] -= 1;
                self.ends[above] ^= node as u32;
                self.weights[above] ^= weight;
                // Nodes after `first` have their turn.
                if above > first {
                    break;
                }
                node = above;
            }
        }
        steps
    }
}

/// Returns the edges from the strongest to the weakest, each once; the reservoir has the number after the last node.
fn sorted(graph: &Graph) -> Vec<[u32; 2]> {
    let nodes = graph.len();
    let each = |visit: &mut dyn FnMut(usize, usize, f64)| {
        for node in 0..nodes {
            graph.row(node).filter(|(end, _)| *end > node).for_each(|(end, weight)| visit(node, end, weight));
            visit(node, nodes, graph.outside(node));
        }
    };
    let class = |weight: f64| (weight.to_bits() >> SHIFT) as usize;
    let mut counts = Vec::new();
    let mut total = 0;
    each(&mut |_, _, weight| {
        if weight > 0.0 {
            if class(weight) >= counts.len() {
                counts.resize(class(weight) + 1, 0);
            }
            counts[class(weight)] += 1;
            total += 1;
        }
    });
    let mut next: Vec<usize> = vec![0; counts.len()];
    (0..counts.len()).rev().fold(0, |start, class| {
        next[class] = start;
        start + counts[class]
    });
    let mut edges = vec![[0; 2]; total];
    each(&mut |a, b, weight| {
        if weight > 0.0 {
            edges[next[class(weight)]] = [a as u32, b as u32];
            next[class(weight)] += 1;
        }
    });
    edges
}

/// Returns the weight of an edge.
fn weight(graph: &Graph, a: usize, b: usize) -> f64 {
    let to = |end: usize| graph.row(a).find(|edge| edge.0 == end).map_or(0.0, |edge| edge.1);
    if b == graph.len() { graph.outside(a) } else { to(b) }
}

/// Returns the first node of the group of a node.
fn root(groups: &mut [u32], mut node: u32) -> u32 {
    while groups[node as usize] != node {
        let above = groups[groups[node as usize] as usize];
        groups[node as usize] = above;
        node = above;
    }
    node
}
