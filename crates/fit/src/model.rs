//! Settings of a fit: terms and their exponents, weights, resamples.

use crate::Axis;

/// Exponent of a term, fixed or fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exponent {
    /// Fixed at a value.
    Fixed(f64),
    /// Fitted between bounds.
    Free {
        /// Smallest value, above zero.
        min: f64,
        /// Largest value.
        max: f64,
    },
}

impl Exponent {
    /// Free exponent with the default bounds [1/4, 4].
    pub const FREE: Self = Self::Free { min: 0.25, max: 4.0 };
}

/// Terms of the model. `None` omits the term of an axis even if the axis has several levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Term in eps_t.
    pub t: Option<Exponent>,
    /// Term in eps_f.
    pub f: Option<Exponent>,
    /// Term in eps_c.
    pub c: Option<Exponent>,
    /// True if the term in eps_t is multiplied by the power of eps_f: C_t eps_t^alpha_t eps_f^alpha_f. Without a term
    /// in eps_f it is C_t eps_t^alpha_t.
    pub crossed: bool,
    /// Continuum error as a multiple of the measured edge of every realisation ([`crate::Datum::edge`]). Unlike a
    /// constant times eps_c, it scales with the perimeter of the contact. `c` must then be `None`.
    pub edge: Option<Edge>,
}

/// Expected factor of the measured edge, f + f' (eps_c/[`COARSE`])². The expected f, and a nonzero f', are observations
/// in addition to the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Expected f.
    pub factor: f64,
    /// Standard error of f, above zero; infinite without prior knowledge.
    pub standard_error: f64,
    /// Standard error of f', which has the expected value zero; zero fixes f' = 0.
    pub coarse: f64,
}

/// Value of eps_c at which f' is added once: four points per shortest wave.
pub const COARSE: f64 = 0.25;

impl Edge {
    /// No prior: the data alone determine the factor, which does not depend on eps_c.
    pub const UNKNOWN: Self = Self { factor: 1.0, standard_error: f64::INFINITY, coarse: 0.0 };

    /// Returns the number of columns.
    pub(crate) fn columns(&self) -> usize {
        1 + usize::from(self.coarse > 0.0)
    }

    /// Returns true if the expected factor is an observation.
    pub(crate) fn is_known(&self) -> bool {
        self.standard_error.is_finite()
    }
}

impl Default for Model {
    /// Fixes all three exponents at one. alpha_c = 1 is the perimeter error of a contact area counted in pixels. The
    /// exponents of the other two axes are conventions; check them against a fit with [`Model::free`].
    fn default() -> Self {
        Self {
            t: Some(Exponent::Fixed(1.0)),
            f: Some(Exponent::Fixed(1.0)),
            c: Some(Exponent::Fixed(1.0)),
            crossed: false,
            edge: None,
        }
    }
}

impl Model {
    /// Fits all three exponents within [1/4, 4].
    pub fn free() -> Self {
        Self { t: Some(Exponent::FREE), f: Some(Exponent::FREE), c: Some(Exponent::FREE), ..Self::default() }
    }

    pub(crate) fn of(&self, axis: Axis) -> Option<Exponent> {
        [self.t, self.f, self.c][axis as usize]
    }
}

/// Variance assigned to one realisation of a datum without common surfaces. The weight of the datum is its number of
/// realisations divided by this variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weighting {
    /// Average of the datum's own variance and the variance pooled over all data, weighted by degrees of freedom, with
    /// `prior` degrees of freedom for the pooled one. The pooled variance dominates for few realisations, the datum's
    /// own for many.
    Shrunk {
        /// Degrees of freedom assigned to the pooled variance.
        prior: f64,
    },
    /// Pooled variance for all data.
    Pooled,
    /// Equal weights for all data, for any number of realisations.
    Equal,
}

/// Settings of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Terms and their exponents.
    pub model: Model,
    /// Weights of the data.
    pub weighting: Weighting,
    /// Number of resamples of the means from their errors; 0 for none.
    pub resamples: usize,
    /// Seed of the resamples.
    pub seed: u64,
    /// True to compare data with common seeds surface by surface. False is only for tests of the method.
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
