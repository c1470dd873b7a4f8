//! Cells of a sheet, and the texts that sheets share.

use super::MOST_STRINGS;
use crate::bytes::clip;

/// Largest number of fields of the text of a sheet for each cell, and for any sheet.
const MOST_EMPTY: usize = 8;
const FEW: usize = 1000;

/// Error of a sheet without numbers.
pub(super) const NO_NUMBERS: &str = "the sheet has no numbers; it must have them";

/// Cell with a value: its line and column from 1 on.
pub(super) struct Cell {
    pub(super) line: u32,
    pub(super) column: u32,
    pub(super) text: String,
    pub(super) is_number: bool,
}

/// Cells of a sheet, in the order of the file.
pub(super) struct Sheet {
    pub(super) cells: Vec<Cell>,
}

/// Part of an XML text.
enum Event<'a> {
    /// Local name, the whole tag, and true if it has no content.
    Open(&'a str, &'a str, bool),
    Close(&'a str),
    Text(&'a str),
}

/// Returns the parts of an XML text, without its declarations and comments.
fn events(xml: &str) -> impl Iterator<Item = Event<'_>> {
    let mut rest = xml;
    std::iter::from_fn(move || {
        loop {
            if rest.is_empty() {
                return None;
            }
            let Some(tag) = rest.strip_prefix('<') else {
                let (text, after) = rest.split_at(rest.find('<').unwrap_or(rest.len()));
                rest = after;
                return Some(Event::Text(text));
            };
            let end = tag.find('>')?;
            rest = &tag[end + 1..];
            let tag = &tag[..end];
            if tag.starts_with(['?', '!']) {
                continue;
            }
            let local =
                |tag: &'_ str| -> usize { tag.find(|c: char| c.is_whitespace() || c == '/').unwrap_or(tag.len()) };
            if let Some(name) = tag.strip_prefix('/') {
                return Some(Event::Close(bare(&name[..local(name)])));
            }
            return Some(Event::Open(bare(&tag[..local(tag)]), tag, tag.ends_with('/')));
        }
    })
}

/// Returns a name without its prefix.
fn bare(name: &str) -> &str {
    name.rsplit_once(':').map_or(name, |(_, name)| name)
}

/// Returns an attribute of a tag.
fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    let mut words = tag.split([' ', '\t', '\n', '\r']).filter_map(|word| word.split_once('='));
    let (_, value) = words.find(|(key, _)| *key == name)?;
    Some(value.trim_end_matches('/').trim_matches(['"', '\'']))
}

/// Replaces the entities of XML.
fn plain(text: &str) -> String {
    let named = [
        ("&lt;", "<"),
        ("&gt;", ">"),
        ("&quot;", "\""),
        ("&apos;", "'"),
        ("&#181;", "µ"),
        ("&#xB5;", "µ"),
        ("&amp;", "&"),
    ];
    named.iter().fold(text.to_owned(), |text, (name, character)| text.replace(name, character))
}

/// Reads the texts that sheets share, up to a number of bytes.
pub(super) fn strings(xml: &str) -> Vec<String> {
    let (mut found, mut bytes, mut is_text, mut is_reading) = (Vec::<String>::new(), 0, false, false);
    for event in events(xml) {
        match event {
            Event::Open("si", ..) if bytes < MOST_STRINGS => {
                found.push(String::new());
                bytes += size_of::<String>();
            }
            // Phonetic readings stand beside the text.
            Event::Open("rPh", _, is_empty) => is_reading = !is_empty,
            Event::Close("rPh") => is_reading = false,
            Event::Open("t", _, is_empty) => is_text = !is_empty,
            Event::Close("t") => is_text = false,
            Event::Text(text) if is_text && !is_reading && bytes < MOST_STRINGS => {
                bytes += text.len();
                if let Some(last) = found.last_mut() {
                    last.push_str(&plain(text));
                }
            }
            _ => {}
        }
    }
    found
}

