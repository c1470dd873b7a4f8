//! Surfaces whose heights have a given distribution, below a given spectrum.

use std::f64::consts::SQRT_2;
use std::fmt;
use std::str::FromStr;

use gfmd_field::{Grid, Transform};
use ndarray::Array2;
use num_complex::Complex64;
use rayon::prelude::*;
use statrs::function::erf::erf_inv;

use crate::{SelfAffine, SurfaceError};

/// Passes of the exchange of ranks and amplitudes; more of them change skewness and kurtosis by less than their
/// deviation from the distribution.
const PASSES: usize = 50;

/// Largest rms distance between the heights and the values of the distribution in the same order, relative to the rms
/// height; beyond it the waves do not allow the distribution.
const LARGEST_DEVIATION: f64 = 0.1;

/// Points per shortest wavelength of the grid on which heights are exchanged.
const POINTS_PER_WAVE: f64 = 4.0;

/// Distribution of the heights of a surface. Its mean and its width do not matter, since heights have mean zero and are
/// scaled to the size of the spectrum.
///
/// ```
/// use gfmd_field::Grid;
/// use gfmd_surface::{Marginal, SelfAffine};
///
/// let rough = SelfAffine {
///     hurst: 0.8,
///     longest_wavelength: 0.25,
///     shortest_wavelength: 1.0 / 16.0,
///     ..SelfAffine::with_rms_gradient(0.1)
/// };
/// // Plateaus with deep valleys: a negative parameter mirrors the heights.
/// let worn: Marginal = "weibull:-1.5".parse()?;
/// let heights = worn.heights(&rough, &Grid::square(64, 1.0)?, 1)?;
/// let [square, cube] = [2, 3].map(|power| heights.mapv(|height| height.powi(power)).mean().unwrap_or(0.0));
/// assert!(cube / square.powf(1.5) < -0.8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Marginal(Distribution);

#[derive(Clone, Debug, PartialEq)]
enum Distribution {
    /// exp(σ g) of a normal variable g; mirrored if σ is negative.
    Lognormal(f64),
    /// Weibull distribution of this shape; mirrored if the shape is negative.
    Weibull(f64),
    /// Heights, and the fractions of the surface below them.
    Table(Vec<[f64; 2]>),
}

/// Reasons why a text or a table is no distribution of heights.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MarginalError {
    /// A text without a known form.
    #[error("it is {found:?}; it must be lognormal:SIGMA, weibull:SHAPE or HEIGHT:PROBABILITY,...")]
    Unknown {
        /// Given text.
        found: String,
    },
    /// A parameter without a distribution.
    #[error(
        "the {name} is {found}; it must be between {least} and {largest}, or the negative of it for a mirror image"
    )]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Given value.
        found: f64,
        /// Smallest allowed value.
        least: f64,
        /// Largest allowed value.
        largest: f64,
    },
    /// A table that does not begin at probability 0 or does not end at 1.
    #[error("the table has probabilities from {first} to {last}; they must begin with 0 and end with 1")]
    Ends {
        /// First probability.
        first: f64,
        /// Last probability.
        last: f64,
    },
    /// A row that does not lie above the row before it.
    #[error(
        "row {row} of the table is height {height} with probability {probability}; both must be finite and not below \
         the row before, and some height must be above it"
    )]
    Row {
        /// Number of the row, from 1.
        row: usize,
        /// Height of the row.
        height: f64,
        /// Probability of the row.
        probability: f64,
    },
}

impl Marginal {
    /// Returns the distribution of exp(σ g), with a normal variable g of variance 1; its mirror image for a negative
    /// `sigma`.
    ///
    /// # Errors
    /// Returns an error unless |σ| is between 0.01 and 2.
    pub fn lognormal(sigma: f64) -> Result<Self, MarginalError> {
        between("standard deviation", sigma, [0.01, 2.0]).map(|sigma| Self(Distribution::Lognormal(sigma)))
    }

    /// Returns the Weibull distribution P(h) = 1 − exp(−hᵏ) of the shape k; its mirror image for a negative `shape`.
    ///
    /// # Errors
    /// Returns an error unless |k| is between 0.5 and 100.
    pub fn weibull(shape: f64) -> Result<Self, MarginalError> {
        between("shape", shape, [0.5, 100.0]).map(|shape| Self(Distribution::Weibull(shape)))
    }

