use crate::bosch_schreurs_geers::LARGEST_Y_GAUSS;
use crate::{Law, LawError, MixedMode, Response, Separation};

/// The potential of Xu and Needleman (1993). q = φ_t/φ_n couples the modes; r = Δ_n*/δ_n is the opening after complete
/// sliding without normal traction.
///
/// With q = 1 the law behaves well in tension. With q ≠ 1 a normal traction remains after complete sliding, and for
/// most parameters the shear traction changes sign under over-closure ([`Law::mixed_mode`] lists the properties).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct XuNeedleman {
    separation: Separation,
    r: f64,
    /// Coefficient (1 − q)/(r − 1).
    a: f64,
    /// Coefficient (r − q)/(r − 1).
    b: f64,
}

impl XuNeedleman {
    /// Creates the law with the given works, lengths and ratio r.
    ///
    /// # Errors
    /// Returns an error if a work or a length is not positive, or if r = 1.
    pub fn new(separation: Separation, r: f64) -> Result<Self, LawError> {
        let separation = separation.check()?;
        if !r.is_finite() || r == 1.0 {
            return Err(LawError::Range { name: "r", found: r, allowed: "a finite number other than 1" });
        }
        let q = separation.tangential_work / separation.normal_work;
        Ok(Self { separation, r, a: (1.0 - q) / (r - 1.0), b: (r - q) / (r - 1.0) })
    }

    fn q(&self) -> f64 {
        self.separation.tangential_work / self.separation.normal_work
    }
}

impl Law for XuNeedleman {
    fn response(&self, normal: f64, sliding: f64) -> Response {
        let Self { separation, r, a, b } = *self;
        let q = self.q();
        let [x, y] = separation.reduce(normal, sliding);
        let (e, gauss) = ((-x).exp(), (-y * y).exp());
        let slid = -(-y * y).exp_m1();
        let secant = 2.0 * e * gauss * (q + b * x) / q;
        let coupling = -2.0 * y * e * gauss * (x - a * (r - x));
        separation.scale(
            [e * (x * gauss + a * (r - x) * slid), secant * y],
            [
                [e * ((1.0 - x) * gauss - a * (r - x + 1.0) * slid), coupling],
                [coupling / q, secant * (1.0 - 2.0 * y * y)],
            ],
            secant,
        )
    }

    fn energy(&self, normal: f64, sliding: f64) -> Option<f64> {
        let Self { separation, r, a, b } = *self;
        let [x, y] = separation.reduce(normal, sliding);
        let (e, gauss) = ((-x).exp(), (-y * y).exp());
        Some(separation.normal_work * e * ((1.0 - r + x) * a - (self.q() + b * x) * gauss))
    }

    fn opening_energy(&self, normal: f64) -> f64 {
        self.separation.opening_energy(normal)
    }

    fn stiffness_bound(&self, lowest: f64) -> f64 {
        let Self { separation, r, a, b } = *self;
        let q = self.q();
        // Upper bound of |c₀ + c₁ x| e^{−x} for x ≥ x₀.
        let x0 = (lowest / separation.normal_length).min(0.0);
        let largest = |c0: f64, c1: f64| (c0.abs() + c1.abs() * x0.abs().max(1.0)) * (-x0).exp();
        let coupling = largest(a * r, b) * LARGEST_Y_GAUSS;
        separation.bound([
            [largest(1.0, 1.0) + largest(a * (r + 1.0), a), 2.0 * coupling],
            [2.0 * coupling / q, 2.0 * largest(q, b) / q],
        ])
    }

    fn mixed_mode(&self) -> Option<MixedMode> {
        let pressed = self.b <= 0.0;
        Some(MixedMode {
            independent_works: true,
            resists_sliding: self.b == 0.0,
            keeps_repulsion: pressed && self.r >= 0.0,
            holds_under_pressure: pressed,
            vanishes: self.a == 0.0,
            continuous: true,
        })
    }
}
