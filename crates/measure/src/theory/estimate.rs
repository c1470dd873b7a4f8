//! Numbers of a rough contact from its spectrum and highest points: the area formula for finite spectra, and Persson's
//! theory with the pressure distribution that has this area (theory.md, section 10).

use std::f64::consts::{SQRT_2, TAU};

use super::quadrature::gauss_legendre;
use super::{ENERGY_FACTOR, Persson, Summits};
use crate::SelfAffineArea;

/// Self-affine band-limited spectrum that spreads its mean square gradient over the wavenumbers as a surface does: the
/// logarithm of the wavenumber has the same variance and skewness. A band of the Hurst exponent H has the density
/// q^{2(1 − H)} per logarithm of the wavenumber q, from 2π/λ_l to 2π/λ_s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquivalentBand {
    /// Hurst exponent, not restricted to \[0, 1\].
    pub hurst: f64,
    /// Longest divided by shortest wavelength.
    pub eps_f_inv: f64,
}

/// Largest magnitude of the exponent t of a density e^{t x} on (0, 1).
const STEEPEST: f64 = 60.0;

/// Variance of the logarithm of one wavenumber, by rounding.
const ROUNDING: f64 = 1e-20;

/// Number of bisections of an interval.
const HALVINGS: usize = 60;

/// Returns variance and skewness of the density proportional to e^{t x} on (0, 1).
fn exponential(t: f64, rule: &[(f64, f64)]) -> [f64; 2] {
    let largest = t.max(0.0);
    let moments = rule.iter().fold([0.0; 4], |mut sums, (x, weight)| {
        let part = weight * (t * x - largest).exp();
        (0..4).for_each(|k| sums[k] += part * x.powi(k as i32));
        sums
    });
    let [m1, m2, m3] = [1, 2, 3].map(|k| moments[k] / moments[0]);
    let variance = m2 - m1 * m1;
    [variance, (m3 - 3.0 * m1 * m2 + 2.0 * m1.powi(3)) / variance.powf(1.5)]
}

impl EquivalentBand {
    /// Returns the band of the waves, each a wavenumber with its contribution to the mean square gradient.
    ///
    /// # Errors
    /// No band has their skewness, for one wavenumber for example.
    fn of(waves: impl Iterator<Item = (f64, f64)> + Clone) -> Result<Self, UnlikeSpectrum> {
        let logarithms = waves.map(|(wavenumber, square)| (wavenumber.ln(), square));
        let total: f64 = logarithms.clone().map(|(_, square)| square).sum();
        let mean = logarithms.clone().map(|(x, square)| x * square).sum::<f64>() / total;
        let moment = |k: i32| logarithms.clone().map(|(x, square)| square * (x - mean).powi(k)).sum::<f64>() / total;
        let variance = moment(2);
        let skewness = if variance > ROUNDING { moment(3) / variance.powf(1.5) } else { f64::NAN };
        let rule = gauss_legendre(80, [0.0, 1.0]);
        // The skewness falls as t grows.
        let [mut low, mut high] = [-STEEPEST, STEEPEST];
        let ends = [low, high].map(|t| exponential(t, &rule)[1]);
        if !(skewness < ends[0] && skewness > ends[1]) {
            return Err(UnlikeSpectrum::Skewness { skewness, ends: [ends[1], ends[0]] });
        }
        for _ in 0..HALVINGS {
            let t = 0.5 * (low + high);
            if exponential(t, &rule)[1] > skewness { low = t } else { high = t }
        }
        let t = 0.5 * (low + high);
        let length = (variance / exponential(t, &rule)[0]).sqrt();
        Ok(Self { hurst: 1.0 - 0.5 * t / length, eps_f_inv: length.exp() })
    }
}

/// A spectrum without an estimate, unlike all self-affine ones.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UnlikeSpectrum {
    /// No band has its skewness.
    Skewness {
        /// Skewness of the logarithm of the wavenumber, weighted by the mean square gradient; NaN for one wavenumber.
        skewness: f64,
        /// Least and largest skewness of bands.
        ends: [f64; 2],
    },
    /// The equivalent band has a Hurst exponent far from 0 to 1.
    Hurst(f64),
}

