//! Options of the measurements.

use clap::Args as ClapArgs;
use gfmd_green::Height;
use gfmd_input::failure::Failure;
use gfmd_problem::options::{Kinds, Options, height, parse_height};
use gfmd_problem::{Facts, SIZES, key, words};
use gfmd_record::repulsion;
use gfmd_run::flow::FluidArgs;
use gfmd_run::gas::GasArgs;
use gfmd_run::series::{Asked, Chosen};
use serde::{Deserialize, Serialize};

/// Options of the measurements of each state.
#[derive(ClapArgs, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Measurements")]
pub(crate) struct MeasureArgs {
    /// Measure patches, distributions of pressure and gap, pressure spectrum, and conductance
    #[arg(long)]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(crate) statistics: bool,
    /// Depth of the electrodes of both conductors, for the conductance of --statistics, length, or inf
    #[arg(
        long,
        default_value_t = Height::Infinite,
        value_name = "H|inf",
        value_parser = parse_height,
        allow_negative_numbers = true
    )]
    #[serde(skip_serializing_if = "is_infinite", with = "height")]
    #[option(kinds = Kinds::LENGTH)]
    pub(crate) conductor_height: Height,
    /// Thermal conductivities of both conductors, such as 50W/(m*K),0.2W/(m*K); with --statistics they give the contact
    /// conductance per area
    #[arg(long, value_delimiter = ',', num_args = 1, value_name = "K1,K2", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::CONDUCTIVITY)]
    conductivity: Vec<f64>,
    /// Compute fluid flow through the gap along x and along y (Reynolds' equation)
    #[arg(long)]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(crate) flow: bool,
    #[command(flatten)]
    #[serde(flatten)]
    pub(crate) fluid: FluidArgs,
    #[command(flatten)]
    #[serde(flatten)]
    pub(crate) gas: GasArgs,
}

fn is_infinite(height: &Height) -> bool {
    *height == Height::Infinite
}

impl MeasureArgs {
    /// Adds the measurements to the facts of a problem.
    pub(crate) fn of(&self, facts: Facts) -> Facts {
        Facts {
            statistics: self.statistics,
            flow: self.flow,
            conducts: !self.conductivity.is_empty(),
            gas: self.gas.is_given(),
            leak: self.fluid.viscosity.is_some(),
            ..facts
        }
    }

    /// Returns the measurements without the flow.
    pub(crate) fn without_flow(&self) -> Self {
        Self { flow: false, ..self.clone() }
    }

    /// Adds the fluid, the gas and the conductivity to the parts of a problem.
    ///
    /// # Errors
    /// Returns an error for numbers that cannot be used.
    pub(crate) fn asked<'a>(&self, asked: Asked<'a>) -> Result<Asked<'a>, Failure> {
        let (fluid, conductivity) = (self.fluid.fluid(self.flow)?, self.series_conductivity()?);
        Ok(Asked { fluid, conductivity, gas: self.gas.given()?, ..asked })
    }

    /// Returns the conductivity of both conductors in series, 1/(1/k1 + 1/k2); `None` if it is not given.
    fn series_conductivity(&self) -> Result<Option<f64>, Failure> {
        let option = key("conductivity");
        match self.conductivity[..] {
            [] => Ok(None),
            _ if !self.statistics => {
                Err(Failure::value(option, "given", words!["left out without ", key("statistics")]))
            }
            [first, second] if [first, second].iter().all(|k| SIZES.contains(k)) => {
                Ok(Some(1.0 / (1.0 / first + 1.0 / second)))
            }
            [_, _] => Err(Failure::value(option, format!("{:?}", self.conductivity), "positive and finite")),
            _ => Err(Failure::value(option, format!("{:?}", self.conductivity), "two numbers, of both conductors")),
        }
    }

    /// Checks that the chosen fields of a run that may be resumed include the fields from which statistics are
    /// measured again.
    ///
    /// # Errors
    /// Returns an error that names the needed fields.
    pub(crate) fn check_resumed(&self, fields: &Chosen, facts: &Facts) -> Result<(), Failure> {
        if !self.statistics || fields.contact_and_gap(facts).is_some() {
            return Ok(());
        }
        let needed =
            words![format!("with {} and gap for ", repulsion(facts)), key("statistics"), " with ", key("resume")];
        Err(Failure::value(key("fields"), fields, needed))
    }
}
