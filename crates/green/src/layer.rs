//! One layer with two faces: what moves and pulls at its top, told from what moves and pulls at its bottom.

use crate::{Blocks, slab::LayerMode};

/// Stiffness at the top of a layer that stands on something elastic, and how much of the top's displacement arrives at
/// the bottom.
pub(crate) struct Bonded {
    pub(crate) stiffness: Blocks,
    /// u(bottom) = transfer · u(top).
    pub(crate) transfer: Blocks,
}

/// A 2 × 2 matrix [[a, i b], [i c, d]] is [[a, b], [−c, d]] for u_z = −i w, σ_zz = −i τ: real throughout.
type Real2 = [[f64; 2]; 2];

impl LayerMode<'_> {
    /// Traction on the top of displacement of the bottom, L_tb (theory.md, section 4).
    pub(crate) fn cross_stiffness(&self) -> Blocks {
        let (m, t) = (self.material, &self.t);
        let rh = m.r() * t.raw;
        let [minus, plus] = if t.raw < 1.0 {
            let half = (0.5 * t.raw).sinh();
            let curved = t.sinh_minus_h - rh * 2.0 * half * half;
            let other = t.sinh_minus_h + rh * 2.0 * half * half;
            [m.one_minus_r() * t.h + curved, m.one_plus_r() * t.h + other]
        } else {
            [t.sinh - rh * t.cosh, t.sinh + rh * t.cosh]
        };
        let (determinant, unit) = (self.bonded_determinant(), self.unit());
        let cross = |n: f64| -unit * (t.one * n / determinant);
        let coupling = cross(-rh * t.sinh);
        Blocks {
            longitudinal: cross(minus),
            normal: cross(plus),
            transverse: -self.shear_unit() * t.csch(),
            coupling: [coupling; 2],
        }
    }

    /// The layer bonded to something of stiffness `support` (Hermitian).
    pub(crate) fn on(&self, support: &Blocks) -> Bonded {
        if self.t.raw < 1.0 { self.thin_on(support) } else { self.thick_on(support) }
    }

    /// K_top = L_tt − L_tb (L_bb + K_below)⁻¹ L_bt: every term decays with h (theory.md, section 4).
    fn thick_on(&self, support: &Blocks) -> Bonded {
        let face = self.bonded_stiffness();
        let cross = self.cross_stiffness();
        let top = real(&face);
        let bottom = add(real(&mirrored(&face)), real(support));
        // L_bt = L_tb†: its coupling changes sign, and that of the real form with it.
        let up = real(&cross);
        let down = transposed(up);
        let sagittal = times(inverse(bottom), down).map(|row| row.map(|entry| -entry));
        let stiffness = add(top, times(up, sagittal));
        let bottom_transverse = face.transverse + support.transverse;
        let transverse = -cross.transverse / bottom_transverse;
        Bonded {
            stiffness: hermitian(stiffness, face.transverse + cross.transverse * transverse),
            transfer: general(sagittal, transverse),
        }
    }

    /// The same by the propagator from bottom to top, which has no term that grows as the layer thins: L does, like
    /// 1/h, and the difference above would lose as much.
    ///
    /// With B = A² − 1, B² = 0 of the equation of equilibrium d/d(qz) (a, w, σ, τ) = A (a, w, σ, τ):
    /// exp(h A) = cosh h + A sinh h + B (h/2) sinh h + A B (h cosh h − sinh h)/2.
    fn thin_on(&self, support: &Blocks) -> Bonded {
        let unit = self.shear_unit();
        let [uu, us, su, ss] = self.propagator();
        let below = real(support).map(|row| row.map(|entry| entry / unit));
        let displacement = add(uu, times(us, below));
        let traction = add(su, times(ss, below));
        let transfer = inverse(displacement);
        let sagittal = times(traction, transfer).map(|row| row.map(|entry| entry * unit));

        let (sinh, cosh) = (self.t.sinh, self.t.cosh);
        let below = support.transverse / unit;
        let displacement = cosh + sinh * below;
        Bonded {
            stiffness: hermitian(sagittal, unit * (sinh + cosh * below) / displacement),
            transfer: general(transfer, 1.0 / displacement),
        }
    }

    /// From (u, σ/(C44 q)) at the bottom to the same at the top, in the real form, of a thin layer: the blocks uu, us,
    /// su, ss.
    pub(crate) fn propagator(&self) -> [Real2; 4] {
        let (h, s, k) = (self.t.raw, self.material.s(), self.material.one_minus_s());
        let (sinh, cosh) = (self.t.sinh, self.t.cosh);
        let p = 0.5 * k * h * sinh;
        let cosh_minus_one = 2.0 * (0.5 * h).sinh().powi(2);
        let g = 0.5 * k * (h * cosh_minus_one - self.t.sinh_minus_h);
        let e = 1.0 - 2.0 * s;
        [
            [[cosh + 2.0 * p, -sinh - 2.0 * g], [e * sinh + 2.0 * g, cosh - 2.0 * p]],
            [[sinh + g, -p], [p, s * sinh - g]],
            [[4.0 * (k * sinh + g), -4.0 * p], [4.0 * p, -4.0 * g]],
            [[cosh + 2.0 * p, -e * sinh - 2.0 * g], [sinh + 2.0 * g, cosh - 2.0 * p]],
        ]
    }
}

/// The same matrix seen from below, z and σ_zz mirrored: J K J with J = diag(1, −1).
pub(crate) fn mirrored(blocks: &Blocks) -> Blocks {
    Blocks { coupling: blocks.coupling.map(|c| -c), ..*blocks }
}

fn real(blocks: &Blocks) -> Real2 {
    let [lz, zl] = blocks.coupling;
    [[blocks.longitudinal, lz], [-zl, blocks.normal]]
}

fn general(real: Real2, transverse: f64) -> Blocks {
    let [[longitudinal, lz], [zl, normal]] = real;
    Blocks { longitudinal, normal, transverse, coupling: [lz, -zl] }
}

/// Of a matrix that is Hermitian but for rounding.
fn hermitian(real: Real2, transverse: f64) -> Blocks {
    Blocks::hermitian(real[0][0], 0.5 * (real[0][1] + real[1][0]), real[1][1], transverse)
}

fn times(a: Real2, b: Real2) -> Real2 {
    a.map(|row| [0, 1].map(|column| row[0] * b[0][column] + row[1] * b[1][column]))
}

fn add(a: Real2, b: Real2) -> Real2 {
    [0, 1].map(|row| [0, 1].map(|column| a[row][column] + b[row][column]))
}

fn transposed(a: Real2) -> Real2 {
    [[a[0][0], a[1][0]], [a[0][1], a[1][1]]]
}

fn inverse(a: Real2) -> Real2 {
    let determinant = a[0][0] * a[1][1] - a[0][1] * a[1][0];
    [[a[1][1] / determinant, -a[0][1] / determinant], [-a[1][0] / determinant, a[0][0] / determinant]]
}