    /// Returns the distribution through `rows` of a height and the fraction of the surface below it, linear between
    /// them: a material ratio curve, counted from the lowest height.
    ///
    /// # Errors
    /// Returns an error unless heights and fractions are finite and ascending, the fractions from 0 to 1.
    pub fn table(rows: Vec<[f64; 2]>) -> Result<Self, MarginalError> {
        let at = |row: usize| MarginalError::Row { row: row + 1, height: rows[row][0], probability: rows[row][1] };
        let [Some(first), Some(last)] = [rows.first(), rows.last()] else {
            return Err(MarginalError::Unknown { found: String::new() });
        };
        if first[1] != 0.0 || last[1] != 1.0 {
            return Err(MarginalError::Ends { first: first[1], last: last[1] });
        }
        let falls = |pair: &[[f64; 2]]| !(pair[0][0] <= pair[1][0] && pair[0][1] <= pair[1][1]);
        match rows.windows(2).position(falls) {
            Some(row) => Err(at(row + 1)),
            None if !(last[0] - first[0] > 0.0 && (last[0] - first[0]).is_finite()) => Err(at(rows.len() - 1)),
            None => Ok(Self(Distribution::Table(rows))),
        }
    }

    /// Returns true if `text` has the name of a distribution.
    pub fn is_named(text: &str) -> bool {
        text.split_once(':').is_some_and(|(name, _)| ["lognormal", "weibull"].contains(&name.trim()))
    }

    /// Returns the name of the distribution with its parameter; `of a table` without one.
    pub fn name(&self) -> String {
        if let Distribution::Table(_) = self.0 { "of a table".into() } else { self.to_string() }
    }

    /// Returns the height below which a fraction `p` of the surface lies, above 0 and below 1.
    fn quantile(&self, p: f64) -> f64 {
        match &self.0 {
            Distribution::Lognormal(sigma) => (sigma * SQRT_2 * erf_inv(2.0 * p - 1.0)).exp() * sigma.signum(),
            Distribution::Weibull(shape) if *shape < 0.0 => -(-p.ln()).powf(-1.0 / shape),
            Distribution::Weibull(shape) => (-(-p).ln_1p()).powf(1.0 / shape),
            Distribution::Table(rows) => {
                let next = rows.partition_point(|row| row[1] < p).clamp(1, rows.len() - 1);
                let ([low, below], [high, above]) = (rows[next - 1], rows[next]);
                if above > below { low + (high - low) * (p - below) / (above - below) } else { high }
            }
        }
    }

    /// Generates heights (length) with this distribution and the mode amplitudes of realisation `seed` of `spectrum`,
    /// shape `[nx, ny]`, mean zero.
    ///
    /// The phases are found by the exchange of ranks and amplitudes (Schreiber and Schmitz, Phys. Rev. Lett. 77 (1996)
    /// 635): heights are replaced by the values of the distribution in the same order, then the amplitudes of their
    /// waves by the given ones, fifty times. The last step is the amplitudes: spectrum, cut-offs and size are exact,
    /// and the distribution is met as well as these waves allow. The exchange runs on a grid with four points per
    /// shortest wavelength, which depends on the cell alone, so that seed and cell determine the surface on any grid.
    ///
    /// # Errors
    /// Returns an error as [`SelfAffine::heights`], for a grid with two points per shortest wavelength only, and for a
    /// distribution that no surface with these waves has: heights that lie more than a tenth of their rms value away
    /// from it, in the order of the heights.
    pub fn heights(&self, spectrum: &SelfAffine, grid: &Grid, seed: u64) -> Result<Array2<f64>, SurfaceError> {
        // Refuses what the grid of the surface cannot hold.
        spectrum.on(grid)?;
        let stretch = spectrum.anisotropy.map_or(1.0, |anisotropy| anisotropy.stretch());
        let shortest = spectrum.shortest_wavelength / stretch;
        let spacing = if grid.is_line() { grid.spacing()[0] } else { grid.spacing()[0].max(grid.spacing()[1]) };
        if shortest < 2.0 * spacing * (1.0 + 1e-9) {
            return Err(SurfaceError::NoRoomForPhases { shortest });
        }
        let points = |length: f64| 2 * (0.5 * POINTS_PER_WAVE * length / shortest * (1.0 - 1e-12)).ceil() as usize;
        let lengths = grid.lengths();
        let exchanged = match grid.is_line() {
            true => Grid::line(points(lengths[0]), lengths[0])?,
            false => Grid::new(lengths.map(points), lengths)?,
        };
        let coefficients = self.exchange(&exchanged, &spectrum.spectrum(&exchanged, seed)?)?;
        let waves: Vec<([i64; 2], Complex64)> = {
            let waves = exchanged.modes().zip(&coefficients).filter(|(_, value)| **value != Complex64::ZERO);
            let mut waves: Vec<_> = waves.map(|(mode, value)| (mode.number, *value)).collect();
            waves.sort_unstable_by_key(|(number, _)| *number);
            waves
        };
        let of_number = |number: [i64; 2]| {
            let found = waves.binary_search_by_key(&number, |(number, _)| *number);
            found.map_or(Complex64::ZERO, |index| waves[index].1)
        };
        let spectrum: Vec<Complex64> =
            (0..grid.spectrum_len()).into_par_iter().map(|index| of_number(grid.mode_at(index).number)).collect();
        let transform = Transform::new(*grid);
        let mut heights = vec![0.0; grid.len()];
        transform.inverse(&spectrum, &mut heights, &mut transform.workspace())?;
        let (found, expected) = ([heights.len(), 1], grid.points());
        Array2::from_shape_vec(expected, heights).map_err(|_| SurfaceError::Shape { found, expected })
    }

