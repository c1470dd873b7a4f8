//! The response of a body between few points of its grid.

mod blocks;
mod near_part;
mod sources;
mod stencil;

use std::array::from_fn;
use std::f64::consts::{PI, TAU};
use std::ops::Range;

use gfmd_field::{Grid, Mode, Rows, Transform, Workspace};
use multiversion::multiversion;
use rayon::prelude::*;

pub use blocks::Blocks;
use near_part::near_part;
use sources::{Source, Sources};
use stencil::Stencil;

use crate::NormalResponse;
use crate::elastic::fits;
use crate::units::power_of_two;

/// Compliance between few points of a periodic grid, in single precision, and what makes up an approximate stiffness: for contacts so
/// small that transforms of the whole surface would mostly move zeros.
///
/// The compliance is split as Ewald (1921) split Coulomb's sum. With g that of `G = g/q` for the shortest waves, the part
/// `g (1 − Φ(r))/(2π r)` vanishes beyond a radius of some points, and is summed over pairs of points. The rest, `g Φ(r)/(2π r)` on a
/// half-space, has hardly any short waves: it is computed on a grid of four times the spacing, to which pressures are spread, and from
/// which displacements are interpolated, by B-splines (Essmann et al. 1995). Φ is the integral of a window of Kaiser and Bessel, which
/// separates short distances from long waves better than Ewald's error function. Images are accurate to 4e-4 of the largest ones.
///
/// The points come in [`Blocks`] of [`LANES`] neighbours in a row.
#[derive(Debug)]
pub struct Scattered {
    coarse: Transform<f32>,
    /// The compliance of long waves on the coarse grid, over the unit.
    smooth: Vec<f32>,
    /// The stiffness of waves that are interpolated from the coarse grid, times the unit.
    stiffness: Vec<f32>,
    /// The compliance of short waves between two points, over the unit.
    near: Stencil<NEAR>,
    /// The stiffness between two points times the unit, cut off at a short distance.
    stiff: Stencil<NEXT>,
    /// What a point at each of the places between two coarse points gives to those around it.
    weights: [[f32; ORDER]; COARSENING],
    /// The same for the lanes of a block and the coarse points around it: what a lane gives to them, and what each gives to the lanes.
    given: [[f32; PADDED]; LANES],
    taken: [[f32; LANES]; SPREAD],
    unit: f64,
}

/// The number of rows of points that are worked on together.
const ROWS: usize = 16;

/// The number of neighbouring points in a block.
pub const LANES: usize = 8;

/// The spacing of the coarse grid of [`Scattered`], in points.
pub const COARSENING: usize = 4;

/// The number of coarse points in a direction to which a point spreads: a B-spline of degree one less.
const ORDER: usize = 8;

/// The number of coarse points along a row to which a block spreads, and the same with some to which it gives nothing: whole vectors.
const SPREAD: usize = ORDER + LANES / COARSENING - 1;
const PADDED: usize = SPREAD.next_multiple_of(LANES);

/// The number of coarse points before the first one of a row to which its first block spreads.
const BEFORE: usize = ORDER / 2 - 1;

/// The distance in points at which the short waves have decayed but for those that the grid cuts off: these go on as ripples along the
/// axes, and are summed up to a longer distance.
const RADIUS: f64 = 10.0;
const REACH: usize = 16;

/// The number of blocks of a row with points at that distance.
const NEAR: usize = 2 * REACH.div_ceil(LANES) + 1;

/// The distance in points up to which points stiffen each other.
const STIFF: usize = 6;

/// The number of blocks of a row with points at that distance.
const NEXT: usize = 2 * STIFF.div_ceil(LANES) + 1;

/// The largest relative difference from a half-space, of the shortest waves of the coarse grid.
const DEEP: f64 = 1e-3;

/// The least number of points of a cell in which the response to a point has decayed.
const BOX: usize = 2 * REACH + LANES;

