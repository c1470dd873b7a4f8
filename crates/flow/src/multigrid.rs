//! Multigrid for the Laplacian of a weighted graph: aggregates of four or so strongly connected nodes, Gauss–Seidel sweeps, and two
//! conjugate-gradient steps on each coarser level (K-cycle; Notay, Electron. Trans. Numer. Anal. 37 (2010) 123).

/// A node's weight to a neighbour, relative to its largest, below which it is not joined with that neighbour.
const STRONG: f64 = 0.25;

/// The most nodes of the coarsest graph, whose equations are solved directly.
const COARSEST: usize = 200;

/// A level must have less than this share of the nodes of the level before.
const SHRINKAGE: f64 = 0.8;

/// The second step on a coarser level is left out if the first leaves this part of the residual.
const ENOUGH: f64 = 0.25;

/// A graph with weights on its edges, and conductances of its nodes to a reservoir.
#[derive(Clone, Debug, Default)]
pub(crate) struct Graph {
    /// The edges of node i are `starts[i]..starts[i + 1]`.
    starts: Vec<usize>,
    ends: Vec<u32>,
    weights: Vec<f64>,
    /// The weight of each node to the reservoir.
    outside: Vec<f64>,
    /// The sum of the weights of each node, with that to the reservoir.
    diagonal: Vec<f64>,
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
            graph.diagonal.push(row.iter().map(|edge| edge.1).sum::<f64>() + outside);
            graph.ends.extend(row.iter().map(|edge| edge.0));
            graph.weights.extend(row.iter().map(|edge| edge.1));
            graph.starts.push(graph.ends.len());
        }
        graph
    }

    pub(crate) fn len(&self) -> usize {
        self.diagonal.len()
    }

    fn row(&self, node: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.starts[node]..self.starts[node + 1];
        self.ends[range.clone()].iter().map(|end| *end as usize).zip(self.weights[range].iter().copied())
    }

    /// `out` ← A x, which is what flows out of each node.
    pub(crate) fn apply(&self, x: &[f64], out: &mut [f64]) {
        for (node, out) in out.iter_mut().enumerate() {
            *out = self.diagonal[node] * x[node] - self.row(node).map(|(end, weight)| weight * x[end]).sum::<f64>();
        }
    }

    /// Joins nodes in pairs, each with the strongest of its neighbours that are still alone; one that finds none joins its
    /// strongest neighbour. Returns the number of the aggregate of each node, and the number of aggregates.
    fn pairs(&self) -> (Vec<u32>, usize) {
        const ALONE: u32 = u32::MAX;
        let mut aggregates = vec![ALONE; self.len()];
        let mut count = 0;
        for node in 0..self.len() {
            if aggregates[node] != ALONE {
                continue;
            }
            let (mut strongest, mut free) = ((node, 0.0), (node, 0.0));
            for (end, weight) in self.row(node).filter(|(end, _)| *end != node) {
                if weight > strongest.1 {
                    strongest = (end, weight);
                }
                if weight > free.1 && aggregates[end] == ALONE {
                    free = (end, weight);
                }
            }
            if free.1 < STRONG * strongest.1 && aggregates[strongest.0] != ALONE {
                aggregates[node] = aggregates[strongest.0];
                continue;
            }
            aggregates[node] = count;
            aggregates[free.0] = count;
            count += 1;
        }
        (aggregates, count as usize)
    }

    /// The graph of aggregates: weights between two of them are added up.
    fn joined(&self, aggregates: &[u32], count: usize) -> Self {
        // Nodes in the order of their aggregates.
        let mut first = vec![0_usize; count + 1];
        aggregates.iter().for_each(|aggregate| first[*aggregate as usize + 1] += 1);
        (0..count).for_each(|k| first[k + 1] += first[k]);
        let mut next = first.clone();
        let mut members = vec![0_u32; self.len()];
        for (node, aggregate) in aggregates.iter().enumerate() {
            members[next[*aggregate as usize]] = node as u32;
            next[*aggregate as usize] += 1;
        }
        let mut place = vec![usize::MAX; count];
        Self::new(count, |aggregate, row| {
            let mut outside = 0.0;
            for &node in &members[first[aggregate]..first[aggregate + 1]] {
                for (end, weight) in self.row(node as usize) {
                    let other = aggregates[end] as usize;
                    if other == aggregate {
                        continue;
                    }
                    match row.get_mut(place[other]).filter(|edge| edge.0 as usize == other) {
                        Some(edge) => edge.1 += weight,
                        None => {
                            place[other] = row.len();
                            row.push((other as u32, weight));
                        }
                    }
                }
                outside += self.outside[node as usize];
            }
            outside
        })
    }
}

