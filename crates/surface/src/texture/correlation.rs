use std::borrow::Cow;
use std::f64::consts::PI;

use gfmd_field::Grid;
use ndarray::{Array2, ArrayRef2, s};

use crate::statistics::checked;
use crate::{PowerSpectrum, SurfaceError};

/// Autocorrelation of heights, at distances up to half of the cell along x and along y.
///
/// The height-difference function A(d) = ⟨(h(x+d) − h(x))²⟩/2 is the mean over all points if the heights repeat,
/// otherwise over the pairs of points inside, as in SurfaceTopography. The autocorrelation f(d) = 1 − A(d)/Sq² is f_ACF
/// of ISO 25178-2 for heights that repeat. Otherwise the two differ, since the mean square over the pairs is not Sq².
#[derive(Clone, Debug, PartialEq)]
pub struct Autocorrelation {
    spacing: [f64; 2],
    /// Half of the (shorter) side, length.
    farthest: f64,
    /// True if the largest distance along an axis is half the period, where +d and −d are equivalent.
    is_edge: [bool; 2],
    /// Values of A at distances of 0 to nx/2 points along x and −ny/2 to ny/2 along y.
    difference: Array2<f64>,
    mean_square: f64,
}

/// Distances at which the autocorrelation falls to 0.2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CorrelationLengths {
    /// Sal of ISO 25178-2, length: the shortest distance over all directions. `None` if the autocorrelation does not
    /// fall to 0.2 within half of the cell, or if the surface is flat.
    pub sal: Option<f64>,
    /// Longest distance, over all directions, of the first fall to 0.2; `None` for a profile or if a direction has
    /// none.
    pub longest: Option<f64>,
    /// Largest distance at which the autocorrelation is known: half of the (shorter) side, length.
    pub farthest: f64,
}

impl CorrelationLengths {
    /// Returns Str of ISO 25178-2, the texture aspect ratio: the shortest divided by the longest distance, 1 for an
    /// isotropic surface.
    pub fn aspect(&self) -> Option<f64> {
        Some(self.sal? / self.longest?)
    }

    /// Returns an upper bound of Str: its value, or the shortest distance divided by the farthest one if a direction
    /// has none, as along parallel grooves.
    pub fn largest_aspect(&self) -> Option<f64> {
        Some(self.sal? / self.longest.unwrap_or(self.farthest))
    }
}

/// Autocorrelation at the correlation length.
const ENDS: f64 = 0.2;

/// Number of search directions, one degree apart.
const DIRECTIONS: usize = 180;

impl Autocorrelation {
    /// Computes the autocorrelation of heights `[nx, ny]`, or of a profile `[n, 1]`, by fast Fourier transforms.
    /// Heights that do not repeat are transformed in a cell 1.5 times as long.
    ///
    /// # Errors
    /// Heights that do not have the shape of the grid or are not finite.
    pub fn of(heights: &ArrayRef2<f64>, grid: &Grid, repeats: bool) -> Result<Self, SurfaceError> {
        let all = checked(heights, grid)?;
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let mean_square = all.iter().map(|height| (height - mean).powi(2)).sum::<f64>() / all.len() as f64;
        let deviations = heights.mapv(|height| height - mean);
        let [nx, ny] = grid.points();
        let half = [nx / 2, ny / 2];
        // The longer cell has room for the distances on all sides.
        let cell = if repeats { *grid } else { longer(grid, half)? };
        let [px, py] = cell.points();
        let field = if repeats { Cow::Borrowed(&deviations) } else { Cow::Owned(padded(&deviations, [px, py])) };
        let products = PowerSpectrum::of(&field, &cell)?.correlation()?;
        let product = |x: usize, y: i64| products[x % px * py + y.rem_euclid(py as i64) as usize];
        let squares = Squares::of(&deviations);
        let difference = Array2::from_shape_fn((half[0] + 1, 2 * half[1] + 1), |(x, y)| {
            let y = y as i64 - half[1] as i64;
            // Rounding must not make a mean square negative.
            let difference = match repeats {
                true => product(0, 0) - product(x, y),
                false => squares.over_pairs(x, y) - product(x, y) * cell.len() as f64 / pairs([nx, ny], x, y),
            };
            if (x, y) == (0, 0) { 0.0 } else { difference.max(0.0) }
        });
        let [lx, ly] = grid.lengths();
        Ok(Self {
            spacing: grid.spacing(),
            farthest: 0.5 * if grid.is_line() { lx } else { lx.min(ly) },
            is_edge: [nx, ny].map(|n| repeats && n.is_multiple_of(2)),
            difference,
            mean_square,
        })
    }

