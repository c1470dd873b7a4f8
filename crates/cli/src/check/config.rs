//! The configuration of a result, read as data: the keys that describe its problem, each with its type, and no others.
//!
//! A result may come from a stranger. No key names a file that is written, and no file is opened that a key names, but the input
//! of a result of `body`, which [`Configuration::file`] returns and whose name the result has a second time, with a checksum.

use toml::Value;

use super::Kind;
use crate::failure::Failure;

/// The types of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    /// True or false.
    Flag,
    /// A whole number from 0.
    Whole,
    /// A number.
    Number,
    /// A number, or `inf`.
    Height,
    /// The name of a choice.
    Word,
    /// Whole numbers from 0.
    Wholes,
    /// Numbers.
    Numbers,
    /// Names of choices.
    Words,
    /// Lists of numbers, one for each time that the flag is given.
    Rows,
    /// Lists of numbers and of one component, one for each time that the flag is given.
    Places,
    /// Names with a number each.
    Pairs,
    /// A text that names a file or a part of it, whose values stand in the result, from which they are taken.
    Stored,
    /// A number, or the name of a file as of `Stored`.
    NumberOrStored,
    /// The name of an input.
    Input,
}

type Keys = &'static [(&'static str, Form)];

const SOURCE: Keys = &[
    ("surface", Form::Stored),
    ("channel", Form::Stored),
    ("fill", Form::Word),
    ("length", Form::Numbers),
    ("detrend", Form::Word),
    ("periodise", Form::Word),
    ("flip", Form::Flag),
    ("second_surface", Form::Stored),
    ("shift", Form::Numbers),
    ("n", Form::Wholes),
    ("hurst", Form::Number),
    ("eps_t_inv", Form::Number),
    ("eps_f_inv", Form::Number),
    ("eps_c_inv", Form::Number),
    ("rms_gradient", Form::Number),
    ("rms_height", Form::Number),
    ("seed", Form::Whole),
    ("dim", Form::Whole),
    ("method", Form::Word),
    ("roll_off", Form::Number),
    ("roll_off_shape", Form::Word),
    ("amplitudes", Form::Word),
];

const BODY: Keys = &[
    ("young", Form::Number),
    ("poisson", Form::Number),
    ("height", Form::Height),
    ("base", Form::Word),
    ("base_young", Form::Number),
    ("base_poisson", Form::Number),
    ("layer", Form::Rows),
    ("second_body", Form::Numbers),
];

const MODULUS: Keys = &[("e_star", Form::Number)];

const LOADS: Keys = &[("pressure", Form::Numbers), ("p_star", Form::Numbers), ("displacement", Form::Numbers)];

const LAW: Keys = &[("law", Form::Word), ("param", Form::Pairs), ("coarse", Form::Flag)];

const INTERACTION: Keys = &[("boundary", Form::Word), ("hardness", Form::NumberOrStored)];

const SEARCH: Keys = &[("tol", Form::Number), ("max_iter", Form::Whole)];

/// The method of a search, and its record.
const METHOD: Keys = &[
    ("solver", Form::Word),
    ("dt", Form::Number),
    ("damping", Form::Numbers),
    ("history", Form::Flag),
    ("history_mode", Form::Places),
    ("history_point", Form::Places),
];

const CONTACT: Keys = &[
    ("base_displacement", Form::Stored),
    ("base_traction", Form::Stored),
    ("lower_surface", Form::Stored),
    ("lower_seed", Form::Whole),
    ("components", Form::Word),
    ("finite_slope", Form::Flag),
    ("statistics", Form::Flag),
    ("conductor_height", Form::Height),
    ("flow", Form::Flag),
    ("flow_threshold", Form::Flag),
    ("range_continuation", Form::Flag),
    ("fields", Form::Word),
];

const PATH: Keys = &[
    ("friction", Form::Number),
    ("shear_strength", Form::Number),
    ("lateral", Form::Numbers),
    ("direction", Form::Number),
    ("steps", Form::Whole),
    ("energy_tol", Form::Number),
    ("energy_solves", Form::Whole),
];

const PUNCH: Keys = &[
    ("length", Form::Number),
    ("dim", Form::Whole),
    ("n", Form::Whole),
    ("punch_fraction", Form::Number),
    ("depth", Form::Number),
    ("contact", Form::Word),
    ("nodes", Form::Word),
    ("mask", Form::Stored),
    ("traction", Form::Stored),
    ("shift", Form::Numbers),
    ("refine", Form::Whole),
];

