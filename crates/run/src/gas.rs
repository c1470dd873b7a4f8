//! Gas in the gap of a contact, which conducts heat between the points in contact.

use clap::Args;
use gfmd_measure::{GapGas, Gas, UnknownGasState};
use gfmd_problem::options::{Kinds, Options, named_if, parse_choice};
use gfmd_problem::{SIZES, key, setting, words};
use gfmd_unit::Units;
use serde::{Deserialize, Serialize};

use gfmd_input::failure::Failure;

/// Options of the gas whose conductance is computed from the gap.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Measurements")]
pub struct GasArgs {
    /// Compute the conductance per area of this gas in the gap; lengths and stresses need a unit. For another gas use
    /// --gas-conductivity and --gas-jump
    #[arg(long, value_name = "GAS", value_parser = parse_choice::<Gas>())]
    #[serde(skip_serializing_if = "Option::is_none", with = "named_if")]
    pub gas: Option<Gas>,
    /// Temperature of the gas, from 200 to 1000 K; default: 300 K
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::TEMPERATURE)]
    pub gas_temperature: Option<f64>,
    /// Pressure of the gas, stress, at most 1 MPa; default: one atmosphere, 101325 Pa
    #[arg(long, value_name = "P", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::STRESS)]
    pub gas_pressure: Option<f64>,
    /// Thermal accommodation coefficients of both surfaces, above 0 and at most 1; default, for engineering surfaces:
    /// air 0.86, nitrogen 0.85, argon 0.85, helium 0.37, hydrogen 0.29
    #[arg(long, value_delimiter = ',', num_args = 1, value_name = "A1,A2", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gas_accommodation: Vec<f64>,
    /// Thermal conductivity of another gas, such as 26mW/(m*K); with --gas-jump, in place of --gas
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::CONDUCTIVITY)]
    pub gas_conductivity: Option<f64>,
    /// Temperature-jump length of both surfaces together, length: the gap with the thermal resistance of the gas next
    /// to the surfaces
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::LENGTH)]
    pub gas_jump: Option<f64>,
}

/// Gas that options describe.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GivenGas {
    /// Gas with known properties, in a state given in the units of the problem.
    Known {
        /// Gas.
        gas: Gas,
        /// Temperature, K.
        temperature: f64,
        /// Pressure, stress; an atmosphere if it is not given.
        pressure: Option<f64>,
        /// Accommodation coefficients of both surfaces.
        accommodation: [f64; 2],
    },
    /// Gas given by its numbers in the units of the problem.
    Numbers(GapGas),
}

impl GasArgs {
    /// Returns true if a gas is in the gap.
    pub fn is_given(&self) -> bool {
        self.gas.is_some() || self.gas_conductivity.is_some() || self.gas_jump.is_some()
    }

    /// Returns the gas; `None` without one.
    ///
    /// # Errors
    /// Returns an error for a number without its gas, for a gas given in both ways, and for numbers that are not
    /// positive.
    pub fn given(&self) -> Result<Option<GivenGas>, Failure> {
        let state = [
            ("gas_temperature", self.gas_temperature.is_some()),
            ("gas_pressure", self.gas_pressure.is_some()),
            ("gas_accommodation", !self.gas_accommodation.is_empty()),
        ];
        let of_state = state.iter().find(|(_, given)| *given).map(|(option, _)| key(option));
        match (self.gas, self.gas_conductivity, self.gas_jump) {
            (None, None, None) => match of_state {
                Some(option) => Err(Failure::value(option, "given", words!["left out without ", key("gas")])),
                None => Ok(None),
            },
            (Some(gas), None, None) => {
                let temperature = self.gas_temperature.unwrap_or(Gas::TEMPERATURE);
                let accommodation = match self.gas_accommodation[..] {
                    [] => [gas.accommodation(); 2],
                    [both] => [both; 2],
                    [first, second] => [first, second],
                    _ => {
                        let found = format!("{:?}", self.gas_accommodation);
                        return Err(Failure::value(key("gas_accommodation"), found, "one or two numbers"));
                    }
                };
                Ok(Some(GivenGas::Known { gas, temperature, pressure: self.gas_pressure, accommodation }))
            }
            (Some(gas), ..) => Err(Failure::value(
                key("gas"),
                gas,
                words!["left out with ", key("gas_conductivity"), " and ", key("gas_jump")],
            )),
            (None, Some(_), None) => {
                Err(Failure::missing("gas_jump", words!["it is needed with ", key("gas_conductivity")]))
            }
            (None, None, Some(_)) => {
                Err(Failure::missing("gas_conductivity", words!["it is needed with ", key("gas_jump")]))
            }
            (None, Some(conductivity), Some(jump)) => {
                if let Some(option) = of_state {
                    return Err(Failure::value(option, "given", words!["left out without ", key("gas")]));
                }
                for (option, value) in [("gas_conductivity", conductivity), ("gas_jump", jump)] {
                    if !SIZES.contains(&value) {
                        return Err(Failure::value(key(option), value, words!["positive and finite"]));
                    }
                }
                Ok(Some(GivenGas::Numbers(GapGas { conductivity, jump })))
            }
        }
    }
}

impl GivenGas {
    /// Returns the numbers of the gas in the units of a problem.
    ///
    /// # Errors
    /// Returns an error if the properties of the gas are not known in its state, or if lengths or stresses have no
    /// unit.
    pub fn in_units(self, units: &Units) -> Result<GapGas, Failure> {
        let (gas, temperature, pressure, accommodation) = match self {
            Self::Numbers(gas) => return Ok(gas),
            Self::Known { gas, temperature, pressure, accommodation } => (gas, temperature, pressure, accommodation),
        };
        let (Some(metre), Some(pascal)) = (units.metres(), units.pascals()) else {
            let missing = if units.metres().is_none() { setting("unit", "um") } else { setting("stress_unit", "Pa") };
            let allowed = words![
                "given with units of length and stress (",
                missing,
                "), or replaced by ",
                key("gas_conductivity"),
                " and ",
                key("gas_jump")
            ];
            return Err(Failure::value(key("gas"), gas, allowed));
        };
        let pressure = pressure.map_or(Gas::PRESSURE, |pressure| pressure * pascal);
        let in_si = gas.between(temperature, pressure, accommodation).map_err(|error| {
            let option = match error {
                UnknownGasState::Temperature { .. } => "gas_temperature",
                UnknownGasState::Pressure { .. } => "gas_pressure",
                UnknownGasState::Accommodation { .. } => "gas_accommodation",
            };
            Failure::input(key(option), error)
        })?;
        Ok(GapGas { conductivity: in_si.conductivity / (pascal * metre * metre), jump: in_si.jump / metre })
    }
}
