//! Weighted least squares, linear in the coefficients and nonlinear in at most three bounded exponents.
//!
//! Variable projection: for given exponents the coefficients follow from one QR decomposition, so the search runs over
//! the exponents alone. It starts from the best node of a grid over the whole box, because the sum of squares may have
//! several minima, and ends with damped Gauss–Newton steps that respect the bounds.

use crate::{Axis, COARSE};

/// Largest number of terms: one per axis.
pub(crate) const AXES: usize = 3;

/// Fraction of a column's length below which a pivot makes the columns dependent.
const DEPENDENT: f64 = 1e-10;

/// Length of a step of the exponents below which the search ends. Steps shrink at least tenfold, so that the next step
/// would be negligible.
const SHORT: f64 = 1e-10;

/// Term C eps^alpha of the sum, with alpha fixed (`min == max`) or fitted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shape {
    pub(crate) axis: usize,
    pub(crate) min: f64,
    pub(crate) max: f64,
    /// Index of the shape with the power that multiplies this one.
    pub(crate) times: Option<usize>,
}

impl Shape {
    pub(crate) fn is_free(&self) -> bool {
        self.max > self.min
    }
}

/// Coefficients and exponents as arrays over the axes t, f, c; a missing term has the coefficient zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameters {
    /// kappa in the limit of all eps -> 0.
    pub kappa_tfc: f64,
    /// C_t, C_f, C_c; zero for an axis without a term.
    pub coefficients: [f64; AXES],
    /// alpha_t, alpha_f, alpha_c; one for an axis without a term.
    pub exponents: [f64; AXES],
    /// True if the term in eps_t is multiplied by the power of eps_f ([`crate::Model::crossed`]).
    pub crossed: bool,
    /// f and f' of the measured edge ([`crate::Edge`]); zero without it.
    pub edge: [f64; 2],
}

impl Parameters {
    /// Returns kappa of the model at `eps` = (eps_t, eps_f, eps_c), for contacts without an edge.
    pub fn predict(&self, eps: [f64; AXES]) -> f64 {
        self.kappa_tfc + (0..AXES).map(|axis| self.term(axis, eps)).sum::<f64>()
    }

    /// Returns the contribution of a measured mean edge to kappa at `eps_c`.
    pub fn excess(&self, eps_c: f64, edge: f64) -> f64 {
        factor(self.edge, eps_c) * edge
    }

    /// Returns the function of `eps` that the coefficient of an axis multiplies.
    pub fn power(&self, axis: Axis, eps: [f64; AXES]) -> f64 {
        let power = |axis: usize| eps[axis].powf(self.exponents[axis]);
        let [t, f] = [Axis::Thermodynamic as usize, Axis::Fractal as usize];
        match axis as usize {
            axis if axis == t && self.crossed => power(t) * power(f),
            axis => power(axis),
        }
    }

    pub(crate) fn term(&self, axis: usize, eps: [f64; AXES]) -> f64 {
        match self.coefficients[axis] {
            0.0 => 0.0,
            coefficient => coefficient * self.power(Axis::ALL[axis], eps),
        }
    }
}

/// Comparison of a datum with its parent: index of the parent, and b.
pub(crate) type Parent = (usize, f64);

/// Rows of the fit: abscissae, parents, ordinates, measured edges, square roots of the weights. An expected edge factor
/// is an additional row with an ordinate, an edge of one and a weight.
#[derive(Clone, Debug)]
pub(crate) struct Means {
    pub(crate) eps: Vec<[f64; AXES]>,
    pub(crate) parents: Vec<Option<Parent>>,
    pub(crate) kappa: Vec<f64>,
    pub(crate) edges: Vec<Vec<f64>>,
    pub(crate) root_weight: Vec<f64>,
}

/// Minimum of the weighted sum of squares.
#[derive(Clone, Debug)]
pub(crate) struct Minimum {
    pub(crate) parameters: Parameters,
    pub(crate) sum_of_squares: f64,
}

/// Error for a design matrix with linearly dependent columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dependent;

/// Density of the grid over the box of exponents that is searched before the descent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Search {
    /// Dense grid, for a first fit.
    Thorough,
    /// Sparse grid, for a refit of similar data with a good guess.
    Near,
}

/// Nodes of a grid over the free exponents with their factorised columns. They do not depend on the ordinates and are
/// shared by all resamples.
pub(crate) struct Nodes {
    shapes: Vec<Shape>,
    free: Vec<usize>,
    nodes: Vec<(Vec<f64>, Qr)>,
}