impl Scattered {
    /// Splits the response, with the given compliance and stiffness of the uniform mode, in length/stress and stress/length. `None` if the grid is no rectangle of
    /// whole blocks and coarse cells, or small, and on layers that are not thicker than a few points.
    pub fn of(response: &NormalResponse, [compliance, stiffness]: [f64; 2]) -> Option<Self> {
        let grid = response.grid();
        let [nx, ny] = grid.points();
        let small = [nx, ny].map(|points| (BOX..=points / 2).find(|side| points.is_multiple_of(*side)));
        let [Some(rows), Some(columns)] = small else { return None };
        let [wide, narrow] = [f64::max, f64::min].map(|pick| {
            let [x, y] = grid.spacing();
            pick(x, y)
        });
        // Beyond, the reach would be too short along an axis, or have too many points along the other one.
        if !nx.is_multiple_of(COARSENING) || !ny.is_multiple_of(LANES) || wide > 1.5 * narrow {
            return None;
        }
        let coarse = Grid::new([nx / COARSENING, ny / COARSENING], grid.lengths()).ok()?;
        // Short waves see a half-space: their compliance times wavenumber does not depend on the wavelength.
        let slope = |x: usize, y: usize| {
            let number = [x, y].map(|number| -(number as i64));
            let q = [0, 1].map(|axis| TAU * number[axis] as f64 / grid.lengths()[axis]);
            q[0].hypot(q[1]) * compliance_of(response, number)
        };
        let [rows_of, columns_of] = coarse.points();
        let shortest = slope(nx / 2, ny / 2);
        let is_deep = |slope: f64| (slope / shortest - 1.0).abs() < DEEP;
        if !(is_deep(slope(rows_of / 2, 0)) && is_deep(slope(0, columns_of / 2))) {
            return None;
        }
        let unit = power_of_two(1.0 / response.stiffness_range()[0]);
        let radius = RADIUS * (wide * narrow).sqrt();
        let short = |q: f64| shortest * radius * near_part(q * radius);
        let cell = [rows, columns];
        let near = Stencil::new(response, cell, (REACH, radius), |q, _| short(q) / unit).ok()?;
        let inverse = |_, g: f64| if g > 0.0 { unit / g } else { 0.0 };
        let stiff = Stencil::new(response, cell, (STIFF, f64::INFINITY), inverse).ok()?;
        let table = |of: &(dyn Fn(Mode, f64) -> f64 + Sync)| long_waves(grid, &coarse, of);
        let smooth = table(&|mode, splines| {
            let all = if mode.is_uniform() { compliance } else { compliance_of(response, mode.number) };
            (all - short(mode.wavenumber())) / (splines * unit)
        });
        let stiffness = table(&|mode, splines| {
            let all = if mode.is_uniform() { stiffness } else { 1.0 / compliance_of(response, mode.number) };
            all * splines * unit
        });
        let weights: [[f32; ORDER]; COARSENING] =
            from_fn(|place| spline(place as f64 / COARSENING as f64).map(|weight| weight as f32));
        let weight = |lane: usize, k: usize| {
            let k = k.checked_sub(lane / COARSENING);
            k.and_then(|k| weights[lane % COARSENING].get(k).copied()).unwrap_or(0.0)
        };
        Some(Self {
            coarse: Transform::new(coarse),
            smooth,
            stiffness,
            near,
            stiff,
            weights,
            given: from_fn(|lane| from_fn(|k| weight(lane, k))),
            taken: from_fn(|k| from_fn(|lane| weight(lane, k))),
            unit,
        })
    }

    /// The unit of compliances, a power of two, in length/stress.
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// The coarse grid.
    pub fn coarse(&self) -> &Grid {
        self.coarse.grid()
    }

    /// A transform pair on the coarse grid, in pairs on the whole one: [`compliance`](Self::compliance) and [`stiffen`](Self::stiffen) take
    /// one each.
    pub fn effort(&self) -> f64 {
        1.0 / (COARSENING * COARSENING) as f64
    }

    /// Memory for images of pressures on the coarse grid.
    pub fn memory(&self) -> ScatteredMemory {
        ScatteredMemory {
            workspace: self.coarse.workspace(),
            far: Vec::new(),
            lines: Lines::default(),
            sources: Sources::default(),
        }
    }