impl std::fmt::Display for UnlikeSpectrum {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let unlike = "the spectrum is unlike any self-affine one:";
        match self {
            Self::Skewness { skewness, .. } if skewness.is_nan() => write!(f, "{unlike} it has a single wavenumber"),
            Self::Skewness { skewness, ends: [least, most] } => write!(
                f,
                "{unlike} weighted by the mean square slope, the logarithm of the wavenumber has the skewness \
                 {skewness:.2}, and the formula is known from {least:.2} to {most:.2}"
            ),
            Self::Hurst(hurst) => write!(
                f,
                "{unlike} it has the Hurst exponent {hurst:.2}, and the formula is known from {:.2} to {:.2}",
                -HURST_MARGIN,
                1.0 + HURST_MARGIN
            ),
        }
    }
}

/// Estimate of the contacts of a surface with a half-space, without a solution: no friction, no adhesion.
///
/// The area is [`SelfAffineArea::of_band`] of the equivalent band, with the slopes of the points that touch: a contact
/// of area fraction a has points among the highest f = 1 − (1 − a)² of the surface, as a truncation of light contacts
/// has twice their area. With s the rms slope there divided by the rms slope of all points ([`Summits`]), the reduced
/// pressure is p/s. Mean gap and stiffness are of Persson's theory, moved by the height that f exceeds, in place of the
/// one of a Gaussian surface: w (h(f) + s e) + (1 − w) u with w = max(1 − 2a, 0), e = u − σ z(f), u the gap of the
/// theory at p/s, σ the rms height and z the Gaussian quantile. A light contact is no farther than the level that
/// truncates: of a positive e, only the part 5a counts up to a = 0.2. Pressures have Persson's distribution, with the
/// variance W with which its area is this area (theory.md, section 11): on the points in contact the mean square is
/// M₂/a, with M₂ = (p̄² + W) a + 2 p̄ √(W/2π) e^{−p̄²/2W}. The largest pressure is the level that one patch of the cell
/// exceeds on average: of a Gaussian field they are A ⟨q²⟩/(4π) z² P for high levels, z the level above the mean in
/// standard deviations, P the area fraction above it, and ⟨q²⟩ the mean square wavenumber of the pressure (Adler 1981).
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate {
    persson: Persson,
    band: EquivalentBand,
    formula: SelfAffineArea,
    /// Heights and slopes of the highest points; `None` stands for a Gaussian surface.
    summits: Option<Summits>,
    /// Variance of the pressure in full contact, stress².
    variance: f64,
    /// Area of the cell times its mean square wavenumber of the pressure in full contact, divided by 4π.
    patches: f64,
}

/// Numbers of a contact under one load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimated {
    /// Contact area fraction.
    pub area_fraction: f64,
    /// Mean gap, length.
    pub mean_gap: f64,
    /// Slope of the mean pressure p against the approach, p times the slope of ln p between p/1.5 and 1.5 p,
    /// stress/length.
    pub stiffness: f64,
    /// Rms pressure on the points in contact, stress.
    pub rms_pressure: f64,
    /// Largest pressure, stress; `None` if the cell has less than one patch of high pressure.
    pub max_pressure: Option<f64>,
}

/// Distance of a Hurst exponent from 0 to 1 within which it counts as the end of this range.
pub const HURST_MARGIN: f64 = 0.5;

impl Estimate {
    /// Takes Persson's theory of the surface on a half-space, and the area of the cell, length².
    ///
    /// # Errors
    /// The spectrum is unlike all self-affine ones: no equivalent band, or one with a Hurst exponent below −0.5 or
    /// above 1.5.
    pub fn new(persson: Persson, cell: f64) -> Result<Self, UnlikeSpectrum> {
        let band = EquivalentBand::of(persson.variances())?;
        let hurst = band.hurst.clamp(0.0, 1.0);
        let is_near = (band.hurst - hurst).abs() <= HURST_MARGIN;
        let formula = SelfAffineArea::new(hurst).filter(|_| is_near).ok_or(UnlikeSpectrum::Hurst(band.hurst))?;
        let variance = persson.variance(f64::INFINITY);
        let square: f64 = persson.variances().map(|(q, part)| q * q * part).sum();
        let patches = cell * square / variance / (2.0 * TAU);
        Ok(Self { band, formula, summits: None, variance, patches, persson })
    }

    /// Takes the heights and slopes of the surface's highest points, in place of the ones of a Gaussian surface.
    #[must_use]
    pub fn with_summits(mut self, summits: Summits) -> Self {
        self.summits = Some(summits);
        self
    }

    /// Returns the equivalent band.
    pub fn band(&self) -> EquivalentBand {
        self.band
    }

