//! Materials by name: elastic constants with their sources.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use gfmd_problem::key;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// Material with a source.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Material {
    /// Young's modulus, a stress with its unit.
    pub young: String,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Yield stress with its unit, if the source has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub yield_stress: Option<String>,
    /// Hardness with its unit, mean pressure on the projected area of an indentation, if the source has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hardness: Option<String>,
    /// Thermal conductivity with its unit, if the source has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub conductivity: Option<String>,
    /// Relaxation times with their unit and fractions of the instantaneous modulus, if the source has them; Young's
    /// modulus is then the long-term one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub prony: Vec<(String, f64)>,
    /// Moduli that relax, as the option has it, with a Prony series.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relaxes: Option<String>,
    /// Source of the values.
    pub source: String,
}

/// Returns all materials by name.
pub fn materials() -> &'static BTreeMap<String, Material> {
    static ALL: OnceLock<BTreeMap<String, Material>> = OnceLock::new();
    ALL.get_or_init(|| toml::from_str(include_str!("../data/materials.toml")).unwrap_or_default())
}

/// Returns the material that an option names.
///
/// # Errors
/// Returns an error that lists the known names.
pub fn material(option: &str, name: &str) -> Result<&'static Material, Failure> {
    let names = || materials().keys().map(String::as_str).collect::<Vec<_>>().join(", ");
    materials().get(name).ok_or_else(|| Failure::value(key(option), name, format!("one of {}", names())))
}

#[cfg(test)]
mod tests {
    use gfmd_unit::{Quantity, Units};

    use super::*;

    #[test]
    fn every_material_has_usable_values_and_a_source() {
        assert!(materials().len() > 5, "{:?}", materials());
        let units = Units::new(Some("m"), Some("Pa"));
        for (name, material) in materials() {
            let stress = |text: &str| {
                let quantity = Quantity::parse(text).unwrap().unwrap();
                units.value(&quantity, "stress").unwrap()
            };
            let young = stress(&material.young);
            assert!((1e5..1e12).contains(&young) && (0.0..0.5).contains(&material.poisson), "{name}");
            // Polymers yield at strains of some percent.
            assert!(material.yield_stress.as_ref().is_none_or(|text| stress(text) < 0.05 * young), "{name}");
            // A plastic indentation has about three times the yield stress of the strained material.
            let bounds = material.yield_stress.as_ref().map_or(0.0, |text| 2.0 * stress(text))..0.1 * young;
            assert!(material.hardness.as_ref().is_none_or(|text| bounds.contains(&stress(text))), "{name}");
            let conductivity = material.conductivity.as_ref().map(|text| {
                let quantity = Quantity::parse(text).unwrap().unwrap();
                units.value(&quantity, "stress*length^2/time/temperature").unwrap()
            });
            assert!(conductivity.is_none_or(|conductivity| (0.01..1e3).contains(&conductivity)), "{name}");
            let parts = material.prony.iter().map(|(_, fraction)| fraction).sum::<f64>();
            assert!(parts < 1.0 && material.prony.is_empty() == material.relaxes.is_none(), "{name}");
            assert!(material.source.chars().any(|c| c.is_ascii_digit()) && !name.ends_with(')'), "{name}");
        }
    }

    #[test]
    fn hardness_is_the_vickers_number_of_its_source_on_the_projected_area() {
        let projected = 9.80665 / 68.0_f64.to_radians().sin();
        for (name, number, digits) in [("steel-100cr6", 746.0, 2), ("copper-hard", 106.0, 3)] {
            let expected = format!("{:.digits$}GPa", number * projected / 1e3);
            assert_eq!(materials()[name].hardness.as_ref(), Some(&expected));
        }
        assert_eq!(materials()["copper-annealed"].hardness, Some(format!("{:.0}MPa", 51.0 * projected)));
    }

    #[test]
    fn the_series_of_nitrile_rubber_has_the_moduli_of_its_source() {
        let nbr = &materials()["nbr"];
        let [long_term, bulk] = [400.0, 400e3];
        let young = 9.0 * bulk * long_term / (3.0 * bulk + long_term);
        let poisson = (3.0 * bulk - 2.0 * long_term) / (2.0 * (3.0 * bulk + long_term));
        assert_eq!((format!("{:.1}MPa", young / 1e3), format!("{poisson:.4}")), (nbr.young.clone(), "0.4995".into()));
        assert_eq!(format!("{:.4}", nbr.poisson), "0.4995");
        let branches = [("1s", 535.7), ("10s", 76.2), ("100s", 120.5), ("1000s", 21.3), ("10000s", 22.9)];
        let instantaneous = long_term + branches.iter().map(|(_, modulus)| modulus).sum::<f64>();
        assert_eq!(nbr.prony.len(), branches.len());
        for ((time, modulus), (listed, fraction)) in branches.iter().zip(&nbr.prony) {
            assert_eq!((time, format!("{:.5}", modulus / instantaneous)), (&&**listed, format!("{fraction:.5}")));
        }
    }
}
