//! Projected path along a direction.

use gfmd_vector::{Share, add};

use super::active::Active;
use super::constants::{BOUNDED_MEAN, HALVINGS, MEAN, SHORTER};
use super::sums::{View, block_sums};
use crate::Ceiling;

/// Start of a path: variables, direction, gradient, and the active blocks.
pub(super) struct Start<'a> {
    pub(super) share: &'a Share,
    pub(super) x: &'a [f64],
    pub(super) direction: &'a [f32],
    pub(super) gradient: &'a [f32],
    pub(super) active: &'a Active,
    pub(super) view: View,
    pub(super) upper: Ceiling<'a>,
}

/// Point of the projected path: `factor · max(0, x − length z − μ)`, at most the upper bound, on the free variables
/// (between the bounds or with z ≠ 0). The others do not change.
pub(super) struct Path {
    pub(super) length: f64,
    /// Length in the unit of steps.
    scale: f64,
    mu: f64,
    pub(super) factor: f64,
    /// ⟨g, step⟩ at the beginning of the step.
    pub(super) slope: f64,
}

impl Path {
    pub(super) fn end(&self, x: f64, z: f32, upper: f64) -> f64 {
        // Without branches, which would be unpredictable.
        let end = x - self.scale * f64::from(z) - self.mu;
        let held = (x >= upper) & (z == 0.0);
        let end = if (end > 0.0) & ((x > 0.0) | (z != 0.0)) { end } else { 0.0 };
        let end = if end < upper { end } else { upper };
        if held { x } else { end }
    }
}

impl Start<'_> {
    /// Returns the point of the path at `length`, halved until the step begins downhill.
    pub(super) fn downhill(&self, length: f64, mean: Option<f64>) -> Option<Path> {
        let Self { share, x, direction: z, gradient, active, view, upper } = *self;
        let (bounded, highest) = (upper.is_finite(), upper.highest(share));
        let mut path = Path { length, scale: 0.0, mu: 0.0, factor: 1.0, slope: 0.0 };
        'steps: for _ in 0..HALVINGS {
            path.mu = 0.0;
            path.scale = path.length * view.step;
            let mut bracket = [f64::NEG_INFINITY, f64::INFINITY];
            loop {
                let [sum, positive, slope, along] = share.reduce(
                    &|range| {
                        active.blocks(range).fold([0.0; 4], |sums, block| {
                            let ceiling = upper.part(block.clone());
                            let (x, z, gradient) = (&x[block.clone()], &z[block.clone()], &gradient[block]);
                            let terms = |x: f64, z: f32, g: f32, upper: f64| {
                                let (end, g) = (path.end(x, z, upper), view.own(g));
                                let moves = if (end > 0.0) & (end < upper) { 1.0 } else { 0.0 };
                                [end, moves, g * (end - x), g * end]
                            };
                            add(
                                sums,
                                match ceiling {
                                    Ceiling::All(upper) => {
                                        block_sums((x, z, gradient, gradient), |x, z, g, _| terms(x, z, g, upper))
                                    }
                                    Ceiling::Each(upper) => block_sums((x, z, gradient, upper), terms),
                                },
                            )
                        })
                    },
                    &add,
                );
                (path.factor, path.slope) = (1.0, slope);
                let Some(mean) = mean else { break };
                let asked = mean * share.total() as f64;
                let excess = sum - asked;
                if bounded && excess.abs() <= BOUNDED_MEAN * asked {
                    break;
                }
                if !bounded && excess.abs() <= MEAN * asked {
                    path.factor = asked / sum;
                    path.slope += (path.factor - 1.0) * along;
                    break;
                }
                // Newton's method takes a few steps on a convex, piecewise linear function. With two bounds, the
                // function is not convex, and the steps stay within a bracket.
                let mut mu = path.mu + excess / positive;
                if bounded {
                    bracket[usize::from(excess < 0.0)] = path.mu;
                    let inside = bracket[0] < mu && mu < bracket[1];
                    if !inside {
                        mu = middle(bracket, path.mu, highest);
                    }
                }
                if !mu.is_finite() {
                    return None;
                }
                if mu == path.mu {
                    path.length *= SHORTER;
                    continue 'steps;
                }
                path.mu = mu;
            }
            if path.slope < 0.0 {
                return Some(path);
            }
            path.length *= 0.5;
        }
        None
    }
}

/// Returns the middle of a bracket, or a point beyond its finite end if it is open on one side.
pub(super) fn middle([low, high]: [f64; 2], mu: f64, size: f64) -> f64 {
    match (low.is_finite(), high.is_finite()) {
        (true, true) => 0.5 * (low + high),
        (true, false) => mu + mu.abs().max(size),
        _ => mu - mu.abs().max(size),
    }
}