    /// Returns E* times the rms gradient, the unit of reduced pressures.
    pub fn unit_pressure(&self) -> f64 {
        2.0 * self.variance.sqrt()
    }

    /// Returns the numbers at a positive mean pressure, stress.
    pub fn at(&self, mean_pressure: f64) -> Estimated {
        let touching = self.touching(mean_pressure);
        let Touching { area, slope, factor } = touching;
        let deviation = self.variance.sqrt() * slope / factor;
        let z = mean_pressure / deviation;
        let square = deviation * deviation * ((1.0 + z * z) * area + 2.0 * z * (-0.5 * z * z).exp() / TAU.sqrt());
        let gap = |pressure| self.mean_gap(pressure, self.touching(pressure));
        let [low, high] = [mean_pressure / STIFFNESS_STEP, mean_pressure * STIFFNESS_STEP];
        Estimated {
            area_fraction: area,
            mean_gap: self.mean_gap(mean_pressure, touching),
            stiffness: mean_pressure * (high / low).ln() / (gap(low) - gap(high)),
            rms_pressure: (square / area).sqrt(),
            max_pressure: self.highest(z).map(|level| mean_pressure + level * deviation),
        }
    }

    /// Returns the points in contact at a mean pressure, stress.
    fn touching(&self, mean_pressure: f64) -> Touching {
        let with = |slope: f64| {
            let p_star = mean_pressure / (self.unit_pressure() * slope);
            let factor = self.formula.factor(1.0 / self.band.eps_f_inv, p_star);
            Touching { area: libm::erf(SQRT_2 * factor * p_star), slope, factor }
        };
        let Some(summits) = &self.summits else { return with(1.0) };
        let with_area = |area: f64| with(summits.slope(highest_fraction(area)).sqrt());
        // The contact area at the slopes of an assumed area is larger than a too small one, and smaller than 1.
        let [mut low, mut high] = [0.0, 1.0];
        for _ in 0..HALVINGS {
            let area = 0.5 * (low + high);
            if with_area(area).area > area { low = area } else { high = area }
        }
        with_area(0.5 * (low + high))
    }

    /// Returns the mean gap at a mean pressure, length.
    fn mean_gap(&self, mean_pressure: f64, Touching { area, slope, .. }: Touching) -> f64 {
        let gap = self.persson.mean_gap(mean_pressure / slope, ENERGY_FACTOR);
        let Some(summits) = &self.summits else { return gap };
        let fraction = highest_fraction(area);
        let gaussian = summits.rms_height() * exceeded(fraction);
        let beyond = gap - gaussian;
        let beyond = beyond.min(0.0) + (area / LIGHT).min(1.0) * beyond.max(0.0);
        let weight = (1.0 - 2.0 * area).max(0.0);
        weight * (summits.height(fraction) + slope * beyond) + (1.0 - weight) * gap
    }

    /// Returns the level above the mean pressure, in standard deviations, that one patch of the cell exceeds; `mean` is
    /// the mean pressure divided by the standard deviation.
    fn highest(&self, mean: f64) -> Option<f64> {
        let above = |z: f64| 0.5 * (libm::erfc(z / SQRT_2) - libm::erfc((z + 2.0 * mean) / SQRT_2));
        let number = |z: f64| self.patches * z * z * above(z);
        // The number of patches falls beyond the level √2.
        let [mut low, mut high] = [SQRT_2, FARTHEST];
        let has_patches = number(low) > 1.0;
        if !has_patches {
            return None;
        }
        for _ in 0..HALVINGS {
            let z = 0.5 * (low + high);
            if number(z) > 1.0 { low = z } else { high = z }
        }
        Some(0.5 * (low + high))
    }
}

/// Ratio of the higher load that gives the stiffness to the load, and of the load to the lower one.
const STIFFNESS_STEP: f64 = 1.5;

/// Area fraction below which a contact is light: its mean gap hardly exceeds the level that truncates.
const LIGHT: f64 = 0.2;

/// Points in contact.
#[derive(Clone, Copy, Debug)]
struct Touching {
    /// Area fraction.
    area: f64,
    /// Rms slope there, divided by the rms slope of all points.
    slope: f64,
    /// κ/√(8/π) of the formula at the reduced pressure divided by the slope.
    factor: f64,
}

/// Returns the area fraction of the highest points, among which are the points in contact.
fn highest_fraction(area: f64) -> f64 {
    1.0 - (1.0 - area).powi(2)
}

