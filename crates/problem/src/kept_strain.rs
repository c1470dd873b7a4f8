use std::fmt;

/// States of a path whose plastic strain its file keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum KeptStrain {
    /// The last state.
    #[default]
    Last,
    /// The states at all waypoints, too.
    Waypoints,
}

impl KeptStrain {
    /// All choices.
    pub const ALL: [Self; 2] = [Self::Last, Self::Waypoints];

    /// Returns true for the choice without an option.
    pub fn is_default(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Last => "last",
            Self::Waypoints => "waypoints",
        }
    }

    /// Returns a description in one line.
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Last => "after the last step, and before its last increment",
            Self::Waypoints => "also at every waypoint: six numbers for each point of each cell",
        }
    }
}

impl fmt::Display for KeptStrain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
