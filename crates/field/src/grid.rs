use std::f64::consts::TAU;

use gfmd_vector::Share;
use num_complex::Complex64;

/// Periodic rectangular cell and the points on it: point `[i, j]` lies at `(i Lx/nx, j Ly/ny)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    points: [usize; 2],
    lengths: [f64; 2],
}

/// One Fourier mode of the stored half spectrum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mode {
    /// Integer wave numbers (m, n): `−⌊nx/2⌋ ≤ m ≤ ⌈nx/2⌉−1`, likewise n. The number along the halved axis is never
    /// negative, except at Nyquist, where it is `−n/2` as in the full spectrum.
    pub number: [i64; 2],
    /// Wave vector `(2π m/Lx, 2π n/Ly)` in rad/length.
    pub wavevector: [f64; 2],
    /// Number of modes of the full spectrum that this mode represents: 2, or 1 at zero and Nyquist of the halved axis.
    pub weight: f64,
    /// True where m (n) is the Nyquist number of an even axis; kernel entries odd in that component of q must vanish
    /// there (theory.md, section 0).
    pub nyquist: [bool; 2],
}

impl Mode {
    /// Returns the wavenumber |q| in rad/length.
    pub fn wavenumber(&self) -> f64 {
        self.wavevector[0].hypot(self.wavevector[1])
    }

    /// Returns true for the uniform mode q = 0, identified by its numbers and never by a small wavenumber.
    pub fn is_uniform(&self) -> bool {
        self.number == [0, 0]
    }

    /// Iterates over the wave vectors that the grid cannot distinguish from this one: a Nyquist component takes both
    /// signs.
    pub fn aliases(&self) -> impl Iterator<Item = [f64; 2]> + use<> {
        let ([x, y], [nyquist_x, nyquist_y]) = (self.wavevector, self.nyquist);
        let signs = |nyquist: bool| if nyquist { &[1.0, -1.0][..] } else { &[1.0][..] };
        signs(nyquist_x).iter().flat_map(move |a| signs(nyquist_y).iter().map(move |b| [a * x, b * y]))
    }

    /// Returns true if −q is the same mode as q, so that its amplitude is real: all components are zero or Nyquist.
    pub fn is_self_conjugate(&self) -> bool {
        (0..2).all(|axis| self.number[axis] == 0 || self.nyquist[axis])
    }
}

/// Error of an unusable grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GridError {
    /// Axis without points.
    #[error("the grid has {0:?} points; each axis must have at least one")]
    NoPoints([usize; 2]),
    /// More points than memory can address.
    #[error("the grid has {found:?} points; their product must be at most {most}")]
    TooManyPoints {
        /// Points along x and along y.
        found: [usize; 2],
        /// Largest total number of points.
        most: usize,
    },
    /// Length that is zero, negative or not finite.
    #[error("the cell lengths are {0:?}; they must be positive and finite")]
    Length([f64; 2]),
}

/// Largest number of points: one complex number per point, more than a half spectrum needs, is the largest slice that a
/// program can address.
const MOST_POINTS: usize = isize::MAX as usize / size_of::<Complex64>();

impl Grid {
    /// Creates a cell of `lengths` (Lx, Ly) with `points` (nx, ny).
    ///
    /// # Errors
    /// Returns an error if an axis has no points, memory cannot address all points, or a length is unusable.
    pub fn new(points: [usize; 2], lengths: [f64; 2]) -> Result<Self, GridError> {
        if points.contains(&0) {
            return Err(GridError::NoPoints(points));
        }
        if points[0].checked_mul(points[1]).is_none_or(|all| all > MOST_POINTS) {
            return Err(GridError::TooManyPoints { found: points, most: MOST_POINTS });
        }
        if !lengths.iter().all(|l| l.is_finite() && *l > 0.0) {
            return Err(GridError::Length(lengths));
        }
        Ok(Self { points, lengths })
    }

