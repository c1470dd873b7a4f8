//! Comments are plain English (docs/style.md): the phrases that make them hard to read do not come back.

use std::path::{Path, PathBuf};

use crate::lines::collect;

/// Phrases that stand for a missing noun or a missing verb.
const PHRASES: [&str; 4] = ["that of", "those of", "of which", "so many"];

/// First words of a sentence that describes something without naming it.
const OPENINGS: [&str; 3] = ["What ", "Whether ", "That of "];

/// Most findings in a thousand lines of comments. It may fall, not rise.
const MOST: f64 = 1.0;

/// Folders with Rust sources.
const FOLDERS: [&str; 3] = ["crates", "tests", "xtask"];

/// Returns the text of a comment line without its slashes, if the line is a comment.
fn comment(line: &str) -> Option<&str> {
    Some(line.trim_start().strip_prefix("//")?.trim_start_matches(['/', '!']).trim())
}

/// Returns the number of comment lines of a source, and its findings.
fn findings(source: &str) -> (usize, Vec<String>) {
    let (mut count, mut found, mut block) = (0, Vec::new(), String::new());
    for line in source.lines().chain([""]) {
        if let Some(text) = comment(line) {
            count += 1;
            block += if block.is_empty() { "" } else { " " };
            block += text;
            continue;
        }
        let is_word = |at: usize, length: usize| {
            let around = [block[..at].chars().next_back(), block[at + length..].chars().next()];
            around.iter().flatten().all(|letter| !letter.is_alphanumeric())
        };
        for phrase in PHRASES {
            let all = block.match_indices(phrase).filter(|(at, _)| is_word(*at, phrase.len()));
            found.extend(all.map(|_| format!("\"{phrase}\" in: {block}")));
        }
        found.extend(OPENINGS.iter().filter(|word| block.starts_with(**word)).map(|_| format!("opening of: {block}")));
        block.clear();
    }
    (count, found)
}

#[test]
fn comments_are_plain_english() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut sources: Vec<PathBuf> = Vec::new();
    FOLDERS.iter().for_each(|folder| collect(&root.join(folder), &mut sources));
    let sources = sources.into_iter().filter(|path| path.extension().is_some_and(|ending| ending == "rs"));
    let (mut lines, mut all) = (0, Vec::new());
    for path in sources.filter(|path| path.file_name() != Some("english.rs".as_ref())) {
        let (count, found) = findings(&std::fs::read_to_string(&path).unwrap());
        lines += count;
        all.extend(found.into_iter().map(|text| format!("{}: {text}", path.display())));
    }
    let rate = 1000.0 * all.len() as f64 / lines as f64;
    assert!(rate <= MOST, "{rate:.2} findings in a thousand lines, at most {MOST}:\n{}", all.join("\n"));
    assert!(lines > 10_000, "{lines} lines");
}

#[test]
fn a_phrase_is_found_across_lines() {
    let of = |source: &str| findings(source).1.len();
    assert_eq!(of("/// The height is that\n/// of the mean.\nlet x = 1;"), 1);
    assert_eq!(of("/// Whether it holds.\nfn holds() {}\n// What is left"), 2);
    assert_eq!(of("let text = \"those of\"; // so manifold\n//! Returns the height."), 0);
    assert_eq!(findings("/// a\n/// b\nfn c() {}").0, 2);
}