    /// Returns coefficients as large as the given ones, with phases that give the heights the distribution.
    fn exchange(&self, grid: &Grid, given: &[Complex64]) -> Result<Vec<Complex64>, SurfaceError> {
        let (transform, count) = (Transform::new(*grid), grid.len());
        let rms = |field: &[f64]| (field.iter().map(|value| value * value).sum::<f64>() / count as f64).sqrt();
        let mut workspace = transform.workspace();
        let mut values: Vec<f64> =
            (0..count).into_par_iter().map(|rank| self.quantile((rank as f64 + 0.5) / count as f64)).collect();
        let mean = values.iter().sum::<f64>() / count as f64;
        values.iter_mut().for_each(|value| *value -= mean);
        let amplitudes: Vec<f64> = given.iter().map(|value| value.norm()).collect();
        let (mut coefficients, mut heights) = (given.to_vec(), vec![0.0; count]);
        let mut order: Vec<u32> = (0..count as u32).collect();
        for _ in 0..PASSES {
            transform.inverse(&coefficients, &mut heights, &mut workspace)?;
            // Equal heights keep the order of their points, so that the result does not depend on the threads.
            order.par_sort_unstable_by(|a, b| {
                heights[*a as usize].total_cmp(&heights[*b as usize]).then_with(|| a.cmp(b))
            });
            order.iter().zip(&values).for_each(|(point, value)| heights[*point as usize] = *value);
            let before = coefficients.clone();
            transform.forward(&heights, &mut coefficients, &mut workspace)?;
            coefficients.par_iter_mut().zip(&amplitudes).zip(&before).for_each(|((value, amplitude), before)| {
                let norm = value.norm();
                *value = if norm > 0.0 { *value * (amplitude / norm) } else { *before };
            });
        }
        transform.inverse(&coefficients, &mut heights, &mut workspace)?;
        heights.par_sort_unstable_by(f64::total_cmp);
        let factor = rms(&heights) / rms(&values);
        let apart: Vec<f64> = heights.iter().zip(&values).map(|(height, value)| height - factor * value).collect();
        let found = rms(&apart) / rms(&heights);
        // NaN is refused, too.
        if found <= LARGEST_DEVIATION { Ok(coefficients) } else { Err(SurfaceError::Marginal { found }) }
    }
}

/// Checks a parameter that may be negative.
fn between(name: &'static str, found: f64, [least, largest]: [f64; 2]) -> Result<f64, MarginalError> {
    let is_allowed = (least..=largest).contains(&found.abs());
    if is_allowed { Ok(found) } else { Err(MarginalError::Parameter { name, found, least, largest }) }
}

impl FromStr for Marginal {
    type Err = MarginalError;

    fn from_str(text: &str) -> Result<Self, MarginalError> {
        let unknown = || MarginalError::Unknown { found: text.to_owned() };
        let number = |text: &str| text.trim().parse::<f64>().map_err(|_| unknown());
        match text.split_once(':').map(|(name, value)| (name.trim(), value)) {
            Some(("lognormal", sigma)) => Self::lognormal(number(sigma)?),
            Some(("weibull", shape)) => Self::weibull(number(shape)?),
            _ => {
                let row = |row: &str| {
                    let (height, probability) = row.split_once(':').ok_or_else(unknown)?;
                    Ok([number(height)?, number(probability)?])
                };
                Self::table(text.split(',').map(row).collect::<Result<_, MarginalError>>()?)
            }
        }
    }
}

