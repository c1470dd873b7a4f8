//! What a state must tell to be recorded as a load.

use gfmd_contact::{
    Contact, Equilibrium, Fields, FullContact, FullSolution, Plastic, Residual, Solution, SqueezedContact,
    SqueezedSolution, SteepContact, SteepSolution, Stiffness,
};
use gfmd_interface::{Interface, State};
use ndarray::Array2;

use super::{LawRecord, ResidualRecord};

/// A contact whose states are recorded with their stiffness.
pub trait Stiff: Equilibrium {
    /// The stiffness of a state at rest.
    ///
    /// # Errors
    /// The reason why there is none, or why it is less exact than it should be.
    fn stiffness_of(&self, state: &Self::State) -> Result<Stiffness, NoStiffness>;
}

/// The reasons why a contact has no stiffness, or not the one that it should have.
#[derive(Clone, Debug, PartialEq)]
pub enum NoStiffness {
    /// It is not computed.
    Undefined(&'static str),
    /// It is less exact than it should be: as far as its solve came, and the remark.
    Inexact(Stiffness, String),
}

impl Stiff for Contact {
    fn stiffness_of(&self, state: &Solution) -> Result<Stiffness, NoStiffness> {
        self.stiffness(state).map_err(|(reached, why)| {
            let text = format!("the error of the stiffness {:e} is {:.1e} ({why})", reached.value, reached.error);
            NoStiffness::Inexact(reached, text)
        })
    }
}

/// Contacts whose stiffness is not computed, each with its reason.
macro_rules! without_stiffness {
    ($($contact:ident: $reason:literal),+) => {
        $(impl Stiff for $contact {
            fn stiffness_of(&self, _: &Self::State) -> Result<Stiffness, NoStiffness> {
                Err(NoStiffness::Undefined($reason))
            }
        })+
    };
}

without_stiffness! {
    SteepContact: "not computed with finite slopes: the points in contact move sideways with the load",
    Interface: "not computed with a law across the gap: it acts on all points, not on those in contact alone",
    SqueezedContact: "not computed of a slab between two surfaces, which has two contacts",
    FullContact: "not computed with all components: the Nyquist modes of an even grid have a stiffness of their own"
}

/// A state that can be recorded as a load.
pub trait Recorded: Fields {
    /// The residuals of the state.
    fn residual_record(&self) -> ResidualRecord;

    /// What gives way, if the contact has a hardness.
    fn plastic(&self) -> Option<&Plastic> {
        None
    }

    /// The contact with a surface below, as seen from there.
    fn lower(&self) -> Option<&Solution> {
        None
    }

    /// The lateral displacement u_x, u_y (u_x of a profile), if it was unknown, too.
    fn lateral(&self) -> &[Array2<f64>] {
        &[]
    }

    /// The scalars of the law, if one acts across the gap.
    fn law_record(&self) -> Option<LawRecord> {
        None
    }

    /// The state, if slopes are finite.
    fn steep(&self) -> Option<&SteepSolution> {
        None
    }
}

impl Recorded for SteepSolution {
    fn residual_record(&self) -> ResidualRecord {
        ResidualRecord { lateral_displacement: Some(self.lateral_residual), ..self.normal.residual_record() }
    }

    fn lateral(&self) -> &[Array2<f64>] {
        &self.lateral
    }

    fn steep(&self) -> Option<&SteepSolution> {
        Some(self)
    }
}

impl Recorded for FullSolution {
    fn residual_record(&self) -> ResidualRecord {
        ResidualRecord { lateral_traction: Some(self.lateral_traction), ..self.normal.residual_record() }
    }

    fn lateral(&self) -> &[Array2<f64>] {
        &self.lateral
    }
}

impl Recorded for Solution {
    fn residual_record(&self) -> ResidualRecord {
        let saturation = self.plastic.as_ref().map(|plastic| plastic.saturation);
        ResidualRecord { saturation, ..self.residual.into() }
    }

    fn plastic(&self) -> Option<&Plastic> {
        self.plastic.as_ref()
    }
}

impl Recorded for SqueezedSolution {
    fn residual_record(&self) -> ResidualRecord {
        self.residual().into()
    }

    fn lower(&self) -> Option<&Solution> {
        Some(&self.lower)
    }
}

impl Recorded for State {
    fn residual_record(&self) -> ResidualRecord {
        let gfmd_interface::Residual { complementarity, penetration, wall_tension, load, .. } = self.residual;
        Residual { complementarity, penetration, negative_pressure: wall_tension, load }.into()
    }

    fn law_record(&self) -> Option<LawRecord> {
        Some(LawRecord {
            interface_energy: self.interface_energy,
            passed_instability: self.passed_instability,
            lowest_curvature: self.lowest_curvature,
            residual_equilibrium: self.residual.equilibrium,
        })
    }
}
