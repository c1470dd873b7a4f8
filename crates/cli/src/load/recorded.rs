//! The parts of a record that one kind of state alone has.

use gfmd_contact::{FullSolution, Residual, Solution, SqueezedSolution};
use gfmd_problem::Rest;

use super::{LawRecord, ResidualRecord};

impl ResidualRecord {
    /// The residuals of a state.
    pub(super) fn of(state: &Rest) -> Self {
        if let Some(law) = state.law() {
            let gfmd_interface::Residual { complementarity, penetration, wall_tension, load, .. } = law.residual;
            return Residual { complementarity, penetration, negative_pressure: wall_tension, load }.into();
        }
        if let Some(squeezed) = state.get::<SqueezedSolution>() {
            return squeezed.residual().into();
        }
        if let Some(steep) = state.steep() {
            return Self { lateral_displacement: Some(steep.lateral_residual), ..Self::of_wall(&steep.normal) };
        }
        if let Some(full) = state.get::<FullSolution>() {
            return Self { lateral_traction: Some(full.lateral_traction), ..Self::of_wall(&full.normal) };
        }
        state.get().map_or(Self::UNKNOWN, Self::of_wall)
    }

    fn of_wall(state: &Solution) -> Self {
        let saturation = state.plastic.as_ref().map(|plastic| plastic.saturation);
        Self { saturation, ..state.residual.into() }
    }

    /// The residuals of a state that is recorded as a step of a path.
    const UNKNOWN: Self = Self {
        complementarity: f64::NAN,
        penetration: f64::NAN,
        negative_pressure: f64::NAN,
        load: f64::NAN,
        saturation: None,
        lateral_traction: None,
        lateral_displacement: None,
    };
}

impl LawRecord {
    /// The scalars of the law, if one acts across the gap.
    pub(super) fn of(state: &Rest) -> Option<Self> {
        state.law().map(|law| Self {
            interface_energy: law.interface_energy,
            passed_instability: law.passed_instability,
            lowest_curvature: law.lowest_curvature,
            residual_equilibrium: law.residual.equilibrium,
        })
    }
}