    /// Creates a square cell with the same number of points along both axes.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn square(points: usize, length: f64) -> Result<Self, GridError> {
        Self::new([points, points], [length, length])
    }

    /// Creates a line of points along x, the profile of a plane-strain problem. The length along y is one.
    ///
    /// # Errors
    /// As [`Grid::new`].
    pub fn line(points: usize, length: f64) -> Result<Self, GridError> {
        Self::new([points, 1], [length, 1.0])
    }

    /// Returns the same cell with lengths in units of `unit`, a positive number. The extent of a line along y remains
    /// one unit. A side that under- or overflows in this unit becomes the smallest or the largest number.
    pub fn in_units(&self, unit: f64) -> Self {
        let [lx, ly] = self.lengths.map(|length| (length / unit).clamp(f64::from_bits(1), f64::MAX));
        Self { points: self.points, lengths: [lx, if self.is_line() { self.lengths[1] } else { ly }] }
    }

    /// Returns the numbers of points (nx, ny), the shape of a field.
    pub fn points(&self) -> [usize; 2] {
        self.points
    }

    /// Returns the cell lengths (Lx, Ly).
    pub fn lengths(&self) -> [f64; 2] {
        self.lengths
    }

    /// Returns the distance between neighbouring points along x and along y.
    pub fn spacing(&self) -> [f64; 2] {
        [0, 1].map(|axis| self.lengths[axis] / self.points[axis] as f64)
    }

    /// Returns the number of points.
    #[expect(clippy::len_without_is_empty, reason = "a grid is never empty")]
    pub fn len(&self) -> usize {
        self.points[0] * self.points[1]
    }

    /// Returns the numbers of rows and of points per row. A grid with one point along an axis is a single row.
    pub fn rows(&self) -> [usize; 2] {
        if self.points.contains(&1) { [1, self.len()] } else { self.points }
    }

    /// Returns the partition for a single process: all rows.
    pub fn whole(&self) -> Share {
        let [rows, columns] = self.rows();
        Share::whole(rows, columns)
    }

    /// Returns true for a line along x (one point along y).
    pub fn is_line(&self) -> bool {
        self.points[1] == 1
    }

    /// Returns the axis along which the half spectrum has only non-negative wave numbers: y, or x for a line.
    pub fn halved_axis(&self) -> usize {
        usize::from(!self.is_line())
    }

    /// Returns the shape of the half spectrum, `[lanes, modes per lane]`: `[ny/2 + 1, nx]` (transposed: x is
    /// contiguous), or `[1, nx/2 + 1]` for a line.
    pub fn spectrum_shape(&self) -> [usize; 2] {
        let [nx, ny] = self.points;
        if self.is_line() { [1, nx / 2 + 1] } else { [ny / 2 + 1, nx] }
    }

    /// Returns the number of modes in the half spectrum.
    pub fn spectrum_len(&self) -> usize {
        self.spectrum_shape().iter().product()
    }

    /// Returns the mode at `[lane, position]` of the half spectrum.
    pub fn mode(&self, lane: usize, position: usize) -> Mode {
        let index = if self.is_line() { [position, 0] } else { [position, lane] };
        let halved = self.halved_axis();
        let nyquist = [0, 1].map(|axis| self.points[axis].is_multiple_of(2) && index[axis] == self.points[axis] / 2);
        let number = [0, 1].map(|axis| {
            let (n, k) = (self.points[axis] as i64, index[axis] as i64);
            if 2 * k >= n && n > 1 { k - n } else { k }
        });
        let wavevector = [0, 1].map(|axis| TAU * number[axis] as f64 / self.lengths[axis]);
        let alone = index[halved] == 0 || nyquist[halved];
        Mode { number, wavevector, weight: if alone { 1.0 } else { 2.0 }, nyquist }
    }

    /// Returns mode `index` of the half spectrum in storage order, at `[index / positions, index % positions]`.
    pub fn mode_at(&self, index: usize) -> Mode {
        let [_, positions] = self.spectrum_shape();
        self.mode(index / positions, index % positions)
    }

    /// Returns the index of the mode with wave numbers `number` in the half spectrum, the inverse of [`Self::mode_at`];
    /// `None` if the half spectrum does not contain it, though it may contain the opposite mode.
    pub fn index_of(&self, number: [i64; 2]) -> Option<usize> {
        let [lanes, positions] = self.spectrum_shape();
        let [x, y] = [0, 1].map(|axis| number[axis].rem_euclid(self.points[axis] as i64) as usize);
        let [lane, position] = if self.is_line() { [0, x] } else { [y, x] };
        let held = lane < lanes && position < positions && self.mode(lane, position).number == number;
        held.then(|| lane * positions + position)
    }

    /// Iterates over all modes of the half spectrum in storage order.
    pub fn modes(&self) -> impl Iterator<Item = Mode> + '_ {
        self.modes_from(0)
    }

    /// Iterates over the modes of the half spectrum in storage order from mode `start` on.
    pub fn modes_from(&self, start: usize) -> impl Iterator<Item = Mode> + '_ {
        let [lanes, positions] = self.spectrum_shape();
        let (first, skipped) = (start / positions, start % positions);
        let from = move |lane: usize| if lane == first { skipped } else { 0 };
        (first..lanes).flat_map(move |lane| (from(lane)..positions).map(move |position| self.mode(lane, position)))
    }
}
