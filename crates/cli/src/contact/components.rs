use clap::ValueEnum;
use gfmd_contact::{Boundary, Contact, Refusal};
use gfmd_field::{Grid, Share};
use gfmd_green::Body;
use gfmd_law::Kind;
use gfmd_response::NormalResponse;
use ndarray::ArrayRef2;
use serde::Serialize;

/// The components of the surface displacement that are unknown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Unknown {
    /// u_z; u_x and u_y follow from the pressure, as the lateral traction is zero
    #[default]
    Normal,
    /// u_x, u_y and u_z, moved by damped dynamics; the lateral traction is zero
    All,
    /// u_z, with u_x and u_y held at zero
    Held,
}

impl Unknown {
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
    pub(super) fn is_normal(&self) -> bool {
        *self == Self::Normal
    }

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::All => "all",
            Self::Held => "held",
        }
    }

    /// The normal response of a body with these unknowns.
    pub fn response(self, grid: Grid, body: &Body) -> NormalResponse {
        match self {
            Self::Normal | Self::All => NormalResponse::new(grid, body),
            Self::Held => NormalResponse::held_sideways(grid, body),
        }
    }

    /// The contact of `body` with `heights` behind a hard wall, of the rows of a [`Share`], in units of its own size: the one that
    /// the program, its check and the Python package solve. Free boundaries have one process.
    ///
    /// # Errors
    /// Heights or a body that cannot be in contact.
    pub fn wall(
        self,
        boundary: Boundary,
        share: &Share,
        body: &Body,
        grid: &Grid,
        heights: &ArrayRef2<f64>,
    ) -> Result<Contact, Refusal> {
        match (self, boundary) {
            (Self::Held, _) => Contact::held_sideways_over(share, body, grid, heights),
            (_, Boundary::Periodic) => Contact::over(share, body, grid, heights),
            (_, Boundary::Free) => Contact::bounded(boundary, body, grid, heights),
        }
    }

    /// What a contact with these unknowns cannot have.
    pub fn clash(self, law: Kind, boundary: Boundary, is_plastic: bool, body: &Body) -> Option<&'static str> {
        match self {
            Self::Normal => None,
            _ if law != Kind::HardWall => Some("a law"),
            _ if boundary == Boundary::Free => Some("free boundaries"),
            Self::All if is_plastic => Some("a hardness"),
            Self::Held if body.second().is_some() => Some("a second body"),
            Self::All | Self::Held => None,
        }
    }
}
