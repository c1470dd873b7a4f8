use gfmd_green::Material;

/// Strain and stress on one plane of a body, point by point, in the memory of a [`Workspace`](crate::Workspace).
#[derive(Clone, Copy, Debug)]
pub struct Deformation<'w> {
    pub(crate) material: Material,
    /// Fields ε_xx, ε_yy, γ_xy, σ_zz, σ_yz, σ_xz; those that vanish on a line are empty.
    pub(crate) fields: [&'w [f64]; 6],
}

/// Strain and stress at one point, with components xx, yy, zz, yz, xz, xy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Strain, dimensionless; shear components are engineering strains γ_ij = ∂_i u_j + ∂_j u_i.
    pub strain: [f64; 6],
    /// Stress, positive in tension.
    pub stress: [f64; 6],
    shear_modulus: f64,
}

impl Deformation<'_> {
    /// Returns the material at this plane.
    pub fn material(&self) -> &Material {
        &self.material
    }

    /// Returns the number of points.
    #[expect(clippy::len_without_is_empty, reason = "a grid is never empty")]
    pub fn len(&self) -> usize {
        self.fields[0].len()
    }

    /// Returns the state at point `index` of the grid.
    ///
    /// Stress follows from lateral strain and normal stress, which are both finite at ν = 1/2 (theory.md, section 5).
    ///
    /// # Panics
    /// If there is no such point.
    pub fn at(&self, index: usize) -> State {
        let on_a_plane = |field: &[f64]| if field.is_empty() { 0.0 } else { field[index] };
        let [exx, eyy, gxy, zz, yz, xz] = self.fields.map(on_a_plane);
        let shear_modulus = self.material.shear_modulus();
        let ezz = self.material.normal_strain([exx, eyy], zz);
        let lateral = |strain: f64| zz + 2.0 * shear_modulus * (strain - ezz);
        State {
            strain: [exx, eyy, ezz, yz / shear_modulus, xz / shear_modulus, gxy],
            stress: [lateral(exx), lateral(eyy), zz, yz, xz, shear_modulus * gxy],
            shear_modulus,
        }
    }
}

impl State {
    /// Returns the von Mises stress √(3 s_ij s_ij / 2), where s is the deviator of the stress.
    ///
    /// It is computed from the strains, since the normal stresses of a nearly incompressible body differ by little.
    pub fn von_mises(&self) -> f64 {
        let [xx, yy, zz, yz, xz, xy] = self.strain;
        let stretch = (xx - yy).powi(2) + (yy - zz).powi(2) + (zz - xx).powi(2);
        self.shear_modulus * (2.0 * stretch + 3.0 * (yz * yz + xz * xz + xy * xy)).sqrt()
    }

    /// Returns the elastic energy per volume, ½ σ_ij ε_ij, in stress.
    pub fn energy_density(&self) -> f64 {
        0.5 * self.stress.iter().zip(self.strain).map(|(stress, strain)| stress * strain).sum::<f64>()
    }
}
