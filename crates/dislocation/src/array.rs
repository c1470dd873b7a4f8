//! Row of equal edge dislocations, one in each periodic cell, in an unbounded body (theory.md, section 15.1).

use std::f64::consts::PI;

use gfmd_green::Material;
use num_complex::Complex64;

/// Edge dislocation of a periodic row: one at `place` + (n L, 0) for each integer n.
///
/// The Burgers vector is the jump of the displacement along a closed counter-clockwise path in the x-z plane, seen with
/// x to the right and z up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Coordinates x, and z from the surface (negative inside), in length.
    pub place: [f64; 2],
    /// Components of the Burgers vector along x and z, in length.
    pub burgers: [f64; 2],
}

/// Stress in plane strain.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stress {
    /// Component σ_xx.
    pub xx: f64,
    /// Component σ_zz.
    pub zz: f64,
    /// Component σ_xz.
    pub xz: f64,
}

impl Stress {
    /// Returns the resolved shear stress τ on a plane with the unit vector `along` in it, positive if it moves the side
    /// to the left of `along` forward.
    pub fn resolved(&self, along: [f64; 2]) -> f64 {
        let [c, s] = along;
        (self.zz - self.xx) * s * c + self.xz * (c * c - s * s)
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Self { xx: self.xx + other.xx, zz: self.zz + other.zz, xz: self.xz + other.xz }
    }
}

/// Elastic constants of an unbounded body, and the period.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    shear_modulus: f64,
    poisson: f64,
    contact_modulus: f64,
    period: f64,
}

impl Row {
    pub(crate) fn new(material: &Material, period: f64) -> Self {
        Self {
            shear_modulus: material.shear_modulus(),
            poisson: material.poisson(),
            contact_modulus: material.contact_modulus(),
            period,
        }
    }

    /// Returns γ of the potentials φ = γ ln ζ, ψ' = γ̄/ζ + ..., which give the jump B = 2πi γ (κ + 1)/(2μ).
    fn strength(&self, burgers: [f64; 2]) -> Complex64 {
        let jump = Complex64::new(burgers[0], burgers[1]);
        jump * Complex64::new(0.0, -self.shear_modulus / (PI * 4.0 * (1.0 - self.poisson)))
    }

    /// Returns Σ_n 1/(ζ − nL) and Σ_n 1/(ζ − nL)².
    fn sums(&self, zeta: Complex64) -> [Complex64; 2] {
        let k = PI / self.period;
        // With w = e^(2ik ζ), |w| <= 1, no term overflows far away.
        let (zeta, sign) = if zeta.im >= 0.0 { (zeta, 1.0) } else { (-zeta, -1.0) };
        let w = (Complex64::new(0.0, 2.0 * k) * zeta).exp();
        let one_minus = 1.0 - w;
        let first = Complex64::new(0.0, -k) * (1.0 + w) / one_minus;
        let second = -4.0 * k * k * w / (one_minus * one_minus);
        [first * sign, second]
    }

    /// Returns the stress of the row of `source` at `place`.
    pub(crate) fn stress(&self, source: &Edge, place: [f64; 2]) -> Stress {
        let zeta = Complex64::new(place[0] - source.place[0], place[1] - source.place[1]);
        let gamma = self.strength(source.burgers);
        let [first, second] = self.sums(zeta);
        let sum = 4.0 * (gamma * first).re;
        let difference = 2.0 * ((gamma.conj() - gamma) * first + Complex64::new(0.0, 2.0 * zeta.im) * gamma * second);
        Stress { xx: 0.5 * (sum - difference.re), zz: 0.5 * (sum + difference.re), xz: 0.5 * difference.im }
    }

    /// Returns the uniform σ_xx far above the row, −E* b_x/(2L), stress; far below the row it has the opposite sign.
    pub(crate) fn uniform_stress(&self, burgers: [f64; 2]) -> f64 {
        -0.5 * self.contact_modulus * burgers[0] / self.period
    }

    /// Returns the energy (per length along the lines, per cell) of one row in the field of another, up to a constant.
    /// Its negative gradient is the force on the second.
    pub(crate) fn energy(&self, one: &Edge, other: &Edge) -> f64 {
        let zeta = Complex64::new(other.place[0] - one.place[0], other.place[1] - one.place[1]);
        let gamma = self.strength(one.burgers);
        let [first, _] = self.sums(zeta);
        // ln |sin(π ζ/L)| without overflow, up to ln 2.
        let k = PI / self.period;
        let y = zeta.im.abs();
        let w = Complex64::new(-2.0 * k * y, 2.0 * k * zeta.re).exp();
        let logarithm = k * y + (1.0 - w).norm().ln();
        let potential = 2.0 * gamma * logarithm + Complex64::new(0.0, 2.0 * zeta.im) * gamma.conj() * first.conj();
        let jump = Complex64::new(other.burgers[0], other.burgers[1]);
        (jump.conj() * potential).im
    }

