//! Python classes with documented properties, for the tests of `gfmd-record` and `gfmd-cli`.

/// Longest line of the file.
const WIDTH: usize = 120;

/// Property of a class: name, type, definition, and the expression of its value.
pub(crate) struct Property {
    pub(crate) name: String,
    pub(crate) of: &'static str,
    pub(crate) text: String,
    pub(crate) value: String,
}

impl Property {
    /// Returns a property that reads its value from a record.
    pub(crate) fn of_record(name: String, of: &'static str, text: String) -> Self {
        let value = format!("self._value(\"{name}\")");
        Self { name, of, text, value }
    }
}

/// Returns the source text of a class.
pub(crate) fn class(name: &str, base: &str, text: &str, properties: &[Property]) -> String {
    let head = format!("\n\nclass {name}{base}:\n    \"\"\"{text}\"\"\"\n");
    properties.iter().fold(head, |class, Property { name, of, text, value }| {
        let text = filled(&format!("\"\"\"{text}"), 8);
        class + &format!("\n    @property\n    def {name}(self) -> {of}:\n{text}\n        return {value}\n")
    })
}

/// Wraps a docstring that begins with its quotes. The closing quotes follow below if there are several lines.
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

/// Returns the kind of quantity for the beginning of a definition.
pub(crate) fn quantity(unit: &str) -> String {
    let words = match unit {
        "1" => "without unit".to_owned(),
        "s" => "seconds".to_owned(),
        unit => unit.replace('*', " * "),
    };
    words[..1].to_uppercase() + &words[1..]
}

/// Writes a generated file if requested, and compares it with `text`.
pub(crate) fn compare(file: &str, text: &str) {
    if std::env::var_os("GFMD_DOCS").is_some_and(|what| what == "write") {
        std::fs::write(file, text).unwrap();
    }
    assert!(text.lines().all(|line| line.chars().count() <= WIDTH));
    assert_eq!(std::fs::read_to_string(file).unwrap(), text);
}
