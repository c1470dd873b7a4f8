//! Prony series from measured dynamic moduli.

use std::f64::consts::TAU;

use num_complex::Complex64;

use crate::nnls::minimise;
use crate::{Prony, PronyError};

/// Misfit of the chosen series, divided by the smallest misfit of all: the least number of branches within it is taken.
pub const EXCESS: f64 = 1.1;

/// Misfit that is good enough: instruments and specimens are hardly more exact.
pub const GOOD_MISFIT: f64 = 0.01;

/// Most relaxation times per decade that an automatic fit tries.
const DENSEST: f64 = 3.0;

/// Most relaxation times of a fit.
pub const MOST_TIMES: usize = 60;

/// Storage modulus at the lowest frequency divided by the long-term modulus, or instantaneous modulus divided by the
/// storage modulus at the highest frequency, above which the fitted modulus is an extrapolation.
pub const PLATEAU: f64 = 1.1;

/// Long-term modulus divided by the lowest storage modulus that is no more than rounding.
const NEGLIGIBLE: f64 = 1e-6;

/// Complex modulus measured at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DynamicModulus {
    /// Frequency ω/(2π), 1/time.
    pub frequency: f64,
    /// Storage modulus E', stress.
    pub storage: f64,
    /// Loss modulus E'', stress.
    pub loss: f64,
}

impl DynamicModulus {
    /// Returns the angular frequency ω, rad/time.
    fn angular(&self) -> f64 {
        TAU * self.frequency
    }
}

/// Relaxation times of a fit.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum RelaxationTimes {
    /// The fewest branches with a misfit within [`EXCESS`] of the smallest one, or within [`GOOD_MISFIT`], among series
    /// with up to three times per decade, from the shortest of [`Count`](Self::Count) or a tenth of it, for data that
    /// end below the fastest relaxation.
    #[default]
    Automatic,
    /// This number of times in geometric steps from 1/ω of the highest to 1/ω of the lowest frequency; a single one is
    /// their geometric mean.
    Count(usize),
    /// These times.
    Given(Vec<f64>),
}

/// Branch of a fitted series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedBranch {
    /// Relaxation time τ.
    pub time: f64,
    /// Modulus E_i, stress.
    pub modulus: f64,
    /// Standard error of the modulus, stress; `None` without spare data.
    pub modulus_error: Option<f64>,
}

/// Generalised Maxwell body fitted to dynamic moduli:
/// E'(ω) = E_∞ + Σ E_i (ωτ_i)²/(1 + (ωτ_i)²), E''(ω) = Σ E_i ωτ_i/(1 + (ωτ_i)²)
/// (J. D. Ferry, Viscoelastic Properties of Polymers, 3rd edition, 1980, chapter 3).
#[derive(Clone, Debug, PartialEq)]
pub struct PronyFit {
    /// Branches with a positive modulus, by increasing time.
    pub branches: Vec<FittedBranch>,
    /// Long-term modulus E_∞, stress.
    pub long_term: f64,
    /// Standard error of the long-term modulus, stress; `None` if it was given, or without spare data.
    pub long_term_error: Option<f64>,
    /// Rms of (fit − measured)/measured of the storage modulus.
    pub storage_misfit: f64,
    /// Rms of (fit − measured)/measured of the loss modulus.
    pub loss_misfit: f64,
    /// Each series that was tried: number of branches with a positive modulus, and rms misfit of both moduli.
    pub tried: Vec<(usize, f64)>,
}

