use std::fmt;
use std::str::FromStr;

/// The solvers. All methods find one state; they differ in cost and in the problems that they can solve
/// ([`Equilibrium::solvers`](crate::Equilibrium::solvers)).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Solver {
    /// The fastest robust method: for a hard wall [`PreconditionedCg`](Self::PreconditionedCg), followed by
    /// [`ProjectedCg`](Self::ProjectedCg) after 100 iterations and again by the former after 5000 more; if little touches, the former on few
    /// points first (theory.md, section 7.5); for a law with a potential [`Newton`](Self::Newton).
    #[default]
    Auto,
    /// Constrained conjugate gradients on the pressure, restarted when the contact grows (Polonsky and Keer 1999).
    PolonskyKeer,
    /// Conjugate gradients on the pressure without restarts.
    ProjectedCg,
    /// Conjugate gradients on the pressure, preconditioned by the stiffness of the surface with the gap extended from
    /// the contact to the whole surface. The method is close to Newton's; its number of steps hardly depends on the
    /// grid.
    PreconditionedCg,
    /// Damped position Verlet of the surface displacement, with optimal scalar damping and time step for the range of
    /// stiffnesses.
    Verlet,
    /// Damped position Verlet with the softest mode critically damped, as in the original method.
    VerletCritical,
    /// Damped position Verlet with every mode critically damped, and the best time step for the range of stiffnesses.
    VerletModes,
    /// The fast inertial relaxation engine (Bitzek et al. 2006).
    Fire,
    /// The fast inertial relaxation engine, version 2.0 (Guénolé et al. 2020).
    Fire2,
    /// Dynamics with inertia K + ϱ, close to the stiffness, under the reaction of the wall in place of clipping.
    AugmentedLagrangian,
    /// Newton steps that decrease the energy, for laws with a potential.
    Newton,
}

impl Solver {
    /// All solvers.
    pub const ALL: [Self; 11] = [
        Self::Auto,
        Self::PolonskyKeer,
        Self::ProjectedCg,
        Self::PreconditionedCg,
        Self::Verlet,
        Self::VerletCritical,
        Self::VerletModes,
        Self::Fire,
        Self::Fire2,
        Self::AugmentedLagrangian,
        Self::Newton,
    ];

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::PolonskyKeer => "cg",
            Self::ProjectedCg => "projected-cg",
            Self::PreconditionedCg => "preconditioned-cg",
            Self::Verlet => "verlet",
            Self::VerletCritical => "verlet-critical",
            Self::VerletModes => "verlet-modes",
            Self::Fire => "fire",
            Self::Fire2 => "fire2",
            Self::AugmentedLagrangian => "augmented-lagrangian",
            Self::Newton => "newton",
        }
    }

    /// The description in one line.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Auto => "the fastest robust method",
            Self::PolonskyKeer => "conjugate gradients on the pressure, restarted when the contact grows",
            Self::ProjectedCg => "conjugate gradients on the pressure without restarts",
            Self::PreconditionedCg => "conjugate gradients on the pressure, preconditioned by the stiffness",
            Self::Verlet => "damped dynamics with optimal scalar damping",
            Self::VerletCritical => "damped dynamics with critical damping of the softest mode",
            Self::VerletModes => "damped dynamics with critical damping of every mode",
            Self::Fire => "FIRE (Bitzek et al. 2006)",
            Self::Fire2 => "FIRE 2.0 (Guénolé et al. 2020)",
            Self::AugmentedLagrangian => "dynamics with inertia close to the stiffness, under the reaction of the wall",
            Self::Newton => "Newton steps that decrease the energy, for laws with a potential",
        }
    }
}

impl fmt::Display for Solver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Error: no solver has the given name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the solver is {found}; it must be one of {}", Solver::ALL.map(Solver::name).join(", "))]
pub struct UnknownSolver {
    /// The name given.
    pub found: String,
}

impl FromStr for Solver {
    type Err = UnknownSolver;

    fn from_str(name: &str) -> Result<Self, UnknownSolver> {
        let named = Self::ALL.into_iter().find(|solver| solver.name() == name);
        named.ok_or_else(|| UnknownSolver { found: name.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for solver in Solver::ALL {
            assert_eq!(solver.name().parse(), Ok(solver));
        }
        assert!("newton-cg".parse::<Solver>().is_err_and(|error| error.found == "newton-cg"));
    }
}
