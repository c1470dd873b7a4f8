use crate::bosch_schreurs_geers::LARGEST_Y_GAUSS;
use crate::{Law, LawError, MixedMode, Response, Separation};

/// The coupled exponential law C3D of Khajeh Salehani and Irani (2018). The shear traction resists sliding at any
/// opening and grows under over-closure. φ_t is the work of sliding (theory.md, section 8); τ_max = √(2/e) φ_t/δ_t.
///
/// Sliding weakens the repulsion of over-closed surfaces; in [`Npb`] it does not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoupledExponential {
    separation: Separation,
}

impl CoupledExponential {
    /// Creates the law with the given works and lengths.
    ///
    /// # Errors
    /// Returns an error if a work or a length is not positive.
    pub fn new(separation: Separation) -> Result<Self, LawError> {
        Ok(Self { separation: separation.check()? })
    }
}

impl Law for CoupledExponential {
    fn response(&self, normal: f64, sliding: f64) -> Response {
        let [x, y] = self.separation.reduce(normal, sliding);
        let decay = (-x - y * y).exp();
        let secant = 2.0 * decay;
        self.separation.scale(
            [x * decay, secant * y],
            [[(1.0 - x) * decay, -2.0 * x * y * decay], [-secant * y, secant * (1.0 - 2.0 * y * y)]],
            secant,
        )
    }

    fn energy(&self, _: f64, _: f64) -> Option<f64> {
        None
    }

    fn opening_energy(&self, normal: f64) -> f64 {
        self.separation.opening_energy(normal)
    }

    fn stiffness_bound(&self, lowest: f64) -> f64 {
        let x0 = (lowest / self.separation.normal_length).min(0.0);
        let e0 = (-x0).exp();
        let coupling = 2.0 * (-x0 * e0).max((-1.0_f64).exp()) * LARGEST_Y_GAUSS;
        self.separation.bound([[(1.0 - x0) * e0, coupling], [2.0 * LARGEST_Y_GAUSS * e0, 2.0 * e0]])
    }

    fn mixed_mode(&self) -> Option<MixedMode> {
        Some(MixedMode {
            independent_works: true,
            resists_sliding: true,
            keeps_repulsion: false,
            holds_under_pressure: true,
            vanishes: true,
            continuous: true,
        })
    }
}

/// The law [`CoupledExponential`] with a repulsion independent of sliding: for Δ_n < 0, T_n = (φ_n/δ_n) x e^{−x}. It is
/// safe under over-closure and takes the role of the non-potential laws of McGarry et al. (2014), but its formulas
/// differ from theirs (theory.md, section 8). Its Jacobian jumps at Δ_n = 0 if Δ_t ≠ 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Npb {
    coupled: CoupledExponential,
}

impl Npb {
    /// Creates the law with the given works and lengths.
    ///
    /// # Errors
    /// Returns an error if a work or a length is not positive.
    pub fn new(separation: Separation) -> Result<Self, LawError> {
        Ok(Self { coupled: CoupledExponential::new(separation)? })
    }
}

impl Law for Npb {
    fn response(&self, normal: f64, sliding: f64) -> Response {
        let coupled = self.coupled.response(normal, sliding);
        if normal >= 0.0 {
            return coupled;
        }
        let separation = &self.coupled.separation;
        let [x, _] = separation.reduce(normal, sliding);
        let e = (-x).exp();
        let alone = separation.scale([x * e, 0.0], [[(1.0 - x) * e, 0.0], [0.0; 2]], 0.0);
        Response {
            traction: [alone.traction[0], coupled.traction[1]],
            jacobian: [alone.jacobian[0], coupled.jacobian[1]],
            secant: coupled.secant,
        }
    }

    fn energy(&self, _: f64, _: f64) -> Option<f64> {
        None
    }

    fn opening_energy(&self, normal: f64) -> f64 {
        self.coupled.opening_energy(normal)
    }

    fn stiffness_bound(&self, lowest: f64) -> f64 {
        self.coupled.stiffness_bound(lowest)
    }

    fn mixed_mode(&self) -> Option<MixedMode> {
        self.coupled.mixed_mode().map(|properties| MixedMode { keeps_repulsion: true, ..properties })
    }
}