/// Error: dynamic moduli that give no series.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Number that is not positive.
    #[error("the {name} of point {point} is {found}; it must be positive and finite")]
    Point {
        /// Index of the point.
        point: usize,
        /// Name of the number.
        name: &'static str,
        /// Value found.
        found: f64,
    },
    /// Fewer points than relaxation times, or no point.
    #[error("there are {points} points for {times} relaxation times; there must be at least as many points, and one")]
    TooFew {
        /// Number of points.
        points: usize,
        /// Number of relaxation times.
        times: usize,
    },
    /// Number of relaxation times out of range.
    #[error("there are {0} relaxation times; there must be 1 to {MOST_TIMES}")]
    Count(usize),
    /// Relaxation time that is not positive, or repeated.
    #[error("a relaxation time is {0}; all must be positive, finite and different")]
    Time(f64),
    /// Given long-term modulus that is no lower limit of the storage modulus.
    #[error("the long-term modulus is {found}; it must be positive and below the lowest storage modulus, {lowest}")]
    LongTerm {
        /// Value found.
        found: f64,
        /// Lowest storage modulus.
        lowest: f64,
    },
    /// Best series without a long-term modulus.
    #[error(
        "the best fit has the long-term modulus 0; it must be positive, and data at lower frequencies or a given \
         long-term modulus make it so"
    )]
    NoLongTerm,
}

impl PronyFit {
    /// Fits a series to dynamic moduli by least squares of the relative misfits of both moduli, with moduli E_i ≥ 0 and
    /// E_∞ ≥ 0, or with the long-term modulus given. Branches with E_i = 0 are left out.
    ///
    /// Standard errors follow from the misfit and the number of spare data, for the branches that are kept and errors
    /// of the data that are independent of each other.
    ///
    /// # Errors
    /// Returns an error for numbers that are not positive, fewer points than times, and data whose best fit has no
    /// long-term modulus.
    pub fn new(points: &[DynamicModulus], times: &RelaxationTimes, long_term: Option<f64>) -> Result<Self, FitError> {
        check(points, long_term)?;
        let grids: Vec<Vec<f64>> = match times {
            RelaxationTimes::Automatic => {
                let within = window(points);
                let beyond = [0.1 * within[0], within[1]];
                [within, beyond].iter().flat_map(|window| grids(*window, points.len())).collect()
            }
            RelaxationTimes::Count(count) => {
                within(points, *count)?;
                vec![grid(window(points), *count)]
            }
            RelaxationTimes::Given(given) => {
                within(points, given.len())?;
                vec![sorted(given)?]
            }
        };
        let fits: Vec<Self> = grids.iter().map(|times| Self::at(points, times, long_term)).collect();
        let tried: Vec<(usize, f64)> = fits.iter().map(|fit| (fit.branches.len(), fit.misfit())).collect();
        let least = NEGLIGIBLE * points.iter().map(|point| point.storage).fold(f64::INFINITY, f64::min);
        let has_end = |fit: &&Self| fit.long_term > least && !fit.branches.is_empty();
        // A series without a long-term modulus is none that a body can have: the others are compared.
        let smallest = fits.iter().filter(has_end).map(Self::misfit).fold(f64::INFINITY, f64::min);
        let allowed = (EXCESS * smallest).max(GOOD_MISFIT);
        let close = fits.iter().filter(has_end).filter(|fit| fit.misfit() <= allowed || fits.len() == 1);
        let chosen = close
            .min_by(|a, b| a.branches.len().cmp(&b.branches.len()).then_with(|| a.misfit().total_cmp(&b.misfit())));
        let chosen = chosen.ok_or(FitError::NoLongTerm)?;
        // The best of all has no end: the data show none.
        let best = tried.iter().map(|(_, misfit)| *misfit).fold(f64::INFINITY, f64::min);
        if smallest > (EXCESS * best).max(GOOD_MISFIT) {
            return Err(FitError::NoLongTerm);
        }
        Ok(Self { tried, ..chosen.clone() })
    }

