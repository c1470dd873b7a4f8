use crate::{Law, LawError, MixedMode, Response, Separation};

/// A law with normal and tangential tractions that decay with the magnitude of the separation, λ² = max(Δ_n, 0)²/δ_n² +
/// Δ_t²/δ_t². Under over-closure the modes are uncoupled (theory.md, section 8). τ_max = φ_t/(e δ_t).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Npc {
    separation: Separation,
}

impl Npc {
    /// Creates the law with the given works and lengths.
    ///
    /// # Errors
    /// Returns an error if a work or a length is not positive.
    pub fn new(separation: Separation) -> Result<Self, LawError> {
        Ok(Self { separation: separation.check()? })
    }
}

impl Law for Npc {
    fn response(&self, normal: f64, sliding: f64) -> Response {
        let [x, y] = self.separation.reduce(normal, sliding);
        if x < 0.0 {
            let (e, decay) = ((-x).exp(), (-y.abs()).exp());
            let jacobian = [[(1.0 - x) * e, 0.0], [0.0, decay * (1.0 - y.abs())]];
            return self.separation.scale([x * e, y * decay], jacobian, decay);
        }
        let lambda = x.hypot(y);
        let decay = (-lambda).exp();
        // x²/λ, x y/λ and y²/λ vanish with λ.
        let over = |product: f64| if lambda > 0.0 { product / lambda } else { 0.0 };
        let coupling = -decay * over(x * y);
        self.separation.scale(
            [x * decay, y * decay],
            [[decay * (1.0 - over(x * x)), coupling], [coupling, decay * (1.0 - over(y * y))]],
            decay,
        )
    }

    fn energy(&self, normal: f64, sliding: f64) -> Option<f64> {
        let Separation { normal_work, tangential_work, .. } = self.separation;
        let [x, y] = self.separation.reduce(normal, sliding);
        let left = |lambda: f64| (1.0 + lambda) * (-lambda).exp();
        (normal_work == tangential_work)
            .then(|| -normal_work * if x < 0.0 { left(x) + left(y.abs()) - 1.0 } else { left(x.hypot(y)) })
    }

    fn opening_energy(&self, normal: f64) -> f64 {
        self.separation.opening_energy(normal)
    }

    fn stiffness_bound(&self, lowest: f64) -> f64 {
        let x0 = (lowest / self.separation.normal_length).min(0.0);
        // |x y|/λ ≤ λ/2, and the maximum of λ e^{−λ} is 1/e.
        let coupling = 0.5 * (-1.0_f64).exp();
        self.separation.bound([[(1.0 - x0) * (-x0).exp(), coupling], [coupling, 1.0]])
    }

    fn mixed_mode(&self) -> Option<MixedMode> {
        Some(MixedMode {
            independent_works: true,
            resists_sliding: true,
            keeps_repulsion: true,
            holds_under_pressure: true,
            vanishes: true,
            continuous: true,
        })
    }
}
