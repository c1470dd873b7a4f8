use gfmd_green::Material;

/// Returns the ratio of bulk to shear modulus.
pub(crate) fn bulk(material: &Material) -> f64 {
    let nu = material.poisson();
    2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))
}
