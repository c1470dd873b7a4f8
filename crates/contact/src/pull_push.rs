//! Pull-push (Gortler et al. 1996): extension of values known on part of a periodic grid to the whole grid.
//!
//! ```text
//!   level 2                 +-------+          pull: a cell gets the weighted mean of its four children,
//!                           |       |                level by level, up to one cell
//!   level 1             +---+---+---+---+      push: a cell with few known values is blended with the
//!                       |   |   |   |   |            interpolated level above, down to the points
//!   points            +-+-+-+-+-+-+-+-+-+-+
//!                      x . . x x . . . x .     x: known, unchanged;  .: extended
//! ```
//!
//! A point thus gets the mean of the known values around it on the finest scale with enough of them, at a cost of a few
//! operations per point. The map E is linear; its transpose applies the steps with equal weights in the opposite order.

mod level;
mod rows;

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use gfmd_relax::{BLOCK, Ceiling};
use gfmd_vector::Share;
use level::{Level, held_row, row_of};

/// Linear map E from values on part of a periodic grid to all of it; the identity on the known part.
pub(crate) struct PullPush {
    /// Number of points of this process; a profile is one row.
    points: [usize; 2],
    /// Rows of this process among all rows.
    share: Share,
    /// Number of levels computed in shares of rows. Every process holds all of the last one and of the levels above.
    shared: usize,
    edges: Edges,
    /// Cells of 2×2 points, then of 2×2 cells, up to one cell.
    levels: Vec<Level>,
    /// One bit per point, row by row in whole words; set if the point keeps its own value.
    kept: Vec<AtomicU64>,
    /// For each of these words, true if one of its points is not zero.
    above: Vec<AtomicBool>,
}

/// Known values: `gradient − level` where 0 < `x` < `upper`. A point with x = 0 also keeps its own value if it is
/// negative and lower than the extended one, because the point is about to enter the contact; but this value is not
/// extended to its neighbours.
#[derive(Clone, Copy)]
pub(crate) struct Known<'a> {
    pub(crate) x: &'a [f64],
    pub(crate) gradient: &'a [f32],
    pub(crate) level: f32,
    /// Largest x. Points with this x are treated like points with x = 0: their values are not known, and they keep
    /// their own if it is positive and higher than the extended one.
    pub(crate) upper: Ceiling<'a>,
}

impl<'a> Known<'a> {
    /// Returns the points of row i.
    fn row(&self, i: usize, columns: usize) -> rows::Points<'a> {
        (row_of(self.x, i, columns), row_of(self.gradient, i, columns), self.bounds(i, columns))
    }

    /// Returns the upper bounds of row i.
    fn bounds(&self, i: usize, columns: usize) -> Ceiling<'a> {
        self.upper.part(i * columns..(i + 1) * columns)
    }
}

/// Surroundings of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Edges {
    /// The opposite edge.
    Joined,
    /// The mirror image.
    Mirrored,
}

impl Edges {
    /// Returns the cell before `cell`, out of `cells`.
    fn before(self, cell: usize, cells: usize) -> usize {
        match self {
            Self::Joined => (cell + cells - 1) % cells,
            Self::Mirrored => cell.saturating_sub(1),
        }
    }

    /// Returns the cell after `cell`, out of `cells`.
    fn after(self, cell: usize, cells: usize) -> usize {
        match self {
            Self::Joined => (cell + 1) % cells,
            Self::Mirrored => (cell + 1).min(cells - 1),
        }
    }

    /// Returns the children to which `cell` contributes, with the weights: its own, and the nearest of its neighbours.
    fn children(self, cell: usize, cells: usize) -> [(usize, f32); 4] {
        let (before, after) = match self {
            Self::Mirrored if cell == 0 => (0, self.after(cell, cells)),
            _ => (2 * self.before(cell, cells) + 1, self.after(cell, cells)),
        };
        // The mirror image of the last cell contributes to its own last child.
        let after = if self == Self::Mirrored && cell + 1 == cells { 2 * cell + 1 } else { 2 * after };
        [(before, 0.25), (2 * cell, 0.75), (2 * cell + 1, 0.75), (after, 0.25)]
    }
}

