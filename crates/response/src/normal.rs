use gfmd_field::{Grid, Transform};
use gfmd_green::{Body, normal_stiffness_table, restricted_normal_stiffness_table};

/// The normal response of a body on one grid: planned transforms, and compliance and stiffness of every mode for
/// problems in which only u_z and the pressure matter. Built once, shared between problems and threads.
#[derive(Debug)]
pub struct NormalResponse {
    transform: Transform,
    compliance: Vec<f64>,
    stiffness: Vec<f64>,
    uniform_compliance: f64,
    stiffness_range: [f64; 2],
    contact_modulus: f64,
}

impl NormalResponse {
    /// Tabulates the response of `body` on `grid`; its surface is free to move sideways.
    pub fn new(grid: Grid, body: &Body) -> Self {
        Self::from_stiffness(grid, body, normal_stiffness_table(body, &grid, 0.0))
    }

    /// As [`new`](Self::new), of a surface that cannot move sideways: the stiffness is K_N in place of 1/G_zz
    /// (theory.md, section 3, restricted lateral displacement).
    pub fn held_sideways(grid: Grid, body: &Body) -> Self {
        Self::from_stiffness(grid, body, restricted_normal_stiffness_table(body, &grid, 0.0))
    }

    fn from_stiffness(grid: Grid, body: &Body, mut stiffness: Vec<f64>) -> Self {
        let mut compliance: Vec<f64> = stiffness.iter().map(|k| 1.0 / k).collect();
        // By index, never by value: the uniform mode is the first.
        (compliance[0], stiffness[0]) = (0.0, 0.0);
        let uniform = body.normal_compliance(0.0);
        let (softest, stiffest) =
            stiffness[1..].iter().fold((f64::INFINITY, 0.0), |(low, high), k| (k.min(low), k.max(high)));
        Self {
            transform: Transform::new(grid),
            compliance,
            stiffness,
            uniform_compliance: if uniform.is_finite() { uniform } else { 0.0 },
            stiffness_range: [softest, stiffest],
            contact_modulus: body.material().contact_modulus(),
        }
    }

    /// The grid of the surface.
    pub fn grid(&self) -> &Grid {
        self.transform.grid()
    }

    /// The planned transforms of the grid, behind [`NormalTransforms`](crate::NormalTransforms).
    pub(crate) fn transform(&self) -> &Transform {
        &self.transform
    }

    /// G_zz(q) in length/stress, laid out as [`Grid::modes`]; 0 at q = 0, see
    /// [`uniform_compliance`](Self::uniform_compliance).
    pub fn compliance(&self) -> &[f64] {
        &self.compliance
    }

    /// 1/G_zz(q) in stress/length, laid out as [`Grid::modes`]; 0 at q = 0.
    pub fn stiffness(&self) -> &[f64] {
        &self.stiffness
    }

    /// E* of the body, in stress.
    pub fn contact_modulus(&self) -> f64 {
        self.contact_modulus
    }

    /// G_zz(0), length/stress: the height over the P-wave modulus of a slab, 0 of a half-space (whose surface keeps its
    /// mean level, theory.md, section 7) and of an incompressible slab.
    pub fn uniform_compliance(&self) -> f64 {
        self.uniform_compliance
    }

    /// Smallest and largest stiffness 1/G_zz of the modes q ≠ 0, in stress/length.
    pub fn stiffness_range(&self) -> [f64; 2] {
        self.stiffness_range
    }
}
