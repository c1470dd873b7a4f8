//! Tables of dynamic moduli from instruments and data sheets.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use gfmd_unit::Units;

/// Row of a table: numbers in the units of the table, the frequency in Hz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Row {
    /// Number of the line, from 1.
    pub(super) line: usize,
    pub(super) frequency: f64,
    pub(super) storage: f64,
    pub(super) loss: f64,
    pub(super) temperature: Option<f64>,
    pub(super) log_a_t: Option<f64>,
}

/// Table of dynamic moduli.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Table {
    pub(super) rows: Vec<Row>,
    /// Unit of the moduli, if the heads name one.
    pub(super) stress_unit: Option<String>,
}

/// Column that is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Column {
    Frequency,
    Storage,
    Loss,
    Temperature,
    Shift,
}

/// Columns that a table must have, in the order without heads.
const NEEDED: [Column; 3] = [Column::Frequency, Column::Storage, Column::Loss];

impl Column {
    fn name(self) -> &'static str {
        match self {
            Self::Frequency => "frequency",
            Self::Storage => "storage",
            Self::Loss => "loss",
            Self::Temperature => "temperature",
            Self::Shift => "log_a_t",
        }
    }

    /// Returns the column with a head, without its unit.
    fn of(head: &str) -> Option<Self> {
        let head: String = head.to_lowercase().chars().filter(|c| !c.is_whitespace() && *c != '_').collect();
        let head = head.replace(['’', '′'], "'").replace(['″', '"'], "''");
        let begins = |words: &[&str]| words.iter().any(|word| head.starts_with(word));
        if begins(&["freq", "angularfreq", "reducedfreq"]) || ["f", "omega", "ω"].contains(&head.as_str()) {
            Some(Self::Frequency)
        } else if begins(&["loss", "e''", "g''"]) && !begins(&["lossfactor", "losstan"]) {
            Some(Self::Loss)
        } else if begins(&["storage", "e'", "g'"]) {
            Some(Self::Storage)
        } else if begins(&["temp"]) || head == "t" {
            Some(Self::Temperature)
        } else if begins(&["logat", "log10at", "log(at", "log10(at", "shift"]) {
            Some(Self::Shift)
        } else {
            None
        }
    }
}

/// Place and unit of each column.
type Places = BTreeMap<Column, (usize, Option<String>)>;

/// Splits a line at tabs or semicolons, else at commas, else at blanks. Between tabs and semicolons a comma is a
/// decimal point.
fn cells(line: &str) -> Vec<String> {
    let trimmed = |cell: &str| cell.trim().trim_matches('"').trim().to_owned();
    if line.contains(['\t', ';']) {
        let cell = |cell: &str| {
            let text = trimmed(cell);
            let point = text.replace(',', ".");
            if point.parse::<f64>().is_ok() { point } else { text }
        };
        line.split(['\t', ';']).map(cell).collect()
    } else if line.contains(',') {
        line.split(',').map(trimmed).collect()
    } else {
        line.split_whitespace().map(trimmed).collect()
    }
}

/// Splits a head into its name and its unit: `loss (MPa)`, `loss [MPa]`, `loss / MPa`, `loss_MPa`.
fn name_and_unit(head: &str) -> (&str, Option<&str>) {
    let bracket = head.find(|c: char| "([".contains(c));
    let bracketed = bracket.map(|at| (head[..at].trim(), head[at..].trim_matches(|c: char| "()[] ".contains(c))));
    let parts = bracketed.or_else(|| head.split_once(" / ")).or_else(|| {
        let (name, unit) = head.rsplit_once('_')?;
        (Column::of(head) != Some(Column::Shift)).then_some((name, unit))
    });
    match parts {
        // The bracket of log(a_T) belongs to the name.
        Some((name, unit)) if Column::of(name).is_some() => (name.trim(), Some(unit.trim()).filter(|u| !u.is_empty())),
        _ => (head, None),
    }
}