    /// Returns the traction (x, z) of the wave e^(i q x), q > 0, of the row on the plane z = `level`, which faces +z.
    pub(crate) fn wave(&self, source: &Edge, level: f64, q: f64) -> [Complex64; 2] {
        let y = level - source.place[1];
        let gamma = self.strength(source.burgers);
        let unit = PI / self.period;
        let decay = (-q * y.abs()).exp();
        let phase = Complex64::cis(-q * source.place[0]) * decay;
        // The complex function is e^(iqx) above the row, its conjugate below it.
        let sign = if y >= 0.0 { 1.0 } else { -1.0 };
        let turned = gamma.conj() - gamma;
        let normal = Complex64::new(0.0, -4.0 * sign * unit) * (0.5 * gamma.re + 0.5 * sign * y * q * gamma);
        let shear = -sign * unit * (turned + 2.0 * sign * y * q * gamma);
        let [shear, normal] = if y >= 0.0 { [shear, normal] } else { [shear.conj(), normal.conj()] };
        [shear * phase, normal * phase]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(period: f64) -> Row {
        Row::new(&Material::from_young(2.6, 0.3).unwrap(), period)
    }

    #[test]
    fn the_field_near_one_dislocation_is_that_in_an_infinite_body() {
        // Hirth and Lothe: D = μ b/(2π (1 − ν)); σ_xz = D x (x² − z²)/r⁴, σ_xx = −D z (3x² + z²)/r⁴, σ_zz = D z (x² −
        // z²)/r⁴.
        let d = 1.0 / (2.0 * PI * 0.7);
        let edge = Edge { place: [0.3, -0.2], burgers: [1.0, 0.0] };
        let (x, z) = (0.013, 0.021);
        let found = row(1e4).stress(&edge, [0.3 + x, -0.2 + z]);
        let r4 = (x * x + z * z) * (x * x + z * z);
        let wanted = [-d * z * (3.0 * x * x + z * z) / r4, d * z * (x * x - z * z) / r4, d * x * (x * x - z * z) / r4];
        for (found, wanted) in [found.xx, found.zz, found.xz].into_iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-6 * d / x, "{found} {wanted}");
        }
    }

    #[test]
    fn a_row_is_the_sum_of_its_members() {
        let edge = Edge { place: [0.1, 0.0], burgers: [0.6, 0.8] };
        let place = [0.37, 0.22];
        let (mut sum, single) = (Stress::default(), row(1e7));
        // The sum converges like 1/n in pairs.
        for n in -20_000..=20_000 {
            let member = Edge { place: [0.1 + f64::from(n), 0.0], ..edge };
            sum = sum.plus(single.stress(&member, place));
        }
        let found = row(1.0).stress(&edge, place);
        for (found, sum) in [(found.xx, sum.xx), (found.zz, sum.zz), (found.xz, sum.xz)] {
            assert!((found - sum).abs() < 2e-4, "{found} {sum}");
        }
    }

    #[test]
    fn the_force_is_the_slope_of_the_energy() {
        let row = row(1.3);
        let one = Edge { place: [0.1, -0.4], burgers: [0.6, 0.8] };
        for place in [[0.5, -0.1], [0.2, -0.9], [0.101, -0.398], [0.9, -4.0]] {
            let other = Edge { place, burgers: [-0.8, 0.3] };
            let at = |dx: f64, dz: f64| row.energy(&one, &Edge { place: [place[0] + dx, place[1] + dz], ..other });
            let step = 1e-6 * (place[0] - 0.1);
            let slope =
                [(at(-step, 0.0) - at(step, 0.0)) / (2.0 * step), (at(0.0, -step) - at(0.0, step)) / (2.0 * step)];
            let stress = row.stress(&one, place);
            let [bx, bz] = other.burgers;
            let force = [bx * stress.xz + bz * stress.zz, -(bx * stress.xx + bz * stress.xz)];
            let scale = force[0].hypot(force[1]);
            assert!((slope[0] - force[0]).abs() < 1e-6 * scale, "{slope:?} {force:?}");
            assert!((slope[1] - force[1]).abs() < 1e-6 * scale, "{slope:?} {force:?}");
        }
    }

    #[test]
    fn the_waves_add_up_to_the_tractions() {
        let row = row(1.3);
        let edge = Edge { place: [0.2, -0.5], burgers: [0.6, -0.8] };
        for level in [-0.1, -0.8] {
            for x in [0.05, 0.21, 0.9] {
                let mut sum = [0.0; 2];
                for m in 1..120 {
                    let q = 2.0 * PI * f64::from(m) / 1.3;
                    let wave = row.wave(&edge, level, q);
                    for (sum, amplitude) in sum.iter_mut().zip(wave) {
                        *sum += 2.0 * (amplitude * Complex64::cis(q * x)).re;
                    }
                }
                let stress = row.stress(&edge, [x, level]);
                assert!((sum[0] - stress.xz).abs() < 1e-12, "{sum:?} {stress:?}");
                assert!((sum[1] - stress.zz).abs() < 1e-12, "{sum:?} {stress:?}");
            }
        }
    }

    #[test]
    fn far_away_the_stress_of_a_row_is_uniform() {
        let row = row(1.0);
        let edge = Edge { place: [0.2, 0.0], burgers: [0.6, -0.8] };
        let (above, below) = (row.stress(&edge, [0.7, 300.0]), row.stress(&edge, [0.1, -300.0]));
        assert!((above.xx - row.uniform_stress(edge.burgers)).abs() < 1e-15 && (above.xx + below.xx).abs() < 1e-15);
        assert!(above.zz.abs() + above.xz.abs() + below.zz.abs() + below.xz.abs() < 1e-14);
    }
}
