//! B-splines that spread point values to a coarse grid and interpolate fields from it (Essmann et al. 1995).

use std::array::from_fn;
use std::ops::Range;

use multiversion::multiversion;
use rayon::prelude::*;

use super::sources::{Source, Sources};
use super::window::Window;
use super::{Blocks, COARSENING, LANES, ROWS};

/// Number of coarse points per direction to which a point spreads; the degree of the B-spline is one less.
pub(super) const ORDER: usize = 8;

/// Number of coarse points along a row to which a block spreads, and the same number padded to whole vectors.
const SPREAD: usize = ORDER + LANES / COARSENING - 1;
const PADDED: usize = SPREAD.next_multiple_of(LANES);

/// Number of coarse points before the first point of a row to which its first block spreads.
pub(super) const BEFORE: usize = ORDER / 2 - 1;

/// Splines between the points of blocks and a coarse grid. Values along rows are stored in lines: rows of the coarse
/// grid, extended at both ends as far as blocks spread.
#[derive(Debug)]
pub(super) struct Splines {
    /// Numbers of coarse points.
    points: [usize; 2],
    /// Weights of the coarse points around a point, for each position between two coarse points.
    weights: [[f32; ORDER]; COARSENING],
    /// Weights between the lanes of a block and the coarse points around it, in both directions.
    given: [[f32; PADDED]; LANES],
    taken: [[f32; LANES]; SPREAD],
}

/// Contributions of the sources of every row to the coarse points of a line.
#[derive(Debug, Default)]
pub(super) struct Lines {
    values: Vec<f32>,
    /// False for rows without sources, with stale values.
    filled: Vec<bool>,
}

impl Splines {
    /// Creates the splines for a coarse grid with these numbers of points.
    pub(super) fn new(points: [usize; 2]) -> Self {
        let weights: [[f32; ORDER]; COARSENING] =
            from_fn(|place| spline(place as f64 / COARSENING as f64).map(|weight| weight as f32));
        let weight = |lane: usize, k: usize| {
            let k = k.checked_sub(lane / COARSENING);
            k.and_then(|k| weights[lane % COARSENING].get(k).copied()).unwrap_or(0.0)
        };
        Self {
            points,
            weights,
            given: from_fn(|lane| from_fn(|k| weight(lane, k))),
            taken: from_fn(|k| from_fn(|lane| weight(lane, k))),
        }
    }

    /// Returns the length of a line: a row of the coarse grid, extended at both ends as far as blocks spread.
    pub(super) fn line(&self) -> usize {
        self.points[1] + PADDED - LANES / COARSENING
    }

    /// Fills the lines with the contributions of the sources in every row of points of a window.
    pub(super) fn spread(&self, blocks: &Blocks, sources: &Sources, window: Window, lines: &mut Lines) {
        let Lines { values, filled } = lines;
        values.resize(self.line() * window.len(), 0.0);
        filled.resize(window.len(), false);
        let rows = values.par_chunks_exact_mut(self.line()).zip(filled).with_min_len(ROWS);
        rows.enumerate().for_each(|(place, (line, filled))| {
            let sources = sources.in_row(blocks, window.row(place));
            *filled = !sources.is_empty();
            if *filled {
                to_line(&self.given, sources, line, self.points[1]);
            }
        });
    }

    /// Fills a row of the coarse grid with the contributions of the lines around it, from the lines of a window.
    pub(super) fn gather(&self, (lines, window): (&Lines, Window), row: usize, values: &mut [f32]) {
        values.fill(0.0);
        let [rows, columns] = self.points;
        for k in 0..ORDER {
            let from = window.place((row + rows + BEFORE - k) % rows * COARSENING);
            let is_filled = |within: usize| lines.filled[from + within];
            let Some(filled) = (0..COARSENING).find(|within| is_filled(*within)) else { continue };
            let weights = from_fn(|within| if is_filled(within) { self.weights[within][k] } else { 0.0 });
            let lines: [&[f32]; COARSENING] = from_fn(|within| {
                let line = from + if is_filled(within) { within } else { filled };
                &lines.values[line * self.line() + BEFORE..][..columns]
            });
            add_all(values, &weights, lines);
        }
    }

