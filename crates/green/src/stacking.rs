//! Bodies from names and numbers: kinds of bases, and stacks of layers.

use std::fmt;
use std::str::FromStr;

use crate::{Base, Body, GreenError, Material};

/// The kinds of [`Base`], by their names.
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

    /// The name on the command line and in configurations.
    pub fn name(self) -> &'static str {
        match self {
            Self::Bonded => "bonded",
            Self::Sliding => "sliding",
            Self::Free => "free",
            Self::HalfSpace => "half-space",
        }
    }

    /// A description in one line.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Bonded => "bonded to a rigid base",
            Self::Sliding => "on a rigid base without friction",
            Self::Free => "no base: a plate, held by the opposite of the mean traction on its lower face",
            Self::HalfSpace => "bonded to an elastic half-space: a coating",
        }
    }

    /// The base, with the material of the half-space below.
    ///
    /// # Errors
    /// An elastic half-space without its material, or a material for another base.
    pub fn with(self, below: Option<Material>) -> Result<Base, GreenError> {
        match (self, below) {
            (Self::Bonded, None) => Ok(Base::Bonded),
            (Self::Sliding, None) => Ok(Base::Sliding),
            (Self::Free, None) => Ok(Base::Free),
            (Self::HalfSpace, Some(material)) => Ok(Base::Elastic(Box::new(Body::half_space(material)))),
            _ => Err(GreenError::BaseMaterial(self)),
        }
    }
}

impl fmt::Display for BaseKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Error: no base has the given name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the base is {found}; it must be bonded, sliding, free or half-space")]
pub struct UnknownBase {
    /// The name given.
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
    /// A stack of layers from the top down, bonded to each other, each with a material and a thickness (length). `base`
    /// is below the lowest layer.
    ///
    /// # Errors
    /// No layer; a thickness that is not positive and finite; a pair of bodies below.
    pub fn stack(layers: &[(Material, f64)], base: Base) -> Result<Self, GreenError> {
        let mut base = base;
        let (&(material, thickness), below) = layers.split_first().ok_or(GreenError::NoLayer)?;
        for &(material, thickness) in below.iter().rev() {
            base = Base::Elastic(Box::new(Self::slab(material, thickness)?.on(base)?));
        }
        Self::slab(material, thickness)?.on(base)
    }
}
