//! Closed forms of a slab of finite height on rigid ground at one wavenumber.

use crate::{Blocks, Condition, Ground, Material, hyperbolic::Hyperbolic};

/// Layer at one wavenumber q > 0.
pub(crate) struct LayerMode<'a> {
    pub(crate) material: &'a Material,
    pub(crate) q: f64,
    pub(crate) t: Hyperbolic,
}

/// Closed forms on ground that fixes one of u_long and u_z. Fixed u_z gives the mirror-symmetric mode of a plate of
/// twice the height, fixed u_long the antisymmetric mode (theory.md, section 4).
struct Mixed {
    /// Denominator of the compliance, sinh h cosh h ± h, in units of E* q/2.
    determinant: f64,
    /// Denominator of the stiffness, sinh h cosh h ∓ r h.
    of_stiffness: f64,
    /// Numerator of the compliance; in the stiffness, `longitudinal` and `normal` are exchanged.
    longitudinal: f64,
    normal: f64,
    coupling: f64,
    /// Transverse stiffness divided by its unit, and the inverse.
    transverse: [f64; 2],
}

impl<'a> LayerMode<'a> {
    #[inline]
    pub(crate) fn new(material: &'a Material, thickness: f64, q: f64) -> Self {
        Self { material, q, t: Hyperbolic::new(q * thickness) }
    }

    /// Returns the unit of the sagittal stiffness, P(q) = 2 C44 q/(1 + s).
    pub(crate) fn unit(&self) -> f64 {
        self.material.shear_modulus() * self.q * self.material.sagittal_unit()
    }

    /// Returns the unit of the transverse stiffness, C44 q.
    pub(crate) fn shear_unit(&self) -> f64 {
        self.material.shear_modulus() * self.q
    }

    /// Returns the normal stiffness of the half-space, E* q/2 = P (1 − s²).
    fn contact_unit(&self) -> f64 {
        0.5 * self.material.contact_modulus() * self.q
    }

    /// Returns the determinant D = sinh² h − r² h².
    pub(crate) fn bonded_determinant(&self) -> f64 {
        let (m, t) = (self.material, &self.t);
        (m.one_minus_r() * t.h + t.sinh_minus_h) * (m.one_plus_r() * t.h + t.sinh_minus_h)
    }

    /// Returns the numerators sinh h cosh h ∓ r h.
    fn bonded_numerators(&self) -> [f64; 2] {
        let (m, t) = (self.material, &self.t);
        [m.one_minus_r(), m.one_plus_r()].map(|factor| factor * t.h_twice_scaled + t.sinh_cosh_minus_h)
    }

    /// Returns the numerator of the coupling, s sinh² h − r² (1 + s) h².
    fn bonded_coupling(&self) -> f64 {
        let (m, t) = (self.material, &self.t);
        t.h * t.h * ((1.0 - 4.0 * m.poisson()) * m.r()) + m.s() * t.sinh_minus_h * (2.0 * t.h + t.sinh_minus_h)
    }

    /// Returns the determinant N = 1 + (1 − s²) sinh² h + (1 − s)² h².
    fn full_determinant(&self) -> f64 {
        let (m, t) = (self.material, &self.t);
        let stretched = m.one_minus_s() * t.h;
        t.factor * t.factor + m.one_minus_s_squared() * t.sinh * t.sinh + stretched * stretched
    }

    /// Returns the stiffness at the top of a slab on `ground`.
    pub(crate) fn stiffness_over(&self, ground: Ground) -> Blocks {
        match (ground.lateral, ground.normal) {
            (Condition::Fixed, Condition::Fixed) => self.bonded_stiffness(),
            (Condition::Free, Condition::Free) => self.free_stiffness(),
            (Condition::Free, Condition::Fixed) | (Condition::Fixed, Condition::Free) => self.mixed_stiffness(ground),
        }
    }

    /// Returns the compliance at the top of a slab on `ground`.
    pub(crate) fn compliance_over(&self, ground: Ground) -> Blocks {
        match (ground.lateral, ground.normal) {
            (Condition::Fixed, Condition::Fixed) => self.bonded_compliance(),
            (Condition::Free, Condition::Free) => self.free_compliance(),
            (Condition::Free, Condition::Fixed) | (Condition::Fixed, Condition::Free) => self.mixed_compliance(ground),
        }
    }

    /// Returns the normal compliance at the top of a slab on `ground`, without shear traction at the top.
    #[inline]
    pub(crate) fn normal_compliance_over(&self, ground: Ground) -> f64 {
        match (ground.lateral, ground.normal) {
            (Condition::Fixed, Condition::Fixed) => self.bonded_normal_compliance(),
            (Condition::Free, Condition::Free) => self.free_normal_compliance(),
            (Condition::Free, Condition::Fixed) | (Condition::Fixed, Condition::Free) => {
                let Mixed { determinant, normal, .. } = self.mixed(ground);
                normal / determinant / self.contact_unit()
            }
        }
    }

