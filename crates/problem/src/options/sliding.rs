//! Friction and wear.

use clap::Args;
use gfmd_interface::{LimitingPressure, Shear, Wear};
use gfmd_law::Limit;
use serde::{Deserialize, Serialize};

use super::{Kinds, Options, named, parse_choice};
use crate::{Unusable, WearBy, key};

/// Options of the friction between the surfaces.
#[derive(Args, Options, Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Contact")]
pub struct FrictionArgs {
    /// Friction coefficient (Coulomb), 0 for none; with a shear strength the smaller shear limit holds
    #[arg(long, value_name = "MU", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<f64>,
    /// Shear strength in contact (Tresca), stress; 0 for none
    #[arg(long, value_name = "TAU", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::STRESS)]
    pub shear_strength: Option<f64>,
    /// Pressure that sets the friction when a law acts
    #[arg(
        long,
        value_parser = parse_choice::<LimitingPressure>(),
        default_value_t = LimitingPressure::Repulsion,
    )]
    #[serde(with = "named", skip_serializing_if = "is_repulsion")]
    pub friction_of: LimitingPressure,
}

fn is_repulsion(pressure: &LimitingPressure) -> bool {
    *pressure == LimitingPressure::Repulsion
}

impl FrictionArgs {
    /// Returns true if there is friction.
    pub fn is_given(&self) -> bool {
        self.friction.is_some() || self.shear_strength.is_some()
    }

    /// Returns the shear between the surfaces.
    ///
    /// # Errors
    /// Returns an error for a coefficient or a strength that is no limit.
    pub fn shear(&self) -> Result<Option<Shear>, Unusable> {
        let (limit, option) = match (self.friction, self.shear_strength) {
            (None, None) => return Ok(None),
            (Some(coefficient), None) => (Limit::Coulomb(coefficient), "friction"),
            (None, Some(strength)) => (Limit::Tresca(strength), "shear_strength"),
            (Some(coefficient), Some(strength)) => {
                let option = if coefficient >= 0.0 { "shear_strength" } else { "friction" };
                (Limit::Orowan { coefficient, strength }, option)
            }
        };
        limit.check().map_err(|error| Unusable::input(key(option), error))?;
        Ok(Some(Shear { limit, pressure: self.friction_of }))
    }
}

/// Options of the wear of both surfaces.
#[derive(Args, Options, Clone, Copy, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Wear")]
pub struct WearArgs {
    /// Wear coefficient divided by hardness, for both surfaces together, 1/stress: wear depth per repulsion and sliding
    /// distance
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::WEAR)]
    pub coefficient: Option<f64>,
    /// Sliding that causes wear
    #[arg(long, value_parser = parse_choice::<WearBy>(), default_value_t = WearBy::Distance)]
    #[serde(with = "named", skip_serializing_if = "is_by_distance")]
    pub wear_by: WearBy,
}

fn is_by_distance(by: &WearBy) -> bool {
    *by == WearBy::Distance
}

impl WearArgs {
    /// Returns the fact of the wear.
    pub fn fact(&self) -> Option<WearBy> {
        self.coefficient.map(|_| self.wear_by)
    }

    /// Returns the wear; `None` without a coefficient.
    ///
    /// # Errors
    /// Returns an error for a coefficient that is not positive and finite.
    pub fn wear(&self) -> Result<Option<Wear>, Unusable> {
        let Some(found) = self.coefficient else { return Ok(None) };
        if !(found > 0.0 && found.is_finite()) {
            return Err(Unusable::value(key("coefficient"), found, "positive and finite"));
        }
        Ok(Some(match self.wear_by {
            WearBy::Distance => Wear { by_distance: found, by_slip: 0.0 },
            WearBy::Slip => Wear { by_distance: 0.0, by_slip: found },
        }))
    }
}
