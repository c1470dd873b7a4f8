//! Quantities that can be computed, and their components.

use clap::ValueEnum;
use gfmd_body::{Deformation, Interior, InteriorError, State, Workspace};
use serde::{Deserialize, Serialize};

use super::{Plane, Side};

/// Quantity at every point of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Displacement
    Displacement,
    /// Strain; engineering shear strains
    Strain,
    /// Stress, tension positive
    Stress,
    /// Von Mises equivalent stress
    VonMises,
    /// Elastic energy per volume
    EnergyDensity,
}

/// Families of quantities that are computed together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Family {
    Displacement,
    Deformation,
}

/// Axes of a vector, and the indices of the axes of a line.
pub(super) const AXES: [&str; 3] = ["x", "y", "z"];
pub(super) const AXES_OF_A_LINE: [usize; 2] = [0, 2];

/// Components of a tensor, and the indices of the components that do not vanish in plane strain.
pub(super) const TENSOR: [&str; 6] = ["xx", "yy", "zz", "yz", "xz", "xy"];
pub(super) const TENSOR_OF_A_LINE: [usize; 4] = [0, 1, 2, 4];

impl Quantity {
    /// Returns the kind of its unit.
    pub(super) fn kind(self) -> &'static str {
        match self {
            Self::Displacement => "length",
            Self::Strain => "1",
            Self::Stress | Self::VonMises | Self::EnergyDensity => "stress",
        }
    }

    /// All quantities.
    pub const ALL: [Self; 5] = [Self::Displacement, Self::Strain, Self::Stress, Self::VonMises, Self::EnergyDensity];

    pub(super) fn family(self) -> Family {
        if self == Self::Displacement { Family::Displacement } else { Family::Deformation }
    }

    /// Returns true if the surface traction determines it, for any moduli with the same Poisson's ratio.
    pub(super) fn is_of_traction(self) -> bool {
        matches!(self, Self::Stress | Self::VonMises)
    }

    /// Returns true if the quantity has one component.
    pub(super) fn is_scalar(self) -> bool {
        matches!(self, Self::VonMises | Self::EnergyDensity)
    }

    /// Returns the name in a file.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Displacement => "displacement",
            Self::Strain => "strain",
            Self::Stress => "stress",
            Self::VonMises => "von_mises",
            Self::EnergyDensity => "energy_density",
        }
    }

    /// Returns a description.
    pub(super) fn long_name(self) -> &'static str {
        match self {
            Self::Displacement => "displacement, z upwards",
            Self::Strain => "strain, with engineering shear strains",
            Self::Stress => "stress, tension positive",
            Self::VonMises => "von Mises equivalent stress",
            Self::EnergyDensity => "elastic energy per volume",
        }
    }
}

/// Displacement on one plane, component after component.
pub(super) struct Displacement<'w> {
    axes: &'static [usize],
    values: &'w [f64],
}

impl Displacement<'_> {
    pub(super) fn points(&self) -> usize {
        self.values.len() / self.axes.len()
    }

    pub(super) fn at(&self, point: usize) -> [f64; 3] {
        let mut vector = [0.0; 3];
        for (&axis, component) in self.axes.iter().zip(self.values.chunks_exact(self.points())) {
            vector[axis] = component[point];
        }
        vector
    }
}

/// Fields of one family on one plane.
pub(super) enum Fields<'w> {
    Displacement(Displacement<'w>),
    Deformation(Deformation<'w>),
}

impl<'w> Fields<'w> {
    pub(super) fn at(
        interior: &Interior,
        family: Family,
        Plane { depth, side }: Plane,
        ws: &'w mut Workspace,
    ) -> Result<Self, InteriorError> {
        Ok(match family {
            Family::Displacement => {
                let axes = interior.components().axes();
                Self::Displacement(Displacement { axes, values: interior.displacement(depth, ws)? })
            }
            Family::Deformation if side == Some(Side::Below) => {
                Self::Deformation(interior.deformation_below(depth, ws)?)
            }
            Family::Deformation => Self::Deformation(interior.deformation(depth, ws)?),
        })
    }

    /// Writes the given components of a quantity at the given points, point by point; a scalar has component 0. A
    /// quantity of another family has no values here.
    pub(super) fn values(&self, quantity: Quantity, components: &[usize], points: &[usize], out: &mut Vec<f64>) {
        out.clear();
        match self {
            Self::Displacement(u) => {
                for vector in points.iter().map(|&point| u.at(point)) {
                    out.extend(components.iter().map(|&component| vector[component]));
                }
            }
            Self::Deformation(deformation) => {
                let tensor: fn(&State) -> [f64; 6] = match quantity {
                    Quantity::Displacement => return,
                    Quantity::Strain => |state| state.strain,
                    Quantity::Stress => |state| state.stress,
                    Quantity::VonMises => |state| [state.von_mises(); 6],
                    Quantity::EnergyDensity => |state| [state.energy_density(); 6],
                };
                for tensor in points.iter().map(|&point| tensor(&deformation.at(point))) {
                    out.extend(components.iter().map(|&component| tensor[component]));
                }
            }
        }
    }
}
