//! Laws that depend only on the gap.

use std::f64::consts::PI;

use crate::separation::{finite, positive};
use crate::{Law, LawError, Opening, Response};

/// The hard wall: the surfaces do not interpenetrate and do not attract each other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HardWall;

impl Law for HardWall {
    fn response(&self, _: f64, _: f64) -> Response {
        Response::default()
    }

    fn energy(&self, normal: f64, _: f64) -> Option<f64> {
        Some(self.opening_energy(normal))
    }

    fn opening_energy(&self, _: f64) -> f64 {
        0.0
    }

    fn has_wall(&self) -> bool {
        true
    }

    fn stiffness_bound(&self, _: f64) -> f64 {
        0.0
    }
}

/// Returns the work of adhesion and the range of a law if both are valid and their steepest slope is finite.
fn of_range(energy: f64, range: f64) -> Result<(f64, f64), LawError> {
    let (energy, range) = (positive("gamma", energy)?, positive("range", range)?);
    finite("2 gamma/range^2", 2.0 * energy / range / range)?;
    Ok((energy, range))
}

/// Exponentially decaying attraction, V = −γ e^{−g/ϱ}, with a hard wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exponential {
    energy: f64,
    range: f64,
}

impl Exponential {
    /// Creates the law with the work of adhesion γ (`energy`, per area) and the range ϱ.
    ///
    /// # Errors
    /// Returns an error if a parameter is not positive.
    pub fn new(energy: f64, range: f64) -> Result<Self, LawError> {
        let (energy, range) = of_range(energy, range)?;
        Ok(Self { energy, range })
    }
}

impl Law for Exponential {
    fn response(&self, normal: f64, _: f64) -> Response {
        let traction = self.energy / self.range * (-normal / self.range).exp();
        Response::normal(traction, -traction / self.range)
    }

    fn energy(&self, normal: f64, _: f64) -> Option<f64> {
        Some(self.opening_energy(normal))
    }

    fn opening_energy(&self, normal: f64) -> f64 {
        -self.energy * (-normal / self.range).exp()
    }

    fn opening(&self, normal: f64) -> Opening {
        let e = (-normal / self.range).exp();
        let traction = self.energy / self.range * e;
        Opening { energy: -self.energy * e, traction, slope: -traction / self.range }
    }

    fn has_wall(&self) -> bool {
        true
    }

    fn stiffness_bound(&self, lowest: f64) -> f64 {
        self.energy / self.range.powi(2) * (-lowest.max(0.0) / self.range).exp()
    }
}

/// Constant attraction γ/ϱ up to the gap ϱ, zero beyond, with a hard wall: the cohesive zone of Dugdale (1960), used by
/// Maugis (1992) for the adhesive sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dugdale {
    energy: f64,
    range: f64,
}

impl Dugdale {
    /// Creates the law with the work of adhesion γ (`energy`, per area) and the range ϱ.
    ///
    /// # Errors
    /// Returns an error if a parameter is not positive.
    pub fn new(energy: f64, range: f64) -> Result<Self, LawError> {
        let (energy, range) = of_range(energy, range)?;
        Ok(Self { energy, range })
    }
}

impl Law for Dugdale {
    fn response(&self, normal: f64, _: f64) -> Response {
        Response::normal(if normal <= self.range { self.energy / self.range } else { 0.0 }, 0.0)
    }

    fn energy(&self, normal: f64, _: f64) -> Option<f64> {
        Some(self.opening_energy(normal))
    }

    fn opening_energy(&self, normal: f64) -> f64 {
        self.energy * (normal / self.range - 1.0).min(0.0)
    }

    fn has_wall(&self) -> bool {
        true
    }

    fn stiffness_bound(&self, _: f64) -> f64 {
        0.0
    }

    fn steepness(&self) -> f64 {
        self.energy / self.range.powi(2)
    }

    /// Returns a large number, because the traction jumps to zero at the end of the range.
    fn resolving_points(&self) -> f64 {
        32.0
    }
}

