use std::fmt;
use std::sync::Arc;

/// An isotropic traction–separation law without history.
pub trait Law: fmt::Debug + Send + Sync {
    /// Computes the traction and its derivatives at the `normal` separation Δ_n and the `sliding` separation Δ_t along
    /// one direction (length, either sign).
    fn response(&self, normal: f64, sliding: f64) -> Response;

    /// Returns the potential Φ, energy per surface area, zero at infinite separation (Δ_n → ∞); `None` if the traction
    /// is not the gradient of a potential.
    fn energy(&self, normal: f64, sliding: f64) -> Option<f64>;

    /// Returns the potential of T_n(Δ_n, 0), energy per area, zero at infinite separation. It exists for every law.
    fn opening_energy(&self, normal: f64) -> f64;

    /// Computes energy, traction and slope at the separation Δ_n without sliding:
    /// [`opening_energy`](Self::opening_energy) and [`response`](Self::response) in one call.
    fn opening(&self, normal: f64) -> Opening {
        let Response { traction: [traction, _], jacobian: [[slope, _], _], .. } = self.response(normal, 0.0);
        Opening { energy: self.opening_energy(normal), traction, slope }
    }

    /// Returns true if a hard wall forbids Δ_n < 0; the law then holds for Δ_n ≥ 0 only.
    fn has_wall(&self) -> bool {
        false
    }

    /// Returns an upper bound of the magnitude of the Jacobian eigenvalues over all Δ_n ≥ `lowest` (stress/length). It
    /// sets the time step (theory.md, section 8). Jumps of the traction do not count.
    fn stiffness_bound(&self, lowest: f64) -> f64;

    /// Returns the steepest decay of the attraction (stress/length). Lattice trapping is avoided if it is below about
    /// half the stiffness of the body at the shortest wavelength of the grid (theory.md, section 8).
    fn steepness(&self) -> f64 {
        self.stiffness_bound(0.0)
    }

    /// Returns the number of grid steps in the process zone, (π/4) E*/[`steepness`](Self::steepness), at which the
    /// pull-off load of a sphere is accurate to 2.5 %. A traction that is continuous in the gap needs few. If the
    /// traction ends in a jump, the edge of the zone moves from point to point, and the error is only of first order in
    /// the grid step. Measurements: docs/laws/adhesion.md.
    fn resolving_points(&self) -> f64 {
        2.0
    }

    /// Returns the properties of the law under mixed loading; `None` for a law without tangential traction.
    fn mixed_mode(&self) -> Option<MixedMode> {
        None
    }

    /// Returns the traction (T_x, T_y, T_n), stress.
    fn traction(&self, normal: f64, [x, y]: [f64; 2]) -> [f64; 3] {
        let Response { traction: [n, _], secant, .. } = self.response(normal, x.hypot(y));
        [secant * x, secant * y, n]
    }

    /// Returns the Jacobian ∂T/∂Δ, stress/length.
    fn jacobian(&self, normal: f64, [x, y]: [f64; 2]) -> Jacobian {
        let sliding = x.hypot(y);
        let Response { jacobian: [[nn, nt], [tn, tt]], secant, .. } = self.response(normal, sliding);
        let [x, y] = if sliding > 0.0 { [x / sliding, y / sliding] } else { [0.0; 2] };
        let along = tt - secant;
        Jacobian {
            nn,
            nt: [nt * x, nt * y],
            tn: [tn * x, tn * y],
            tt: [[secant + along * x * x, along * x * y], [along * x * y, secant + along * y * y]],
        }
    }

    /// Moves the law into a shared pointer.
    fn into_shared(self) -> Arc<dyn Law>
    where
        Self: Sized + 'static,
    {
        Arc::new(self)
    }
}

