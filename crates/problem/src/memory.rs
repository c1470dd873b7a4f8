use gfmd_contact::{Boundary, Solver};
use gfmd_interface::Sequence;

use crate::rules::Facts;
use crate::unknown::Unknown;

/// Number of fields, of one double per point, that a problem holds in memory at its peak, with a margin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryNeed(pub u64);

impl MemoryNeed {
    /// Contact with a hard wall.
    pub const HARD_WALL: Self = Self(13);
    /// Contact with a hard wall under one load that does not start from another load.
    pub const HARD_WALL_ONCE: Self = Self(9);
    /// Contact with a hard wall and free boundaries, or with a hardness.
    pub const FREE: Self = Self(26);
    /// Contact with finite slopes.
    pub const STEEP: Self = Self(48);
    /// Whole fields of each of several processes with finite slopes: splines through heights and lateral displacement.
    pub const STEEP_OF_EACH: Self = Self(6);
    /// Contact with a hard wall whose components all are moved by damped dynamics.
    pub const WALL_ALL_COMPONENTS: Self = Self(64);
    /// Slab between two surfaces.
    pub const SQUEEZED: Self = Self(50);
    /// Slab between two surfaces with a hardness: its bounds and both plastic depths of two states.
    pub const SQUEEZED_WITH_HARDNESS: Self = Self(60);
    /// Slab between two surfaces with a law at both faces, which are searched in double precision.
    pub const SQUEEZED_BY_LAW: Self = Self(90);
    /// Path of a slab between two surfaces, with the states before and after a jump.
    pub const SQUEEZED_ON_PATH: Self = Self(140);
    /// Contact with a law that acts across the gap.
    pub const LAW: Self = Self(29);
    /// Contact with a law on a patch, which is solved in a cell with four times its points.
    pub const LAW_FREE: Self = Self(110);
    /// Path of u_z alone, with the states before and after a jump.
    pub const PATH: Self = Self(41);
    /// Path with a law, on a patch.
    pub const PATH_FREE: Self = Self(141);
    /// Path that moves all components, with the states of steps that are divided (111 fields measured).
    pub const ALL_COMPONENTS: Self = Self(122);
    /// Path with friction, on a patch (133 fields measured).
    pub const ALL_COMPONENTS_FREE: Self = Self(146);
    /// Path with a law that moves all components, on a patch, which is solved in a cell with four times its points. A
    /// Poisson's ratio well below 0 takes a cell of nine times the points, and about twice the memory.
    pub const LAW_ALL_COMPONENTS_FREE: Self = Self(320);

    /// Flow through the gap of a contact, with the state at rest.
    pub const FLOW: Self = Self(48);
    /// Flow through the gap on a path, with the previous state.
    pub const FLOW_ON_PATH: Self = Self(54);
    /// Flow alone, through a given gap.
    pub const FLOW_ALONE: Self = Self(34);

    /// Lateral displacement by the pressure.
    const SIDEWAYS: u64 = 24;
    /// Lateral displacement by the pressure on a patch.
    const SIDEWAYS_FREE: u64 = 44;
    /// Law beside friction on a path.
    const LAW_BESIDE_FRICTION: u64 = 41;
    /// Law beside friction on a path of a patch, whose stiffness is found in a cell with four times its points (283
    /// fields measured in all). A Poisson's ratio well below 0 takes a cell as for
    /// [`LAW_ALL_COMPONENTS_FREE`](Self::LAW_ALL_COMPONENTS_FREE).
    const LAW_BESIDE_FRICTION_FREE: u64 = 164;
    /// Cell of a body that yields, on the grid of the surface.
    const YIELD_PER_CELL: f64 = 45.0;
    /// Strain of a cell at a waypoint, and its copy beside an unfinished file, on the grid of the surface.
    const STRAIN_PER_CELL: f64 = 12.0;
    /// Wear on a path.
    const WEAR: u64 = 16;
    /// Hardness beside a law or friction on a path.
    const HARDNESS: u64 = 14;

    /// Adds the fields of a viscoelastic body with this number of branches and components of its memory to the fields
    /// of an elastic path.
    #[must_use]
    pub fn relaxing(self, branches: usize, components: usize) -> Self {
        Self(self.0 + components as u64 * (14 + 10 * branches as u64))
    }

