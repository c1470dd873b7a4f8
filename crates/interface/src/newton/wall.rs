use gfmd_vector::{Share, add, for_each};

use crate::frame::Frame;
use crate::numbers::reduce;

/// Allowed displacements: w_z not above the hard wall, and mean 0 in components with a held mean.
pub(crate) struct Wall {
    /// Upper bounds of w_z; `None` for a law without a wall.
    bound: Option<Vec<f64>>,
    held: Vec<bool>,
    points: usize,
    share: Share,
    /// Means below this length times ε count as 0.
    length_scale: f64,
}

/// Maximum number of rounds to restore a mean; a few suffice.
const ROUNDS: usize = 50;

impl Wall {
    pub(crate) fn new(frame: &Frame, is_hard: bool, length_scale: f64) -> Self {
        let bound = is_hard.then(|| frame.wall().collect());
        Self { bound, held: frame.held.clone(), points: frame.points(), share: frame.share.clone(), length_scale }
    }

    /// Returns the upper bounds of component `c`, if any.
    pub(crate) fn bound(&self, c: usize) -> Option<&[f64]> {
        self.bound.as_deref().filter(|_| c + 1 == self.held.len())
    }

    /// Projects `position` on the allowed displacements: clips it at the wall and restores held means. Clipping lowers
    /// the mean, so that the free points are raised.
    pub(crate) fn project_keeping_mean(&self, position: &mut [f64]) {
        for (c, field) in position.chunks_exact_mut(self.points).enumerate() {
            if let Some(bound) = self.bound(c) {
                for_each([&mut *field], &|start, [w]| {
                    w.iter_mut().zip(&bound[start..]).for_each(|(w, b)| *w = w.min(*b));
                });
            }
            if self.held[c] {
                self.restore_mean(self.bound(c), field);
            }
        }
    }

    /// Shifts the free points until the mean is 0. A shift may push more points to the wall; it is repeated until none
    /// is.
    fn restore_mean(&self, bound: Option<&[f64]>, field: &mut [f64]) {
        let points = if self.share.is_whole() { field.len() } else { self.share.total() } as f64;
        for _ in 0..ROUNDS {
            let [total, free] = reduce(
                &self.share,
                field.len(),
                &|range| {
                    range.fold([0.0; 2], |sums, i| {
                        add(sums, [field[i], f64::from(bound.is_none_or(|bound| field[i] < bound[i]))])
                    })
                },
                &add,
            );
            if free == 0.0 || total.abs() / points <= f64::EPSILON * self.length_scale {
                break;
            }
            let shift = -total / free;
            let lift = |start: usize, [w]: [&mut [f64]; 1]| {
                for (k, w) in w.iter_mut().enumerate() {
                    match bound.map(|bound| bound[start + k]) {
                        Some(bound) if *w < bound => *w = (*w + shift).min(bound),
                        Some(_) => {}
                        None => *w += shift,
                    }
                }
            };
            for_each([&mut *field], &lift);
        }
    }
}
