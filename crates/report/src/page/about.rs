//! Sections common to all pages: origin, cost, repetition, citation.

use gfmd_files::{Provenance, Reader};
use maud::{Markup, html};
use serde::Deserialize as _;

use super::said::with_unit;
use super::write::{given, of, quoted, text};
use super::{Common, Fact, Page, block, render};

use gfmd_check::result::ResultKind;
use gfmd_input::lower::{self, LowerArgs};
use gfmd_problem::options::OtherArgs;
use gfmd_unit::Units;

/// Returns the warnings of the run, one per line.
pub fn warnings(reader: &Reader) -> Vec<String> {
    let all = reader.text("/", "warnings").unwrap_or_default();
    all.lines().filter(|line| !line.trim().is_empty()).map(text).collect()
}

/// Renders the page with the sections common to all results. `again` is the command that repeats the run, or the reason
/// why it cannot be repeated.
pub fn whole_page(
    page: &Page,
    reader: &Reader,
    kind: ResultKind,
    intact: Option<bool>,
    again: &Result<String, String>,
) -> Markup {
    let root = |name: &str| text(&reader.text("/", name).unwrap_or_default());
    let file = reader.path().file_name().map(|name| text(&name.to_string_lossy())).unwrap_or_default();
    let dated = dated(&root("created"));
    let threads = reader
        .number("/", "threads")
        .map(|threads| format!(", {threads} thread{}", if threads == 1.0 { "" } else { "s" }));
    let threads = threads.unwrap_or_default();
    let mut cost = Vec::new();
    if !root("machine").is_empty() {
        cost.push(Fact::new("machine", &format!("{}{threads}", root("machine"))));
    }
    let checksum = match intact {
        Some(true) => "The checksum of the content holds.",
        _ => "The file has no checksum of its content, which every version writes: it was changed.",
    };
    let (version, commit) = (root("version"), root("git_commit"));
    let whole: String = reader.text("/", "config").unwrap_or_default();
    let common = Common {
        kicker: format!("gfmd {} · {file}", kind.name()),
        dated,
        // Fields below a surface need no search; `check` compares their means.
        checksum: (kind != ResultKind::Body).then_some(checksum),
        repeat: repeat(reader, kind, again, &file),
        config: whole,
        cost,
        own: own(&version, &commit),
        version: format!(
            "Computed by {} {version}, commit {commit}; page made by gfmd {} from {file}, layout {}.",
            root("program"),
            env!("CARGO_PKG_VERSION"),
            reader.number("/", "schema_version").map_or_else(|_| "unknown".into(), |schema| schema.to_string()),
        ),
    };
    render(page, &common)
}

/// Renders the page about an object other than a result file. `repeat` describes how to make it again.
pub(crate) fn page_of(page: &Page, kicker: String, provenance: &Provenance, repeat: Markup) -> Markup {
    let Provenance { program, version, git_commit, created, .. } = provenance;
    render(
        page,
        &Common {
            kicker,
            dated: dated(created),
            checksum: None,
            config: provenance.config.clone(),
            cost: Vec::new(),
            repeat,
            own: own(version, git_commit),
            version: format!("Computed, and the page made, by {program} {version}, commit {git_commit}."),
        },
    )
}

/// Formats a time in words.
fn dated(created: &str) -> String {
    match created.split_once('T') {
        Some((day, time)) => format!("{day}, {} UTC", time.split(['.', 'Z']).next().unwrap_or_default()),
        None => created.into(),
    }
}

/// Returns the citation of this program.
fn own(version: &str, commit: &str) -> Markup {
    html! {
        "The gfmd developers, " cite { "gfmd: Green’s function molecular dynamics of rough contact" }
        ", version " (version) " (commit " (commit.chars().take(12).collect::<String>()) ")."
    }
}

/// Renders a command so that lines break between flags, not within one.
pub(crate) fn command(words: &str) -> Markup {
    html! { @for word in text(words).split(' ') { span.word { (word) } " " } }
}