/// Returns the columns of a line of heads; `None` if no head is known.
fn heads(cells: &[String]) -> Result<Option<Places>, String> {
    let mut places = Places::new();
    for (place, cell) in cells.iter().enumerate() {
        let (name, unit) = name_and_unit(cell);
        let Some(column) = Column::of(name) else { continue };
        if places.insert(column, (place, unit.map(str::to_owned))).is_some() {
            return Err(format!("has two columns {}; it must have one", column.name()));
        }
    }
    if places.is_empty() {
        return Ok(None);
    }
    match NEEDED.into_iter().find(|column| !places.contains_key(column)) {
        Some(column) => Err(format!(
            "has no column {}; it must have frequency, storage and loss, and may have temperature and log_a_t",
            column.name()
        )),
        None => Ok(Some(places)),
    }
}

/// Returns the factor from a unit of frequency to Hz.
fn hertz(unit: &str) -> Result<f64, String> {
    match unit {
        "Hz" | "1/s" | "s^-1" | "s-1" => Ok(1.0),
        "mHz" => Ok(1e-3),
        "kHz" => Ok(1e3),
        "MHz" => Ok(1e6),
        "rad/s" | "rad s^-1" | "rad·s⁻¹" => Ok(1.0 / TAU),
        _ => Err(format!("has the unit {unit:?} of the frequency; it must be Hz, mHz, kHz, MHz, 1/s or rad/s")),
    }
}

/// Returns a unit of stress in Pa.
fn pascals(unit: &str) -> Result<f64, String> {
    let found = Units::is_stress(unit).then(|| Units::new(None, Some(unit)).pascals()).flatten();
    found
        .ok_or_else(|| format!("has the unit {unit:?} of a modulus; it must be a unit of stress, such as Pa, MPa, GPa"))
}

/// Checks the unit of temperatures and shifts, which are taken as they are.
fn others(places: &Places) -> Result<(), String> {
    let unit = |column| places.get(&column).and_then(|(_, unit)| unit.as_deref());
    match (unit(Column::Temperature), unit(Column::Shift)) {
        (Some(unit), _) if !["K", "°C", "degC", "C", "deg C", "ºC"].contains(&unit) => {
            Err(format!("has the unit {unit:?} of the temperature; it must be °C, degC, C or K"))
        }
        (_, Some(unit)) if !["-", "1"].contains(&unit) => {
            Err(format!("has the unit {unit:?} of log_a_t; it must have none"))
        }
        _ => Ok(()),
    }
}

/// Factors from the units of the columns to Hz and to the unit of the moduli.
struct Factors {
    frequency: f64,
    loss: f64,
    stress_unit: Option<String>,
}

impl Factors {
    fn of(places: &Places) -> Result<Self, String> {
        let unit = |column: Column| places.get(&column).and_then(|(_, unit)| unit.as_deref());
        others(places)?;
        let (storage, loss) = (unit(Column::Storage), unit(Column::Loss));
        // One unit holds for both.
        let size = |unit: Option<&str>| unit.map(pascals).transpose();
        let loss_factor = match (size(storage)?, size(loss)?) {
            (Some(storage), Some(loss)) => loss / storage,
            _ => 1.0,
        };
        Ok(Self {
            frequency: unit(Column::Frequency).map_or(Ok(1.0), hertz)?,
            loss: loss_factor,
            stress_unit: storage.or(loss).map(str::to_owned),
        })
    }
}

/// Returns true if the line has units below the heads, as some instruments write them, and takes them.
fn take_units(places: &mut Places, cells: &[String]) -> bool {
    let bare = places.values().all(|(_, unit)| unit.is_none());
    let unit = |place: &usize| cells.get(*place).map(|cell| cell.trim_matches(|c: char| "()[]".contains(c)).to_owned());
    let found: Vec<_> = NEEDED.iter().filter_map(|column| unit(&places[column].0)).collect();
    let [frequency, storage, loss] = &found[..] else { return false };
    if !bare || hertz(frequency).is_err() || pascals(storage).is_err() || pascals(loss).is_err() {
        return false;
    }
    for (place, own) in places.values_mut() {
        *own = unit(place).filter(|unit| !unit.is_empty());
    }
    true
}

