/// The condition for a component at the bottom of a slab.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Condition {
    /// No displacement.
    Fixed,
    /// No traction.
    Free,
}

/// Rigid ground below a slab: a condition for each component (theory.md, section 4). All else about a slab on it
/// follows from these two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Ground {
    /// The condition for u_x and u_y, or σ_xz and σ_yz.
    pub lateral: Condition,
    /// The condition for u_z, or σ_zz.
    pub normal: Condition,
}

impl Ground {
    /// Ground to which the slab is bonded: u = 0.
    pub const BONDED: Self = Self { lateral: Condition::Fixed, normal: Condition::Fixed };
    /// Ground without friction or gap: u_z = 0, no shear traction.
    pub const SLIDING: Self = Self { lateral: Condition::Free, normal: Condition::Fixed };
    /// No ground: a plate, whose lower face bears no traction.
    pub const NONE: Self = Self { lateral: Condition::Free, normal: Condition::Free };
    /// Ground that fixes the lateral displacement alone: u_x = u_y = 0, σ_zz = 0. It is the mid-plane of a plate that
    /// bends.
    pub const GUIDED: Self = Self { lateral: Condition::Fixed, normal: Condition::Free };
}
