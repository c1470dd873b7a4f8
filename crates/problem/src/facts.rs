use gfmd_contact::Boundary;
use gfmd_green::{BaseKind, Condition, Ground, Height};
use gfmd_law::LawKind;
use gfmd_medium::Relaxes;

use crate::{GridError, Unknown};

/// Kind of load sequence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Task {
    /// Loads, each solved as its own problem.
    #[default]
    Loads,
    /// Path of states that follow from one another.
    Path,
}

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
            Self::Distance => {
                "the sliding distance of the legs, the same for all points: gross sliding, or many cycles"
            }
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
    fn is_open(self) -> bool {
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

/// Parts of a problem, which decide what can be combined and which of its numbers have a meaning. The default is a
/// periodic hard wall on a half-space, under loads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facts {
    /// Kind of load sequence.
    pub task: Task,
    /// Law across the gap; [`LawKind::HardWall`] for none.
    pub law: LawKind,
    /// True if a hardness limits the pressure.
    pub hardness: bool,
    /// True if the body yields below its surface.
    pub yields: bool,
    /// Limit of the shear, if there is friction.
    pub friction: Option<Friction>,
    /// Surroundings of the surface.
    pub boundary: Boundary,
    /// Unknown components of the displacement.
    pub unknown: Unknown,
    /// True if slopes are not assumed small.
    pub finite_slope: bool,
    /// Rigid surface below the slab, if there is one.
    pub lower: Option<Lower>,
    /// Elastic body.
    pub support: Support,
    /// True if there are layers below the top one.
    pub layers: bool,
    /// Elastic body of the rough surface, if there is one.
    pub second: Option<Support>,
    /// Relaxing moduli of a viscoelastic body.
    pub relaxes: Option<Relaxes>,
    /// Sliding by which the surfaces wear, if they do.
    pub wear: Option<WearBy>,
    /// Motion of the base, if it moves.
    pub moved_base: Option<MovedBase>,
    /// True for a profile, in plane strain.
    pub line: bool,
    /// True if an approach is prescribed instead of a load.
    pub approach: bool,
    /// True if a lateral displacement is prescribed.
    pub lateral: bool,
    /// True if patches, distributions, spectra and the conductance are measured.
    pub statistics: bool,
    /// True if the flow through the gap is computed.
    pub flow: bool,
    /// True if the loads at which the flow stops are computed.
    pub flow_threshold: bool,
    /// Method to find the grid error.
    pub grid_error: GridError,
    /// True if the search is recorded.
    pub history: bool,
    /// True if a run continues an earlier one.
    pub resume: bool,
    /// Number of processes that share the problem.
    pub processes: usize,
}

impl Default for Facts {
    fn default() -> Self {
        Self {
            task: Task::Loads,
            law: LawKind::HardWall,
            hardness: false,
            yields: false,
            friction: None,
            boundary: Boundary::Periodic,
            unknown: Unknown::Normal,
            finite_slope: false,
            lower: None,
            support: Support::HalfSpace,
            layers: false,
            second: None,
            relaxes: None,
            wear: None,
            moved_base: None,
            line: false,
            approach: false,
            lateral: false,
            statistics: false,
            flow: false,
            flow_threshold: false,
            grid_error: GridError::Estimate,
            history: false,
            resume: false,
            processes: 1,
        }
    }
}

impl Facts {
    /// Returns true if a law acts across the gap.
    pub fn has_law(&self) -> bool {
        self.law != LawKind::HardWall
    }

    /// Returns true if a law that shears moves all components of the displacement.
    pub fn shears_by_law(&self) -> bool {
        self.task == Task::Path && self.lateral && self.friction.is_none()
    }

    /// Returns true if the displacement has a reference level: points far away, or its mean. A profile on a patch over
    /// a half-space has none, since its displacement grows with the logarithm of the distance.
    pub fn has_level(&self) -> bool {
        let is_open = self.support.is_open() || self.second.is_some_and(Support::is_open);
        self.boundary == Boundary::Periodic || !self.line || !is_open
    }

    /// Returns true if all components of the displacement are unknown.
    pub fn moves_sideways(&self) -> bool {
        self.unknown == Unknown::All || self.finite_slope || self.friction.is_some() || self.lateral
    }

    /// Returns true if the states follow a law across the gap; on a path that is periodic or moves all components also
    /// for an elastic hard wall alone, and for any hard wall of a slab between two surfaces.
    pub fn solves_a_law(&self) -> bool {
        let is_alone = !(self.hardness
            || self.yields
            || self.friction.is_some()
            || self.boundary == Boundary::Free && !self.shears_by_law()
            || self.relaxes.is_some()
            || self.wear.is_some());
        self.has_law() || self.task == Task::Path && (is_alone || self.lower.is_some())
    }

    /// Returns true for the path of a hard wall without friction that is solved by hard-wall methods.
    pub fn is_wall_on_path(&self) -> bool {
        self.task == Task::Path && !self.solves_a_law() && self.friction.is_none()
    }
}