/// Renders the command that repeats the run, the recorded command, and the check.
fn repeat(reader: &Reader, kind: ResultKind, again: &Result<String, String>, file: &str) -> Markup {
    let recorded = text(&reader.text("/", "command").unwrap_or_default());
    let from_file = reader.text("/surface", "file").ok().map(|path| {
        let sum = reader.text("/surface", "file_sha256").unwrap_or_default();
        html! { p { "The surface was read from " code { (text(&path)) } ", SHA-256 " code { (text(&sum)) } "." } }
    });
    html! {
        @match again {
            Ok(again) => {
                p {
                    @if kind == ResultKind::KappaSweep { "With the configuration below as " code { "sweep.toml" } ":" }
                    @else if kind == ResultKind::Study { "With the configuration below as " code { "study.toml" } ":" }
                    @else { "All flags are written out:" }
                }
                (block(again, command(again)))
            }
            Err(reason) => p { (text(reason)) },
        }
        @if let Some(from_file) = from_file { (from_file) }
        p { "To recompute every number of the file from its inputs, and to run it again:" }
        pre tabindex="0" { code { "gfmd check " (quoted(file)) " --rerun" } }
        @if !recorded.is_empty() {
            p { "The command as it was given:" }
            (block(&recorded, command(&recorded)))
        }
    }
}

/// Describes the elastic body of a configuration.
pub(crate) fn body(table: &toml::Table, units: &Units) -> Fact {
    let value = |name: &str| Some(of(table, name)).filter(|value| value.is_finite());
    let material = match (value("e_star"), value("young"), value("poisson")) {
        (Some(e_star), ..) => html! { i { "E" } "* = " (with_unit(e_star, "stress", units)) },
        (None, Some(young), Some(poisson)) => html! {
            i { "E" } " = " (with_unit(young, "stress", units)) ", ν = " (given(poisson))
        },
        _ => html! { "material as in the configuration" },
    };
    let height = match value("height") {
        Some(height) => html! { "slab of height " (with_unit(height, "length", units)) },
        None => html! { "half-space" },
    };
    let between = LowerArgs::NAMES.iter().any(|name| table.contains_key(*name)).then_some(lower::BETWEEN);
    let others = OtherArgs::deserialize(table.clone()).map(|others| others.words(between, units)).unwrap_or_default();
    Fact(html! { "elastic body" }, html! { (height) ", " (material) @if !others.is_empty() { "; " (others) } })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_is_named_with_its_material() {
        let said = |config: &str| body(&config.parse().unwrap(), &Units::default()).1.into_string();
        assert_eq!(said("young = 1.0\npoisson = 0.25\nheight = \"inf\""), "half-space, <i>E</i> = 1, ν = 0.25");
        assert_eq!(said("e_star = 2\nheight = 0.5"), "slab of height 0.5, <i>E</i>* = 2");
        let coated = said("e_star = 2\nheight = 0.5\nbase = \"sliding\"\nlayer = [[3.0, 0.25, 0.1]]");
        let wanted = "slab of height 0.5, <i>E</i>* = 2; on a layer of height 0.1 (E = 3, nu = 0.25), on a \
                      frictionless rigid base";
        assert_eq!(coated, wanted);
        let squeezed = said("e_star = 2\nheight = 0.5\nlower_seed = 2");
        assert_eq!(squeezed, "slab of height 0.5, <i>E</i>* = 2; between two rigid surfaces");
        let si = Units::new(Some("m"), None);
        let layers = "young = 1e7\npoisson = 0.4\nheight = 2e-6\nlayer = [[3e9, 0.25, 1e-6]]\nsecond_body = [2e9, 0.3]";
        let wanted = "slab of height 2 µm, <i>E</i> = 10 MPa, ν = 0.4; on a layer of height 1 µm (E = 3 GPa, nu = \
                      0.25), bonded to a rigid base, against a half-space (E = 2 GPa, nu = 0.3) above";
        assert_eq!(body(&layers.parse().unwrap(), &si).1.into_string(), wanted);
    }
}
