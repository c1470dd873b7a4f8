//! Options whose numbers may have a unit, and the texts of their values with bare numbers in place of these.
//!
//! Numbers with a unit become numbers of the problem before anything else reads them: what is parsed, recorded and
//! computed with is
//! a plain number in the units of the surface.

use std::collections::BTreeMap;

use gfmd_law::LawKind as Kind;
use gfmd_surface::{Marginal, Shape};
use gfmd_unit::{NoValue, Quantity, Units};
use toml::Value;

use crate::{Unusable, Words, key, setting, words};

/// Kinds of the numbers of an option, in the words of results: `stress`, `1/length`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kinds {
    /// Kinds of the numbers of an entry, in turn; of a table one list for each number of columns.
    rows: &'static [&'static [&'static str]],
    /// Form of the entries.
    form: Form,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// Numbers, with commas between.
    List,
    /// Rows of numbers, with colons between.
    Rows,
    /// Rows that may be in a file; the names of its columns.
    Table(&'static [&'static [&'static str]]),
    /// Rows of heights and probabilities that may be in a file, or a distribution with a name.
    Marginal,
    /// Parameters of a law with their names.
    Parameters,
    /// Name of a shape, and its numbers with their names.
    Shape,
    /// A number, or the name of a file.
    NumberOrFile,
    /// Numbers, words and names of files, with colons, commas and equals signs between.
    Mixed,
}

impl Kinds {
    /// Numbers of these kinds in turn; of one kind if there is one.
    pub const fn list(kinds: &'static [&'static [&'static str]; 1]) -> Self {
        Self { rows: kinds, form: Form::List }
    }

    /// Parameters of a law, `NAME=VALUE`.
    pub const PARAMETERS: Self = Self { rows: &[&["1"]], form: Form::Parameters };

    /// Shape, `KIND:KEY=LENGTH,..`.
    pub const SHAPE: Self = Self { rows: &[&["length"]], form: Form::Shape };

    /// Lengths among words and file names, `X0:X1,Y0:Y1`, `below:Z` or `s:L,kind=gaussian`.
    pub const LENGTHS_AMONG_WORDS: Self = Self { rows: &[&["length"]], form: Form::Mixed };

    /// Numbers without a unit.
    pub const NUMBER: Self = Self::list(&[&["1"]]);
    /// A length, or lengths.
    pub const LENGTH: Self = Self::list(&[&["length"]]);
    /// A stress, or stresses.
    pub const STRESS: Self = Self::list(&[&["stress"]]);
    /// Forces.
    pub const FORCE: Self = Self::list(&[&["stress*length^2"]]);
    /// A viscosity.
    pub const VISCOSITY: Self = Self::list(&[&["stress*time"]]);
    /// Times.
    pub const TIME: Self = Self::list(&[&["time"]]);
    /// A wavenumber.
    pub const WAVENUMBER: Self = Self::list(&[&["1/length"]]);
    /// Velocities.
    pub const VELOCITY: Self = Self::list(&[&["length/time"]]);
    /// A wear coefficient divided by the hardness.
    pub const WEAR: Self = Self::list(&[&["1/stress"]]);
    /// A hardness, or a file of it.
    pub const HARDNESS: Self = Self { rows: &[&["stress"]], form: Form::NumberOrFile };
    /// Relaxation times and fractions of a Prony series.
    pub const PRONY: Self = Self { rows: &[&["time", "1"]], form: Form::Rows };
    /// Thermal conductivities and diffusivities.
    pub const HEAT: Self = Self::list(&[&["stress*length^2/time/temperature", "length^2/time"]]);
    /// Thermal conductivities.
    pub const CONDUCTIVITY: Self = Self::list(&[&["stress*length^2/time/temperature"]]);
    /// A temperature.
    pub const TEMPERATURE: Self = Self::list(&[&["temperature"]]);
    /// Gaps and tractions of a law.
    pub const LAW_TABLE: Self = Self { rows: &[&["length", "stress"]], form: Form::Table(&[&["gap", "traction"]]) };
    /// Equivalent plastic strains and yield stresses of a hardening curve.
    pub const HARDENING_CURVE: Self = Self { rows: &[&["1", "stress"]], form: Form::Table(&[&["strain", "stress"]]) };
    /// Wavenumbers, or both components of wave vectors, and compliances.
    pub const COMPLIANCE: Self = Self {
        rows: &[&["1/length", "length/stress"], &["1/length", "1/length", "length/stress"]],
        form: Form::Table(&[&["wavenumber", "compliance"], &["qx", "qy", "compliance"]]),
    };
    /// Young's modulus, Poisson's ratio and height of a layer.
    pub const LAYER: Self = Self::list(&[&["stress", "1", "length"]]);

    /// Heights, and the fractions of the surface below them; or a distribution with a name.
    pub const MARGINAL: Self = Self { rows: &[&["length", "1"]], form: Form::Marginal };

    /// Returns the kinds of the numbers of an option; numbers without a unit if it is not among `all`.
    pub fn of(key: &str, all: &KindsByKey) -> Self {
        all.get(key).copied().unwrap_or(Self::NUMBER)
    }

    /// Returns the kinds of the numbers of an entry, in turn.
    pub fn in_turn(&self) -> &'static [&'static str] {
        self.rows[0]
    }

    /// Returns the kind of a number in a row of `length` numbers.
    pub fn in_row(&self, column: usize, length: usize) -> &'static str {
        let row = self.rows.iter().find(|row| row.len() == length).unwrap_or(&self.rows[0]);
        row[column % row.len()]
    }

    /// Returns the lists of column names of a table in a file; none if the option is no table.
    pub fn columns(&self) -> &'static [&'static [&'static str]] {
        match self.form {
            Form::Table(columns) => columns,
            Form::Marginal => &[&["height", "probability"]],
            _ => &[],
        }
    }

    /// Returns true if `text` names the file of a table.
    pub fn names_a_table(&self, text: &str) -> bool {
        let is_named = self.form == Form::Marginal && Marginal::is_named(text);
        !self.columns().is_empty() && !is_rows(text) && !is_named
    }

    fn has_columns(&self) -> bool {
        matches!(self.form, Form::Rows | Form::Table(_) | Form::Marginal)
    }
}

/// Kinds of the numbers of options, by key.
pub type KindsByKey = BTreeMap<&'static str, Kinds>;

/// Returns true if the value of an option is a table with its rows written out.
fn is_rows(text: &str) -> bool {
    let is_number = |text: &str| text.trim().parse::<f64>().is_ok() || matches!(Quantity::parse(text), Ok(Some(_)));
    text.split(',').all(|row| row.contains(':') && row.split(':').all(is_number))
}

/// Returns the kind of a law parameter; the kind without a unit if no law has it.
fn kind_of_parameter(name: &str) -> &'static str {
    let parameters = Kind::ALL.into_iter().flat_map(|kind| kind.parameters());
    parameters.into_iter().find(|parameter| parameter.name == name).map_or("1", |parameter| parameter.units)
}

