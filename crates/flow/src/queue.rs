//! Nodes of a graph, sorted by their number of edges.

/// Marks the absence of a node or an edge.
pub(crate) const NONE: u32 = u32::MAX;

/// Remaining nodes, in one list per number of edges.
pub(crate) struct Queue {
    /// First node of each list; the last list holds all larger numbers of edges.
    firsts: Vec<u32>,
    degrees: Vec<u32>,
    before: Vec<u32>,
    after: Vec<u32>,
    lowest: usize,
}

impl Queue {
    /// Number of lists.
    const LISTS: usize = 64;

    pub(crate) fn new(degrees: Vec<u32>) -> Self {
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

    /// Adds `change` to the number of edges of a node.
    pub(crate) fn add(&mut self, node: usize, change: i32) {
        let degree = self.degrees[node].saturating_add_signed(change);
        if (degree as usize).min(Self::LISTS - 1) == self.list(node) {
            self.degrees[node] = degree;
            return;
        }
        self.remove(node);
        self.degrees[node] = degree;
        self.insert(node);
    }

    /// Removes and returns a node with the smallest number of edges.
    pub(crate) fn pop(&mut self) -> Option<usize> {
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
