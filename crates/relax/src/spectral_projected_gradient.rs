use std::ops::Range;

use gfmd_vector::{add, for_each, reduce};

use crate::{Budget, Ending, Progress, Watch, Why};

/// Convex quadratic function ½⟨x, A x⟩ + ⟨b, x⟩ on a closed convex set with a known projection.
pub trait OnConvexSet {
    /// Writes A `direction` into `out`. Entries that are fixed by the set may be 0.
    fn apply(&mut self, direction: &[f64], out: &mut [f64]);

    /// Moves `x` to the nearest point of the set.
    fn project(&self, x: &mut [f64]);

    /// Writes the projection of x − `length` `gradient`, minus x, into `out`; `x` is a point of the set. At its edge,
    /// the difference of the two may have rounding errors whose product with the gradient hides the slope.
    fn direction(&self, x: &[f64], gradient: &[f64], length: f64, out: &mut [f64]) {
        for_each([&mut *out], &|start, [d]| {
            let here = x[start..].iter().zip(&gradient[start..]);
            d.iter_mut().zip(here).for_each(|(d, (x, g))| *d = x - length * g);
        });
        self.project(out);
        for_each([out], &|start, [d]| d.iter_mut().zip(&x[start..]).for_each(|(d, x)| *d -= x));
    }

    /// Returns the sums of four products over a vector of this `length`; `of` returns the sums over a range. Several
    /// processes that share a vector add all their values.
    fn sums(&self, length: usize, of: &(dyn Fn(Range<usize>) -> [f64; 4] + Sync)) -> [f64; 4] {
        reduce(length, &|range| of(range), &add)
    }

    /// Returns the distance of `x` from the minimum, to be compared with the tolerance; `gradient` is A x + b.
    fn residual(&self, x: &[f64], gradient: &[f64]) -> f64;
}

/// Projected gradients with Barzilai–Borwein step lengths and an exact line search along each segment (Birgin, Martínez
/// & Raydan 2000, with an inexact line search).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralProjectedGradient {
    /// Length of the first step, in the unit of x divided by the unit of the gradient.
    pub first_step: f64,
}

/// Result of [`SpectralProjectedGradient::minimise`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Descended {
    /// Number of steps.
    pub steps: u64,
    /// Ending of the search.
    pub ending: Ending,
}

impl SpectralProjectedGradient {
    /// Minimises from `x`, a point of the set with `gradient` A x + b, and updates both in place. Gives up if rounding
    /// leaves no downhill direction.
    pub fn minimise(
        &self,
        problem: &mut dyn OnConvexSet,
        x: &mut [f64],
        gradient: &mut [f64],
        budget: &Budget,
        watch: &mut dyn Watch,
    ) -> Descended {
        let mut direction = vec![0.0; x.len()];
        let mut image = vec![0.0; x.len()];
        let mut length = self.first_step;
        let mut steps = 0;
        loop {
            let residual = problem.residual(x, gradient);
            if watch.see(&Progress { iteration: steps, residual }).is_break() {
                return Descended { steps, ending: Ending::Interrupted };
            }
            if residual <= budget.tolerance {
                return Descended { steps, ending: Ending::Converged };
            }
            if steps >= budget.max_iterations {
                return Descended { steps, ending: Ending::GaveUp(Why::Iterations) };
            }
            steps += 1;
            problem.direction(x, gradient, length, &mut direction);
            problem.apply(&direction, &mut image);
            let products = |range: Range<usize>| {
                range.fold([0.0; 4], |sums, k| {
                    let (d, a) = (direction[k], image[k]);
                    add(sums, [d * gradient[k], d * a, d * d, a * a])
                })
            };
            let [slope, curvature, square, images] = problem.sums(x.len(), &products);
            // NaN also ends the descent.
            if !(slope < 0.0 && curvature > 0.0) {
                return Descended { steps, ending: Ending::GaveUp(Why::NoDescent) };
            }
            let share = (-slope / curvature).min(1.0);
            for_each([&mut *x, &mut *gradient], &|start, [x, g]| {
                let along = direction[start..].iter().zip(&image[start..]);
                for ((x, g), (d, a)) in x.iter_mut().zip(g).zip(along) {
                    *x += share * d;
                    *g += share * a;
                }
            });
            length = if steps % 2 == 0 { square / curvature } else { curvature / images };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Function ½ Σ kᵢ xᵢ² − Σ bᵢ xᵢ in a disc.
    struct InDisc {
        stiffness: [f64; 2],
        radius: f64,
    }

    impl OnConvexSet for InDisc {
        fn apply(&mut self, direction: &[f64], out: &mut [f64]) {
            (0..2).for_each(|i| out[i] = self.stiffness[i] * direction[i]);
        }

        fn project(&self, x: &mut [f64]) {
            let length = x[0].hypot(x[1]);
            if length > self.radius {
                x.iter_mut().for_each(|x| *x *= self.radius / length);
            }
        }

        fn residual(&self, x: &[f64], gradient: &[f64]) -> f64 {
            let mut moved = [x[0] - gradient[0], x[1] - gradient[1]];
            self.project(&mut moved);
            (moved[0] - x[0]).hypot(moved[1] - x[1])
        }
    }

    fn minimise(radius: f64, b: [f64; 2]) -> ([f64; 2], Descended) {
        let mut problem = InDisc { stiffness: [1.0, 100.0], radius };
        let (mut x, mut gradient) = ([0.0; 2], b.map(|b| -b));
        let method = SpectralProjectedGradient { first_step: 0.01 };
        let budget = Budget { tolerance: 1e-12, max_iterations: 1000 };
        let descended = method.minimise(&mut problem, &mut x, &mut gradient, &budget, &mut ());
        (x, descended)
    }

    #[test]
    fn the_minimum_is_found_inside_the_set_and_on_its_edge() {
        let ([x, y], _) = minimise(10.0, [1.0, 100.0]);
        assert!((x - 1.0).abs() < 1e-11 && (y - 1.0).abs() < 1e-11, "{x} {y}");
        // At the edge the gradient is parallel to x: (k + λ) x = b.
        let ([x, y], _) = minimise(0.5, [1.0, 100.0]);
        let multiplier = 1.0 / x - 1.0;
        assert!((x.hypot(y) - 0.5).abs() < 1e-11 && multiplier > 0.0);
        assert!(((100.0 + multiplier) * y - 100.0).abs() < 1e-9, "{x} {y}");
    }

    #[test]
    fn numbers_that_are_not_finite_end_the_descent() {
        assert_eq!(minimise(1.0, [f64::NAN, 1.0]).1, Descended { steps: 1, ending: Ending::GaveUp(Why::NoDescent) });
    }
}
