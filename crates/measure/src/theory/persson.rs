//! Persson's theory for a spectrum and a body (theory.md, section 10).

use std::f64::consts::PI;

use super::persson_pressure;
use super::quadrature::{scaled, unit_rule};

/// Persson's theory of a randomly rough surface pressed on an elastic body (Persson 2001). Waves are added from long to
/// short; each spreads the pressure distribution, which vanishes at zero pressure.
#[derive(Clone, Debug, PartialEq)]
pub struct Persson {
    /// Shells in ascending order of wavenumber.
    shells: Vec<Shell>,
}

/// Waves of about equal wavenumber.
#[derive(Clone, Debug, PartialEq)]
struct Shell {
    wavenumber: f64,
    /// Contribution of the waves to the mean square height, length².
    mean_square_height: f64,
    /// Normal stiffness of the body, stress/length.
    stiffness: f64,
    /// Wavenumber and contribution to the mean square height of each wave, in order; equal wavenumbers are merged.
    waves: Vec<(f64, f64)>,
}

/// Ratio of the wavenumbers at the ends of a shell.
const ALIKE: f64 = 1.002;

/// Relative tolerance for a wave up to a wavenumber: far above the rounding errors of 2π divided by a wavelength, and
/// far below the distance of wavenumbers.
const ROUNDING_OF_WAVENUMBER: f64 = 1e-12;

/// Elastic energy of a contact of small area, divided by the energy in full contact times the area fraction. Almqvist,
/// Campañá, Prodanov and Persson (2011) find 0.42 to 0.48 for self-affine surfaces.
pub const ENERGY_FACTOR: f64 = 0.45;

impl Persson {
    /// Takes waves in any order, each with its wavenumber (1/length) and its contribution to the mean square height
    /// (length²), and the normal stiffness k(q) of the body (stress/length; E* q/2 for a half-space). Waves without
    /// height are ignored. Returns `None` if no wave is left, or if a value is negative or not finite.
    pub fn new(waves: impl IntoIterator<Item = (f64, f64)>, stiffness: impl Fn(f64) -> f64) -> Option<Self> {
        let mut waves: Vec<(f64, f64)> = waves.into_iter().filter(|(_, square)| *square != 0.0).collect();
        let good = |value: f64| value > 0.0 && value.is_finite();
        if waves.is_empty() || !waves.iter().all(|(wavenumber, square)| good(*wavenumber) && good(*square)) {
            return None;
        }
        waves.sort_by(|one, other| one.0.total_cmp(&other.0));
        let alike = |one: &(f64, f64), other: &(f64, f64)| {
            (one.0.ln() / ALIKE.ln()).floor() == (other.0.ln() / ALIKE.ln()).floor()
        };
        let shell = |waves: &[(f64, f64)]| {
            let mean_square_height: f64 = waves.iter().map(|(_, square)| square).sum();
            let wavenumber = waves.iter().map(|(wavenumber, square)| wavenumber * square / mean_square_height).sum();
            let mut distinct: Vec<(f64, f64)> = Vec::new();
            for (wavenumber, square) in waves {
                match distinct.last_mut() {
                    Some((last, sum)) if *wavenumber <= *last * (1.0 + ROUNDING_OF_WAVENUMBER) => *sum += square,
                    _ => distinct.push((*wavenumber, *square)),
                }
            }
            Shell { wavenumber, mean_square_height, stiffness: stiffness(wavenumber), waves: distinct }
        };
        let shells: Vec<Shell> = waves.chunk_by(alike).map(shell).collect();
        shells.iter().all(|shell| good(shell.stiffness)).then_some(Self { shells })
    }

    /// Returns the variance of the pressure in full contact, Σ k(q)²|h̃|², of the waves up to the wavenumber `largest`,
    /// which is included up to rounding errors; stress².
    pub fn variance(&self, largest: f64) -> f64 {
        let largest = largest * (1.0 + ROUNDING_OF_WAVENUMBER);
        self.shells.iter().map(|shell| shell.variance_up_to(largest)).sum()
    }