/// Returns the kind of a number of a shape, whose key may stand behind the name of the shape.
fn kind_of_key(name: &str) -> &'static str {
    let key = name.rsplit(':').next().unwrap_or_default().trim();
    if Shape::is_length(key) { "length" } else { "1" }
}

/// Returns the number for a quantity of an option, which must be of this kind.
///
/// # Errors
/// Returns an error for a quantity of another kind, or without a value.
pub fn number_in_units(option: &str, quantity: &Quantity, kind: &str, units: &Units) -> Result<f64, Unusable> {
    units.value(quantity, kind).map_err(|error| {
        let why = words![format!("{:?}: ", quantity.text()), without_value(&error)];
        Unusable::of(why).at(key(option))
    })
}

/// Says why a quantity has no value in the units of a problem.
fn without_value(error: &NoValue) -> Words {
    match error {
        NoValue::Kind { found, allowed } => format!("it is {found}; it must be {allowed}").into(),
        NoValue::NoLength => words![
            "it has a unit, and the lengths have none; ",
            key("unit"),
            " gives them one, as in ",
            setting("unit", "um"),
            ", or leave the unit out: a number is then in the units of the other numbers",
        ],
        NoValue::Length(name) => words![
            format!("it has a unit, and the unit of the lengths, {name}, is not known; "),
            key("unit"),
            " names one, as in ",
            setting("unit", "um"),
        ],
    }
}

/// Returns the number that stands in the place of a quantity of this kind.
type Take<'a> = &'a mut dyn FnMut(&Quantity, &str) -> Result<f64, Unusable>;

/// Replaces a number with a unit; `None` if the text stays as it is.
fn number((option, kinds): (&str, Kinds), text: &str, kind: &str, take: Take) -> Result<Option<f64>, Unusable> {
    // It may be a file name.
    let may_be_file = matches!(kinds.form, Form::NumberOrFile | Form::Mixed);
    if may_be_file && [".npy", ".h5"].iter().any(|end| text.contains(end)) {
        return Ok(None);
    }
    match Quantity::parse(text) {
        Ok(Some(quantity)) => take(&quantity, kind).map(Some),
        Ok(None) => Ok(None),
        Err(error) => Err(Unusable::input(key(option), format!("{text:?}: {error}"))),
    }
}

