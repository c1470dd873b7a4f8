//! Extrapolation to the thermodynamic, fractal and continuum limit (theory.md, section 11).
//!
//! kappa(eps_t, eps_f, eps_c) = kappa_TFC + C_t eps_t^alpha_t + C_f eps_f^alpha_f + C_c eps_c^alpha_c, fitted to all
//! cells of a sweep at once by weighted least squares. Numbers in, numbers out: no files, no clocks, no printing.
//!
//! - An axis with a single level has no term: kappa_TFC then still contains that axis' correction, and a warning says
//!   so.
//! - Intervals come from a bootstrap over realisations: seeds are resampled, the cells computed on one seed stay
//!   together (common random numbers), and everything is refitted. With few realisations the percentile interval is
//!   stretched by Student's t and (n / (n - 1))^(1/2), because the bare percentiles are then too narrow.
//! - Misfit of the model is not in these intervals. Look at `chi_squared`, at `kappa_tfc_without`, at the profiles, and
//!   at a second fit with other exponents.
//!
//! ```
//! use gfmd_fit::{Cell, Exponent, Model, Settings, fit};
//!
//! // kappa = 2 + 1.5 eps_c, four levels, the same three surfaces (seeds) at each.
//! let cells: Vec<Cell> = [0.5, 0.25, 0.125, 0.0625]
//!     .iter()
//!     .map(|&eps_c| Cell {
//!         eps_t: 0.5,
//!         eps_f: 0.1,
//!         eps_c,
//!         kappa: [(7, -0.01), (8, 0.0), (9, 0.01)].map(|(seed, noise)| (seed, 2.0 + 1.5 * eps_c + noise)).into(),
//!     })
//!     .collect();
//! let free = Model { c: Some(Exponent::Free { min: 0.25, max: 4.0 }), ..Model::default() };
//! let fit = fit(&cells, &Settings { model: free, ..Settings::default() }).unwrap();
//! assert!((fit.kappa_tfc.value - 2.0).abs() < 1e-8 && (fit.terms[0].exponent.value - 1.0).abs() < 1e-8);
//! ```

mod error;
mod projection;
mod report;
mod resample;
mod richardson;
mod uncertainty;

#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::fmt;

use rayon::prelude::*;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use projection::{Data, Minimum, Search, Shape, is_interior, log_node};
use resample::Strata;
use uncertainty::{Errors, Quantity};

pub use error::FitError;
pub use projection::Parameters;
pub use report::{BootstrapReport, CellReport, Estimate, Fit, ProfilePoint, Term, Uncertainty, Warning};
pub use richardson::{Richardson, RichardsonLimit};

/// One of the three limits.
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
    /// All axes, in the order of every array over axes here.
    pub const ALL: [Self; 3] = [Self::Thermodynamic, Self::Fractal, Self::Continuum];

    /// The letter t, f or c.
    pub fn letter(self) -> char {
        ['t', 'f', 'c'][self as usize]
    }
}

impl fmt::Display for Axis {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.letter())
    }
}

/// One discretisation of the sweep and the kappa of its realisations.
#[derive(Clone, Debug, PartialEq)]
pub struct Cell {
    /// Largest wavelength / cell length.
    pub eps_t: f64,
    /// Shortest / largest wavelength.
    pub eps_f: f64,
    /// Grid spacing / shortest wavelength.
    pub eps_c: f64,
    /// kappa by seed. Equal seeds in two cells mean that the cells were computed on the same random modes; cells that
    /// are independent must not have seeds in common.
    pub kappa: BTreeMap<u64, f64>,
}

impl Cell {
    /// The eps of one axis.
    pub fn eps(&self, axis: Axis) -> f64 {
        self.all_eps()[axis as usize]
    }

    /// (eps_t, eps_f, eps_c).
    pub fn all_eps(&self) -> [f64; 3] {
        [self.eps_t, self.eps_f, self.eps_c]
    }

    /// Mean over the realisations.
    pub fn mean(&self) -> f64 {
        self.kappa.values().sum::<f64>() / self.kappa.len() as f64
    }