    /// Adds the fields of a body that yields in cells with this number of points per point of the surface.
    #[must_use]
    pub fn yielding(self, points: f64) -> Self {
        Self(self.0 + (Self::YIELD_PER_CELL * points) as u64)
    }

    /// Adds the plastic strain at a waypoint, kept in cells with this number of points per point of the surface.
    #[must_use]
    pub fn keeping_strain(self, points: f64) -> Self {
        Self(self.0 + (Self::STRAIN_PER_CELL * points) as u64)
    }

    /// Returns the number of bytes on a grid of `points`, at most `u64::MAX`.
    pub fn bytes(self, points: [usize; 2]) -> u64 {
        points.iter().fold(8 * self.0, |bytes, &points| bytes.saturating_mul(points as u64))
    }
}

impl Facts {
    /// Returns the memory that the problem needs with this solver; less for `only` one load without statistics.
    pub fn memory_need(&self, solver: Solver, only: bool) -> MemoryNeed {
        let flow = match self.sequence {
            _ if !self.flow => MemoryNeed(0),
            Sequence::Loads => MemoryNeed::FLOW,
            Sequence::Path => MemoryNeed::FLOW_ON_PATH,
        };
        // The fields of the search are freed before the flow is computed.
        let search =
            if self.moves_all_by(solver) { MemoryNeed::WALL_ALL_COMPONENTS } else { self.need_of_search(only) };
        MemoryNeed(flow.0.max(search.0))
    }

    fn need_of_search(&self, only: bool) -> MemoryNeed {
        let is_free = self.boundary == Boundary::Free;
        let normal = self.need_of_normal(only);
        if self.sequence == Sequence::Path || self.unknown != Unknown::All || self.finite_slope {
            return normal;
        }
        let sideways = if is_free { MemoryNeed::SIDEWAYS_FREE } else { MemoryNeed::SIDEWAYS };
        MemoryNeed(normal.0 + sideways)
    }

    /// Returns the need of a search that finds no lateral displacement by the pressure.
    fn need_of_normal(&self, only: bool) -> MemoryNeed {
        let is_free = self.boundary == Boundary::Free;
        match self.sequence {
            Sequence::Loads if self.finite_slope => MemoryNeed::STEEP,
            Sequence::Loads if self.lower.is_some() && self.has_law() => MemoryNeed::SQUEEZED_BY_LAW,
            Sequence::Loads if self.lower.is_some() && self.hardness => MemoryNeed::SQUEEZED_WITH_HARDNESS,
            Sequence::Loads if self.lower.is_some() => MemoryNeed::SQUEEZED,
            Sequence::Loads if self.has_law() && is_free => MemoryNeed::LAW_FREE,
            Sequence::Loads if self.has_law() => MemoryNeed::LAW,
            Sequence::Loads if self.hardness || is_free => MemoryNeed::FREE,
            Sequence::Loads if only => MemoryNeed::HARD_WALL_ONCE,
            Sequence::Loads => MemoryNeed::HARD_WALL,
            Sequence::Path => self.need_of_path(is_free),
        }
    }

    /// Returns the sum of the needs of the parts of a path on an elastic body.
    fn need_of_path(&self, is_free: bool) -> MemoryNeed {
        let (law, sideways) = (self.solves_a_law(), self.moves_sideways());
        let base = match (sideways, law, is_free) {
            _ if self.lower.is_some() => MemoryNeed::SQUEEZED_ON_PATH,
            (true, _, true) if self.shears_by_law() => MemoryNeed::LAW_ALL_COMPONENTS_FREE,
            (true, _, true) => MemoryNeed::ALL_COMPONENTS_FREE,
            (true, _, false) => MemoryNeed::ALL_COMPONENTS,
            (false, true, true) => MemoryNeed::PATH_FREE,
            (false, true, false) => MemoryNeed::PATH,
            (false, false, _) => MemoryNeed::FREE,
        };
        let of = |is_part: bool, fields: u64| if is_part { fields } else { 0 };
        let histories =
            of(self.wear.is_some(), MemoryNeed::WEAR) + of(self.hardness && (law || sideways), MemoryNeed::HARDNESS);
        let faces = 1 + u64::from(self.lower.is_some());
        let beside = if is_free { MemoryNeed::LAW_BESIDE_FRICTION_FREE } else { MemoryNeed::LAW_BESIDE_FRICTION };
        let friction = of(self.friction.is_some() && law, beside);
        MemoryNeed(base.0 + friction + faces * histories)
    }
}
