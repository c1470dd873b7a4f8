//! Contents of a page about a result, section by section, and its HTML.

mod about;
mod reading;
mod said;
mod sections;
mod write;

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::path::Path;

use gfmd_input::failure::Failure;
use gfmd_plot::{COLUMN, Chart, PlotError};
use gfmd_problem::key;
use gfmd_record::ROUGH;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use crate::figures::Drawn;

pub(crate) use about::{body, command, page_of};
pub use about::{warnings, whole_page};
pub(crate) use reading::{FaceFields, Stored, StoredSurface, config};
pub(crate) use said::{list, option, unit_for, with_unit};
pub use write::quoted;
pub(crate) use write::{given, interval, number, of, powers, sentence, text, transforms, whole};

/// Contents of a page about a result. The sections common to all kinds of results are added when it is written.
#[derive(Default)]
pub struct Page {
    /// Short description of the computed problem.
    pub(crate) title: String,
    /// Results, most important first.
    pub(crate) answer: Vec<Markup>,
    /// Description of the problem.
    pub(crate) asked: Vec<Fact>,
    pub(crate) figures: Vec<Figure>,
    pub(crate) tables: Vec<Table>,
    pub(crate) certificates: Vec<Certificate>,
    /// Failure of a search, if there is one.
    pub(crate) failed: Option<Markup>,
    pub(crate) cost: Vec<Fact>,
    /// Works that describe the methods and theories used.
    pub(crate) cited: Vec<&'static str>,
    /// Warnings, and parts that could not be shown.
    pub remarks: Vec<String>,
}

/// Term and its description.
pub(crate) struct Fact(pub(crate) Markup, pub(crate) Markup);

impl Fact {
    /// Creates a fact from a term and a text of the file.
    pub(crate) fn new(term: &str, said: &str) -> Self {
        Self(html! { (term) }, html! { (text(said)) })
    }
}

/// Residual and its largest allowed value.
pub(crate) struct Certificate {
    pub(crate) name: String,
    pub(crate) largest: f64,
    pub(crate) allowed: f64,
}

/// Figure as an `svg` element.
pub(crate) struct Figure {
    title: String,
    svg: String,
    caption: Markup,
}

/// Table of a page.
pub(crate) struct Table {
    pub(crate) caption: Markup,
    pub(crate) head: Vec<Markup>,
    pub(crate) rows: Vec<Vec<Markup>>,
}

/// Largest number of rows of a table; a longer table is thinned.
const MOST_ROWS: usize = 100;

impl Page {
    /// Returns the number of figures.
    pub fn figures(&self) -> usize {
        self.figures.len()
    }

    /// Returns the figures as SVG with names made from their titles. A repeated name gets a number as suffix.
    pub fn into_figures(self) -> Vec<(String, String)> {
        let mut seen = BTreeMap::new();
        let named = |Figure { title, svg, .. }: Figure| {
            let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' };
            let name: String = title.chars().map(plain).collect();
            let count = seen.entry(name.clone()).and_modify(|count| *count += 1).or_insert(1);
            (if *count == 1 { name } else { format!("{name}-{count}") }, svg)
        };
        self.figures.into_iter().map(named).collect()
    }

    /// Adds the panels of a chart as separate figures, since a phone shows one per row. A panel that cannot be drawn
    /// becomes a remark.
    pub(crate) fn chart(&mut self, chart: &Chart, title: &str, caption: &Markup) {
        if chart.stacked {
            let narrow = Chart { width: COLUMN, ..chart.clone() };
            return self.figure(title, caption, |name| narrow.element(name, title));
        }
        for panel in &chart.panels {
            let single = Chart { height: chart.height.max(170.0), ..Chart::new(vec![panel.clone()]) };
            self.figure(title, caption, |name| single.element(name, title));
        }
    }

    /// Adds the figure of a field.
    pub(crate) fn field(&mut self, drawn: &Drawn, title: &str, caption: &Markup) {
        match drawn {
            Drawn::Chart(chart) => self.chart(chart, title, caption),
            Drawn::Map(map) => self.figure(title, caption, |name| map.element(name, title)),
        }
    }

