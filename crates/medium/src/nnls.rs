//! Least squares with non-negative unknowns.

/// Smallest part of a unit column that is independent of the columns before it.
const INDEPENDENT: f64 = 1e-9;

/// Smallest gradient, relative to the right-hand side, by which an unknown leaves zero.
const GRADIENT: f64 = 1e-13;

/// Minimum of ‖A x − b‖² with x ≥ 0.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Minimum {
    /// Unknowns, one for each column; exactly 0 where the bound holds.
    pub(crate) x: Vec<f64>,
    /// Roots of the diagonal of (AᵀA)⁻¹ of the columns whose unknown is positive; 0 for the others.
    pub(crate) spread: Vec<f64>,
}

/// Independent columns as Q R: orthonormal columns, and rows of the upper triangle by column.
#[derive(Default)]
struct Factors {
    q: Vec<Vec<f64>>,
    r: Vec<Vec<f64>>,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Adds `factor` times `b` to `a`.
fn add(a: &mut [f64], factor: f64, b: &[f64]) {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += factor * b);
}

impl Factors {
    /// Factors unit columns by Gram and Schmidt, each projected twice; `None` if one depends on those before it.
    fn of(columns: &[&[f64]]) -> Option<Self> {
        let mut factors = Self::default();
        for column in columns {
            let mut rest = column.to_vec();
            let mut parts = vec![0.0; factors.q.len()];
            for _ in 0..2 {
                for (part, q) in parts.iter_mut().zip(&factors.q) {
                    let along = dot(&rest, q);
                    *part += along;
                    add(&mut rest, -along, q);
                }
            }
            let norm = dot(&rest, &rest).sqrt();
            if norm <= INDEPENDENT || norm.is_nan() {
                return None;
            }
            rest.iter_mut().for_each(|value| *value /= norm);
            parts.push(norm);
            factors.q.push(rest);
            factors.r.push(parts);
        }
        Some(factors)
    }

    /// Solves R x = y.
    fn back(&self, mut y: Vec<f64>) -> Vec<f64> {
        for k in (0..y.len()).rev() {
            y[k] /= self.r[k][k];
            let known = y[k];
            for (row, part) in y[..k].iter_mut().zip(&self.r[k]) {
                *row -= part * known;
            }
        }
        y
    }

    /// Returns the least-squares solution without bounds.
    fn solution(&self, b: &[f64]) -> Vec<f64> {
        let mut rest = b.to_vec();
        let mut y = Vec::with_capacity(self.q.len());
        for q in &self.q {
            let along = dot(&rest, q);
            add(&mut rest, -along, q);
            y.push(along);
        }
        self.back(y)
    }

    /// Returns the norms of the rows of R⁻¹.
    fn spread(&self) -> Vec<f64> {
        let mut squares = vec![0.0; self.q.len()];
        for k in 0..self.q.len() {
            let mut unit = vec![0.0; self.q.len()];
            unit[k] = 1.0;
            squares.iter_mut().zip(self.back(unit)).for_each(|(square, entry)| *square += entry * entry);
        }
        squares.into_iter().map(f64::sqrt).collect()
    }
}

/// Returns the triangle R of unit columns followed by `b`, as columns: the least-squares problem in as many rows as
/// there are unknowns, and one.
fn reduce(columns: &[Vec<f64>], b: &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) {
    let count = columns.len() + 1;
    let mut rest: Vec<Vec<f64>> = columns.iter().cloned().chain([b.to_vec()]).collect();
    let mut reduced = vec![vec![0.0; count]; count];
    for k in 0..count {
        let norm = dot(&rest[k], &rest[k]).sqrt();
        reduced[k][k] = norm;
        if norm == 0.0 {
            continue;
        }
        let q: Vec<f64> = rest[k].iter().map(|value| value / norm).collect();
        for j in k + 1..count {
            let along = dot(&rest[j], &q);
            reduced[j][k] = along;
            add(&mut rest[j], -along, &q);
        }
    }
    let b = reduced.pop().unwrap_or_default();
    (reduced, b)
}

