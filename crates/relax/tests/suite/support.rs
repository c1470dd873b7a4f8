//! Problems with known solutions.

use gfmd_relax::{Bounds, Landscape};
use gfmd_vector::pass;

/// Chain with U = ½ uᵀ K u − loadᵀ u, K symmetric and tridiagonal.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    pub(crate) diagonal: Vec<f64>,
    /// Coupling of i and i + 1; one entry fewer than `diagonal`.
    pub(crate) coupling: Vec<f64>,
    pub(crate) load: Vec<f64>,
    pub(crate) lower: Option<Vec<f64>>,
    pub(crate) upper: Option<Vec<f64>>,
    /// Number of calls of `force`.
    pub(crate) calls: u64,
}

impl Chain {
    /// Creates springs of stiffness 1 between neighbours and fixed ends, and of stiffness `ground` to the ground.
    pub(crate) fn springs(n: usize, ground: f64, load: impl Fn(usize) -> f64) -> Self {
        Self {
            diagonal: vec![2.0 + ground; n],
            coupling: vec![-1.0; n - 1],
            load: (0..n).map(load).collect(),
            lower: None,
            upper: None,
            calls: 0,
        }
    }

    /// Creates uncoupled modes without load. The solution is zero, so small errors keep all digits.
    pub(crate) fn modes(stiffness: &[f64]) -> Self {
        let n = stiffness.len();
        Self {
            diagonal: stiffness.to_vec(),
            coupling: vec![0.0; n - 1],
            load: vec![0.0; n],
            lower: None,
            upper: None,
            calls: 0,
        }
    }

    pub(crate) fn below(self, upper: Vec<f64>) -> Self {
        Self { upper: Some(upper), ..self }
    }

    pub(crate) fn above(self, lower: Vec<f64>) -> Self {
        Self { lower: Some(lower), ..self }
    }

    /// Returns the smallest and the largest eigenvalue, by bisection on the signs of the Sturm sequence.
    pub(crate) fn band(&self) -> (f64, f64) {
        let n = self.diagonal.len();
        let coupling = |i: usize| self.coupling.get(i).copied().unwrap_or(0.0);
        let below = |x: f64| {
            let mut pivot = 1.0;
            (0..n)
                .filter(|&i| {
                    let left = if i == 0 { 0.0 } else { coupling(i - 1) };
                    pivot = self.diagonal[i] - x - if i == 0 { 0.0 } else { left * left / pivot };
                    pivot < 0.0
                })
                .count()
        };
        let radius = |i: usize| coupling(i).abs() + if i == 0 { 0.0 } else { coupling(i - 1).abs() };
        let top = (0..n).map(|i| self.diagonal[i] + radius(i)).fold(0.0, f64::max) * 1.01;
        let find = |index: usize| {
            let (mut low, mut high) = (0.0, top);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                if below(middle) > index { high = middle } else { low = middle }
            }
            0.5 * (low + high)
        };
        (find(0), find(n - 1))
    }

    pub(crate) fn matrix(&self) -> Vec<Vec<f64>> {
        let n = self.diagonal.len();
        let mut k = vec![vec![0.0; n]; n];
        for i in 0..n {
            k[i][i] = self.diagonal[i];
            if i + 1 < n {
                k[i][i + 1] = self.coupling[i];
                k[i + 1][i] = self.coupling[i];
            }
        }
        k
    }

    /// Returns the exact solution below `upper`.
    pub(crate) fn solution(&self) -> Vec<f64> {
        active_set(&self.matrix(), &self.load, self.upper.as_deref())
    }
}

impl Landscape for Chain {
    fn len(&self) -> usize {
        self.load.len()
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        self.calls += 1;
        let at = |x: &[f64], i: Option<usize>| i.and_then(|i| x.get(i)).copied().unwrap_or(0.0);
        pass(
            [force],
            &|start, [force]| {
                let mut energy = 0.0;
                for (i, f) in (start..).zip(force) {
                    let left = i.checked_sub(1);
                    let neighbours =
                        at(&self.coupling, left) * at(u, left) + at(&self.coupling, Some(i)) * at(u, Some(i + 1));
                    *f = self.load[i] - (self.diagonal[i] * u[i] + neighbours);
                    energy -= 0.5 * u[i] * (*f + self.load[i]);
                }
                energy
            },
            &|a, b| a + b,
        )
    }

    fn bounds(&self) -> Bounds<'_> {
        match (&self.lower, &self.upper) {
            (None, None) => Bounds::Free,
            (None, Some(upper)) => Bounds::Upper(upper),
            (Some(lower), Some(upper)) => Bounds::Between { lower, upper },
            (Some(_), None) => panic!("give an upper bound as well"),
        }
    }

    fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
        self.bounds().natural_residual(u, force, 1.0, 1.0)
    }
}

/// Solves the dense system A x = b by elimination with row pivoting.
pub(crate) fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for column in 0..n {
        let pivot = (column..n).max_by(|&i, &j| a[i][column].abs().total_cmp(&a[j][column].abs())).unwrap();
        a.swap(column, pivot);
        b.swap(column, pivot);
        let (above, below) = a.split_at_mut(column + 1);
        let pivot = &above[column];
        for (i, row) in below.iter_mut().enumerate() {
            let factor = row[column] / pivot[column];
            row.iter_mut().zip(pivot).for_each(|(x, p)| *x -= factor * p);
            b[column + 1 + i] -= factor * b[column];
        }
    }
    for row in (0..n).rev() {
        for k in row + 1..n {
            b[row] -= a[row][k] * b[k];
        }
        b[row] /= a[row][row];
    }
    b
}

/// Returns argmin ½ uᵀ K u − loadᵀ u over u ≤ upper: guesses the active set, solves for the free entries exactly,
/// corrects the guess, and finally checks the optimality conditions.
pub(crate) fn active_set(k: &[Vec<f64>], load: &[f64], upper: Option<&[f64]>) -> Vec<f64> {
    let n = load.len();
    let open = vec![f64::INFINITY; n];
    let upper = upper.unwrap_or(&open);
    let force = |u: &[f64], i: usize| load[i] - k[i].iter().zip(u).map(|(k, u)| k * u).sum::<f64>();
    let mut touching = vec![false; n];
    for _ in 0..200 {
        let matrix = (0..n).map(|i| if touching[i] { unit(n, i) } else { k[i].clone() }).collect();
        let right = (0..n).map(|i| if touching[i] { upper[i] } else { load[i] }).collect();
        let mut u = solve(matrix, right);
        for i in (0..n).filter(|&i| touching[i]) {
            u[i] = upper[i];
        }
        let next: Vec<bool> = (0..n).map(|i| if touching[i] { force(&u, i) > 0.0 } else { u[i] > upper[i] }).collect();
        if next == touching {
            assert!((0..n).all(|i| if touching[i] { force(&u, i) > 0.0 } else { force(&u, i).abs() < 1e-12 }));
            return u;
        }
        touching = next;
    }
    panic!("the active set does not settle");
}

fn unit(n: usize, i: usize) -> Vec<f64> {
    (0..n).map(|j| f64::from(u8::from(i == j))).collect()
}

/// Returns reproducible, scattered numbers in −1 … 1.
pub(crate) fn scattered(n: usize) -> Vec<f64> {
    (1..=n).map(|i| 2.0 * (0.618_033_988_749_894_9 * (i * i) as f64).fract() - 1.0).collect()
}

pub(crate) fn distance(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

pub(crate) fn bits(x: &[f64]) -> Vec<u64> {
    x.iter().map(|x| x.to_bits()).collect()
}