/// `full` of cells with two and with four children. It is below the number of children, so that a cell has full weight
/// if most of it is known. It is above one, so that a single point loses weight from level to level: otherwise its
/// value would extend to a large neighbourhood, at an energy cost that increases with the size of the neighbourhood.
const FULL: [f32; 2] = [1.5, 3.0];

/// `full` of cells of 4×4 points, weighted by their number of known points.
const FULL_OF_POINTS: f32 = 5.0;

/// Largest number of cells of a level that every one of several processes holds.
const GATHERED: usize = 1 << 18;

/// Number of points in a word of [`PullPush::kept`], and in a block of the search.
const BITS: usize = u64::BITS as usize;
const _: () = assert!(BITS == BLOCK);

impl PullPush {
    /// Plans the map. `stiffness` gives the stiffness of a wave as a function of its number of periods along the longer
    /// side. If it halves when the wavelength doubles, as on a half-space, displacements extend far, and unknown values
    /// are taken from distant points. If it does not, as for waves longer than the thickness of a layer, points move
    /// independently, and zero is the better value.
    ///
    /// If `floating`, constants are extended as constants; otherwise values decay to zero away from the known points.
    pub(crate) fn new([nx, ny]: [usize; 2], floating: bool, edges: Edges, stiffness: impl Fn(usize) -> f64) -> Self {
        let points = if nx.min(ny) == 1 { [1, nx.max(ny)] } else { [nx, ny] };
        let mut levels = Vec::new();
        let mut below = points;
        while below != [1, 1] {
            let cells = below.map(|n| n.div_ceil(2));
            let shortest = (nx.max(ny) / 2).min(cells[0].max(cells[1]));
            let ratio = if shortest > 1 { stiffness(shortest / 2) / stiffness(shortest) } else { 0.5 };
            let full = FULL[usize::from(!below.contains(&1))];
            levels.push(Level::new(cells, full, (2.5 - 2.5 * ratio).clamp(0.0, 1.0) as f32));
            below = cells;
        }
        if let (true, Some(top)) = (floating, levels.last_mut()) {
            top.full = 0.0;
        }
        let share = Share::whole(points[0], points[1]);
        Self { points, share, shared: 0, edges, levels, kept: words_of(points), above: words_of(points) }
    }

    /// Plans the map from known values on [`cells`](Self::cells) of 4×4 points to all of these cells. The known weight
    /// of a cell is its number of known points.
    pub(crate) fn on_cells(cells: [usize; 2], floating: bool, stiffness: impl Fn(usize) -> f64) -> Self {
        let mut all = Self::new(cells.map(|n| 2 * n), floating, Edges::Joined, stiffness);
        all.levels[0].full = FULL_OF_POINTS;
        all
    }

    /// Returns the number of levels computed in shares of rows: all above [`GATHERED`] cells, and the next one.
    pub(crate) fn shared_levels(points: [usize; 2]) -> u32 {
        let cells = |level: u32| points.iter().map(|n| n.div_ceil(1 << level)).product::<usize>();
        (1..).find(|level| cells(*level) <= GATHERED).unwrap_or(1)
    }

    /// Restricts the map to the points of one of several processes, which make the same calls. The rows of its first
    /// [`shared_levels`](Self::shared_levels) levels are shared.
    pub(crate) fn distributed(mut self, share: &Share) -> Self {
        if share.is_whole() {
            return self;
        }
        self.shared = self.levels.len().min(Self::shared_levels(self.points) as usize);
        for (height, level) in (1..).zip(&mut self.levels[..self.shared]) {
            level.distribute(share, height, height as usize == self.shared);
        }
        self.points[0] = share.rows().len();
        (self.kept, self.above) = (words_of(self.points), words_of(self.points));
        self.share = share.clone();
        self
    }

