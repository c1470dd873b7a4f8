//! Replaces quantities with units among words and tables by bare numbers in the units of their surface, before they are
//! parsed.

use gfmd_files::{Reader, Reading, Topography, split_dataset};
use gfmd_problem::options::given::{ArrayOption, Arrays};
use gfmd_problem::options::quantities::{Sought, text_in_units, value_in_units};
use gfmd_problem::options::{Kinds, KindsByKey};
use gfmd_problem::{Written, flag, key};
use gfmd_unit::Units;
use toml::{Table, Value};

use crate::failure::Failure;
use crate::named::{self, Resolved, in_words, resolved};
use crate::session::NamedMap;
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
    !matches!(command, "contact" | "path" | "slide" | "surface" | "theory" | "estimate" | BODY | LAW)
}

/// The refusal of a quantity with a unit by a command without units.
fn refused(command: &str, option: &str, text: &str) -> Failure {
    let allowed = format!("a number without a unit, since the lengths of {command} have none");
    Failure::value(key(option), text, allowed)
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
    image_heights: bool,
}

impl Source {
    /// Returns the units of the problem: the given ones, the units of a result, or the unit in the file of the surface,
    /// with the height map if that was read.
    fn units(&self) -> Result<(Units, Option<NamedMap>), Failure> {
        let stress = self.stress_unit.as_deref();
        let surface = match (&self.unit, &self.surface) {
            (None, Some(surface)) => surface,
            (unit, _) => return Ok((Units::new(unit.as_deref(), stress), None)),
        };
        let (file, _) = split_dataset(surface).unwrap_or((surface, ""));
        if let Some(units) = Reader::open(file).ok().and_then(|reader| units_of_result(&reader)) {
            return Ok((Units::new(units.length(), stress.or(units.stress())), None));
        }
        let topography = Topography::read_as(
            surface,
            Reading { channel: self.channel.as_deref(), image_heights: self.image_heights },
        );
        let topography = topography.map_err(|error| Failure::refused(error.to_string()))?;
        let units = Units::new(topography.unit.as_deref(), stress);
        Ok((units, Some(NamedMap { file: surface.clone(), channel: self.channel.clone(), topography })))
    }
}

/// The units of a result; `None` of a file that is none.
pub fn units_of_result(reader: &Reader) -> Option<Units> {
    let config: Table = reader.text("/", "config").ok()?.parse().ok()?;
    let stress = config.get(STRESS_UNIT).and_then(Value::as_str);
    let length = crate::source::stored_unit(reader, "/surface");
    Some(Units::new(length.as_deref(), stress))
}

/// Word of a command line, with the option whose value it has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Word {
    text: String,
    /// Key of the option, and the start of the value in the text, `--young=70GPa` or `70GPa`.
    option: Option<(String, usize)>,
}

impl Word {
    /// Creates a word that is not the value of an option.
    pub fn plain(text: impl Into<String>) -> Self {
        Self { text: text.into(), option: None }
    }

    /// Creates a value of the option with this key, after the text `before`.
    pub fn value(key: &str, before: &str, value: &str) -> Self {
        Self { text: format!("{before}{value}"), option: Some((key.to_owned(), before.len())) }
    }

    /// Returns the whole word.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Returns the key of the option, and its value.
    pub fn given(&self) -> Option<(&str, &str)> {
        let (key, start) = self.option.as_ref()?;
        Some((key, &self.text[*start..]))
    }

    /// Returns the option and its value, if it has numbers that may have a unit, and their kinds.
    fn quantity(&self, kinds: &KindsByKey) -> Option<((&str, &str), Kinds)> {
        let given = self.given()?;
        Some((given, *kinds.get(given.0)?))
    }

    /// Appends to the value.
    pub fn append(&mut self, text: &str) {
        self.text.push_str(text);
    }

    fn replace(&mut self, value: &str) {
        if let Some((_, start)) = &self.option {
            self.text.replace_range(*start.., value);
        }
    }
}

