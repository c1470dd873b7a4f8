use std::sync::Arc;

use gfmd_contact::{Boundary, Dynamics, Hardness, Heights, Refusal};
use gfmd_field::{Grid, Share};
use gfmd_green::Body;
use gfmd_law::{Law, Limit};
use gfmd_medium::{Medium, Prony, Relaxes, Relaxing};
use ndarray::Array2;

/// Parts of a contact of [one face](crate::QuasistaticContact) or of [both](crate::Squeezed). All but body, grid and
/// heights are optional, and any combination with a physical meaning can be solved.
#[derive(Clone)]
pub struct Parts<'a> {
    /// Meaning of a drive.
    pub sequence: Sequence,
    /// Elastic body; with its long-term moduli if it relaxes.
    pub body: &'a Body,
    /// Grid of the surface.
    pub grid: &'a Grid,
    /// Rows of this process, one of several that make the same calls with their rows of all fields; `None` if it is
    /// alone. Fields and numbers have the bits of one process.
    pub share: Option<&'a Share>,
    /// Rigid profile on the grid, in length, with peaks towards the body. A constant has no effect.
    pub heights: Heights<'a>,
    /// Rigid profile below a slab, likewise, for a contact of both faces ([`Squeezed`](crate::Squeezed)).
    pub lower: Option<Heights<'a>>,
    /// Boundary of the surface.
    pub boundary: Boundary,
    /// Law across the gap; `None` for a hard wall, which is solved for the pressure. With a
    /// [`HardWall`](gfmd_law::HardWall) as a law, the wall is solved for the displacement.
    pub law: Option<Arc<dyn Law>>,
    /// True if all components of the displacement are unknown: a law that shears moves them, and, at a hard wall under
    /// [loads](Sequence::Loads), the damped dynamics.
    pub all_components: bool,
    /// True if u_x and u_y of the surface are held at zero, without shear and with periodic boundaries.
    pub held: bool,
    /// Largest pressure that the surfaces carry, in stress. The depth by which they are pressed into each other stays.
    pub hardness: Option<Hardness>,
    /// Shear between the surfaces.
    pub shear: Option<Shear>,
    /// Relaxation of the body.
    pub relaxation: Option<(&'a Prony, Relaxes)>,
    /// Wear of the surfaces.
    pub wear: Option<Wear>,
    /// u_x and u_y (u_x of a profile) of the surface by a base that moves, `[x, y]`, in length; empty at rest. Counts
    /// for a law that moves all components.
    pub sideways: &'a [Array2<f64>],
    /// Time step and damping of the dynamic solvers of a hard wall.
    pub dynamics: Dynamics,
}

/// Meaning of the drives of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sequence {
    /// Each drive is a load of its own, on undeformed surfaces; the state to start from only begins the search.
    Loads,
    /// Each drive is an increment from the state to start from.
    Path,
}

impl<'a> Parts<'a> {
    /// Returns the parts of a hard wall above an elastic body, with periodic boundaries, along a path.
    pub fn new(body: &'a Body, grid: &'a Grid, heights: impl Into<Heights<'a>>) -> Self {
        Self {
            sequence: Sequence::Path,
            body,
            grid,
            share: None,
            heights: heights.into(),
            lower: None,
            boundary: Boundary::Periodic,
            law: None,
            all_components: false,
            held: false,
            hardness: None,
            shear: None,
            relaxation: None,
            wear: None,
            sideways: &[],
            dynamics: Dynamics::default(),
        }
    }
}

