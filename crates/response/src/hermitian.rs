use gfmd_green::Matrix3;

/// Hermitian matrix of an isotropic body at one wave vector, with rows and columns x, y, z. The in-plane entries and zz
/// are real; the entries that couple the plane with z are imaginary.
///
/// ```text
///   x  [    xx      xy    i xz ]
///   y  [    xy      yy    i yz ]
///   z  [ −i xz   −i yz      zz ]
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hermitian {
    /// Entry (x, x).
    pub xx: f64,
    /// Entry (y, y).
    pub yy: f64,
    /// Entry (z, z).
    pub zz: f64,
    /// Entries (x, y) and (y, x).
    pub xy: f64,
    /// Entry (x, z), divided by i.
    pub xz: f64,
    /// Entry (y, z), divided by i.
    pub yz: f64,
}

impl Hermitian {
    /// Converts a stiffness or compliance matrix of `gfmd-green`.
    pub fn of(matrix: &Matrix3) -> Self {
        let [x, y, z] = matrix;
        Self { xx: x[0].re, yy: y[1].re, zz: z[2].re, xy: x[1].re, xz: x[2].im, yz: y[2].im }
    }

    /// Creates the diagonal matrix diag(xx, yy, zz).
    pub fn diagonal([xx, yy, zz]: [f64; 3]) -> Self {
        Self { xx, yy, zz, ..Self::default() }
    }

    /// Applies `f` to each entry.
    pub fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let Self { xx, yy, zz, xy, xz, yz } = self;
        Self { xx: f(xx), yy: f(yy), zz: f(zz), xy: f(xy), xz: f(xz), yz: f(yz) }
    }

    /// Returns the eigenvalues in ascending order, each with its normalised eigenvector (a, b, c) for u = (a, b, i c).
    ///
    /// The eigenvectors of a stiffness are the independent modes of one wave vector, and also the eigenvectors of the
    /// update matrix 1 − K Δt² of the dynamics (theory.md, sections 6.1 and 6.2). Computed by Jacobi rotations.
    pub fn modes(self) -> [(f64, [f64; 3]); 3] {
        let Self { xx, yy, zz, xy, xz, yz } = self;
        let mut a = [[xx, xy, -xz], [xy, yy, -yz], [-xz, -yz, zz]];
        let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        // Jacobi rotations converge quadratically; ten sweeps are more than enough for three rows.
        for [p, q] in [[0, 1], [0, 2], [1, 2]].into_iter().cycle().take(30) {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta: f64 = 0.5 * (a[q][q] - a[p][p]) / a[p][q];
            let tangent = 1.0f64.copysign(theta) / (theta.abs() + theta.hypot(1.0));
            let cosine = 1.0 / tangent.hypot(1.0);
            let sine = tangent * cosine;
            for row in &mut a {
                (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
            }
            for k in 0..3 {
                (a[p][k], a[q][k]) = (cosine * a[p][k] - sine * a[q][k], sine * a[p][k] + cosine * a[q][k]);
                let [u, v] = [vectors[p][k], vectors[q][k]];
                (vectors[p][k], vectors[q][k]) = (cosine * u - sine * v, sine * u + cosine * v);
            }
        }
        let mut modes = [0, 1, 2].map(|k| (a[k][k], vectors[k]));
        modes.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        modes
    }

    /// Computes a matrix function: applies `f` to the eigenvalues and keeps the eigenvectors. Used for the critical
    /// damping of all modes of a stiffness.
    pub fn function(self, f: impl Fn(f64) -> f64) -> Self {
        self.modes().into_iter().fold(Self::default(), |sum, (k, [a, b, c])| {
            let part = Self { xx: a * a, yy: b * b, zz: c * c, xy: a * b, xz: -a * c, yz: -b * c };
            let value = f(k);
            sum + part.map(|entry| value * entry)
        })
    }

    /// Inverts a positive definite matrix by its Cholesky factors.
    ///
    /// With u_z = i w, the matrix is real and symmetric; the inversion uses this form.
    pub fn inverse(self) -> Self {
        let Self { xx, yy, zz, xy, xz, yz } = self;
        let (l21, l31) = (xy / xx, -xz / xx);
        let d2 = yy - l21 * xy;
        let l32 = (-yz + l21 * xz) / d2;
        let d3 = zz + l31 * xz - l32 * l32 * d2;
        // The inverse is L⁻ᵀ D⁻¹ L⁻¹.
        let m31 = l21 * l32 - l31;
        let [i1, i2, i3] = [1.0 / xx, 1.0 / d2, 1.0 / d3];
        Self {
            xx: i1 + l21 * l21 * i2 + m31 * m31 * i3,
            yy: i2 + l32 * l32 * i3,
            zz: i3,
            xy: -l21 * i2 - m31 * l32 * i3,
            xz: -m31 * i3,
            yz: l32 * i3,
        }
    }
}

impl std::ops::Add for Hermitian {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            xx: self.xx + other.xx,
            yy: self.yy + other.yy,
            zz: self.zz + other.zz,
            xy: self.xy + other.xy,
            xz: self.xz + other.xz,
            yz: self.yz + other.yz,
        }
    }
}
