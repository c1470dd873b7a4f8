/// The methods. All find the same state; they differ in cost. (docs/solvers.md)
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Solver {
    /// The fastest that is safe: [`PreconditionedCg`](Self::PreconditionedCg), and where that takes more than 100
    /// iterations, [`ProjectedCg`](Self::ProjectedCg) from there on.
    #[default]
    Auto,
    /// Constrained conjugate gradients on the pressure, restarted when the contact grows (Polonsky and Keer 1999).
    PolonskyKeer,
    /// Conjugate gradients on the pressure that are not restarted.
    ProjectedCg,
    /// Conjugate gradients on the pressure, preconditioned by the stiffness of the surface with the gap extended from the
    /// contact to all of it: nearly Newton's method, in a number of steps that hardly depends on the grid.
    PreconditionedCg,
    /// Damped position Verlet of the surface displacement, with the scalar damping and time step that suit the range of
    /// stiffnesses best.
    Verlet,
    /// Damped position Verlet with the softest mode critically damped, as in the original method.
    VerletCritical,
    /// The fast inertial relaxation engine (Bitzek et al. 2006).
    Fire,
    /// The same, version 2.0 (Guénolé et al. 2020).
    Fire2,
    /// Dynamics with inertia K + ϱ, nearly that of the stiffness, under the reaction of the wall in place of clipping.
    AugmentedLagrangian,
}
