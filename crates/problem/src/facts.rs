use gfmd_contact::Boundary;
use gfmd_green::{BaseKind, Condition, Ground, Height};
use gfmd_law::Kind;
use gfmd_viscoelastic::Relaxes;

use crate::{GridError, Unknown};

/// The way through the loads.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Task {
    /// Loads, each a problem of its own.
    #[default]
    Loads,
    /// A path, whose states follow from one another.
    Path,
}

/// The limit of the shear between the surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Friction {
    /// In proportion to the pressure.
    Coulomb,
    /// A shear strength.
    Tresca,
}

/// The support of a surface: the body below it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// A half-space.
    HalfSpace,
    /// A slab, or layers, on a base.
    Slab(BaseKind),
    /// A body of which the normal compliance alone is known.
    Table,
}

impl Support {
    /// The support of a body whose top layer has this height, and its lowest layer this base.
    pub fn of(height: Height, base: BaseKind) -> Self {
        match height {
            Height::Infinite => Self::HalfSpace,
            Height::Finite(_) => Self::Slab(base),
        }
    }

    /// True if nothing rigid holds the body from below: points far from a line load sink without end.
    fn is_open(self) -> bool {
        self != Self::Table && self.ground().is_none_or(|ground| ground.normal == Condition::Free)
    }

    /// The rigid ground below; `None` with a half-space below, or if it is not known.
    pub(crate) fn ground(self) -> Option<Ground> {
        match self {
            Self::HalfSpace | Self::Table => None,
            Self::Slab(base) => base.ground(),
        }
    }
}

/// The origin of a rigid surface below a slab.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lower {
    /// Heights that are given.
    Surface,
    /// A seed.
    Seed,
}

/// The motion of a base.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MovedBase {
    /// The displacement of a rigid base.
    Displacement,
    /// The traction on the lower face of a plate.
    Traction,
}

/// The parts of a problem, which decide what goes together and which of its numbers have a meaning. The default is a
/// hard wall on a half-space, periodic, under loads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Facts {
    /// The way through the loads.
    pub task: Task,
    /// The law across the gap; [`Kind::HardWall`] for none.
    pub law: Kind,
    /// True if the pressure has a largest value.
    pub hardness: bool,
    /// The limit of the shear, if there is friction.
    pub friction: Option<Friction>,
    /// The surroundings of the surface.
    pub boundary: Boundary,
    /// The components that are unknown.
    pub unknown: Unknown,
    /// True if slopes are not taken as small.
    pub finite_slope: bool,
    /// The rigid surface below the slab, if there is one.
    pub lower: Option<Lower>,
    /// The elastic body.
    pub support: Support,
    /// True with layers below the top one.
    pub layers: bool,
    /// The elastic body that has the rough surface, if there is one.
    pub second: Option<Support>,
    /// The moduli that relax, of a viscoelastic body.
    pub relaxes: Option<Relaxes>,
    /// True if the surfaces wear.
    pub wears: bool,
    /// The motion of the base, if it moves.
    pub moved_base: Option<MovedBase>,
    /// True for a profile, in plane strain.
    pub line: bool,
    /// True if an approach is prescribed in place of a load.
    pub approach: bool,
    /// True if a lateral displacement is prescribed.
    pub lateral: bool,
    /// True if patches, distributions, spectra and the conductance are measured.
    pub statistics: bool,
    /// True if the flow through the gap is computed.
    pub flow: bool,
    /// True if the loads are sought at which the flow stops.
    pub flow_threshold: bool,
    /// The way in which the error of the grid is found.
    pub grid_error: GridError,
    /// True if the search is recorded.
    pub history: bool,
    /// True if a run continues an earlier one.
    pub resume: bool,
    /// The number of processes that share the problem.
    pub processes: usize,
}

impl Default for Facts {
    fn default() -> Self {
        Self {
            task: Task::Loads,
            law: Kind::HardWall,
            hardness: false,
            friction: None,
            boundary: Boundary::Periodic,
            unknown: Unknown::Normal,
            finite_slope: false,
            lower: None,
            support: Support::HalfSpace,
            layers: false,
            second: None,
            relaxes: None,
            wears: false,
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
    /// True if a law acts across the gap.
    pub fn has_law(&self) -> bool {
        self.law != Kind::HardWall
    }

    /// True if the displacement has a level: that of points far away, or that of its mean. It has none of a profile on
    /// a patch over a half-space, whose displacement grows with the logarithm of the distance.
    pub fn has_level(&self) -> bool {
        let is_open = self.support.is_open() || self.second.is_some_and(Support::is_open);
        self.boundary == Boundary::Periodic || !self.line || !is_open
    }

    /// True if all components of the displacement are unknown.
    pub fn moves_sideways(&self) -> bool {
        self.unknown == Unknown::All || self.finite_slope || self.friction.is_some() || self.lateral
    }

    /// True if the states are those of a law across the gap; on a periodic path also those of a hard wall.
    pub fn solves_a_law(&self) -> bool {
        match self.task {
            Task::Loads => self.has_law(),
            Task::Path => self.friction.is_none() && !self.is_wall_on_path(),
        }
    }

    /// True for the path of a hard wall alone that is solved by the methods of a hard wall: with a hardness, on a
    /// patch, on a viscoelastic body, or with surfaces that wear.
    pub fn is_wall_on_path(&self) -> bool {
        self.task == Task::Path
            && !self.has_law()
            && self.friction.is_none()
            && !self.lateral
            && (self.hardness || self.boundary == Boundary::Free || self.relaxes.is_some() || self.wears)
    }
}