    /// Restricts the map [`on_cells`](Self::on_cells) to the rows of cells of one of several processes, which make the
    /// same calls. Levels are shared as in [`distributed`](Self::distributed), as far as processes have whole rows of
    /// them, and always the first one.
    pub(crate) fn cells_over(mut self, share: &Share) -> Self {
        if share.is_whole() {
            return self;
        }
        let most = (Self::shared_levels(self.points) as usize).max(2);
        let is_whole = |height: u32| share.all_rows().iter().all(|rows| rows.start.is_multiple_of(1 << height));
        self.shared = (0..).take_while(|height| is_whole(*height)).take(most.min(self.levels.len())).count();
        for (height, level) in (0..).zip(&mut self.levels[..self.shared]) {
            level.distribute(share, height, height as usize + 1 == self.shared);
        }
        self.share = share.clone();
        self
    }

    /// Adapts the map to displacements that resist bending: a value extends to as large a neighbourhood as there is
    /// room for, since the energy cost falls with its size.
    pub(crate) fn bending(mut self) -> Self {
        self.levels.iter_mut().for_each(|level| level.full = level.full.min(1.0));
        self
    }

    /// Returns true if constants are extended as constants.
    pub(crate) fn keeps_constants(&self) -> bool {
        self.levels.iter().all(|level| level.trust == 1.0) && self.levels.last().is_none_or(|top| top.full == 0.0)
    }

    /// Allocates the levels.
    fn reserve(&mut self) {
        self.levels.iter_mut().for_each(Level::reserve);
    }

    /// Frees the levels until the next use.
    pub(crate) fn release(&mut self) {
        self.levels.iter_mut().for_each(Level::release);
    }

    /// Computes all levels of E r except the points, which are computed by [`row`](Self::row).
    pub(crate) fn prepare(&mut self, known: Known) {
        self.reserve();
        let (share, shared) = (&self.share, self.shared);
        let (start, columns) = (share.rows().start, self.points[1]);
        let points = [share.all_rows().last().map_or(0, |rows| rows.end), columns];
        let Some(first) = self.levels.first_mut() else { return };
        first.pull(points, |i, weights, values| {
            let i = i - start;
            rows::weigh_points(known.row(i, columns), known.level, words(&self.above, i, columns), weights, values);
        });
        exchange_level(share, shared, 0, first);
        self.fill();
    }

    /// Extends the values of the [`cells`](Self::cells) of the first level.
    pub(crate) fn fill_cells(&mut self) {
        if self.shared > 0 {
            self.levels[0].exchange_known(&self.share);
        }
        self.fill();
    }

    /// Applies the transpose of [`fill_cells`](Self::fill_cells).
    pub(crate) fn fill_cells_transposed(&mut self) {
        if self.shared > 0 {
            self.levels[0].exchange_values(&self.share);
        }
        self.fill_transposed();
    }

    /// Extends the values of the first level.
    fn fill(&mut self) {
        let (edges, share, shared) = (self.edges, &self.share, self.shared);
        upwards(&mut self.levels, |number, above, below| {
            above.pull(below.cells, |i, weights, values| {
                rows::weigh(below.full, (below.known(i), below.value(i)), weights, values);
            });
            exchange_level(share, shared, number, above);
        });
        weigh_top(&mut self.levels);
        downwards(&mut self.levels, |number, above, below| {
            let columns = below.cells[1];
            let (full, known) = (below.full, std::mem::take(&mut below.known));
            let held = below.values();
            let first = held.1.start;
            above.push(edges, held, columns, |i, value, pushed| {
                rows::blend(full, row_of(&known, i - first, columns), pushed, value);
            });
            below.known = known;
            if number < shared {
                below.exchange_halo(share);
            }
        });
    }

    /// Marks the words in which a point was not zero or kept its own value. Returns false, and marks none, if rows end
    /// within words.
    pub(crate) fn mark(&self, words: &mut [bool]) -> bool {
        let are_whole = self.points[1].is_multiple_of(BITS);
        if are_whole {
            for (word, (above, kept)) in words.iter_mut().zip(self.above.iter().zip(&self.kept)) {
                *word = above.load(Ordering::Relaxed) || kept.load(Ordering::Relaxed) != 0;
            }
        }
        are_whole
    }

