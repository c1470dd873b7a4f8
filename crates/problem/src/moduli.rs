use std::fmt;

/// Moduli that are given for a viscoelastic body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Moduli {
    /// Long-term moduli, after the relaxation of all branches.
    #[default]
    LongTerm,
    /// Moduli under an instantaneous load.
    Instantaneous,
}

impl Moduli {
    /// All choices.
    pub const ALL: [Self; 2] = [Self::LongTerm, Self::Instantaneous];

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::LongTerm => "long-term",
            Self::Instantaneous => "instantaneous",
        }
    }

    /// Returns a description in one line.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::LongTerm => "the fully relaxed moduli",
            Self::Instantaneous => "the moduli under an instantaneous load, as in ANSYS and Nastran",
        }
    }
}

impl fmt::Display for Moduli {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