    /// `out` ← G `pressure` over the unit. Both have a value for each point of the blocks; the pressure elsewhere is zero.
    pub fn compliance(&self, blocks: &Blocks, pressure: &[f32], memory: &mut ScatteredMemory, out: &mut [f32]) {
        let ScatteredMemory { workspace, far, lines, sources } = memory;
        self.spread(blocks, pressure, sources, lines);
        let lines = &*lines;
        far.resize(self.coarse.grid().points()[0] * self.line(), 0.0);
        let source = |row: usize, (): (), values: &mut [f32]| self.gather(lines, row, values);
        let copy = |_: usize, row: &mut [f32], Rows(line, _): Rows<&mut [f32]>| repeat(row, line);
        let far_lines = Rows(&mut far[..], self.line());
        fits(self.coarse.convolve_rows(&self.smooth, (), source, far_lines, copy, workspace));
        self.interpolate_lines(blocks, far, out);
        sources.add(&self.near, blocks, out);
    }

    /// `out` ← S `gap` times the unit, with the stiffness S of a surface that is held between the points and beyond a few of them.
    /// S is positive definite.
    pub fn stiffness(&self, blocks: &Blocks, gap: &[f32], memory: &mut ScatteredMemory, out: &mut [f32]) {
        memory.sources.take(blocks, gap);
        out.fill(0.0);
        memory.sources.add(&self.stiff, blocks, out);
    }

    /// `out` ← I `field`: what is interpolated at the points from a field on the coarse grid.
    pub fn interpolate(&self, blocks: &Blocks, field: &[f32], memory: &mut ScatteredMemory, out: &mut [f32]) {
        memory.far.resize(self.coarse.grid().points()[0] * self.line(), 0.0);
        let rows = field.par_chunks_exact(self.coarse.grid().points()[1]);
        rows.zip(memory.far.par_chunks_exact_mut(self.line())).for_each(|(row, line)| repeat(row, line));
        self.interpolate_lines(blocks, &memory.far, out);
    }

    /// As [`interpolate`](Self::interpolate), from the lines of a field.
    fn interpolate_lines(&self, blocks: &Blocks, field: &[f32], out: &mut [f32]) {
        blocks.for_rows(LANES, out, &|rows, out| {
            let mut line = vec![0.0; self.line()];
            for (row, of_row, out) in blocks.by_row(rows, LANES, out) {
                if !of_row.is_empty() {
                    self.blend(field, row, &mut line);
                    from_line(&self.taken, &line, (blocks, of_row), out);
                }
            }
        });
    }

    /// `field` ← Iᵀ (K I `field` times the unit − `pressure`), with the stiffness K of the body and the transpose of
    /// [`interpolate`](Self::interpolate). K I has the waves of the coarse grid only.
    pub fn stiffen(&self, blocks: &Blocks, field: &mut [f32], pressure: &[f32], memory: &mut ScatteredMemory) {
        let ScatteredMemory { workspace, lines, sources, .. } = memory;
        self.spread(blocks, pressure, sources, lines);
        let (lines, columns) = (&*lines, self.coarse.grid().points()[1]);
        let source = |_: usize, Rows(field, _): Rows<&[f32]>, values: &mut [f32]| values.copy_from_slice(field);
        let less = |row: usize, values: &mut [f32], Rows(out, _): Rows<&mut [f32]>| {
            self.gather(lines, row, out);
            out.iter_mut().zip(values).for_each(|(out, value)| *out = *value - *out);
        };
        fits(self.coarse.convolve_ahead(&self.stiffness, Rows(&*field, columns), source, workspace));
        fits(self.coarse.convolve_back(Rows(field, columns), less, workspace));
    }

    /// The length of a line: a row of the coarse grid, and what lies beyond its ends as far as blocks spread.
    fn line(&self) -> usize {
        self.coarse.grid().points()[1] + PADDED - LANES / COARSENING
    }

