use std::fmt;

/// The way in which the error of the numbers of a contact by its finite grid is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GridError {
    /// Not at all.
    None,
    /// From the solution alone.
    #[default]
    Estimate,
    /// From a second solution, on a grid of twice as many points along each side.
    Refine,
}

impl GridError {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::None, Self::Estimate, Self::Refine];

    /// True for the one that no option asks for.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Estimate => "estimate",
            Self::Refine => "refine",
        }
    }

    /// The description in one line.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::None => "not at all",
            Self::Estimate => "from the solution alone, at no cost: hard walls on periodic half-spaces",
            Self::Refine => {
                "from a second solution on a grid of twice as many points along each side, at five times the cost"
            }
        }
    }
}

impl fmt::Display for GridError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}
