use rayon::prelude::*;

/// Continues values that are known on part of a periodic grid to all of it: E, linear, the identity on the known part.
/// The others take a weighted mean of the known ones around them, at the finest scale at which there are enough
/// ("pull-push", Gortler et al. 1996), so E costs a few operations for each point.
///
/// For the transpose the same weights are walked the other way.
pub(crate) struct Extension {
    /// Points; a profile is one row.
    points: [usize; 2],
    /// Cells of 2×2 points first, then of 2×2 cells, up to one cell.
    levels: Vec<Level>,
}

/// What is known: `gradient − level` where `x` > 0. Where it is negative at x = 0, and lower than what the cell around
/// has got, the point has its own value, too, but does not teach others: it is about to enter the contact.
#[derive(Clone, Copy)]
pub(crate) struct Known<'a> {
    pub(crate) x: &'a [f64],
    pub(crate) gradient: &'a [f64],
    pub(crate) level: f64,
}

struct Level {
    cells: [usize; 2],
    /// The known weight at which the own value of a cell counts in full.
    full: f64,
    /// How much of the next level's value is taken where the own does not count; the rest of it is zero.
    trust: f64,
    /// Weights of the children.
    known: Vec<f64>,
    value: Vec<f64>,
    /// The same on the way of the transpose.
    image: Vec<f64>,
}

/// `full` of cells with two and with four children. Less than their number, so that a cell counts in full when most of
/// it is known; more than one, so that a lone point loses weight from level to level and cannot impose its value on a
/// large neighbourhood: that would cost the more energy the larger it is.
const FULL: [f64; 2] = [1.5, 3.0];

impl Extension {
    /// `stiffness` is that of the wave with so many periods along the longer side. Where it falls by half from an octave
    /// to the next, as on a half-space, displacement spreads, and what is not known is taken from afar; where it does
    /// not, as in waves longer than a layer is thick, a point moves by itself, and zero is nearer.
    ///
    /// `floating`: constants stay constants. Otherwise values decay to zero away from all that is known.
    pub(crate) fn new([nx, ny]: [usize; 2], floating: bool, stiffness: impl Fn(usize) -> f64) -> Self {
        let points = if nx.min(ny) == 1 { [1, nx.max(ny)] } else { [nx, ny] };
        let mut levels = Vec::new();
        let mut below = points;
        while below != [1, 1] {
            let cells = below.map(|n| n.div_ceil(2));
            let [half, whole] = [4, 2].map(|part| cells[0].max(cells[1]) * 2 / part);
            let ratio =
                if half > 0 { stiffness(half) / stiffness(whole.min(points[0].max(points[1]) / 2)) } else { 0.5 };
            let zeros = || vec![0.0; cells[0] * cells[1]];
            levels.push(Level {
                cells,
                full: FULL[usize::from(!below.contains(&1))],
                trust: (2.5 - 2.5 * ratio).clamp(0.0, 1.0),
                known: zeros(),
                value: zeros(),
                image: zeros(),
            });
            below = cells;
        }
        if let (true, Some(top)) = (floating, levels.last_mut()) {
            top.full = 0.0;
        }
        Self { points, levels }
    }

    /// Prepares the values that [`fill`](Self::fill) hands out.
    pub(crate) fn extend(&mut self, known: Known) {
        let Some(first) = self.levels.first_mut() else { return };
        first.pull(self.points, |k| if known.x[k] > 0.0 { (1.0, known.own(k)) } else { (0.0, 0.0) });
        self.climb(|above, below| above.pull(below.cells, |k| (below.weight(k), below.value[k])));
        if let Some(top) = self.levels.last_mut() {
            top.value[0] *= top.weight(0);
        }
        self.descend(|above, below| {
            let Level { cells: [_, columns], full, known, value, .. } = below;
            let rows = value.par_chunks_mut(*columns).with_min_len(few(*columns)).enumerate();
            rows.for_each(|(i, row)| {
                above.push(i, row.len(), |j, value| {
                    let weight = weight(known[i * *columns + j], *full);
                    row[j] = weight * row[j] + (1.0 - weight) * value;
                });
            });
        });
    }

