use gfmd_interface::{Shear, Wear};
use gfmd_medium::{Prony, Relaxes};

use crate::facts::{Friction, WearBy};
use crate::options::Plasticity;
use crate::rules::Facts;

/// Inelastic parts of a problem, whose states depend on what happened before.
#[derive(Clone, Default)]
pub struct Inelastic {
    /// Yielding of the body, with cells that [fit](Plasticity::cells).
    pub plasticity: Option<Plasticity>,
    /// Shear between the surfaces, with friction.
    pub shear: Option<Shear>,
    /// Relaxation of the body, which has its long-term moduli, and its moduli that relax.
    pub relaxation: Option<(Prony, Relaxes)>,
    /// Wear of both surfaces together.
    pub wear: Option<Wear>,
}

impl Inelastic {
    /// Returns the facts of a problem with these parts.
    #[must_use]
    pub fn of(&self, facts: Facts) -> Facts {
        Facts {
            yields: self.plasticity.is_some(),
            friction: self.shear.map(|shear| Friction::of(shear.limit)),
            relaxes: self.relaxation.as_ref().map(|(_, relaxes)| *relaxes),
            wear: self.wear.map(WearBy::of),
            ..facts
        }
    }
}