/// Minimises ‖A x − b‖² over x ≥ 0 by the method of active sets of Lawson and Hanson, Solving Least Squares Problems
/// (1974), chapter 23. Columns are of the length of `b`; a column of zeros has the unknown 0.
pub(crate) fn minimise(columns: &[Vec<f64>], b: &[f64]) -> Minimum {
    let count = columns.len();
    let norms: Vec<f64> = columns.iter().map(|column| dot(column, column).sqrt()).collect();
    let unit = |column: &Vec<f64>, norm: f64| -> Vec<f64> { column.iter().map(|value| value / norm).collect() };
    let units: Vec<Vec<f64>> =
        columns.iter().zip(&norms).map(|(column, norm)| unit(column, norm.max(f64::MIN_POSITIVE))).collect();
    // Few rows make each of the many small problems cheap.
    let (units, b) = if b.len() > count + 1 { reduce(&units, b) } else { (units, b.to_vec()) };
    let least = GRADIENT * dot(&b, &b).sqrt();
    let mut x = vec![0.0; count];
    let mut blocked = vec![false; count];
    let mut free: Vec<usize> = Vec::new();
    let factors = |free: &[usize]| Factors::of(&free.iter().map(|j| &units[*j][..]).collect::<Vec<_>>());
    for _ in 0..10 * count {
        let mut rest = b.clone();
        free.iter().for_each(|j| add(&mut rest, -x[*j], &units[*j]));
        let bound = (0..count).filter(|j| !blocked[*j] && !free.contains(j));
        let steepest = bound.map(|j| (j, dot(&units[j], &rest))).max_by(|(_, a), (_, b)| a.total_cmp(b));
        let Some((entering, _)) = steepest.filter(|(_, gradient)| *gradient > least) else { break };
        free.push(entering);
        let mut is_first = true;
        loop {
            let found = factors(&free).map(|factors| factors.solution(&b));
            // By rounding, a nearly dependent column may lead to a step against its gradient.
            let Some(z) = found.filter(|z| !is_first || z.last().is_some_and(|last| *last > 0.0)) else {
                free.retain(|j| *j != entering);
                x[entering] = 0.0;
                blocked[entering] = true;
                break;
            };
            is_first = false;
            if z.iter().all(|value| *value > 0.0) {
                free.iter().zip(&z).for_each(|(j, value)| x[*j] = *value);
                blocked.fill(false);
                break;
            }
            let length = |(j, z): (&usize, &f64)| if *z > 0.0 { f64::INFINITY } else { x[*j] / (x[*j] - z) };
            let lengths: Vec<f64> = free.iter().zip(&z).map(length).collect();
            let step = lengths.iter().copied().fold(f64::INFINITY, f64::min);
            free.iter().zip(&z).for_each(|(j, z)| x[*j] += step * (z - x[*j]));
            let leaving: Vec<usize> =
                free.iter().zip(&lengths).filter(|(_, length)| **length <= step).map(|(j, _)| *j).collect();
            leaving.iter().for_each(|j| x[*j] = 0.0);
            free.retain(|j| !leaving.contains(j) && x[*j] > 0.0);
        }
    }
    let mut spread = vec![0.0; count];
    if let Some(factors) = factors(&free) {
        free.iter().zip(factors.spread()).for_each(|(j, value)| spread[*j] = value / norms[*j]);
    }
    x.iter_mut().zip(&norms).filter(|(x, _)| **x > 0.0).for_each(|(x, norm)| *x /= norm);
    Minimum { x, spread }
}

#[cfg(test)]
mod tests {
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    use super::*;

    /// Deterministic numbers between −1 and 1.
    fn numbers(count: usize, seed: u64) -> Vec<f64> {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn the_minimum_satisfies_the_conditions_of_kuhn_and_tucker() {
        for seed in 0..60 {
            let (rows, count) = (5 + seed as usize % 20, 2 + seed as usize % 7);
            let columns: Vec<Vec<f64>> = (0..count).map(|j| numbers(rows, 100 * seed + j as u64)).collect();
            let b = numbers(rows, 77 + seed);
            let Minimum { x, .. } = minimise(&columns, &b);
            let mut rest = b.clone();
            x.iter().zip(&columns).for_each(|(x, column)| add(&mut rest, -x, column));
            for (x, column) in x.iter().zip(&columns) {
                let gradient = dot(column, &rest);
                assert!(*x >= 0.0);
                if *x > 0.0 {
                    assert_abs_diff_eq!(gradient, 0.0, epsilon = 1e-12);
                } else {
                    assert!(gradient < 1e-12, "{seed}: {gradient}");
                }
            }
        }
    }

    #[test]
    fn a_positive_solution_and_its_spread_are_those_without_bounds() {
        // y = 2 + 3 t at t = 0, 1, 2: (AᵀA)⁻¹ = [[5, −3], [−3, 3]]/6.
        let columns = [vec![1.0, 1.0, 1.0], vec![0.0, 1.0, 2.0]];
        let Minimum { x, spread } = minimise(&columns, &[2.0, 5.0, 8.0]);
        assert_relative_eq!(x[0], 2.0, max_relative = 1e-14);
        assert_relative_eq!(x[1], 3.0, max_relative = 1e-14);
        assert_relative_eq!(spread[0], (5.0_f64 / 6.0).sqrt(), max_relative = 1e-14);
        assert_relative_eq!(spread[1], 0.5_f64.sqrt(), max_relative = 1e-14);
    }

    #[test]
    fn dependent_columns_share_no_infinite_solution() {
        let columns = [vec![1.0, 2.0, 3.0], vec![1.0, 2.0, 3.0], vec![0.0; 3], vec![2.0, 4.0, 6.0 + 1e-14]];
        let Minimum { x, .. } = minimise(&columns, &[2.0, 4.0, 6.0]);
        assert_relative_eq!(x[0] + x[1] + 2.0 * x[3], 2.0, max_relative = 1e-12);
        assert_eq!(x[2], 0.0);
        assert_eq!(minimise(&columns, &[-1.0, -1.0, -1.0]).x, [0.0; 4]);
    }
}
