//! Flow of a fluid through the gap of a contact, by Reynolds' equation.

use clap::Args;
use gfmd_flow::{Flow, FlowError, Fluid, Wanted, flow};
use gfmd_problem::options::{Kinds, Options};
use gfmd_problem::{SIZES, key, words};
use ndarray::{Array2, ArrayView2, Zip};
use serde::{Deserialize, Serialize};

use gfmd_input::failure::Failure;
use gfmd_input::source::Surface;

/// Options of the fluid whose leak is computed from the flow.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Measurements")]
pub struct FluidArgs {
    /// Fluid that sets the viscosity, in place of --viscosity. gfmd materials lists the names with their sources
    #[arg(long, value_name = "NAME")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fluid: Option<String>,
    /// Viscosity of the fluid, stress * time, such as 1mPa*s; with --flow and --pressure-drop it gives the leak along x
    /// and along y, volume per time
    #[arg(long, value_name = "ETA", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::VISCOSITY)]
    pub viscosity: Option<f64>,
    /// Pressure drop across the cell in the direction of flow, stress, such as 1bar
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::STRESS)]
    pub pressure_drop: Option<f64>,
}

impl FluidArgs {
    /// Returns the fluid; `None` without one. `flow` is true if the flow is computed.
    ///
    /// # Errors
    /// Returns an error for one number without the other, without the flow, and for numbers that are not positive.
    pub fn fluid(&self, flow: bool) -> Result<Option<Fluid>, Failure> {
        let Self { fluid, viscosity, pressure_drop } = self;
        let given = [
            ("fluid", fluid.is_some()),
            ("viscosity", viscosity.is_some()),
            ("pressure_drop", pressure_drop.is_some()),
        ];
        if let (false, Some((option, _))) = (flow, given.iter().find(|(_, is_given)| *is_given)) {
            return Err(Failure::value(key(option), "given", words!["left out without ", key("flow")]));
        }
        // The viscosity of a fluid is an option, too, once it is looked up.
        if let (Some(name), None) = (fluid, viscosity) {
            return Err(Failure::value(key("fluid"), name, words!["given with ", key("viscosity"), ", its viscosity"]));
        }
        match (self.viscosity, self.pressure_drop) {
            (None, None) => Ok(None),
            (Some(_), None) => {
                let named = if fluid.is_some() { "fluid" } else { "viscosity" };
                Err(Failure::missing("pressure_drop", words!["it is needed with ", key(named)]))
            }
            (None, Some(_)) => Err(Failure::missing("viscosity", words!["it is needed with ", key("pressure_drop")])),
            (Some(viscosity), Some(pressure_drop)) => {
                for (option, value) in [("viscosity", viscosity), ("pressure_drop", pressure_drop)] {
                    if !SIZES.contains(&value) {
                        return Err(Failure::value(key(option), value, words!["positive and finite"]));
                    }
                }
                Ok(Some(Fluid { viscosity, pressure_drop }))
            }
        }
    }
}

/// Computes the flow through the gap, relative to a uniform gap equal to the mean gap; points with a positive
/// `pressure` are closed. Soft surfaces may overlap so far that their mean gap is not positive. The flow is then
/// relative to a uniform gap equal to the largest one, and only its paths have a meaning. Only [`Wanted::Fields`] gives
/// paths. `warn` receives a message if the flow is less exact than it should be.
///
/// # Errors
/// Returns an error if the flow cannot be computed.
pub fn through(
    surface: &Surface,
    [pressure, gap]: [ArrayView2<f64>; 2],
    mean_gap: f64,
    wanted: Wanted,
    warn: impl FnOnce(String),
) -> Result<Flow, Failure> {
    let scale = if mean_gap > 0.0 { mean_gap } else { gap.fold(f64::MIN_POSITIVE, |largest, gap| largest.max(*gap)) };
    let mut cubes = Array2::zeros(gap.dim());
    Zip::from(&mut cubes).and(gap).and(pressure).for_each(|cube, gap, p| {
        *cube = if *p > 0.0 || *gap <= 0.0 { 0.0 } else { (gap / scale).powi(3) };
    });
    match flow(&surface.grid, cubes.view(), surface.boundary, wanted) {
        Err(FlowError::NotConverged { state, .. }) => {
            warn(format!("the residual of the flow is {:.1e}", state.worst()));
            Ok(*state)
        }
        found => found.map_err(|error| Failure::computation(error.to_string())),
    }
}
