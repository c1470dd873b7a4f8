//! Texts that name options, spelled by the one who prints them: `--young 70GPa` on a command line, `young="70GPa"` in
//! Python.

use std::fmt;

/// Spelling of options in a text.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Spelling {
    /// Flags of a command line: `--boundary free`.
    #[default]
    Flag,
    /// Arguments of a Python function: `boundary="free"`.
    Argument,
}

/// Text that names options by their keys.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Words(Vec<Piece>);

#[derive(Clone, Debug, PartialEq, Eq)]
enum Piece {
    Text(String),
    Option { key: String, value: Option<String> },
}

/// Python arguments that group several options or have another name than their key.
const ARGUMENTS: [(&str, &str); 7] = [
    ("param", "law"),
    ("lateral_y", "lateral"),
    ("wear_by", "by"),
    ("layer", "layers"),
    ("slice", "along"),
    ("history_mode", "history_modes"),
    ("history_point", "history_points"),
];

/// Returns the Python argument of the option with this key.
pub fn argument(key: &str) -> &str {
    ARGUMENTS.iter().find(|(other, _)| *other == key).map_or(key, |(_, name)| name)
}

/// Returns the flag of the option with this key.
pub fn flag(key: &str) -> String {
    format!("--{}", key.replace('_', "-"))
}

/// Names the option with this key.
pub fn key(key: &str) -> Words {
    Words(vec![Piece::Option { key: key.to_owned(), value: None }])
}

/// Names the option with this key, and a value for it.
pub fn setting(key: &str, value: impl fmt::Display) -> Words {
    Words(vec![Piece::Option { key: key.to_owned(), value: Some(value.to_string()) }])
}

/// Joins texts, [`key`]s and [`setting`]s to [`Words`].
#[macro_export]
macro_rules! words {
    ($($piece:expr),+ $(,)?) => {
        $crate::Words::default()$(.and($piece))+
    };
}

impl Words {
    /// Appends further words.
    #[must_use]
    pub fn and(mut self, further: impl Into<Self>) -> Self {
        self.0.extend(further.into().0);
        self
    }

    /// Returns the key of the first option in the text.
    pub fn key(&self) -> Option<&str> {
        self.0.iter().find_map(|piece| if let Piece::Option { key, .. } = piece { Some(&**key) } else { None })
    }

    /// Returns true if the text is empty.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the words with another text in place of each one between the options.
    pub(crate) fn with_texts(self, change: impl Fn(&str) -> String) -> Self {
        let piece = |piece: Piece| match piece {
            Piece::Text(text) => Piece::Text(change(&text)),
            option @ Piece::Option { .. } => option,
        };
        Self(self.0.into_iter().map(piece).collect())
    }

    /// Returns the text with its options spelled as flags or as arguments.
    pub fn spelled(&self, spelling: Spelling) -> String {
        self.spelled_by(match spelling {
            Spelling::Flag => as_flag,
            Spelling::Argument => as_argument,
        })
    }

    /// Returns the text with its options spelled by a function of the key and the value, if the text gives one.
    pub fn spelled_by(&self, spell: impl Fn(&str, Option<&str>) -> String) -> String {
        let piece = |piece: &Piece| match piece {
            Piece::Text(text) => text.clone(),
            Piece::Option { key, value } => spell(key, value.as_deref()),
        };
        self.0.iter().map(piece).collect()
    }
}

fn as_flag(key: &str, value: Option<&str>) -> String {
    value.map_or_else(|| flag(key), |value| format!("{} {value}", flag(key)))
}

fn as_argument(key: &str, value: Option<&str>) -> String {
    let Some(value) = value else { return argument(key).to_owned() };
    // A parameter of a law is an argument of its own.
    let (name, value) = match (key, value.split_once('=')) {
        ("param", Some(parameter)) => parameter,
        _ => (argument(key), value),
    };
    let is_number = value.parse::<f64>().is_ok_and(f64::is_finite);
    if is_number { format!("{name}={value}") } else { format!("{name}=\"{value}\"") }
}

impl From<&str> for Words {
    fn from(text: &str) -> Self {
        text.to_owned().into()
    }
}

impl From<&String> for Words {
    fn from(text: &String) -> Self {
        text.clone().into()
    }
}

impl From<String> for Words {
    fn from(text: String) -> Self {
        Self(vec![Piece::Text(text)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_spelled_for_their_outlet() {
        let words = words!["left out with ", setting("relaxes", "shear"), ", or ", key("base_young"), " at most 2"];
        assert_eq!(words.spelled(Spelling::Flag), "left out with --relaxes shear, or --base-young at most 2");
        assert_eq!(words.spelled(Spelling::Argument), "left out with relaxes=\"shear\", or base_young at most 2");
        assert_eq!(words.key(), Some("relaxes"));
        let spelled = |words: Words| words.spelled(Spelling::Argument);
        assert_eq!(spelled(setting("param", "gamma=0.05J/m^2")), "gamma=\"0.05J/m^2\"");
        assert_eq!(spelled(setting("eps_t_inv", 1.5)), "eps_t_inv=1.5");
        assert_eq!(spelled(setting("height", "inf")), "height=\"inf\"");
        assert_eq!(spelled(key("param")), "law");
    }
}
