/// Boundary condition for a component at the bottom of a slab.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Condition {
    /// No displacement.
    Fixed,
    /// No traction.
    Free,
}

/// Rigid ground below a slab, fully described by the conditions for its components (theory.md, section 4).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Ground {
    /// Condition for u_x and u_y, or σ_xz and σ_yz.
    pub lateral: Condition,
    /// Condition for u_z, or σ_zz.
    pub normal: Condition,
}

impl Ground {
    /// Bonded: u = 0.
    pub const BONDED: Self = Self { lateral: Condition::Fixed, normal: Condition::Fixed };
    /// Sliding without friction or gap: u_z = 0, no shear traction.
    pub const SLIDING: Self = Self { lateral: Condition::Free, normal: Condition::Fixed };
    /// No ground: a plate without traction on the lower face.
    pub const NONE: Self = Self { lateral: Condition::Free, normal: Condition::Free };
    /// Lateral displacement fixed, normal free: u_x = u_y = 0, σ_zz = 0, as on the mid-plane of a bending plate.
    pub const GUIDED: Self = Self { lateral: Condition::Fixed, normal: Condition::Free };
}