/// Returns the words of the command `name` with bare numbers in place of quantities with a unit, and the rows of tables
/// in place of their files; with the height map of the surface if it was read for its unit, and the quantities as they
/// were written.
///
/// # Errors
/// Returns an error for a text that is not a unit, a quantity of another kind than its option, a quantity without a
/// unit of lengths, or a table that cannot be read.
pub fn of_words(
    name: &str,
    mut words: Vec<Word>,
    kinds: &KindsByKey,
) -> Result<(Vec<Word>, Option<NamedMap>, Written), Failure> {
    for word in &mut words {
        let rows = match word.quantity(kinds) {
            // A command without units takes the numbers of the table, whatever its units.
            Some(((key, text), kinds)) if kinds.names_a_table(text) => {
                table::rows(key, text, kinds.columns(), !without_units(name))?
            }
            _ => continue,
        };
        word.replace(&rows);
    }
    let given =
        |option: &str| words.iter().filter_map(Word::given).find(|(key, _)| *key == option).map(|(_, value)| value);
    for Resolved { option, recorded, values } in resolved(given)? {
        words.iter_mut().filter(|word| word.given().is_some_and(|(key, _)| key == option)).for_each(|word| {
            word.replace(&recorded);
        });
        words.extend(values.iter().map(|(key, value)| {
            let (before, text) = in_words(key, value);
            Word::value(key, &before, &text)
        }));
    }
    let mut sought = Sought::default();
    for ((key, text), kinds) in words.iter().filter_map(|word| word.quantity(kinds)) {
        let before = sought.any;
        text_in_units((key, kinds), text, &mut sought)?;
        if sought.any && !before && without_units(name) {
            return Err(refused(name, key, text));
        }
    }
    if !sought.any {
        return Ok((words, None, Written::default()));
    }
    let value_of = |option: &str| {
        words.iter().filter_map(Word::given).find(|(key, _)| *key == option).map(|(_, value)| value.to_owned())
    };
    let mut source = Source {
        unit: value_of(UNIT),
        stress_unit: value_of(STRESS_UNIT),
        surface: value_of("surface"),
        channel: value_of("channel"),
        image_heights: words.iter().any(|word| word.text() == flag("image_heights")),
    };
    let mut added = Vec::new();
    if let (LAW, Some(rows)) = (name, value_of("law_table")) {
        let [unit, stress_unit] = units_of_rows(&rows);
        for (key, own, found) in [(UNIT, &mut source.unit, unit), (STRESS_UNIT, &mut source.stress_unit, stress_unit)] {
            if let (None, Some(found)) = (&own, found) {
                added.push((key, found.clone()));
                *own = Some(found);
            }
        }
    }
    // Generated heights take the unit of the length of their cell.
    if let (None, None, Some(size)) = (&source.unit, &source.surface, value_of("size"))
        && let Some(found) = size.split(',').find_map(unit_in)
    {
        added.push((UNIT, found.clone()));
        source.unit = Some(found);
    }
    let (units, map) = source.units()?;
    let mut take = (&units, Written::default());
    for word in &mut words {
        let Some(((key, text), kinds)) = word.quantity(kinds) else { continue };
        if let Some(text) = text_in_units((key, kinds), text, &mut take)? {
            word.replace(&text);
        }
    }
    // If a stress has a unit, stresses without one are in Pa, which is recorded.
    if name != BODY && sought.stress && units.stress().is_none() {
        added.push((STRESS_UNIT, Units::PASCAL.to_owned()));
    }
    words.extend(added.iter().map(|(option, value)| Word::value(option, &format!("{}=", flag(option)), value)));
    let written = take.1;
    Ok((words, map, written))
}

/// Does what [`of_words`] does, for a table of options and its arrays. Returns the quantities as they were written.
///
/// # Errors
/// The errors of `of_words`.
pub fn of_table(command: &str, table: &mut Table, arrays: &Arrays, kinds: &KindsByKey) -> Result<Written, Failure> {
    named::of_table(table)?;
    let mut sought = Sought::default();
    for (key, value) in &*table {
        if let Some(kinds) = kinds.get(&**key) {
            value_in_units((key, *kinds), &mut value.clone(), &mut sought)?;
        }
    }
    if !sought.any {
        return Ok(Written::default());
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
    let mut source = Source {
        unit: text(UNIT),
        stress_unit: text(STRESS_UNIT),
        surface: text("surface"),
        channel: text("channel"),
        image_heights: table.get("image_heights").and_then(Value::as_bool) == Some(true),
    };
    if let Some(ArrayOption::Load(load)) = arrays.get("surface") {
        let recorded = |key: &str| load.config.get(key).and_then(Value::as_str).map(str::to_owned);
        source.unit = source.unit.or_else(|| recorded(UNIT));
        source.stress_unit = source.stress_unit.or_else(|| recorded(STRESS_UNIT));
    }
    // Generated heights take the unit of the length of their cell.
    if source.unit.is_none() && source.surface.is_none() && !arrays.contains_key("surface") {
        let texts = match table.get("size") {
            Some(Value::Array(sides)) => sides.iter().filter_map(Value::as_str).collect(),
            Some(Value::String(text)) => text.split(',').collect(),
            _ => Vec::new(),
        };
        if let Some(found) = texts.into_iter().find_map(unit_in) {
            table.insert(UNIT.into(), found.clone().into());
            source.unit = Some(found);
        }
    }
    let (units, _) = source.units()?;
    let mut take = (&units, Written::default());
    for (key, value) in table.iter_mut() {
        if let Some(kinds) = kinds.get(&**key) {
            value_in_units((key, *kinds), value, &mut take)?;
        }
    }
    if command != BODY && sought.stress && units.stress().is_none() {
        table.insert(STRESS_UNIT.into(), Units::PASCAL.into());
    }
    Ok(take.1)
}
