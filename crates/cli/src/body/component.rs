//! Components of quantities to draw and compare.

use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::quantity::Quantity;
use super::rows::Slice;

/// Component of a quantity, with its name in files and its label in figures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Component {
    pub(super) quantity: Quantity,
    /// Index in the vector or tensor; 0 for a scalar.
    pub(super) index: usize,
    pub(super) name: &'static str,
    pub(super) label: &'static str,
}

const fn component(quantity: Quantity, index: usize, name: &'static str, label: &'static str) -> Component {
    Component { quantity, index, name, label }
}

/// Axes of the components of a tensor.
const PAIRS: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [1, 2], [0, 2], [0, 1]];

impl Component {
    pub(super) const ALL: [Self; 17] = [
        component(Quantity::Displacement, 0, "ux", "displacement *u*_x"),
        component(Quantity::Displacement, 1, "uy", "displacement *u*_y"),
        component(Quantity::Displacement, 2, "uz", "displacement *u*_z"),
        component(Quantity::Strain, 0, "exx", "strain *ε*_{xx}"),
        component(Quantity::Strain, 1, "eyy", "strain *ε*_{yy}"),
        component(Quantity::Strain, 2, "ezz", "strain *ε*_{zz}"),
        component(Quantity::Strain, 3, "eyz", "strain *γ*_{yz}"),
        component(Quantity::Strain, 4, "exz", "strain *γ*_{xz}"),
        component(Quantity::Strain, 5, "exy", "strain *γ*_{xy}"),
        component(Quantity::Stress, 0, "sxx", "stress *σ*_{xx}"),
        component(Quantity::Stress, 1, "syy", "stress *σ*_{yy}"),
        component(Quantity::Stress, 2, "szz", "stress *σ*_{zz}"),
        component(Quantity::Stress, 3, "syz", "stress *σ*_{yz}"),
        component(Quantity::Stress, 4, "sxz", "stress *σ*_{xz}"),
        component(Quantity::Stress, 5, "sxy", "stress *σ*_{xy}"),
        component(Quantity::VonMises, 0, "mises", "von Mises stress"),
        component(Quantity::EnergyDensity, 0, "energy", "elastic energy density"),
    ];

    /// Returns a parser of names; the help lists all.
    pub(super) fn parser() -> impl TypedValueParser<Value = Self> {
        PossibleValuesParser::new(Self::ALL.map(|component| component.name)).try_map(|name| {
            Self::ALL.into_iter().find(|component| component.name == name).ok_or("it is not a component")
        })
    }

    /// Returns the components of `quantities` in the plane of a slice (without one, of a row along x); on a plane of
    /// constant height, all components.
    pub(super) fn in_plane(quantities: &[Quantity], slice: Option<Slice>) -> Vec<Self> {
        let across = slice.map_or(1, Slice::axis);
        let lies_in = |component: &Self| match component.quantity {
            Quantity::Displacement => component.index != across,
            Quantity::Strain | Quantity::Stress => !PAIRS[component.index].contains(&across),
            Quantity::VonMises | Quantity::EnergyDensity => true,
        };
        let drawn = |component: &Self| quantities.contains(&component.quantity) && (across == 2 || lies_in(component));
        Self::ALL.into_iter().filter(drawn).collect()
    }

    /// Returns true if the component vanishes in plane strain.
    pub(super) fn is_out_of_plane(self) -> bool {
        match self.quantity {
            Quantity::Displacement => self.index == 1,
            Quantity::Strain | Quantity::Stress => matches!(self.index, 3 | 5),
            Quantity::VonMises | Quantity::EnergyDensity => false,
        }
    }
}
