//! Document docs/validation.md: tables of the checks, and figures.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use gfmd_input::failure::Failure;
use gfmd_tests::Reference;

use super::{Report, figures};

/// Writes `validation.md` and `images/validation-*` into `folder`.
pub(super) fn write(folder: &Path, report: &Report, reference: &Reference) -> Result<Vec<PathBuf>, Failure> {
    let failed = |path: &Path, error| Failure::computation(format!("cannot write {}: {error}", path.display()));
    let images = folder.join("images");
    std::fs::create_dir_all(&images).map_err(|error| failed(&images, error))?;
    let path = folder.join("validation.md");
    std::fs::write(&path, text(report)).map_err(|error| failed(&path, error))?;
    let mut written = vec![path];
    written.extend(figures::draw(&images.join("validation"), reference)?);
    Ok(written)
}

fn text(report: &Report) -> String {
    let mut text = format!(
        "# Validation\n\n\
         Comparison with independent references, closed forms and identities: {} checks, {} failed. `cargo xtask \
         verify\n--write-docs` writes this page, `cargo test -p gfmd-tests` asserts the checks. An error is the \
         largest of all compared\nnumbers, relative unless stated otherwise; ″ repeats the line above. Origin of \
         the references:\n[data/reference](../data/reference/README.md).\n",
        report.checks, report.failed
    );
    for topic in &report.topics {
        let _ = write!(text, "\n## {}\n\n| check | against | found, bound |\n|---|---|---|\n", topic.title);
        let mut above = None;
        for check in &topic.checks {
            let [value, bound] = check.words();
            let mark = if check.passed { "" } else { ", **failed**" };
            let source = if above == Some(check.source) { "″" } else { check.source };
            let _ = writeln!(text, "| {} | {source} | {value} {bound}{mark} |", check.name);
            above = Some(check.source);
        }
    }
    text.push_str("\n## Figures\n");
    for (name, caption) in figures::CAPTIONS {
        let _ = write!(text, "\n![{name}](images/validation-{name}.svg)\n\n{caption}\n");
    }
    text
}