    /// Row i of E r.
    pub(crate) fn fill(&self, known: Known, i: usize, row: &mut [f64]) {
        let start = i * row.len();
        let Some(first) = self.levels.first() else { return row.fill(known.own(0)) };
        let cells = first.row(&first.value, i / 2);
        first.push(i, row.len(), |j, value| {
            row[j] = if known.keeps(start + j, cells[j / 2]) { known.own(start + j) } else { value };
        });
    }

    /// `t` ← Eᵀ t, after [`extend`](Self::extend).
    pub(crate) fn transpose(&mut self, known: Known, t: &mut [f64]) {
        let columns = self.points[1];
        let Some(first) = self.levels.first_mut() else { return };
        let (width, value) = (first.cells[1], &first.value);
        let keeps = |k: usize, i: usize, j: usize| known.keeps(k, value[i / 2 * width + j / 2]);
        let children = |i: usize, j: usize| {
            let k = i * columns + j;
            if keeps(k, i, j) { 0.0 } else { t[k] }
        };
        gather(first.cells, first.trust, &mut first.image, self.points, children);
        self.climb(|above, below| {
            let columns = below.cells[1];
            let children = |i: usize, j: usize| (1.0 - below.weight(i * columns + j)) * below.image[i * columns + j];
            gather(above.cells, above.trust, &mut above.image, below.cells, children);
        });
        if let Some(top) = self.levels.last_mut() {
            top.image[0] *= top.weight(0);
        }
        self.descend(|above, below| {
            let Level { cells: [_, columns], full, known, image, .. } = below;
            let rows = image.par_chunks_mut(*columns).with_min_len(few(*columns)).enumerate();
            rows.for_each(|(i, row)| {
                let parents = (above.row(&above.image, i / 2), above.row(&above.known, i / 2));
                for (j, image) in row.iter_mut().enumerate() {
                    *image = weight(known[i * *columns + j], *full) * (*image + share(parents, j / 2));
                }
            });
        });
        let first = &self.levels[0];
        t.par_chunks_mut(columns).with_min_len(few(columns)).enumerate().for_each(|(i, row)| {
            let parents = (first.row(&first.image, i / 2), first.row(&first.known, i / 2));
            let cells = first.row(&first.value, i / 2);
            for (j, t) in row.iter_mut().enumerate() {
                let k = i * columns + j;
                if known.x[k] > 0.0 {
                    *t += share(parents, j / 2);
                } else if !known.keeps(k, cells[j / 2]) {
                    *t = 0.0;
                }
            }
        });
    }

    fn climb(&mut self, mut step: impl FnMut(&mut Level, &Level)) {
        for k in 1..self.levels.len() {
            let (below, above) = self.levels.split_at_mut(k);
            step(&mut above[0], &below[k - 1]);
        }
    }

    fn descend(&mut self, mut step: impl FnMut(&Level, &mut Level)) {
        for k in (1..self.levels.len()).rev() {
            let (below, above) = self.levels.split_at_mut(k);
            step(&above[0], &mut below[k - 1]);
        }
    }
}

impl Known<'_> {
    fn own(&self, k: usize) -> f64 {
        self.gradient[k] - self.level
    }

    fn keeps(&self, k: usize, around: f64) -> bool {
        self.x[k] > 0.0 || self.own(k) < around.min(0.0)
    }
}

impl Level {
    fn weight(&self, cell: usize) -> f64 {
        weight(self.known[cell], self.full)
    }