/// A level with the memory of its part of a cycle.
struct Level {
    graph: Graph,
    /// The node of the next level that each node is part of; empty on the coarsest.
    aggregates: Vec<u32>,
    /// Right-hand side and solution of the equations on this level.
    residual: Vec<f64>,
    solution: Vec<f64>,
    /// Two corrections and their images.
    corrections: [Vec<f64>; 2],
    images: [Vec<f64>; 2],
    /// Residual within a cycle.
    left: Vec<f64>,
}

/// The hierarchy of graphs of one problem, a preconditioner.
pub(crate) struct Multigrid {
    levels: Vec<Level>,
    coarsest: Elimination,
}

impl Multigrid {
    pub(crate) fn new(graph: Graph) -> Self {
        let mut levels = Vec::new();
        let mut graph = graph;
        loop {
            let n = graph.len();
            let mut next = None;
            if n > COARSEST {
                let (pairs, count) = graph.pairs();
                let half = graph.joined(&pairs, count);
                let (again, fewer) = half.pairs();
                if (fewer as f64) < SHRINKAGE * n as f64 {
                    let aggregates = pairs.iter().map(|pair| again[*pair as usize]).collect::<Vec<_>>();
                    next = Some((half.joined(&again, fewer), aggregates));
                }
            }
            let (coarser, aggregates) = next.map_or((None, Vec::new()), |(coarser, of)| (Some(coarser), of));
            let zeros = || vec![0.0; n];
            // The finest level has no equations of its own: those are of the caller.
            let own = || if levels.is_empty() { Vec::new() } else { zeros() };
            levels.push(Level {
                residual: own(),
                solution: own(),
                corrections: [own(), own()],
                images: [own(), own()],
                left: zeros(),
                graph,
                aggregates,
            });
            match coarser {
                Some(coarser) => graph = coarser,
                None => break,
            }
        }
        let coarsest = levels.last().map_or_else(Elimination::default, |level| Elimination::of(&level.graph));
        Self { levels, coarsest }
    }

    pub(crate) fn graph(&self) -> &Graph {
        &self.levels[0].graph
    }

    /// `out` ← about A⁻¹ `residual`, by one cycle.
    pub(crate) fn precondition(&mut self, residual: &[f64], out: &mut [f64]) {
        cycle(&mut self.levels, &self.coarsest, residual, out);
    }
}

/// A sweep forward, a correction by the coarser level, and a sweep backward.
fn cycle(levels: &mut [Level], coarsest: &Elimination, residual: &[f64], out: &mut [f64]) {
    let Some((level, coarser)) = levels.split_first_mut() else { return };
    let Level { graph, aggregates, left, .. } = level;
    let Some(next) = coarser.first_mut() else {
        coarsest.solve(graph, residual, out);
        return;
    };
    for node in 0..graph.len() {
        let before: f64 = graph.row(node).filter(|(end, _)| *end < node).map(|(end, weight)| weight * out[end]).sum();
        out[node] = (residual[node] + before) / graph.diagonal[node];
    }
    // After the sweep from zero, the residual is what the later nodes have added.
    next.residual.fill(0.0);
    for (node, aggregate) in aggregates.iter().enumerate() {
        let later: f64 = graph.row(node).filter(|(end, _)| *end > node).map(|(end, weight)| weight * out[end]).sum();
        left[node] = later;
        next.residual[*aggregate as usize] += later;
    }
    two_steps(coarser, coarsest);
    let correction = &coarser[0].solution;
    out.iter_mut().zip(aggregates).for_each(|(out, aggregate)| *out += correction[*aggregate as usize]);
    for node in (0..graph.len()).rev() {
        let around: f64 = graph.row(node).map(|(end, weight)| weight * out[end]).sum();
        out[node] = (residual[node] + around) / graph.diagonal[node];
    }
}