impl fmt::Display for Marginal {
    /// Writes the text that [`from_str`](Self::from_str) reads.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Distribution::Lognormal(sigma) => write!(f, "lognormal:{sigma}"),
            Distribution::Weibull(shape) => write!(f, "weibull:{shape}"),
            Distribution::Table(rows) => rows.iter().enumerate().try_for_each(|(index, [height, probability])| {
                write!(f, "{}{height}:{probability}", if index > 0 { "," } else { "" })
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;
    use statrs::function::gamma::gamma;

    use super::*;
    use crate::PowerSpectrum;

    fn rough(shortest: f64) -> SelfAffine {
        SelfAffine {
            hurst: 0.8,
            longest_wavelength: 0.25,
            shortest_wavelength: shortest,
            ..SelfAffine::with_rms_gradient(0.1)
        }
    }

    fn marginal(text: &str) -> Marginal {
        text.parse().unwrap()
    }

    /// Returns skewness and kurtosis.
    fn shape(heights: &Array2<f64>) -> [f64; 2] {
        let [square, cube, fourth] = [2, 3, 4].map(|power| heights.mapv(|height| height.powi(power)).mean().unwrap());
        [cube / square.powf(1.5), fourth / square.powi(2)]
    }

    /// Returns skewness and kurtosis from the first four moments.
    fn of_moments([m1, m2, m3, m4]: [f64; 4]) -> [f64; 2] {
        let variance = m2 - m1 * m1;
        let third = m3 - 3.0 * m1 * m2 + 2.0 * m1.powi(3);
        let fourth = m4 - 4.0 * m1 * m3 + 6.0 * m1 * m1 * m2 - 3.0 * m1.powi(4);
        [third / variance.powf(1.5), fourth / variance.powi(2)]
    }

    #[test]
    fn heights_have_the_skewness_and_kurtosis_of_their_distribution() {
        let grid = Grid::square(128, 1.0).unwrap();
        let lognormal = |sigma: f64| of_moments([1.0, 2.0, 3.0, 4.0].map(|k: f64| (0.5 * (k * sigma).powi(2)).exp()));
        let weibull = |shape: f64| of_moments([1.0, 2.0, 3.0, 4.0].map(|k: f64| gamma(1.0 + k / shape)));
        // The value of ISO for exp(0.3 g), from an independent program.
        assert_relative_eq!(lognormal(0.3)[0], 0.949534907257, max_relative = 1e-11);
        assert_relative_eq!(lognormal(0.3)[1], 4.64491040539, max_relative = 1e-11);
        let uniform = "-1:0,1:1";
        for (text, [skewness, kurtosis], allowed) in [
            ("lognormal:0.3", lognormal(0.3), 0.01),
            ("weibull:1.5", weibull(1.5), 0.01),
            ("weibull:3", weibull(3.0), 0.005),
            ("weibull:20", weibull(20.0), 0.01),
            (uniform, [0.0, 1.8], 0.02),
        ] {
            for seed in 1..4 {
                let found = shape(&marginal(text).heights(&rough(1.0 / 32.0), &grid, seed).unwrap());
                assert!((found[0] - skewness).abs() < allowed, "{text}: {} {skewness}", found[0]);
                assert!((found[1] / kurtosis - 1.0).abs() < 2.0 * allowed, "{text}: {} {kurtosis}", found[1]);
            }
        }
    }

    #[test]
    fn a_negative_number_mirrors_the_distribution() {
        for (text, mirror) in [("lognormal:0.4", "lognormal:-0.4"), ("weibull:1.5", "weibull:-1.5")] {
            for p in [1e-4, 0.2, 0.5, 0.9] {
                let [low, high] = [marginal(text).quantile(p), marginal(mirror).quantile(1.0 - p)];
                assert_relative_eq!(low, -high, max_relative = 1e-12);
            }
        }
        assert_relative_eq!(marginal("weibull:2").quantile(0.5), 2.0_f64.ln().sqrt(), max_relative = 1e-14);
        assert_relative_eq!(marginal("0:0,1:0.5,5:1").quantile(0.75), 3.0, max_relative = 1e-14);
    }

    #[test]
    fn the_spectrum_and_the_size_are_kept() {
        let grid = Grid::new([64, 96], [1.0, 1.5]).unwrap();
        let spectrum = rough(1.0 / 15.0);
        let heights = marginal("weibull:-1.5").heights(&spectrum, &grid, 7).unwrap();
        let found = PowerSpectrum::of(&heights, &grid).unwrap();
        let normal = PowerSpectrum::of(&spectrum.heights(&grid, 7).unwrap(), &grid).unwrap();
        assert_relative_eq!(found.moments().rms_gradient(), 0.1, max_relative = 1e-12);
        assert_relative_eq!(found.moments().rms_height(), normal.moments().rms_height(), max_relative = 1e-12);
        let transform = Transform::new(grid);
        let mut coefficients = vec![Complex64::ZERO; grid.spectrum_len()];
        let field: Vec<f64> = heights.iter().copied().collect();
        transform.forward(&field, &mut coefficients, &mut transform.workspace()).unwrap();
        for (own, given) in coefficients.iter().zip(spectrum.spectrum(&grid, 7).unwrap()) {
            assert!((own.norm() - given.norm()).abs() < 1e-15, "{own} {given}");
        }
    }

    #[test]
    fn seed_and_cell_determine_the_surface_on_any_grid() {
        let (spectrum, marginal) = (rough(0.05), marginal("lognormal:0.3"));
        let of = |n: usize| marginal.heights(&spectrum, &Grid::square(n, 1.0).unwrap(), 3).unwrap();
        let (coarse, fine) = (of(50), of(150));
        for ((i, j), height) in coarse.indexed_iter() {
            assert!((height - fine[[3 * i, 3 * j]]).abs() < 1e-15, "{i} {j}");
        }
    }

    #[test]
    fn the_bits_do_not_depend_on_the_threads() {
        let grid = Grid::square(96, 1.0).unwrap();
        let of = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| marginal("weibull:2").heights(&rough(1.0 / 24.0), &grid, 1).unwrap())
        };
        assert_eq!(of(1), of(3));
    }

