//! A slab of finite height at one wavenumber, on rigid ground, in closed form.

use crate::{Blocks, Condition, Ground, Material, hyperbolic::Hyperbolic};

/// One layer at one wavenumber q > 0.
pub(crate) struct LayerMode<'a> {
    pub(crate) material: &'a Material,
    pub(crate) q: f64,
    pub(crate) t: Hyperbolic,
}

/// Numerators on ground that fixes one of u_long and u_z: for u_z the mirror-symmetric mode of a plate of twice the
/// height, for u_long its antisymmetric mode (theory.md, section 4).
struct Mixed {
    /// The denominator of the compliance, sinh h cosh h ± h, in units of E* q/2.
    determinant: f64,
    /// The denominator of the stiffness, sinh h cosh h ∓ r h.
    of_stiffness: f64,
    /// Of the compliance; of the stiffness it is that of the other component.
    longitudinal: f64,
    normal: f64,
    coupling: f64,
    /// The transverse stiffness over its unit, and its inverse.
    transverse: [f64; 2],
}

impl<'a> LayerMode<'a> {
    #[inline]
    pub(crate) fn new(material: &'a Material, thickness: f64, q: f64) -> Self {
        Self { material, q, t: Hyperbolic::new(q * thickness) }
    }

    /// The unit of the sagittal stiffness, P(q) = 2 C44 q/(1 + s).
    pub(crate) fn unit(&self) -> f64 {
        self.material.shear_modulus() * self.q * self.material.sagittal_unit()
    }

    /// The unit of the transverse stiffness, C44 q.
    pub(crate) fn shear_unit(&self) -> f64 {
        self.material.shear_modulus() * self.q
    }

    /// The normal stiffness of the half-space, E* q/2 = P (1 − s²).
    fn contact_unit(&self) -> f64 {
        0.5 * self.material.contact_modulus() * self.q
    }

    /// The determinant D = sinh² h − r² h².
    pub(crate) fn bonded_determinant(&self) -> f64 {
        let (m, t) = (self.material, &self.t);
        (m.one_minus_r() * t.h + t.sinh_minus_h) * (m.one_plus_r() * t.h + t.sinh_minus_h)
    }

    /// The numerators sinh h cosh h ∓ r h.
    fn bonded_numerators(&self) -> [f64; 2] {
        let (m, t) = (self.material, &self.t);
        [m.one_minus_r(), m.one_plus_r()].map(|factor| factor * t.h_twice_scaled + t.sinh_cosh_minus_h)
    }

    /// The numerator of the coupling, s sinh² h − r² (1 + s) h².
    fn bonded_coupling(&self) -> f64 {
        let (m, t) = (self.material, &self.t);
        t.h * t.h * ((1.0 - 4.0 * m.poisson()) * m.r()) + m.s() * t.sinh_minus_h * (2.0 * t.h + t.sinh_minus_h)
    }

    /// The determinant N = 1 + (1 − s²) sinh² h + (1 − s)² h².
    fn full_determinant(&self) -> f64 {
        let (m, t) = (self.material, &self.t);
        let stretched = m.one_minus_s() * t.h;
        t.factor * t.factor + m.one_minus_s_squared() * t.sinh * t.sinh + stretched * stretched
    }

    /// The stiffness at the top of a slab on `ground`.
    pub(crate) fn stiffness_over(&self, ground: Ground) -> Blocks {
        match (ground.lateral, ground.normal) {
            (Condition::Fixed, Condition::Fixed) => self.bonded_stiffness(),
            (Condition::Free, Condition::Free) => self.free_stiffness(),
            (Condition::Free, Condition::Fixed) | (Condition::Fixed, Condition::Free) => self.mixed_stiffness(ground),
        }
    }

    /// The compliance at the top of a slab on `ground`.
    pub(crate) fn compliance_over(&self, ground: Ground) -> Blocks {
        match (ground.lateral, ground.normal) {
            (Condition::Fixed, Condition::Fixed) => self.bonded_compliance(),
            (Condition::Free, Condition::Free) => self.free_compliance(),
            (Condition::Free, Condition::Fixed) | (Condition::Fixed, Condition::Free) => self.mixed_compliance(ground),
        }
    }

    /// The normal compliance at the top of a slab on `ground`, without shear traction there.
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

    /// The stiffness on a bonded base, u = 0 (theory.md, section 1).
    pub(crate) fn bonded_stiffness(&self) -> Blocks {
        // Quotients first: at tiny h the product of numerator and unit would underflow.
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

    /// The closed forms on ground that fixes one of u_long and u_z.
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

    /// The stiffness on ground that fixes one of u_long and u_z: the inverse of [`Self::mixed_compliance`].
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

    /// The numerator of the coupling, s sinh² h + (1 − s) h².
    fn free_coupling(&self) -> f64 {
        let (m, t) = (self.material, &self.t);
        m.s() * t.sinh * t.sinh + m.one_minus_s() * t.h * t.h
    }

    /// The stiffness of a plate, whose base bears no traction: the inverse of [`Self::free_compliance`], with the
    /// determinant N over sinh² h − h² (theory.md, section 4).
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

    /// The compliance of a plate: half the sum of the compliances of its mirror-symmetric and its antisymmetric mode.
    /// The diagonal has positive terms only, so that nothing cancels in a thin plate.
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

    /// The determinant (E* q/2)(sinh² h − h²).
    fn free_determinant(&self) -> f64 {
        self.contact_unit() * self.t.sinh_minus_h * (2.0 * self.t.h + self.t.sinh_minus_h)
    }
}
