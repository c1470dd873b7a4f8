use std::sync::Arc;

use crate::{Law, MixedMode, Opening, Response};

/// A law in other units of stress and length, given in its own. Powers of two keep every digit.
#[derive(Clone, Debug)]
pub struct InUnits {
    law: Arc<dyn Law>,
    stress: f64,
    length: f64,
}

impl InUnits {
    /// The `law` in the given units.
    pub fn new(law: Arc<dyn Law>, stress: f64, length: f64) -> Self {
        Self { law, stress, length }
    }

    fn energy_of(&self, energy: f64) -> f64 {
        energy / self.stress / self.length
    }

    fn stiffness_of(&self, stiffness: f64) -> f64 {
        stiffness / self.stress * self.length
    }
}

impl Law for InUnits {
    fn response(&self, normal: f64, sliding: f64) -> Response {
        let Response { traction, jacobian, secant } = self.law.response(normal * self.length, sliding * self.length);
        Response {
            traction: traction.map(|t| t / self.stress),
            jacobian: jacobian.map(|row| row.map(|entry| self.stiffness_of(entry))),
            secant: self.stiffness_of(secant),
        }
    }

    fn energy(&self, normal: f64, sliding: f64) -> Option<f64> {
        self.law.energy(normal * self.length, sliding * self.length).map(|energy| self.energy_of(energy))
    }

    fn opening_energy(&self, normal: f64) -> f64 {
        self.energy_of(self.law.opening_energy(normal * self.length))
    }

    fn opening(&self, normal: f64) -> Opening {
        let Opening { energy, traction, slope } = self.law.opening(normal * self.length);
        Opening { energy: self.energy_of(energy), traction: traction / self.stress, slope: self.stiffness_of(slope) }
    }

    fn has_wall(&self) -> bool {
        self.law.has_wall()
    }

    fn stiffness_bound(&self, lowest: f64) -> f64 {
        self.stiffness_of(self.law.stiffness_bound(lowest * self.length))
    }

    fn steepness(&self) -> f64 {
        self.stiffness_of(self.law.steepness())
    }

    fn resolving_points(&self) -> f64 {
        self.law.resolving_points()
    }

    fn mixed_mode(&self) -> Option<MixedMode> {
        self.law.mixed_mode()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Kind, Parameter};

    /// A law and its parameters, both in other units, are the same function.
    #[test]
    fn units_of_the_law_and_of_its_parameters_agree_to_the_bit() {
        let (stress, length) = (2.0_f64.powi(80), 2.0_f64.powi(-60));
        for kind in Kind::ALL {
            let in_unit = |p: &Parameter| match p.units {
                "stress*length" => stress * length,
                "length" => length,
                "stress/length" => stress / length,
                _ => 1.0,
            };
            let values = |scale: bool| -> Vec<(&'static str, f64)> {
                let one = |(k, p): (usize, &Parameter)| {
                    (p.name, (0.5 + 0.25 * k as f64) * if scale { in_unit(p) } else { 1.0 })
                };
                kind.parameters().iter().enumerate().map(one).collect()
            };
            let plain = kind.with(&values(false)).unwrap();
            let scaled = InUnits::new(kind.with(&values(true)).unwrap().into_shared(), stress, length);
            for (normal, sliding) in [(0.0, 0.0), (0.3, 0.2), (1.7, -0.4), (-0.2, 0.1)] {
                assert_eq!(scaled.response(normal, sliding), plain.response(normal, sliding), "{}", kind.name());
                assert_eq!(scaled.energy(normal, sliding), plain.energy(normal, sliding), "{}", kind.name());
                assert_eq!(scaled.opening_energy(normal), plain.opening_energy(normal), "{}", kind.name());
                assert_eq!(scaled.opening(normal), plain.opening(normal), "{}", kind.name());
                assert_eq!(scaled.stiffness_bound(normal), plain.stiffness_bound(normal), "{}", kind.name());
            }
            assert_eq!((scaled.steepness(), scaled.has_wall()), (plain.steepness(), plain.has_wall()));
            assert_eq!(scaled.mixed_mode(), plain.mixed_mode());
        }
    }
}
