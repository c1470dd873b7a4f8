//! Result of a fit, with its diagnostics and warnings.

use std::fmt;

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::{Axis, Datum, Parameters, Richardson};

/// Fitted value with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Value from the fit to the means.
    pub value: f64,
    /// Standard error by linear propagation of the scatter (or misfit), times √(χ²/degrees of freedom) where it is
    /// above one; `None` if the value is fixed or at its bound, or if its error is unknown.
    pub standard_error: Option<f64>,
    /// 95 % interval; see [`Uncertainty`] for its source.
    pub ci95: Option<[f64; 2]>,
}

/// Source of the intervals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Uncertainty {
    /// Means of the realisations resampled from their errors, with all parameters refitted.
    Realisations,
    /// Linear propagation of the scatter of realisations (no resamples were requested, or all refits failed).
    Propagated,
    /// Misfit of the model in place of the noise, since there is one realisation per datum.
    Misfit,
    /// No source: there is one realisation per datum, and there are as many parameters as data.
    None,
}

impl fmt::Display for Uncertainty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Realisations => "scatter of realisations, resampled and refitted",
            Self::Propagated => "scatter of realisations, linearly propagated",
            Self::Misfit => "misfit of the model (one realisation per datum)",
            Self::None => "none: one realisation per datum and no degrees of freedom",
        })
    }
}

/// Term C eps^alpha of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// Axis of the term.
    pub axis: Axis,
    /// Number of levels of the axis in the data.
    pub levels: usize,
    /// Coefficient C, in units of kappa.
    pub coefficient: Estimate,
    /// Exponent alpha.
    pub exponent: Estimate,
    /// True if the exponent was fitted.
    pub free: bool,
    /// True if the exponent should be fitted but two levels do not determine it; it is then fixed at one.
    pub held: bool,
    /// True if the fitted exponent stopped at a bound.
    pub at_bound: bool,
    /// chi^2 and kappa_TFC against this exponent, with all other parameters refitted; exponents increase.
    pub profile: Vec<ProfilePoint>,
}

/// Term of the measured edge, a factor times the edge of every realisation ([`crate::Edge`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeTerm {
    /// Factor f, from the data and from its expected value.
    pub factor: Estimate,
    /// Factor f', from the data and from its expected value; `None` if it is fixed at zero.
    pub coarse: Option<Estimate>,
    /// Standard error of kappa_TFC due to the factors, in units of kappa; `None` without errors.
    pub share: Option<f64>,
}

/// Point of a profile likelihood.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfilePoint {
    /// Fixed exponent.
    pub exponent: f64,
    /// Least chi^2 with this exponent.
    pub chi_squared: f64,
    /// kappa_TFC at the least chi^2.
    pub kappa_tfc: f64,
}

/// Result of the fit for one datum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DatumReport {
    /// Mean over realisations.
    pub mean: f64,
    /// Standard error of the mean from the datum's own scatter; `None` for a single realisation.
    pub standard_error: Option<f64>,
    /// Weight in the sum of squares, for the datum or for its comparison with its parent.
    pub weight: f64,
    /// Value of the fitted model, for the mean edge of the datum.
    pub fitted: f64,
    /// kappa_TFC of a fit without this datum; `None` if the other data do not determine the model.
    pub kappa_tfc_without: Option<f64>,
}

/// Number of realisations of each datum below which a warning is given. Chosen: with 4, kappa scattered by 1.7 times
/// its standard error in 14 sweeps by `star`, and 10 of 14 intervals contained its mean. Intervals of data with normal
/// noise are sound from 3 on.
const FEW: usize = 6;

/// Result of resampling.
#[derive(Clone, Debug, PartialEq)]
pub struct BootstrapReport {
    /// Number of requested resamples.
    pub resamples: usize,
    /// Number of resamples without a fit because the terms could not be separated.
    pub failed: usize,
    /// For each free exponent, the number of resamples in which it stopped at a bound.
    pub at_bound: Vec<(Axis, usize)>,
    /// Seed of the draws.
    pub seed: u64,
    /// Student's factor on the deviations of the percentiles of kappa_TFC. It is above one for few realisations and
    /// tends to one for many.
    pub stretch: f64,
    /// Refitted parameters of the successful resamples, in the order of the draws.
    pub samples: Vec<Parameters>,
}