impl Nodes {
    pub(crate) fn new(means: &Means, shapes: &[Shape], search: Search) -> Result<Self, Dependent> {
        let free: Vec<usize> = (0..shapes.len()).filter(|&k| shapes[k].is_free()).collect();
        let per_axis = match (search, free.len()) {
            (_, 0) => 1,
            (Search::Thorough, 1) => 25,
            (Search::Thorough, 2) => 9,
            (Search::Thorough, _) => 6,
            (Search::Near, 1) => 9,
            (Search::Near, 2) => 4,
            (Search::Near, _) => 3,
        };
        let mut exponents: Vec<f64> = shapes.iter().map(|shape| shape.min).collect();
        let mut nodes = Vec::new();
        for index in 0..usize::pow(per_axis, free.len() as u32) {
            let mut rest = index;
            for &k in &free {
                exponents[k] = log_node(shapes[k].min, shapes[k].max, rest % per_axis, per_axis);
                rest /= per_axis;
            }
            if let Ok(qr) = Qr::new(means.columns(shapes, &exponents)) {
                nodes.push((exponents.clone(), qr));
            }
        }
        if nodes.is_empty() { Err(Dependent) } else { Ok(Self { shapes: shapes.to_vec(), free, nodes }) }
    }

    /// Minimises over the coefficients and the free exponents, from the best of the nodes and `guess`.
    pub(crate) fn minimise(&self, means: &Means, guess: Option<&Parameters>) -> Result<Minimum, Dependent> {
        let values = means.weighted_values();
        let mut least = f64::INFINITY;
        let mut start = None;
        for (exponents, qr) in &self.nodes {
            let rotated = qr.rotate(values.clone());
            let value = square(&rotated[qr.upper.len()..]);
            if value < least {
                (least, start) = (value, Some(exponents.clone()));
            }
        }
        let mut start = start.ok_or(Dependent)?;
        if let Some(guess) = guess {
            let exponents: Vec<f64> = self.shapes.iter().map(|s| guess.exponents[s.axis].clamp(s.min, s.max)).collect();
            if means.project(&self.shapes, &exponents).is_ok_and(|projection| projection.sum_of_squares() < least) {
                start = exponents;
            }
        }
        means.descend(&self.shapes, &self.free, start)
    }
}

impl Means {
    /// Minimises once, with separate nodes.
    pub(crate) fn minimise(
        &self,
        shapes: &[Shape],
        search: Search,
        guess: Option<&Parameters>,
    ) -> Result<Minimum, Dependent> {
        Nodes::new(self, shapes, search)?.minimise(self, guess)
    }

    fn weighted_values(&self) -> Vec<f64> {
        self.kappa.iter().zip(&self.root_weight).map(|(k, w)| k * w).collect()
    }

    /// Returns the weighted column of a function of eps, compared with the parent of each row.
    fn column(&self, f: impl Fn(&[f64; AXES]) -> f64) -> Vec<f64> {
        let above = |parent: &Option<Parent>| parent.map_or(0.0, |(index, b)| b * f(&self.eps[index]));
        let rows = self.eps.iter().zip(&self.parents).zip(&self.root_weight);
        let mut column: Vec<f64> = rows.map(|((eps, parent), w)| w * (f(eps) - above(parent))).collect();
        column.resize(self.root_weight.len(), 0.0);
        column
    }

    /// Returns the weighted columns 1, eps^alpha of each term, and the measured edge.
    fn columns(&self, shapes: &[Shape], exponents: &[f64]) -> Vec<Vec<f64>> {
        let terms = (0..shapes.len()).map(|k| self.column(|eps| power(shapes, exponents, k, eps)));
        std::iter::once(self.column(|_| 1.0)).chain(terms).chain(self.weighted_edges()).collect()
    }

    /// Returns the weighted derivative of all terms with respect to the exponent of term `k`.
    fn slope(&self, shapes: &[Shape], exponents: &[f64], coefficients: &[f64], k: usize) -> Vec<f64> {
        let depends = |term: usize| term == k || shapes[term].times == Some(k);
        self.column(|eps| {
            let terms = (0..shapes.len()).filter(|term| depends(*term));
            terms.map(|term| coefficients[term] * power(shapes, exponents, term, eps)).sum::<f64>()
                * eps[shapes[k].axis].ln()
        })
    }

    fn weighted_edges(&self) -> impl Iterator<Item = Vec<f64>> {
        self.edges.iter().map(|edge| edge.iter().zip(&self.root_weight).map(|(e, w)| e * w).collect())
    }

    /// Returns the rows for fixed edge factors.
    pub(crate) fn without_edges(&self) -> Self {
        Self { edges: Vec::new(), root_weight: self.root_weight[..self.eps.len()].to_vec(), ..self.clone() }
    }

