//! What a fit says about itself.

use std::fmt;

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::{Axis, Datum, Parameters, Richardson};

/// A number and what is known of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value of the fit to the means.
    pub value: f64,
    /// Linear error propagation of the scatter (or misfit) into this number; `None` if it is given, at its bound, or if
    /// nothing is known.
    pub standard_error: Option<f64>,
    /// 95 % interval; see [`Uncertainty`] for its source.
    pub ci95: Option<[f64; 2]>,
}

/// Where the intervals come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Uncertainty {
    /// Bootstrap over realisations.
    Realisations,
    /// Linear propagation of the scatter of realisations (no bootstrap was asked for, or none of its refits worked).
    Propagated,
    /// One realisation per datum: the misfit of the model stands for the noise.
    Misfit,
    /// One realisation per datum and as many parameters as data: nothing is known.
    None,
}

impl fmt::Display for Uncertainty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Realisations => "bootstrap over realisations",
            Self::Propagated => "scatter of realisations, linearly propagated",
            Self::Misfit => "misfit of the model (one realisation per datum)",
            Self::None => "none: one realisation per datum and no degrees of freedom",
        })
    }
}

/// One term C eps^alpha of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// Its axis.
    pub axis: Axis,
    /// Number of levels of the axis in the data.
    pub levels: usize,
    /// C, in units of kappa.
    pub coefficient: Estimate,
    /// alpha.
    pub exponent: Estimate,
    /// Whether the exponent was fitted.
    pub free: bool,
    /// Whether the exponent was to be fitted but two levels do not determine it; it is then held at one.
    pub held: bool,
    /// Whether the fitted exponent stopped at a bound.
    pub at_bound: bool,
    /// chi^2 and kappa_TFC against this exponent, everything else refitted; rising exponents.
    pub profile: Vec<ProfilePoint>,
}

/// One point of a profile likelihood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfilePoint {
    /// The exponent, held.
    pub exponent: f64,
    /// The least chi^2 with it.
    pub chi_squared: f64,
    /// kappa_TFC there.
    pub kappa_tfc: f64,
}

/// One datum as the fit sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DatumReport {
    /// Mean over realisations.
    pub mean: f64,
    /// Standard error of the mean from the datum's own scatter; `None` for a single realisation.
    pub standard_error: Option<f64>,
    /// Weight in the sum of squares.
    pub weight: f64,
    /// The model's value.
    pub fitted: f64,
    /// kappa_TFC of a fit without this datum; `None` where the other data do not determine the model.
    pub kappa_tfc_without: Option<f64>,
}

/// What the bootstrap did.
#[derive(Clone, Debug, PartialEq)]
pub struct BootstrapReport {
    /// Resamples asked for.
    pub resamples: usize,
    /// Resamples without a fit: a datum lost all its realisations, or the terms could not be told apart.
    pub failed: usize,
    /// For each free exponent, the number of resamples in which it stopped at a bound.
    pub at_bound: Vec<(Axis, usize)>,
    /// The seed.
    pub seed: u64,
    /// By which the deviations of the percentiles of kappa_TFC were multiplied because realisations are few; tends to
    /// one.
    pub stretch: f64,
    /// The refitted parameters, failed resamples left out, in the order of the draws.
    pub samples: Vec<Parameters>,
}

/// The result of [`crate::fit()`].
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// kappa in the thermodynamic, fractal and continuum limit.
    pub kappa_tfc: Estimate,
    /// The terms, in the order t, f, c, only those fitted.
    pub terms: Vec<Term>,
    /// All fitted numbers once more, as arrays over the axes.
    pub parameters: Parameters,
    /// The weighted sum of squares. Data that share seeds are correlated, so that it tends to fall below the degrees
    /// of freedom; with `noise_known` false it is a plain sum of squares in units of kappa^2.
    pub chi_squared: f64,
    /// Whether the weights are inverse variances. False for equal weights and without scatter to take them from.
    pub noise_known: bool,
    /// Data minus parameters.
    pub degrees_of_freedom: usize,
    /// One report for each datum, in the order of the data.
    pub data: Vec<DatumReport>,
    /// Three-level extrapolations along single axes, a check on the joint fit.
    pub richardson: Vec<Richardson>,
    /// Where the intervals come from.
    pub uncertainty: Uncertainty,
    /// The bootstrap, if there was one.
    pub bootstrap: Option<BootstrapReport>,
    /// What a reader of the numbers has to know.
    pub warnings: Vec<Warning>,
}

impl Fit {
    /// The term of an axis, if it was fitted.
    pub fn term(&self, axis: Axis) -> Option<&Term> {
        self.terms.iter().find(|term| term.axis == axis)
    }

    /// kappa of the fitted model at (eps_t, eps_f, eps_c).
    pub fn predict(&self, eps: [f64; 3]) -> f64 {
        self.parameters.predict(eps)
    }

    /// The mean of a datum with the terms of all axes but `axis` taken off: what to plot against eps^alpha of that axis.
    pub fn isolate(&self, datum: &Datum, axis: Axis) -> f64 {
        let others = Axis::ALL.iter().filter(|&&other| other != axis);
        datum.mean() - others.map(|&other| self.parameters.term(other as usize, datum.eps(other))).sum::<f64>()
    }