/// Replaces the quantities in the value of an option by bare numbers; `None` if there is no unit to replace.
///
/// # Errors
/// Returns an error for an unknown unit, or a quantity that cannot be used.
pub fn text_in_units(option: (&str, Kinds), text: &str, units: &Units) -> Result<Option<String>, Unusable> {
    replaced(option, text, &mut |quantity, kind| number_in_units(option.0, quantity, kind, units))
}

fn replaced((key, kinds): (&str, Kinds), text: &str, take: Take) -> Result<Option<String>, Unusable> {
    let mut changed = false;
    let mut entries = Vec::new();
    for (index, entry) in text.split(',').enumerate() {
        let (name, values) = entry.split_once('=').map_or((None, entry), |(name, value)| (Some(name), value));
        let kind = match kinds.form {
            Form::Parameters => kind_of_parameter(name.unwrap_or_default().trim()),
            Form::Shape => kind_of_key(name.unwrap_or_default()),
            _ => kinds.in_row(index, kinds.in_turn().len()),
        };
        let mut parts = Vec::new();
        let length = values.split(':').count();
        for (column, part) in values.split(':').enumerate() {
            let kind = if kinds.has_columns() { kinds.in_row(column, length) } else { kind };
            let found = number((key, kinds), part, kind, take)?;
            changed |= found.is_some();
            parts.push(found.map_or_else(|| part.to_owned(), |number| format!("{number:e}")));
        }
        let parts = parts.join(":");
        entries.push(name.map_or_else(|| parts.clone(), |name| format!("{name}={parts}")));
    }
    Ok(changed.then(|| entries.join(",")))
}

/// Replaces texts with a unit in the table value of an option by numbers, which `take` returns for a quantity and its
/// kind.
///
/// # Errors
/// Fails like [`text_in_units`].
pub fn value_in_units(option: (&str, Kinds), value: &mut Value, take: Take) -> Result<(), Unusable> {
    in_list(option, value, option.1.in_turn()[0], take)
}