/// Reads a table. Lines that begin with # are comments, if they are no heads; further columns are ignored.
///
/// # Errors
/// Returns an error that names the line, what was found and what is allowed.
pub(super) fn read(text: &str) -> Result<Table, String> {
    let mut places: Option<Places> = None;
    let mut rows: Vec<Row> = Vec::new();
    let mut factors = Factors { frequency: 1.0, loss: 1.0, stress_unit: None };
    let mut seen: BTreeMap<[u64; 3], usize> = BTreeMap::new();
    let mut head_line = 0;
    for (line, whole) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let (content, is_comment) = match whole.trim().strip_prefix('#') {
            Some(comment) => (comment.trim(), true),
            None => (whole.trim(), false),
        };
        if content.is_empty() {
            continue;
        }
        let at = |reason: String| format!("line {line} {reason}");
        let cells = cells(content);
        let is_number = |cell: &String| cell.parse::<f64>().is_ok();
        if rows.is_empty() && !cells.iter().any(is_number) {
            if let Some(places) = places.as_mut().filter(|_| head_line > 0 && !is_comment) {
                if take_units(places, &cells) {
                    factors = Factors::of(places).map_err(at)?;
                    continue;
                }
            } else {
                match heads(&cells) {
                    Ok(Some(found)) => {
                        factors = Factors::of(&found).map_err(at)?;
                        (places, head_line) = (Some(found), line);
                        continue;
                    }
                    Err(_) if is_comment => continue,
                    Err(reason) => return Err(at(reason)),
                    Ok(None) => {}
                }
            }
        }
        if is_comment {
            continue;
        }
        let places = places.get_or_insert_with(|| {
            NEEDED.into_iter().enumerate().map(|(place, column)| (column, (place, None))).collect()
        });
        if head_line == 0 && cells.len() != NEEDED.len() {
            let found: String = content.chars().take(40).collect();
            return Err(at(format!(
                "is {found:?}; it must be three numbers, frequency, storage and loss, or before them these heads"
            )));
        }
        let number = |column: Column| -> Result<Option<f64>, String> {
            let Some((place, _)) = places.get(&column) else { return Ok(None) };
            let cell = cells.get(*place).map_or("", String::as_str);
            let found = cell.parse::<f64>().ok().filter(|number| number.is_finite());
            let (name, is_positive) = (column.name(), NEEDED.contains(&column));
            match found {
                Some(number) if number > 0.0 || !is_positive => Ok(Some(number)),
                _ => {
                    let allowed = if is_positive { "a positive, finite number" } else { "a finite number" };
                    let cell = if cell.is_empty() { "missing" } else { cell };
                    Err(at(format!("has the {name} {cell}; it must be {allowed}")))
                }
            }
        };
        let needed = |column| number(column).map(Option::unwrap_or_default);
        let row = Row {
            line,
            frequency: needed(Column::Frequency)? * factors.frequency,
            storage: needed(Column::Storage)?,
            loss: needed(Column::Loss)? * factors.loss,
            temperature: number(Column::Temperature)?,
            log_a_t: number(Column::Shift)?,
        };
        let key = [Some(row.frequency), row.temperature, row.log_a_t].map(|number| number.unwrap_or(0.0).to_bits());
        if let Some(first) = seen.insert(key, line) {
            let cell = &cells[places[&Column::Frequency].0];
            let with = if row.temperature.is_some() { " at the same temperature" } else { "" };
            return Err(at(format!("has the frequency {cell}, as line {first} has; it must differ{with}")));
        }
        rows.push(row);
    }
    if rows.is_empty() {
        return Err("it has no row; it must have rows of frequency, storage and loss".into());
    }
    Ok(Table { rows, stress_unit: factors.stress_unit })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(text: &str) -> Vec<[f64; 3]> {
        read(text).unwrap().rows.iter().map(|row| [row.frequency, row.storage, row.loss]).collect()
    }

    #[test]
    fn tables_of_several_makers_are_read() {
        let wanted = vec![[1.0, 2.5, 0.5], [10.0, 4.0, 1.0]];
        for text in [
            "1,2.5,0.5\n10,4,1\n",
            "frequency,storage,loss\n1,2.5,0.5\n10,4,1\n",
            "# made\n\nfrequency (Hz), storage (MPa), loss (MPa)\n1,2.5,0.5\n10,4,1\n",
            "\u{feff}Storage modulus [MPa];Loss modulus [MPa];tan d;Frequency [Hz]\r\n2,5;0,5;0,2;1\r\n4;1;0,25;10\r\n",
            "f\tE'\tE''\nHz\tMPa\tMPa\n1\t2.5\t0.5\n10\t4\t1\n",
            "frequency_Hz storage_MPa loss_kPa\n1 2.5 500\n10 4 1e3\n",
            "\"Frequency / mHz\",\"G' / MPa\",\"G'' / MPa\"\n1000,2.5,0.5\n1e4,4,1\n",
        ] {
            assert_eq!(numbers(text), wanted, "{text}");
        }
        assert_eq!(read("f,storage (GPa),loss\n1,2,3\n").unwrap().stress_unit.as_deref(), Some("GPa"));
        assert!((numbers("omega (rad/s),storage,loss\n6.283185307179586,2,3\n")[0][0] - 1.0).abs() < 1e-15);
        let shifted = read("temperature (°C),frequency,storage,loss,log_a_t\n20,1,2,3,-1.5\n30,1,2,3,-2\n").unwrap();
        assert_eq!((shifted.rows[1].temperature, shifted.rows[0].log_a_t), (Some(30.0), Some(-1.5)));
        assert_eq!(read("frequency,storage,loss,log(a_T)\n1,2,3,-1\n").unwrap().rows[0].log_a_t, Some(-1.0));
    }

    #[test]
    fn tables_that_cannot_be_used_are_refused_by_their_line() {
        for (text, words) in [
            ("", "it has no row"),
            ("frequency,storage,loss\n", "it has no row"),
            ("frequency,storage\n1,2\n", "line 1 has no column loss; it must have frequency, storage and loss"),
            ("frequency,storage,loss,loss\n1,2,3,4\n", "line 1 has two columns loss"),
            ("1,2\n", "line 1 is \"1,2\"; it must be three numbers"),
            ("a,b,c\n1,2,3\n", "line 1 has the frequency a; it must be a positive, finite number"),
            ("1,2,3\n2,-1,3\n", "line 2 has the storage -1; it must be a positive"),
            ("1,2,3\n2,1,nan\n", "line 2 has the loss nan; it must be a positive"),
            ("1,2,3\n2,1,0\n", "line 2 has the loss 0; it must be a positive"),
            ("1,2,3\n0,1,1\n", "line 2 has the frequency 0; it must be a positive"),
            ("f,storage,loss\n1,2,3\n1,2\n", "line 3 has the loss missing"),
            ("f,storage,loss,T\n1,2,3,20\n1,2,3,warm\n", "line 3 has the temperature warm; it must be a finite number"),
            ("1,2,3\n2,2,3\n1.0,2,3\n", "line 3 has the frequency 1.0, as line 1 has; it must differ"),
            ("f,storage,loss,T\n1,2,3,20\n1,2,3,20\n", "it must differ at the same temperature"),
            ("f (rpm),storage,loss\n1,2,3\n", "line 1 has the unit \"rpm\" of the frequency; it must be Hz"),
            ("f,storage (psi),loss\n1,2,3\n", "line 1 has the unit \"psi\" of a modulus; it must be a unit of stress"),
            ("f,storage,loss,T (F)\n1,2,3,4\n", "line 1 has the unit \"F\" of the temperature; it must be °C"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(words), "{text:?}: {error}");
        }
        assert!(read("f,storage,loss,T\n1,2,3,20\n1,2,3,30\n").is_ok());
    }
}