    /// Returns the contact area fraction erf(p̄/√(2V)) of the waves up to the wavenumber `largest`; infinity includes
    /// all waves.
    pub fn area(&self, mean_pressure: f64, largest: f64) -> f64 {
        match self.variance(largest) {
            0.0 => f64::from(u8::from(mean_pressure > 0.0)),
            variance => libm::erf(mean_pressure / (2.0 * variance).sqrt()),
        }
    }

    /// Returns the density P(σ) of the pressure σ > 0, 1/stress, of the waves up to `largest`: a Gaussian about p̄
    /// minus its mirror image at σ = 0. Its integral is the contact area fraction. Zero if there is no wave.
    pub fn pressure_density(&self, mean_pressure: f64, largest: f64, pressure: f64) -> f64 {
        match self.variance(largest) {
            variance if variance > 0.0 && pressure > 0.0 => persson_pressure(pressure, mean_pressure, variance),
            _ => 0.0,
        }
    }

    /// Returns the mean gap ∫ (1/p) dU/dp dp from p̄ to infinity, where U = ½ Σ k|h̃|² [γ a + (1 − γ) a³] is the
    /// elastic energy per area, a the area at the wavenumber, and γ = `energy_factor` (Persson 2007; Almqvist et al.
    /// 2011). Length.
    ///
    /// The sum is an integral over the variance V of the pressure, in which waves of equal wavenumber are added one by
    /// one: a depends on V, and V grows by k² |h̃|² with each wave. The gap therefore depends on the spectrum alone,
    /// even for few waves. It grows without limit as the pressure vanishes and is infinite at zero pressure.
    pub fn mean_gap(&self, mean_pressure: f64, energy_factor: f64) -> f64 {
        if mean_pressure <= 0.0 {
            return f64::INFINITY;
        }
        self.sum_of(mean_pressure, energy_factor, Separation::at)
    }

    /// Returns the slope of the mean pressure against the approach of the mean planes, −dp̄/dū with the gap of
    /// [`mean_gap`](Self::mean_gap), at a positive pressure; stress/length. Infinite in full contact.
    pub fn stiffness(&self, mean_pressure: f64, energy_factor: f64) -> f64 {
        self.sum_of(mean_pressure, energy_factor, Separation::slope).recip()
    }

    /// Returns Σ ½ k|h̃|² times the mean of `part` over the variance of each wave.
    fn sum_of(&self, mean_pressure: f64, energy_factor: f64, part: fn(&Separation, f64) -> f64) -> f64 {
        let separation = Separation { mean_pressure, energy_factor, rule: unit_rule(12).collect() };
        let rules = [2, 6].map(|count| unit_rule(count).collect::<Vec<_>>());
        let mut longer = 0.0;
        let mut sum = 0.0;
        for shell in &self.shells {
            let variances = [longer, longer + shell.variance()];
            longer = variances[1];
            let separated = separation.mean_over(variances, &rules, part);
            sum += 0.5 * shell.stiffness * shell.mean_square_height * separated;
        }
        sum
    }

    /// Returns the wavenumbers of the shells, ascending, each with its contribution to the variance of the pressure in
    /// full contact; 1/length and stress².
    pub(super) fn variances(&self) -> impl Iterator<Item = (f64, f64)> + Clone {
        self.shells.iter().map(|shell| (shell.wavenumber, shell.variance()))
    }
}

impl Shell {
    fn variance(&self) -> f64 {
        self.stiffness.powi(2) * self.mean_square_height
    }

    /// Returns the contribution of the waves up to a wavenumber to the variance.
    fn variance_up_to(&self, largest: f64) -> f64 {
        match self.waves.last() {
            Some((highest, _)) if *highest <= largest => self.variance(),
            _ => {
                let seen = self.waves.iter().take_while(|(wavenumber, _)| *wavenumber <= largest);
                self.stiffness.powi(2) * seen.map(|(_, square)| square).sum::<f64>()
            }
        }
    }
}

