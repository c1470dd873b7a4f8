//! Bodies from names and numbers: kinds of bases and stacks of layers.

use std::fmt;
use std::str::FromStr;

use crate::{Base, Body, GreenError, Ground, Material};

/// Named kinds of [`Base`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum BaseKind {
    /// Bonded to a rigid base.
    #[default]
    Bonded,
    /// On a rigid base without friction.
    Sliding,
    /// No base: a plate.
    Free,
    /// Bonded to an elastic half-space: a coating.
    HalfSpace,
}

impl BaseKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Bonded, Self::Sliding, Self::Free, Self::HalfSpace];

    /// Returns the name, a one-line description, and the ground; `None` for an elastic base.
    const fn row(self) -> (&'static str, &'static str, Option<Ground>) {
        match self {
            Self::Bonded => ("bonded", "bonded to a rigid base", Some(Ground::BONDED)),
            Self::Sliding => ("sliding", "on a frictionless rigid base", Some(Ground::SLIDING)),
            Self::Free => {
                ("free", "plate, balanced by an opposite mean traction on its lower face", Some(Ground::NONE))
            }
            Self::HalfSpace => ("half-space", "bonded to an elastic half-space: a coating", None),
        }
    }

    /// Returns the name on the command line and in configurations.
    pub const fn name(self) -> &'static str {
        self.row().0
    }

    /// Returns a one-line description.
    pub const fn meaning(self) -> &'static str {
        self.row().1
    }

    /// Returns the ground; `None` for an elastic base.
    pub const fn ground(self) -> Option<Ground> {
        self.row().2
    }

    /// Returns the base, given the material of a half-space below.
    ///
    /// # Errors
    /// Returns an error for an elastic half-space without a material, or another base with one.
    pub fn with(self, below: Option<Material>) -> Result<Base, GreenError> {
        match (self.ground(), below) {
            (Some(ground), None) => Ok(Base::Rigid(ground)),
            (None, Some(material)) => Ok(Base::Elastic(Box::new(Body::half_space(material)))),
            _ => Err(GreenError::BaseMaterial(self)),
        }
    }
}

impl fmt::Display for BaseKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Error of an unknown base name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the base is {found}; it must be one of {}", BaseKind::ALL.map(BaseKind::name).join(", "))]
pub struct UnknownBase {
    /// Name found.
    pub found: String,
}

impl FromStr for BaseKind {
    type Err = UnknownBase;

    fn from_str(name: &str) -> Result<Self, UnknownBase> {
        let named = Self::ALL.into_iter().find(|kind| kind.name() == name);
        named.ok_or_else(|| UnknownBase { found: name.to_owned() })
    }
}

impl Body {
    /// Creates a stack of layers from the top down, bonded to each other, each with a material and a thickness
    /// (length). `base` is below the lowest layer.
    ///
    /// # Errors
    /// Returns an error if there is no layer, a thickness is not positive and finite, or a pair of bodies is below.
    pub fn stack(layers: &[(Material, f64)], base: Base) -> Result<Self, GreenError> {
        let mut base = base;
        let (&(material, thickness), below) = layers.split_first().ok_or(GreenError::NoLayer)?;
        for &(material, thickness) in below.iter().rev() {
            base = Base::Elastic(Box::new(Self::slab(material, thickness)?.on(base)?));
        }
        Self::slab(material, thickness)?.on(base)
    }
}