/// One or two steps of conjugate gradients on the first of `levels`, each with a cycle as preconditioner: its solution for its
/// residual.
fn two_steps(levels: &mut [Level], coarsest: &Elimination) {
    if levels.len() == 1 {
        let Level { graph, residual, solution, .. } = &mut levels[0];
        coarsest.solve(graph, residual, solution);
        return;
    }
    let mut residual = std::mem::take(&mut levels[0].residual);
    let [mut first, mut second] = std::mem::take(&mut levels[0].corrections);
    let [mut first_image, mut second_image] = std::mem::take(&mut levels[0].images);
    let mut solution = std::mem::take(&mut levels[0].solution);

    cycle(levels, coarsest, &residual, &mut first);
    levels[0].graph.apply(&first, &mut first_image);
    let (along, work) = (dot(&first, &residual), dot(&first, &first_image));
    let before = dot(&residual, &residual);
    let step = if work > 0.0 { along / work } else { 0.0 };
    residual.iter_mut().zip(&first_image).for_each(|(r, image)| *r -= step * image);
    solution.iter_mut().zip(&first).for_each(|(x, c)| *x = step * c);
    if work > 0.0 && dot(&residual, &residual) > ENOUGH * ENOUGH * before {
        cycle(levels, coarsest, &residual, &mut second);
        levels[0].graph.apply(&second, &mut second_image);
        let mixed = dot(&second, &first_image);
        let rest = dot(&second, &second_image) - mixed * mixed / work;
        if rest > 0.0 {
            let step = dot(&second, &residual) / rest;
            let pairs = first.iter().zip(&second);
            solution.iter_mut().zip(pairs).for_each(|(x, (c, d))| *x += step * (d - mixed / work * c));
        }
    }

    let level = &mut levels[0];
    (level.residual, level.solution) = (residual, solution);
    (level.corrections, level.images) = ([first, second], [first_image, second_image]);
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The factors of the equations of the coarsest level, from eliminating one node after the other: its neighbours are then
/// connected through it. No differences are formed (Grassmann, Taksar and Heyman 1985), so that a part of the graph that hangs
/// on the rest by the weakest edge is resolved. The last node of a part without a reservoir has no edge left: its value is zero.
#[derive(Default)]
struct Elimination {
    /// The weight of each node to each later node when it is eliminated, over their sum, row by row.
    shares: Vec<f64>,
    /// That sum, with the weight to the reservoir.
    sums: Vec<f64>,
}

impl Elimination {
    /// Empty factors of a graph that is too large, since its nodes could not be joined.
    fn of(graph: &Graph) -> Self {
        let n = graph.len();
        if n > 4 * COARSEST {
            return Self::default();
        }
        let mut weights = vec![0.0; n * n];
        let mut outside = graph.outside.clone();
        for node in 0..n {
            graph.row(node).filter(|(end, _)| *end != node).for_each(|(end, weight)| weights[node * n + end] += weight);
        }
        let mut sums = vec![0.0; n];
        for i in 0..n {
            let (done, later) = weights.split_at_mut((i + 1) * n);
            let row = &mut done[i * n..];
            let sum = row[i + 1..].iter().sum::<f64>() + outside[i];
            sums[i] = sum;
            if sum == 0.0 {
                continue;
            }
            for j in i + 1..n {
                let weight = row[j];
                if weight > 0.0 {
                    outside[j] += weight * (outside[i] / sum);
                    let of_neighbour = &mut later[(j - i - 1) * n..(j - i) * n];
                    (i + 1..n).filter(|k| *k != j).for_each(|k| of_neighbour[k] += weight * (row[k] / sum));
                }
            }
            row[i + 1..].iter_mut().for_each(|weight| *weight /= sum);
        }
        Self { shares: weights, sums }
    }

    fn solve(&self, graph: &Graph, residual: &[f64], out: &mut [f64]) {
        let n = self.sums.len();
        if n < graph.len() {
            out.iter_mut().zip(residual).zip(&graph.diagonal).for_each(|((x, r), d)| *x = r / d);
            return;
        }
        out.copy_from_slice(residual);
        for i in 0..n {
            let (done, later) = out.split_at_mut(i + 1);
            let shares = &self.shares[i * n + i + 1..(i + 1) * n];
            later.iter_mut().zip(shares).for_each(|(x, share)| *x += share * done[i]);
        }
        for i in (0..n).rev() {
            let shares = &self.shares[i * n + i + 1..(i + 1) * n];
            let known: f64 = shares.iter().zip(&out[i + 1..]).map(|(share, x)| share * x).sum();
            out[i] = if self.sums[i] > 0.0 { out[i] / self.sums[i] + known } else { 0.0 };
        }
    }
}
