//! Largest value of a field between its points.

use std::array::from_fn;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use gfmd_vector::{Share, contiguous};
use ndarray::{Array1, ArrayView2, CowArray, Ix1};

/// Largest value of a periodic field `[x, y]` between its points: the largest maximum of the quadratics through each
/// high point and its eight neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak {
    /// Largest value of the quadratics, in the unit of the field; the value of a point if its quadratic has no maximum.
    pub value: f64,
    /// Sharpness of the peak on this grid: the larger of both second differences at its point, positive for a maximum,
    /// divided by its value.
    pub sharpness: f64,
    /// Skewness of the peak on this grid: the larger of both third differences around its point, divided by its value.
    pub skewness: f64,
}

impl Peak {
    /// Finds the peak of `field`; `None` without points.
    pub fn of(field: ArrayView2<f64>) -> Option<Self> {
        Self::distributed(&whole(&field), field)
    }

    /// Finds the peak of a field from the rows of each process, on all processes, as [`of`](Self::of).
    pub fn distributed(share: &Share, field: ArrayView2<f64>) -> Option<Self> {
        let highest = share.each(field.iter().copied().max_by(f64::total_cmp).unwrap_or(f64::NEG_INFINITY));
        let highest = highest.into_iter().max_by(f64::total_cmp).filter(|_| share.total() > 0)?;
        let rows = Rows::of(share, field, 2);
        let rises = rows.maxima(0.5 * highest).map(|(place, around)| {
            let value = around[1][1];
            let [xx, yy] = second_differences(&around);
            let skewness = rows.third_differences(place).into_iter().fold(0.0, f64::max) / value;
            Self { value: value + rise(&around, rows.is_level(place)), sharpness: -xx.min(yy) / value, skewness }
        });
        let flat = Self { value: highest, sharpness: 0.0, skewness: 0.0 };
        let higher = |most: Self, peak: Self| if peak.value >= most.value { peak } else { most };
        let own = rises.reduce(higher).map(|Self { value, sharpness, skewness }| [value, sharpness, skewness]);
        let found = share.each(own.unwrap_or([f64::NAN; 3]));
        let found = found.into_iter().map(|[value, sharpness, skewness]| Self { value, sharpness, skewness });
        Some(found.fold(flat, higher))
    }
}

/// Returns a share that has all rows of a field.
fn whole(field: &ArrayView2<f64>) -> Share {
    Share::whole(field.nrows(), field.ncols())
}

/// Rows of a periodic field of one process, between rows of other processes.
struct Rows<'a> {
    own: ArrayView2<'a, f64>,
    /// Rows before the own ones, from the nearest one; empty if all rows are own.
    before: Vec<Vec<f64>>,
    /// Rows after the own ones, from the nearest one.
    after: Vec<Vec<f64>>,
}

impl<'a> Rows<'a> {
    /// Exchanges `reach` rows on each side.
    fn of(share: &Share, own: ArrayView2<'a, f64>, reach: usize) -> Self {
        let mut rows = Self { own, before: Vec::new(), after: Vec::new() };
        if !share.is_whole() {
            let count = own.nrows() as isize;
            for step in 0..reach as isize {
                // A process with few rows passes on what it got in the last step.
                let edges = [step, count - 1 - step].map(|i| (0..own.ncols()).map(|j| rows.at(i, j)).collect());
                let [first, last]: [Vec<f64>; 2] = edges;
                let [before, after] = share.beside(&first, &last);
                rows.before.push(before);
                rows.after.push(after);
            }
        }
        rows
    }

    /// Returns a value; rows count from the first own one, columns around the cell.
    fn at(&self, i: isize, j: usize) -> f64 {
        let count = self.own.nrows() as isize;
        if self.before.is_empty() {
            return self.own[[i.rem_euclid(count) as usize, j]];
        }
        match i {
            ..0 => self.before[(-1 - i) as usize][j],
            i if i < count => self.own[[i as usize, j]],
            i => self.after[(i - count) as usize][j],
        }
    }