    /// Interpolates `out` at the points of the blocks in these rows, from the lines of a field on the coarse grid in a
    /// window of its rows.
    pub(super) fn interpolate(&self, blocks: &Blocks, rows: Range<usize>, field: (&[f32], Window), out: &mut [f32]) {
        blocks.for_rows(rows, LANES, out, &|rows, out| {
            let mut line = vec![0.0; self.line()];
            for (row, of_row, out) in blocks.by_row(rows, LANES, out) {
                if !of_row.is_empty() {
                    self.blend(field, row, &mut line);
                    from_line(&self.taken, &line, (blocks, of_row), out);
                }
            }
        });
    }

    /// Fills a line with the interpolation of the lines around a row of points.
    fn blend(&self, (lines, window): (&[f32], Window), row: usize, line: &mut [f32]) {
        line.fill(0.0);
        let (rows, length) = (self.points[0], line.len());
        let around: [&[f32]; ORDER] = from_fn(|k| {
            let from = window.place((row / COARSENING + rows + k - BEFORE) % rows);
            &lines[from * length..(from + 1) * length]
        });
        add_all(line, &self.weights[row % COARSENING], around);
    }
}

/// Copies `row` to `line` and continues it periodically beyond its ends.
pub(super) fn repeat(row: &[f32], line: &mut [f32]) {
    let columns = row.len();
    line[BEFORE..BEFORE + columns].copy_from_slice(row);
    line.copy_within(columns..columns + BEFORE, 0);
    for i in BEFORE + columns..line.len() {
        line[i] = line[i - columns];
    }
}

/// Adds the values of a line beyond the ends of its row of `columns` points to the points of the row; the transpose of
/// [`repeat`].
fn fold(line: &mut [f32], columns: usize) {
    for i in (BEFORE + columns..line.len()).rev() {
        line[i - columns] += line[i];
    }
    for i in 0..BEFORE {
        line[i + columns] += line[i];
    }
}

/// Adds Σ weight row to `sum`, for rows of its length.
#[multiversion(targets = "simd")]
fn add_all<const K: usize>(sum: &mut [f32], weights: &[f32; K], rows: [&[f32]; K]) {
    let rows = rows.map(|row| &row[..sum.len()]);
    for (i, sum) in sum.iter_mut().enumerate() {
        let terms = (0..K).map(|k| weights[k] * rows[k][i]);
        *sum = terms.fold(*sum, |sum, term| sum + term);
    }
}

/// Fills `line` with the contributions of the sources of a row to its `columns` coarse points.
#[multiversion(targets = "simd")]
fn to_line(given: &[[f32; PADDED]; LANES], sources: &[Source], line: &mut [f32], columns: usize) {
    line.fill(0.0);
    for source in sources {
        let place = source.column() * (LANES / COARSENING);
        let line: &mut [f32; PADDED] = line[place..].first_chunk_mut().expect("blocks of a row");
        let mut sums = *line;
        for (value, given) in source.values().into_iter().zip(given) {
            sums.iter_mut().zip(given).for_each(|(sum, given)| *sum += value * given);
        }
        *line = sums;
    }
    fold(line, columns);
}

/// Interpolates `out` at these blocks of a row from the coarse points of its line.
#[multiversion(targets = "simd")]
fn from_line(taken: &[[f32; LANES]; SPREAD], line: &[f32], (blocks, of_row): (&Blocks, Range<usize>), out: &mut [f32]) {
    for (block, out) in of_row.zip(out.as_chunks_mut::<LANES>().0) {
        let place = blocks.column(block) * (LANES / COARSENING);
        let line: &[f32; SPREAD] = line[place..].first_chunk().expect("blocks of a row");
        *out = [0.0; LANES];
        for (value, taken) in line.iter().zip(taken) {
            out.iter_mut().zip(taken).for_each(|(out, taken)| *out += value * taken);
        }
    }
}

/// Returns the values at `place`, between 0 and 1, of the B-splines of [`ORDER`] centred at each of the points from
/// `1 − ORDER/2` to `ORDER/2`.
fn spline(place: f64) -> [f64; ORDER] {
    // De Boor recurrence for equidistant knots.
    let mut values = [0.0; ORDER];
    values[0] = 1.0;
    for degree in 1..ORDER {
        for k in (0..=degree).rev() {
            let [own, before] = [values[k], if k > 0 { values[k - 1] } else { 0.0 }];
            let behind = (degree - k) as f64;
            values[k] = ((place + behind) * before + (1.0 - place + k as f64) * own) / degree as f64;
        }
    }
    values
}