/// The Morse potential V = γ(e^{−2g/ϱ} − 2e^{−g/ϱ}): soft repulsion, minimum −γ at g = 0, largest tension γ/(2ϱ) at
/// g = ϱ ln 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Morse {
    energy: f64,
    range: f64,
}

impl Morse {
    /// Creates the law with the depth γ of the minimum (`energy`, per area) and the range ϱ.
    ///
    /// # Errors
    /// Returns an error if a parameter is not positive.
    pub fn new(energy: f64, range: f64) -> Result<Self, LawError> {
        let (energy, range) = of_range(energy, range)?;
        Ok(Self { energy, range })
    }
}

impl Law for Morse {
    fn response(&self, normal: f64, _: f64) -> Response {
        let e = (-normal / self.range).exp();
        let strength = 2.0 * self.energy / self.range;
        Response::normal(strength * e * (1.0 - e), strength / self.range * e * (2.0 * e - 1.0))
    }

    fn energy(&self, normal: f64, _: f64) -> Option<f64> {
        Some(self.opening_energy(normal))
    }

    fn opening_energy(&self, normal: f64) -> f64 {
        let e = (-normal / self.range).exp();
        self.energy * e * (e - 2.0)
    }

    fn opening(&self, normal: f64) -> Opening {
        let e = (-normal / self.range).exp();
        let strength = 2.0 * self.energy / self.range;
        Opening {
            energy: self.energy * e * (e - 2.0),
            traction: strength * e * (1.0 - e),
            slope: strength / self.range * e * (2.0 * e - 1.0),
        }
    }

    fn stiffness_bound(&self, lowest: f64) -> f64 {
        let e = (-lowest / self.range).exp();
        // The steepest decay of the attraction is 1/8, at e = 1/4.
        2.0 * self.energy / self.range.powi(2) * (e * (2.0 * e - 1.0)).max(0.125)
    }

    fn steepness(&self) -> f64 {
        0.25 * self.energy / self.range.powi(2)
    }
}

/// Harmonic repulsion, V = −γ + ½ k g² for g < 0, and half a cosine wave of attraction, V = −γ (1 + cos wg)/2, up to
/// the finite range g = π/w, with w = √(2k/γ).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HarmonicCosine {
    energy: f64,
    curvature: f64,
    wavenumber: f64,
}

impl HarmonicCosine {
    /// Creates the law with the depth γ of the minimum of V (`energy`, per area) and its curvature k, stress/length.
    ///
    /// # Errors
    /// Returns an error if a parameter is not positive.
    pub fn new(energy: f64, curvature: f64) -> Result<Self, LawError> {
        let (energy, curvature) = (positive("gamma", energy)?, positive("curvature", curvature)?);
        let wavenumber = finite("sqrt(curvature/gamma)", (2.0 * curvature / energy).sqrt())?;
        finite("sqrt(gamma/curvature)", wavenumber.recip())?;
        Ok(Self { energy, curvature, wavenumber })
    }

    /// Returns the range π/w, the gap beyond which the traction is zero.
    pub fn cutoff(&self) -> f64 {
        PI / self.wavenumber
    }
}

impl Law for HarmonicCosine {
    fn response(&self, normal: f64, _: f64) -> Response {
        if normal < 0.0 {
            Response::normal(self.curvature * normal, self.curvature)
        } else if normal < self.cutoff() {
            let (sin, cos) = (self.wavenumber * normal).sin_cos();
            Response::normal(0.5 * self.energy * self.wavenumber * sin, self.curvature * cos)
        } else {
            Response::default()
        }
    }

    fn energy(&self, normal: f64, _: f64) -> Option<f64> {
        Some(self.opening_energy(normal))
    }

    fn opening_energy(&self, normal: f64) -> f64 {
        if normal < 0.0 {
            0.5 * self.curvature * normal * normal - self.energy
        } else if normal < self.cutoff() {
            // (1 + cos x)/2, written without cancellation.
            -self.energy * (0.5 * self.wavenumber * normal).cos().powi(2)
        } else {
            0.0
        }
    }

    fn stiffness_bound(&self, _: f64) -> f64 {
        self.curvature
    }
}