    /// Returns the own local maxima with at least this value, with their 3 × 3 values.
    fn maxima(&self, least: f64) -> impl Iterator<Item = ([usize; 2], [[f64; 3]; 3])> {
        let (nx, ny) = self.own.dim();
        let has_one = move |i: &usize| self.own.row(*i).iter().any(|value| *value >= least);
        let places = (0..nx).filter(has_one).flat_map(move |i| (0..ny).map(move |j| [i, j]));
        places.filter(move |place| self.own[*place] >= least).filter_map(move |[i, j]| {
            let value = |di: usize, dj: usize| self.at((i + di) as isize - 1, (j + ny + dj - 1) % ny);
            let around: [[f64; 3]; 3] = from_fn(|di| from_fn(|dj| value(di, dj)));
            let is_highest = around.iter().flatten().all(|value| *value <= around[1][1]);
            is_highest.then_some(([i, j], around))
        })
    }

    /// Returns whether a point lies in a level row of points along x and along y; see [`levels`].
    fn is_level(&self, [i, j]: [usize; 2]) -> [bool; 2] {
        let ny = self.own.ncols();
        levels([
            from_fn(|k| self.at((i + k) as isize - 2, j)),
            from_fn(|k| self.at(i as isize, (j + 2 * ny + k - 2) % ny)),
        ])
    }

    /// Returns the magnitudes of the third differences along x and y, from two points on each side.
    fn third_differences(&self, [i, j]: [usize; 2]) -> [f64; 2] {
        let ny = self.own.ncols();
        let difference = |at: &dyn Fn(usize) -> f64| (0.5 * (at(4) - at(0)) - (at(3) - at(1))).abs();
        [
            difference(&|k| self.at((i + k) as isize - 2, j)),
            difference(&|k| self.at(i as isize, (j + 2 * ny + k - 2) % ny)),
        ]
    }
}

/// Points on each side used to interpolate a field without waves shorter than four points: the error of a sinc under a
/// Gaussian is e^(−π REACH/4), 5e-8 of the field.
const REACH: usize = 21;

/// Refinement of the grid around a high point.
const ZOOM: usize = 8;

/// Number of high points that are searched.
const CANDIDATES: usize = 8;

/// Returns the largest value between the points of a periodic field `[x, y]` without waves shorter than four points, in
/// the unit of the field: the quadratic through the largest point of an eight times finer grid around the highest
/// maxima, to 3e-5 of the amplitude of the shortest waves. NaN without points.
pub fn top(field: ArrayView2<f64>) -> f64 {
    top_of_shared(&whole(&field), field)
}

/// Returns the [`top`] of a field from the rows of each process, on all processes.
pub fn top_of_shared(share: &Share, field: ArrayView2<f64>) -> f64 {
    let highest = share.each(field.fold(f64::NEG_INFINITY, |most, value| most.max(*value)));
    let highest = highest.into_iter().fold(f64::NEG_INFINITY, f64::max);
    if !highest.is_finite() {
        return f64::NAN;
    }
    // With four points per wave, a wave exceeds its points by at most 1/cos(π/4) along each axis.
    let mean = share.total_of(&contiguous(&field)) / share.total() as f64;
    let rows = Rows::of(share, field, 2);
    let own = rows.maxima(highest - 0.5 * (highest - mean)).map(|([i, j], around)| {
        let place = [share.rows().start + i, j];
        (around[1][1] + rise(&around, rows.is_level([i, j])), place)
    });
    let own = highest_first(own.collect());
    let counts = share.each(own.len());
    let maxima = highest_first(share.collect(&own, &counts));
    let reached = reached(share, field, &maxima);
    let row = |i: usize| match &reached {
        Some(reached) => CowArray::from(reached[&i].view()),
        None => CowArray::from(field.row(i)),
    };
    let weights = weights();
    let points = [if share.is_whole() { field.nrows() } else { share.total() / field.ncols() }, field.ncols()];
    maxima.iter().fold(highest, |top, (_, place)| top.max(zoomed(row, points, *place, &weights)))
}

/// Height and place of a maximum.
type Candidate = (f64, [usize; 2]);

/// Returns the highest maxima in descending order, the first of equal ones first.
fn highest_first(mut maxima: Vec<Candidate>) -> Vec<Candidate> {
    maxima.sort_by(|(a, _), (b, _)| b.total_cmp(a));
    maxima.truncate(CANDIDATES);
    maxima
}