/// Result of [`crate::fit()`].
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// kappa in the thermodynamic, fractal and continuum limit.
    pub kappa_tfc: Estimate,
    /// Fitted terms, in the order t, f, c.
    pub terms: Vec<Term>,
    /// Term of the measured edge, if the model has it and eps_c has several levels.
    pub edge: Option<EdgeTerm>,
    /// All fitted values as arrays over the axes.
    pub parameters: Parameters,
    /// Weighted sum of squares; if `noise_known` is false, unweighted sum of squares in units of kappa^2.
    pub chi_squared: f64,
    /// True if the weights are inverse variances. False for equal weights, and without scatter to estimate variances.
    pub noise_known: bool,
    /// Number of data minus number of parameters.
    pub degrees_of_freedom: usize,
    /// One report for each datum, in the order of the data.
    pub data: Vec<DatumReport>,
    /// Three-level extrapolations along single axes, a check on the joint fit.
    pub richardson: Vec<Richardson>,
    /// Source of the intervals.
    pub uncertainty: Uncertainty,
    /// Bootstrap result, if a bootstrap was made.
    pub bootstrap: Option<BootstrapReport>,
    /// Limitations of the result.
    pub warnings: Vec<Warning>,
}

impl Fit {
    /// Returns the fitted term of an axis, if any.
    pub fn term(&self, axis: Axis) -> Option<&Term> {
        self.terms.iter().find(|term| term.axis == axis)
    }

    /// Returns kappa of the fitted model at (eps_t, eps_f, eps_c).
    pub fn predict(&self, eps: [f64; 3]) -> f64 {
        self.parameters.predict(eps)
    }

