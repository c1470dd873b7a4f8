//! Fluids by name: viscosities with their sources.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use gfmd_problem::key;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// Fluid with a source.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Fluid {
    /// Dynamic viscosity with its unit.
    pub viscosity: String,
    /// Source of the value, and its temperature.
    pub source: String,
}

/// Returns all fluids by name.
pub fn fluids() -> &'static BTreeMap<String, Fluid> {
    static ALL: OnceLock<BTreeMap<String, Fluid>> = OnceLock::new();
    ALL.get_or_init(|| toml::from_str(include_str!("../data/fluids.toml")).unwrap_or_default())
}

/// Returns the fluid that an option names.
///
/// # Errors
/// Returns an error that lists the known names.
pub fn fluid(option: &str, name: &str) -> Result<&'static Fluid, Failure> {
    let names = || fluids().keys().map(String::as_str).collect::<Vec<_>>().join(", ");
    fluids().get(name).ok_or_else(|| Failure::value(key(option), name, format!("one of {}", names())))
}

#[cfg(test)]
mod tests {
    use gfmd_unit::{Quantity, Units};

    use super::*;

    fn viscosity(name: &str) -> f64 {
        let quantity = Quantity::parse(&fluids()[name].viscosity).unwrap().unwrap();
        Units::new(Some("m"), Some("Pa")).value(&quantity, "stress*time").unwrap()
    }

    #[test]
    fn every_fluid_has_a_viscosity_and_a_source_with_a_temperature() {
        assert!(fluids().len() > 4, "{:?}", fluids());
        for (name, fluid) in fluids() {
            assert!((1e-6..10.0).contains(&viscosity(name)), "{name}");
            assert!(fluid.source.contains(" C") && !name.ends_with(')'), "{name}");
        }
    }

    #[test]
    fn air_follows_the_law_of_the_gas_and_water_the_formulation_of_2008() {
        let air = 1.716e-5 * (293.15_f64 / 273.0).powf(1.5) * (273.0 + 111.0) / (293.15 + 111.0);
        assert!((viscosity("air") / air - 1.0).abs() < 1e-3, "{air}");
        // IAPWS 2008, without the critical enhancement: Huber et al., J. Phys. Chem. Ref. Data 38 (2009) 101.
        let (t, rho) = (293.15 / 647.096, 998.2_f64 / 322.0);
        let dilute = 100.0 * f64::sqrt(t) / (1.677_52 + 2.204_62 / t + 0.636_656_4 / (t * t) - 0.241_605 / (t * t * t));
        let coefficients = [
            (0, 0, 0.520_094),
            (1, 0, 0.085_089_5),
            (2, 0, -1.083_74),
            (3, 0, -0.289_555),
            (0, 1, 0.222_531),
            (1, 1, 0.999_115),
            (2, 1, 1.887_97),
            (3, 1, 1.266_13),
            (5, 1, 0.120_573),
            (0, 2, -0.281_378),
            (1, 2, -0.906_851),
            (2, 2, -0.772_479),
            (3, 2, -0.489_837),
            (4, 2, -0.257_040),
            (0, 3, 0.161_913),
            (1, 3, 0.257_399),
            (0, 4, -0.032_537_2),
            (3, 4, 0.069_845_2),
            (4, 5, 0.008_721_02),
            (3, 6, -0.004_356_73),
            (5, 6, -0.000_593_264),
        ];
        let sum: f64 = coefficients.iter().map(|(i, j, h)| (1.0 / t - 1.0).powi(*i) * h * (rho - 1.0).powi(*j)).sum();
        let water = 1e-6 * dilute * (rho * sum).exp();
        assert!((viscosity("water") / water - 1.0).abs() < 1e-4, "{water}");
    }
}
