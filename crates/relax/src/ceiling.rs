//! Upper bounds of variables.

use std::ops::Range;
use std::sync::Arc;

use gfmd_vector::{Share, Split};

/// The upper bounds of the variables of a problem.
#[derive(Clone, Debug)]
pub enum Upper {
    /// One for all variables, infinite if there is none.
    All(f64),
    /// One for each, finite.
    Each(Arc<[f64]>),
}

impl Upper {
    /// The bounds, to be cut into stretches.
    pub fn ceiling(&self) -> Ceiling<'_> {
        match self {
            Self::All(bound) => Ceiling::All(*bound),
            Self::Each(bounds) => Ceiling::Each(bounds),
        }
    }

    /// The mean of the bounds.
    pub fn mean(&self) -> f64 {
        match self {
            Self::All(bound) => *bound,
            Self::Each(bounds) => self.mean_over(&Share::whole(bounds.len(), 1)),
        }
    }

    /// The mean of the bounds of all processes, of which these are those of a `share`.
    pub fn mean_over(&self, share: &Share) -> f64 {
        match self {
            Self::All(bound) => *bound,
            Self::Each(bounds) => share.total_of(bounds) / share.total() as f64,
        }
    }

    /// The bounds times a factor.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        match self {
            Self::All(bound) => Self::All(bound * factor),
            Self::Each(bounds) => Self::Each(bounds.iter().map(|bound| bound * factor).collect()),
        }
    }
}

/// The upper bounds of a stretch of variables.
#[derive(Clone, Copy, Debug)]
pub enum Ceiling<'a> {
    /// One for all variables.
    All(f64),
    /// One for each.
    Each(&'a [f64]),
}

impl<'a> Ceiling<'a> {
    /// The bound of the variable with this index in the stretch.
    #[inline]
    pub fn at(self, index: usize) -> f64 {
        match self {
            Self::All(bound) => bound,
            Self::Each(bounds) => bounds[index],
        }
    }

    /// True if there is a bound.
    pub fn is_finite(self) -> bool {
        match self {
            Self::All(bound) => bound.is_finite(),
            Self::Each(_) => true,
        }
    }

    /// The bounds of a part of the stretch.
    #[must_use]
    pub fn part(self, range: Range<usize>) -> Ceiling<'a> {
        match self {
            Self::All(_) => self,
            Self::Each(bounds) => Self::Each(&bounds[range]),
        }
    }

    /// The highest bound of all processes.
    pub(crate) fn highest(self, share: &Share) -> f64 {
        match self {
            Self::All(bound) => bound,
            Self::Each(bounds) => {
                share.each(bounds.iter().copied().fold(0.0, f64::max)).into_iter().fold(0.0, f64::max)
            }
        }
    }
}

impl Split for Ceiling<'_> {
    fn length(&self) -> usize {
        match self {
            // One bound is that of any number of variables, as `()`.
            Self::All(_) => usize::MAX,
            Self::Each(bounds) => bounds.len(),
        }
    }

    fn fits(&self, length: usize) -> bool {
        matches!(self, Self::All(_)) || self.length() == length
    }

    fn split(self, middle: usize) -> (Self, Self) {
        match self {
            Self::All(_) => (self, self),
            Self::Each(bounds) => {
                let (first, last) = bounds.split_at(middle);
                (Self::Each(first), Self::Each(last))
            }
        }
    }
}