    #[test]
    fn profiles_have_the_distribution_too() {
        let spectrum = SelfAffine { longest_wavelength: 0.02, ..rough(0.004) };
        let heights = marginal("weibull:-2").heights(&spectrum, &Grid::line(2048, 1.0).unwrap(), 1).unwrap();
        assert!((shape(&heights)[0] + 0.631).abs() < 0.02, "{:?}", shape(&heights));
    }

    #[test]
    fn texts_are_read_back_and_wrong_ones_refused() {
        for text in ["lognormal:0.3", "weibull:-1.5", "-1:0,0.5:0.25,2:1"] {
            assert_eq!(marginal(text).to_string(), text);
        }
        let says = |text: &str, words: &str| {
            let message = text.parse::<Marginal>().unwrap_err().to_string();
            assert!(message.starts_with(words), "{message}");
        };
        says("normal", "it is \"normal\"; it must be lognormal:SIGMA, weibull:SHAPE or HEIGHT:PROBABILITY");
        says("weibull:x", "it is \"weibull:x\"; it must be");
        says("weibull:0", "the shape is 0; it must be between 0.5 and 100, or");
        says("lognormal:nan", "the standard deviation is NaN; it must be between 0.01 and 2");
        says("0:0.1,1:1", "the table has probabilities from 0.1 to 1; they must begin with 0 and end with 1");
        says("0:0,1:0.5,0.5:1", "row 3 of the table is height 0.5 with probability 1; both must be finite");
        says("0:0,nan:0.5,1:1", "row 2 of the table");
        says("0:0,0:1", "row 2 of the table is height 0");
        says("0:0", "the table has probabilities from 0 to 0");
    }

    #[test]
    fn what_the_waves_cannot_have_is_refused() {
        let grid = Grid::square(64, 1.0).unwrap();
        let refused = |text: &str, shortest: f64| marginal(text).heights(&rough(shortest), &grid, 1).unwrap_err();
        assert!(matches!(refused("lognormal:1", 1.0 / 16.0), SurfaceError::Marginal { found } if found > 0.1));
        assert!(matches!(refused("weibull:2", 1.0 / 32.0), SurfaceError::NoRoomForPhases { .. }));
        assert!(matches!(refused("weibull:2", 1.0 / 64.0), SurfaceError::BeyondNyquist { .. }));
    }
}
