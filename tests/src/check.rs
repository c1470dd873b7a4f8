use gfmd_body::InteriorError;
use gfmd_contact::{Refusal, Solution, SolveError, SqueezedSolution, SteepSolution};
use gfmd_field::{GridError, ShapeError};
use gfmd_green::GreenError;
use gfmd_interface::{QuasistaticState, State};
use gfmd_law::LawError;
use gfmd_mixed::MixedError;
use gfmd_surface::SurfaceError;

use crate::Reference;

/// Value and the bound that it must meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Quantity that is compared.
    pub name: String,
    /// Origin of the expected values.
    pub source: &'static str,
    /// Error, relative unless the name says otherwise, or order of convergence.
    pub value: f64,
    /// Bound of the value.
    pub bound: Bound,
}

/// Upper or lower bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// Upper bound of an error.
    AtMost(f64),
    /// Lower bound of an order of convergence or of a ratio.
    AtLeast(f64),
}

/// Checks that belong together.
#[derive(Clone, Copy, Debug)]
pub struct Topic {
    /// Name of its file here and of its test.
    pub name: &'static str,
    /// Title in docs/validation.md.
    pub title: &'static str,
    /// Function that computes the checks.
    pub checks: fn(&Reference) -> Result<Vec<Check>, ValidationError>,
}

/// Reasons why a check could not be computed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ValidationError {
    /// A reference file that is missing or has unexpected contents.
    #[error("{file}: {reason}")]
    Reference {
        /// Path of the file.
        file: String,
        /// Reason of the failure.
        reason: String,
    },
    /// A contact that could not be solved.
    #[error(transparent)]
    Contact(#[from] SolveError<Solution>),
    /// A contact with finite slopes that could not be solved.
    #[error(transparent)]
    Steep(#[from] SolveError<SteepSolution>),
    /// A slab between two surfaces that could not be solved.
    #[error(transparent)]
    Squeezed(#[from] SolveError<SqueezedSolution>),
    /// A contact that could not be posed.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// An invalid body.
    #[error(transparent)]
    Green(#[from] GreenError),
    /// An invalid grid.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// A contact with a law that did not reach equilibrium.
    #[error(transparent)]
    Interface(#[from] SolveError<State>),
    /// A contact made of parts that did not reach equilibrium.
    #[error(transparent)]
    Quasistatic(#[from] SolveError<QuasistaticState>),
    /// Invalid parameters of a law.
    #[error(transparent)]
    Law(#[from] LawError),
    /// Fields inside that could not be computed.
    #[error(transparent)]
    Interior(#[from] InteriorError),
    /// A punch that could not be pressed.
    #[error(transparent)]
    Mixed(#[from] MixedError),
    /// Slices that do not fit.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// An invalid surface.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
}

impl Check {
    /// Makes a check of an error that must not exceed `bound`.
    pub fn error(name: impl Into<String>, source: &'static str, value: f64, bound: f64) -> Self {
        Self { name: name.into(), source, value, bound: Bound::AtMost(bound) }
    }

    /// Makes a check of a value that must reach `bound`: an order of convergence, or a ratio.
    pub fn at_least(name: impl Into<String>, source: &'static str, value: f64, bound: f64) -> Self {
        Self { name: name.into(), source, value, bound: Bound::AtLeast(bound) }
    }

    /// Returns true if the bound is met. NaN meets no bound.
    pub fn passes(&self) -> bool {
        match self.bound {
            Bound::AtMost(bound) => self.value <= bound,
            Bound::AtLeast(bound) => self.value >= bound,
        }
    }
}

/// Largest error of several comparisons.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Worst(f64);

impl Worst {
    /// Starts an empty comparison, which fails its check.
    pub(crate) fn new() -> Self {
        Self(f64::NEG_INFINITY)
    }

    /// Compares relative to the magnitude of the wanted value.
    pub(crate) fn compare(&mut self, found: f64, wanted: f64) {
        self.compare_to(found, wanted, wanted.abs());
    }

    /// Compares relative to `scale`.
    pub(crate) fn compare_to(&mut self, found: f64, wanted: f64, scale: f64) {
        let error = if found == wanted { 0.0 } else { (found - wanted).abs() / scale };
        if error.is_nan() || error > self.0 {
            self.0 = error;
        }
    }

    /// Makes the check of the largest error. It fails if nothing was compared.
    pub(crate) fn check(self, name: impl Into<String>, source: &'static str, bound: f64) -> Check {
        let value = if self.0 == f64::NEG_INFINITY { f64::NAN } else { self.0 };
        Check::error(name, source, value, bound)
    }
}

/// Returns the order at which errors fall with the number of points, by least squares in logarithms.
pub(crate) fn order<const K: usize>(errors: &[(usize, [f64; K])]) -> [f64; K] {
    let points: Vec<(f64, [f64; K])> = errors.iter().map(|(n, e)| ((*n as f64).ln(), e.map(|e| -e.ln()))).collect();
    let x = points.iter().map(|p| p.0).sum::<f64>() / points.len() as f64;
    let squares: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    std::array::from_fn(|k| points.iter().map(|p| (p.0 - x) * p.1[k]).sum::<f64>() / squares)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_number_or_was_never_compared_fails() {
        assert!(!Worst::new().check("nothing", "", 1.0).passes());
        let mut worst = Worst::new();
        worst.compare(2.0, f64::NAN);
        worst.compare(1.0, 1.0);
        assert!(!worst.check("lost", "", 1.0).passes());
        let mut worst = Worst::new();
        worst.compare(1.0, 1.0);
        worst.compare(1.1, 1.0);
        assert!(worst.check("far", "", 0.11).passes() && !worst.check("far", "", 0.09).passes());
        assert!(!Check::at_least("slow", "", 0.5, 1.0).passes());
    }

    #[test]
    fn the_order_of_a_power_is_its_exponent() {
        let errors: Vec<_> = [8, 16, 40].map(|n| (n, [3.0 * (n as f64).powf(-1.5)])).into();
        assert!((order(&errors)[0] - 1.5).abs() < 1e-14);
    }
}
