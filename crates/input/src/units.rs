//! Replaces quantities with units among words and tables by bare numbers in the units of their surface, before they are
//! parsed.

use gfmd_files::{Reader, Reading, Topography, split_dataset};
use gfmd_problem::options::KindsByKey;
use gfmd_problem::options::given::{ArrayOption, Arrays};
use gfmd_problem::options::quantities::{number_in_units, value_in_units};
use gfmd_problem::{Unusable, Written, flag};
use gfmd_unit::Units;
use toml::{Table, Value};

use crate::failure::Failure;
use crate::named::{find, put_values, text};
use crate::session::NamedMap;
use crate::table;

/// The key and the flag of the unit of lengths.
const UNIT: &str = "unit";

/// The key of the unit of stresses.
const STRESS_UNIT: &str = "stress_unit";

/// The key of the flag that reads the grey values of an image.
const IMAGE_HEIGHTS: &str = "image_heights";

/// Command that takes its units from a result.
const BODY: &str = "body";

/// Command that takes its units from its table, unless others are given.
const LAW: &str = "law";

/// True if the lengths of a command have no unit.
fn without_units(command: &str) -> bool {
    !matches!(command, "contact" | "path" | "slide" | "surface" | "theory" | "estimate" | BODY | LAW)
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
    fn units(&self) -> Result<(Units, Option<NamedMap>), Unusable> {
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
        let topography = topography.map_err(|error| Unusable::of(error.to_string()))?;
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
/// in place of their files; with the height map of the surface if it was read for its unit.
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
        let Some((key, text)) = word.given() else { continue };
        if let Some(kinds) = kinds.get(key).filter(|kinds| kinds.names_a_table(text)) {
            // A command without units takes the numbers of the table, whatever its units.
            let rows = table::rows(key, text, kinds.columns(), !without_units(name))?;
            word.replace(&rows);
        }
    }
    let switch = flag(IMAGE_HEIGHTS);
    let option = |word: &Word| match word.given() {
        Some((key, text)) => Some((key.to_owned(), Value::from(text))),
        None => (word.text() == switch).then(|| (IMAGE_HEIGHTS.to_owned(), true.into())),
    };
    let mut given = words.iter().filter_map(option).collect();
    let (map, written) = resolve(name, &mut given, &Arrays::new(), kinds)?;
    let mut given = given.into_iter();
    for (word, (_, value)) in words.iter_mut().filter(|word| option(word).is_some()).zip(given.by_ref()) {
        word.replace(&text(&value));
    }
    words.extend(given.map(|(key, value)| Word::value(&key, &format!("{}=", flag(&key)), &text(&value))));
    Ok((words, map, written))
}

/// Does what [`of_words`] does, for a table of options and its arrays. Returns the quantities as they were written.
///
/// # Errors
/// The errors of `of_words`.
pub fn of_table(command: &str, table: &mut Table, arrays: &Arrays, kinds: &KindsByKey) -> Result<Written, Failure> {
    let mut given = std::mem::take(table).into_iter().collect();
    let resolved = resolve(command, &mut given, arrays, kinds);
    table.extend(given);
    resolved.map(|(_, written)| written)
}

/// Puts bare numbers in the place of quantities among the options `given` to a command, and values in the place of
/// names. Adds the units that follow from the quantities. Returns the height map of the surface if it was read for its
/// unit, and the quantities as they were written.
fn resolve(
    command: &str,
    given: &mut Vec<(String, Value)>,
    arrays: &Arrays,
    kinds: &KindsByKey,
) -> Result<(Option<NamedMap>, Written), Failure> {
    put_values(given)?;
    let text_of = |key: &str| find(given, key).and_then(Value::as_str).map(str::to_owned);
    let mut source = Source {
        unit: text_of(UNIT),
        stress_unit: text_of(STRESS_UNIT),
        surface: text_of("surface"),
        channel: text_of("channel"),
        image_heights: find(given, IMAGE_HEIGHTS).and_then(Value::as_bool) == Some(true),
    };
    let mut added = Vec::new();
    if let (LAW, Some(rows)) = (command, text_of("law_table")) {
        let [unit, stress_unit] = units_of_rows(&rows);
        for (key, own, found) in [(UNIT, &mut source.unit, unit), (STRESS_UNIT, &mut source.stress_unit, stress_unit)] {
            if let (None, Some(found)) = (&own, found) {
                added.push((key, found.clone()));
                *own = Some(found);
            }
        }
    }
    if let Some(ArrayOption::Load(load)) = arrays.get("surface") {
        let recorded = |key: &str| load.config.get(key).and_then(Value::as_str).map(str::to_owned);
        source.unit = source.unit.or_else(|| recorded(UNIT));
        source.stress_unit = source.stress_unit.or_else(|| recorded(STRESS_UNIT));
    }
    // Generated heights take the unit of the length of their cell.
    if source.unit.is_none()
        && source.surface.is_none()
        && !arrays.contains_key("surface")
        && let Some(found) = find(given, "size").map(text).and_then(|size| size.split(',').find_map(unit_in))
    {
        added.push((UNIT, found.clone()));
        source.unit = Some(found);
    }
    // The units are found with the first quantity.
    let (mut found, mut has_stress, mut written) = (None, false, Written::default());
    for (key, value) in given.iter_mut() {
        let Some(kinds) = kinds.get(&**key) else { continue };
        let whole = value.clone();
        value_in_units((key, *kinds), value, &mut |quantity, kind| {
            if without_units(command) {
                let allowed = format!("a number without a unit, since the lengths of {command} have none");
                return Err(Unusable::value(gfmd_problem::key(key), text(&whole), allowed));
            }
            let (units, _) = match &found {
                Some(found) => found,
                None => found.insert(source.units()?),
            };
            let number = number_in_units(key, quantity, kind, units)?;
            has_stress |= quantity.dimension().stress != 0;
            written.add(key, quantity.text(), number);
            Ok(number)
        })?;
    }
    let Some((units, map)) = found else { return Ok((None, written)) };
    // If a stress has a unit, stresses without one are in Pa, which is recorded.
    if command != BODY && has_stress && units.stress().is_none() {
        added.push((STRESS_UNIT, Units::PASCAL.to_owned()));
    }
    given.extend(added.into_iter().map(|(key, value)| (key.to_owned(), value.into())));
    Ok((map, written))
}
