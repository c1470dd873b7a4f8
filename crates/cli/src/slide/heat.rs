//! The flash temperature of steady sliding: its flags, and its numbers.

use clap::Args;
use gfmd_contact::Budget;
use gfmd_field::Grid;
use gfmd_heat::{Flash, HeatError, Heated, Thermal, Watch};
use gfmd_input::failure::Failure;
use gfmd_medium::Velocity;
use gfmd_problem::options::{Kinds, Options};
use gfmd_problem::{key, words};
use ndarray::Array2;
use serde::{Deserialize, Serialize};

/// Flags of the heat that friction makes.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Flash temperature")]
pub(super) struct HeatArgs {
    /// Thermal conductivity and diffusivity of the body, then of the rough surface if it shares the heat
    #[arg(long, value_delimiter = ',', value_name = "K,ALPHA[,K2,ALPHA2]", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::HEAT)]
    heat: Vec<f64>,
}

/// The heat that friction makes: its coefficient, and the properties of the body and of the rough surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source {
    friction: f64,
    body: Thermal,
    indenter: Option<Thermal>,
}

impl HeatArgs {
    /// Returns the requested heat, which this `friction` makes; `None` without heat.
    pub(super) fn source(&self, friction: Option<f64>) -> Result<Option<Source>, Failure> {
        let thermal = |conductivity: f64, diffusivity: f64| {
            Thermal::new(conductivity, diffusivity).map_err(|error| Failure::input(key("heat"), error))
        };
        let (body, indenter) = match (&self.heat[..], friction) {
            ([], _) => return Ok(None),
            (_, None) => return Err(Failure::missing("friction", words!["it is needed with ", key("heat")])),
            ([k, alpha], _) => (thermal(*k, *alpha)?, None),
            ([k, alpha, k2, alpha2], _) => (thermal(*k, *alpha)?, Some(thermal(*k2, *alpha2)?)),
            (found, _) => {
                let allowed = "two, or four with the two of the rough surface";
                return Err(Failure::refused(words![
                    key("heat"),
                    format!(" has {} numbers; it must have {allowed}", found.len())
                ]));
            }
        };
        match friction {
            Some(friction) if friction > 0.0 => Ok(Some(Source { friction, body, indenter })),
            found => {
                let allowed = words!["positive with ", key("heat")];
                Err(Failure::value(key("friction"), found.unwrap_or(f64::NAN), allowed))
            }
        }
    }
}

impl Source {
    /// True if the heat is shared between two bodies.
    pub(super) fn is_shared(&self) -> bool {
        self.indenter.is_some()
    }

    fn flash(&self, grid: &Grid, velocity: &Velocity) -> Result<Flash, HeatError> {
        let along = velocity.direction().map(|direction| velocity.speed() * direction);
        Flash::new(*grid, along, self.body, self.indenter)
    }

    /// The heat flux that the friction of a pressure makes.
    fn flux(&self, velocity: &Velocity, pressure: &Array2<f64>) -> Array2<f64> {
        // Where the search leaves an attraction, there is no contact.
        pressure.mapv(|p| self.friction * velocity.speed() * if p > 0.0 { p } else { 0.0 })
    }

    /// The temperature under a pressure.
    pub(super) fn heat(
        &self,
        grid: &Grid,
        velocity: &Velocity,
        pressure: &Array2<f64>,
        budget: &Budget,
        watch: &mut dyn Watch,
    ) -> Result<Heated, HeatError> {
        self.flash(grid, velocity)?.heat(&self.flux(velocity, pressure), budget, watch)
    }

    /// Recomputes the temperature under a pressure; `into_body` is the heat flux into the body, all of it if `None`.
    pub(super) fn certify(
        &self,
        grid: &Grid,
        velocity: &Velocity,
        pressure: &Array2<f64>,
        into_body: Option<&Array2<f64>>,
    ) -> Result<Heated, HeatError> {
        let flux = self.flux(velocity, pressure);
        self.flash(grid, velocity)?.certify(&flux, into_body.unwrap_or(&flux))
    }
}
