//! Settings of a fit: terms and their exponents, weights, resamples.

use crate::Axis;

/// The exponent of a term: fixed or fitted.
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
    /// A free exponent with the default bounds [1/4, 4].
    pub const FREE: Self = Self::Free { min: 0.25, max: 4.0 };
}

/// The terms of the model. `None` leaves the term of an axis out even if the axis has several levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Term in eps_t.
    pub t: Option<Exponent>,
    /// Term in eps_f.
    pub f: Option<Exponent>,
    /// Term in eps_c.
    pub c: Option<Exponent>,
    /// If true, the continuum error is (s + s' eps_c) times the measured edge of every realisation, with s and s' fitted:
    /// unlike a constant times eps_c, it grows and falls with the perimeter of the contact. `c` must then be `None`.
    pub edge: bool,
}

impl Default for Model {
    /// All three exponents fixed at one. alpha_c = 1 is the perimeter error of a contact area counted in pixels; the
    /// exponents of the other two axes are conventions; check them against a fit with [`Model::free`].
    fn default() -> Self {
        Self {
            t: Some(Exponent::Fixed(1.0)),
            f: Some(Exponent::Fixed(1.0)),
            c: Some(Exponent::Fixed(1.0)),
            edge: false,
        }
    }
}

impl Model {
    /// All three exponents fitted within [1/4, 4].
    pub fn free() -> Self {
        Self { t: Some(Exponent::FREE), f: Some(Exponent::FREE), c: Some(Exponent::FREE), edge: false }
    }

    pub(crate) fn of(&self, axis: Axis) -> Option<Exponent> {
        [self.t, self.f, self.c][axis as usize]
    }
}

/// The variance assigned to one realisation of a datum that has no surfaces in common with another one. The weight of
/// such a datum is its number of realisations over this variance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Weighting {
    /// The average of the datum's own variance and the variance pooled over all data, weighted by degrees of freedom,
    /// with `prior` degrees of freedom for the pooled one: it dominates for few realisations, the own one for many.
    Shrunk {
        /// Degrees of freedom assigned to the pooled variance.
        prior: f64,
    },
    /// The pooled variance for all data.
    Pooled,
    /// Equal weights for all data, for any number of realisations.
    Equal,
}

/// Settings of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The terms and their exponents.
    pub model: Model,
    /// The weights of the data.
    pub weighting: Weighting,
    /// Number of resamples of the means from their errors; 0 for none.
    pub resamples: usize,
    /// Seed of the resamples.
    pub seed: u64,
    /// If true, data with common seeds are compared surface by surface. False is only for tests of the method.
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
