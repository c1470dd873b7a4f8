//! Sections shared by the pages about a contact and about a path: surface, fields, failure.

use std::convert::Infallible;

use gfmd_contact::Hardness;
use gfmd_files::Reader;
use gfmd_plot::{Axis, Chart, Panel, Series};
use gfmd_record::{Form, Head, Subject, Table as RecordTable, heads, with_limit};
use maud::html;

use super::about::body;
use super::reading::{FaceFields, InUnit, Stored, StoredSurface};
use super::write::{given, number, powers, text, transforms, whole};
use super::{Certificate, Fact, Page, Table};
use crate::figures::{Face, FigureKind, Scene, heights, rough, sides};
use gfmd_run::convergence::NotConverged;

/// Returns true for a column that has a number and is not left out.
fn is_shown(form: Form, values: &[f64]) -> bool {
    values.iter().any(|value| value.is_finite() && (form != Form::SizeUnlessZero || *value != 0.0))
}

impl Page {
    /// Adds a condition with its largest residual.
    pub(crate) fn certificate(&mut self, name: &str, largest: f64, allowed: f64) {
        self.certificates.push(Certificate { name: name.into(), largest, allowed });
    }

    /// Adds the largest residual of all conditions of the states.
    pub(crate) fn residual(&mut self, stored: &Stored, tolerance: f64) {
        self.certificate("largest of all conditions", stored.worst("residual"), tolerance);
    }

    /// Adds the cost of all states.
    pub(crate) fn effort(&mut self, stored: &Stored) {
        self.cost.extend([
            Fact(html! { "transform pairs" }, transforms(stored.sum("transform_pairs"))),
            Fact(html! { "iterations" }, whole(stored.sum("iterations"))),
            Fact(html! { "time" }, html! { (number(stored.sum("seconds"))) " s" }),
        ]);
    }

