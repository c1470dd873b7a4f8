use gfmd_green::{BaseKind, Condition, Ground, Height};
use gfmd_interface::Wear;
use gfmd_law::Limit;

/// Limit of the shear between the surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Friction {
    /// Limit proportional to the pressure.
    Coulomb,
    /// Shear strength.
    Tresca,
    /// The smaller of both.
    Orowan,
}

impl Friction {
    /// Returns the kind of a limit.
    pub fn of(limit: Limit) -> Self {
        match limit {
            Limit::Coulomb(_) => Self::Coulomb,
            Limit::Tresca(_) => Self::Tresca,
            Limit::Orowan { .. } => Self::Orowan,
        }
    }
}

/// Sliding by which surfaces wear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum WearBy {
    /// Prescribed sliding distance: gross sliding, or many cycles.
    #[default]
    Distance,
    /// Slip of each point: fretting.
    Slip,
}

impl WearBy {
    /// All choices.
    pub const ALL: [Self; 2] = [Self::Distance, Self::Slip];

    /// Returns the sliding by which surfaces wear.
    pub fn of(wear: Wear) -> Self {
        if wear.by_slip > 0.0 { Self::Slip } else { Self::Distance }
    }

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Distance => "distance",
            Self::Slip => "slip",
        }
    }

    /// Returns a description in one line.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Distance => "the sliding distance of each leg, the same at all points: gross sliding, or many cycles",
            Self::Slip => "the slip of each point, which friction determines: fretting",
        }
    }
}

impl std::fmt::Display for WearBy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// Support of a surface: the body below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// Half-space.
    HalfSpace,
    /// Slab, or layers, on a base.
    Slab(BaseKind),
    /// Body with a known normal compliance only.
    Table,
}

impl Support {
    /// Returns the support of a body with a top layer of this height, and this base below its lowest layer.
    pub fn of(height: Height, base: BaseKind) -> Self {
        match height {
            Height::Infinite => Self::HalfSpace,
            Height::Finite(_) => Self::Slab(base),
        }
    }

    /// Returns true if nothing rigid holds the body from below: points far from a line load sink without bound.
    pub(crate) fn is_open(self) -> bool {
        self != Self::Table && self.ground().is_none_or(|ground| ground.normal == Condition::Free)
    }

    /// Returns the rigid ground below; `None` if a half-space lies below, or if the ground is unknown.
    pub(crate) fn ground(self) -> Option<Ground> {
        match self {
            Self::HalfSpace | Self::Table => None,
            Self::Slab(base) => base.ground(),
        }
    }
}

/// Origin of a rigid surface below a slab.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lower {
    /// Given heights.
    Surface,
    /// Seed of a generated surface.
    Seed,
}

/// Motion of a base.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MovedBase {
    /// Displacement of a rigid base.
    Displacement,
    /// Traction on the lower face of a plate.
    Traction,
}
