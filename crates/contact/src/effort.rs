use std::fmt;

/// The effort of a solve: a number that does not depend on the machine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effort {
    /// Iterations, or time steps.
    pub iterations: u64,
    /// Forward and inverse real transforms of one component on the full grid, in pairs; those of the certificate
    /// included. Half a pair is a transform one way.
    pub transform_pairs: f64,
}

impl fmt::Display for Effort {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} iterations, {} transform pairs", self.iterations, self.transform_pairs)
    }
}