    /// Performs damped Gauss–Newton steps from `exponents`, inside the bounds.
    fn descend(&self, shapes: &[Shape], free: &[usize], mut exponents: Vec<f64>) -> Result<Minimum, Dependent> {
        let mut here = self.project(shapes, &exponents)?;
        let mut damping = 1e-3;
        for _ in 0..200 {
            let slopes: Vec<Vec<f64>> = free.iter().map(|&k| here.slope(self, shapes, &exponents, k)).collect();
            let gradient: Vec<f64> = slopes.iter().map(|slope| dot(slope, here.residual())).collect();
            let moving: Vec<usize> = (0..free.len())
                .filter(|&i| {
                    let (shape, value) = (&shapes[free[i]], exponents[free[i]]);
                    !(value <= shape.min && gradient[i] > 0.0 || value >= shape.max && gradient[i] < 0.0)
                })
                .collect();
            let step = damped_step(&slopes, &gradient, &moving, damping);
            let mut trial = exponents.clone();
            for (&i, &change) in moving.iter().zip(&step) {
                let shape = &shapes[free[i]];
                trial[free[i]] = (exponents[free[i]] + change).clamp(shape.min, shape.max);
            }
            let length = trial.iter().zip(&exponents).fold(0.0_f64, |far, (a, b)| far.max((a - b).abs()));
            let next = self.project(shapes, &trial).ok().filter(|p| p.sum_of_squares() <= here.sum_of_squares());
            let accepted = next.is_some();
            if let Some(next) = next {
                (here, exponents) = (next, trial);
            }
            if length <= SHORT {
                break;
            }
            damping = if accepted { (damping * 0.1).max(1e-15) } else { damping * 10.0 };
        }
        Ok(here.into_minimum(shapes, &exponents))
    }

    /// Returns the optimal coefficients at given exponents.
    fn project(&self, shapes: &[Shape], exponents: &[f64]) -> Result<Projection, Dependent> {
        let qr = Qr::new(self.columns(shapes, exponents))?;
        let rotated = qr.rotate(self.weighted_values());
        let coefficients = qr.back_substitute(&rotated);
        Ok(Projection { qr, rotated, coefficients })
    }

    /// Returns the rows d(parameter)/d(kappa of each row) of kappa_TFC, the coefficients, the edge factors, and the
    /// free exponents that are not at a bound.
    pub(crate) fn sensitivities(&self, shapes: &[Shape], at: &Parameters) -> Result<Vec<Vec<f64>>, Dependent> {
        let exponents: Vec<f64> = shapes.iter().map(|s| at.exponents[s.axis]).collect();
        let mut columns = self.columns(shapes, &exponents);
        let coefficients: Vec<f64> = shapes.iter().map(|s| at.coefficients[s.axis]).collect();
        for k in (0..shapes.len()).filter(|&k| is_interior(&shapes[k], exponents[k])) {
            columns.push(self.slope(shapes, &exponents, &coefficients, k));
        }
        let (rows, count) = (columns.len(), self.root_weight.len());
        let qr = Qr::new(columns)?;
        let mut sensitivities = vec![vec![0.0; count]; rows];
        for datum in 0..count {
            let mut unit = vec![0.0; count];
            unit[datum] = self.root_weight[datum];
            let response = qr.back_substitute(&qr.rotate(unit));
            for (row, value) in sensitivities.iter_mut().zip(response) {
                row[datum] = value;
            }
        }
        Ok(sensitivities)
    }
}

/// Returns the factor of an edge measured at `eps_c`.
pub(crate) fn factor([f, coarse]: [f64; 2], eps_c: f64) -> f64 {
    f + coarse * (eps_c / COARSE).powi(2)
}

/// Returns the function of eps that the coefficient of term `k` multiplies.
fn power(shapes: &[Shape], exponents: &[f64], k: usize, eps: &[f64; AXES]) -> f64 {
    let own = |k: usize| eps[shapes[k].axis].powf(exponents[k]);
    own(k) * shapes[k].times.map_or(1.0, own)
}

/// Returns true for a free exponent that did not stop at its bound.
pub(crate) fn is_interior(shape: &Shape, exponent: f64) -> bool {
    shape.is_free() && exponent > shape.min && exponent < shape.max
}

/// Returns node `index` of `nodes` from `min` to `max`, equally spaced in the logarithm.
pub(crate) fn log_node(min: f64, max: f64, index: usize, nodes: usize) -> f64 {
    match index {
        0 => min,
        i if i + 1 == nodes => max,
        i => min * (max / min).powf(i as f64 / (nodes - 1) as f64),
    }
}

/// Solved linear problem, in coordinates rotated by Q.
struct Projection {
    qr: Qr,
    rotated: Vec<f64>,
    coefficients: Vec<f64>,
}

impl Projection {
    fn residual(&self) -> &[f64] {
        &self.rotated[self.coefficients.len()..]
    }

    fn sum_of_squares(&self) -> f64 {
        square(self.residual())
    }

