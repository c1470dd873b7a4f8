//! Data of a fit: kappa of the realisations at each discretisation.

use std::collections::BTreeMap;
use std::fmt;

/// Axis of one of the three limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Axis {
    /// Thermodynamic: eps_t = largest wavelength / cell length.
    Thermodynamic,
    /// Fractal: eps_f = shortest / largest wavelength.
    Fractal,
    /// Continuum: eps_c = grid spacing / shortest wavelength.
    Continuum,
}

impl Axis {
    /// All axes, in the order of every array over axes in this crate.
    pub const ALL: [Self; 3] = [Self::Thermodynamic, Self::Fractal, Self::Continuum];

    /// Returns the letter t, f or c.
    pub fn letter(self) -> char {
        ['t', 'f', 'c'][self as usize]
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.letter())
    }
}

/// Discretisation of the sweep and kappa of its realisations.
#[derive(Clone, Debug, PartialEq)]
pub struct Datum {
    /// Largest wavelength / cell length.
    pub eps_t: f64,
    /// Shortest / largest wavelength.
    pub eps_f: f64,
    /// Grid spacing / shortest wavelength.
    pub eps_c: f64,
    /// kappa by seed. Data with a common seed must come from the same random modes; independent data must not share
    /// seeds.
    pub kappa: BTreeMap<u64, f64>,
    /// Measured edge of the contact by seed, in units of kappa: an estimate of the contribution of whole points along
    /// the perimeter to kappa. Empty, or for the same seeds as `kappa`; needed by [`crate::Model::edge`].
    pub edge: BTreeMap<u64, f64>,
}

impl Datum {
    /// Returns eps on one axis.
    pub fn eps(&self, axis: Axis) -> f64 {
        self.all_eps()[axis as usize]
    }

    /// Returns the array (eps_t, eps_f, eps_c).
    pub fn all_eps(&self) -> [f64; 3] {
        [self.eps_t, self.eps_f, self.eps_c]
    }

    /// Makes a datum at (eps_t, eps_f, eps_c) without measured edges.
    pub fn new(eps: [f64; 3], kappa: BTreeMap<u64, f64>) -> Self {
        let [eps_t, eps_f, eps_c] = eps;
        Self { eps_t, eps_f, eps_c, kappa, edge: BTreeMap::new() }
    }

    /// Returns the mean over the realisations.
    pub fn mean(&self) -> f64 {
        self.kappa.values().sum::<f64>() / self.kappa.len() as f64
    }

    /// Returns the mean of the measured edge over the realisations; zero without measured edges.
    pub fn mean_edge(&self) -> f64 {
        self.edge.values().sum::<f64>() / self.edge.len().max(1) as f64
    }

    /// Returns the variance of one realisation; `None` for a single realisation.
    pub fn variance(&self) -> Option<f64> {
        let mean = self.mean();
        let squares: f64 = self.kappa.values().map(|k| (k - mean) * (k - mean)).sum();
        (self.kappa.len() > 1).then(|| squares / (self.kappa.len() - 1) as f64)
    }

    /// Returns the standard error of the mean; `None` for a single realisation.
    pub fn standard_error(&self) -> Option<f64> {
        self.variance().map(|variance| (variance / self.kappa.len() as f64).sqrt())
    }
}

/// Returns true if two values of eps are equal up to rounding.
pub(crate) fn same_level(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

/// Returns the distinct levels (values of eps) on an axis, largest first.
pub(crate) fn levels(data: &[Datum], axis: Axis) -> Vec<f64> {
    let mut all: Vec<f64> = data.iter().map(|datum| datum.eps(axis)).collect();
    all.sort_by(|a, b| b.total_cmp(a));
    all.dedup_by(|a, b| same_level(*a, *b));
    all
}
