//! A slab of finite height at one wavenumber, on each of the bases that have a closed form.

use crate::{Blocks, Material, hyperbolic::Hyperbolic};

/// One layer at one wavenumber q > 0.
pub(crate) struct LayerMode<'a> {
    pub(crate) material: &'a Material,
    pub(crate) q: f64,
    pub(crate) t: Hyperbolic,
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

    /// The stiffness on a bonded base, u = 0 (theory.md, section 1).
    pub(crate) fn bonded_stiffness(&self) -> Blocks {
        // Quotients first: at tiny h the product of numerator and unit would underflow.
        let (determinant, unit) = (self.bonded_determinant(), self.unit());
        let [longitudinal, normal] = self.bonded_numerators().map(|n| unit * (n / determinant));
        let coupling = unit * (self.bonded_coupling() / determinant);
        Blocks::hermitian(longitudinal, coupling, normal, self.shear_unit() * self.t.coth())
    }

    pub(crate) fn bonded_compliance(&self) -> Blocks {
        let (determinant, unit) = (self.full_determinant(), self.unit());
        let [normal, longitudinal] = self.bonded_numerators().map(|n| n / determinant / unit);
        let coupling = -self.bonded_coupling() / determinant / unit;
        Blocks::hermitian(longitudinal, coupling, normal, self.t.tanh() / self.shear_unit())
    }

    #[inline]
    pub(crate) fn bonded_normal_compliance(&self) -> f64 {
        self.bonded_numerators()[0] / self.full_determinant() / self.unit()
    }

    /// The numerator of the coupling, s sinh h cosh h − (1 − s) h, with 2s − 1 = −ν/(1 − ν).
    fn sliding_coupling(&self) -> f64 {
        let (m, t) = (self.material, &self.t);
        m.s() * t.sinh_cosh_minus_h - m.poisson() / (1.0 - m.poisson()) * t.h_twice_scaled
    }

    /// The stiffness on a frictionless rigid base, u_z = 0 and no shear traction (theory.md, section 4).
    pub(crate) fn sliding_stiffness(&self) -> Blocks {
        let t = &self.t;
        let (determinant, unit) = (self.bonded_numerators()[0], self.unit());
        let stiffness = |n: f64| unit * (n / determinant);
        Blocks::hermitian(
            stiffness(t.sinh * t.sinh),
            stiffness(self.sliding_coupling()),
            stiffness(t.cosh * t.cosh),
            self.shear_unit() * t.tanh(),
        )
    }

    pub(crate) fn sliding_compliance(&self) -> Blocks {
        let t = &self.t;
        let determinant = t.sinh_cosh_plus_h() * self.contact_unit();
        Blocks::hermitian(
            t.cosh * t.cosh / determinant,
            -self.sliding_coupling() / determinant,
            t.sinh * t.sinh / determinant,
            t.coth() / self.shear_unit(),
        )
    }

    #[inline]
    pub(crate) fn sliding_normal_compliance(&self) -> f64 {
        let t = &self.t;
        t.sinh * t.sinh / t.sinh_cosh_plus_h() / self.contact_unit()
    }

    /// The normal compliance of the upper half of a plate that bends: u_x = 0 and no normal traction on the mid-plane
    /// (theory.md, section 4).
    pub(crate) fn bending_normal_compliance(&self) -> f64 {
        let t = &self.t;
        t.cosh * t.cosh / t.sinh_cosh_minus_h / self.contact_unit()
    }

    /// The numerator of the coupling, s sinh² h + (1 − s) h².
    fn free_coupling(&self) -> f64 {
        let (m, t) = (self.material, &self.t);
        m.s() * t.sinh * t.sinh + m.one_minus_s() * t.h * t.h
    }

    /// The stiffness of a plate, whose base bears no traction: the inverse of [`Self::free_compliance`], with the determinant
    /// N over sinh² h − h² (theory.md, section 4).
    pub(crate) fn free_stiffness(&self) -> Blocks {
        let t = &self.t;
        let factor = self.contact_unit() / self.full_determinant();
        Blocks::hermitian(
            factor * t.sinh_cosh_plus_h(),
            factor * self.free_coupling(),
            factor * t.sinh_cosh_minus_h,
            self.shear_unit() * t.tanh(),
        )
    }

    /// The compliance of a plate: half the sum of the compliances of its mirror-symmetric and its antisymmetric mode. The
    /// diagonal has positive terms only, so that nothing cancels in a thin plate.
    pub(crate) fn free_compliance(&self) -> Blocks {
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
    pub(crate) fn free_normal_compliance(&self) -> f64 {
        self.t.sinh_cosh_plus_h() / self.free_determinant()
    }

    /// The determinant (E* q/2)(sinh² h − h²).
    fn free_determinant(&self) -> f64 {
        self.contact_unit() * self.t.sinh_minus_h * (2.0 * self.t.h + self.t.sinh_minus_h)
    }
}