    /// Computes row i of E r, after [`prepare`](Self::prepare).
    pub(crate) fn row(&self, known: Known, i: usize, out: &mut [f32]) {
        let columns = self.points[1];
        match self.levels.first() {
            Some(first) => first.interpolate(self.edges, self.share.rows().start + i, out),
            None => out.fill(0.0),
        }
        let (above, kept) = (words(&self.above, i, columns), words(&self.kept, i, columns));
        rows::keep(known.row(i, columns), known.level, above, kept, out);
    }

    /// Replaces `t` by Eᵀ t, with the map E of the last rows.
    pub(crate) fn transpose(&mut self, known: Known, t: &mut [f32]) {
        let (edges, share, shared) = (self.edges, &self.share, self.shared);
        let ([rows, columns], own) = (self.points, share.rows());
        let points = [share.all_rows().last().map_or(0, |rows| rows.end), columns];
        let Some(first) = self.levels.first_mut() else { return };
        let kept = |i: usize| words(&self.kept, i, columns);
        let loaded = |i: usize| kept(i).iter().map(|word| word.load(Ordering::Relaxed)).collect::<Vec<u64>>();
        let (t_beside, kept_beside): ([Vec<f32>; 2], [Vec<AtomicU64>; 2]) = if share.is_whole() {
            Default::default()
        } else {
            (
                share.beside(row_of(t, 0, columns), row_of(t, rows - 1, columns)),
                share
                    .beside(&loaded(0), &loaded(rows - 1))
                    .map(|words| words.into_iter().map(AtomicU64::new).collect()),
            )
        };
        // Points that did not keep their own value pass their entry of t to the levels above.
        let entries = &*t;
        let width = columns.div_ceil(BITS);
        first.push_transposed(edges, points, |i, line, part| {
            let row = held_row(entries, &t_beside, &own, points, i);
            let kept = held_row(&self.kept, &kept_beside, &own, [points[0], width], i);
            rows::accumulate_points(row, kept, part, line);
        });
        if shared > 0 {
            first.exchange_values(share);
        }
        self.fill_transposed();
        let kept = |i: usize| words(&self.kept, i, columns);
        self.levels[0].pull_transposed((t, own.clone()), columns, |i, t, share| {
            let i = i - own.start;
            rows::finish(row_of(known.x, i, columns), known.bounds(i, columns), kept(i), share, t);
        });
    }

    /// Applies the transpose of [`fill`](Self::fill).
    fn fill_transposed(&mut self) {
        let (edges, share, shared) = (self.edges, &self.share, self.shared);
        upwards(&mut self.levels, |number, above, below| {
            above.push_transposed(edges, below.cells, |i, line, part| {
                rows::accumulate_cells(below.full, (below.known(i), below.value(i)), part, line);
            });
            if number < shared {
                above.exchange_values(share);
            }
        });
        weigh_top(&mut self.levels);
        downwards(&mut self.levels, |_, above, below| {
            let columns = below.cells[1];
            let (full, known) = (below.full, std::mem::take(&mut below.known));
            let held = below.values();
            let first = held.1.start;
            above.pull_transposed(held, columns, |i, image, share| {
                rows::receive(full, row_of(&known, i - first, columns), share, image);
            });
            below.known = known;
        });
    }

    /// Returns the known weights and the values of the cells of the first level, in the rows of this process.
    pub(crate) fn cells(&mut self) -> (&mut [f32], &mut [f32]) {
        self.reserve();
        let first = &mut self.levels[0];
        (&mut first.known, &mut first.value)
    }
}

/// Visits every level, by its number, together with the level below it, upwards.
fn upwards(levels: &mut [Level], mut step: impl FnMut(usize, &mut Level, &Level)) {
    for k in 1..levels.len() {
        let (below, above) = levels.split_at_mut(k);
        step(k, &mut above[0], &below[k - 1]);
    }
}

/// Receives the values of a level computed by other processes, if its number is below `shared`.
fn exchange_level(share: &Share, shared: usize, number: usize, level: &mut Level) {
    if number < shared {
        level.exchange_known(share);
        if number + 1 == shared {
            level.exchange_values(share);
        }
    }
}

