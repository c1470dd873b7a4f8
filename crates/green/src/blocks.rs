use num_complex::Complex64;

/// 3 × 3 matrix of one wave vector, rows and columns x, y, z.
pub type Matrix3 = [[Complex64; 3]; 3];

/// 2 × 2 matrix of one wave vector in plane strain, rows and columns x, z.
pub type Matrix2 = [[Complex64; 2]; 2];

/// 3 × 3 matrix of one wave vector in the frame of this vector: the sagittal part on (long, z), with `long` along q,
/// and the transverse part (theory.md, sections 1 and 2).
///
/// ```text
///               long              z
///   long  [  longitudinal    i coupling[0]  ]          transverse: one number
///   z     [  i coupling[1]   normal         ]
/// ```
///
/// A stiffness (stress/length) has the coupling `[Kc, −Kc]`, a compliance (length/stress) `[−Gc, Gc]`. The two
/// couplings are independent for the transfer into the body and for the blocks between the two faces of a layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blocks {
    /// Entry along the wave vector.
    pub longitudinal: f64,
    /// Entry along z.
    pub normal: f64,
    /// Entry in the surface, across the wave vector.
    pub transverse: f64,
    /// Entries (long, z) and (z, long), each divided by i.
    pub coupling: [f64; 2],
}

impl Blocks {
    /// Creates a Hermitian matrix with `i coupling` at (long, z).
    pub(crate) fn hermitian(longitudinal: f64, coupling: f64, normal: f64, transverse: f64) -> Self {
        Self { longitudinal, normal, transverse, coupling: [coupling, -coupling] }
    }

    /// Creates a matrix without coupling, with one entry for both lateral directions.
    pub(crate) fn diagonal(lateral: f64, normal: f64) -> Self {
        Self { longitudinal: lateral, normal, transverse: lateral, coupling: [0.0; 2] }
    }

    pub(crate) fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self {
            longitudinal: f(self.longitudinal),
            normal: f(self.normal),
            transverse: f(self.transverse),
            coupling: self.coupling.map(f),
        }
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self {
            longitudinal: self.longitudinal + other.longitudinal,
            normal: self.normal + other.normal,
            transverse: self.transverse + other.transverse,
            coupling: [0, 1].map(|i| self.coupling[i] + other.coupling[i]),
        }
    }

    /// Returns the matrix with z mirrored.
    pub(crate) fn mirrored(self) -> Self {
        Self { coupling: self.coupling.map(|c| -c), ..self }
    }

    /// Returns the inverse of a matrix without coupling. Zero becomes infinite, and infinity becomes zero.
    pub(crate) fn inverse_diagonal(&self) -> Self {
        Self::diagonal(1.0 / self.transverse, 1.0 / self.normal)
    }

    /// Returns the inverse of a Hermitian matrix.
    pub(crate) fn inverse_hermitian(&self) -> Self {
        let coupling = self.coupling[0];
        // Divided by the pivot first: the determinant of a thin slab may overflow although the inverse does not.
        let normal = 1.0 / (self.normal - coupling * (coupling / self.longitudinal));
        let longitudinal = 1.0 / (self.longitudinal - coupling * (coupling / self.normal));
        let mixed = -(coupling / self.longitudinal) * normal;
        Self::hermitian(longitudinal, mixed, normal, 1.0 / self.transverse)
    }

    /// Returns the matrix on (x, y, z), with the wave vector along `direction` = q/|q| (theory.md, section 2).
    pub fn rotated(&self, direction: [f64; 2]) -> Matrix3 {
        let [nx, ny] = direction;
        let real = |value: f64| Complex64::new(value, 0.0);
        let imaginary = |value: f64| Complex64::new(0.0, value);
        let xy = real(nx * ny * (self.longitudinal - self.transverse));
        let [lz, zl] = self.coupling;
        [
            [real(nx * nx * self.longitudinal + ny * ny * self.transverse), xy, imaginary(nx * lz)],
            [xy, real(ny * ny * self.longitudinal + nx * nx * self.transverse), imaginary(ny * lz)],
            [imaginary(nx * zl), imaginary(ny * zl), real(self.normal)],
        ]
    }

    /// Returns the plane-strain matrix on (x, z), with the wave vector along +x, or along −x if `sign` is −1.
    pub(crate) fn plane(&self, sign: f64) -> Matrix2 {
        let [lz, zl] = self.coupling.map(|c| Complex64::new(0.0, sign * c));
        [[Complex64::new(self.longitudinal, 0.0), lz], [zl, Complex64::new(self.normal, 0.0)]]
    }
}

/// Returns the unit vector along `q`, and |q|; `None` at q = 0, which has no direction.
pub(crate) fn direction(q: [f64; 2]) -> Option<([f64; 2], f64)> {
    let wavenumber = q[0].hypot(q[1]);
    (q != [0.0, 0.0]).then(|| (q.map(|component| component / wavenumber), wavenumber))
}

/// Averages the matrix of a Nyquist mode over its aliases ±q_N: entries odd in this component of q vanish (theory.md,
/// section 0). An entry is odd in q_x if its indices contain x an odd number of times.
pub(crate) fn average_aliases<const COLUMNS: usize, const ROWS: usize, const INDICES: usize>(
    matrix: &mut [[Complex64; COLUMNS]; ROWS],
    rows: &[[usize; INDICES]; ROWS],
    nyquist: [bool; 2],
) {
    for axis in (0..2).filter(|&axis| nyquist[axis]) {
        for (entries, indices) in matrix.iter_mut().zip(rows) {
            let in_row = indices.iter().filter(|&&index| index == axis).count();
            for (column, entry) in entries.iter_mut().enumerate() {
                if (in_row + usize::from(column == axis)) % 2 == 1 {
                    *entry = Complex64::ZERO;
                }
            }
        }
    }
}

/// Rows of a vector: x, y, z.
pub(crate) const VECTOR_ROWS: [[usize; 1]; 3] = [[0], [1], [2]];
