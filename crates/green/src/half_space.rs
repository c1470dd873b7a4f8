//! Half-space at one wavenumber q > 0: the limit of a slab for q·height → ∞ (theory.md, section 3).

use crate::{Blocks, Material};

pub(crate) fn stiffness(material: &Material, q: f64) -> Blocks {
    let shear = material.shear_modulus() * q;
    let unit = shear * material.sagittal_unit();
    Blocks::hermitian(unit, unit * material.s(), unit, shear)
}

pub(crate) fn compliance(material: &Material, q: f64) -> Blocks {
    let normal = normal_compliance(material, q);
    Blocks::hermitian(normal, -normal * material.s(), normal, 1.0 / (material.shear_modulus() * q))
}

/// Returns the frictionless normal compliance 2/(E* q).
#[inline]
pub(crate) fn normal_compliance(material: &Material, q: f64) -> f64 {
    2.0 / (material.contact_modulus() * q)
}

/// Returns the displacement at depth ζ per displacement of the surface, with b = q ζ (theory.md, section 5).
pub(crate) fn transfer(material: &Material, b: f64) -> Blocks {
    let decay = (-b).exp();
    let bent = if decay > 0.0 { material.r() * b * decay } else { 0.0 };
    Blocks { longitudinal: decay - bent, normal: decay + bent, transverse: decay, coupling: [bent; 2] }
}
