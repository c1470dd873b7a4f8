//! Rows of the fit: data with common surfaces are replaced by independent comparisons.
//!
//! kappa of one surface at two discretisations differs much less than kappa of two surfaces. If the surfaces of a datum
//! are among the surfaces of another one, its parent, it therefore enters the fit as the mean of kappa - b kappa_parent
//! over these surfaces, with b the coefficient of their regression. The residual of the regression does not correlate
//! with kappa_parent, so that all rows are independent, and the many surfaces of a coarse parent improve its finer
//! children (the regression estimator of double sampling; for nested surfaces the maximum-likelihood estimate: T. W.
//! Anderson, J. Am. Stat. Assoc. 52, 200, 1957).

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::projection::{Means, Parent, factor};
use crate::student::stretch;
use crate::{Axis, Datum, Edge, Settings, Weighting};

/// Smallest number of common surfaces to compute b; with fewer, b = 1.
const LEAST_REGRESSION: usize = 4;

/// Lower bound of the variance of a realisation in a row, as a fraction of the pooled one: a few realisations that
/// agree by chance must not dominate the fit.
const LEAST_VARIANCE: f64 = 1e-6;

/// Weight of the pooled variance of comparisons, relative to the weight for data without a parent: the variances of
/// comparisons differ more.
const COMPARED_PRIOR: f64 = 0.25;

/// Independent rows of a fit, in the order of the data.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    /// Fitted values.
    pub(crate) means: Means,
    /// Standard error of each row.
    errors: Vec<f64>,
    /// Degrees of freedom of each error; zero if it is estimated from the other rows.
    freedom: Vec<f64>,
    /// True if the weights are inverse variances.
    pub(crate) noise_known: bool,
    /// Number of data with a single realisation.
    pub(crate) single: usize,
}

/// Standard error of a linear combination of the rows, and its accuracy.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spread {
    pub(crate) standard_error: f64,
    /// Student's t divided by the normal quantile, with the degrees of freedom of Welch and Satterthwaite.
    pub(crate) stretch: f64,
}

impl Rows {
    /// Makes the rows of the data, with the columns of the measured edge if the model has `edge`. `factors` are the
    /// current estimates of f and f' for the scatter.
    pub(crate) fn new(data: &[Datum], settings: &Settings, edge: Option<Edge>, factors: [f64; 2]) -> Self {
        let paired = settings.paired && settings.weighting != Weighting::Equal;
        let scatter: Vec<Scatter> = (0..data.len()).map(|index| Scatter::of(data, index, paired, factors)).collect();
        let pool = Pool::of(&scatter);
        let mut errors: Vec<f64> =
            scatter.iter().map(|row| (pool.variance(row, settings.weighting) / row.count).sqrt()).collect();
        let noise_known = pool.alone > 0.0 && settings.weighting != Weighting::Equal;
        let parents: Vec<Option<Parent>> = scatter.iter().map(|row| row.parent).collect();
        let compare = |value: &dyn Fn(&Datum, u64) -> f64| -> Vec<f64> {
            data.iter().zip(&parents).map(|(datum, parent)| comparison(data, datum, *parent, value)).collect()
        };
        let measured = |datum: &Datum, seed: u64| datum.edge.get(&seed).copied().unwrap_or(0.0);
        let mut means = Means {
            eps: data.iter().map(Datum::all_eps).collect(),
            kappa: compare(&|datum, seed| datum.kappa[&seed]),
            edges: (0..edge.map_or(0, |edge| edge.columns()))
                .map(|column| {
                    let part = [f64::from(u8::from(column == 0)), f64::from(u8::from(column == 1))];
                    compare(&|datum, seed| factor(part, datum.eps_c) * measured(datum, seed))
                })
                .collect(),
            root_weight: errors.iter().map(|error| if noise_known { error.recip() } else { 1.0 }).collect(),
            parents,
        };
        let mut freedom: Vec<f64> = scatter.iter().map(|row| row.freedom).collect();
        let expected = edge.into_iter().flat_map(|edge| [(edge.factor, edge.standard_error), (0.0, edge.coarse)]);
        for (column, (value, error)) in expected.enumerate().take(means.edges.len()) {
            if error.is_finite() {
                means.edges.iter_mut().enumerate().for_each(|(k, edge)| edge.push(f64::from(u8::from(k == column))));
                means.kappa.push(value);
                means.root_weight.push(error.recip());
                errors.push(error);
                freedom.push(0.0);
            }
        }
        let single = data.iter().filter(|datum| datum.kappa.len() < 2).count();
        Self { means, errors, freedom, noise_known, single }
    }

    /// Returns true if some datum has at least two realisations.
    pub(crate) fn have_scatter(&self) -> bool {
        self.single < self.means.eps.len()
    }

