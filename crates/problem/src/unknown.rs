use std::fmt;
use std::str::FromStr;

use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_response::NormalResponse;

/// Unknown components of the surface displacement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unknown {
    /// u_z; u_x and u_y follow from the pressure, as the lateral traction is zero.
    #[default]
    Normal,
    /// u_x, u_y and u_z; the lateral traction is zero. A dynamic solver moves all of them against a periodic hard wall.
    All,
    /// u_z, with u_x and u_y held at zero.
    Held,
}

impl Unknown {
    /// All choices.
    pub const ALL: [Self; 3] = [Self::Normal, Self::All, Self::Held];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::All => "all",
            Self::Held => "held",
        }
    }

    /// Returns a description in one line.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Normal => "u_z; u_x and u_y follow from the pressure at zero lateral traction",
            Self::All => "u_x, u_y and u_z, at zero lateral traction",
            Self::Held => "u_z, with u_x and u_y held at zero",
        }
    }

    /// Returns the normal response of a body with these unknowns.
    pub fn response(self, grid: Grid, body: &Body) -> NormalResponse {
        match self {
            Self::Normal | Self::All => NormalResponse::new(grid, body),
            Self::Held => NormalResponse::held_sideways(grid, body),
        }
    }
}

impl fmt::Display for Unknown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Error: no choice of components has the given name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the components are {found}; they must be one of normal, all, held")]
pub struct NoUnknown {
    /// Name given.
    pub found: String,
}

impl FromStr for Unknown {
    type Err = NoUnknown;

    fn from_str(name: &str) -> Result<Self, NoUnknown> {
        let named = Self::ALL.into_iter().find(|unknown| unknown.name() == name);
        named.ok_or_else(|| NoUnknown { found: name.to_owned() })
    }
}