    /// Returns Sq², length².
    pub fn mean_square(&self) -> f64 {
        self.mean_square
    }

    /// Returns f = 1 − A/Sq² for a height-difference function A; NaN for a flat surface.
    pub fn relative(&self, difference: f64) -> f64 {
        if self.mean_square > 0.0 { 1.0 - difference / self.mean_square } else { f64::NAN }
    }

    /// Returns distances and A along x (axis 0) or y (axis 1), length and length²; the zero distance is the first.
    pub fn along(&self, axis: usize) -> Vec<[f64; 2]> {
        let middle = self.middle();
        let line = match axis {
            0 => self.difference.slice(s![.., middle]),
            _ => self.difference.slice(s![0, middle..]),
        };
        line.iter().enumerate().map(|(k, value)| [k as f64 * self.spacing[axis], *value]).collect()
    }

    /// Returns mean distances and means of A over rings with the width of the (larger) spacing, centred on its
    /// multiples, up to half of the (shorter) side. For a profile, every distance is a ring.
    pub fn radial(&self) -> Vec<[f64; 2]> {
        let (columns, middle) = (self.difference.ncols(), self.middle());
        let is_line = columns == 1;
        let width = if is_line { self.spacing[0] } else { self.spacing[0].max(self.spacing[1]) };
        let last = (self.farthest / width * (1.0 + 1e-12)).floor() as usize;
        let mut rings = vec![[0.0; 3]; last + 1];
        for ((x, y), value) in self.difference.indexed_iter() {
            let distance = (x as f64 * self.spacing[0]).hypot((y as f64 - middle as f64) * self.spacing[1]);
            let ring = (distance / width).round() as usize;
            if ring > last || distance > self.farthest * (1.0 + 1e-12) {
                continue;
            }
            // Along x, only one of ±d is stored; along y, both are. A distance at an edge is its own opposite.
            let across = if x == 0 || (self.is_edge[0] && x + 1 == self.difference.nrows()) { 1.0 } else { 2.0 };
            let weight = across * if !is_line && self.is_edge[1] && (y == 0 || y + 1 == columns) { 0.5 } else { 1.0 };
            let ring = &mut rings[ring];
            *ring = [ring[0] + weight, ring[1] + weight * distance, ring[2] + weight * value];
        }
        let filled = rings.into_iter().filter(|ring| ring[0] > 0.0);
        filled.map(|[weight, distance, value]| [distance / weight, value / weight]).collect()
    }

    /// Returns A at all distances of both signs: from −nx/2 to nx/2 points along x and −ny/2 to ny/2 along y, length².
    pub fn map(&self) -> Array2<f64> {
        let (rows, columns) = self.difference.dim();
        Array2::from_shape_fn((2 * rows - 1, columns), |(x, y)| match (x + 1).checked_sub(rows) {
            Some(x) => self.difference[[x, y]],
            None => self.difference[[rows - 1 - x, columns - 1 - y]],
        })
    }

