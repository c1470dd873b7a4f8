//! The records in the file of a contact.

use gfmd_files::Reader;
use gfmd_green::BaseKind;
use gfmd_problem::{Facts, Lower, MovedBase, Support};
use gfmd_record::{Record, reason_of};
use toml::Value;

use crate::check::{Configuration, Kind};
use crate::choice::Choice;
use crate::failure::Failure;

/// The facts of the configuration of a contact, whose surface may be a `line`.
///
/// # Errors
/// A configuration of another kind; a name that is not known.
pub fn facts_of(config: &str, line: bool) -> Result<Facts, Failure> {
    let table = Configuration::read(Kind::Contact, config)?.into_table();
    let has = |key: &str| table.contains_key(key);
    let is = |key: &str| table.get(key).and_then(Value::as_bool).unwrap_or(false);
    let base: BaseKind = named(&table, "base")?;
    let support = if table.get("height").is_some_and(|height| height.as_str().is_none()) {
        Support::Slab(base)
    } else {
        Support::HalfSpace
    };
    let second = table.get("second_body").and_then(Value::as_array).map(|sheet| match sheet.len() {
        2 => Support::HalfSpace,
        _ => Support::Slab(BaseKind::Bonded),
    });
    Ok(Facts {
        law: match table.get("law").and_then(Value::as_str) {
            Some(name) => name.parse().map_err(|error| Failure::input("law", error))?,
            None => Facts::default().law,
        },
        hardness: has("hardness"),
        boundary: named(&table, "boundary")?,
        unknown: named(&table, "components")?,
        finite_slope: is("finite_slope"),
        lower: match (has("lower_surface"), has("lower_seed")) {
            (true, _) => Some(Lower::Surface),
            (_, true) => Some(Lower::Seed),
            _ => None,
        },
        support,
        layers: has("layer"),
        second,
        moved_base: match (has("base_displacement"), has("base_traction")) {
            (true, _) => Some(MovedBase::Displacement),
            (_, true) => Some(MovedBase::Traction),
            _ => None,
        },
        line,
        approach: has("displacement"),
        statistics: is("statistics"),
        flow: is("flow"),
        flow_threshold: is("flow_threshold"),
        ..Facts::default()
    })
}

/// The choice that a key names, or the default without the key.
fn named<T: Choice + Default>(table: &toml::Table, key: &str) -> Result<T, Failure> {
    let Some(name) = table.get(key).and_then(Value::as_str) else { return Ok(T::default()) };
    let found = T::all().iter().copied().find(|choice| choice.name() == name);
    let allowed = T::all().iter().map(|choice| choice.name()).collect::<Vec<_>>().join(", ");
    found.ok_or_else(|| Failure::value(key, name, format!("one of {allowed}")))
}

/// The records of all loads of a file. A number that the file does not have is NaN.
///
/// # Errors
/// A file that is no result of a contact.
pub fn records(reader: &Reader) -> Result<Vec<Record>, Failure> {
    let refuse = |error: gfmd_files::FileError| Failure::Input(error.to_string());
    let config = reader.text("/", "config").map_err(refuse)?;
    let line = reader.shape("/surface/height").map_err(refuse)?.get(1) == Some(&1);
    let facts = facts_of(&config, line)?;
    let shape = reader.shape("/loads/mean_pressure").map_err(refuse)?;
    let &[count] = &shape[..] else {
        let path = reader.path().display();
        return Err(Failure::Input(format!(
            "{path}: /loads/mean_pressure has the shape {shape:?}; it must be [loads]"
        )));
    };
    let mut columns = std::collections::BTreeMap::new();
    for column in gfmd_record::columns(&facts) {
        let path = format!("/loads/{}", column.name);
        let values = if reader.contains(&path) { reader.values::<f64>(&path).map_err(refuse)? } else { Vec::new() };
        if !values.is_empty() && values.len() != count {
            let file = reader.path().display();
            return Err(Failure::Input(format!(
                "{file}: {path} has the shape [{}]; it must be [{count}]",
                values.len()
            )));
        }
        columns.insert(column.name, (values, reader.text(&path, "undefined").ok()));
    }
    let record = |row: usize| {
        Record::stored(&facts, |column| {
            let (values, reasons) = &columns[column.name];
            let value = values.get(row).copied().unwrap_or(f64::NAN);
            (value, reasons.as_ref().filter(|_| value.is_nan()).and_then(|reasons| reason_of(reasons, row)))
        })
    };
    Ok((0..count).map(record).collect())
}