/// Gathers the rows within reach of the maxima, on all processes; `None` if all rows are own.
fn reached(share: &Share, field: ArrayView2<f64>, maxima: &[Candidate]) -> Option<BTreeMap<usize, Array1<f64>>> {
    if share.is_whole() {
        return None;
    }
    let count = share.all_rows().last()?.end;
    let around = |i: usize| (0..=2 * REACH).map(move |dx| (i + dx + REACH * count - REACH) % count);
    let wanted: BTreeSet<usize> = maxima.iter().flat_map(|(_, [i, _])| around(*i)).collect();
    let of = |rows: &Range<usize>| wanted.range(rows.clone()).copied().collect::<Vec<_>>();
    let own = of(&share.rows()).into_iter().flat_map(|i| field.row(i - share.rows().start).to_vec());
    let lengths: Vec<usize> = share.all_rows().iter().map(|rows| of(rows).len() * field.ncols()).collect();
    let values = share.collect(&own.collect::<Vec<f64>>(), &lengths);
    let rows = values.chunks_exact(field.ncols()).map(|row| Array1::from(row.to_vec()));
    Some(wanted.into_iter().zip(rows).collect())
}

/// Returns the largest value between the points of a patch, which does not repeat, in the unit of the field: the
/// largest maximum of the quadratics through the inner points and their neighbours, or the largest value of a point.
/// NaN without points.
pub fn top_inside(field: ArrayView2<f64>) -> f64 {
    top_inside_of_shared(&whole(&field), field)
}

/// Returns the [`top_inside`] of a field from the rows of each process, on all processes.
pub fn top_inside_of_shared(share: &Share, field: ArrayView2<f64>) -> f64 {
    let highest_of = |own: f64| share.each(own).into_iter().fold(f64::NEG_INFINITY, f64::max);
    let highest = highest_of(field.fold(f64::NEG_INFINITY, |most, value| most.max(*value)));
    if !highest.is_finite() {
        return f64::NAN;
    }
    let ny = field.ncols();
    let (first, nx) = if share.is_whole() { (0, field.nrows()) } else { (share.rows().start, share.total() / ny) };
    let is_inner = |at: usize, points: usize| points == 1 || at > 0 && at + 1 < points;
    let rows = Rows::of(share, field, 2);
    let inner = rows.maxima(f64::NEG_INFINITY).filter(|([i, j], _)| is_inner(first + i, nx) && is_inner(*j, ny));
    let risen = |([i, j], around): ([usize; 2], _)| field[[i, j]] + rise(&around, rows.is_level([i, j]));
    highest_of(inner.map(risen).fold(highest, f64::max))
}

/// Points of the finer grid along each side around a point.
const SIDE: usize = 2 * ZOOM + 1;

/// Weights of the points within reach, for each point of the finer grid along an axis.
type Weights = [[f64; 2 * REACH + 1]; SIDE];

fn weights() -> Weights {
    from_fn(|fine| {
        from_fn(|point| {
            let distance = point as f64 - REACH as f64 - (fine as f64 / ZOOM as f64 - 1.0);
            let angle = std::f64::consts::PI * distance;
            let sinc = if angle.abs() < 1e-12 { 1.0 } else { angle.sin() / angle };
            sinc * (-0.25 * angle * distance / REACH as f64).exp()
        })
    })
}

