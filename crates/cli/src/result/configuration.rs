//! The configuration of a result, read as data: the keys that describe its problem, each with its type, and no others.
//!
//! A result may come from a stranger. No key names a file that is written, and no file is opened that a key names, but the input
//! of a result of `body`, which [`Configuration::file`] returns and whose name the result has a second time, with a checksum.

use clap::Args;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::Kind;
use crate::failure::Failure;
use gfmd_problem::options::flags::{self, keys, line};

/// Keys that say how a run was shown and kept, and change no number of a result. They are left out.
const SHOWN: [&str; 10] =
    ["out", "plots", "vtk", "resume", "checkpoint", "compare", "draw", "levels", "deepest", "scan"];

/// Keys of files or parts of them, whose values stand in the result, from which they are taken; of `hardness` a text alone.
const FILES: [&str; 9] = [
    "surface",
    "channel",
    "second_surface",
    "base_displacement",
    "base_traction",
    "lower_surface",
    "hardness",
    "mask",
    "traction",
];

/// The longest text of a configuration.
const LONGEST: usize = 1 << 24;

/// The name of a configuration in messages.
const NAME: &str = "config of the file";

/// The keys of the results of a command with these flags.
fn keys_of<A: Args>() -> Vec<String> {
    let mut keys = keys::<A>();
    keys.retain(|key| !SHOWN.contains(&key.as_str()));
    keys
}

/// The configuration of a result, of keys and values that the results of its kind have.
#[derive(Clone, Debug)]
pub(crate) struct Configuration {
    table: Table,
}

impl Configuration {
    /// Reads the configuration of a result of a `kind`, of a command with these flags.
    ///
    /// # Errors
    /// A text that is not TOML; a key that results of this kind do not have; a value of another type.
    pub(crate) fn read<A: Args + DeserializeOwned>(kind: Kind, text: &str) -> Result<Self, Failure> {
        let refuse = |reason: String| Failure::input(NAME, reason);
        if text.len() > LONGEST {
            return Err(refuse(format!("it has {} bytes; it must have at most {LONGEST}", text.len())));
        }
        let mut table: Table = text.parse().map_err(|error: toml::de::Error| refuse(line(error.message())))?;
        let keys = keys_of::<A>();
        table.retain(|key, _| !SHOWN.contains(&key));
        if let Some(key) = table.keys().find(|key| !keys.contains(key)) {
            return Err(refuse(format!("{} is no key of a result of {}", flags::quoted(key), kind.name())));
        }
        let config = Self { table };
        config.as_named::<A>()?;
        Ok(config)
    }

    /// The keys and values.
    pub(crate) fn into_table(self) -> Table {
        self.table
    }

    /// True if the configuration has this key.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// True if the value of this key names a file.
    pub(crate) fn names_a_file(&self, key: &str) -> bool {
        FILES.contains(&key) && self.table.get(key).is_some_and(Value::is_str)
    }

    /// The input of a result of `body`.
    pub(crate) fn file(&self) -> Option<&str> {
        self.table.get("surface").and_then(Value::as_str)
    }

    /// The problem as it was named, to be described. The files in it are those that a stranger names: none may be opened.
    ///
    /// # Errors
    /// A value of another type, which is named.
    pub(crate) fn as_named<A: DeserializeOwned>(&self) -> Result<A, Failure> {
        flags::of_table(self.table.clone()).map_err(|reason| Failure::input(NAME, reason))
    }

    /// The problem, or a part of it, without the keys in `except`, and without those that name files, in place of which there are
    /// those that are `stored` in the result.
    ///
    /// # Errors
    /// As [`as_named`](Self::as_named).
    pub(crate) fn problem<A: DeserializeOwned>(&self, except: &[String], stored: Table) -> Result<A, Failure> {
        let own = |key: &String| !except.contains(key) && !self.names_a_file(key);
        let table = self.table.iter().filter(|(key, _)| own(key)).map(|(key, value)| (key.clone(), value.clone()));
        flags::of_table(table.chain(stored).collect()).map_err(|reason| Failure::input(NAME, reason))
    }

    /// All flags of the run, to be shown.
    pub(crate) fn told(&self) -> Vec<String> {
        let mut words = Vec::new();
        for (key, value) in &self.table {
            let flag = format!("--{}", key.replace('_', "-"));
            match value {
                Value::Boolean(given) => words.extend(given.then_some(flag)),
                Value::Array(lists) if lists.iter().any(Value::is_array) => {
                    let between = if key == "param" { "=" } else { "," };
                    words.extend(
                        lists
                            .iter()
                            .filter_map(Value::as_array)
                            .map(|list| format!("{flag}={}", joined(list, between))),
                    );
                }
                Value::Array(values) => words.push(format!("{flag}={}", joined(values, ","))),
                value => words.push(format!("{flag}={}", text(value))),
            }
        }
        words
    }
}

fn text(value: &Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), Into::into)
}

fn joined(values: &[Value], between: &str) -> String {
    values.iter().map(text).collect::<Vec<_>>().join(between)
}

#[cfg(test)]
mod tests {
    use gfmd_contact::Boundary;

    use super::*;
    use crate::{body, contact, path, punch};