    /// Adds the surface, body and law of the problem.
    pub(crate) fn asked(&mut self, surface: &Result<StoredSurface, String>, table: &toml::Table, law: &str) {
        match surface {
            Ok(surface) => {
                let ([nx, ny], [lx, ly]) = (surface.grid.points(), surface.grid.lengths());
                let read = sides(&surface.grid, &surface.unit);
                let (lx, ly) = (lx * read.factor, ly * read.factor);
                let unit = if surface.unit == "length" { "" } else { &read.name };
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
        let units = surface.as_ref().map(|surface| surface.units.clone()).unwrap_or_default();
        self.asked.push(body(table, &units));
        self.asked.push(Fact::new("interface", law));
    }

    /// Adds the figures of state `index`, named as in `state` and with pressures in the unit `modulus`, and the map of
    /// the heights.
    pub(crate) fn fields(
        &mut self,
        reader: &Reader,
        surface: &Result<StoredSurface, String>,
        (index, state, modulus): (Option<usize>, &str, f64),
        hardness: Option<&Hardness>,
    ) {
        let (Ok(surface), Some(index)) = (surface, index) else { return };
        self.face(reader, surface, (index, state, modulus), hardness, &FaceFields::UPPER);
        let caption = html! { "Heights of the rough surface, peaks towards the body." };
        heights(&surface.grid, &surface.heights, &surface.unit, |drawn| {
            self.field(drawn, "heights of the surface", &caption);
        });
    }

    /// Adds the figures of one face of the body in state `index`.
    pub(crate) fn face(
        &mut self,
        reader: &Reader,
        surface: &StoredSurface,
        (index, state, modulus): (usize, &str, f64),
        hardness: Option<&Hardness>,
        fields: &FaceFields,
    ) {
        let of = if fields.face == Face::Upper { "" } else { " on the lower face" };
        let shown = match surface.shown(reader, index, fields) {
            Ok(shown) if modulus > 0.0 => shown,
            Ok(_) => return self.remarks.push(format!("no figure of the pressure{of}: its unit is not known")),
            Err(reason) => return self.remarks.push(format!("no figure of the pressure{of}: {reason}")),
        };
        let scene = Scene {
            shown: &shown,
            grid: &surface.grid,
            unit: &surface.unit,
            stress: surface.units.stress(),
            modulus,
            hardness,
            rigid: rough(reader.text("/surface", "second_file").is_ok()),
            face: fields.face,
        };
        let state = html! { ", " (state) "." };
        let divided = html! { @if scene.is_divided() { " divided by the modulus " i { "E" } "*" } };
        let drawn = scene.figures(|kind, drawn| {
            let (title, caption) = match kind {
                FigureKind::Pressure => ("contact pressure", html! { "Contact pressure" (of) (divided) }),
                FigureKind::Traction => (
                    "repulsion and attraction",
                    html! { "Pressure" (of) (divided) ", repulsive (blue) and attractive (red)" },
                ),
                FigureKind::Gap => ("gap", html! { "Gap" (of) " on a logarithmic scale" }),
                FigureKind::Section => (
                    "section through both surfaces",
                    html! {
                        "Section along " i { "x" } " through the largest pressure" (of) ": both surfaces, heights in "
                        "their true distance and not to scale with " i { "x" } "; below, the pressure"
                    },
                ),
            };
            self.field(drawn, &format!("{title}{of}"), &html! { (caption) (state) });
            Ok::<_, Infallible>(())
        });
        drawn.unwrap_or_else(|never| match never {});
    }

    /// Adds tables of the first `rows` states, in readable units. Columns without a number are left out.
    pub(crate) fn numbers<S: Subject>(&mut self, stored: &Stored, rows: usize, state: &str) {
        let tables = [
            (RecordTable::State, ""),
            (RecordTable::Energy, ", energies per area"),
            (RecordTable::LowerFace, ", the lower face"),
            (RecordTable::Patches, ", patches and conductance"),
            (RecordTable::Flow, ", flow through the gap"),
            (RecordTable::Heat, ", flash temperature"),
        ];
        for (table, part) in tables {
            let columns = heads::<S>(table).map(|(column, head)| (column.name, head, stored.read(column, table)));
            let shown: Vec<_> = columns.filter(|(_, head, (values, _))| is_shown(head.form, &values[..rows])).collect();
            if !shown.iter().any(|(_, head, _)| head.table == table) {
                continue;
            }
            let cell = |(name, head, (values, unit)): &(&str, Head, InUnit), row: usize| match head.form {
                Form::Whole => whole(values[row]),
                Form::Unsure => powers(&with_limit(values[row], f64::NAN, f64::NAN)),
                Form::Flag => html! { (if values[row] == 0.0 { "no" } else { "yes" }) },
                _ if stored.has(&format!("{name}_limit")) => {
                    let factor = unit.as_ref().map_or(1.0, |unit| unit.factor);
                    let [limit, error] =
                        ["limit", "limit_error"].map(|of| factor * stored.column(&format!("{name}_{of}"))[row]);
                    powers(&with_limit(values[row], limit, error))
                }
                _ => number(values[row]),
            };
            let head = |(name, head, (_, unit)): &(&str, Head, InUnit)| {
                let unit = unit.as_ref().map_or_else(|| stored.unit(name), |unit| unit.name.clone());
                html! { span title=(stored.definition(name)) { (head.word) } br; small { (unit) } }
            };
            self.tables.push(Table {
                caption: html! { "The " (state) "s" (part) "." },
                head: [html! { (state) }].into_iter().chain(shown.iter().map(head)).collect(),
                rows: (0..rows)
                    .map(|row| {
                        [whole(row as f64)].into_iter().chain(shown.iter().map(|column| cell(column, row))).collect()
                    })
                    .collect(),
            });
        }
    }

    /// Adds the failure of a search, if the file has one; `part` is the name of the counted part.
    pub(crate) fn failure(&mut self, reader: &Reader, part: &str) {
        let Some(stored) = NotConverged::read(reader) else { return };
        self.failed = Some(html! {
            p {
                (part) " " (stored.part) " (counted from 0): " (text(&stored.why)) ". Its numbers are no result."
            }
            ul { @for criterion in &stored.criteria { li { (text(&criterion.to_string())) } } }
            p { (text(&stored.advice)) }
        });
        let samples = stored.history.samples().map(|(iteration, residual)| (iteration as f64, residual));
        let positive = samples.filter(|(_, residual)| *residual > 0.0);
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
