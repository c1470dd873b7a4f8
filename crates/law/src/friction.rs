use crate::LawError;
use crate::separation::positive;

/// Upper limit of the shear traction in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Coulomb friction: μ p, with the friction coefficient μ ≥ 0.
    Coulomb(f64),
    /// Tresca friction: a shear strength τ_c ≥ 0 (stress) wherever there is contact.
    Tresca(f64),
    /// Coulomb friction up to a shear strength: the smaller of both (Orowan 1943).
    Orowan {
        /// Friction coefficient μ ≥ 0.
        coefficient: f64,
        /// Shear strength τ_c ≥ 0, stress.
        strength: f64,
    },
}

impl Limit {
    /// Returns the limit if its value is valid.
    ///
    /// # Errors
    /// Returns an error if the coefficient or strength is negative or not finite.
    pub fn check(self) -> Result<Self, LawError> {
        let parts = match self {
            Self::Coulomb(coefficient) => [("mu", coefficient); 2],
            Self::Tresca(strength) => [("tau_c", strength); 2],
            Self::Orowan { coefficient, strength } => [("mu", coefficient), ("tau_c", strength)],
        };
        match parts.into_iter().find(|(_, found)| !(*found >= 0.0 && found.is_finite())) {
            Some((name, found)) => Err(LawError::Range { name, found, allowed: "0 or a positive, finite number" }),
            None => Ok(self),
        }
    }

    /// Returns the limit in other units of stress.
    #[must_use]
    pub fn in_units(self, stress: f64) -> Self {
        match self {
            Self::Coulomb(_) => self,
            Self::Tresca(strength) => Self::Tresca(strength / stress),
            Self::Orowan { coefficient, strength } => Self::Orowan { coefficient, strength: strength / stress },
        }
    }

    /// Returns the largest shear traction at the contact pressure `pressure` ≥ 0, stress.
    pub fn at(self, pressure: f64) -> f64 {
        match self {
            Self::Coulomb(coefficient) => coefficient * pressure,
            Self::Tresca(strength) => strength,
            Self::Orowan { coefficient, strength } => strength.min(coefficient * pressure),
        }
    }

    /// Returns the derivative of [`at`](Self::at) with respect to the pressure.
    pub fn slope(self, pressure: f64) -> f64 {
        match self {
            Self::Coulomb(coefficient) => coefficient,
            Self::Orowan { coefficient, strength } if coefficient * pressure < strength => coefficient,
            Self::Tresca(_) | Self::Orowan { .. } => 0.0,
        }
    }

    /// Returns the derivatives of [`at`](Self::at) with respect to the friction coefficient, in stress, and to the
    /// shear strength.
    pub fn by_parameters(self, pressure: f64) -> [f64; 2] {
        match self {
            Self::Coulomb(_) => [pressure, 0.0],
            Self::Orowan { coefficient, strength } if coefficient * pressure < strength => [pressure, 0.0],
            Self::Tresca(_) | Self::Orowan { .. } => [0.0, 1.0],
        }
    }
}

/// Friction with elastic sticking: the return map of a tangential spring with a sliding end, the foot (theory.md,
/// section 8).
///
/// The slip s is the displacement of the *elastic* surface relative to the rigid one. τ has the sign of s − s_p; the
/// traction on the elastic surface is −τ. This map serves point models and time-stepping codes; the frictional contact
/// in `gfmd-interface` needs only the [`Limit`] and sticks rigidly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Friction {
    limit: Limit,
    stiffness: f64,
}

/// Result of one slip increment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sliding {
    /// Shear traction τ, stress.
    pub traction: [f64; 2],
    /// Position s_p of the foot of the spring after the increment.
    pub foot: [f64; 2],
    /// True if the foot did not move.
    pub sticks: bool,
    /// Derivative ∂τ/∂s, stress/length.
    pub by_slip: [[f64; 2]; 2],
    /// Derivative ∂τ/∂p.
    pub by_pressure: [f64; 2],
}

impl Friction {
    /// Creates friction with a spring of the given `stiffness` (stress/length). A spring as stiff as the stiffest mode
    /// of the grid hardly changes the solution.
    ///
    /// # Errors
    /// Returns an error if the limit is negative or the stiffness is not positive.
    pub fn new(limit: Limit, stiffness: f64) -> Result<Self, LawError> {
        Ok(Self { limit: limit.check()?, stiffness: positive("stiffness", stiffness)? })
    }

    /// Computes the increment from the previous foot s_p to the slip s at the given pressure.
    pub fn slide(&self, slip: [f64; 2], foot: [f64; 2], pressure: f64) -> Sliding {
        let Self { limit, stiffness } = *self;
        let stretch = [slip[0] - foot[0], slip[1] - foot[1]];
        let length = stretch[0].hypot(stretch[1]);
        let largest = limit.at(pressure);
        if stiffness * length <= largest {
            return Sliding {
                traction: stretch.map(|s| stiffness * s),
                foot,
                sticks: true,
                by_slip: [[stiffness, 0.0], [0.0, stiffness]],
                by_pressure: [0.0; 2],
            };
        }
        let [x, y] = stretch.map(|s| s / length);
        let across = largest / length;
        Sliding {
            traction: [largest * x, largest * y],
            foot: [slip[0] - largest / stiffness * x, slip[1] - largest / stiffness * y],
            sticks: false,
            by_slip: [[across * y * y, -across * x * y], [-across * x * y, across * x * x]],
            by_pressure: [limit.slope(pressure) * x, limit.slope(pressure) * y],
        }
    }
}

/// Friction regularised in the sliding velocity v, for time-stepping codes: v_ε is the velocity below which it deviates
/// from the limit (theory.md, section 8). The quasistatic contacts of this workspace do not use it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rate {
    /// Root law τ = limit · v/√(v² + v_ε²).
    Root {
        /// Velocity v_ε.
        velocity: f64,
    },
    /// Arctangent law τ = limit · (2/π) atan(|v|/v_ε), along v.
    Arctangent {
        /// Velocity v_ε.
        velocity: f64,
    },
}

impl Rate {
    /// Returns the shear traction τ at the sliding velocity `v`; `limit` is the largest shear traction.
    pub fn traction(self, limit: f64, v: [f64; 2]) -> [f64; 2] {
        let speed = v[0].hypot(v[1]);
        if speed == 0.0 {
            return [0.0; 2];
        }
        let share = match self {
            Self::Root { velocity } => speed / speed.hypot(velocity),
            Self::Arctangent { velocity } => std::f64::consts::FRAC_2_PI * (speed / velocity).atan(),
        };
        v.map(|v| limit * share * v / speed)
    }
}
