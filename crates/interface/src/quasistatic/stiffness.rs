//! Stiffness of a state along a path.

use gfmd_contact::{GradientError, Refusal, Stiffness};
use gfmd_relax::Why;

use super::normal::{Normal, NormalState};
use super::{QuasistaticContact, QuasistaticState};

/// Reasons why a state along a path has no stiffness, or an inexact one.
#[derive(Debug, thiserror::Error)]
pub enum StiffnessError {
    /// The surfaces shear each other.
    #[error("not computed of surfaces that shear each other, whose shear changes with the load")]
    Sheared,
    /// A law acts across the gap of surfaces with a memory.
    #[error("not computed with a law on a body that relaxes, or on surfaces that yield or wear")]
    LawAndMemory,
    /// The state is of another kind of contact.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The law gives no stiffness.
    #[error(transparent)]
    Law(#[from] GradientError),
    /// The stiffness reached is less exact than requested.
    #[error("the error of the stiffness {:e} is {:.1e} ({why})", reached.value, reached.error)]
    Inexact {
        /// Stiffness reached.
        reached: Stiffness,
        /// Reason why the iterations ended.
        why: Why,
    },
}

impl QuasistaticContact {
    /// Computes the stiffness of `state`, d(mean pressure)/d(approach) in stress/length, to the relative error
    /// `tolerance` ([`Stiffness`]). It is the stiffness of an instant: points in contact stay in contact, points at the
    /// hardness keep their pressure, nothing wears off, and a body that relaxes has its instantaneous moduli.
    ///
    /// # Errors
    /// Returns the reason why there is no stiffness, or the stiffness reached with a larger error.
    pub fn stiffness(&self, state: &QuasistaticState, tolerance: f64) -> Result<Stiffness, StiffnessError> {
        if self.shear.is_some() || self.all_components {
            return Err(StiffnessError::Sheared);
        }
        let memory = self.medium.as_ref().zip(state.memory.as_ref());
        let affine = memory.map(|(medium, memory)| medium.begin(memory, 0.0)).transpose()?;
        let (length, stress) = (self.units.length(), self.units.stress());
        let scales = (&self.scaled, self.contact_modulus / self.units.modulus());
        let solved = state.normal.clone().times(1.0 / length, 1.0 / stress, scales);
        let found = match (&self.normal, &solved) {
            (Normal::Law(_), _) if affine.is_some() || self.wear.is_some() || self.hardness.is_some() => {
                return Err(StiffnessError::LawAndMemory);
            }
            (Normal::Law(interface), NormalState::Law(state)) => interface.stiffness(state)?,
            (Normal::Wall(_), NormalState::Wall(_)) => {
                let factor = affine.as_ref().map_or(1.0, |affine| affine.factor());
                let contact = match &affine {
                    Some(affine) => self.normal.stiffened(&affine.stiffening)?,
                    None => self.normal.clone(),
                };
                let divided = solved.to_step(factor, None, 0.0);
                let (Normal::Wall(contact), NormalState::Wall(state)) = (&contact, &divided) else {
                    return Err(Refusal::OtherKind.into());
                };
                let scaled = |found: Stiffness| Stiffness { value: factor * found.value, ..found };
                contact.stiffness(state, tolerance).map(scaled).map_err(|(reached, why)| StiffnessError::Inexact {
                    reached: self.given_stiffness(scaled(reached)),
                    why,
                })?
            }
            _ => return Err(Refusal::OtherKind.into()),
        };
        Ok(self.given_stiffness(found))
    }

    fn given_stiffness(&self, found: Stiffness) -> Stiffness {
        Stiffness { value: found.value * self.units.stress() / self.units.length(), ..found }
    }
}
