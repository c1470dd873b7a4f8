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
    /// The stiffness of a state at rest, if it is known, or as far as its solve came.
    ///
    /// # Errors
    /// The reason why the stiffness is less exact than it should be, beside it.
    fn stiffness_of(&self, _: &Self::State) -> Result<Option<Stiffness>, (Stiffness, String)> {
        Ok(None)
    }
}

impl Stiff for Contact {
    fn stiffness_of(&self, state: &Solution) -> Result<Option<Stiffness>, (Stiffness, String)> {
        self.stiffness(state).map(Some).map_err(|(reached, why)| {
            let text = format!("the error of the stiffness {:e} is {:.1e} ({why})", reached.value, reached.error);
            (reached, text)
        })
    }
}

impl Stiff for SteepContact {}

impl Stiff for Interface {}

impl Stiff for SqueezedContact {}

/// The discrete problem has a stiffness of its own in the Nyquist modes of an even grid, which is not computed.
impl Stiff for FullContact {}

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
