use num_complex::Complex64;

use crate::{Blocks, Body, GreenError, Material, Matrix2, Matrix3, body::on_axes, slab::LayerMode};

/// Layer with two moving faces and all components, the starting point for a base with a prescribed displacement or
/// traction (theory.md, section 4). Contacts over a moving base use `gfmd_body::BaseField`, and slabs between two
/// surfaces use [`Plate`](crate::Plate); this type is for other problems.
///
/// The matrix L maps the displacements of top and bottom to the outward tractions on top and bottom; on the bottom, the
/// traction is −(σ_xz, σ_yz, σ_zz). L is Hermitian, and positive definite for q ≠ 0. At q = 0, rigid translations cost
/// no energy, and the zz entries are infinite if ν = 1/2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    material: Material,
    thickness: f64,
}

impl Layer {
    /// Creates a layer of `thickness` (length).
    ///
    /// # Errors
    /// Returns an error if the thickness is not positive and finite.
    pub fn new(material: Material, thickness: f64) -> Result<Self, GreenError> {
        Body::slab(material, thickness)?;
        Ok(Self { material, thickness })
    }

    /// Returns the block L_tt at |q| = `q` (rad/length), in stress/length: traction on the top per displacement of the
    /// top, the stiffness of the slab on a bonded base.
    pub fn top_blocks(&self, q: f64) -> Blocks {
        let q = q.abs();
        if q == 0.0 { self.uniform() } else { self.mode(q).bonded_stiffness() }
    }

    /// Returns the block L_bb at |q| = `q`: traction on the bottom per displacement of the bottom, equal to L_tt with
    /// reversed coupling.
    pub fn bottom_blocks(&self, q: f64) -> Blocks {
        self.top_blocks(q).mirrored()
    }

    /// Returns the block L_tb at |q| = `q`: traction on the top per displacement of the bottom. L_bt is its adjoint.
    pub fn cross_blocks(&self, q: f64) -> Blocks {
        let q = q.abs();
        if q == 0.0 { self.uniform().map(|entry| -entry) } else { self.mode(q).cross_stiffness() }
    }

    /// Returns the matrix L of the wave vector `q` (rad/length), in stress/length, with rows and columns x, y, z of the
    /// top, then of the bottom.
    pub fn matrix(&self, q: [f64; 2]) -> [[Complex64; 6]; 6] {
        let tt: Matrix3 = on_axes(q, |q| self.top_blocks(q));
        let bb: Matrix3 = on_axes(q, |q| self.bottom_blocks(q));
        let tb: Matrix3 = on_axes(q, |q| self.cross_blocks(q));
        let mut matrix = [[Complex64::ZERO; 6]; 6];
        for row in 0..3 {
            for column in 0..3 {
                matrix[row][column] = tt[row][column];
                matrix[row + 3][column + 3] = bb[row][column];
                matrix[row][column + 3] = tb[row][column];
                matrix[column + 3][row] = tb[row][column].conj();
            }
        }
        matrix
    }

    /// Returns the plane-strain matrix L of the wave vector `q` along x (either sign), in stress/length, with rows and
    /// columns x, z of the top, then of the bottom.
    pub fn plane_matrix(&self, q: f64) -> [[Complex64; 4]; 4] {
        let on_plane = |blocks: Blocks| -> Matrix2 { blocks.plane(q.signum()) };
        let (tt, bb) = (on_plane(self.top_blocks(q)), on_plane(self.bottom_blocks(q)));
        let tb = on_plane(self.cross_blocks(q));
        let mut matrix = [[Complex64::ZERO; 4]; 4];
        for row in 0..2 {
            for column in 0..2 {
                matrix[row][column] = tt[row][column];
                matrix[row + 2][column + 2] = bb[row][column];
                matrix[row][column + 2] = tb[row][column];
                matrix[column + 2][row] = tb[row][column].conj();
            }
        }
        matrix
    }

    fn mode(&self, q: f64) -> LayerMode<'_> {
        LayerMode::new(&self.material, self.thickness, q)
    }

    /// Returns the stiffness of the uniform mode, C44/thickness laterally and C11/thickness normally.
    fn uniform(&self) -> Blocks {
        let normal = 1.0 / (self.thickness * self.material.p_wave_compliance());
        Blocks::diagonal(self.material.shear_modulus() / self.thickness, normal)
    }
}

impl LayerMode<'_> {
    /// Returns the block L_tb, traction on the top per displacement of the bottom (theory.md, section 4).
    pub(crate) fn cross_stiffness(&self) -> Blocks {
        let (m, t) = (self.material, &self.t);
        let rh = m.r() * t.raw;
        let [minus, plus] = if self.is_thin() {
            let half = (0.5 * t.raw).sinh();
            let bent = rh * 2.0 * half * half;
            [m.one_minus_r() * t.h + (t.sinh_minus_h - bent), m.one_plus_r() * t.h + (t.sinh_minus_h + bent)]
        } else {
            [t.sinh - rh * t.cosh, t.sinh + rh * t.cosh]
        };
        let (determinant, unit) = (self.bonded_determinant(), self.unit());
        let cross = |numerator: f64| unit * (t.factor * numerator / determinant);
        Blocks {
            longitudinal: -cross(minus),
            normal: -cross(plus),
            transverse: -self.shear_unit() * t.csch(),
            coupling: [cross(rh * t.sinh); 2],
        }
    }
}