const BELOW: Keys = &[
    ("surface", Form::Input),
    ("wave", Form::Places),
    ("n", Form::Wholes),
    ("load", Form::Whole),
    ("length", Form::Numbers),
    ("mean_traction", Form::Numbers),
    ("depths", Form::Numbers),
    ("slice", Form::Word),
    ("quantities", Form::Words),
];

/// Keys that say how a run was shown and kept, and change no number of a result. They are left out.
const SHOWN: [&str; 10] =
    ["out", "plots", "vtk", "resume", "checkpoint", "compare", "draw", "levels", "deepest", "scan"];

/// The longest text of a configuration.
const LONGEST: usize = 1 << 24;

/// The longest word, and the longest value in a message.
const LONGEST_WORD: usize = 200;

/// The keys of results of a `kind`.
fn keys(kind: Kind) -> impl Iterator<Item = &'static (&'static str, Form)> {
    let groups: &[Keys] = match kind {
        Kind::Contact => &[SOURCE, BODY, MODULUS, LOADS, LAW, INTERACTION, SEARCH, METHOD, CONTACT],
        Kind::Path => &[SOURCE, BODY, MODULUS, LOADS, LAW, INTERACTION, SEARCH, PATH],
        Kind::Punch => &[PUNCH, BODY, SEARCH, METHOD],
        Kind::Body => &[BELOW, BODY, MODULUS],
        // It is read by the library, which refuses all other keys.
        Kind::KappaSweep => &[],
    };
    groups.iter().copied().flatten()
}

/// The configuration of a result, of keys and values that the results of its kind have.
#[derive(Clone, Debug)]
pub(crate) struct Configuration {
    kind: Kind,
    table: toml::Table,
}

impl Configuration {
    /// Reads the configuration of a result of a `kind`.
    ///
    /// # Errors
    /// A text that is not TOML; a key that results of this kind do not have; a value of another type.
    pub(crate) fn read(kind: Kind, text: &str) -> Result<Self, Failure> {
        let refuse = |reason: String| Failure::input("config of the file", reason);
        if text.len() > LONGEST {
            return Err(refuse(format!("it has {} bytes; it must have at most {LONGEST}", text.len())));
        }
        let all: toml::Table = text.parse().map_err(|error: toml::de::Error| refuse(one_line(error.message())))?;
        let mut table = toml::Table::new();
        for (key, value) in all {
            match keys(kind).find(|(name, _)| *name == key) {
                Some((_, form)) if form.allows(&value) => drop(table.insert(key, value)),
                Some((_, form)) => {
                    return Err(refuse(format!("{key} is {}; it must be {}", shown(&value), form.words())));
                }
                None if SHOWN.contains(&key.as_str()) => {}
                None => {
                    let key = shown(&Value::String(key));
                    return Err(refuse(format!("{key} is no key of a result of {}", kind.name())));
                }
            }
        }
        Ok(Self { kind, table })
    }

    /// The keys and values.
    pub(crate) fn into_table(self) -> toml::Table {
        self.table
    }

    /// True if the configuration has this key.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// True if the value of this key names a file.
    pub(crate) fn names_a_file(&self, key: &str) -> bool {
        self.forms().any(|(name, form, value)| name == key && form.is_file(value))
    }

    /// The flags of the run, without those in `except`, and without those that name files.
    pub(crate) fn words(&self, except: &[&str]) -> Vec<String> {
        self.flags(|key, form, value| !except.contains(&key) && !form.is_file(value))
    }

    /// The flags of these keys alone.
    pub(crate) fn words_of(&self, keys: &[&str]) -> Vec<String> {
        self.flags(|key, form, value| keys.contains(&key) && !form.is_file(value))
    }

    /// The text of a key; empty if it has none.
    pub(crate) fn text(&self, key: &str) -> &str {
        self.table.get(key).and_then(Value::as_str).unwrap_or_default()
    }

    /// All flags of the run, to be shown.
    pub(crate) fn told(&self) -> Vec<String> {
        self.flags(|_, _, _| true)
    }

    /// The input of a result of `body`.
    pub(crate) fn file(&self) -> Option<&str> {
        self.forms().find(|(_, form, _)| *form == Form::Input).and_then(|(.., value)| value.as_str())
    }