    /// Fits the series with these times.
    fn at(points: &[DynamicModulus], times: &[f64], long_term: Option<f64>) -> Self {
        // In units of the largest modulus, squares neither overflow nor vanish.
        let unit = points.iter().map(|point| point.storage.max(point.loss)).fold(0.0, f64::max);
        let fixed = long_term.unwrap_or(0.0);
        let column = |of: &dyn Fn(&DynamicModulus) -> Complex64| -> Vec<f64> {
            let storage = points.iter().map(|point| of(point).re * (unit / point.storage));
            storage.chain(points.iter().map(|point| of(point).im * (unit / point.loss))).collect()
        };
        let mut columns: Vec<Vec<f64>> =
            times.iter().map(|time| column(&|point| maxwell(point.angular() * time))).collect();
        if long_term.is_none() {
            columns.push(column(&|_| Complex64::new(1.0, 0.0)));
        }
        let wanted: Vec<f64> = (points.iter().map(|point| (point.storage - fixed) / point.storage))
            .chain(points.iter().map(|_| 1.0))
            .collect();
        let minimum = minimise(&columns, &wanted);
        let mut rest = wanted;
        for (x, column) in minimum.x.iter().zip(&columns) {
            rest.iter_mut().zip(column).for_each(|(rest, entry)| *rest -= x * entry);
        }
        let (storage, loss) = rest.split_at(points.len());
        let sum = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
        let spare = rest.len().saturating_sub(minimum.x.iter().filter(|x| **x > 0.0).count());
        let deviation = (spare > 0).then(|| (sum(&rest) / spare as f64).sqrt());
        let error = |index: usize| deviation.map(|deviation| unit * deviation * minimum.spread[index]);
        let branch = |(index, time): (usize, &f64)| FittedBranch {
            time: *time,
            modulus: unit * minimum.x[index],
            modulus_error: error(index),
        };
        let rms = |values: &[f64]| (sum(values) / values.len() as f64).sqrt();
        Self {
            branches: times.iter().enumerate().map(branch).filter(|branch| branch.modulus > 0.0).collect(),
            long_term: long_term.unwrap_or_else(|| unit * minimum.x[times.len()]),
            long_term_error: if long_term.is_some() { None } else { error(times.len()) },
            storage_misfit: rms(storage),
            loss_misfit: rms(loss),
            tried: Vec::new(),
        }
    }

    /// Returns the rms relative misfit of both moduli together.
    pub fn misfit(&self) -> f64 {
        self.storage_misfit.hypot(self.loss_misfit) * std::f64::consts::FRAC_1_SQRT_2
    }

    /// Returns the instantaneous modulus E_∞ + Σ E_i, stress.
    pub fn instantaneous(&self) -> f64 {
        self.long_term + self.branches.iter().map(|branch| branch.modulus).sum::<f64>()
    }

    /// Returns the pairs (τ_i, g_i) of relaxation time and fraction of the instantaneous modulus.
    pub fn fractions(&self) -> Vec<(f64, f64)> {
        let whole = self.instantaneous();
        self.branches.iter().map(|branch| (branch.time, branch.modulus / whole)).collect()
    }

    /// Returns the series, for bodies with the long-term Young's modulus [`long_term`](Self::long_term).
    ///
    /// # Errors
    /// Returns an error if rounding leaves no fraction of a branch or of the long-term modulus.
    pub fn series(&self) -> Result<Prony, PronyError> {
        Prony::from_fractions(&self.fractions())
    }

    /// Returns the complex modulus E' + iE'' of the series at a frequency ω/(2π), stress.
    pub fn modulus(&self, frequency: f64) -> Complex64 {
        let of = |branch: &FittedBranch| branch.modulus * maxwell(TAU * frequency * branch.time);
        self.long_term + self.branches.iter().map(of).sum::<Complex64>()
    }

    /// Returns true if the long-term modulus lies further below the storage modulus at the lowest frequency than
    /// [`PLATEAU`] allows: the data have no plateau there.
    pub fn extrapolates_slow_end(&self, points: &[DynamicModulus]) -> bool {
        let lowest = points.iter().min_by(|a, b| a.frequency.total_cmp(&b.frequency));
        lowest.is_some_and(|point| self.modulus(point.frequency).re > PLATEAU * self.long_term)
    }

    /// Returns true if the instantaneous modulus lies further above the storage modulus at the highest frequency than
    /// [`PLATEAU`] allows.
    pub fn extrapolates_fast_end(&self, points: &[DynamicModulus]) -> bool {
        let highest = points.iter().max_by(|a, b| a.frequency.total_cmp(&b.frequency));
        highest.is_some_and(|point| self.instantaneous() > PLATEAU * self.modulus(point.frequency).re)
    }
}

