use crate::{Law, LawError, MixedMode, Response, Separation};

/// The exponential law of van den Bosch, Schreurs and Geers (2006). The works of opening and sliding are independent,
/// but a potential exists only if they are equal. The law is meant for tension: at an over-closure above δ_n the shear
/// traction drives the sliding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoschSchreursGeers {
    separation: Separation,
}

impl BoschSchreursGeers {
    /// Creates the law with the given works and lengths.
    ///
    /// # Errors
    /// Returns an error if a work or a length is not positive.
    pub fn new(separation: Separation) -> Result<Self, LawError> {
        Ok(Self { separation: separation.check()? })
    }
}

impl Law for BoschSchreursGeers {
    fn response(&self, normal: f64, sliding: f64) -> Response {
        let [x, y] = self.separation.reduce(normal, sliding);
        let decay = (-x - y * y).exp();
        let secant = 2.0 * (1.0 + x) * decay;
        let coupling = -2.0 * x * y * decay;
        self.separation.scale(
            [x * decay, secant * y],
            [[(1.0 - x) * decay, coupling], [coupling, secant * (1.0 - 2.0 * y * y)]],
            secant,
        )
    }

    fn energy(&self, normal: f64, sliding: f64) -> Option<f64> {
        let Separation { normal_work, tangential_work, .. } = self.separation;
        let [x, y] = self.separation.reduce(normal, sliding);
        (normal_work == tangential_work).then(|| -normal_work * (1.0 + x) * (-x - y * y).exp())
    }

    fn opening_energy(&self, normal: f64) -> f64 {
        self.separation.opening_energy(normal)
    }

    fn stiffness_bound(&self, lowest: f64) -> f64 {
        let x0 = (lowest / self.separation.normal_length).min(0.0);
        let e0 = (-x0).exp();
        let coupling = 2.0 * (-x0 * e0).max((-1.0_f64).exp()) * LARGEST_Y_GAUSS;
        // The maximum of |1 + x| e^{−x} is 1, or the value at x₀ if x₀ < −1.
        self.separation.bound([[(1.0 - x0) * e0, coupling], [coupling, 2.0 * ((-1.0 - x0) * e0).max(1.0)]])
    }

    fn mixed_mode(&self) -> Option<MixedMode> {
        Some(MixedMode {
            independent_works: true,
            resists_sliding: false,
            keeps_repulsion: false,
            holds_under_pressure: false,
            vanishes: true,
            continuous: true,
        })
    }
}

/// Maximum of y e^{−y²}, 1/√(2e) at y = 1/√2.
pub(crate) const LARGEST_Y_GAUSS: f64 = 0.428_881_942_480_353_4;
