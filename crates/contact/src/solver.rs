use std::fmt;
use std::str::FromStr;

/// Generates the enumeration of the solvers, with their names and descriptions, from one table.
macro_rules! solvers {
    ($($(#[$attribute:meta])* $solver:ident $name:literal $meaning:literal)*) => {
        /// Methods that solve a contact. All find the same state; they differ in cost and in the problems that they can
        /// solve ([`Equilibrium::solvers`](crate::Equilibrium::solvers)).
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
        pub enum Solver {
            $($(#[$attribute])* $solver,)*
        }

        impl Solver {
            /// All solvers.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$solver),*];

            /// Returns the name on the command line.
            pub fn name(self) -> &'static str {
                match self {
                    $(Self::$solver => $name,)*
                }
            }

            /// Returns the description in one line.
            pub fn meaning(self) -> &'static str {
                match self {
                    $(Self::$solver => $meaning,)*
                }
            }
        }
    };
}

solvers! {
    /// The fastest robust method. For a hard wall: [`PreconditionedCg`](Self::PreconditionedCg), then
    /// [`ProjectedCg`](Self::ProjectedCg) after 100 iterations, and the former again after 5000 more; if few points
    /// touch, the former on few points first (theory.md, section 7.5). For a law with a potential:
    /// [`Newton`](Self::Newton).
    #[default]
    Auto "auto" "the fastest robust method"
    /// Constrained conjugate gradients on the pressure, restarted when the contact grows (Polonsky and Keer 1999).
    PolonskyKeer "cg" "conjugate gradients on the pressure, restarted when the contact grows"
    /// Conjugate gradients on the pressure without restarts.
    ProjectedCg "projected-cg" "conjugate gradients on the pressure without restarts"
    /// Conjugate gradients on the pressure, preconditioned by the stiffness of the surface with the gap extended from
    /// the contact to the whole surface. The method is close to Newton's; its number of steps hardly depends on the
    /// grid.
    PreconditionedCg "preconditioned-cg" "conjugate gradients on the pressure, preconditioned by the stiffness"
    /// Damped position Verlet of the surface displacement, with optimal scalar damping and time step for the range of
    /// stiffnesses.
    Verlet "verlet" "damped dynamics with optimal scalar damping"
    /// Damped position Verlet with the softest mode critically damped, as in the original method.
    VerletCritical "verlet-critical" "damped dynamics with critical damping of the softest mode"
    /// Damped position Verlet with every mode critically damped, and the best time step for the range of stiffnesses.
    VerletModes "verlet-modes" "damped dynamics with critical damping of every mode"
    /// The fast inertial relaxation engine (Bitzek et al. 2006).
    Fire "fire" "FIRE (Bitzek et al. 2006)"
    /// The fast inertial relaxation engine, version 2.0 (Guénolé et al. 2020).
    Fire2 "fire2" "FIRE 2.0 (Guénolé et al. 2020)"
    /// Dynamics with inertia K + ϱ, close to the stiffness, under the reaction of the wall in place of clipping.
    AugmentedLagrangian "augmented-lagrangian" "dynamics with inertia close to the stiffness, under the reaction of \
        the wall"
    /// Newton steps that decrease the energy, for laws with a potential.
    Newton "newton" "Newton steps that decrease the energy, for laws with a potential"
}

impl fmt::Display for Solver {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Error for an unknown name of a solver.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the solver is {found}; it must be one of {}", Solver::ALL.map(Solver::name).join(", "))]
pub struct UnknownSolver {
    /// Name given.
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

    #[test]
    fn the_page_of_the_solvers_has_each_of_them() {
        let page = include_str!("../../../docs/solvers.md");
        let rows = page.lines().skip_while(|line| !line.starts_with("|---")).skip(1);
        let firsts = rows.take_while(|line| line.starts_with('|')).filter_map(|row| row.split('|').nth(1));
        let named: Vec<Solver> = firsts
            .flat_map(|cell| cell.split(" (").take(1).flat_map(|names| names.split(", ")))
            .map(|name| name.trim().trim_matches('`').parse().unwrap())
            .collect();
        for solver in Solver::ALL {
            assert_eq!(named.iter().filter(|other| **other == solver).count(), 1, "{solver}");
        }
    }

    #[test]
    fn a_hard_wall_is_for_all_solvers_that_need_no_law() {
        let without_law = Solver::ALL.into_iter().filter(|solver| *solver != Solver::Newton);
        assert!(without_law.eq(crate::Contact::SOLVERS));
        for some in [&crate::Contact::FREE_SOLVERS[..], &crate::Contact::HARDNESS_SOLVERS] {
            assert!(some.iter().all(|solver| crate::Contact::SOLVERS.contains(solver)));
        }
    }
}
