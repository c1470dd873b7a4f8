//! Closed forms that contact calculations are compared with (theory.md, section 10). Half-space, no friction, rigid
//! indenter; `modulus` is the contact modulus E* (stress).

use std::f64::consts::{PI, SQRT_2};

/// κ of Persson's theory at vanishing load, √(8/π) ≈ 1.596 (Persson 2001).
pub const PERSSON_KAPPA: f64 = 1.595_769_121_605_731;

/// κ of Bush, Gibson and Thomas at vanishing load, √(2π) ≈ 2.507 (Bush et al. 1975).
pub const BUSH_GIBSON_THOMAS_KAPPA: f64 = 2.506_628_274_631_000_5;

/// Contact area fraction of Persson's theory, erf(√2 p*), p* the reduced pressure.
pub fn persson_area(reduced_pressure: f64) -> f64 {
    libm::erf(SQRT_2 * reduced_pressure)
}

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

/// Hertz point contact under the normal force `force` (stress × length²).
pub fn hertz_point(modulus: f64, curvature_radius: f64, force: f64) -> HertzPoint {
    let radius = (0.75 * force * curvature_radius / modulus).cbrt();
    HertzPoint {
        radius,
        peak_pressure: 1.5 * force / (PI * radius * radius),
        approach: radius * radius / curvature_radius,
    }
}

/// Hertz line contact of a parabola h = −x²/2R: half-width a, a² = 4 F′R/(π E*), and peak pressure 2F′/(π a), under the
/// force per length `force` (stress × length).
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
    /// The mean pressure that closes the gap, π E* A/λ.
    pub fn full_contact_pressure(&self) -> f64 {
        PI * self.modulus * self.amplitude / self.period
    }

    fn load(&self, mean_pressure: f64) -> f64 {
        (mean_pressure / self.full_contact_pressure()).clamp(0.0, 1.0)
    }

    /// Contact area fraction (2/π) asin √(p̄/p_full).
    pub fn area(&self, mean_pressure: f64) -> f64 {
        2.0 / PI * self.load(mean_pressure).sqrt().asin()
    }

    /// Pressure at x, up to full contact.
    pub fn pressure(&self, mean_pressure: f64, x: f64) -> f64 {
        let f = self.load(mean_pressure);
        let s = (PI * x / self.period).sin().powi(2);
        if s >= f {
            return 0.0;
        }
        2.0 * mean_pressure * (PI * x / self.period).cos().abs() * (f - s).sqrt() / f
    }

    /// Mean gap A (1 − f + f ln f), f = p̄/p_full.
    pub fn mean_gap(&self, mean_pressure: f64) -> f64 {
        let f = self.load(mean_pressure);
        if f == 0.0 { self.amplitude } else { self.amplitude * (1.0 - f + f * f.ln()) }
    }
}

/// Johnson's doubly wavy surface A cos(2π x/λ) cos(2π y/λ): the mean pressure that closes the gap, √2 π E* A/λ
/// (Johnson, Greenwood and Higginson 1985).
pub fn johnson_full_contact_pressure(modulus: f64, amplitude: f64, period: f64) -> f64 {
    SQRT_2 * PI * modulus * amplitude / period
}

/// Area fraction of the doubly wavy surface at vanishing load, π (3 f/8π)^{2/3}, f = p̄/p_full.
pub fn johnson_area_at_low_load(relative_pressure: f64) -> f64 {
    PI * (3.0 * relative_pressure / (8.0 * PI)).powf(2.0 / 3.0)
}

/// Area fraction of the doubly wavy surface near full contact, 1 − (3/2π)(1 − f).
pub fn johnson_area_near_full_contact(relative_pressure: f64) -> f64 {
    1.0 - 1.5 / PI * (1.0 - relative_pressure)
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;

    #[test]
    fn constants_are_the_square_roots_they_claim() {
        assert_relative_eq!(PERSSON_KAPPA, (8.0 / PI).sqrt(), max_relative = 1e-15);
        assert_relative_eq!(BUSH_GIBSON_THOMAS_KAPPA, (2.0 * PI).sqrt(), max_relative = 1e-15);
    }

    #[test]
    fn westergaard_pressure_carries_the_load_and_ends_at_the_edge() {
        let wave = Westergaard { modulus: 2.0, amplitude: 0.03, period: 1.5 };
        for f in [0.05, 0.4, 0.9] {
            let mean = f * wave.full_contact_pressure();
            let n = 200_000;
            let x = |i: usize| (i as f64 + 0.5) / n as f64 * wave.period;
            let load = (0..n).map(|i| wave.pressure(mean, x(i))).sum::<f64>() / n as f64;
            assert_relative_eq!(load, mean, max_relative = 1e-6);
            let touching = (0..n).filter(|i| wave.pressure(mean, x(*i)) > 0.0).count() as f64 / n as f64;
            assert_relative_eq!(touching, wave.area(mean), epsilon = 2.0 / n as f64);
        }
    }

    #[test]
    fn hertz_contacts_carry_their_load() {
        // ∫ p₀ √(1 − r²/a²) over the contact.
        let point = hertz_point(3.0, 2.0, 0.1);
        assert_relative_eq!(2.0 / 3.0 * PI * point.radius.powi(2) * point.peak_pressure, 0.1, max_relative = 1e-14);
        let (half_width, peak) = hertz_line(3.0, 2.0, 0.1);
        assert_relative_eq!(0.5 * PI * half_width * peak, 0.1, max_relative = 1e-14);
    }

    #[test]
    fn johnson_low_load_is_two_hertz_contacts_in_the_cell() {
        let (modulus, amplitude, period, f) = (1.3, 0.02, 0.7, 1e-4);
        let radius = period * period / (4.0 * PI * PI * amplitude);
        let force = f * johnson_full_contact_pressure(modulus, amplitude, period) * period * period / 2.0;
        let contact = hertz_point(modulus, radius, force).radius;
        let area = 2.0 * PI * contact * contact / (period * period);
        assert_relative_eq!(johnson_area_at_low_load(f), area, max_relative = 1e-12);
    }
}