    /// Variance of one realisation; `None` for a single one.
    pub fn variance(&self) -> Option<f64> {
        let mean = self.mean();
        let squares: f64 = self.kappa.values().map(|k| (k - mean) * (k - mean)).sum();
        (self.kappa.len() > 1).then(|| squares / (self.kappa.len() - 1) as f64)
    }
}

/// What is known about the exponent of a term before the fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exponent {
    /// Given.
    Fixed(f64),
    /// Found by the fit, between bounds.
    Free {
        /// Smallest value, above zero.
        min: f64,
        /// Largest value.
        max: f64,
    },
}

impl Exponent {
    /// The range over which a free exponent is sought unless told otherwise: [1/4, 4].
    pub const FREE: Self = Self::Free { min: 0.25, max: 4.0 };
}

/// Which terms to fit. `None` leaves the term of an axis out although the axis has several levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Term in eps_t.
    pub t: Option<Exponent>,
    /// Term in eps_f.
    pub f: Option<Exponent>,
    /// Term in eps_c.
    pub c: Option<Exponent>,
}

impl Default for Model {
    /// All three exponents fixed at one. alpha_c = 1 is the perimeter error of a contact area counted in pixels; the
    /// other two are conventions, to be checked against a fit with [`Model::free`].
    fn default() -> Self {
        Self { t: Some(Exponent::Fixed(1.0)), f: Some(Exponent::Fixed(1.0)), c: Some(Exponent::Fixed(1.0)) }
    }
}

impl Model {
    /// All three exponents sought in [1/4, 4].
    pub fn free() -> Self {
        Self { t: Some(Exponent::FREE), f: Some(Exponent::FREE), c: Some(Exponent::FREE) }
    }

    fn of(&self, axis: Axis) -> Option<Exponent> {
        [self.t, self.f, self.c][axis as usize]
    }
}

/// The variance given to one realisation of a cell. A cell's weight is its number of realisations over this variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weighting {
    /// The cell's own variance and the variance pooled over all cells, averaged by degrees of freedom, the pool
    /// counting as `prior` of them: with few realisations the pool decides, with many the cell.
    Shrunk {
        /// Degrees of freedom given to the pooled variance.
        prior: f64,
    },
    /// The pooled variance for all cells.
    Pooled,
    /// The same weight for all cells, whatever their number of realisations.
    Equal,
}

/// How to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The terms and their exponents.
    pub model: Model,
    /// The weights of the cells.
    pub weighting: Weighting,
    /// Number of bootstrap resamples; 0 for none.
    pub resamples: usize,
    /// Seed of the bootstrap.
    pub seed: u64,
    /// Whether the cells of one seed are resampled together. Only a test of the method has a reason to say no.
    pub paired: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            model: Model::default(),
            weighting: Weighting::Shrunk { prior: 8.0 },
            resamples: 2000,
            seed: 1,
            paired: true,
        }
    }
}

/// Fits the model to the cells.
///
/// The same data and settings give the same bits for any number of threads.
pub fn fit(cells: &[Cell], settings: &Settings) -> Result<Fit, FitError> {
    check(cells, settings)?;
    let mut warnings = Vec::new();
    let (shapes, held) = shapes(cells, &settings.model, &mut warnings);
    let parameters = 1 + shapes.len() + shapes.iter().filter(|shape| shape.is_free()).count();
    if parameters > cells.len() {
        return Err(FitError::TooFewCells { parameters, cells: cells.len() });
    }
    let (data, noise_known) = weighted(cells, settings.weighting);
    let minimum = data.minimise(&shapes, Search::Thorough, None).map_err(|_| FitError::Dependent)?;
    let degrees_of_freedom = cells.len() - parameters;

    let strata = Strata::new(cells, settings.paired);
    let errors = Errors::new(&data, &shapes, &minimum, &strata, settings, degrees_of_freedom)?;
    let fit = Fit {
        kappa_tfc: errors.estimate(Quantity::Limit),
        terms: shapes
            .iter()
            .enumerate()
            .map(|(k, shape)| {
                let axis = Axis::ALL[shape.axis];
                Term {
                    axis,
                    levels: levels(cells, axis).len(),
                    coefficient: errors.estimate(Quantity::Coefficient(k)),
                    exponent: errors.estimate(Quantity::Exponent(k)),
                    free: shape.is_free(),
                    held: held.contains(&axis),
                    at_bound: shape.is_free() && !is_interior(shape, minimum.parameters.exponents[shape.axis]),
                    profile: profile(&data, &shapes, k, &minimum),
                }
            })
            .collect(),
        parameters: minimum.parameters,
        chi_squared: minimum.sum_of_squares,
        noise_known,
        degrees_of_freedom,
        cells: cell_reports(cells, &data, &shapes, &minimum),
        richardson: Axis::ALL.iter().flat_map(|&axis| richardson::triples(cells, axis)).collect(),
        uncertainty: errors.source,
        bootstrap: errors.bootstrap,
        warnings,
    };
    Ok(fit.with_warnings(cells, strata.single()))
}

