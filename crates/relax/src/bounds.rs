//! Bounds of a landscape: a lower and an upper bound for each entry.

use std::ops::Range;

use gfmd_vector::{for_each, reduce};

use crate::RelaxError;

/// Bounds of the entries of `u`. Vectors contain one bound per entry in the unit of `u`; ±∞ means no bound, and equal
/// bounds fix the entry.
///
/// Bounds are data, not a function, so that clipping, masking and moving take one sweep over the vectors. Both the
/// bounds and the methods of this crate, with their scalar mass, act on each entry separately. This is necessary for
/// clipped steps to stop at the constrained minimum (theory.md, section 6.3).
#[derive(Clone, Copy, Debug)]
pub enum Bounds<'a> {
    /// Every value is allowed.
    Free,
    /// uᵢ ≤ upperᵢ.
    Upper(&'a [f64]),
    /// lowerᵢ ≤ uᵢ ≤ upperᵢ.
    Between {
        /// Smallest allowed values.
        lower: &'a [f64],
        /// Largest allowed values.
        upper: &'a [f64],
    },
}

impl Bounds<'_> {
    /// Replaces each entry of `u` by the nearest allowed value. NaN stays NaN.
    ///
    /// # Panics
    /// If `u` and the bounds differ in length.
    pub fn project(&self, u: &mut [f64]) {
        fn clip(wall: impl Wall, u: &mut [f64]) {
            for_each([u], &|start, [u]| {
                let wall = wall.stretch(start..start + u.len());
                for (k, u) in u.iter_mut().enumerate() {
                    *u = wall.clip(k, *u);
                }
            });
        }
        within!(*self, wall => clip(wall, u));
    }

    /// Returns max |rᵢ| of the natural residual r = clamp(f / `force_scale`, (lower − u) / `length_scale`, (upper − u)
    /// / `length_scale`), which vanishes exactly at the constrained minimum (theory.md, section 6.6). It measures
    /// forces on free entries, forces that pull entries off bounds, and violated bounds. NaN if any entry is NaN.
    ///
    /// # Panics
    /// If `u`, `force` and the bounds differ in length.
    pub fn natural_residual(&self, u: &[f64], force: &[f64], force_scale: f64, length_scale: f64) -> f64 {
        fn largest(wall: impl Wall, u: &[f64], force: &[f64], length_per_force: f64) -> f64 {
            assert_eq!(u.len(), force.len(), "displacement and force have equal lengths");
            let leaf = |range: Range<usize>| {
                let (wall, u, force) = (wall.stretch(range.clone()), &u[range.clone()], &force[range]);
                u.iter().zip(force).enumerate().fold(0, |largest, (k, (&u, &f))| {
                    let (down, up) = wall.distances(k, u);
                    let residual = if u.is_nan() { u } else { clamp(f * length_per_force, down, up) };
                    // Bit patterns of positive numbers are ordered like the numbers, with NaN last.
                    u64::max(largest, residual.abs().to_bits())
                })
            };
            f64::from_bits(reduce(u.len(), &leaf, &u64::max))
        }
        let length_per_force = length_scale / force_scale;
        within!(*self, wall => largest(wall, u, force, length_per_force)) / length_scale
    }

    /// Returns true if the bound of entry `index` is active: the entry lies on it, and its force does not pull it off.
    ///
    /// # Panics
    /// If `index` is out of range.
    pub fn holds(&self, index: usize, u: f64, force: f64) -> bool {
        within!(*self, wall => wall.holds(index, u, force))
    }

    /// Checks that there is one bound per entry, that none is NaN, and that no lower bound exceeds the upper bound.
    pub(crate) fn check(&self, length: usize) -> Result<(), RelaxError> {
        self.check_length(length)?;
        let wrong = match *self {
            Self::Free => None,
            Self::Upper(upper) => upper.iter().position(|z| z.is_nan()).map(|i| (i, f64::NEG_INFINITY, upper[i])),
            Self::Between { lower, upper } => {
                let ordered = |(a, z): (&f64, &f64)| a <= z;
                lower.iter().zip(upper).position(|pair| !ordered(pair)).map(|i| (i, lower[i], upper[i]))
            }
        };
        wrong.map_or(Ok(()), |(index, lower, upper)| Err(RelaxError::Bounds { index, lower, upper }))
    }

    pub(crate) fn check_length(&self, length: usize) -> Result<(), RelaxError> {
        let fits = |what, bound: &[f64]| RelaxError::check_length(what, bound.len(), length);
        match *self {
            Self::Free => Ok(()),
            Self::Upper(upper) => fits("upper bounds", upper),
            Self::Between { lower, upper } => {
                fits("lower bounds", lower)?;
                fits("upper bounds", upper)
            }
        }
    }
}