    /// Returns d(residual)/d(exponent of term `k`) in Kaufman's approximation, which leaves the gradient of the sum of
    /// squares exact.
    fn slope(&self, means: &Means, shapes: &[Shape], exponents: &[f64], k: usize) -> Vec<f64> {
        let mut column = means.slope(shapes, exponents, &self.coefficients[1..=shapes.len()], k);
        column.iter_mut().for_each(|value| *value = -*value);
        self.qr.rotate(column).split_off(self.coefficients.len())
    }

    fn into_minimum(self, shapes: &[Shape], exponents: &[f64]) -> Minimum {
        let kappa_tfc = self.coefficients[0];
        let mut parameters =
            Parameters { kappa_tfc, coefficients: [0.0; AXES], exponents: [1.0; AXES], crossed: false, edge: [0.0; 2] };
        for (factor, found) in parameters.edge.iter_mut().zip(&self.coefficients[1 + shapes.len()..]) {
            *factor = *found;
        }
        parameters.crossed = shapes.iter().any(|shape| shape.times.is_some());
        for (k, shape) in shapes.iter().enumerate() {
            parameters.coefficients[shape.axis] = self.coefficients[k + 1];
            parameters.exponents[shape.axis] = exponents[k];
        }
        Minimum { parameters, sum_of_squares: self.sum_of_squares() }
    }
}

/// Solves (J^T J + damping diag J^T J) step = -gradient for the moving exponents.
fn damped_step(slopes: &[Vec<f64>], gradient: &[f64], moving: &[usize], damping: f64) -> Vec<f64> {
    let n = moving.len();
    let mut rows: Vec<Vec<f64>> = moving
        .iter()
        .map(|&i| {
            let mut row: Vec<f64> = moving.iter().map(|&j| dot(&slopes[i], &slopes[j])).collect();
            row.push(-gradient[i]);
            row
        })
        .collect();
    for (i, row) in rows.iter_mut().enumerate() {
        row[i] += damping * row[i] + f64::MIN_POSITIVE;
    }
    for k in 0..n {
        for i in k + 1..n {
            let factor = rows[i][k] / rows[k][k];
            let (above, below) = rows.split_at_mut(i);
            below[0].iter_mut().zip(&above[k]).for_each(|(b, a)| *b -= factor * a);
        }
    }
    let mut step = vec![0.0; n];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| rows[k][j] * step[j]).sum();
        step[k] = (rows[k][n] - known) / rows[k][k];
    }
    step.iter().map(|s| if s.is_finite() { *s } else { 0.0 }).collect()
}

/// Householder QR of a tall matrix given by columns; each reflector is stored as a unit vector.
struct Qr {
    reflectors: Vec<Vec<f64>>,
    /// R by columns; column k holds its k + 1 entries.
    upper: Vec<Vec<f64>>,
}

impl Qr {
    fn new(columns: Vec<Vec<f64>>) -> Result<Self, Dependent> {
        let mut qr = Self { reflectors: Vec::with_capacity(columns.len()), upper: Vec::with_capacity(columns.len()) };
        for (k, column) in columns.into_iter().enumerate() {
            if k >= column.len() {
                return Err(Dependent);
            }
            let length = square(&column).sqrt();
            let mut column = qr.rotate(column);
            let tail = square(&column[k..]).sqrt();
            let independent = tail > DEPENDENT * length; // false for NaN too
            if !independent {
                return Err(Dependent);
            }
            let pivot = if column[k] > 0.0 { -tail } else { tail };
            let mut reflector = column.split_off(k);
            reflector[0] -= pivot;
            let norm = square(&reflector).sqrt();
            reflector.iter_mut().for_each(|v| *v /= norm);
            column.push(pivot);
            qr.upper.push(column);
            qr.reflectors.push(reflector);
        }
        Ok(qr)
    }

    /// Returns Q^T v.
    fn rotate(&self, mut v: Vec<f64>) -> Vec<f64> {
        for (k, reflector) in self.reflectors.iter().enumerate() {
            let twice = 2.0 * dot(reflector, &v[k..]);
            v[k..].iter_mut().zip(reflector).for_each(|(v, r)| *v -= twice * r);
        }
        v
    }

    /// Solves R x = the leading entries of `rotated`.
    fn back_substitute(&self, rotated: &[f64]) -> Vec<f64> {
        let n = self.upper.len();
        let mut x = rotated[..n].to_vec();
        for k in (0..n).rev() {
            x[k] /= self.upper[k][k];
            let value = x[k];
            x[..k].iter_mut().zip(&self.upper[k]).for_each(|(x, r)| *x -= value * r);
        }
        x
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Returns Σ a², which is +0 without values.
fn square(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |sum, a| sum + a * a)
}