fn in_list(option: (&str, Kinds), value: &mut Value, kind: &str, take: Take) -> Result<(), Unusable> {
    match value {
        // A slice or a wave is a text; a list in one text has commas.
        Value::String(text) if text.contains([',', '=', ':']) => {
            replaced(option, text, take)?.into_iter().for_each(|text| *value = Value::String(text));
        }
        Value::String(text) => {
            number(option, text, kind, take)?.into_iter().for_each(|number| *value = Value::Float(number));
        }
        Value::Array(entries) => {
            let length = entries.len();
            // A law parameter is its name and its value.
            let named = entries
                .first()
                .and_then(Value::as_str)
                .filter(|_| option.1.form == Form::Parameters && entries.len() == 2);
            let named = named.map(kind_of_parameter);
            for (index, entry) in entries.iter_mut().enumerate() {
                in_list(option, entry, named.unwrap_or_else(|| option.1.in_row(index, length)), take)?;
            }
        }
        _ => {}
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds(key: &str) -> Kinds {
        match key {
            "young" | "base_young" | "pressure" => Kinds::STRESS,
            "hardness" => Kinds::HARDNESS,
            "layer" | "second_body" => Kinds::LAYER,
            "param" => Kinds::PARAMETERS,
            "wave" => Kinds::list(&[&["1", "1", "1", "length"]]),
            "velocity" => Kinds::VELOCITY,
            "time" => Kinds::TIME,
            "prony" => Kinds::PRONY,
            "heat" => Kinds::HEAT,
            "compliance" => Kinds::COMPLIANCE,
            "law_table" => Kinds::LAW_TABLE,
            "p_star" | "law" => Kinds::NUMBER,
            "crop" | "filter" | "invalid" => Kinds::LENGTHS_AMONG_WORDS,
            _ => Kinds::LENGTH,
        }
    }

    fn texts(key: &str, text: &str) -> Result<Option<String>, String> {
        let units = Units::new(Some("nm"), None);
        text_in_units((key, kinds(key)), text, &units).map_err(|error| error.to_string())
    }

    #[test]
    fn texts_have_bare_numbers_in_place_of_quantities() {
        for (key, text, found) in [
            ("young", "70GPa", Some("7e10")),
            ("young", "70e9", None),
            ("p_star", "0.1", None),
            ("pressure", "1kPa:1MPa:4,2 MPa,5", Some("1e3:1e6:4,2e6,5")),
            ("pressure", "1e3:1e6:4", None),
            ("layer", "3 GPa,0.3,2 µm", Some("3e9,0.3,2e3")),
            ("second_body", "3GPa,0.3", Some("3e9,0.3")),
            ("param", "gamma=0.05J/m^2,range=2 nm", Some("gamma=5e7,range=2e0")),
            ("param", "curvature=1e15 Pa/m", Some("curvature=1e6")),
            ("height", "inf", None),
            ("slice", "y=2um", Some("y=2e3")),
            ("wave", "1,1,z,5nm", Some("1,1,z,5e0")),
            ("hardness", "2GPa", Some("2e9")),
            ("hardness", "2um.npy", None),
            ("lateral", "0,-2nm", Some("0,-2e0")),
            ("velocity", "1mm/s:1m/s:4", Some("1e6:1e9:4")),
            ("time", "0,1ms:2h:4,3 min", Some("0,1e-3:7.2e3:4,1.8e2")),
            ("prony", "10 ms:0.3,1d:0.4,2:0.1", Some("1e-2:0.3,8.64e4:0.4,2:0.1")),
            ("heat", "0.2W/(m K),1e-7m^2/s", Some("2e17,1e11")),
            ("compliance", "2/um:3nm/GPa", Some("2e-3:3e-9")),
            ("compliance", "2/um:0:3nm/GPa", Some("2e-3:0:3e-9")),
            ("law_table", "0nm:2MPa,1nm:1kPa,3:0", Some("0e0:2e6,1e0:1e3,3:0")),
            ("crop", "1um:,:2um", Some("1e3:,:2e3")),
            ("crop", "1:2,3:4", None),
            ("filter", "s:2.5um,l:0.8mm,kind=robust,degree=2", Some("s:2.5e3,l:8e5,kind=robust,degree=2")),
            ("invalid", "below:-3um", Some("below:-3e3")),
            ("invalid", "2um.npy", None),
        ] {
            assert_eq!(texts(key, text), Ok(found.map(str::to_owned)), "{key} {text}");
        }
    }

    #[test]
    fn wrong_quantities_are_named_with_their_flag() {
        for (key, text, words) in [
            ("young", "70GPaa", "--young: \"70GPaa\": \"GPaa\" is no unit"),
            ("base_young", "3nm", "--base-young: \"3nm\": it is a length"),
            ("param", "gamma=1 Pa", "--param: \"1 Pa\": it is a stress (such as MPa); it must be an energy per area"),
            ("param", "r=1 Pa", "it must be a number without a unit"),
            ("layer", "1GPa,0.3Pa,1nm", "it must be a number without a unit"),
            ("prony", "1s:0.3s", "--prony: \"0.3s\": it is a time (such as s); it must be a number without a unit"),
            ("time", "1m", "it must be a time (such as s)"),
        ] {
            let error = texts(key, text).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
        let error = text_in_units(("young", Kinds::STRESS), "1Pa", &Units::default()).unwrap_err().to_string();
        assert!(error.contains("--unit gives them one"), "{error}");
    }

    #[test]
    fn tables_have_bare_numbers_in_place_of_texts() {
        let units = Units::new(Some("µm"), Some("MPa"));
        let mut table: toml::Table = toml::from_str(
            "young = '70GPa'\nlayer = [['2GPa', 0.3, '3mm'], [1.0, 0.2, 0.5]]\nheight = 'inf'\n\
             pressure = ['1kPa', 2.0]\n\
             param = [['gamma', '0.05J/m^2'], ['range', 2.0]]\nhardness = 'x.npy'\nslice = 'x=1mm'\nlaw = 'morse'\n\
             law_table = [['2nm', '3MPa'], [1.0, 2.0]]",
        )
        .unwrap();
        for (key, value) in &mut table {
            value_in_units((key, kinds(key)), value, &mut |found, kind| number_in_units(key, found, kind, &units))
                .unwrap();
        }
        let wanted: toml::Table = toml::from_str(
            "young = 70000.0\nlayer = [[2000.0, 0.3, 3000.0], [1.0, 0.2, 0.5]]\nheight = 'inf'\n\
             pressure = [0.001, 2.0]\n\
             param = [['gamma', 0.05], ['range', 2.0]]\nhardness = 'x.npy'\nslice = 'x=1e3'\nlaw = 'morse'\n\
             law_table = [[0.002, 3.0], [1.0, 2.0]]",
        )
        .unwrap();
        assert_eq!(table, wanted);
    }
}