/// Weighs the top level, which has no level above.
fn weigh_top(levels: &mut [Level]) {
    if let Some(top) = levels.last_mut() {
        top.value[0] *= top.weight(top.known[0]);
    }
}

/// Visits every level, by its number, together with the level above it, downwards.
fn downwards(levels: &mut [Level], mut step: impl FnMut(usize, &Level, &mut Level)) {
    for k in (1..levels.len()).rev() {
        let (below, above) = levels.split_at_mut(k);
        step(k - 1, &above[0], &mut below[k - 1]);
    }
}

/// Returns a default value for each word of bits of `rows` × `columns` points.
fn words_of<T: Default>([rows, columns]: [usize; 2]) -> Vec<T> {
    (0..rows * columns.div_ceil(BITS)).map(|_| T::default()).collect()
}

/// Returns the entries that belong to the words of row i.
fn words<T>(of_all: &[T], i: usize, columns: usize) -> &[T] {
    let words = columns.div_ceil(BITS);
    &of_all[i * words..][..words]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAPES: [[usize; 2]; 9] = [[16, 16], [7, 12], [12, 7], [1, 9], [9, 1], [33, 2], [3, 3], [2, 2], [1, 2]];

    /// Plans the extension for a half-space, with a stiffness proportional to the wavenumber.
    fn extension(points: [usize; 2], floating: bool, edges: Edges) -> PullPush {
        PullPush::new(points, floating, edges, |periods| periods as f64)
    }

    const BOTH: [Edges; 2] = [Edges::Joined, Edges::Mirrored];

    /// Computes all rows of E r.
    fn extend(extension: &mut PullPush, known: Known, out: &mut [f32]) {
        extension.prepare(known);
        let columns = extension.points[1];
        out.chunks_mut(columns).enumerate().for_each(|(i, row)| extension.row(known, i, row));
    }

    /// Returns reproducible, scattered numbers between −1 and 1.
    fn noise(n: usize, seed: f64) -> Vec<f32> {
        (0..n).map(|i| (2.0 * ((i as f64 + 1.0) * 0.618_034 + seed * 0.754_878).fract() - 1.0) as f32).collect()
    }

    /// Returns a field with a third of the points in contact, scattered, and residuals of both signs.
    fn field([nx, ny]: [usize; 2]) -> (Vec<f64>, Vec<f32>) {
        let x = noise(nx * ny, 0.3).iter().map(|v| f64::from(v - 0.3).max(0.0)).collect();
        (x, noise(nx * ny, 7.1))
    }

    #[test]
    fn known_values_and_constants_are_kept() {
        for (points, edges) in SHAPES.into_iter().flat_map(|points| BOTH.map(|edges| (points, edges))) {
            let (x, mut gradient) = field(points);
            let mut out = vec![f32::NAN; x.len()];
            extend(
                &mut extension(points, true, edges),
                Known { x: &x, gradient: &gradient, level: 0.2, upper: Ceiling::All(f64::INFINITY) },
                &mut out,
            );
            for (k, out) in out.iter().enumerate() {
                assert!(x[k] == 0.0 || *out == gradient[k] - 0.2, "{points:?} {k}");
                assert!(x[k] > 0.0 || *out == gradient[k] - 0.2 || *out <= 0.8, "a mean of known values");
            }
            gradient.fill(0.7);
            if x.iter().any(|x| *x > 0.0) {
                extend(
                    &mut extension(points, true, edges),
                    Known { x: &x, gradient: &gradient, level: 0.2, upper: Ceiling::All(f64::INFINITY) },
                    &mut out,
                );
                assert!(out.iter().all(|out| (out - 0.5).abs() < 1e-6), "{points:?}");
            }
        }
    }

    #[test]
    fn the_transpose_is_one() {
        for points in SHAPES {
            for (floating, edges) in [false, true].into_iter().flat_map(|floating| BOTH.map(|edges| (floating, edges)))
            {
                let (x, gradient) = field(points);
                let known = Known { x: &x, gradient: &gradient, level: -0.1, upper: Ceiling::All(f64::INFINITY) };
                let mut extension = extension(points, floating, edges);
                let mut extended = vec![0.0; x.len()];
                extend(&mut extension, known, &mut extended);
                let traction = noise(x.len(), 3.3);
                let mut image = traction.clone();
                extension.transpose(known, &mut image);
                let direct: f32 = extended.iter().zip(&traction).map(|(a, b)| a * b).sum();
                let around: f32 = gradient.iter().zip(&image).map(|(g, z)| (g + 0.1) * z).sum();
                assert!((direct - around).abs() < 1e-6 * x.len() as f32, "{points:?}: {direct} {around}");
                let free = |k: usize| x[k] > 0.0 || extended[k] == gradient[k] + 0.1;
                assert!((0..x.len()).all(|k| free(k) || image[k] == 0.0), "{points:?}");
            }
        }
    }

    #[test]
    fn what_moves_is_marked() {
        for (points, edges) in [[8, 64], [3, 192]].into_iter().flat_map(|points| BOTH.map(|edges| (points, edges))) {
            let (mut x, mut gradient) = field(points);
            // Blocks in contact, blocks that touch nowhere, and some of these with a point that is about to enter.
            for (number, (x, gradient)) in x.chunks_mut(BITS).zip(gradient.chunks_mut(BITS)).enumerate() {
                if number % 2 == 1 {
                    x.fill(0.0);
                    gradient.fill(1.0);
                    gradient[17] = if number % 4 == 1 { -3.0 } else { 1.0 };
                }
            }
            let known = Known { x: &x, gradient: &gradient, level: 0.0, upper: Ceiling::All(f64::INFINITY) };
            let mut extension = extension(points, true, edges);
            let mut image = vec![0.0; x.len()];
            extend(&mut extension, known, &mut image);
            extension.transpose(known, &mut image);
            let mut marks = vec![false; x.len() / BITS];
            assert!(extension.mark(&mut marks));
            for (number, (mark, (x, image))) in marks.iter().zip(x.chunks(BITS).zip(image.chunks(BITS))).enumerate() {
                let moves = x.iter().any(|x| *x != 0.0) || image.iter().any(|z| *z != 0.0);
                assert_eq!((*mark, moves), (number % 4 != 3, number % 4 != 3), "{points:?} {number}");
            }
        }
        let mut marks = [false; 3];
        assert!(!extension([3, 48], true, Edges::Joined).mark(&mut marks), "blocks of several rows");
        assert_eq!(marks, [false; 3]);
    }

    #[test]
    fn nothing_known_is_zero_and_floating_or_not_decides_what_is_far() {
        let points = [64, 64];
        let mut x = vec![0.0; 4096];
        let mut gradient = vec![1.0; 4096];
        let far = 32 * 64 + 32;
        let value = |x: &[f64], gradient: &[f32], floating| {
            let mut out = vec![f32::NAN; 4096];
            extend(
                &mut extension(points, floating, Edges::Joined),
                Known { x, gradient, level: 0.0, upper: Ceiling::All(f64::INFINITY) },
                &mut out,
            );
            out[far]
        };
        assert_eq!(value(&x, &gradient, true), 0.0);
        assert_eq!(value(&x, &gradient, false), 0.0);
        x[0] = 1.0;
        assert_eq!(value(&x, &gradient, true), 1.0);
        assert!((0.0..0.01).contains(&value(&x, &gradient, false)));
        gradient[far] = -0.5;
        assert_eq!(value(&x, &gradient, true), -0.5, "a point that is about to enter");
    }

    #[test]
    fn waves_as_stiff_as_their_octave_are_not_continued() {
        let (x, gradient) = field([16, 16]);
        let mut out = vec![f32::NAN; 256];
        let known = Known { x: &x, gradient: &gradient, level: -2.0, upper: Ceiling::All(f64::INFINITY) };
        extend(&mut PullPush::new([16, 16], true, Edges::Joined, |_| 1.0), known, &mut out);
        assert!(out.iter().zip(&x).all(|(out, x)| *x > 0.0 || *out == 0.0));
    }
}