    /// Returns the rows with one draw of their errors added. The draw depends only on `seed` and `index`.
    pub(crate) fn draw(&self, seed: u64, index: u64) -> Vec<f64> {
        let mut rng = Pcg64::seed_from_u64(seed.wrapping_add(index.wrapping_mul(0x9E37_79B9_7F4A_7C15)));
        let mut normal = || {
            let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
            (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
        };
        self.means.kappa.iter().zip(&self.errors).map(|(kappa, error)| kappa + error * normal()).collect()
    }

    /// Returns the spread of the sum of a_i times row i; `None` without scatter.
    pub(crate) fn spread(&self, combination: &[f64]) -> Option<Spread> {
        let parts = || combination.iter().zip(&self.errors).map(|(a, error)| (a * error).powi(2));
        let variance: f64 = parts().sum();
        let of_variance: f64 = parts().zip(&self.freedom).filter(|(_, f)| **f > 0.0).map(|(p, f)| p * p / f).sum();
        let freedom = if of_variance > 0.0 { variance * variance / of_variance } else { f64::INFINITY };
        self.have_scatter().then(|| Spread { standard_error: variance.sqrt(), stretch: stretch(freedom) })
    }
}

/// Scatter of one row.
#[derive(Clone, Copy, Debug)]
struct Scatter {
    parent: Option<Parent>,
    /// Number of realisations.
    count: f64,
    /// Variance of the row times the number of realisations.
    of_one: f64,
    /// Degrees of freedom of this variance; zero for a single realisation.
    freedom: f64,
}

impl Scatter {
    fn of(data: &[Datum], index: usize, paired: bool, factors: [f64; 2]) -> Self {
        let value = |datum: &Datum, seed: u64| {
            datum.kappa[&seed] - factor(factors, datum.eps_c) * datum.edge.get(&seed).unwrap_or(&0.0)
        };
        let mean = |of: &Datum, seeds: &Datum| {
            seeds.kappa.keys().map(|seed| value(of, *seed)).sum::<f64>() / seeds.kappa.len() as f64
        };
        let datum = &data[index];
        let (count, middle) = (datum.kappa.len() as f64, mean(datum, datum));
        let squares: f64 = datum.kappa.keys().map(|seed| (value(datum, *seed) - middle).powi(2)).sum();
        let alone = Self { parent: None, count, of_one: squares / (count - 1.0).max(1.0), freedom: count - 1.0 };
        let Some(parent) = paired.then(|| parent(data, index)).flatten() else { return alone };
        let above = &data[parent];
        let common = mean(above, datum);
        let (mut own, mut crossed) = (0.0, 0.0);
        for seed in datum.kappa.keys() {
            let [x, y] = [value(above, *seed) - common, value(datum, *seed) - middle];
            own += x * x;
            crossed += x * y;
        }
        if own <= 0.0 {
            return alone;
        }
        let regression = datum.kappa.len() >= LEAST_REGRESSION;
        let (b, freedom) = if regression { (crossed / own, count - 2.0) } else { (1.0, count - 1.0) };
        let residual = (squares - 2.0 * b * crossed + b * b * own).max(0.0) / freedom;
        // The error of b is weighted by the distance between the means of the common surfaces and of the parent.
        let leverage = if regression { (mean(above, above) - common).powi(2) / own } else { 0.0 };
        Self { parent: Some((parent, b)), count, of_one: residual * (1.0 + count * leverage), freedom }
    }
}

/// Variances pooled over the data.
#[derive(Clone, Copy, Debug)]
struct Pool {
    /// Mean over the data without a parent.
    alone: f64,
    /// Geometric mean over the comparisons, since their variances differ by orders of magnitude.
    compared: f64,
}

impl Pool {
    fn of(scatter: &[Scatter]) -> Self {
        let mean = |terms: &mut dyn Iterator<Item = (f64, f64)>| {
            let (weights, sum) = terms.fold((0.0, 0.0), |(w, s), (weight, value)| (w + weight, s + weight * value));
            if weights > 0.0 { sum / weights } else { f64::NEG_INFINITY }
        };
        let roots = scatter.iter().filter(|row| row.parent.is_none());
        let alone = mean(&mut roots.map(|row| (row.freedom, row.of_one))).max(0.0);
        let compared = scatter.iter().filter(|row| row.parent.is_some() && row.of_one > 0.0);
        Self { alone, compared: mean(&mut compared.map(|row| (row.freedom, row.of_one.ln()))).exp() }
    }

    /// Returns the variance of one realisation in a row.
    fn variance(&self, row: &Scatter, weighting: Weighting) -> f64 {
        let Scatter { of_one: own, freedom, .. } = *row;
        let found = match (weighting, row.parent) {
            (Weighting::Shrunk { prior }, None) if freedom + prior > 0.0 => {
                (prior * self.alone + freedom * own) / (prior + freedom)
            }
            (Weighting::Shrunk { prior }, Some(_)) if own > 0.0 => {
                let prior = COMPARED_PRIOR * prior;
                ((prior * self.compared.ln() + freedom * own.ln()) / (prior + freedom)).exp()
            }
            (_, Some(_)) => self.compared,
            (_, None) => self.alone,
        };
        found.max(LEAST_VARIANCE * self.alone)
    }
}

/// Returns the datum to compare with datum `index`: the one nearest in the logarithms of eps, among the preceding data
/// (more surfaces, or a coarser grid) that have all its surfaces.
fn parent(data: &[Datum], index: usize) -> Option<usize> {
    let datum = &data[index];
    if datum.kappa.len() < 2 {
        return None;
    }
    let order = |i: usize| {
        let eps: f64 = data[i].all_eps().iter().product();
        (std::cmp::Reverse(data[i].kappa.len()), std::cmp::Reverse(eps.to_bits()), i)
    };
    let distance =
        |i: usize| -> f64 { Axis::ALL.iter().map(|&axis| (data[i].eps(axis) / datum.eps(axis)).ln().abs()).sum() };
    (0..data.len())
        .filter(|&i| order(i) < order(index))
        .filter(|&i| datum.kappa.keys().all(|seed| data[i].kappa.contains_key(seed)))
        .min_by(|&a, &b| distance(a).total_cmp(&distance(b)).then(order(a).cmp(&order(b))))
}

/// Returns the mean of value - b value_parent over the surfaces of a datum.
fn comparison(data: &[Datum], datum: &Datum, parent: Option<Parent>, value: &dyn Fn(&Datum, u64) -> f64) -> f64 {
    let one = |seed: u64| match parent {
        Some((above, b)) => value(datum, seed) - b * value(&data[above], seed),
        None => value(datum, seed),
    };
    datum.kappa.keys().map(|seed| one(*seed)).sum::<f64>() / datum.kappa.len() as f64
}