    /// Returns the stiffness on a bonded base, u = 0 (theory.md, section 1).
    pub(crate) fn bonded_stiffness(&self) -> Blocks {
        // Quotients first: at tiny h, the product of numerator and unit would underflow.
        let (determinant, unit) = (self.bonded_determinant(), self.unit());
        let [longitudinal, normal] = self.bonded_numerators().map(|n| unit * (n / determinant));
        let coupling = unit * (self.bonded_coupling() / determinant);
        Blocks::hermitian(longitudinal, coupling, normal, self.shear_unit() * self.t.coth())
    }

    fn bonded_compliance(&self) -> Blocks {
        let (determinant, unit) = (self.full_determinant(), self.unit());
        let [normal, longitudinal] = self.bonded_numerators().map(|n| n / determinant / unit);
        let coupling = -self.bonded_coupling() / determinant / unit;
        Blocks::hermitian(longitudinal, coupling, normal, self.t.tanh() / self.shear_unit())
    }

    #[inline]
    fn bonded_normal_compliance(&self) -> f64 {
        self.bonded_numerators()[0] / self.full_determinant() / self.unit()
    }

    /// Returns the closed forms on ground that fixes one of u_long and u_z.
    #[inline]
    fn mixed(&self, ground: Ground) -> Mixed {
        let (m, t) = (self.material, &self.t);
        let [sinh, cosh] = [t.sinh * t.sinh, t.cosh * t.cosh];
        let (bonded, s) = (self.bonded_numerators(), m.s() * t.sinh_cosh_minus_h);
        match ground.lateral {
            Condition::Free => Mixed {
                determinant: t.sinh_cosh_plus_h(),
                of_stiffness: bonded[0],
                longitudinal: cosh,
                normal: sinh,
                // s sinh h cosh h − (1 − s) h, with 2s − 1 = −ν/(1 − ν).
                coupling: s - m.poisson() / (1.0 - m.poisson()) * t.h_twice_scaled,
                transverse: [t.tanh(), t.coth()],
            },
            Condition::Fixed => Mixed {
                determinant: t.sinh_cosh_minus_h,
                of_stiffness: bonded[1],
                longitudinal: sinh,
                normal: cosh,
                // s sinh h cosh h + (1 − s) h.
                coupling: s + t.h_twice_scaled,
                transverse: [t.coth(), t.tanh()],
            },
        }
    }

    /// Returns the stiffness on ground that fixes one of u_long and u_z: the inverse of [`Self::mixed_compliance`].
    fn mixed_stiffness(&self, ground: Ground) -> Blocks {
        let (mixed, unit) = (self.mixed(ground), self.unit());
        let stiffness = |n: f64| unit * (n / mixed.of_stiffness);
        let transverse = self.shear_unit() * mixed.transverse[0];
        Blocks::hermitian(stiffness(mixed.normal), stiffness(mixed.coupling), stiffness(mixed.longitudinal), transverse)
    }

    fn mixed_compliance(&self, ground: Ground) -> Blocks {
        let Mixed { determinant, longitudinal, normal, coupling, transverse, .. } = self.mixed(ground);
        let determinant = determinant * self.contact_unit();
        let transverse = transverse[1] / self.shear_unit();
        Blocks::hermitian(longitudinal / determinant, -coupling / determinant, normal / determinant, transverse)
    }

    /// Returns the numerator of the coupling, s sinh² h + (1 − s) h².
    fn free_coupling(&self) -> f64 {
        let (m, t) = (self.material, &self.t);
        m.s() * t.sinh * t.sinh + m.one_minus_s() * t.h * t.h
    }

    /// Returns the stiffness of a plate, without traction on the base: the inverse of [`Self::free_compliance`], with
    /// the determinant N/(sinh² h − h²) (theory.md, section 4).
    fn free_stiffness(&self) -> Blocks {
        let t = &self.t;
        let factor = self.contact_unit() / self.full_determinant();
        Blocks::hermitian(
            factor * t.sinh_cosh_plus_h(),
            factor * self.free_coupling(),
            factor * t.sinh_cosh_minus_h,
            self.shear_unit() * t.tanh(),
        )
    }

    /// Returns the compliance of a plate: half the sum of the compliances of its mirror-symmetric and antisymmetric
    /// modes. All diagonal terms are positive, so nothing cancels in a thin plate.
    fn free_compliance(&self) -> Blocks {
        let t = &self.t;
        let determinant = self.free_determinant();
        Blocks::hermitian(
            t.sinh_cosh_minus_h / determinant,
            -self.free_coupling() / determinant,
            t.sinh_cosh_plus_h() / determinant,
            t.coth() / self.shear_unit(),
        )
    }

    #[inline]
    fn free_normal_compliance(&self) -> f64 {
        self.t.sinh_cosh_plus_h() / self.free_determinant()
    }

    /// Returns the determinant (E* q/2)(sinh² h − h²).
    fn free_determinant(&self) -> f64 {
        self.contact_unit() * self.t.sinh_minus_h * (2.0 * self.t.h + self.t.sinh_minus_h)
    }
}