    /// The sources with these values, and what those of every row give to the coarse points of a line.
    fn spread(&self, blocks: &Blocks, values: &[f32], sources: &mut Sources, lines: &mut Lines) {
        sources.take(blocks, values);
        let Lines { values, filled } = lines;
        values.resize(self.line() * blocks.rows(), 0.0);
        filled.resize(blocks.rows(), false);
        let rows = values.par_chunks_exact_mut(self.line()).zip(filled).with_min_len(ROWS);
        rows.enumerate().for_each(|(row, (line, filled))| {
            let sources = sources.in_row(blocks, row);
            *filled = !sources.is_empty();
            if *filled {
                to_line(&self.given, sources, line, self.coarse.grid().points()[1]);
            }
        });
    }

    /// Fills a row of the coarse grid with what the lines around it give.
    fn gather(&self, lines: &Lines, row: usize, values: &mut [f32]) {
        values.fill(0.0);
        let [rows, columns] = self.coarse.grid().points();
        for k in 0..ORDER {
            let from = (row + rows + BEFORE - k) % rows * COARSENING;
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

    /// Fills a line with what the lines around a row of points give.
    fn blend(&self, lines: &[f32], row: usize, line: &mut [f32]) {
        line.fill(0.0);
        let (rows, length) = (self.coarse.grid().points()[0], line.len());
        let around: [&[f32]; ORDER] = from_fn(|k| {
            let from = (row / COARSENING + rows + k - BEFORE) % rows;
            &lines[from * length..(from + 1) * length]
        });
        add_all(line, &self.weights[row % COARSENING], around);
    }
}

/// `line` ← `row`, continued periodically beyond its ends.
fn repeat(row: &[f32], line: &mut [f32]) {
    let columns = row.len();
    line[BEFORE..BEFORE + columns].copy_from_slice(row);
    line.copy_within(columns..columns + BEFORE, 0);
    for i in BEFORE + columns..line.len() {
        line[i] = line[i - columns];
    }
}

/// Adds what a line has beyond the ends of its row of so many `columns` to the points of the row: the transpose of [`repeat`].
fn fold(line: &mut [f32], columns: usize) {
    for i in (BEFORE + columns..line.len()).rev() {
        line[i - columns] += line[i];
    }
    for i in 0..BEFORE {
        line[i + columns] += line[i];
    }
}

/// `sum` ← `sum` + Σ weight row, for rows of its length.
#[multiversion(targets = "simd")]
fn add_all<const K: usize>(sum: &mut [f32], weights: &[f32; K], rows: [&[f32]; K]) {
    let rows = rows.map(|row| &row[..sum.len()]);
    for (i, sum) in sum.iter_mut().enumerate() {
        let terms = (0..K).map(|k| weights[k] * rows[k][i]);
        *sum = terms.fold(*sum, |sum, term| sum + term);
    }
}

/// `line` ← what the sources of a row give to its so many coarse points.
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

/// `out` ← what these blocks of a row take from the coarse points of its line.
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

/// Working memory of a [`Scattered`] response.
#[derive(Debug)]
pub struct ScatteredMemory {
    workspace: Workspace<f32>,
    /// The lines of a field on the coarse grid, such as the displacement by long waves.
    far: Vec<f32>,
    lines: Lines,
    sources: Sources,
}

impl ScatteredMemory {
    /// Frees what does not need to be kept until the next image.
    pub fn release(&mut self) {
        (self.far, self.lines, self.sources) = Default::default();
    }
}

/// What the sources of every row give to the coarse points of a line.
#[derive(Debug, Default)]
struct Lines {
    values: Vec<f32>,
    /// False for rows without sources, whose values are stale.
    filled: Vec<bool>,
}

/// A table of the modes of the coarse grid with q_x ≥ 0, in which it is even. `of` gets the mode and the square of the part of it that
/// interpolation by splines leaves, times the number of points for each coarse one.
fn long_waves(grid: &Grid, coarse: &Grid, of: &(dyn Fn(Mode, f64) -> f64 + Sync)) -> Vec<f32> {
    let points = grid.len() as f64 / coarse.len() as f64;
    // The transforms of the splines along each axis, squared.
    let [across, along] = [0, 1].map(|axis| {
        let points = coarse.points()[axis];
        let sinc = |number: usize| {
            let half = PI * number as f64 / points as f64;
            if number == 0 { 1.0 } else { half.sin() / half }
        };
        (0..=points / 2).map(|number| sinc(number).powi(2 * ORDER as i32)).collect::<Vec<_>>()
    });
    let value = |y: usize, x: usize| of(coarse.mode(y, x), points * across[x] * along[y]) as f32;
    let modes = (0..along.len() * across.len()).into_par_iter();
    modes.map(|index| value(index / across.len(), index % across.len())).collect()
}

/// The compliance of the mode with these numbers, or of the opposite one.
fn compliance_of(response: &NormalResponse, number: [i64; 2]) -> f64 {
    let grid = response.grid();
    let index = grid.index_of(number).or_else(|| grid.index_of(number.map(|number| -number)));
    index.map_or(0.0, |index| response.compliance_at(index))
}

/// The values of the B-spline of [`ORDER`] centred at each of the points from `1 − ORDER/2` to `ORDER/2`, at `place` between 0 and 1.
fn spline(place: f64) -> [f64; ORDER] {
    // De Boor's recurrence for equidistant knots.
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

#[cfg(test)]
mod tests {
    use gfmd_green::{Body, Material};

    use super::*;

    fn response(points: [usize; 2], lengths: [f64; 2], height: Option<f64>) -> NormalResponse {
        let material = Material::from_contact_modulus(2.0, 0.3).unwrap();
        let body = height.map_or_else(|| Body::half_space(material), |height| Body::slab(material, height).unwrap());
        NormalResponse::new(Grid::new(points, lengths).unwrap(), &body)
    }

    /// Every seventh block, and some that are neighbours, among them those at the edges.
    fn places(grid: &Grid) -> Vec<usize> {
        let all = grid.len() / LANES;
        (0..all).filter(|place| place % 7 == 0 || place % 97 < 9 || *place < 20 || place + 20 > all).collect()
    }

    #[test]
    fn images_are_those_of_transforms_of_the_whole_surface() {
        for (points, lengths, height) in [
            ([128, 128], [1.0, 1.0], None),
            ([120, 232], [1.0, 2.0], None),
            ([256, 128], [2.2, 1.0], Some(0.1)),
            ([128, 128], [1.0, 1.0], Some(0.15)),
        ] {
            let response = response(points, lengths, height);
            let (grid, uniform) = (*response.grid(), response.uniform_compliance());
            let scattered = Scattered::of(&response, [uniform, 0.0]).unwrap();
            let blocks = Blocks::new(&grid, places(&grid));
            let noise = |i: usize| ((i as f64 + 1.0) * 0.618_034).fract();
            // Among them some that are zero.
            let values: Vec<f32> = (0..LANES * blocks.len()).map(|i| (noise(i) as f32 - 0.3).max(0.0)).collect();
            let mut pressure = vec![0.0; grid.len()];
            for (place, values) in blocks.places().iter().zip(values.chunks(LANES)) {
                for (p, value) in pressure[place * LANES..].iter_mut().zip(values) {
                    *p = f64::from(*value);
                }
            }
            let mut kernel = response.compliance().to_vec();
            kernel[0] = uniform;
            let transform = Transform::new(grid);
            let mut exact = vec![0.0; grid.len()];
            transform.convolve(&kernel, &pressure, &mut exact, &mut transform.workspace()).unwrap();
            let largest = exact.iter().fold(0.0, |largest: f64, u| largest.max(u.abs()));
            let mut image = vec![f32::NAN; values.len()];
            scattered.compliance(&blocks, &values, &mut scattered.memory(), &mut image);
            for (place, image) in blocks.places().iter().zip(image.chunks(LANES)) {
                for (exact, image) in exact[place * LANES..].iter().zip(image) {
                    let error = f64::from(*image) * scattered.unit() - exact;
                    assert!(error.abs() < 5e-4 * largest, "{points:?} {height:?} {place}: {error} of {largest}");
                }
            }
        }
    }

    #[test]
    fn the_stiffness_is_symmetric_and_positive() {
        let response = response([128, 128], [1.0, 1.0], None);
        let scattered = Scattered::of(&response, [0.0; 2]).unwrap();
        let blocks = Blocks::new(response.grid(), places(response.grid()));
        let field = |seed: f32| (0..LANES * blocks.len()).map(|i| (seed * i as f32).sin()).collect::<Vec<f32>>();
        let image = |field: &[f32]| {
            let mut out = vec![f32::NAN; field.len()];
            scattered.stiffness(&blocks, field, &mut scattered.memory(), &mut out);
            out
        };
        let dot = |a: &[f32], b: &[f32]| gfmd_vector::dot(a, b);
        for seed in [0.1, 0.7, 2.0] {
            let (a, b) = (field(seed), field(1.3 * seed));
            let (k_a, k_b) = (image(&a), image(&b));
            assert!((dot(&a, &k_b) - dot(&b, &k_a)).abs() < 1e-5 * dot(&a, &k_a));
            assert!(dot(&a, &k_a) > 0.0);
        }
    }

    #[test]
    fn grids_without_whole_blocks_and_thin_layers_are_left_to_transforms() {
        for (points, lengths) in [
            ([64, 64], [1.0, 1.0]),
            ([1, 4096], [1.0, 1.0]),
            ([4096, 1], [1.0, 1.0]),
            ([130, 128], [1.0, 1.0]),
            ([128, 132], [1.0, 1.0]),
            ([128, 128], [1.0, 2.0]),
            ([251, 251], [1.0, 1.0]),
        ] {
            assert!(Scattered::of(&response(points, lengths, None), [0.0; 2]).is_none(), "{points:?}");
        }
        let thin = response([128, 128], [1.0, 1.0], Some(0.01));
        assert!(Scattered::of(&thin, [thin.uniform_compliance(), 0.0]).is_none());
    }

    #[test]
    fn waves_on_the_coarse_grid_have_the_stiffness_of_the_body() {
        let response = response([128, 128], [1.0, 1.0], None);
        let grid = *response.grid();
        let scattered = Scattered::of(&response, [0.0; 2]).unwrap();
        let blocks = Blocks::new(&grid, (0..grid.len() / LANES).collect());
        let [rows, columns] = scattered.coarse().points();
        for number in [1_i64, 3, 6] {
            let wave =
                |i: usize| (TAU * (number * (i / columns + i % columns) as i64) as f64 / columns as f64).cos() as f32;
            let field: Vec<f32> = (0..rows * columns).map(wave).collect();
            let mut displacement = vec![f32::NAN; grid.len()];
            scattered.interpolate(&blocks, &field, &mut scattered.memory(), &mut displacement);
            let mut traction = field.clone();
            scattered.stiffen(&blocks, &mut traction, &vec![0.0; grid.len()], &mut scattered.memory());
            let stiffness = scattered.unit() / compliance_of(&response, [number; 2]);
            let expected = stiffness * gfmd_vector::dot(&displacement, &displacement);
            let energy = gfmd_vector::dot(&field, &traction);
            assert!((energy / expected - 1.0).abs() < 1e-4, "{number}: {energy} {expected}");
        }
    }

    #[test]
    fn splines_are_parts_of_one_and_keep_their_centre() {
        for place in [0.0, 0.25, 0.5, 0.9] {
            let values = spline(place);
            let [sum, centre] = [0, 1].map(|power| {
                let terms = values.iter().enumerate();
                terms.map(|(k, w)| w * (k as f64 + 1.0 - ORDER as f64 / 2.0).powi(power)).sum::<f64>()
            });
            assert!((sum - 1.0).abs() < 1e-14 && (centre - place).abs() < 1e-14, "{place}: {sum} {centre}");
        }
    }
}