impl Parts<'_> {
    /// Returns the rows of this process.
    pub(crate) fn share(&self) -> Share {
        self.share.cloned().unwrap_or_else(|| self.grid.whole())
    }

    /// Checks that loads have no part that only acts along a path.
    pub(super) fn check_of_loads(&self) -> Result<(), Refusal> {
        // A wall does not feel a surface that moves sideways without traction.
        let shears = self.all_components && self.law.is_some();
        let of_paths = [
            (self.shear.is_some(), "a limit of the shear is"),
            (self.relaxation.is_some(), "a relaxation is"),
            (self.wear.is_some(), "a coefficient of wear is"),
            (shears && !self.sideways.is_empty(), "a displacement of the base sideways is"),
        ];
        let found = of_paths.into_iter().find(|(is_given, _)| *is_given);
        found.map_or(Ok(()), |(_, part)| Err(Refusal::NoWall { part, with: "loads" }))
    }

    /// Checks that a hard wall can move all components of the displacement.
    pub(super) fn check_moving_wall(&self, share: &Share) -> Result<(), Refusal> {
        let others = [
            (self.sequence == Sequence::Path, "a hard wall along a path"),
            (self.boundary == Boundary::Free, "free boundaries"),
            (!share.is_whole(), "several processes"),
        ];
        let found = others.into_iter().find(|(is_given, _)| *is_given);
        found.map_or(Ok(()), |(_, with)| Err(Refusal::NotNormal { with }))
    }

    /// Returns the body with a memory, for this number of displacement components on the `grid`; `None` for an elastic
    /// body.
    pub(super) fn medium(
        &self,
        grid: &Grid,
        share: &Share,
        components: usize,
    ) -> Result<Option<Arc<dyn Medium>>, Refusal> {
        let Some((prony, relaxes)) = self.relaxation else { return Ok(None) };
        let medium = Relaxing::distributed(share, self.body, grid, self.boundary, components, prony, relaxes)?;
        Ok(Some(Arc::new(if self.held { medium.held_sideways()? } else { medium })))
    }

    /// Checks that no other part moves a surface that is held sideways.
    pub(super) fn check_held(&self) -> Result<(), Refusal> {
        let others = [
            (self.boundary == Boundary::Free, "free boundaries"),
            (self.all_components, "a law that moves all components"),
            (self.shear.is_some(), "a limit of the shear"),
            (self.body.second().is_some(), "a second body"),
        ];
        others.into_iter().find(|(is_given, _)| *is_given).map_or(Ok(()), |(_, with)| Err(Refusal::Held { with }))
    }
}

/// Shear between surfaces in contact: they stick to each other up to a limit of the shear traction, and slip there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shear {
    /// Largest shear traction at a pressure.
    pub limit: Limit,
    /// Pressure that sets the limit.
    pub pressure: LimitingPressure,
}

/// Pressure that sets the limit of the shear. Without attraction both are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LimitingPressure {
    /// Repulsion between the surfaces, the pressure without the attraction (Derjaguin 1934, point by point). Surfaces
    /// that attract each other have friction without a load, and under tension.
    #[default]
    Repulsion,
    /// Net pressure, where it is positive.
    Net,
}

impl LimitingPressure {
    /// All choices.
    pub const ALL: [Self; 2] = [Self::Repulsion, Self::Net];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Repulsion => "repulsion",
            Self::Net => "net",
        }
    }

    /// Returns a description in one line.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Repulsion => "the repulsion of touching points, without the attraction: friction even at zero load",
            Self::Net => "the net pressure, where it is positive",
        }
    }
}

impl std::fmt::Display for LimitingPressure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

impl From<Limit> for Shear {
    fn from(limit: Limit) -> Self {
        Self { limit, pressure: LimitingPressure::Repulsion }
    }
}

/// Wear of both surfaces together (Archard): depth lost per repulsion and sliding distance, in 1/stress.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wear {
    /// Coefficient for the [distance](gfmd_contact::Drive::distance) of a drive: gross sliding, or many cycles.
    pub by_distance: f64,
    /// Coefficient for the slip of each point in an increment: fretting.
    pub by_slip: f64,
}

impl Wear {
    /// Returns the wear if its coefficients are valid.
    pub(super) fn check(self) -> Result<Self, Refusal> {
        for found in [self.by_distance, self.by_slip] {
            if !(found >= 0.0 && found.is_finite()) {
                return Err(Refusal::WearCoefficient { found });
            }
        }
        if self.by_distance == 0.0 && self.by_slip == 0.0 {
            return Err(Refusal::WearCoefficient { found: 0.0 });
        }
        Ok(self)
    }
}
