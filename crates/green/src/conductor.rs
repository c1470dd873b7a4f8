use crate::{Body, GreenError, Height, Material};

/// Conductor of heat or electric current with unit conductivity and a current through the surface: a half-space, or a
/// slab on an electrode of potential zero.
///
/// Conduction and anti-plane shear both obey Laplace's equation: potential corresponds to displacement, current density
/// to traction, conductivity to shear modulus. A conductor is therefore a bonded [`Body`] of shear modulus 1, and its
/// resistance is the [transverse compliance](Body::transverse_compliance) (theory.md, section 7.6).
#[derive(Clone, Debug, PartialEq)]
pub struct Conductor(Body);

impl Conductor {
    /// Creates a conductor with the electrode at the depth `height` (length), or infinitely deep.
    ///
    /// # Errors
    /// Returns an error if the height of a slab is not positive and finite.
    pub fn new(height: Height) -> Result<Self, GreenError> {
        // At zero Poisson's ratio, a half-space has equal transverse and normal compliance: 1/(C44 q) = 2/(E* q).
        Ok(Self(Body::new(Material::from_young(2.0, 0.0)?, height)?))
    }

    /// Converts the conductor to another unit of length, given in the current unit.
    #[must_use]
    pub fn in_units(&self, length: f64) -> Self {
        Self(self.0.in_units(1.0, length))
    }

    /// Returns the surface potential divided by a current density of wavenumber `q` (rad/length), in length: tanh(q
    /// H)/q on an electrode at depth H, 1/q on a half-space. At q = 0, it is H, the bulk resistance.
    pub fn resistance(&self, q: f64) -> f64 {
        self.0.transverse_compliance(q)
    }

    /// Returns the elastic body with anti-plane shear equivalent to the conduction.
    pub fn body(&self) -> &Body {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_resistance_is_that_of_laplaces_equation() {
        let half_space = Conductor::new(Height::Infinite).unwrap();
        for height in [1e-3, 0.07, 1.0, 50.0] {
            let slab = Conductor::new(Height::Finite(height)).unwrap();
            for q in [1e-6, 0.3, 6.0, 800.0, 1e9] {
                approx::assert_relative_eq!(slab.resistance(q), (q * height).tanh() / q, max_relative = 1e-14);
                approx::assert_relative_eq!(half_space.resistance(q), 1.0 / q, max_relative = 1e-14);
                let scaled = slab.in_units(8.0).resistance(8.0 * q);
                approx::assert_relative_eq!(8.0 * scaled, slab.resistance(q), max_relative = 1e-14);
            }
            approx::assert_relative_eq!(slab.resistance(0.0), height, max_relative = 1e-15);
        }
        assert_eq!(half_space.resistance(0.0), f64::INFINITY);
        assert_eq!(Conductor::new(Height::Finite(-1.0)), Err(GreenError::Height(-1.0)));
    }
}