    fn forms(&self) -> impl Iterator<Item = (&'static str, Form, &Value)> {
        self.table.iter().filter_map(|(key, value)| {
            let (name, form) = keys(self.kind).find(|(name, _)| *name == key)?;
            Some((*name, *form, value))
        })
    }

    fn flags(&self, chosen: impl Fn(&str, Form, &Value) -> bool) -> Vec<String> {
        let mut words = Vec::new();
        for (key, form, value) in self.forms().filter(|(key, form, value)| chosen(key, *form, value)) {
            let flag = format!("--{}", key.replace('_', "-"));
            match (form, value) {
                (_, Value::Boolean(given)) => words.extend(given.then_some(flag)),
                (Form::Rows | Form::Places | Form::Pairs, Value::Array(lists)) => {
                    let between = if form == Form::Pairs { "=" } else { "," };
                    let lists = lists.iter().filter_map(Value::as_array);
                    words.extend(lists.map(|list| format!("{flag}={}", joined(list, between))));
                }
                (_, Value::Array(values)) => words.push(format!("{flag}={}", joined(values, ","))),
                (_, value) => words.push(format!("{flag}={}", text(value))),
            }
        }
        words
    }
}

impl Form {
    /// True for a value that names a file.
    fn is_file(self, value: &Value) -> bool {
        match self {
            Self::Stored | Self::Input => true,
            Self::NumberOrStored => value.is_str(),
            _ => false,
        }
    }

    fn allows(self, value: &Value) -> bool {
        let all = |one: fn(&Value) -> bool| value.as_array().is_some_and(|values| values.iter().all(one));
        match self {
            Self::Flag => value.is_bool(),
            Self::Whole => is_whole(value),
            Self::Number => is_number(value),
            Self::Height => is_number(value) || value.as_str() == Some("inf"),
            Self::Word => is_word(value),
            Self::Wholes => all(is_whole),
            Self::Numbers => all(is_number),
            Self::Words => all(is_word),
            Self::Rows => all(|row| row.as_array().is_some_and(|row| row.iter().all(is_number))),
            Self::Places => all(|place| {
                let is_part = |part: &Value| is_number(part) || matches!(part.as_str(), Some("x" | "y" | "z"));
                place.as_array().is_some_and(|parts| parts.iter().all(is_part))
            }),
            Self::Pairs => all(|pair| {
                let pair = pair.as_array().map(Vec::as_slice);
                matches!(pair, Some([name, number]) if is_word(name) && is_number(number))
            }),
            Self::Stored | Self::Input => value.is_str(),
            Self::NumberOrStored => is_number(value) || value.is_str(),
        }
    }

    fn words(self) -> &'static str {
        match self {
            Self::Flag => "true or false",
            Self::Whole => "a whole number from 0",
            Self::Number => "a number",
            Self::Height => "a number, or \"inf\"",
            Self::Word => "a word",
            Self::Wholes => "a list of whole numbers from 0",
            Self::Numbers => "a list of numbers",
            Self::Words => "a list of words",
            Self::Rows => "a list of lists of numbers",
            Self::Places => "a list of lists of numbers with a component x, y or z",
            Self::Pairs => "a list of names with a number each",
            Self::Stored | Self::Input => "a text",
            Self::NumberOrStored => "a number, or a text",
        }
    }
}

fn is_whole(value: &Value) -> bool {
    value.as_integer().is_some_and(|number| number >= 0)
}

fn is_number(value: &Value) -> bool {
    value.is_integer() || value.is_float()
}

/// A word of a few letters and digits; not one that a command could take for another flag.
fn is_word(value: &Value) -> bool {
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_.=+,".contains(c);
    value.as_str().is_some_and(|word| {
        (1..=LONGEST_WORD).contains(&word.len()) && !word.starts_with('-') && word.chars().all(allowed)
    })
}

fn text(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), Into::into)
}

fn joined(values: &[Value], between: &str) -> String {
    values.iter().map(text).collect::<Vec<_>>().join(between)
}

/// A value in a message: one line, not too long.
fn shown(value: &Value) -> String {
    let text = value.as_str().map_or_else(|| one_line(&value.to_string()), |text| format!("{text:?}"));
    match text.char_indices().nth(LONGEST_WORD) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text,
    }
}