/// Returns the value that a standard normal number exceeds with this probability.
fn exceeded(probability: f64) -> f64 {
    let [mut low, mut high] = [-FARTHEST, FARTHEST];
    for _ in 0..HALVINGS {
        let z = 0.5 * (low + high);
        if 0.5 * libm::erfc(z / SQRT_2) > probability { low = z } else { high = z }
    }
    0.5 * (low + high)
}

/// Standard deviations that no pressure of a cell exceeds.
const FARTHEST: f64 = 36.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::theory::persson_pressure;

    /// Waves of a band in the plane: power q^{−2(1 + H)}, mean square gradient q^{2(1 − H)} d ln q.
    fn band(hurst: f64, longest: f64, shortest: f64) -> Persson {
        let (first, last) = ((TAU / longest).ln(), (TAU / shortest).ln());
        let waves = (0..4000).map(|k| {
            let q = (first + (last - first) * (f64::from(k) + 0.5) / 4000.0).exp();
            (q, 1e-8 * q.powf(-2.0 * hurst))
        });
        Persson::new(waves, |q| 0.5 * q).unwrap()
    }

    #[test]
    fn the_band_of_a_band_is_the_band() {
        for hurst in [0.0, 0.3, 0.8, 1.0] {
            for ratio in [8.0, 32.0, 200.0] {
                let found = Estimate::new(band(hurst, 0.5, 0.5 / ratio), 1.0).unwrap().band();
                assert!((found.hurst - hurst).abs() < 2e-3, "{hurst} {ratio}: {found:?}");
                assert!((found.eps_f_inv / ratio - 1.0).abs() < 0.03, "{hurst} {ratio}: {found:?}");
            }
        }
    }

    #[test]
    fn spectra_unlike_all_self_affine_ones_have_no_estimate() {
        let one = Persson::new([(1.0, 1.0)], |q| 0.5 * q).unwrap();
        let reason = |found: Result<Estimate, UnlikeSpectrum>| found.unwrap_err().to_string();
        assert!(reason(Estimate::new(one, 1.0)).contains("a single wavenumber"));
        for hurst in [-0.8, 1.8] {
            let reason = reason(Estimate::new(band(hurst, 0.5, 0.01), 1.0));
            assert!(
                reason.contains(&format!("Hurst exponent {hurst:.2}, and the formula is known from -0.50 to 1.50"))
            );
        }
        // Most of the slope is noise of the shortest waves.
        let noise = (1..=400).map(|k| (f64::from(k), if k < 400 { 1.0 } else { 4000.0 } / f64::from(k * k)));
        let reason = reason(Estimate::new(Persson::new(noise, |q| 0.5 * q).unwrap(), 1.0));
        assert!(reason.contains("skewness -") && reason.contains("known from -2.00 to 2.00"), "{reason}");
    }

    /// The area, the force and the mean square of the pressures are integrals of one distribution.
    #[test]
    fn the_mean_square_pressure_is_of_the_distribution_with_the_area() {
        let estimate = Estimate::new(band(0.8, 0.5, 0.02), 1.0).unwrap();
        for p_star in [0.001, 0.05, 0.5, 2.0] {
            let p = p_star * estimate.unit_pressure();
            let found = estimate.at(p);
            let factor = estimate.formula.factor(1.0 / estimate.band().eps_f_inv, p_star);
            let deviation = estimate.variance.sqrt() / factor;
            let rule = gauss_legendre(400, [0.0, p + 12.0 * deviation]);
            let moment = |k: i32| -> f64 {
                rule.iter().map(|(s, w)| w * s.powi(k) * persson_pressure(*s, p, deviation * deviation)).sum()
            };
            assert!((moment(0) / found.area_fraction - 1.0).abs() < 1e-9, "{p_star}");
            assert!((moment(1) / p - 1.0).abs() < 1e-9, "{p_star}");
            let rms = (moment(2) / moment(0)).sqrt();
            assert!((found.rms_pressure / rms - 1.0).abs() < 1e-9, "{p_star}");
            assert!(found.max_pressure.unwrap() > found.rms_pressure, "{p_star}");
        }
    }

    #[test]
    fn the_stiffness_is_the_slope_of_the_mean_gap() {
        let estimate = Estimate::new(band(0.5, 0.5, 0.02), 1.0).unwrap();
        for p_star in [1e-6, 0.01, 0.3, 1.5] {
            let p = p_star * estimate.unit_pressure();
            let [low, high] = [p / 1.5, p * 1.5];
            let slope = p * 2.25_f64.ln() / (estimate.at(low).mean_gap - estimate.at(high).mean_gap);
            let found = estimate.at(p).stiffness;
            assert!((found / slope - 1.0).abs() < 1e-5, "{p_star}: {found} {slope}");
        }
    }

    /// A larger cell has a higher peak; the numbers scale with the modulus and the heights.
    #[test]
    fn peaks_grow_with_the_cell_and_all_numbers_scale() {
        let one = Estimate::new(band(0.8, 0.5, 0.02), 1.0).unwrap();
        let large = Estimate::new(band(0.8, 0.5, 0.02), 100.0).unwrap();
        let p = 0.05 * one.unit_pressure();
        assert!(large.at(p).max_pressure > one.at(p).max_pressure);
        assert_eq!(large.at(p).area_fraction, one.at(p).area_fraction);
        let waves = band(0.8, 0.5, 0.02);
        let waves = waves.variances().map(|(q, v)| (q, 4.0 * v / (0.25 * q * q))).collect::<Vec<_>>();
        let stiffer = Estimate::new(Persson::new(waves, |q| 3.0 * 0.5 * q).unwrap(), 1.0).unwrap();
        let (a, b) = (one.at(p), stiffer.at(6.0 * p));
        for (a, b, factor) in [
            (a.area_fraction, b.area_fraction, 1.0),
            (a.mean_gap, b.mean_gap, 2.0),
            (a.stiffness, b.stiffness, 3.0),
            (a.rms_pressure, b.rms_pressure, 6.0),
            (a.max_pressure.unwrap(), b.max_pressure.unwrap(), 6.0),
        ] {
            assert!((b / a / factor - 1.0).abs() < 1e-6, "{a} {b} {factor}");
        }
    }

    /// Heights e^{s h}: where a contact is light, it has the area of a Gaussian surface with the slopes of its summits,
    /// and lies at the height of its summits.
    #[test]
    fn summits_with_other_slopes_move_area_and_gap() {
        let n = 400;
        let field = |s: f64| {
            ndarray::Array2::from_shape_fn((n, n), |(x, y)| {
                let [x, y] = [x, y].map(|k| TAU * k as f64 / n as f64);
                let sum: f64 = (1..9).map(|k: i32| (f64::from(k) * (x + 0.7 * f64::from(k * k)) + y).cos()).sum();
                if s == 0.0 { sum } else { (s * sum).exp_m1() / s }
            })
        };
        let of = |s: f64| Summits::of(field(s).view(), [1.0 / n as f64; 2]).unwrap();
        let plain = Estimate::new(band(0.8, 0.5, 0.02), 1.0).unwrap();
        let p = 0.01 * plain.unit_pressure();
        let [valleys, peaks] = [-0.2, 0.2].map(|s| (of(s), plain.clone().with_summits(of(s)).at(p)));
        assert!(valleys.1.area_fraction > 1.3 * plain.at(p).area_fraction, "{valleys:?}");
        assert!(peaks.1.area_fraction < 0.8 * plain.at(p).area_fraction, "{peaks:?}");
        for (summits, found) in [valleys, peaks] {
            let slope = summits.slope(highest_fraction(found.area_fraction)).sqrt();
            assert!((found.area_fraction / plain.at(p / slope).area_fraction - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn the_exceeded_value_is_the_normal_quantile() {
        for (probability, z) in [(0.5, 0.0), (0.158_655_253_931_457, 1.0), (0.977_249_868_051_821, -2.0)] {
            assert!((exceeded(probability) - z).abs() < 1e-12, "{probability}");
        }
    }

    /// A Gaussian field in full contact: one patch above the level, by the formula for its zeros of order one.
    #[test]
    fn in_full_contact_the_peak_is_of_a_gaussian_field() {
        let estimate = Estimate::new(band(0.8, 0.5, 0.02), 1.0).unwrap();
        let p = 6.0 * estimate.unit_pressure();
        let deviation = estimate.variance.sqrt();
        let z = (estimate.at(p).max_pressure.unwrap() - p) / deviation;
        let gaussian = (-0.5 * z * z).exp() * z / TAU.sqrt();
        // 1/z² corrections of the tail.
        assert!((estimate.patches * gaussian * (1.0 - 1.0 / (z * z)) - 1.0).abs() < 0.03, "{z}");
    }
}
