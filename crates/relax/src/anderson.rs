use std::collections::VecDeque;

use gfmd_vector::{dot, for_each};

/// Anderson mixing (J. ACM 12 (1965) 547) for a fixed point x = F(x). The next x is a linear combination of the last
/// images F(x), with coefficients that minimise the same combination of the residuals F(x) − x. It converges where the
/// iteration x ← F(x) is slow or, with a smooth F, diverges.
///
/// ```
/// use gfmd_relax::Anderson;
///
/// // x = 2 − 3 tanh x: iterates x ← F(x) would go apart.
/// let image = |x: f64| 2.0 - 3.0 * x.tanh();
/// let (mut x, mut mixing) = ([0.0], Anderson::new(3));
/// for _ in 0..12 {
///     let image = [image(x[0])];
///     mixing.advance(&mut x, &image);
/// }
/// assert!((x[0] - image(x[0])).abs() < 1e-12);
/// ```
#[derive(Clone, Debug)]
pub struct Anderson {
    depth: usize,
    /// Image and residual of the last x.
    last: Option<[Vec<f64>; 2]>,
    /// Changes of image and residual from one x to the next, the oldest first.
    changes: VecDeque<[Vec<f64>; 2]>,
}

/// Smallest pivot relative to the largest; below it, a change of the residual depends linearly on later ones.
const LEAST_PIVOT: f64 = 1e-14;

impl Anderson {
    /// Creates a mixing of at most `depth` + 1 images.
    pub fn new(depth: usize) -> Self {
        Self { depth, last: None, changes: VecDeque::new() }
    }

    /// Replaces x by the next x, given `image` = F(x). Both have the same length in all calls.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn advance(&mut self, x: &mut [f64], image: &[f64]) {
        self.advance_by(x, image, &|a, b| dot(a, b));
    }

    /// Replaces x as [`advance`](Self::advance), with another scalar `product` of vectors: the product over all
    /// processes that share them.
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn advance_by(&mut self, x: &mut [f64], image: &[f64], product: &dyn Fn(&[f64], &[f64]) -> f64) {
        assert_eq!(x.len(), image.len(), "an image is as long as x");
        let residual: Vec<f64> = image.iter().zip(&*x).map(|(image, x)| image - x).collect();
        if let Some([old_image, old_residual]) = self.last.take() {
            let mut change = [old_image, old_residual];
            for (change, new) in change.iter_mut().zip([image, &residual]) {
                for_each(&mut change[..], &|start, change: &mut [f64]| {
                    change.iter_mut().zip(&new[start..]).for_each(|(old, new)| *old = new - *old);
                });
            }
            self.changes.push_back(change);
            if self.changes.len() > self.depth {
                self.changes.pop_front();
            }
        }
        x.copy_from_slice(image);
        for (weight, [change, _]) in self.weights(&residual, product).into_iter().zip(&self.changes) {
            for_each(&mut *x, &|start, x: &mut [f64]| {
                x.iter_mut().zip(&change[start..]).for_each(|(x, change)| *x -= weight * change);
            });
        }
        self.last = Some([image.to_vec(), residual]);
    }

    /// Returns the weights that bring the sum of the changes closest to the residual, by elimination. A change that is
    /// nearly a combination of the others has zero weight.
    fn weights(&self, residual: &[f64], product: &dyn Fn(&[f64], &[f64]) -> f64) -> Vec<f64> {
        let n = self.changes.len();
        let mut rows: Vec<Vec<f64>> = self
            .changes
            .iter()
            .map(|[_, a]| self.changes.iter().map(|[_, b]| product(a, b)).chain([product(a, residual)]).collect())
            .collect();
        let largest = (0..n).map(|k| rows[k][k]).fold(0.0, f64::max);
        // Eliminates from the newest change to the oldest, on both sides of the diagonal.
        for k in (0..n).rev() {
            let pivot = rows[k][k];
            let says_more = pivot > LEAST_PIVOT * largest;
            if !says_more {
                rows[k].fill(0.0);
                rows.iter_mut().for_each(|row| row[k] = 0.0);
                continue;
            }
            rows[k].iter_mut().for_each(|value| *value /= pivot);
            let own = rows[k].clone();
            for row in rows.iter_mut().enumerate().filter(|(i, _)| *i != k).map(|(_, row)| row) {
                let factor = row[k];
                row.iter_mut().zip(&own).for_each(|(value, own)| *value -= factor * own);
            }
        }
        rows.into_iter().map(|row| row[n]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_problem_of_few_dimensions_is_solved_in_as_many_steps() {
        // F(x) = b + A x with eigenvalues from -3 to 0.9.
        let image = |x: &[f64]| {
            let [a, b, c] = [x[0] + x[1], x[0] - x[1], x[2]];
            [1.0 - 1.5 * a + 0.45 * b, -2.0 - 1.5 * a - 0.45 * b, 0.5 + 0.3 * c]
        };
        let (mut x, mut mixing) = ([0.0; 3], Anderson::new(4));
        for _ in 0..6 {
            let image = image(&x);
            mixing.advance(&mut x, &image);
        }
        let image = image(&x);
        assert!(x.iter().zip(&image).all(|(x, image)| (x - image).abs() < 1e-10), "{x:?} {image:?}");
    }

    #[test]
    fn a_fixed_point_stays_where_it_is() {
        let (mut x, mut mixing) = ([1.0, 2.0], Anderson::new(3));
        for _ in 0..10 {
            let image = x;
            mixing.advance(&mut x, &image);
        }
        assert_eq!(x, [1.0, 2.0]);
    }
}
