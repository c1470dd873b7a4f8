//! Options whose value is a name in a list, which stands for the values of other options: materials and fluids.

use gfmd_problem::{flag, key, words};
use toml::{Table, Value};

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

/// Option with its value as results record it, and the values for which it stands.
pub(crate) struct Resolved {
    /// Key of the option.
    pub option: &'static str,
    /// Name with its source.
    pub recorded: String,
    /// Values of other options.
    pub values: Vec<(&'static str, Value)>,
}

/// Returns a name with its source, as results record it.
fn recorded(name: &str, source: &str) -> String {
    format!("{name} ({source})")
}

/// Returns true if a text is a name with its source already.
fn is_recorded(text: &str) -> bool {
    text.ends_with(')')
}

/// Returns the meaning of each name among options. `value` returns the text of an option that is given.
///
/// # Errors
/// Returns an error for an unknown name, and for a given option that a name replaces.
pub(crate) fn resolved<'a>(value: impl Fn(&str) -> Option<&'a str>) -> Result<Vec<Resolved>, Failure> {
    let mut all = Vec::new();
    for Named { option, replaced, has, of_body, meaning } in ALL {
        let Some(name) = value(option).filter(|name| !is_recorded(name)) else { continue };
        let Meaning { source, values } = meaning(option, name)?;
        if of_body && value("compliance").is_some() {
            let allowed = words!["left out with ", key("compliance"), ", which describes the whole body"];
            return Err(Failure::value(key(option), name, allowed));
        }
        if let Some(&other) = replaced.iter().find(|other| value(other).is_some()) {
            let allowed = words!["given without ", key(other), format!(": {has}")];
            return Err(Failure::value(key(option), name, allowed));
        }
        all.push(Resolved { option, recorded: recorded(name, source), values });
    }
    Ok(all)
}

/// Puts the values of the names in a table of options in their place.
///
/// # Errors
/// The errors of [`resolved`].
pub(crate) fn of_table(table: &mut Table) -> Result<(), Failure> {
    let found = resolved(|option| table.get(option).map(|value| value.as_str().unwrap_or_default()))?;
    for Resolved { option, recorded, values } in found {
        table.insert(option.into(), recorded.into());
        table.extend(values.into_iter().map(|(key, value)| (key.to_owned(), value)));
    }
    Ok(())
}

/// Returns the flag of an option with `=`, and its value, as words of a command line have them.
pub(crate) fn in_words(option: &str, value: &Value) -> (String, String) {
    (format!("{}=", flag(option)), text(value))
}

/// Returns a value as a flag takes it.
fn text(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(all) => all.iter().map(text).collect::<Vec<_>>().join(","),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(entries: &[(&str, Value)]) -> Table {
        entries.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect()
    }

    #[test]
    fn a_name_stands_for_its_values_once() {
        let mut found = table(&[
            ("material", "aluminium".into()),
            ("second_material", "steel-s355".into()),
            ("fluid", "water".into()),
        ]);
        of_table(&mut found).unwrap();
        assert_eq!((found["young"].as_str(), found["poisson"].as_float()), (Some("70GPa"), Some(0.3)));
        let second: Vec<Value> = vec!["210GPa".into(), 0.3.into()];
        assert_eq!(found["second_body"], Value::from(second));
        assert_eq!(in_words("second_body", &found["second_body"]), ("--second-body=".into(), "210GPa,0.3".into()));
        assert_eq!(found["viscosity"].as_str(), Some("1.0016mPa*s"));
        assert!(ALL.iter().all(|named| is_recorded(found[named.option].as_str().unwrap())));
        let again = found.clone();
        of_table(&mut found).unwrap();
        assert_eq!(found, again);
    }

    #[test]
    fn a_name_is_refused_beside_what_it_replaces_and_if_it_is_unknown() {
        for Named { option, replaced, of_body, .. } in ALL {
            let name = if of_body { "aluminium" } else { "water" };
            for &other in replaced {
                let mut both = table(&[(option, name.into()), (other, 0.2.into())]);
                let said = of_table(&mut both).unwrap_err().to_string();
                assert!(said.contains("it must be given without"), "{said}");
            }
            let mut unknown = table(&[(option, "mithril".into())]);
            let said = of_table(&mut unknown).unwrap_err().to_string();
            assert!(said.contains("mithril; it must be one of") && said.contains(name), "{said}");
            let mut whole = table(&[(option, name.into()), ("compliance", "1:1,100:0.01".into())]);
            assert_eq!(of_table(&mut whole).is_err(), of_body, "{option}");
        }
    }
}
