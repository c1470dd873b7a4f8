//! The form: options of `contact` that the page offers, from the table of all options, and command lines from its
//! answers. No option that names a file, an output or threads is offered.

use std::collections::BTreeMap;

use clap::{Arg, ArgAction, Subcommand};
use gfmd_input::failure::Failure;
use gfmd_unit::Quantity;
use serde::Serialize;
use serde_json::Value;

use crate::kinds::kinds;
use crate::line::table;
use crate::{contact, surface};

/// Commands that the page runs.
#[derive(Debug, Subcommand)]
pub(super) enum Pressed {
    /// Press the scan
    Contact(Box<contact::Args>),
    /// Prepare and measure the scan
    Surface(Box<surface::Args>),
}

/// Groups of options in the order of the form.
const GROUPS: [&str; 9] =
    ["Surface", "Preparation", "Body", "Contact", "Load", "Interface law", "Measurements", "Accuracy", "Solver"];

/// Options that make no sense on the page: a second surface is a file.
const WITHHELD: [&str; 2] = ["shift", "lower_seed"];

/// Part of the name of a value that is a file.
const FILE: &str = "FILE";

/// Option of the form.
#[derive(Debug, Serialize)]
pub(super) struct Entry {
    key: String,
    flag: String,
    group: &'static str,
    meaning: String,
    /// Form of the value, `E,NU,H`; empty for a flag.
    value: String,
    choices: Vec<String>,
    default: String,
    /// Kinds of the numbers, which may have a unit.
    kinds: Vec<&'static str>,
    /// True if the flag may be given without a value.
    bare: bool,
    /// True if the value may be left out or given several times.
    repeats: bool,
    /// True if `surface` has the option, too.
    prepares: bool,
}

/// Returns the arguments of a command that the page offers, each with its group.
fn offered(command: &clap::Command) -> impl Iterator<Item = (&'static str, &Arg)> {
    GROUPS.iter().flat_map(move |group| {
        let of = command.get_arguments().filter(move |arg| arg.get_help_heading() == Some(group) && is_offered(arg));
        of.map(|arg| (*group, arg))
    })
}

fn is_offered(arg: &Arg) -> bool {
    arg.get_long().is_some() && !WITHHELD.contains(&arg.get_id().as_str()) && (!names_file(arg) || may_be_number(arg))
}

fn value_name(arg: &Arg) -> String {
    arg.get_value_names().unwrap_or_default().join(" ")
}

/// Returns true if a value may be the name of a file.
fn names_file(arg: &Arg) -> bool {
    takes_value(arg) && value_name(arg).contains(FILE)
}

/// Returns true if a value is a number or a file.
fn may_be_number(arg: &Arg) -> bool {
    value_name(arg) == "P|FILE"
}

fn takes_value(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::Set | ArgAction::Append)
}

fn command(program: &clap::Command, name: &str) -> clap::Command {
    program.find_subcommand(name).cloned().unwrap_or_default()
}

/// Returns true if `surface` has the option for the preparation: no measurement but the boundary, since the steps
/// across the seam of a patch are no roughness.
fn is_of_preparation(group: &str, arg: &Arg) -> bool {
    group != "Measurements" || arg.get_id() == "boundary"
}

/// Returns the options of the form.
pub(super) fn entries() -> Vec<Entry> {
    let program = table::<Pressed>();
    let (contact, surface) = (command(&program, "contact"), command(&program, "surface"));
    let prepares =
        |arg: &Arg| offered(&surface).any(|(group, own)| is_of_preparation(group, own) && own.get_id() == arg.get_id());
    let entry = |(group, arg): (&'static str, &Arg)| {
        let key = arg.get_id().to_string();
        let takes = takes_value(arg);
        let choices = if takes { arg.get_possible_values() } else { Vec::new() };
        let defaults: Vec<_> = arg.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
        Entry {
            flag: format!("--{}", arg.get_long().unwrap_or_default()),
            group,
            meaning: arg.get_help().map(ToString::to_string).unwrap_or_default(),
            value: if takes { value_name(arg).replace("|FILE", "") } else { String::new() },
            choices: choices.iter().map(|value| value.get_name().to_owned()).collect(),
            default: if takes { defaults.join(",") } else { String::new() },
            kinds: kinds().get(&*key).map_or_else(Vec::new, |kinds| kinds.in_turn().to_vec()),
            bare: takes && arg.get_num_args().is_some_and(|range| range.min_values() == 0),
            repeats: matches!(arg.get_action(), ArgAction::Append) && arg.get_value_delimiter().is_none(),
            prepares: prepares(arg),
            key,
        }
    };
    offered(&contact).map(entry).collect()
}

/// Answers of the form: keys of options with their values.
pub(super) type Answers = BTreeMap<String, Value>;

/// Returns the words of a command for these answers. Options that only `contact` has are left out of `surface`.
///
/// # Errors
/// Returns an error for a key that the page does not offer, and for a value that is neither a text nor true nor a list
/// of texts.
pub(super) fn words(name: &str, answers: &Answers) -> Result<Vec<String>, Failure> {
    let program = table::<Pressed>();
    let (contact, own) = (command(&program, "contact"), command(&program, name));
    let mut words = Vec::new();
    for (key, value) in answers {
        let find = |command| offered(command).find(|(_, arg)| arg.get_id() == key.as_str());
        if find(&contact).is_none() {
            let allowed = "an option of the form; files, outputs and threads are none";
            return Err(Failure::value("the option", gfmd_files::legible::line(key), allowed));
        }
        let is_prepared = |(group, arg)| (name == "contact" || is_of_preparation(group, arg)).then_some(arg);
        let Some(arg) = find(&own).and_then(is_prepared) else { continue };
        let long = arg.get_long().unwrap_or_default();
        let texts: Vec<&str> = match value {
            Value::Bool(true) => {
                words.push(format!("--{long}"));
                continue;
            }
            Value::String(text) => vec![text],
            Value::Array(all) if all.iter().all(Value::is_string) => all.iter().filter_map(Value::as_str).collect(),
            other => return Err(Failure::value(format!("--{long}"), other, "a text, a list of texts, or true")),
        };
        for text in texts {
            // A channel is a name, which may have commas; elsewhere people put spaces behind them.
            let parts = text.split(',').map(str::trim).collect::<Vec<_>>().join(",");
            let text = if key == "channel" { text.trim() } else { &parts };
            let is_number = || text.parse::<f64>().is_ok() || matches!(Quantity::parse(text), Ok(Some(_)));
            if names_file(arg) && !is_number() {
                let found = gfmd_files::legible::line(text);
                return Err(Failure::value(format!("--{long}"), found, "a number; the page takes no name of a file"));
            }
            words.push(format!("--{long}={text}"));
        }
    }
    Ok(words)
}
