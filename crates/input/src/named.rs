//! Options whose value is a name in a list, which stands for the values of other options: materials and fluids.

use gfmd_problem::{key, words};
use toml::Value;

use crate::failure::Failure;
use crate::fluids::fluid;
use crate::materials::material;

/// Name that an option takes.
#[derive(Clone, Copy)]
struct Named {
    option: &'static str,
    /// Keys of the options that the name replaces.
    replaced: &'static [&'static str],
    /// Properties that the name has in their place.
    has: &'static str,
    /// True if the name describes a part of the body.
    of_body: bool,
    meaning: fn(&'static str, &str) -> Result<Meaning, Failure>,
}

/// Source of a name, and the values of the options for which it stands.
struct Meaning {
    source: &'static str,
    values: Vec<(&'static str, Value)>,
}

/// Properties of a material in place of numbers.
const ELASTIC: &str = "it has a modulus and a Poisson's ratio";

const ALL: [Named; 3] = [
    Named {
        option: "material",
        replaced: &["young", "e_star", "poisson"],
        has: ELASTIC,
        of_body: true,
        meaning: |option, name| {
            let found = material(option, name)?;
            let values = vec![("young", found.young.clone().into()), ("poisson", found.poisson.into())];
            Ok(Meaning { source: &found.source, values })
        },
    },
    Named {
        option: "second_material",
        replaced: &["second_body"],
        has: ELASTIC,
        of_body: true,
        meaning: |option, name| {
            let found = material(option, name)?;
            let numbers = vec![Value::from(found.young.clone()), found.poisson.into()];
            Ok(Meaning { source: &found.source, values: vec![("second_body", numbers.into())] })
        },
    },
    Named {
        option: "fluid",
        replaced: &["viscosity"],
        has: "it has a viscosity",
        of_body: false,
        meaning: |option, name| {
            let found = fluid(option, name)?;
            Ok(Meaning { source: &found.source, values: vec![("viscosity", found.viscosity.clone().into())] })
        },
    },
];

/// Returns a name with its source, as results record it.
fn recorded(name: &str, source: &str) -> String {
    format!("{name} ({source})")
}

/// Returns true if a text is a name with its source already.
fn is_recorded(text: &str) -> bool {
    text.ends_with(')')
}

/// Puts values in the place of the names among the `given` options, which keep the names with their sources.
///
/// # Errors
/// Returns an error for an unknown name, and for a given option that a name replaces.
pub(crate) fn put_values(given: &mut Vec<(String, Value)>) -> Result<(), Failure> {
    let mut all = Vec::new();
    let text = |key: &str| find(given, key).map(|value| value.as_str().unwrap_or_default());
    for Named { option, replaced, has, of_body, meaning } in ALL {
        let Some(name) = text(option).filter(|name| !is_recorded(name)) else { continue };
        let Meaning { source, values } = meaning(option, name)?;
        if of_body && text("compliance").is_some() {
            let allowed = words!["left out with ", key("compliance"), ", which describes the whole body"];
            return Err(Failure::value(key(option), name, allowed));
        }
        if let Some(&other) = replaced.iter().find(|other| text(other).is_some()) {
            let allowed = words!["given without ", key(other), format!(": {has}")];
            return Err(Failure::value(key(option), name, allowed));
        }
        all.push((option, recorded(name, source), values));
    }
    for (option, recorded, values) in all {
        let own = given.iter_mut().filter(|(key, _)| key == option);
        own.for_each(|(_, value)| *value = recorded.as_str().into());
        given.extend(values.into_iter().map(|(key, value)| (key.to_owned(), value)));
    }
    Ok(())
}

/// Returns the first value given for an option.
pub(crate) fn find<'a>(given: &'a [(String, Value)], key: &str) -> Option<&'a Value> {
    given.iter().find(|(other, _)| other == key).map(|(_, value)| value)
}

/// Returns a value as a flag takes it.
pub(crate) fn text(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(all) => all.iter().map(text).collect::<Vec<_>>().join(","),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given(entries: &[(&str, Value)]) -> Vec<(String, Value)> {
        entries.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect()
    }

    #[test]
    fn a_name_stands_for_its_values_once() {
        let mut found = given(&[
            ("material", "aluminium".into()),
            ("second_material", "steel-s355".into()),
            ("fluid", "water".into()),
        ]);
        put_values(&mut found).unwrap();
        let shown = |key: &str| text(find(&found, key).unwrap());
        assert_eq!([shown("young"), shown("poisson"), shown("second_body")], ["70GPa", "0.3", "210GPa,0.3"]);
        assert_eq!(shown("viscosity"), "1.0016mPa*s");
        assert!(ALL.iter().all(|named| is_recorded(&shown(named.option))));
        let again = found.clone();
        put_values(&mut found).unwrap();
        assert_eq!(found, again);
    }

    #[test]
    fn a_name_is_refused_beside_what_it_replaces_and_if_it_is_unknown() {
        for Named { option, replaced, of_body, .. } in ALL {
            let name = if of_body { "aluminium" } else { "water" };
            for &other in replaced {
                let mut both = given(&[(option, name.into()), (other, 0.2.into())]);
                let said = put_values(&mut both).unwrap_err().to_string();
                assert!(said.contains("it must be given without"), "{said}");
            }
            let mut unknown = given(&[(option, "mithril".into())]);
            let said = put_values(&mut unknown).unwrap_err().to_string();
            assert!(said.contains("mithril; it must be one of") && said.contains(name), "{said}");
            let mut whole = given(&[(option, name.into()), ("compliance", "1:1,100:0.01".into())]);
            assert_eq!(put_values(&mut whole).is_err(), of_body, "{option}");
        }
    }
}