    fn figure(&mut self, title: &str, caption: &Markup, draw: impl FnOnce(&str) -> Result<String, PlotError>) {
        let drawn = draw(&self.next_name());
        self.drawn(drawn, title, caption);
    }

    /// Returns the name of the next figure.
    pub(crate) fn next_name(&self) -> String {
        format!("figure{}", self.figures.len() + 1)
    }

    /// Adds a figure that was drawn under the next name.
    pub(crate) fn drawn(&mut self, drawn: Result<String, PlotError>, title: &str, caption: &Markup) {
        match drawn {
            Ok(svg) => self.figures.push(Figure { title: title.into(), svg, caption: caption.clone() }),
            Err(error) => self.remarks.push(format!("no figure of {title}: {error}")),
        }
    }

    /// Returns true if every residual is at most its allowed value; false for NaN.
    pub(crate) fn is_certified(&self) -> bool {
        !self.certificates.is_empty() && self.certificates.iter().all(|one| one.largest <= one.allowed)
    }
}

/// Sections common to the pages of all results.
pub(super) struct Common {
    pub(super) kicker: String,
    pub(super) dated: String,
    /// Text about the checksum of the result file; `None` for a page without certificates.
    pub(super) checksum: Option<&'static str>,
    pub(super) config: String,
    pub(super) cost: Vec<Fact>,
    pub(super) repeat: Markup,
    pub(super) own: Markup,
    pub(super) version: String,
}

/// HTML element that marks the pages of this program.
const MARK: &str = r#"<meta name="generator" content="gfmd report">"#;

/// Number of bytes at the start of a page that contain its mark.
const MARK_WITHIN: u64 = 1024;

/// Refuses to replace a file that is not a page of this program: by default the page has the name of the result, and a
/// user may have written another page under that name.
///
/// # Errors
/// Returns an error that names the `option` for a file that is another one, or cannot be read.
pub fn check_replaceable(option: &str, path: &Path) -> Result<(), Failure> {
    let mut start = Vec::new();
    match File::open(path).and_then(|file| file.take(MARK_WITHIN).read_to_end(&mut start)) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(Failure::input(key(option), format!("{}: {error}", path.display()))),
        Ok(_) if start.is_empty() || String::from_utf8_lossy(&start).contains(MARK) => return Ok(()),
        Ok(_) => {}
    }
    let reason = "the file exists and is no page that gfmd report made, which alone is replaced";
    Err(Failure::input(key(option), format!("{}: {reason}; it must be another name", path.display())))
}