/// Returns the largest value around a point of a field of `[nx, ny]` points by interpolation.
fn zoomed<'a>(
    row: impl Fn(usize) -> CowArray<'a, f64, Ix1>,
    [nx, ny]: [usize; 2],
    [i, j]: [usize; 2],
    weights: &Weights,
) -> f64 {
    let at = |middle: usize, point: usize, n: usize| (middle + point + REACH * n - REACH) % n;
    let centre = row(i)[j];
    let along_y: Vec<[f64; SIDE]> = (0..=2 * REACH)
        .map(|dx| {
            let row = row(at(i, dx, nx));
            let rises: [f64; 2 * REACH + 1] = from_fn(|dy| row[at(j, dy, ny)] - centre);
            from_fn(|fine| weights[fine].iter().zip(&rises).map(|(weight, rise)| weight * rise).sum())
        })
        .collect();
    let values: [[f64; SIDE]; SIDE] =
        from_fn(|x| from_fn(|y| along_y.iter().zip(&weights[x]).map(|(row, weight)| weight * row[y]).sum()));
    // Interpolation overshoots at the edges of a plateau, which rises no further along its level rows.
    let along = [from_fn(|k| row(at(i, REACH + k - 2, nx))[j]), from_fn(|k| row(i)[at(j, REACH + k - 2, ny)])];
    let level = levels(along);
    let [along_x, along_y] = level.map(|is_level| if is_level { ZOOM..=ZOOM } else { 1..=SIDE - 2 });
    let inside = along_x.flat_map(|x| along_y.clone().map(move |y| [x, y]));
    let highest = inside.max_by(|[x, y], [u, v]| values[*x][*y].total_cmp(&values[*u][*v]));
    highest.map_or(f64::NAN, |[x, y]| {
        let around = from_fn(|dx| from_fn(|dy| values[x + dx - 1][y + dy - 1]));
        centre + around[1][1] + rise(&around, level)
    })
}

/// Returns the second differences of 3 × 3 points along x and y.
fn second_differences(at: &[[f64; 3]; 3]) -> [f64; 2] {
    let middle = at[1][1];
    [at[2][1] - 2.0 * middle + at[0][1], at[1][2] - 2.0 * middle + at[1][0]]
}

/// Returns whether a point is one of at least three equal ones in a row along x and along y, from five points along
/// each axis: on a profile across it, on the ridge of a cylinder along it, and on a plateau, such as a flat punch or
/// the saturated part of a scan. The edge of a plateau may have two equal points in a row.
fn levels(along: [[f64; 5]; 2]) -> [bool; 2] {
    let is_level = |at: &[f64; 5]| at.windows(3).any(|three| three[0] == three[1] && three[1] == three[2]);
    let ends = |at: &[f64; 5]| is_level(at) && at.iter().any(|value| *value != at[2]);
    let has_equal = |at: &[f64; 5]| at[1] == at[2] || at[2] == at[3];
    let [x, y] = &along;
    [is_level(x) || ends(y) && has_equal(x), is_level(y) || ends(x) && has_equal(y)]
}

