use std::sync::Arc;

use crate::{Law, MixedMode, Opening, Response};

/// A law in other units of stress and length. The new units are expressed in the units of the law; powers of two keep
/// every digit.
#[derive(Clone, Debug)]
pub struct InUnits {
    law: Arc<dyn Law>,
    stress: f64,
    length: f64,
}

impl InUnits {
    /// Converts `law` to the given units.
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