/// Mean gap divided by the elastic energy in full contact, for waves added at a given variance of the pressure.
struct Separation {
    mean_pressure: f64,
    energy_factor: f64,
    /// Quadrature rule on (0, 1).
    rule: Vec<(f64, f64)>,
}

/// Value of p/√(2V) beyond which the integrand is negligible: the rest is below 1e-18.
const FAR: f64 = 6.5;

/// Ratio of pressure deviations below which the integral over the variance is negligible: the integrand grows there as
/// the logarithm of the deviation, and the interval vanishes.
const NOTHING: f64 = 1e-30;

/// Ratio of the pressure deviations at the ends of a shell below which two quadrature points suffice.
const NARROW: f64 = 1.05;

impl Separation {
    /// Returns the mean of `part` over the variances between `low` and `high`. `rules` are the quadrature rules for a
    /// narrow and a wide interval.
    fn mean_over(&self, [low, high]: [f64; 2], rules: &[Vec<(f64, f64)>; 2], part: fn(&Separation, f64) -> f64) -> f64 {
        // dV = 2 r dr with r = √V, starting where the surfaces begin to separate.
        let least = self.mean_pressure / (2.0_f64.sqrt() * FAR);
        let ends = [low.sqrt().max(least).max(high.sqrt() * NOTHING), high.sqrt()];
        if ends[0] >= ends[1] {
            // There is no separation, or the waves add less than the last digit.
            return if high.sqrt() > least { part(self, high) } else { 0.0 };
        }
        let ratio = ends[1] / ends[0];
        let rule = if ratio < NARROW { &rules[0] } else { &rules[1] };
        // The integrand is smooth in ln r.
        let panels = ratio.log2().ceil().max(1.0);
        let edge = |panel: f64| ends[0] * ratio.powf(panel / panels);
        let integral: f64 = (0..panels as usize)
            .flat_map(|panel| scaled(rule, [edge(panel as f64), edge(panel as f64 + 1.0)]))
            .map(|(deviation, weight)| weight * 2.0 * deviation * part(self, deviation * deviation))
            .sum();
        integral / (high - low)
    }

    /// Returns ∫ (1/p) da/dp [γ + 3(1 − γ) a²] dp from the mean pressure to infinity, with a = erf(p/√(2V)); 1/stress.
    fn at(&self, variance: f64) -> f64 {
        let unit = (2.0 * variance).sqrt();
        let start = (self.mean_pressure / unit).max(f64::MIN_POSITIVE).ln();
        // Integrates over x = ln(p/√(2V)); the smallest positive number bounds the quotient from below.
        let end = FAR.ln();
        if start >= end {
            return 0.0;
        }
        // The integrand is constant for small p and falls beyond p = √(2V): panels of unit length.
        let panels = (end - start).ceil().max(1.0);
        let length = (end - start) / panels;
        let sum: f64 = (0..panels as usize)
            .flat_map(|panel| {
                let low = start + panel as f64 * length;
                scaled(&self.rule, [low, low + length])
            })
            .map(|(x, weight)| {
                let s = x.exp();
                let area = libm::erf(s);
                weight * (-s * s).exp() * (self.energy_factor + 3.0 * (1.0 - self.energy_factor) * area * area)
            })
            .sum();
        2.0 / PI.sqrt() / unit * sum
    }

    /// Returns minus the slope of [`at`](Self::at) against the mean pressure, (1/p) da/dp [γ + 3(1 − γ) a²]; 1/stress².
    fn slope(&self, variance: f64) -> f64 {
        let unit = (2.0 * variance).sqrt();
        let s = self.mean_pressure / unit;
        if s >= FAR {
            return 0.0;
        }
        let area = libm::erf(s);
        let energy = self.energy_factor + 3.0 * (1.0 - self.energy_factor) * area * area;
        2.0 / PI.sqrt() / unit * (-s * s).exp() * energy / self.mean_pressure
    }
}
