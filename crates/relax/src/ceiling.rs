//! Upper bounds of variables.

use std::ops::Range;
use std::sync::Arc;

use gfmd_vector::{Share, Split};

/// Upper bounds of the variables of a problem.
#[derive(Clone, Debug)]
pub enum Upper {
    /// One bound for all variables; infinite if there is none.
    All(f64),
    /// One finite bound for each variable.
    Each(Arc<[f64]>),
}

impl Upper {
    /// Returns the bounds in a form that can be split into stretches.
    pub fn ceiling(&self) -> Ceiling<'_> {
        match self {
            Self::All(bound) => Ceiling::All(*bound),
            Self::Each(bounds) => Ceiling::Each(bounds),
        }
    }

    /// Returns the mean of the bounds.
    pub fn mean(&self) -> f64 {
        match self {
            Self::All(bound) => *bound,
            Self::Each(bounds) => self.mean_over(&Share::whole(bounds.len(), 1)),
        }
    }

    /// Returns the mean over all processes, if these are the bounds of one `share`.
    pub fn mean_over(&self, share: &Share) -> f64 {
        match self {
            Self::All(bound) => *bound,
            Self::Each(bounds) => share.total_of(bounds) / share.total() as f64,
        }
    }

    /// Returns the bounds multiplied by `factor`.
    #[must_use]
    pub fn times(&self, factor: f64) -> Self {
        match self {
            Self::All(bound) => Self::All(bound * factor),
            Self::Each(bounds) => Self::Each(bounds.iter().map(|bound| bound * factor).collect()),
        }
    }
}

/// Upper bounds of a stretch of variables.
#[derive(Clone, Copy, Debug)]
pub enum Ceiling<'a> {
    /// One bound for all variables.
    All(f64),
    /// One bound for each variable.
    Each(&'a [f64]),
}

impl<'a> Ceiling<'a> {
    /// Returns the bound of the variable with this index in the stretch.
    #[inline]
    pub fn at(self, index: usize) -> f64 {
        match self {
            Self::All(bound) => bound,
            Self::Each(bounds) => bounds[index],
        }
    }

    /// Returns true if there is a bound.
    pub fn is_finite(self) -> bool {
        match self {
            Self::All(bound) => bound.is_finite(),
            Self::Each(_) => true,
        }
    }

    /// Returns the bounds of a part of the stretch.
    #[must_use]
    pub fn part(self, range: Range<usize>) -> Ceiling<'a> {
        match self {
            Self::All(_) => self,
            Self::Each(bounds) => Self::Each(&bounds[range]),
        }
    }

    /// Returns the highest bound of all processes.
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
            // One bound fits any number of variables, like `()`.
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
