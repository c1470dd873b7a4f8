//! Legend: each label once, with the marks of all its series, and the reference lines beyond their axes.

use std::cmp::Ordering;
use std::fmt::Write;

use super::axis::short;
use super::colour::{INK, REFERENCE, Rgb, hex, hue};
use super::frame::{EDGE, GAP, TICK};
use super::symbol::{PALE_AREA, SYMBOL, line_width, symbol};
use super::text::{Anchor, Text, number};
use super::{Mark, Panel, Series, Side};

const SAMPLE: f64 = 16.0;

/// Label of the legend, with the marks of all its series by colour. A reference line beyond the axis has no mark.
pub(super) struct Entry {
    text: Text,
    colour: Rgb,
    samples: Vec<Vec<Series>>,
}

impl Entry {
    fn width(&self) -> f64 {
        self.samples.iter().map(|samples| sample_width(samples)).sum::<f64>() + GAP + self.text.width()
    }
}

fn sample_width(samples: &[Series]) -> f64 {
    let symbols = samples.iter().all(|sample| matches!(sample.mark, Mark::Points | Mark::HollowPoints));
    if symbols { 4.0 * SYMBOL } else { SAMPLE }
}

/// Returns the entries of panels with their `ranges` of x and y.
pub(super) fn legend(panels: &[Panel], ranges: &[[[f64; 2]; 2]]) -> Vec<Entry> {
    let mut entries: Vec<(&str, Entry)> = Vec::new();
    for series in panels.iter().flat_map(|panel| &panel.series).filter(|series| !series.label.is_empty()) {
        let sample = Series { points: Vec::new(), ..series.clone() };
        let position = entries.iter().position(|(label, _)| *label == series.label).unwrap_or(entries.len());
        if position == entries.len() {
            let text = Text::new(&series.label, TICK);
            entries.push((&series.label, Entry { text, colour: INK, samples: Vec::new() }));
        }
        let samples = &mut entries[position].1.samples;
        match samples.iter_mut().find(|group| group[0].hue == sample.hue) {
            Some(group) if group.contains(&sample) => {}
            Some(group) => group.push(sample),
            None => samples.push(vec![sample]),
        }
    }
    let beyond = beyond(panels, ranges).into_iter();
    let beyond = beyond.map(|name| Entry { text: Text::new(&name, TICK), colour: REFERENCE, samples: Vec::new() });
    entries.into_iter().map(|(_, entry)| entry).chain(beyond).collect()
}

/// Returns the names of the reference lines beyond their axes, each once, with an arrow and the value.
fn beyond(panels: &[Panel], ranges: &[[[f64; 2]; 2]]) -> Vec<String> {
    let mut names = Vec::new();
    for (panel, [_, range]) in panels.iter().zip(ranges) {
        for level in panel.levels.iter().filter(|level| !level.label.is_empty()) {
            let arrow = match level.place(*range) {
                Ordering::Less => '↓',
                Ordering::Equal => continue,
                Ordering::Greater => '↑',
            };
            let name = format!("{arrow} {} = {}", level.label, short(level.middle()));
            if !names.contains(&name) {
                names.push(name);
            }
        }
    }
    names
}

/// Arranges entries in rows that fit into `width`; returns the rows and their total height.
pub(super) fn arrange(entries: &[Entry], width: f64) -> (Vec<Vec<&Entry>>, f64) {
    let mut rows: Vec<Vec<&Entry>> = Vec::new();
    let mut used = f64::INFINITY;
    for entry in entries {
        let needed = entry.width() + 4.0 * GAP;
        if used + needed > width {
            rows.push(Vec::new());
            used = 0.0;
        }
        if let Some(row) = rows.last_mut() {
            row.push(entry);
        }
        used += needed;
    }
    let height = rows.len() as f64 * 1.4 * TICK + if rows.is_empty() { 0.0 } else { GAP };
    (rows, height)
}

pub(super) fn draw_legend(svg: &mut String, rows: &[Vec<&Entry>], width: f64) {
    for (i, row) in rows.iter().enumerate() {
        let total: f64 = row.iter().map(|entry| entry.width()).sum::<f64>() + 4.0 * GAP * (row.len() - 1) as f64;
        let mut left = 0.5 * (width - total);
        let y = EDGE + (i as f64 + 0.5) * 1.4 * TICK;
        for entry in row {
            let mut at = left;
            for group in &entry.samples {
                let width = sample_width(group);
                group.iter().for_each(|sample| draw_sample(svg, sample, [at, at + width], y));
                at += width;
            }
            entry.text.write(svg, at + GAP, y + 0.35 * TICK, Anchor::Start, 0.0, &hex(entry.colour));
            left += entry.width() + 4.0 * GAP;
        }
    }
}

fn draw_sample(svg: &mut String, series: &Series, ends: [f64; 2], y: f64) {
    let colour = hex(hue(series.hue));
    let dashes = if series.mark == Mark::Dashes { r#" stroke-dasharray="5 2.5""# } else { "" };
    if let Mark::Filled(side) = series.mark {
        let half = 0.5 * TICK;
        let top = if side == Side::Top { y - half } else { y };
        let [x, top, wide, tall] = [ends[0], top, ends[1] - ends[0], half].map(number);
        let _ = writeln!(
            svg,
            r#"<rect x="{x}" y="{top}" width="{wide}" height="{tall}" fill="{colour}" opacity="{PALE_AREA}"/>"#
        );
    }
    if let Some(width) = line_width(series.mark) {
        let [x0, x1, y] = [ends[0], ends[1], y].map(number);
        let _ =
            writeln!(svg, r#"<path d="M{x0} {y}H{x1}" stroke="{colour}" stroke-width="{width}"{dashes} fill="none"/>"#);
    }
    let symbol = symbol(series.hue, (0.5 * (ends[0] + ends[1]), y));
    match series.mark {
        Mark::Points | Mark::JoinedPoints => {
            let _ = writeln!(svg, r##"<path d="{symbol}" fill="{colour}" stroke="#ffffff" stroke-width="0.4"/>"##);
        }
        Mark::HollowPoints => {
            let _ = writeln!(svg, r##"<path d="{symbol}" fill="#ffffff" stroke="{colour}" stroke-width="1"/>"##);
        }
        Mark::Line | Mark::Dashes | Mark::Bold | Mark::Filled(_) => {}
    }
}