    fn row<'a>(&self, of: &'a [f64], i: usize) -> &'a [f64] {
        &of[i * self.cells[1]..][..self.cells[1]]
    }

    /// The weighted mean of the children, `(weight, value)` by index.
    fn pull(&mut self, [rows, columns]: [usize; 2], child: impl Fn(usize) -> (f64, f64) + Sync) {
        let width = self.cells[1];
        let cells = self.value.par_chunks_mut(width).zip(self.known.par_chunks_mut(width));
        cells.with_min_len(few(columns)).enumerate().for_each(|(a, (value, known))| {
            for (b, (value, known)) in value.iter_mut().zip(known).enumerate() {
                let (mut total, mut sum) = (0.0, 0.0);
                for i in 2 * a..rows.min(2 * a + 2) {
                    for j in 2 * b..columns.min(2 * b + 2) {
                        let (weight, value) = child(i * columns + j);
                        total += weight;
                        sum += weight * value;
                    }
                }
                *known = total;
                *value = if total > 0.0 { sum / total } else { 0.0 };
            }
        });
    }

    /// Interpolates bilinearly to row i of the level below, of which the cells here are the means: `take(column, value)`.
    fn push(&self, i: usize, columns: usize, mut take: impl FnMut(usize, f64)) {
        let [height, width] = self.cells;
        let near = self.row(&self.value, i / 2);
        let far = self.row(&self.value, beside(i, height));
        let across = |b: usize| self.trust * (0.75 * near[b] + 0.25 * far[b]);
        let (mut before, mut here) = (across(width - 1), across(0));
        for b in 0..width {
            let after = across(if b + 1 < width { b + 1 } else { 0 });
            take(2 * b, 0.75 * here + 0.25 * before);
            if 2 * b + 1 < columns {
                take(2 * b + 1, 0.75 * here + 0.25 * after);
            }
            (before, here) = (here, after);
        }
    }
}

/// The transpose of the interpolation.
fn gather(
    [height, width]: [usize; 2],
    trust: f64,
    image: &mut [f64],
    [rows, columns]: [usize; 2],
    child: impl Fn(usize, usize) -> f64 + Sync,
) {
    image.par_chunks_mut(width).with_min_len(few(columns)).enumerate().for_each(|(a, image)| {
        image.fill(0.0);
        for (i, across) in children(a, rows, height) {
            for (b, image) in image.iter_mut().enumerate() {
                let sum = if b > 0 && 2 * b + 2 < columns {
                    let [p, q, r, s] = [2 * b - 1, 2 * b, 2 * b + 1, 2 * b + 2].map(|j| child(i, j));
                    0.25 * (p + s) + 0.75 * (q + r)
                } else {
                    children(b, columns, width).map(|(j, along)| along * child(i, j)).sum()
                };
                *image += trust * across * sum;
            }
        }
    });
}

fn weight(known: f64, full: f64) -> f64 {
    if known < full { known / full } else { 1.0 }
}

/// What a child gets of the image of its parent, for each unit of its weight.
fn share((images, known): (&[f64], &[f64]), parent: usize) -> f64 {
    if known[parent] > 0.0 { images[parent] / known[parent] } else { 0.0 }
}

/// The cell on the other side of child i from its parent, on one periodic axis.
fn beside(i: usize, cells: usize) -> usize {
    let cell = i / 2;
    if i % 2 == 1 { (cell + 1) % cells } else { (cell + cells - 1) % cells }
}

/// All children that are interpolated from `cell`, with its weight: its own, and the nearest of its neighbours.
fn children(cell: usize, points: usize, cells: usize) -> impl Iterator<Item = (usize, f64)> {
    let before = 2 * ((cell + cells - 1) % cells) + 1;
    let after = 2 * ((cell + 1) % cells);
    [(before, 0.25), (2 * cell, 0.75), (2 * cell + 1, 0.75), (after, 0.25)].into_iter().filter(move |c| c.0 < points)
}

/// Rows of so many columns that are worth a task.
fn few(columns: usize) -> usize {
    1 + 4096 / columns
}
