use std::fmt;
use std::str::FromStr;

/// Boundary condition of a surface and of the fields on it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Boundary {
    /// One period of an endless surface: points at opposite edges are neighbours.
    #[default]
    Periodic,
    /// Patch on an unbounded half-space, slab or stack of layers: pressure acts within the patch only, and the
    /// displacement is zero far away (theory.md, section 3.1). Points at an edge have no neighbours beyond it.
    Free,
}

impl Boundary {
    /// Both boundaries.
    pub const ALL: [Self; 2] = [Self::Periodic, Self::Free];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Periodic => "periodic",
            Self::Free => "free",
        }
    }

    /// Returns the description in one line.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Periodic => "the surface repeats periodically",
            Self::Free => "the surface is an isolated patch on an unbounded body",
        }
    }
}

impl fmt::Display for Boundary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Error for an unknown name of a boundary.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the boundary is {found}; it must be {} or {}", Boundary::Periodic, Boundary::Free)]
pub struct UnknownBoundary {
    /// Name given.
    pub found: String,
}

impl FromStr for Boundary {
    type Err = UnknownBoundary;

    fn from_str(name: &str) -> Result<Self, UnknownBoundary> {
        let named = Self::ALL.into_iter().find(|boundary| boundary.name() == name);
        named.ok_or_else(|| UnknownBoundary { found: name.to_owned() })
    }
}