/// True for two eps that are meant to be the same.
fn same_level(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * a.abs().max(b.abs())
}

/// The distinct levels of an axis, largest first.
fn levels(cells: &[Cell], axis: Axis) -> Vec<f64> {
    let mut all: Vec<f64> = cells.iter().map(|cell| cell.eps(axis)).collect();
    all.sort_by(|a, b| b.total_cmp(a));
    all.dedup_by(|a, b| same_level(*a, *b));
    all
}

fn check(cells: &[Cell], settings: &Settings) -> Result<(), FitError> {
    if cells.is_empty() {
        return Err(FitError::NoCells);
    }
    for (index, cell) in cells.iter().enumerate() {
        if cell.kappa.is_empty() {
            return Err(FitError::NoRealisations { cell: index });
        }
        if let Some((&seed, &found)) = cell.kappa.iter().find(|(_, kappa)| !kappa.is_finite()) {
            return Err(FitError::BadKappa { cell: index, seed, found });
        }
        for axis in Axis::ALL {
            let found = cell.eps(axis);
            if !(found > 0.0 && found.is_finite()) {
                return Err(FitError::BadEps { cell: index, axis, found });
            }
        }
        let same = |other: &Cell| Axis::ALL.iter().all(|&axis| same_level(other.eps(axis), cell.eps(axis)));
        if let Some(first) = cells[..index].iter().position(same) {
            return Err(FitError::SameCell { first, second: index });
        }
    }
    for axis in Axis::ALL {
        let (min, max) = match settings.model.of(axis) {
            None => continue,
            Some(Exponent::Fixed(alpha)) => (alpha, alpha),
            Some(Exponent::Free { min, max }) => (min, max),
        };
        if !(min > 0.0 && min <= max && max <= 16.0) {
            return Err(FitError::BadExponent { axis, min, max });
        }
    }
    match settings.weighting {
        Weighting::Shrunk { prior: found } if !(found >= 0.0 && found.is_finite()) => Err(FitError::BadPrior { found }),
        _ => Ok(()),
    }
}

/// The terms that the levels allow, and the axes whose free exponent they leave undetermined.
fn shapes(cells: &[Cell], model: &Model, warnings: &mut Vec<Warning>) -> (Vec<Shape>, Vec<Axis>) {
    let (mut shapes, mut held) = (Vec::new(), Vec::new());
    for axis in Axis::ALL {
        let levels = levels(cells, axis);
        let Some(exponent) = model.of(axis) else {
            if levels.len() > 1 {
                warnings.push(Warning::TermLeftOut { axis, levels: levels.len() });
            }
            continue;
        };
        let (min, max) = match (exponent, levels.len()) {
            (_, 0 | 1) => {
                warnings.push(Warning::SingleLevel { axis, eps: levels[0] });
                continue;
            }
            (Exponent::Fixed(alpha), _) => (alpha, alpha),
            (Exponent::Free { min, max }, 2) => {
                let alpha = 1.0_f64.clamp(min, max);
                warnings.push(Warning::ExponentHeld { axis, alpha });
                held.push(axis);
                (alpha, alpha)
            }
            (Exponent::Free { min, max }, _) => (min, max),
        };
        shapes.push(Shape { axis: axis as usize, min, max });
    }
    (shapes, held)
}

