use gfmd_field::Grid;
use gfmd_green::{Body, Matrix3, stiffness_range};

use crate::{Components, Hermitian, Operator, Workspace};

/// The response of a body on one grid in all components of its surface: planned transforms, and the stiffness and
/// compliance matrix of every mode. Built once, shared between problems and threads.
///
/// A component of the uniform mode q = 0 that has no stiffness (half-space, free base) or no compliance (u_z of a bonded
/// incompressible slab) has zero for both, and [`uniform_compliance`](Self::uniform_compliance) is zero: its mean does
/// not answer to the mean traction.
#[derive(Debug)]
pub struct FullResponse {
    stiffness: Operator,
    compliance: Operator,
    uniform_compliance: [f64; 3],
    stiffness_range: [f64; 2],
    contact_modulus: f64,
}

impl FullResponse {
    /// Tabulates the response of `body` on `grid`.
    pub fn new(grid: Grid, body: &Body) -> Self {
        let compliance = Operator::new(grid, |mode| finite(&body.compliance_of(mode)));
        let stiffness = compliance.beside(|mode| finite(&body.stiffness_of(mode)));
        // By index, never by value: the uniform mode is the first.
        let Hermitian { xx, yy, zz, .. } = compliance.matrices()[0];
        let range = stiffness_range(body, &grid);
        Self {
            stiffness,
            compliance,
            uniform_compliance: [xx, yy, zz],
            stiffness_range: range.map_or([0.0; 2], |range| [range.softest, range.stiffest]),
            contact_modulus: body.material().contact_modulus(),
        }
    }

    /// The grid of the surface.
    pub fn grid(&self) -> &Grid {
        self.stiffness.grid()
    }

    /// The components of displacement and traction.
    pub fn components(&self) -> Components {
        self.stiffness.components()
    }

    /// K: traction (stress) of a displacement (length).
    pub fn stiffness(&self) -> &Operator {
        &self.stiffness
    }

    /// G: displacement (length) of a traction (stress).
    pub fn compliance(&self) -> &Operator {
        &self.compliance
    }

    /// Memory for the operators of this grid. It serves as many threads as the current rayon pool has.
    pub fn workspace(&self) -> Workspace {
        self.stiffness.workspace()
    }

    /// G_xx(0), G_yy(0), G_zz(0) in length/stress; 0 where the mean displacement does not answer to the mean traction.
    pub fn uniform_compliance(&self) -> [f64; 3] {
        self.uniform_compliance
    }

    /// E* of the body, in stress.
    pub fn contact_modulus(&self) -> f64 {
        self.contact_modulus
    }

    /// Smallest and largest eigenvalue of the stiffness over all modes, in stress/length, those that are zero or
    /// infinite left out; zeros if none is left.
    pub fn stiffness_range(&self) -> [f64; 2] {
        self.stiffness_range
    }
}

/// Infinite entries are those of a uniform mode that nothing holds, or that cannot move.
fn finite(matrix: &Matrix3) -> Hermitian {
    Hermitian::of(matrix).map(|entry| if entry.is_finite() { entry } else { 0.0 })
}