fn one_line(text: &str) -> String {
    text.escape_debug().to_string().replace("\\n", " ").replace("\\\"", "\"")
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn a_configuration_becomes_flags() {
        let config = "young = 1.0\np_star = [0.01, -0.5]\nflip = true\ndetrend = \"none\"\nstatistics = false\n\
                      height = inf\nparam = [[\"gamma\", 1e-4], [\"range\", 0.003]]\nplots = \"p\"\n\
                      surface = \"/dev/zero\"\nhardness = \"h.npy\"\nhistory_mode = [[1, -2, \"z\"]]\n";
        let found = Configuration::read(Kind::Contact, config).unwrap();
        let mut sorted = found.words(&["young"]);
        sorted.sort();
        let wanted = [
            "--detrend=none",
            "--flip",
            "--height=inf",
            "--history-mode=1,-2,z",
            "--p-star=0.01,-0.5",
            "--param=gamma=0.0001",
            "--param=range=0.003",
        ];
        assert_eq!(sorted, wanted);
        let told = found.told();
        assert!(told.contains(&"--surface=/dev/zero".into()) && !told.iter().any(|word| word.contains("plots")));
        assert!(found.has("surface") && !found.has("plots") && found.file().is_none());
    }

    #[test]
    fn other_keys_and_other_types_are_refused_in_one_line() {
        for (config, words) in [
            ("young = ", "config of the file: "),
            ("evil = 1", "\"evil\" is no key of a result of contact"),
            ("\"--out\" = \"x\"", "\"--out\" is no key"),
            ("\"a\\nb\" = 1", "\"a\\nb\" is no key"),
            ("threads = 1", "\"threads\" is no key"),
            ("young = \"--out=x\"", "young is \"--out=x\"; it must be a number"),
            ("young = [1.0]", "young is [1.0]; it must be a number"),
            ("law = \"--out=x\"", "law is \"--out=x\"; it must be a word"),
            ("law = \"morse\\n--out=x\"", "law is \"morse\\n--out=x\"; it must be a word"),
            ("law = [\"morse\"]", "it must be a word"),
            ("law = \"\"", "it must be a word"),
            ("seed = -1", "seed is -1; it must be a whole number from 0"),
            ("seed = 18446744073709551615", "config of the file: "),
            ("p_star = 0.1", "it must be a list of numbers"),
            ("p_star = [\"1:2:3\"]", "it must be a list of numbers"),
            ("param = [[\"gamma=1 --out\", 1.0]]", "it must be a list of names with a number each"),
            ("param = [[\"gamma\", 1.0, 2.0]]", "it must be a list of names with a number each"),
            ("history_point = [[0.0, 0.0, \"--out\"]]", "with a component x, y or z"),
            ("surface = 1", "surface is 1; it must be a text"),
            ("flip = \"yes\"", "it must be true or false"),
            ("[young]\nx = 1", "it must be a number"),
        ] {
            let message = Configuration::read(Kind::Contact, config).unwrap_err().to_string();
            assert!(message.contains(words) && message.starts_with("config of the file: "), "{config}: {message}");
            assert!(!message.contains('\n') && message.len() < 500, "{message}");
        }
        let long = format!("law = \"{}\"", "a".repeat(10_000));
        assert!(Configuration::read(Kind::Contact, &long).unwrap_err().to_string().len() < 500);
    }

    #[test]
    fn every_flag_of_a_command_is_a_key_or_only_shows() {
        fn flags<A: clap::Args>() -> BTreeSet<String> {
            let command = A::augment_args(clap::Command::new("gfmd"));
            command.get_arguments().map(|argument| argument.get_id().to_string()).collect()
        }
        for (kind, flags) in [
            (Kind::Contact, flags::<crate::contact::Args>()),
            (Kind::Path, flags::<crate::path::Args>()),
            (Kind::Punch, flags::<crate::punch::Args>()),
            (Kind::Body, flags::<crate::body::Args>()),
        ] {
            let known: BTreeSet<String> = keys(kind).map(|(name, _)| (*name).into()).collect();
            assert_eq!(keys(kind).count(), known.len(), "{kind:?}: a key stands twice");
            let shown: BTreeSet<String> = SHOWN.map(Into::into).into();
            let new: Vec<&String> = flags.difference(&known).filter(|flag| !shown.contains(*flag)).collect();
            assert!(new.is_empty(), "{kind:?}: {new:?} describe the problem, or are only shown");
            let gone: Vec<&String> = known.difference(&flags).collect();
            assert!(gone.is_empty(), "{kind:?}: {gone:?} are no flags");
            assert!(known.is_disjoint(&shown));
        }
    }
}