/// Returns iy/(1 + iy), the complex modulus of a spring of modulus 1 behind a dashpot, without overflow of y².
fn maxwell(y: f64) -> Complex64 {
    let loss = 1.0 / (y + 1.0 / y);
    Complex64::new(if y > 1.0 { 1.0 / (1.0 + y.powi(-2)) } else { y * loss }, loss)
}

fn check(points: &[DynamicModulus], long_term: Option<f64>) -> Result<(), FitError> {
    if points.is_empty() {
        return Err(FitError::TooFew { points: 0, times: 1 });
    }
    for (index, point) in points.iter().enumerate() {
        let numbers =
            [("frequency", point.frequency), ("storage modulus", point.storage), ("loss modulus", point.loss)];
        if let Some((name, found)) = numbers.into_iter().find(|(_, number)| !(*number > 0.0 && number.is_finite())) {
            return Err(FitError::Point { point: index, name, found });
        }
    }
    let lowest = points.iter().map(|point| point.storage).fold(f64::INFINITY, f64::min);
    match long_term {
        Some(found) if !(found > 0.0 && found < lowest) => Err(FitError::LongTerm { found, lowest }),
        _ => Ok(()),
    }
}

fn within(points: &[DynamicModulus], times: usize) -> Result<(), FitError> {
    match times {
        1..=MOST_TIMES if times <= points.len() => Ok(()),
        1..=MOST_TIMES => Err(FitError::TooFew { points: points.len(), times }),
        _ => Err(FitError::Count(times)),
    }
}

fn sorted(times: &[f64]) -> Result<Vec<f64>, FitError> {
    let mut times = times.to_vec();
    if let Some(time) = times.iter().find(|time| !(**time > 0.0 && time.is_finite())) {
        return Err(FitError::Time(*time));
    }
    times.sort_by(f64::total_cmp);
    match times.windows(2).find(|pair| pair[0] == pair[1]) {
        Some(pair) => Err(FitError::Time(pair[0])),
        None => Ok(times),
    }
}

/// Returns the shortest and the longest time 1/ω of the data.
fn window(points: &[DynamicModulus]) -> [f64; 2] {
    let times = points.iter().map(|point| 1.0 / point.angular());
    times.fold([f64::INFINITY, 0.0], |[low, high], time| [low.min(time), high.max(time)])
}

/// Returns the times of all series that an automatic fit tries between two times.
fn grids([low, high]: [f64; 2], points: usize) -> Vec<Vec<f64>> {
    // Saturates, also for frequencies whose ratio is infinite.
    let densest = (DENSEST * (high.log10() - low.log10())).round() as usize + 1;
    (1..=densest.min(points).min(MOST_TIMES)).map(|count| grid([low, high], count)).collect()
}

