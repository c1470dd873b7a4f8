//! Materials by name: elastic constants with their sources.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use gfmd_problem::{key, words};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use crate::failure::Failure;

/// Key of the option that names a material.
pub const MATERIAL: &str = "material";

/// Keys of the options that a material replaces.
const REPLACED: [&str; 3] = ["young", "e_star", "poisson"];

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

/// Returns the material with a name.
///
/// # Errors
/// Returns an error that lists the known names.
pub fn material(name: &str) -> Result<&'static Material, Failure> {
    let names = || materials().keys().map(String::as_str).collect::<Vec<_>>().join(", ");
    materials().get(name).ok_or_else(|| Failure::value(key(MATERIAL), name, format!("one of {}", names())))
}

/// Returns the name of a material with its source, as results record it.
pub fn recorded(name: &str, material: &Material) -> String {
    format!("{name} ({})", material.source)
}

/// Returns true if a text is a name with its source already.
fn is_recorded(text: &str) -> bool {
    text.ends_with(')')
}

/// Returns a text that names a material as results record it, with the values of the options that it replaces; `None`
/// if the text is recorded already. `given` tells the options that are given beside it.
///
/// # Errors
/// Returns an error for an unknown name, and for a given option that the material replaces.
pub(crate) fn resolved(
    name: &str,
    given: impl Fn(&str) -> bool,
) -> Result<Option<(String, &'static Material)>, Failure> {
    if is_recorded(name) {
        return Ok(None);
    }
    let found = material(name)?;
    if given("compliance") {
        let allowed = words!["left out with ", key("compliance"), ", which describes the whole body"];
        return Err(Failure::value(key(MATERIAL), name, allowed));
    }
    match REPLACED.into_iter().find(|option| given(option)) {
        Some(option) => {
            let allowed = words!["given without ", key(option), ": it has a modulus and a Poisson's ratio"];
            Err(Failure::value(key(MATERIAL), name, allowed))
        }
        None => Ok(Some((recorded(name, found), found))),
    }
}

/// Puts the values of the material in a table of options in its place.
///
/// # Errors
/// The errors of [`resolved`].
pub(crate) fn of_table(table: &mut Table) -> Result<(), Failure> {
    let Some(name) = table.get(MATERIAL).and_then(Value::as_str).map(str::to_owned) else { return Ok(()) };
    if let Some((text, found)) = resolved(&name, |option| table.contains_key(option))? {
        table.insert(MATERIAL.into(), text.into());
        table.insert("young".into(), found.young.clone().into());
        table.insert("poisson".into(), found.poisson.into());
    }
    Ok(())
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
            let conductivity = material.conductivity.as_ref().map(|text| {
                let quantity = Quantity::parse(text).unwrap().unwrap();
                units.value(&quantity, "stress*length^2/time*temperature").unwrap()
            });
            assert!(conductivity.is_none_or(|conductivity| (0.01..1e3).contains(&conductivity)), "{name}");
            let parts = material.prony.iter().map(|(_, fraction)| fraction).sum::<f64>();
            assert!(parts < 1.0 && material.prony.is_empty() == material.relaxes.is_none(), "{name}");
            assert!(material.source.chars().any(|c| c.is_ascii_digit()) && !is_recorded(name), "{name}");
        }
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

    #[test]
    fn a_material_stands_for_its_values_once() {
        let mut table = Table::from_iter([(MATERIAL.to_owned(), "aluminium".into())]);
        of_table(&mut table).unwrap();
        assert_eq!(table["young"].as_str(), Some("70GPa"));
        let again = table.clone();
        of_table(&mut table).unwrap();
        assert_eq!(table, again);
        for key in REPLACED {
            let mut both = Table::from_iter([(MATERIAL.to_owned(), "aluminium".into()), (key.to_owned(), 0.2.into())]);
            assert!(of_table(&mut both).unwrap_err().to_string().contains("it must be given without"), "{key}");
        }
        let mut unknown = Table::from_iter([(MATERIAL.to_owned(), "mithril".into())]);
        assert!(of_table(&mut unknown).unwrap_err().to_string().contains("aluminium, copper-etp, fused-silica"));
    }
}
