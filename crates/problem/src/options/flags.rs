//! Groups of flags as data: their defaults, and what a configuration says of them.

use clap::{Args, Command};
use serde::Serialize;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::Options;
use super::given::Arrays;
use crate::Unusable;

/// The longest value in a message.
const LONGEST: usize = 200;

/// Flags with a default that go with another flag alone.
const BESIDE: [(&str, &str); 3] = [("roll_off_shape", "roll_off"), ("moduli", "prony"), ("relaxes", "prony")];

/// Returns the keys of a group of flags in a configuration.
pub fn keys<A: Args>() -> Vec<String> {
    let command = A::augment_args(Command::new("gfmd"));
    command.get_arguments().map(|argument| argument.get_id().to_string()).collect()
}

/// Removes from a table the defaults of flags that cannot be combined with the others in it.
pub fn leave_out_idle<A: Args>(table: &mut Table) {
    let command = A::augment_args(Command::new("gfmd"));
    let given = command.get_arguments().filter(|flag| table.contains_key(flag.get_id().as_str()));
    let excluded = given.flat_map(|flag| command.get_arg_conflicts_with(flag)).map(|flag| flag.get_id().to_string());
    let alone = BESIDE.iter().filter(|(_, needed)| !table.contains_key(*needed)).map(|(key, _)| (*key).to_owned());
    for key in excluded.chain(alone).collect::<Vec<_>>() {
        table.remove(&key);
    }
}

/// Returns the configuration of a run with these flags as TOML, in flag order.
///
/// # Errors
/// Returns an error for a number that TOML does not have.
pub fn toml_of<A: Args + Serialize>(args: &A) -> Result<String, toml::ser::Error> {
    // A table cannot hold integers above 2^63, but TOML text can.
    let Ok(mut table) = Table::try_from(args) else { return toml::to_string(args) };
    leave_out_idle::<A>(&mut table);
    let lines = keys::<A>().into_iter().filter_map(|key| table.remove_entry(&key)).collect::<Vec<_>>();
    lines.into_iter().chain(table).map(|line| toml::to_string(&Table::from_iter([line]))).collect()
}

/// Reads a group of flags from a table of its keys, and from the arrays of options.
///
/// # Errors
/// Returns an error that names an unknown key, or a value of another type.
pub fn of_keys<A: Args + Options + DeserializeOwned>(table: Table, mut arrays: Arrays) -> Result<A, Unusable> {
    let keys = keys::<A>();
    if let Some(key) = table.keys().chain(arrays.keys()).find(|key| !keys.contains(key)) {
        return Err(Unusable::value("a key", quoted(key), format!("one of {}", keys.join(", "))));
    }
    let mut options: A = of_table(table).map_err(Unusable::of)?;
    options.take_arrays(&mut arrays);
    match arrays.first_key_value() {
        Some((key, _)) => Err(Unusable::value(crate::key(key), "an array", "a text or numbers")),
        None => Ok(options),
    }
}

/// Reads a group of flags from a table of its keys; keys of other groups are ignored.
///
/// # Errors
/// Returns an error that names a value of another type.
pub fn of_table<A: DeserializeOwned>(table: Table) -> Result<A, String> {
    A::deserialize(table.clone()).map_err(|error| {
        // Every key has a default, so a value that cannot be read alone is wrong.
        let wrong = table.into_iter().find_map(|(key, value)| {
            let text = shown(&value);
            let error = A::deserialize(Table::from_iter([(key.clone(), value)])).err()?;
            Some(format!("{key} is {text}: {}", line(error.message())))
        });
        wrong.unwrap_or_else(|| line(error.message()))
    })
}

/// Returns a key as shown in a message.
pub fn quoted(key: &str) -> String {
    shown(&Value::String(key.into()))
}

/// Returns a value as shown in a message.
fn shown(value: &Value) -> String {
    match value.as_str() {
        Some(text) => short(&format!("{text:?}")),
        None => line(&value.to_string()),
    }
}

/// Returns a text as one line of limited length, without control characters.
pub fn line(text: &str) -> String {
    short(&text.escape_debug().to_string().replace("\\n", " ").replace("\\\"", "\""))
}

fn short(text: &str) -> String {
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.into(),
    }
}
