//! Quantities with units among words and tables: bare numbers in the units of their surface in their place, before
//! they are parsed.

use std::ffi::OsString;

use clap::{Arg, Command};
use gfmd_files::{Reader, Topography, split_dataset};
use gfmd_problem::options::given::{ArrayOption, Arrays};
use gfmd_problem::options::quantities::{Sought, is_rows, text_in_units, value_in_units};
use gfmd_problem::options::{Kinds, KindsByKey};
use gfmd_unit::Units;
use toml::{Table, Value};

use crate::failure::Failure;
use crate::table;

/// The key and the flag of the unit of lengths.
const UNIT: &str = "unit";

/// The key of the unit of stresses.
const STRESS_UNIT: &str = "stress_unit";

/// Command that takes its units from a result.
const BODY: &str = "body";

/// Command that takes its units from its table, unless others are given.
const LAW: &str = "law";

/// True if the lengths of a command have no unit.
fn without_units(command: &str) -> bool {
    !matches!(command, "contact" | "path" | "slide" | "wear" | "surface" | "theory" | BODY | LAW)
}

/// The refusal of a quantity with a unit by a command without units.
fn refused(command: &str, key: &str, text: &str) -> Failure {
    let allowed = format!("a number without a unit, since the lengths of {command} have none");
    Failure::value(format!("--{}", key.replace('_', "-")), text, allowed)
}

/// The units of the first row `A:B` of a table; none of numbers without one.
fn units_of_rows(rows: &str) -> [Option<String>; 2] {
    let first = rows.split(',').next().and_then(|row| row.split_once(':')).unwrap_or_default();
    [unit_in(first.0), unit_in(first.1)]
}

/// The unit of a number with one; `None` of a number without.
fn unit_in(text: &str) -> Option<String> {
    let in_number = |c: char| c.is_ascii_digit() || "+-.eE".contains(c);
    Some(text.trim().trim_start_matches(in_number).trim().to_owned()).filter(|unit| !unit.is_empty())
}

/// The source of the units of a problem.
#[derive(Default)]
struct Source {
    unit: Option<String>,
    stress_unit: Option<String>,
    surface: Option<String>,
    channel: Option<String>,
}

impl Source {
    /// The units of the problem: those that are given, of a result those that it has, or the unit in the file
    /// of the surface.
    fn units(&self) -> Result<Units, Failure> {
        let stress = self.stress_unit.as_deref();
        let surface = match (&self.unit, &self.surface) {
            (None, Some(surface)) => surface,
            (unit, _) => return Ok(Units::new(unit.as_deref(), stress)),
        };
        let (file, _) = split_dataset(surface).unwrap_or((surface, ""));
        if let Some(units) = Reader::open(file).ok().and_then(|reader| units_of_result(&reader)) {
            return Ok(Units::new(units.length(), stress.or(units.stress())));
        }
        let topography = Topography::read(surface, self.channel.as_deref());
        let topography = topography.map_err(|error| Failure::refused(error.to_string()))?;
        Ok(Units::new(topography.unit.as_deref(), stress))
    }
}

/// The units of a result; `None` of a file that is none.
pub fn units_of_result(reader: &Reader) -> Option<Units> {
    let config: Table = reader.text("/", "config").ok()?.parse().ok()?;
    let stress = config.get(STRESS_UNIT).and_then(Value::as_str);
    let length = crate::result::stored_unit(reader, "/surface");
    Some(Units::new(length.as_deref(), stress))
}

/// Returns true if an option has this long name, or had it once.
pub fn has_long(option: &Arg, name: &str) -> bool {
    option.get_long() == Some(name) || option.get_all_aliases().is_some_and(|names| names.contains(&name))
}