/// Evaluates an expression with `wall` set to the [`Wall`] of the bounds, in one copy per kind of bounds.
macro_rules! within {
    ($bounds:expr, $wall:ident => $body:expr) => {
        match $bounds {
            $crate::Bounds::Free => {
                let $wall = $crate::bounds::Open;
                $body
            }
            $crate::Bounds::Upper(upper) => {
                let $wall = $crate::bounds::Under(upper);
                $body
            }
            $crate::Bounds::Between { lower, upper } => {
                let $wall = $crate::bounds::Inside(lower, upper);
                $body
            }
        }
    };
}
pub(crate) use within;

/// Bounds in inner loops. There is one type per kind, so no loop branches on the kind or reads an unnecessary vector.
pub(crate) trait Wall: Copy + Sync {
    /// Returns the wall of the entries in `range`.
    fn stretch(self, range: Range<usize>) -> Self;
    /// Returns the nearest allowed value.
    fn clip(self, k: usize, u: f64) -> f64;
    /// Returns true if u lies on its bound.
    fn touches(self, k: usize, u: f64) -> bool;
    /// Returns true if u lies on its bound and the force does not pull it off.
    fn holds(self, k: usize, u: f64, force: f64) -> bool;
    /// Returns the distances of u from its bounds, down (≤ 0) and up (≥ 0).
    fn distances(self, k: usize, u: f64) -> (f64, f64);
}

#[derive(Clone, Copy)]
pub(crate) struct Open;

#[derive(Clone, Copy)]
pub(crate) struct Under<'a>(pub(crate) &'a [f64]);

#[derive(Clone, Copy)]
pub(crate) struct Inside<'a>(pub(crate) &'a [f64], pub(crate) &'a [f64]);

impl Wall for Open {
    fn stretch(self, _: Range<usize>) -> Self {
        self
    }

    fn clip(self, _: usize, u: f64) -> f64 {
        u
    }

    fn touches(self, _: usize, _: f64) -> bool {
        false
    }

    fn holds(self, _: usize, _: f64, _: f64) -> bool {
        false
    }

    fn distances(self, _: usize, _: f64) -> (f64, f64) {
        (f64::NEG_INFINITY, f64::INFINITY)
    }
}

impl Wall for Under<'_> {
    fn stretch(self, range: Range<usize>) -> Self {
        Self(&self.0[range])
    }

    fn clip(self, k: usize, u: f64) -> f64 {
        clamp(u, f64::NEG_INFINITY, self.0[k])
    }

    fn touches(self, k: usize, u: f64) -> bool {
        u >= self.0[k]
    }

    fn holds(self, k: usize, u: f64, force: f64) -> bool {
        u >= self.0[k] && force >= 0.0
    }

    fn distances(self, k: usize, u: f64) -> (f64, f64) {
        (f64::NEG_INFINITY, self.0[k] - u)
    }
}

impl Wall for Inside<'_> {
    fn stretch(self, range: Range<usize>) -> Self {
        Self(&self.0[range.clone()], &self.1[range])
    }

    fn clip(self, k: usize, u: f64) -> f64 {
        clamp(u, self.0[k], self.1[k])
    }

    fn touches(self, k: usize, u: f64) -> bool {
        u <= self.0[k] || u >= self.1[k]
    }

    fn holds(self, k: usize, u: f64, force: f64) -> bool {
        (u >= self.1[k] && force >= 0.0) || (u <= self.0[k] && force <= 0.0)
    }

    fn distances(self, k: usize, u: f64) -> (f64, f64) {
        (self.0[k] - u, self.1[k] - u)
    }
}

/// Clamps like `f64::clamp`, but without panics. NaN stays NaN, while `f64::min` would return the bound and hide it.
fn clamp(x: f64, lower: f64, upper: f64) -> f64 {
    let x = if x > upper { upper } else { x };
    if x < lower { lower } else { x }
}