    #[test]
    fn a_configuration_is_a_problem_and_flags() {
        let config = "young = 2.0\np_star = [0.01, -0.5]\nflip = true\ndetrend = \"none\"\nstatistics = false\n\
                      height = inf\nparam = [[\"gamma\", 1e-4], [\"range\", 0.003]]\nplots = \"p\"\n\
                      surface = \"/dev/zero\"\nhardness = \"h.npy\"\nhistory_mode = [[1, -2, \"z\"]]\nboundary = \"free\"\n";
        let found = Configuration::read::<contact::Args>(Kind::Contact, config).unwrap();
        let wanted = [
            "--boundary=free",
            "--detrend=none",
            "--flip",
            "--hardness=h.npy",
            "--height=inf",
            "--history-mode=1,-2,z",
            "--p-star=0.01,-0.5",
            "--param=gamma=0.0001",
            "--param=range=0.003",
            "--surface=/dev/zero",
            "--young=2.0",
        ];
        let mut told = found.told();
        told.sort();
        assert_eq!(told, wanted);
        assert!(found.has("surface") && !found.has("plots"));
        // Files are named by what stands in the result alone.
        let (young, surface) = ("young".to_owned(), Table::from_iter([("surface".to_owned(), "r.h5:/h".into())]));
        let problem = |stored: Table| found.problem::<contact::Args>(std::slice::from_ref(&young), stored).unwrap();
        let table = |stored: Table| Table::try_from(problem(stored)).unwrap();
        let bare = table(Table::new());
        assert!(!bare.contains_key("surface") && !bare.contains_key("hardness"));
        let (one, free) = (Value::Float(1.0), Value::String(Boundary::Free.name().into()));
        assert_eq!((&bare["young"], &bare["boundary"], &bare["flip"]), (&one, &free, &Value::Boolean(true)));
        assert_eq!(table(surface)["surface"].as_str(), Some("r.h5:/h"));
    }

    #[test]
    fn other_keys_and_other_types_are_refused_in_one_line() {
        for (config, words) in [
            ("young = ", "config of the file: "),
            ("evil = 1", "\"evil\" is no key of a result of contact"),
            ("\"--out\" = \"x\"", "\"--out\" is no key"),
            ("\"a\\nb\" = 1", "\"a\\nb\" is no key"),
            ("threads = 1", "\"threads\" is no key"),
            ("young = \"--out=x\"", "young is \"--out=x\": invalid type: string"),
            ("young = [1.0]", "young is [1.0]: invalid type: sequence"),
            ("law = \"--out=x\"", "law is \"--out=x\": "),
            ("law = \"morse\\n--out=x\"", "law is \"morse\\n--out=x\": "),
            ("law = [\"morse\"]", "law is [\"morse\"]: "),
            ("law = \"\"", "law is \"\": "),
            ("solver = \"best\"", "solver is \"best\": it must be one of auto, "),
            ("boundary = \"open\"", "boundary is \"open\": it must be one of periodic, free"),
            ("height = \"deep\"", "height is \"deep\": it must be a number, or \"inf\""),
            ("layer = [[1.0]]", "layer is [[1.0]]: it must be E, NU"),
            ("seed = -1", "seed is -1: "),
            ("dim = 4", "dim is 4: it must be a whole number from 2 to 3"),
            ("length = [1.0, 2.0, 3.0]", "it has 3 values; it must have 1 to 2"),
            ("seed = 18446744073709551615", "config of the file: "),
            ("p_star = 0.1", "p_star is 0.1: invalid type"),
            ("p_star = [\"1:2:3\"]", "p_star is [\"1:2:3\"]: invalid type"),
            ("param = [[\"gamma\", 1.0, 2.0]]", "param is [[\"gamma\", 1.0, 2.0]]: "),
            ("history_point = [[0.0, 0.0, \"--out\"]]", "it must be X,Y,COMPONENT"),
            ("surface = 1", "surface is 1: invalid type"),
            ("flip = \"yes\"", "flip is \"yes\": invalid type"),
            ("[young]\nx = 1", "young is "),
        ] {
            let message = Configuration::read::<contact::Args>(Kind::Contact, config).unwrap_err().to_string();
            assert!(message.contains(words) && message.starts_with("config of the file: "), "{config}: {message}");
            assert!(!message.contains('\n') && message.len() < 700, "{message}");
        }
        let long = format!("law = \"{}\"", "a".repeat(10_000));
        assert!(Configuration::read::<contact::Args>(Kind::Contact, &long).unwrap_err().to_string().len() < 700);
    }

    #[test]
    fn what_a_command_says_of_itself_is_read_again() {
        fn again<A: DeserializeOwned + serde::Serialize + Default>() {
            let told = toml::to_string(&A::default()).unwrap();
            let read: A = flags::of_table(told.parse().unwrap()).unwrap();
            assert_eq!(toml::to_string(&read).unwrap(), told);
        }
        again::<contact::Args>();
        again::<path::Args>();
        again::<punch::Args>();
        for keys in
            [keys_of::<contact::Args>(), keys_of::<path::Args>(), keys_of::<punch::Args>(), keys_of::<body::Args>()]
        {
            assert!(keys.len() > 10 && FILES.iter().any(|file| keys.iter().any(|key| key == file)), "{keys:?}");
        }
    }
}