    /// Returns the distances at which the autocorrelation first falls to 0.2, in directions one degree apart, by linear
    /// interpolation.
    pub fn lengths(&self) -> CorrelationLengths {
        let farthest = self.farthest;
        let none = CorrelationLengths { sal: None, longest: None, farthest };
        if self.mean_square <= 0.0 {
            return none;
        }
        if self.difference.ncols() == 1 {
            let line = self.along(0);
            return CorrelationLengths { sal: self.end(line.into_iter()), ..none };
        }
        let step = 0.5 * self.spacing[0].min(self.spacing[1]);
        let ends = (0..DIRECTIONS).map(|direction| {
            let angle = PI * direction as f64 / DIRECTIONS as f64 - 0.5 * PI;
            // Exact directions along y and along x.
            let direction = if direction == 0 { [0.0, -1.0] } else { [angle.cos(), angle.sin()] };
            let ray = (0..).map(|k| f64::from(k) * step);
            self.end(ray.map_while(|distance| Some([distance, self.at(direction.map(|part| part * distance))?])))
        });
        let ends: Vec<Option<f64>> = ends.collect();
        CorrelationLengths {
            sal: ends.iter().flatten().copied().reduce(f64::min),
            longest: ends.into_iter().collect::<Option<Vec<f64>>>().and_then(|all| all.into_iter().reduce(f64::max)),
            farthest,
        }
    }

    /// Returns the first distance at which the autocorrelation is 0.2 on a line of distances and values of A.
    fn end(&self, line: impl Iterator<Item = [f64; 2]>) -> Option<f64> {
        let mut before = [0.0, 1.0];
        for [distance, difference] in line {
            let value = self.relative(difference);
            if value <= ENDS {
                let share = (before[1] - ENDS) / (before[1] - value);
                return Some(before[0] + share * (distance - before[0]));
            }
            before = [distance, value];
        }
        None
    }

    /// Returns A at a distance along x, not below zero, and along y, interpolated bilinearly; `None` beyond half a
    /// cell.
    fn at(&self, distance: [f64; 2]) -> Option<f64> {
        let (rows, columns) = self.difference.dim();
        let place = |axis: usize, from: usize, points: usize| {
            let place = distance[axis] / self.spacing[axis] + from as f64;
            if !(0.0..=(points - 1) as f64).contains(&place) {
                return None;
            }
            let below = (place.floor() as usize).min(points.saturating_sub(2));
            Some((below, place - below as f64))
        };
        let ((x, right), (y, up)) = (place(0, 0, rows)?, place(1, self.middle(), columns)?);
        let value = |x: usize, y: usize| self.difference[[x.min(rows - 1), y.min(columns - 1)]];
        let of_row = |x: usize| (1.0 - up) * value(x, y) + up * value(x, y + 1);
        Some((1.0 - right) * of_row(x) + right * of_row(x + 1))
    }

    /// Returns the index of the zero distance along y.
    fn middle(&self) -> usize {
        self.difference.ncols() / 2
    }
}

/// Returns a cell of the same spacing with half as many additional points along each axis.
fn longer(grid: &Grid, half: [usize; 2]) -> Result<Grid, SurfaceError> {
    let ([nx, ny], [dx, dy]) = (grid.points(), grid.spacing());
    let points = [nx + half[0], ny + half[1]];
    let grid = if grid.is_line() {
        Grid::line(points[0], points[0] as f64 * dx)
    } else {
        Grid::new(points, [points[0] as f64 * dx, points[1] as f64 * dy])
    };
    Ok(grid?)
}

fn padded(heights: &ArrayRef2<f64>, [px, py]: [usize; 2]) -> Array2<f64> {
    let mut padded = Array2::zeros([px, py]);
    let (nx, ny) = heights.dim();
    padded.slice_mut(s![..nx, ..ny]).assign(heights);
    padded
}

/// Returns the number of pairs of points at a distance.
fn pairs([nx, ny]: [usize; 2], x: usize, y: i64) -> f64 {
    ((nx - x) * (ny - y.unsigned_abs() as usize)) as f64
}

/// Cumulative sums of squares along x and y, over all points before each one.
struct Squares(Array2<f64>);