    /// Returns the mean of a datum minus the terms of all axes but `axis`, for a plot against the function of eps on
    /// this axis ([`Parameters::power`]), or against the mean edge.
    pub fn isolate(&self, datum: &Datum, axis: Axis) -> f64 {
        let others = Axis::ALL.iter().filter(|&&other| other != axis);
        let terms: f64 = others.map(|&other| self.parameters.term(other as usize, datum.all_eps())).sum();
        let excess = if axis == Axis::Continuum { 0.0 } else { self.parameters.excess(datum.eps_c, datum.mean_edge()) };
        datum.mean() - terms - excess
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
            warnings.push(Warning::SingleRealisation { data: single });
        } else if least < FEW {
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

/// Limitation of the result.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Warning {
    /// The axis has one level and thus no term; kappa_TFC contains the correction of this axis.
    SingleLevel {
        /// Axis with a single level.
        axis: Axis,
        /// Value of eps.
        eps: f64,
    },
    /// The model omits the term although the axis has several levels.
    TermLeftOut {
        /// Axis without a term.
        axis: Axis,
        /// Number of levels of the axis.
        levels: usize,
    },
    /// Two levels do not determine an exponent.
    ExponentHeld {
        /// Axis of the term.
        axis: Axis,
        /// Value of the fixed exponent.
        alpha: f64,
    },
    /// A free exponent stopped at its bound.
    ExponentAtBound {
        /// Axis of the term.
        axis: Axis,
        /// Value of the bound.
        alpha: f64,
    },
    /// A free exponent stopped at its bound in more than 5 % of the resamples: the intervals depend on the bounds.
    RefitsAtBound {
        /// Axis of the term.
        axis: Axis,
        /// Number of resamples at a bound.
        stuck: usize,
        /// Number of resamples.
        resamples: usize,
    },
    /// The interval of a coefficient contains zero.
    NotSignificant {
        /// Axis of the term.
        axis: Axis,
        /// Interval of the coefficient.
        ci95: [f64; 2],
    },
    /// There are as many parameters as data.
    Interpolation,
    /// chi^2 is larger than the noise explains.
    Misfit {
        /// Weighted sum of squares.
        chi_squared: f64,
        /// Number of data minus number of parameters.
        degrees_of_freedom: usize,
        /// Probability of a chi^2 at least this large.
        chance: f64,
    },
    /// Some data have one realisation; their scatter is taken from the other data.
    SingleRealisation {
        /// Number of such data.
        data: usize,
    },
    /// Some datum has fewer than four realisations.
    FewRealisations {
        /// Smallest number of realisations.
        least: usize,
    },
    /// The fractal limit is extrapolated by a power of eps_f, which no theory determines beyond the first terms. For H
    /// near 1 convergence is slow, and the interval may be too narrow. [`fit`](crate::fit()) does not give this
    /// warning; callers with knowledge of the physics add it.
    PowerOfEpsF,
    /// Some resamples gave no fit.
    FailedRefits {
        /// Number of resamples without a fit.
        failed: usize,
        /// Number of resamples.
        resamples: usize,
    },
}

impl Warning {
    /// Returns the short name of the warning, for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Self::SingleLevel { .. } => "single-level",
            Self::TermLeftOut { .. } => "term-left-out",
            Self::ExponentHeld { .. } => "exponent-held",
            Self::ExponentAtBound { .. } => "exponent-at-bound",
            Self::RefitsAtBound { .. } => "refits-at-bound",
            Self::NotSignificant { .. } => "not-significant",
            Self::Interpolation => "interpolation",
            Self::Misfit { .. } => "misfit",
            Self::SingleRealisation { .. } => "single-realisation",
            Self::FewRealisations { .. } => "few-realisations",
            Self::PowerOfEpsF => "power-of-eps-f",
            Self::FailedRefits { .. } => "failed-refits",
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::SingleLevel { axis, eps } => {
                write!(f, "eps_{axis} has one level ({eps}) and no term: kappa_TFC still contains its correction")
            }
            Self::TermLeftOut { axis, levels } => {
                write!(f, "eps_{axis} has {levels} levels but its term is left out of the model")
            }
            Self::ExponentHeld { axis, alpha } => {
                write!(f, "eps_{axis} has two levels, too few to fit alpha_{axis}: it is held at {alpha}")
            }
            Self::ExponentAtBound { axis, alpha } => write!(f, "alpha_{axis} stopped at its bound {alpha}"),
            Self::RefitsAtBound { axis, stuck, resamples } => {
                write!(
                    f,
                    "alpha_{axis} stopped at a bound in {stuck} of {resamples} resamples: the intervals depend on the \
                     bounds"
                )
            }
            Self::NotSignificant { axis, ci95: [low, high] } => {
                write!(f, "C_{axis} is not distinguishable from zero (95 %: {low:.3} to {high:.3})")
            }
            Self::Interpolation => {
                write!(f, "there are as many parameters as data: their misfit gives no uncertainty")
            }
            Self::Misfit { chi_squared, degrees_of_freedom, chance } => write!(
                f,
                "chi^2 = {chi_squared:.1} for {degrees_of_freedom} degrees of freedom (chance {chance:.1e}): \
                 the model does not describe the data within their noise; the intervals are widened accordingly"
            ),
            Self::SingleRealisation { data } => {
                write!(f, "{data} data have one realisation: their scatter is taken from the other data")
            }
            Self::FewRealisations { least } => {
                write!(
                    f,
                    "some data have only {least} realisations: the intervals are rough, and may be too narrow; {FEW} \
                     or more are better"
                )
            }
            Self::PowerOfEpsF => write!(
                f,
                "the limit of eps_f is extrapolated by a power: loads up to p* = 1 would allow to compose the long \
                 waves (fit.long_waves)"
            ),
            Self::FailedRefits { failed, resamples } => write!(f, "{failed} of {resamples} resamples gave no fit"),
        }
    }
}

/// Returns the probability of a chi^2 at least this large if the model and the noise are correct.
fn chance_of_misfit(chi_squared: f64, degrees_of_freedom: usize) -> Option<f64> {
    ChiSquared::new(degrees_of_freedom as f64).ok().map(|distribution| distribution.sf(chi_squared))
}
