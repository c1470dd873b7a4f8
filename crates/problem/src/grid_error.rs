use std::fmt;

/// Method to find the grid error of the numbers of a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GridError {
    /// No error estimate.
    None,
    /// Estimate from the solution alone.
    #[default]
    Estimate,
    /// Estimate from a second solution on a grid with twice as many points along each side.
    Refine,
}

impl GridError {
    /// All methods.
    pub const ALL: [Self; 3] = [Self::None, Self::Estimate, Self::Refine];

    /// Returns true for the method that is used without an option.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Estimate => "estimate",
            Self::Refine => "refine",
        }
    }

    /// Returns a description in one line.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::None => "not at all",
            Self::Estimate => "from the solution alone, at no cost: hard walls on periodic half-spaces",
            Self::Refine => "from a second solution with twice as many points along each side, at five times the cost",
        }
    }
}

impl fmt::Display for GridError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