    pub(crate) fn with_warnings(mut self, data: &[Datum], single: usize) -> Self {
        let least = data.iter().map(|datum| datum.kappa.len()).min().unwrap_or(0);
        let mut warnings = std::mem::take(&mut self.warnings);
        if self.degrees_of_freedom == 0 {
            warnings.push(Warning::Interpolation);
        } else if let Some(chance) =
            chance_of_misfit(self.chi_squared, self.degrees_of_freedom).filter(|&p| self.noise_known && p < 0.01)
        {
            let (chi_squared, degrees_of_freedom) = (self.chi_squared, self.degrees_of_freedom);
            warnings.push(Warning::Misfit { chi_squared, degrees_of_freedom, chance });
        }
        if self.uncertainty == Uncertainty::Realisations && single > 0 {
            warnings.push(Warning::SingleRealisation { groups: single });
        } else if least < 4 {
            warnings.push(Warning::FewRealisations { least });
        }
        for term in &self.terms {
            let (axis, alpha) = (term.axis, term.exponent.value);
            if term.at_bound {
                warnings.push(Warning::ExponentAtBound { axis, alpha });
            }
            if let Some(ci95) = term.coefficient.ci95.filter(|ci| ci[0] <= 0.0 && ci[1] >= 0.0) {
                warnings.push(Warning::NotSignificant { axis, ci95 });
            }
        }
        if let Some(bootstrap) = &self.bootstrap {
            if bootstrap.failed > 0 {
                warnings.push(Warning::FailedRefits { failed: bootstrap.failed, resamples: bootstrap.resamples });
            }
            for &(axis, stuck) in bootstrap.at_bound.iter().filter(|(_, stuck)| stuck * 20 > bootstrap.resamples) {
                warnings.push(Warning::RefitsAtBound { axis, stuck, resamples: bootstrap.resamples });
            }
        }
        self.warnings = warnings;
        self
    }
}

/// What a reader of the numbers has to know.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// One level: no term, and kappa_TFC contains the correction of this axis.
    SingleLevel {
        /// The axis.
        axis: Axis,
        /// Its level.
        eps: f64,
    },
    /// The model leaves the term out although the axis has several levels.
    TermLeftOut {
        /// The axis.
        axis: Axis,
        /// Its number of levels.
        levels: usize,
    },
    /// Two levels do not determine an exponent.
    ExponentHeld {
        /// The axis.
        axis: Axis,
        /// Where the exponent is held.
        alpha: f64,
    },
    /// A free exponent stopped at its bound.
    ExponentAtBound {
        /// The axis.
        axis: Axis,
        /// The bound.
        alpha: f64,
    },
    /// In more than 5 % of the resamples a free exponent stopped at its bound: the intervals depend on the bounds.
    RefitsAtBound {
        /// The axis.
        axis: Axis,
        /// Number of resamples at a bound.
        stuck: usize,
        /// Of so many.
        resamples: usize,
    },
    /// The interval of a coefficient contains zero.
    NotSignificant {
        /// The axis.
        axis: Axis,
        /// The interval of the coefficient.
        ci95: [f64; 2],
    },
    /// As many parameters as data.
    Interpolation,
    /// chi^2 is larger than noise explains.
    Misfit {
        /// The weighted sum of squares.
        chi_squared: f64,
        /// Data minus parameters.
        degrees_of_freedom: usize,
        /// Probability of so large a chi^2.
        chance: f64,
    },
    /// Some groups of data have one realisation, whose scatter is missing in the intervals.
    SingleRealisation {
        /// Number of such groups.
        groups: usize,
    },
    /// Fewer than four realisations of some datum.
    FewRealisations {
        /// The smallest number.
        least: usize,
    },
    /// Resamples without a fit.
    FailedRefits {
        /// So many.
        failed: usize,
        /// Of so many.
        resamples: usize,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::SingleLevel { axis, eps } => {
                write!(f, "eps_{axis} has one level ({eps}): no term in it, kappa_TFC still contains its correction")
            }
            Self::TermLeftOut { axis, levels } => {
                write!(f, "eps_{axis} has {levels} levels but its term is left out of the model")
            }
            Self::ExponentHeld { axis, alpha } => {
                write!(f, "eps_{axis} has two levels, too few to fit alpha_{axis}: held at {alpha}")
            }
            Self::ExponentAtBound { axis, alpha } => write!(f, "alpha_{axis} stopped at its bound {alpha}"),
            Self::RefitsAtBound { axis, stuck, resamples } => {
                write!(
                    f,
                    "alpha_{axis} stopped at a bound in {stuck} of {resamples} resamples: intervals depend on bounds"
                )
            }
            Self::NotSignificant { axis, ci95: [low, high] } => {
                write!(f, "C_{axis} is not distinguishable from zero (95 %: {low:.3} to {high:.3})")
            }
            Self::Interpolation => {
                write!(f, "as many parameters as data: interpolation, no uncertainty from misfit")
            }
            Self::Misfit { chi_squared, degrees_of_freedom, chance } => write!(
                f,
                "chi^2 = {chi_squared:.1} for {degrees_of_freedom} degrees of freedom (chance {chance:.1e}): \
                 the model does not describe the data within their noise, and the intervals do not contain this"
            ),
            Self::SingleRealisation { groups } => {
                write!(f, "{groups} groups of data have one realisation: their scatter is not in the intervals")
            }
            Self::FewRealisations { least } => {
                write!(f, "only {least} realisations of some data: intervals are rough, four or more are better")
            }
            Self::FailedRefits { failed, resamples } => write!(f, "{failed} of {resamples} resamples gave no fit"),
        }
    }
}

/// The probability of a chi^2 at least this large, if the model and the noise are right.
fn chance_of_misfit(chi_squared: f64, degrees_of_freedom: usize) -> Option<f64> {
    ChiSquared::new(degrees_of_freedom as f64).ok().map(|distribution| distribution.sf(chi_squared))
}
