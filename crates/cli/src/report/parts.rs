//! The parts that pages about a contact and about a path have in common: surface, fields, failure.

use gfmd_files::Reader;
use gfmd_plot::{Axis, Chart, Panel, Series};
use maud::html;

use super::about::body;
use super::reading::StoredSurface;
use super::write::{given, text, whole};
use super::{Fact, Page};
use crate::convergence::StoredFailure;
use crate::figures::{field, pressure};

impl Page {
    /// Says which surface, body and law were asked for.
    pub(crate) fn asked(&mut self, surface: &Result<StoredSurface, String>, table: &toml::Table, law: &str) {
        match surface {
            Ok(surface) => {
                let ([nx, ny], [lx, ly]) = (surface.grid.points(), surface.grid.lengths());
                let unit = if surface.unit == "length" { "" } else { &surface.unit };
                self.asked.push(Fact::new("surface", &surface.description));
                self.asked.push(Fact(
                    html! { "grid" },
                    if surface.grid.is_line() {
                        html! { (nx) " points on a line of " (given(lx)) " " (unit) ", plane strain" }
                    } else {
                        html! { (nx) " × " (ny) " points on " (given(lx)) " × " (given(ly)) " " (unit) }
                    },
                ));
                self.asked.push(Fact(html! { "rms gradient" }, given(surface.rms_gradient)));
            }
            Err(reason) => self.remarks.push(format!("the surface is not shown: {reason}")),
        }
        self.asked.push(body(table));
        self.asked.push(Fact::new("interface", law));
    }

    /// Adds the maps of the pressure, over `modulus`, of state `index`, and of the heights.
    pub(crate) fn fields(
        &mut self,
        reader: &Reader,
        surface: &Result<StoredSurface, String>,
        name: &str,
        index: Option<usize>,
        modulus: f64,
    ) {
        let (Ok(surface), Some(index)) = (surface, index) else { return };
        match surface.field(reader, name, index, modulus) {
            Ok(values) => {
                let caption = html! { "Contact pressure over the modulus " i { "E" } "*, state " (index + 1) "." };
                self.field(&pressure(&surface.grid, &values, &surface.unit), "contact pressure", &caption);
            }
            Err(reason) => self.remarks.push(format!("no figure of the {name}: {reason}")),
        }
        let label = format!("height / {}", surface.unit);
        let drawn = field(&surface.grid, &surface.heights, &label, &surface.unit);
        self.field(
            &drawn,
            "heights of the surface",
            &html! { "Heights of the rough surface, peaks towards the body." },
        );
    }

    /// Says how a search failed, if the file says so; `part` is what the file counts.
    pub(crate) fn failure(&mut self, reader: &Reader, part: &str) {
        let Some(stored) = StoredFailure::read(reader) else { return };
        self.failed = Some(html! {
            p { (part) " " (whole(stored.part)) " (counted from 0): " (text(&stored.why)) ". Its numbers are no result." }
            ul { @for line in stored.criteria.lines() { li { (text(line)) } } }
            p { (text(&stored.advice)) }
        });
        let positive = stored.history.into_iter().filter(|(_, residual)| *residual > 0.0);
        let panel = Panel {
            x: Axis::linear("iterations"),
            y: Axis::log("residual"),
            series: vec![Series::line("", 0, positive)],
            ..Panel::default()
        };
        let caption = html! { "The residual of the search that did not converge." };
        self.chart(&Chart::new(vec![panel]), "residual against iterations", &caption);
    }
}
