//! No source line is longer than 120 characters (docs/style.md). Exceptions are lines with an address and rows of
//! tables in comments, which cannot be broken.

use std::path::{Path, PathBuf};

/// Length of the longest line, in characters.
const WIDTH: usize = 120;

/// Folders of the repository with sources, and the endings of their names; scripts have none.
const FOLDERS: [&str; 8] = [".ci", ".github", "crates", "data", "docs", "packaging", "tests", "xtask"];
const ENDINGS: [&str; 9] = ["rs", "py", "pyi", "toml", "sh", "css", "js", "yml", "yaml"];

/// Returns the numbers, from 1, of the lines that are too long, with their lengths.
fn long_lines(text: &str) -> Vec<(usize, usize)> {
    let is_excepted = |line: &str| {
        let row = line.trim_start().strip_prefix("//").map(|comment| comment.trim_start_matches(['/', '!']));
        line.contains("://") || row.is_some_and(|row| row.trim_start().starts_with('|'))
    };
    let numbered = text.lines().enumerate().map(|(at, line)| (at + 1, line.chars().count(), line));
    let long = numbered.filter(|&(_, length, line)| length > WIDTH && !is_excepted(line));
    long.map(|(number, length, _)| (number, length)).collect()
}

/// Adds the sources in a folder and its subfolders.
pub(crate) fn collect(folder: &Path, sources: &mut Vec<PathBuf>) {
    for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = path.file_name().unwrap().to_string_lossy();
        let ending = path.extension().map(|ending| ending.to_string_lossy());
        if path.is_dir() {
            // Skips files left by tools: environments, caches, builds.
            if !name.starts_with(['.', '_']) && name != "target" {
                collect(&path, sources);
            }
        } else if ending.map_or(folder.file_name() == Some(".ci".as_ref()), |ending| ENDINGS.contains(&&*ending)) {
            sources.push(path);
        }
    }
}

#[test]
fn no_line_of_a_source_is_longer_than_120_characters() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut sources = vec![root.join("Cargo.toml"), root.join("deny.toml")];
    FOLDERS.iter().for_each(|folder| collect(&root.join(folder), &mut sources));
    let mut found = Vec::new();
    for source in &sources {
        let long = long_lines(&std::fs::read_to_string(source).unwrap());
        found.extend(long.iter().map(|(number, length)| format!("{}:{number} has {length}", source.display())));
    }
    assert!(found.is_empty(), "characters of lines, at most {WIDTH}:\n{}", found.join("\n"));
    assert!(sources.len() > 900, "{} files", sources.len());
}

#[test]
fn a_long_line_is_found_unless_it_cannot_be_broken() {
    let at = |line: String| long_lines(&format!("\n{line}\n"));
    assert_eq!(at("é".repeat(WIDTH)), []);
    assert_eq!(at("é".repeat(WIDTH + 1)), [(2, WIDTH + 1)]);
    let word = "word ".repeat(30);
    assert_eq!(at(format!("/// {word}")), [(2, 154)]);
    assert_eq!(at(format!("    //! | {word} | {word} |")), []);
    assert_eq!(at(format!("a | {word} |")), [(2, 156)]);
    assert_eq!(at(format!("# https://example.org {word}")), []);
}
