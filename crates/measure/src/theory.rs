//! Closed forms for comparison with contact calculations (theory.md, section 10). Half-space, no friction, rigid
//! indenter; `modulus` is the contact modulus E* (stress).

mod asperities;
mod elastoplastic;
mod estimate;
mod persson;
mod quadrature;
mod summits;
#[cfg(test)]
mod tests;

use std::f64::consts::{PI, SQRT_2};

pub use asperities::{Asperities, AsperityContact, AsperityTheory};
pub use elastoplastic::ElastoplasticArea;
pub use estimate::{EquivalentBand, Estimate, Estimated, HURST_MARGIN, UnlikeSpectrum};
pub use persson::{ENERGY_FACTOR, Persson};
pub use summits::Summits;

use crate::GapGas;

/// κ of Persson's theory at vanishing load, √(8/π) ≈ 1.596 (Persson 2001).
pub const PERSSON_KAPPA: f64 = 1.595_769_121_605_731;

/// κ of Bush, Gibson and Thomas at vanishing load, √(2π) ≈ 2.507 (Bush et al. 1975).
pub const BUSH_GIBSON_THOMAS_KAPPA: f64 = 2.506_628_274_631_000_5;

/// Returns the contact area fraction of Persson's theory, erf(√2 p*), with p* the reduced pressure.
pub fn persson_area(reduced_pressure: f64) -> f64 {
    libm::erf(SQRT_2 * reduced_pressure)
}

/// Returns the density of a positive pressure in Persson's theory, from its variance in full contact (E*² ḡ²/4 on a
/// half-space): a Gaussian about the mean pressure minus its mirror image (Persson, J. Chem. Phys. 115 (2001) 3840).
/// All in stress.
pub fn persson_pressure(pressure: f64, mean_pressure: f64, variance: f64) -> f64 {
    let gaussian = |distance: f64| (-0.5 * distance * distance / variance).exp();
    let [about, image] = [pressure - mean_pressure, pressure + mean_pressure].map(gaussian);
    (about - image) / (std::f64::consts::TAU * variance).sqrt()
}

/// Returns the conductance per area of a gas in the gap above heights with a Gaussian distribution of standard
/// `deviation`, whose mean plane lies at the distance `mean_gap` below the other surface (lengths): the mean of
/// k/(g + M), to which points with a gap g > 0 contribute, by a quadrature of Yovanovich's integral (1982).
pub fn gaussian_gap_conductance(gas: &GapGas, deviation: f64, mean_gap: f64) -> f64 {
    let (distance, jump) = (mean_gap / deviation, gas.jump / deviation);
    // The integrand falls steeply from g = 0 to M, which the logarithm of g + M resolves.
    let [nearest, farthest] = [(distance - RANGE).max(0.0), (distance + RANGE).max(0.0)].map(|g| (g + jump).ln());
    let (rule, width) = (quadrature::unit_rule(24).collect::<Vec<_>>(), (farthest - nearest) / PANELS as f64);
    let panel = |index: usize| [index, index + 1].map(|end| nearest + end as f64 * width);
    let nodes = (0..PANELS).flat_map(|index| quadrature::scaled(&rule, panel(index)).collect::<Vec<_>>());
    let sum: f64 = nodes.map(|(log, weight)| weight * (-0.5 * (log.exp() - jump - distance).powi(2)).exp()).sum();
    gas.conductivity / deviation * sum / std::f64::consts::TAU.sqrt()
}

/// Standard deviations beyond which a Gaussian distribution has no heights that count.
const RANGE: f64 = 9.0;

/// Number of intervals of a quadrature over the gaps.
const PANELS: usize = 64;

/// Hertz contact of a parabola h = −r²/2R with a half-space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HertzPoint {
    /// Contact radius a, a³ = 3 F R/(4 E*).
    pub radius: f64,
    /// Largest pressure p₀ = 3 F/(2π a²).
    pub peak_pressure: f64,
    /// Approach a²/R.
    pub approach: f64,
}

/// Computes the Hertz point contact under the normal force `force` (stress × length²).
pub fn hertz_point(modulus: f64, curvature_radius: f64, force: f64) -> HertzPoint {
    let radius = (0.75 * force * curvature_radius / modulus).cbrt();
    HertzPoint {
        radius,
        peak_pressure: 1.5 * force / (PI * radius * radius),
        approach: radius * radius / curvature_radius,
    }
}

/// Returns half-width and peak pressure of the Hertz line contact of a parabola h = −x²/2R under the force per length
/// `force` (stress × length): a, a² = 4 F′R/(π E*), and 2F′/(π a).
pub fn hertz_line(modulus: f64, curvature_radius: f64, force: f64) -> (f64, f64) {
    let half_width = (4.0 * force * curvature_radius / (PI * modulus)).sqrt();
    (half_width, 2.0 * force / (PI * half_width))
}

/// Westergaard's wavy line contact: the profile A cos(2π x/λ), crest at x = 0, on a half-space in plane strain
/// (Westergaard 1939).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Westergaard {
    /// Contact modulus E*.
    pub modulus: f64,
    /// Amplitude A.
    pub amplitude: f64,
    /// Period λ.
    pub period: f64,
}

impl Westergaard {
    /// Returns the mean pressure that closes the gap, π E* A/λ.
    pub fn full_contact_pressure(&self) -> f64 {
        PI * self.modulus * self.amplitude / self.period
    }

    fn load(&self, mean_pressure: f64) -> f64 {
        (mean_pressure / self.full_contact_pressure()).clamp(0.0, 1.0)
    }

    /// Returns the contact area fraction (2/π) asin √(p̄/p_full).
    pub fn area(&self, mean_pressure: f64) -> f64 {
        2.0 / PI * self.load(mean_pressure).sqrt().asin()
    }