/// Renders the page.
pub(super) fn render(page: &Page, common: &Common) -> Markup {
    // No script runs and nothing is fetched, even if a text of the file contains markup.
    let policy = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";
    let certified = page.is_certified() && page.failed.is_none();
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                (PreEscaped(MARK))
                meta http-equiv="Content-Security-Policy" content=(policy);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                title { (page.title) " · " (common.kicker) }
                style { (PreEscaped(include_str!("page/page.css"))) }
            }
            body {
                header {
                    p.kicker { (common.kicker) }
                    h1 { (page.title) }
                    p.dated { (common.dated) }
                }
                main {
                    @if let Some(failed) = &page.failed {
                        aside.failed role="alert" { h2 { "Not converged" } (failed) }
                    }
                    section #answer aria-labelledby="answer-h" {
                        h2 id="answer-h" { "Result" }
                        @for said in &page.answer { (said) }
                        p.seal {
                            @if common.checksum.is_some() {
                                @if certified { "Every residual is within its bound." }
                                @else { strong { "Not every residual is within its bound." } }
                                " " a href="#certificates" { "Certificates" }
                                @if !page.remarks.is_empty() { " · " }
                            }
                            @match page.remarks.len() {
                                0 => {}
                                1 => { a href="#remarks" { "1 warning" } }
                                count => { a href="#remarks" { (count) " warnings" } }
                            }
                        }
                    }
                    section #asked aria-labelledby="asked-h" {
                        h2 id="asked-h" { "Problem" }
                        (facts(&page.asked))
                    }
                    @if !page.figures.is_empty() {
                        section #figures aria-labelledby="figures-h" {
                            h2 id="figures-h" { "Figures" }
                            div.figures {
                                @for (index, figure) in page.figures.iter().enumerate() {
                                    figure {
                                        (PreEscaped(&figure.svg))
                                        figcaption { b { "Figure " (index + 1) ". " } (figure.caption) }
                                    }
                                }
                            }
                        }
                    }
                    @if !page.tables.is_empty() {
                        section #numbers aria-labelledby="numbers-h" {
                            h2 id="numbers-h" { "Numbers" }
                            @for one in &page.tables { (table(one)) }
                        }
                    }
                    @if let Some(checksum) = common.checksum {
                        section #certificates aria-labelledby="certificates-h" {
                            h2 id="certificates-h" { "Convergence and certificates" }
                            p {
                                "The residuals of the contact conditions are recomputed from the final fields. The \
                                 table "
                                "has the largest of the file. " (checksum)
                            }
                            (certificates(&page.certificates))
                        }
                    }
                    @if !page.remarks.is_empty() {
                        section #remarks aria-labelledby="remarks-h" {
                            h2 id="remarks-h" { "Warnings" }
                            ul { @for remark in &page.remarks { li { (text(remark)) } } }
                        }
                    }
                    @if !(page.cost.is_empty() && common.cost.is_empty()) {
                        section #cost aria-labelledby="cost-h" {
                            h2 id="cost-h" { "Cost" }
                            (facts(&page.cost))
                            (facts(&common.cost))
                        }
                    }
                    section #repeat aria-labelledby="repeat-h" {
                        h2 id="repeat-h" { "To repeat it" }
                        (common.repeat)
                        @if !common.config.is_empty() {
                            h3 { "Configuration" }
                            (block(&common.config, html! { (text(&common.config)) }))
                        }
                    }
                    section #cite aria-labelledby="cite-h" {
                        h2 id="cite-h" { "To cite" }
                        p { (common.own) }
                        @if !page.cited.is_empty() { ul { @for work in &page.cited { li { (work) } } } }
                    }
                }
                footer { p { (common.version) } }
            }
        }
    }
}

/// Longest text of an open block in characters, about a screen.
const OPEN: usize = 2500;

/// Renders a block of code, folded if `words` is long, e.g. for a table of hundreds of rows.
pub(crate) fn block(words: &str, code: Markup) -> Markup {
    let count = words.chars().count();
    let block = html! { pre tabindex="0" { code { (code) } } };
    if count <= OPEN {
        return block;
    }
    html! {
        details {
            summary { "Show all " (count) " characters" }
            (block)
        }
    }
}

fn facts(facts: &[Fact]) -> Markup {
    html! { @if !facts.is_empty() { dl { @for Fact(term, said) in facts { div { dt { (term) } dd { (said) } } } } } }
}

fn table(table: &Table) -> Markup {
    let step = table.rows.len().div_ceil(MOST_ROWS).max(1);
    let last = table.rows.len().saturating_sub(1);
    let shown = |row: usize| row.is_multiple_of(step) || row == last;
    html! {
        div.wide tabindex="0" role="region" aria-label="table" {
            table {
                caption {
                    span {
                        (table.caption)
                        @if step > 1 { " Every " (step) "th of " (table.rows.len()) " rows is shown, and the last." }
                    }
                }
                thead { tr { @for cell in &table.head { th scope="col" { (cell) } } } }
                tbody {
                    @for (_, row) in table.rows.iter().enumerate().filter(|(index, _)| shown(*index)) {
                        tr { @for cell in row { td { (cell) } } }
                    }
                }
            }
        }
        @if table.rows.iter().flatten().any(|cell| cell.0.ends_with('~')) {
            p.legend { (ROUGH) "." }
        }
    }
}

fn certificates(all: &[Certificate]) -> Markup {
    let word = |one: &Certificate| if one.largest <= one.allowed { "holds" } else { "does not hold" };
    let row = |one: &Certificate| {
        let class = if one.largest <= one.allowed { "holds" } else { "fails" };
        vec![
            html! { (one.name) },
            number(one.largest),
            given(one.allowed),
            html! { span class=(class) { (word(one)) } },
        ]
    };
    table(&Table {
        caption: html! {},
        head: ["residual", "largest", "at most", ""].map(|word| html! { (word) }).into(),
        rows: all.iter().map(row).collect(),
    })
}