impl Squares {
    fn of(heights: &ArrayRef2<f64>) -> Self {
        let (nx, ny) = heights.dim();
        let mut sums = Array2::zeros([nx + 1, ny + 1]);
        for i in 0..nx {
            let mut row = 0.0;
            for j in 0..ny {
                row += heights[[i, j]] * heights[[i, j]];
                sums[[i + 1, j + 1]] = sums[[i, j + 1]] + row;
            }
        }
        Self(sums)
    }

    /// Returns half the mean of h(x)² + h(x+d)² over the pairs of points at a distance d.
    fn over_pairs(&self, x: usize, y: i64) -> f64 {
        let (nx, ny) = (self.0.nrows() - 1, self.0.ncols() - 1);
        let across = y.unsigned_abs() as usize;
        let (near, far) = ([0, ny - across], [across, ny]);
        let (first, second) = if y >= 0 { (near, far) } else { (far, near) };
        let sum = |[from, to]: [usize; 2], [low, high]: [usize; 2]| {
            self.0[[to, high]] - self.0[[from, high]] - self.0[[to, low]] + self.0[[from, low]]
        };
        0.5 * (sum([0, nx - x], first) + sum([x, nx], second)) / pairs([nx, ny], x, y)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Returns heights without symmetry, of any size.
    fn rough(nx: usize, ny: usize) -> Array2<f64> {
        Array2::from_shape_fn((nx, ny), |(i, j)| {
            ((i * 7 + j * 13) % 11) as f64 + (i as f64 * 0.7 + j as f64).sin() + 5.0
        })
    }

    /// Returns A by its definition.
    fn by_pairs(heights: &ArrayRef2<f64>, x: usize, y: i64, repeats: bool) -> f64 {
        let (nx, ny) = heights.dim();
        let (mut sum, mut count) = (0.0, 0);
        for i in 0..nx {
            for j in 0..ny {
                let (a, b) = (i + x, j as i64 + y);
                if repeats || (a < nx && (0..ny as i64).contains(&b)) {
                    let there = heights[[a % nx, b.rem_euclid(ny as i64) as usize]];
                    (sum, count) = (sum + (there - heights[[i, j]]).powi(2), count + 1);
                }
            }
        }
        0.5 * sum / f64::from(count)
    }

    #[test]
    fn differences_are_those_of_all_pairs() {
        for (nx, ny) in [(8, 6), (7, 9), (12, 1), (5, 1)] {
            let grid = if ny == 1 { Grid::line(nx, 2.0) } else { Grid::new([nx, ny], [2.0, 3.0]) }.unwrap();
            let heights = rough(nx, ny);
            for repeats in [true, false] {
                let found = Autocorrelation::of(&heights, &grid, repeats).unwrap();
                for ((x, y), value) in found.difference.indexed_iter() {
                    let wanted = by_pairs(&heights, x, y as i64 - (ny / 2) as i64, repeats);
                    assert!(
                        (value - wanted).abs() < 1e-12 * wanted.max(1.0),
                        "{nx} {ny} {repeats} {x} {y}: {value} {wanted}"
                    );
                }
                let map = found.map();
                assert_eq!(map.dim(), (2 * (nx / 2) + 1, 2 * (ny / 2) + 1));
                let turned = map.slice(s![..;-1, ..;-1]);
                assert!(map.iter().zip(turned).all(|(a, b)| (a - b).abs() < 1e-12));
                assert_eq!(map[[nx / 2, ny / 2]], 0.0);
                assert_eq!(found.along(0)[1][1], found.difference[[1, ny / 2]]);
            }
        }
    }

    #[test]
    fn rings_count_every_distance_once() {
        // Whole rings of a surface that repeats weight all distances equally: the sum over a square lattice is known.
        let grid = Grid::new([8, 8], [8.0, 8.0]).unwrap();
        let found = Autocorrelation::of(&rough(8, 8), &grid, true).unwrap();
        let rings = found.radial();
        let all = (-4..4_i64).flat_map(|x| (-4..4_i64).map(move |y| (x, y)));
        for (ring, [distance, value]) in rings.iter().enumerate() {
            let inside = |(x, y): &(i64, i64)| {
                let length = (*x as f64).hypot(*y as f64);
                length.round() as usize == ring && length <= 4.0
            };
            let own: Vec<(i64, i64)> = all.clone().filter(inside).collect();
            let mean = |value: &dyn Fn(i64, i64) -> f64| {
                own.iter().map(|(x, y)| value(*x, *y)).sum::<f64>() / own.len() as f64
            };
            let wanted = mean(&|x, y| by_pairs(&rough(8, 8), x.rem_euclid(8) as usize, y, true));
            assert!(
                (value - wanted).abs() < 1e-12 && (distance - mean(&|x, y| (x as f64).hypot(y as f64))).abs() < 1e-12
            );
        }
        assert_eq!(rings.len(), 5);
    }

    #[test]
    fn a_wave_ends_where_its_cosine_does() {
        let end = 0.2_f64.acos() / TAU;
        let wave =
            |nx: usize, ny: usize| Array2::from_shape_fn((nx, ny), |(i, _)| (TAU * 4.0 * i as f64 / nx as f64).cos());
        let line = Grid::line(1024, 4.0).unwrap();
        let lengths = Autocorrelation::of(&wave(1024, 1), &line, true).unwrap().lengths();
        assert!((lengths.sal.unwrap() - end).abs() < 1e-5 && lengths.longest.is_none(), "{lengths:?}");
        assert_eq!((lengths.aspect(), lengths.largest_aspect()), (None, Some(lengths.sal.unwrap() / lengths.farthest)));
        // Grooves have no end along y.
        let grid = Grid::new([256, 32], [4.0, 4.0]).unwrap();
        let lengths = Autocorrelation::of(&wave(256, 32), &grid, true).unwrap().lengths();
        assert!((lengths.sal.unwrap() - end).abs() < 1e-3);
        assert!(lengths.longest.is_none());
        assert!(lengths.aspect().is_none());
        let flat = Autocorrelation::of(&Array2::zeros((8, 8)), &Grid::square(8, 1.0).unwrap(), false).unwrap();
        assert!(flat.lengths().sal.is_none() && flat.relative(0.0).is_nan());
        // A tilt over n steps has A = d²/2 and Sq² = (n² − 1)/12.
        let tilt = Array2::from_shape_fn((64, 1), |(i, _)| i as f64);
        let found = Autocorrelation::of(&tilt, &Grid::line(64, 64.0).unwrap(), false).unwrap().lengths();
        assert!((found.sal.unwrap() - (0.8 * 4095.0 / 6.0_f64).sqrt()).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn a_stretched_gaussian_has_its_aspect() {
        // White noise under a Gaussian filter has a Gaussian autocorrelation. A single filter bump makes it exact.
        let grid = Grid::new([256, 512], [1.0, 1.0]).unwrap();
        let bump = |i: usize, n: usize, width: f64| {
            let x = (i as f64 / n as f64 - 0.5) / width;
            (-0.5 * x * x).exp()
        };
        let heights = Array2::from_shape_fn((256, 512), |(i, j)| bump(i, 256, 0.03) * bump(j, 512, 0.06));
        let found = Autocorrelation::of(&heights, &grid, true).unwrap();
        let lengths = found.lengths();
        assert!((lengths.aspect().unwrap() - 0.5).abs() < 1e-3, "{lengths:?}");
        // f = (exp(−d²/4w²) − m)/(1 − m), with m = (mean)²/(mean square) of the bump.
        let m = 4.0 * PI * 0.03 * 0.06;
        let wanted = 2.0 * 0.03 * (-(0.2 * (1.0 - m) + m).ln()).sqrt();
        assert!((lengths.sal.unwrap() / wanted - 1.0).abs() < 1e-3, "{lengths:?} {wanted}");
    }
}