    /// Returns the pressure at x, up to full contact.
    pub fn pressure(&self, mean_pressure: f64, x: f64) -> f64 {
        let f = self.load(mean_pressure);
        let s = (PI * x / self.period).sin().powi(2);
        if s >= f {
            return 0.0;
        }
        2.0 * mean_pressure * (PI * x / self.period).cos().abs() * (f - s).sqrt() / f
    }

    /// Returns the mean pressure with an adhesive interface of short range and work of adhesion `work` (stress ×
    /// length) at the area fraction a: p_full sin²(π a/2) − √(2 E* w tan(π a/2)/λ) (Johnson 1995). Negative under
    /// tension.
    pub fn adhesive_pressure(&self, work: f64, area_fraction: f64) -> f64 {
        let angle = 0.5 * PI * area_fraction;
        self.full_contact_pressure() * angle.sin().powi(2)
            - (2.0 * self.modulus * work * angle.tan() / self.period).sqrt()
    }

    /// Returns the mean gap A (1 − f + f ln f), f = p̄/p_full.
    pub fn mean_gap(&self, mean_pressure: f64) -> f64 {
        let f = self.load(mean_pressure);
        if f == 0.0 { self.amplitude } else { self.amplitude * (1.0 - f + f * f.ln()) }
    }
}

/// Adhesive sphere (parabola) on a half-space, with any range of adhesion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdhesiveSphere {
    /// Contact modulus E*.
    pub modulus: f64,
    /// Radius of curvature R.
    pub curvature_radius: f64,
    /// Work of adhesion w, stress × length.
    pub work: f64,
}

/// Contact of an adhesive sphere at one width of its adhesive zone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdhesiveContact {
    /// Contact radius a.
    pub radius: f64,
    /// Normal force, negative if pulled; stress × length².
    pub force: f64,
    /// Approach against points far away, negative if the surfaces stretch towards each other.
    pub approach: f64,
}

impl AdhesiveSphere {
    /// Returns K = 4 E*/3.
    fn stiffness(&self) -> f64 {
        4.0 / 3.0 * self.modulus
    }

    /// Returns Maugis' unit of force, π w R.
    pub fn force_unit(&self) -> f64 {
        PI * self.work * self.curvature_radius
    }

    /// Returns Maugis' unit of the contact radius, (π w R²/K)^{1/3} with K = 4 E*/3.
    pub fn radius_unit(&self) -> f64 {
        (self.force_unit() * self.curvature_radius / self.stiffness()).cbrt()
    }

    /// Returns the adhesive strength σ₀ (stress) at Maugis' parameter λ = 2 σ₀ (R/π w K²)^{1/3}.
    pub fn strength(&self, lambda: f64) -> f64 {
        0.5 * lambda * (PI * self.work * self.stiffness().powi(2) / self.curvature_radius).cbrt()
    }

    /// Returns the pull-off force for vanishing range of adhesion, −(3/2) π w R (Johnson, Kendall and Roberts 1971).
    pub fn jkr_pull_off(&self) -> f64 {
        -1.5 * self.force_unit()
    }

    /// Returns the contact with constant adhesive stress out to the radius m a, m = `zone` > 1 (Maugis 1992).
    pub fn maugis(&self, lambda: f64, zone: f64) -> AdhesiveContact {
        let m = zone;
        let (root, arc) = ((m * m - 1.0).sqrt(), (1.0 / m).acos());
        // b a² + c a = 1 for a in units of `radius_unit`.
        let b = 0.5 * lambda * (root + (m * m - 2.0) * arc);
        let c = 4.0 / 3.0 * lambda * lambda * (root * arc - m + 1.0);
        let a = ((c * c + 4.0 * b).sqrt() - c) / (2.0 * b);
        AdhesiveContact {
            radius: a * self.radius_unit(),
            force: (a.powi(3) - lambda * a * a * (root + m * m * arc)) * self.force_unit(),
            approach: (a * a - 4.0 / 3.0 * lambda * a * root) * self.radius_unit().powi(2) / self.curvature_radius,
        }
    }

    /// Returns the pull-off force with constant adhesive stress, the minimum over all zone widths (Maugis 1992).
    pub fn maugis_pull_off(&self, lambda: f64) -> f64 {
        // The force has one minimum in m. Golden section in ln(m − 1), from m = 1.00005 to 22000.
        const SHORTER: f64 = 0.618_033_988_749_894_9;
        let force = |x: f64| self.maugis(lambda, 1.0 + x.exp()).force;
        let [mut low, mut high] = [-10.0, 10.0];
        for _ in 0..60 {
            let step = SHORTER * (high - low);
            if force(high - step) < force(low + step) { high = low + step } else { low = high - step }
        }
        force(0.5 * (low + high))
    }
}

/// Returns the mean pressure √2 π E* A/λ that closes the gap below Johnson's doubly wavy surface A cos(2π x/λ) cos(2π
/// y/λ) (Johnson, Greenwood and Higginson 1985).
pub fn johnson_full_contact_pressure(modulus: f64, amplitude: f64, period: f64) -> f64 {
    SQRT_2 * PI * modulus * amplitude / period
}

/// Returns the area fraction of the doubly wavy surface at vanishing load, π (3 f/8π)^{2/3}, f = p̄/p_full.
pub fn johnson_area_at_low_load(relative_pressure: f64) -> f64 {
    PI * (3.0 * relative_pressure / (8.0 * PI)).powf(2.0 / 3.0)
}

/// Returns the area fraction of the doubly wavy surface near full contact, 1 − (3/2π)(1 − f).
pub fn johnson_area_near_full_contact(relative_pressure: f64) -> f64 {
    1.0 - 1.5 / PI * (1.0 - relative_pressure)
}