/// Returns the words of a command line, program first, with bare numbers in place of quantities with a unit, and the
/// rows of tables in place of their files.
///
/// # Errors
/// Returns an error for a text that is not a unit, a quantity of another kind than its option, a quantity without a
/// unit of lengths, or a table that cannot be read.
pub fn of_words(command: &Command, words: Vec<OsString>, kinds: &KindsByKey) -> Result<Vec<OsString>, Failure> {
    let Some(sub) = words.iter().find_map(|word| command.find_subcommand(word)) else { return Ok(words) };
    // The place of each value, the key of its option, and what stands before it in its word.
    let mut values: Vec<(usize, String, String, String)> = Vec::new();
    let mut open: Option<(String, usize)> = None;
    for (index, word) in words.iter().enumerate() {
        let Some(text) = word.to_str() else { continue };
        if let Some(name) = text.strip_prefix("--") {
            let (name, value) = name.split_once('=').map_or((name, None), |(name, value)| (name, Some(value)));
            let found = sub.get_arguments().find(|argument| has_long(argument, name));
            let key = found.map(|argument| argument.get_id().to_string());
            let most =
                found.map_or(0, |argument| match (argument.get_action().takes_values(), argument.get_num_args()) {
                    (true, Some(range)) => range.max_values(),
                    (takes, None) => usize::from(takes),
                    (false, _) => 0,
                });
            open = None;
            match (key, value) {
                (Some(key), Some(value)) => values.push((index, key, format!("--{name}="), value.into())),
                (Some(key), None) if most > 0 => open = Some((key, most)),
                _ => {}
            }
        } else if let Some((key, left)) = open.take() {
            values.push((index, key.clone(), String::new(), text.into()));
            open = (left > 1).then_some((key, left - 1));
        }
    }
    let mut words = words;
    for (index, key, before, text) in &mut values {
        let columns = kinds.get(&**key).map_or(&[][..], Kinds::columns);
        if !columns.is_empty() && !is_rows(text) {
            // A command without units takes the numbers of the table, whatever its units.
            *text = table::rows(key, text, columns, !without_units(sub.get_name()))?;
            words[*index] = format!("{before}{text}").into();
        }
    }
    let mut sought = Sought::default();
    let with_kinds = || values.iter().filter_map(|value| Some((value, *kinds.get(&*value.1)?)));
    for ((_, key, _, text), kinds) in with_kinds() {
        text_in_units((key, kinds), text, &mut sought)?;
    }
    if !sought.any {
        return Ok(words);
    }
    let value_of = |name: &str| values.iter().find(|(_, key, ..)| key == name).map(|(.., text)| text.clone());
    let has_unit = |((_, key, _, text), kinds): &(&(usize, String, String, String), Kinds)| {
        matches!(text_in_units((key, *kinds), text, &mut Sought::default()), Ok(Some(_)))
    };
    if without_units(sub.get_name())
        && let Some(((_, key, _, text), _)) = with_kinds().find(has_unit)
    {
        return Err(refused(sub.get_name(), key, text));
    }
    let mut source = Source {
        unit: value_of(UNIT),
        stress_unit: value_of(STRESS_UNIT),
        surface: value_of("surface"),
        channel: value_of("channel"),
    };
    if let (LAW, Some(rows)) = (sub.get_name(), value_of("law_table")) {
        let [unit, stress_unit] = units_of_rows(&rows);
        for (flag, own, found) in
            [("--unit", &mut source.unit, unit), ("--stress-unit", &mut source.stress_unit, stress_unit)]
        {
            if let (None, Some(found)) = (&own, found) {
                words.extend([flag.into(), found.clone().into()]);
                *own = Some(found);
            }
        }
    }
    // Generated heights take the unit of the length of their cell.
    if let (None, None, Some(length)) = (&source.unit, &source.surface, value_of("size")) {
        let found = length.split(',').find_map(unit_in);
        if let Some(found) = found {
            words.extend([format!("--{UNIT}").into(), found.clone().into()]);
            source.unit = Some(found);
        }
    }
    let units = source.units()?;
    for ((index, key, before, text), kinds) in with_kinds() {
        if let Some(text) = text_in_units((key, kinds), text, &mut &units)? {
            words[*index] = format!("{before}{text}").into();
        }
    }
    // If a stress has a unit, stresses without one are in Pa, which is recorded.
    if sub.get_name() != BODY && sought.stress && units.stress().is_none() {
        words.extend(["--stress-unit".into(), Units::PASCAL.into()]);
    }
    Ok(words)
}

/// The units of [`of_words`], for a table of options and its arrays.
///
/// # Errors
/// The errors of `of_words`.
pub fn of_table(command: &str, table: &mut Table, arrays: &Arrays, kinds: &KindsByKey) -> Result<(), Failure> {
    let mut sought = Sought::default();
    for (key, value) in &*table {
        if let Some(kinds) = kinds.get(&**key) {
            value_in_units((key, *kinds), &mut value.clone(), &mut sought)?;
        }
    }
    if !sought.any {
        return Ok(());
    }
    if without_units(command)
        && let Some(found) = table.iter().find(|(key, value)| {
            let mut sought = Sought::default();
            let found =
                kinds.get(&***key).map(|kinds| value_in_units((key, *kinds), &mut (*value).clone(), &mut sought));
            found.is_some_and(|found| found.is_ok()) && sought.any
        })
    {
        return Err(refused(command, found.0, &found.1.to_string()));
    }
    let text = |key: &str| table.get(key).and_then(Value::as_str).map(str::to_owned);
    let mut source =
        Source { unit: text(UNIT), stress_unit: text(STRESS_UNIT), surface: text("surface"), channel: text("channel") };
    if let Some(ArrayOption::Load(load)) = arrays.get("surface") {
        let recorded = |key: &str| load.config.get(key).and_then(Value::as_str).map(str::to_owned);
        source.unit = source.unit.or_else(|| recorded(UNIT));
        source.stress_unit = source.stress_unit.or_else(|| recorded(STRESS_UNIT));
    }
    let units = source.units()?;
    for (key, value) in table.iter_mut() {
        if let Some(kinds) = kinds.get(&**key) {
            value_in_units((key, *kinds), value, &mut &units)?;
        }
    }
    if command != BODY && sought.stress && units.stress().is_none() {
        table.insert(STRESS_UNIT.into(), Units::PASCAL.into());
    }
    Ok(())
}
