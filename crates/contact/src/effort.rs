use std::fmt;

use gfmd_relax::{Variables, Visit};

/// Effort of a solve, independent of the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Effort {
    /// Number of iterations or time steps.
    pub iterations: u64,
    /// Number of pairs of a forward and an inverse real transform of one component on the full grid, including the
    /// transforms of the certificate. A single transform is half a pair.
    pub transform_pairs: f64,
}

impl Effort {
    /// Adds the effort of another part of a solve.
    pub(crate) fn add(&mut self, other: Self) {
        self.iterations += other.iterations;
        self.transform_pairs += other.transform_pairs;
    }
}

impl Variables for Effort {
    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.count(&mut self.iterations);
        visitor.number(&mut self.transform_pairs);
    }
}

impl fmt::Display for Effort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} iterations, {} transform pairs", self.iterations, self.transform_pairs)
    }
}