/// Returns the rise of the quadratic through 3 × 3 points above the centre, zero if it has no maximum. Along a level
/// axis the points rise no further.
fn rise(at: &[[f64; 3]; 3], level: [bool; 2]) -> f64 {
    let slope = [0.5 * (at[2][1] - at[0][1]), 0.5 * (at[1][2] - at[1][0])];
    let [xx, yy] = second_differences(at);
    let xy = 0.25 * (at[2][2] - at[2][0] - at[0][2] + at[0][0]);
    let determinant = xx * yy - xy * xy;
    let along_one = |slope: f64, curvature: f64| if curvature < 0.0 { -0.5 * slope * slope / curvature } else { 0.0 };
    match level {
        [true, true] => return 0.0,
        [true, false] => return along_one(slope[1], yy),
        [false, true] => return along_one(slope[0], xx),
        [false, false] => {}
    }
    let has_maximum = xx < 0.0 && determinant > 0.0;
    // Minus half the slope times the step to the maximum.
    let along = yy * slope[0] * slope[0] - 2.0 * xy * slope[0] * slope[1] + xx * slope[1] * slope[1];
    if has_maximum { -0.5 * along / determinant } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use gfmd_vector::ThreadRanks;
    use ndarray::{Array2, s};

    #[test]
    fn the_maximum_of_a_quadratic_is_exact_and_that_of_a_wave_much_nearer_than_its_points() {
        let quadratic = |x: f64, y: f64| 3.0 - 0.4 * x * x + 0.1 * x * y - 0.3 * y * y;
        let field = Array2::from_shape_fn((9, 8), |(i, j)| quadratic(i as f64 - 4.3, j as f64 - 3.8));
        let peak = Peak::of(field.view()).unwrap();
        assert!((peak.value - 3.0).abs() < 1e-14, "{peak:?}");
        let highest = field.iter().copied().fold(0.0, f64::max);
        assert!((peak.sharpness * highest - 0.8).abs() < 1e-13 && peak.skewness.abs() < 1e-13, "{peak:?}");
        let cubic = Array2::from_shape_fn((9, 8), |(i, j)| {
            let [x, y] = [i as f64 - 4.0, j as f64 - 4.0];
            3.0 - 0.4 * x * x + 0.02 * x * x * x - 0.3 * y * y - 0.01 * y * y * y
        });
        // The third difference of x³ is 6.
        let peak = Peak::of(cubic.view()).unwrap();
        assert!((3.0 * peak.skewness - 0.12).abs() < 1e-13 && (3.0 * peak.sharpness - 0.8).abs() < 1e-13, "{peak:?}");
        let wave = |k: usize, n: usize, at: f64| (std::f64::consts::TAU * (k as f64 - at) / n as f64).cos();
        for at in [0.0, 0.2, 0.5] {
            let field = Array2::from_shape_fn((16, 12), |(i, j)| 2.0 + wave(i, 16, at) + wave(j, 12, 0.4));
            let (most, found) = (field.iter().copied().fold(0.0, f64::max), Peak::of(field.view()).unwrap());
            assert!((found.value - 4.0).abs() < 0.06 * (4.0 - most), "{at}: {most} {found:?}");
        }
        assert_eq!(Peak::of(Array2::<f64>::zeros((0, 3)).view()), None);
    }

    #[test]
    fn peak_and_top_have_the_bits_of_one_process() {
        for points in [[64, 64], [48, 128], [12, 2048], [5, 4096]] {
            let [nx, ny] = points.map(|n| n as f64);
            let wave =
                |x: f64, y: f64, k: f64, phase: f64| (std::f64::consts::TAU * (k * x / nx + y / ny) + phase).cos();
            for seed in 0..7 {
                let field = Array2::from_shape_fn(points, |(i, j)| {
                    let ([x, y], phase) = ([i as f64, j as f64], f64::from(seed));
                    2.0 + wave(x, y, 1.0, phase) + wave(y, x, 2.0, phase * phase) + 0.1 * wave(x, 3.0 * y, 1.0, 0.7)
                });
                let alone = (Peak::of(field.view()), top(field.view()).to_bits(), top_inside(field.view()).to_bits());
                for size in 2..=Share::most(points, 0).min(6) {
                    let each = ThreadRanks::of(size, |ranks| {
                        let share = Share::among(ranks, points, 0).unwrap();
                        let own = field.slice(s![share.rows(), ..]);
                        let tops = [top_of_shared(&share, own), top_inside_of_shared(&share, own)].map(f64::to_bits);
                        (Peak::distributed(&share, own), tops[0], tops[1])
                    });
                    assert!(each.iter().all(|found| *found == alone), "{points:?} on {size}: {each:?} {alone:?}");
                }
            }
        }
    }

    #[test]
    fn the_top_of_a_patch_and_of_a_profile_lies_between_their_points() {
        let sphere = |i: usize, at: f64| -0.3 * (i as f64 - at).powi(2);
        let field = Array2::from_shape_fn((9, 8), |(i, j)| 2.0 + sphere(i, 4.3) + sphere(j, 3.8));
        assert!((top_inside(field.view()) - 2.0).abs() < 1e-14);
        // The highest point at the rim is the top, though the other rim is lower.
        let tilted = Array2::from_shape_fn((9, 8), |(i, j)| i as f64 + sphere(j, 0.2));
        assert_eq!(top_inside(tilted.view()), tilted[[8, 0]]);
        assert!(top_inside(Array2::<f64>::zeros((0, 3)).view()).is_nan());
        let profile = Array2::from_shape_fn((9, 1), |(i, _)| 2.0 + sphere(i, 4.3));
        assert!((top_inside(profile.view()) - 2.0).abs() < 1e-14);
        let wave = Array2::from_shape_fn((64, 1), |(i, _)| (std::f64::consts::TAU * (i as f64 - 20.3) / 8.0).cos());
        // The bound that the function states.
        assert!((top(wave.view()) - 1.0).abs() < 3e-5, "{}", top(wave.view()));
    }

    #[test]
    fn a_plateau_does_not_rise_between_its_points_and_a_ridge_only_across() {
        type Height<'a> = &'a dyn Fn(usize, usize) -> f64;
        let far = |i: usize, j: usize| (i as f64 - 15.5).hypot(j as f64 - 15.8);
        let wave = |i: usize| (std::f64::consts::TAU * (i as f64 - 10.4) / 16.0).cos();
        let fields: [(&str, Height); 5] = [
            ("square punch", &|i, j| if (9..24).contains(&i) && (12..20).contains(&j) { 0.0 } else { -0.1 }),
            ("round punch", &|i, j| if far(i, j) < 7.3 { 0.0 } else { -0.1 }),
            ("strip", &|i, _| if (9..24).contains(&i) { 0.0 } else { -0.1 }),
            ("saturated waves", &|i, j| (wave(i) + wave(j) - 1.2).min(0.0)),
            ("cylinder", &|i, _| -0.01 * (i as f64 - 15.3).powi(2)),
        ];
        for (name, height) in fields {
            let field = Array2::from_shape_fn((32, 32), |(i, j)| height(i, j));
            assert_eq!(Peak::of((&field + 1.0).view()).unwrap().value, 1.0, "{name}");
            let [periodic, inside] = [top(field.view()), top_inside(field.view())];
            // Parabolas are no periodic waves.
            let within = if name == "cylinder" { 1e-3 } else { 1e-15 };
            assert!(periodic.abs() <= within && inside.abs() < 1e-15, "{name}: {periodic} {inside}");
        }
        let ridge = Array2::from_shape_fn((32, 32), |(_, j)| wave(j));
        assert!((top(ridge.view()) - 1.0).abs() < 3e-5);
    }

    #[test]
    fn a_peak_between_points_exceeds_a_lower_one_at_a_point() {
        let peak = |x: f64, y: f64, [u, v]: [f64; 2], value: f64| {
            (value - 0.4 * (x - u).powi(2) - 0.4 * (y - v).powi(2)).max(0.0)
        };
        let field = Array2::from_shape_fn((24, 12), |(i, j)| {
            let [x, y] = [i as f64, j as f64];
            peak(x, y, [6.5, 5.5], 3.1).max(peak(x, y, [17.0, 5.0], 3.0))
        });
        assert_eq!(field.fold(0.0, |most: f64, value| most.max(*value)), 3.0);
        let found = Peak::of(field.view()).unwrap();
        assert!((found.value - 3.1).abs() < 1e-14, "{found:?}");
        assert!((found.sharpness - 0.8 / 2.9).abs() < 1e-13, "{found:?}");
        assert_eq!(Peak::of(Array2::zeros((4, 4)).view()).unwrap().value, 0.0);
        assert!(Peak::of(Array2::from_elem((4, 4), f64::NAN).view()).unwrap().value.is_nan());
    }

    #[test]
    fn the_top_of_waves_four_points_long_is_found_between_the_points() {
        let tau = std::f64::consts::TAU;
        for (n, m, phase) in [(64, 64, 0.3), (64, 48, 0.5), (4, 8, 0.21), (128, 16, 0.77)] {
            // One wave of four points along each axis and a long one, with their maxima at the same place.
            let place = [phase * n as f64 / 5.0, 1.3 * phase * m as f64 / 5.0];
            let value = |x: f64, y: f64| {
                let [x, y] = [x - place[0], y - place[1]];
                (0.25 * tau * x).cos() + (0.25 * tau * y).cos() + 0.5 * (tau * (x / n as f64 + y / m as f64)).cos()
            };
            let field = Array2::from_shape_fn((n, m), |(i, j)| value(i as f64, j as f64));
            let most = field.iter().copied().fold(0.0, f64::max);
            let found = top(field.view());
            assert!((found - 2.5).abs() < 3e-5 * 2.5, "{n} {m}: {found}, points {most}");
            assert!(most < 2.475, "{most}");
        }
        assert_eq!(top(Array2::from_elem((5, 4), 0.3).view()), 0.3);
        assert!(top(Array2::<f64>::zeros((0, 3)).view()).is_nan());
        assert!(top(Array2::from_elem((5, 4), f64::NAN).view()).is_nan());
    }
}