/// Implements [`Law`] for a pointer to a law.
macro_rules! pointer_is_law {
    ($pointer:ty) => {
        impl Law for $pointer {
            fn response(&self, normal: f64, sliding: f64) -> Response {
                (**self).response(normal, sliding)
            }

            fn energy(&self, normal: f64, sliding: f64) -> Option<f64> {
                (**self).energy(normal, sliding)
            }

            fn opening_energy(&self, normal: f64) -> f64 {
                (**self).opening_energy(normal)
            }

            fn opening(&self, normal: f64) -> Opening {
                (**self).opening(normal)
            }

            fn has_wall(&self) -> bool {
                (**self).has_wall()
            }

            fn stiffness_bound(&self, lowest: f64) -> f64 {
                (**self).stiffness_bound(lowest)
            }

            fn steepness(&self) -> f64 {
                (**self).steepness()
            }

            fn resolving_points(&self) -> f64 {
                (**self).resolving_points()
            }

            fn mixed_mode(&self) -> Option<MixedMode> {
                (**self).mixed_mode()
            }

            fn traction(&self, normal: f64, sliding: [f64; 2]) -> [f64; 3] {
                (**self).traction(normal, sliding)
            }

            fn jacobian(&self, normal: f64, sliding: [f64; 2]) -> Jacobian {
                (**self).jacobian(normal, sliding)
            }

            fn into_shared(self) -> Arc<dyn Law> {
                self.into()
            }
        }
    };
}
pointer_is_law!(Box<dyn Law>);
pointer_is_law!(Arc<dyn Law>);

/// Response of a law at one normal separation, without sliding.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Opening {
    /// Potential of T_n(Δ_n, 0), energy per area.
    pub energy: f64,
    /// Traction T_n, stress.
    pub traction: f64,
    /// Slope ∂T_n/∂Δ_n, stress/length.
    pub slope: f64,
}

/// Traction of a law and its derivatives at one separation, along one sliding direction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Response {
    /// Traction (T_n, T_t), stress.
    pub traction: [f64; 2],
    /// Jacobian: rows ∂T_n, ∂T_t; columns ∂Δ_n, ∂Δ_t; stress/length.
    pub jacobian: [[f64; 2]; 2],
    /// Secant stiffness T_t/Δ_t, finite at Δ_t = 0: the stiffness perpendicular to the sliding direction.
    pub secant: f64,
}

impl Response {
    /// Creates the response of a law without tangential traction.
    pub(crate) fn normal(traction: f64, slope: f64) -> Self {
        Self { traction: [traction, 0.0], jacobian: [[slope, 0.0], [0.0; 2]], secant: 0.0 }
    }
}

/// Jacobian ∂T/∂Δ with both tangential directions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jacobian {
    /// Derivative ∂T_n/∂Δ_n.
    pub nn: f64,
    /// Derivatives ∂T_n/∂Δ_x and ∂T_n/∂Δ_y.
    pub nt: [f64; 2],
    /// Derivatives ∂T_x/∂Δ_n and ∂T_y/∂Δ_n.
    pub tn: [f64; 2],
    /// Tangential derivatives: rows T_x, T_y; columns Δ_x, Δ_y.
    pub tt: [[f64; 2]; 2],
}

/// Properties of a cohesive law under mixed loading and over-closure: the requirements R1 to R6 of theory.md, section
/// 8.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MixedMode {
    /// R1: opening alone takes the work φ_n, and sliding alone at Δ_n = 0 the work φ_t; both can be chosen freely.
    pub independent_works: bool,
    /// R2: T_t·Δ_t ≥ 0 at any Δ_n: the shear traction never drives the sliding.
    pub resists_sliding: bool,
    /// R3: for Δ_n < 0, −T_n grows with over-closure, and sliding does not weaken it.
    pub keeps_repulsion: bool,
    /// R4: for Δ_n < 0, |T_t| does not fall with over-closure.
    pub holds_under_pressure: bool,
    /// R5: the traction vanishes at large separation, in any direction with Δ_n ≥ 0.
    pub vanishes: bool,
    /// R6: the traction is continuous, and its derivatives are bounded if Δ_n is bounded.
    pub continuous: bool,
}

impl MixedMode {
    /// Returns true if the law has all six properties.
    pub fn all(self) -> bool {
        let Self { independent_works, resists_sliding, keeps_repulsion, holds_under_pressure, vanishes, continuous } =
            self;
        independent_works && resists_sliding && keeps_repulsion && holds_under_pressure && vanishes && continuous
    }
}
