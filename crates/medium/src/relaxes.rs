use std::fmt;
use std::str::FromStr;

/// Moduli that relax.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Relaxes {
    /// Shear and bulk modulus alike: Poisson's ratio is constant.
    #[default]
    Both,
    /// Shear modulus only: the bulk modulus is constant.
    Shear,
}

impl Relaxes {
    /// All variants.
    pub const ALL: [Self; 2] = [Self::Both, Self::Shear];

    /// Returns the name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Both => "both",
            Self::Shear => "shear",
        }
    }

    /// Returns a description in one line.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Both => "shear and bulk modulus alike, with a constant Poisson's ratio",
            Self::Shear => "the shear modulus, with a constant bulk modulus",
        }
    }
}

impl fmt::Display for Relaxes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Error: unknown name of the moduli that relax.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("it is {found}; it must be both or shear")]
pub struct UnknownRelaxes {
    /// Given name.
    pub found: String,
}

impl FromStr for Relaxes {
    type Err = UnknownRelaxes;

    fn from_str(name: &str) -> Result<Self, UnknownRelaxes> {
        let named = Self::ALL.into_iter().find(|relaxes| relaxes.name() == name);
        named.ok_or_else(|| UnknownRelaxes { found: name.to_owned() })
    }
}