/// Returns times in geometric steps between two times.
fn grid(window: [f64; 2], count: usize) -> Vec<f64> {
    let [low, high] = window.map(f64::ln);
    if count == 1 || low == high {
        return vec![(0.5 * (low + high)).exp()];
    }
    (0..count).map(|i| (low + (high - low) * i as f64 / (count - 1) as f64).exp()).collect()
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    /// Moduli at `count` angular frequencies from 10^low to 10^high.
    fn measured(low: f64, high: f64, count: usize, of: impl Fn(f64) -> Complex64) -> Vec<DynamicModulus> {
        let point = |i: usize| {
            let omega = 10_f64.powf(low + (high - low) * i as f64 / (count - 1) as f64);
            let modulus = of(omega);
            DynamicModulus { frequency: omega / TAU, storage: modulus.re, loss: modulus.im }
        };
        (0..count).map(point).collect()
    }

    const THREE: [(f64, f64); 3] = [(0.01, 500.0), (1.0, 60.0), (100.0, 8.0)];

    fn three(omega: f64) -> Complex64 {
        3.0 + THREE.iter().map(|(time, modulus)| modulus * maxwell(omega * time)).sum::<Complex64>()
    }

    /// Zener's standard solid with a fractional dashpot: E_∞ + (E_0 − E_∞)(iωτ)^α/(1 + (iωτ)^α).
    fn fractional(omega: f64) -> Complex64 {
        let power = Complex64::new(0.0, omega).powf(0.5);
        2.0 + 1998.0 * power / (1.0 + power)
    }

    #[test]
    fn a_known_series_is_recovered() {
        let points = measured(-2.0, 2.0, 41, three);
        for times in [
            RelaxationTimes::Automatic,
            RelaxationTimes::Count(3),
            RelaxationTimes::Given(THREE.iter().rev().map(|(time, _)| *time).collect()),
        ] {
            let fit = PronyFit::new(&points, &times, None).unwrap();
            assert_eq!(fit.branches.len(), 3, "{fit:?}");
            for (branch, (time, modulus)) in fit.branches.iter().zip(THREE) {
                assert_relative_eq!(branch.time, time, max_relative = 1e-12);
                assert_relative_eq!(branch.modulus, modulus, max_relative = 1e-9);
            }
            assert_relative_eq!(fit.long_term, 3.0, max_relative = 1e-9);
            assert!(fit.misfit() < 1e-12, "{}", fit.misfit());
            let series = fit.series().unwrap();
            assert_relative_eq!(fit.instantaneous(), 571.0, max_relative = 1e-9);
            assert_relative_eq!(series.instantaneous() * fit.long_term, 571.0, max_relative = 1e-9);
            let modulus = fit.long_term * series.modulus(TAU * 0.3);
            assert_relative_eq!((modulus - fit.modulus(0.3)).norm() / modulus.norm(), 0.0, epsilon = 1e-12);
        }
        // Superfluous times get no branch, up to rounding.
        let fit = PronyFit::new(&points, &RelaxationTimes::Count(5), None).unwrap();
        let extra = fit.branches.iter().filter(|branch| branch.modulus > 1e-6);
        assert_eq!(extra.count(), 3, "{fit:?}");
    }

    #[test]
    fn noise_moves_the_moduli_by_their_standard_errors() {
        // A fixed sequence with Gaussian numbers by sums of twelve.
        let mut state = 7_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut noise = || (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
        let (mut squares, mut largest, mut branches) = (0.0, 0.0_f64, 0);
        let runs = 40;
        for _ in 0..runs {
            let mut points = measured(-2.0, 2.0, 41, three);
            for point in &mut points {
                point.storage *= 1.0 + 0.02 * noise();
                point.loss *= 1.0 + 0.02 * noise();
            }
            let fit = PronyFit::new(&points, &RelaxationTimes::Count(3), None).unwrap();
            assert!((fit.misfit() - 0.02).abs() < 0.006, "{}", fit.misfit());
            let known = THREE.iter().map(|(_, modulus)| *modulus).chain([3.0]);
            let found = fit.branches.iter().map(|branch| (branch.modulus, branch.modulus_error));
            for ((found, error), known) in found.chain([(fit.long_term, fit.long_term_error)]).zip(known) {
                let deviation = (found - known) / error.unwrap();
                squares += deviation * deviation;
                largest = largest.max(deviation.abs());
            }
            branches += PronyFit::new(&points, &RelaxationTimes::Automatic, None).unwrap().branches.len();
        }
        // 160 deviations of variance 1: their mean square is 1 within 4 of its standard deviations, √(2/160) each.
        let mean = squares / f64::from(4 * runs);
        assert!((mean - 1.0).abs() < 0.45 && largest < 4.5, "{mean} {largest}");
        assert!(branches <= 4 * runs as usize, "{branches}");
    }

    #[test]
    fn a_broad_spectrum_is_fitted_to_the_stated_misfit() {
        let points = measured(-6.0, 6.0, 121, fractional);
        let fit = PronyFit::new(&points, &RelaxationTimes::Automatic, None).unwrap();
        let smallest = fit.tried.iter().map(|(_, misfit)| *misfit).fold(f64::INFINITY, f64::min);
        assert!(fit.misfit() <= (EXCESS * smallest).max(GOOD_MISFIT), "{} {smallest}", fit.misfit());
        let decade = PronyFit::new(&points, &RelaxationTimes::Count(13), None).unwrap();
        assert!(decade.misfit() < 0.08, "{}", decade.misfit());
        assert!(!fit.extrapolates_slow_end(&measured(-9.0, 6.0, 121, fractional)));
    }

    #[test]
    fn ends_without_a_plateau_are_told_from_plateaus() {
        let whole = measured(-4.0, 5.0, 91, three);
        let fit = PronyFit::new(&whole, &RelaxationTimes::Automatic, None).unwrap();
        assert_eq!([fit.extrapolates_slow_end(&whole), fit.extrapolates_fast_end(&whole)], [false; 2]);
        let part = measured(-2.0, 1.0, 31, three);
        let fit = PronyFit::new(&part, &RelaxationTimes::Automatic, None).unwrap();
        assert_eq!([fit.extrapolates_slow_end(&part), fit.extrapolates_fast_end(&part)], [true; 2]);
        // A given long-term modulus is kept.
        let given = PronyFit::new(&part, &RelaxationTimes::Automatic, Some(3.0)).unwrap();
        assert_eq!((given.long_term, given.long_term_error), (3.0, None));
        assert!(given.misfit() < 0.02, "{}", given.misfit());
        let fluid = measured(-2.0, 1.0, 31, |omega| 100.0 * maxwell(omega));
        assert_eq!(PronyFit::new(&fluid, &RelaxationTimes::Automatic, None), Err(FitError::NoLongTerm));
        assert_eq!(PronyFit::new(&fluid, &RelaxationTimes::Count(4), None), Err(FitError::NoLongTerm));
    }

    #[test]
    fn the_unit_of_stress_and_the_order_do_not_matter() {
        let points = measured(-2.0, 2.0, 41, fractional);
        let fit = PronyFit::new(&points, &RelaxationTimes::Automatic, None).unwrap();
        for unit in [1e-130, 1e6, 1e130] {
            let scaled = points.iter().rev().map(|point| DynamicModulus {
                storage: unit * point.storage,
                loss: unit * point.loss,
                ..*point
            });
            let other = PronyFit::new(&scaled.collect::<Vec<_>>(), &RelaxationTimes::Automatic, None).unwrap();
            assert_eq!(other.branches.len(), fit.branches.len());
            assert_relative_eq!(other.long_term, unit * fit.long_term, max_relative = 1e-7);
        }
    }

    #[test]
    fn data_without_a_series_are_refused() {
        let points = measured(-2.0, 2.0, 5, three);
        let refused = |points: &[DynamicModulus], times: RelaxationTimes, long_term| {
            PronyFit::new(points, &times, long_term).unwrap_err().to_string()
        };
        let automatic = RelaxationTimes::Automatic;
        assert!(refused(&[], automatic.clone(), None).starts_with("there are 0 points"));
        assert!(refused(&points, RelaxationTimes::Count(6), None).starts_with("there are 5 points for 6 relaxation"));
        assert!(refused(&points, RelaxationTimes::Count(0), None).starts_with("there are 0 relaxation times"));
        assert!(refused(&points, RelaxationTimes::Count(61), None).starts_with("there are 61 relaxation times"));
        for times in [vec![1.0, 0.0], vec![f64::NAN], vec![1.0, 1.0]] {
            assert!(refused(&points, RelaxationTimes::Given(times), None).starts_with("a relaxation time is"));
        }
        assert!(refused(&points, automatic.clone(), Some(1e3)).starts_with("the long-term modulus is 1000; it must"));
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let mut wrong = points.clone();
            wrong[2].loss = bad;
            assert!(refused(&wrong, automatic.clone(), None).starts_with("the loss modulus of point 2 is"));
        }
        // One point, one frequency, frequencies at the ends of the range of numbers.
        let one = DynamicModulus { frequency: 1.0, storage: 2.0, loss: 0.5 };
        assert!(PronyFit::new(&[one], &automatic, None).unwrap().branches[0].modulus_error.is_none());
        assert_eq!(PronyFit::new(&[one, one], &automatic, None).unwrap().branches.len(), 1);
        let far = [1e-300, 1.0, 1e300].map(|frequency| DynamicModulus { frequency, ..one });
        assert!(PronyFit::new(&far, &automatic, None).is_ok_and(|fit| fit.long_term > 0.0));
    }
}
