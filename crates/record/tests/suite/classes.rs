//! Classes of Python made from tables: a stub with types and definitions, and the definitions as JSON.

use serde_json::{Map, Value, json};

/// Longest line of a file.
const WIDTH: usize = 120;

/// Attribute of a class.
pub(crate) struct Property {
    pub(crate) name: String,
    /// Type in Python.
    pub(crate) of: &'static str,
    /// Definition.
    pub(crate) text: String,
}

/// Class of attributes that stand in a record, or are fields of a result.
pub(crate) struct Class {
    pub(crate) name: &'static str,
    pub(crate) text: &'static str,
    /// Mapping that has the values of a class that is not a record.
    pub(crate) held_in: Option<&'static str>,
    pub(crate) properties: Vec<Property>,
}

impl Class {
    pub(crate) fn record(name: &'static str, text: &'static str, properties: Vec<Property>) -> Self {
        Self { name, text, held_in: None, properties }
    }

    /// Returns the class of a stub.
    pub(crate) fn stub(&self) -> String {
        let Self { name, text, held_in, properties } = self;
        let (base, held) = match held_in {
            Some(mapping) => ("", format!("\n    {mapping}: dict[str, Array]\n")),
            None => ("(Record)", String::new()),
        };
        let head = format!("\nclass {name}{base}:\n    \"\"\"{text}\"\"\"\n{held}");
        properties.iter().fold(head, |class, Property { name, of, text }| {
            let text = filled(&format!("\"\"\"{text}"), 8);
            class + &format!("\n    @property\n    def {name}(self) -> {of}:\n{text}\n")
        })
    }

    /// Returns the definitions of the attributes.
    pub(crate) fn definitions(&self) -> Value {
        let texts = self.properties.iter().map(|property| (property.name.clone(), property.text.clone().into()));
        json!({"text": self.text, "held_in": self.held_in, "attributes": texts.collect::<Map<_, _>>()})
    }
}

/// Returns the lines of a docstring that begins with its quotes. Quotes close it below the last of several lines.
fn filled(text: &str, indent: usize) -> String {
    let margin = " ".repeat(indent);
    let mut lines = vec![margin.clone()];
    for word in text.split(' ') {
        let last = lines.last_mut().unwrap();
        if last.trim().is_empty() {
            last.push_str(word);
        } else if last.len() + 1 + word.len() > WIDTH - 3 {
            lines.push(format!("{margin}{word}"));
        } else {
            *last += &format!(" {word}");
        }
    }
    let end = if lines.len() > 1 { format!("\n{margin}\"\"\"") } else { "\"\"\"".to_owned() };
    lines.join("\n") + &end
}

/// Returns the kind of quantity for the start of a definition.
pub(crate) fn quantity(unit: &str) -> String {
    let words = match unit {
        "1" => "without unit".to_owned(),
        "s" => "seconds".to_owned(),
        unit => unit.replacen("1/", "per ", 1).replace('*', " * "),
    };
    words[..1].to_uppercase() + &words[1..]
}

/// Writes a generated file if `GFMD_DOCS` says so, and compares it.
pub(crate) fn compare(file: &str, text: &str) {
    if std::env::var_os("GFMD_DOCS").is_some_and(|what| what == "write") {
        std::fs::write(file, text).unwrap();
    }
    assert_eq!(std::fs::read_to_string(file).unwrap(), text);
}