/// The data with their weights; the flag says whether the weights are inverse variances.
fn weighted(cells: &[Cell], weighting: Weighting) -> (Data, bool) {
    let freedom = |cell: &Cell| (cell.kappa.len() - 1) as f64;
    let total: f64 = cells.iter().map(freedom).sum();
    let squares: f64 = cells.iter().map(|cell| freedom(cell) * cell.variance().unwrap_or(0.0)).sum();
    let pooled = squares / total;
    let known = pooled > 0.0 && weighting != Weighting::Equal;
    let weight = |cell: &Cell| {
        let variance = match weighting {
            Weighting::Shrunk { prior } if freedom(cell) + prior > 0.0 => {
                (prior * pooled + freedom(cell) * cell.variance().unwrap_or(0.0)) / (prior + freedom(cell))
            }
            _ => pooled,
        };
        // A cell whose few realisations happen to agree must not outweigh all others.
        cell.kappa.len() as f64 / variance.max(1e-4 * pooled)
    };
    let data = Data {
        eps: cells.iter().map(Cell::all_eps).collect(),
        kappa: cells.iter().map(Cell::mean).collect(),
        root_weight: cells.iter().map(|cell| if known { weight(cell).sqrt() } else { 1.0 }).collect(),
    };
    (data, known)
}

/// chi^2 and kappa_TFC against the exponent of term `k`, everything else refitted.
fn profile(data: &Data, shapes: &[Shape], k: usize, minimum: &Minimum) -> Vec<ProfilePoint> {
    const NODES: usize = 41;
    let (min, max) = if shapes[k].is_free() { (shapes[k].min, shapes[k].max) } else { (0.25, 4.0) };
    let mut exponents: Vec<f64> = (0..NODES).map(|i| log_node(min, max, i, NODES)).collect();
    exponents.push(minimum.parameters.exponents[shapes[k].axis]);
    exponents.sort_by(f64::total_cmp);
    exponents.dedup();
    exponents
        .into_par_iter()
        .filter_map(|exponent| {
            let mut shapes = shapes.to_vec();
            shapes[k] = Shape { min: exponent, max: exponent, ..shapes[k] };
            let at = data.minimise(&shapes, Search::Near, Some(&minimum.parameters)).ok()?;
            Some(ProfilePoint { exponent, chi_squared: at.sum_of_squares, kappa_tfc: at.parameters.kappa_tfc })
        })
        .collect()
}

fn cell_reports(cells: &[Cell], data: &Data, shapes: &[Shape], minimum: &Minimum) -> Vec<CellReport> {
    let without = |left_out: usize| {
        let mut rest = data.clone();
        rest.eps.remove(left_out);
        rest.kappa.remove(left_out);
        rest.root_weight.remove(left_out);
        let needed = 1 + shapes.len() + shapes.iter().filter(|shape| shape.is_free()).count();
        let refit =
            (needed <= rest.kappa.len()).then(|| rest.minimise(shapes, Search::Near, Some(&minimum.parameters)).ok());
        refit.flatten().map(|minimum| minimum.parameters.kappa_tfc)
    };
    (0..cells.len())
        .into_par_iter()
        .map(|i| CellReport {
            mean: data.kappa[i],
            standard_error: cells[i].variance().map(|variance| (variance / cells[i].kappa.len() as f64).sqrt()),
            weight: data.root_weight[i] * data.root_weight[i],
            fitted: minimum.parameters.predict(data.eps[i]),
            kappa_tfc_without: without(i),
        })
        .collect()
}

/// The probability of a chi^2 at least this large, if the model and the noise are right.
fn chance_of_misfit(chi_squared: f64, degrees_of_freedom: usize) -> Option<f64> {
    ChiSquared::new(degrees_of_freedom as f64).ok().map(|distribution| distribution.sf(chi_squared))
}