/// Returns the line and column of a cell such as `B3`.
fn place(name: &str) -> Option<[u32; 2]> {
    let digits = name.find(|c: char| c.is_ascii_digit())?;
    let letter = |column: u32, c: char| {
        let digit = u32::from(c.to_ascii_uppercase()).checked_sub(64).filter(|digit| (1..=26).contains(digit))?;
        column.checked_mul(26)?.checked_add(digit)
    };
    let column = name[..digits].chars().try_fold(0, letter)?;
    Some([name[digits..].parse().ok()?, column])
}

impl Sheet {
    /// Reads the cells with values.
    pub(super) fn read(xml: &str, strings: &[String]) -> Result<Self, String> {
        let (mut cells, mut at, mut kind, mut is_value) = (Vec::new(), [0_u32, 0], "", false);
        for event in events(xml) {
            match event {
                Event::Open("row", tag, _) => {
                    let line = attribute(tag, "r").and_then(|line| line.parse().ok());
                    at = [line.unwrap_or(at[0].saturating_add(1)), 0];
                }
                Event::Open("c", tag, _) => {
                    at = attribute(tag, "r").and_then(place).unwrap_or([at[0], at[1].saturating_add(1)]);
                    kind = attribute(tag, "t").unwrap_or("n");
                }
                Event::Open("v" | "t", _, is_empty) => is_value = !is_empty,
                Event::Close("v" | "t") => is_value = false,
                Event::Text(text) if is_value => {
                    let text = match kind {
                        "s" => {
                            let shared = text.trim().parse().ok().and_then(|index: usize| strings.get(index));
                            shared
                                .cloned()
                                .ok_or_else(|| format!("a cell has the text {:?}, which is not there", clip(text)))?
                        }
                        _ => plain(text),
                    };
                    cells.push(Cell { line: at[0], column: at[1], is_number: kind == "n", text });
                }
                _ => {}
            }
        }
        Ok(Self { cells })
    }

    /// Returns the text of the cell in a line and a column, empty if it has none.
    pub(super) fn get(&self, [line, column]: [u32; 2]) -> &str {
        let found = self.cells.iter().find(|cell| (cell.line, cell.column) == (line, column));
        found.map(|cell| cell.text.trim()).unwrap_or_default()
    }

    /// Returns the numbers of a column.
    pub(super) fn column(&self, column: u32) -> Result<Vec<f64>, String> {
        let cells = self.cells.iter().filter(|cell| cell.column == column && cell.is_number);
        let number = |cell: &Cell| {
            cell.text
                .trim()
                .parse()
                .map_err(|_| format!("a cell in line {} is {:?}; it must be a number", cell.line, clip(&cell.text)))
        };
        cells.map(number).collect()
    }

    /// Writes the cells as lines of fields between tabs. Empty cells beside numbers are `nan`.
    pub(super) fn text(&self) -> Result<String, String> {
        let numbers = || self.cells.iter().filter(|cell| cell.is_number).map(|cell| cell.column);
        let (Some(first), Some(last)) = (numbers().min(), numbers().max()) else {
            return Err(NO_NUMBERS.into());
        };
        let width = (last - first) as usize + 1;
        let (mut text, mut fields, most) = (String::new(), 0_usize, MOST_EMPTY * self.cells.len() + FEW);
        let mut last_line = None;
        for line in self.cells.chunk_by(|a, b| a.line == b.line) {
            let mut words = vec![];
            if line.iter().any(|cell| cell.is_number) {
                let number = line[0].line;
                if let Some(last) = last_line.replace(number).filter(|last: &u32| last.checked_add(1) != Some(number)) {
                    return Err(format!(
                        "line {number} follows line {last}; lines with numbers must follow each other"
                    ));
                }
                fields = fields.saturating_add(width);
                if fields > most {
                    return Err(format!(
                        "the {} cells are scattered over {width} columns; they must be a table",
                        self.cells.len()
                    ));
                }
                words.resize(width, "nan");
            }
            for cell in line {
                match cell.column.checked_sub(first).and_then(|column| words.get_mut(column as usize)) {
                    Some(word) => *word = cell.text.trim(),
                    None => words.push(cell.text.trim()),
                }
            }
            text.push_str(&words.join("\t").replace(['\n', '\r'], " "));
            text.push('\n');
        }
        Ok(text)
    }
}
