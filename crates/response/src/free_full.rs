use std::sync::Arc;

use gfmd_field::{Convolution, Grid};
use gfmd_green::{Body, GreenError, PatchMatrix, patch_compliance, patch_matrix, stiffness_range};

use crate::elastic::fits;
use crate::patch_table::Parity::{Even, Odd};
use crate::patch_table::PatchTable;
use crate::{Components, Hermitian, Operator, Workspace};

/// The compliance of a patch that does not repeat, for all components of its surface: the counterpart of
/// [`FreeCompliance`](crate::FreeCompliance) (theory.md, section 3.1). It is built once and shared between problems and threads.
#[derive(Debug)]
pub struct FreeFullCompliance {
    patch: Grid,
    /// On the padded grid.
    compliance: Operator,
    normal: Arc<Convolution>,
    stiffness_range: [f64; 2],
    contact_modulus: f64,
}

impl FreeFullCompliance {
    /// Tabulates the compliance of `body` on the grid of the `patch`, a surface.
    ///
    /// # Errors
    /// As [`patch_matrix`]; a patch with more points than memory can address when it is doubled.
    pub fn new(patch: Grid, body: &Body) -> Result<Self, GreenError> {
        let table = PatchTable::new(&patch, patch_matrix(body, &patch)?)?;
        let [xx, yy, zz] = [|m: &PatchMatrix| m.xx, |m: &PatchMatrix| m.yy, |m: &PatchMatrix| m.zz]
            .map(|of| table.spectrum(of, [Even, Even]));
        let xy = table.spectrum(|m| m.xy, [Odd, Odd]);
        let xz = table.spectrum(|m| m.xz, [Odd, Even]);
        let yz = table.spectrum(|m| m.yz, [Even, Odd]);
        let of_mode = |at: usize| Hermitian {
            xx: xx[at].re,
            yy: yy[at].re,
            zz: zz[at].re,
            xy: xy[at].re,
            xz: xz[at].im,
            yz: yz[at].im,
        };
        let compliance = Operator::of_matrices(table.transform, (0..xx.len()).map(of_mode).collect());
        let range = stiffness_range(body, &patch).map_or([0.0; 2], |range| [range.softest, range.stiffest]);
        let normal = Convolution::new(patch, patch_compliance(body, &patch)?).into();
        Ok(Self { patch, compliance, normal, stiffness_range: range, contact_modulus: body.contact_modulus() })
    }

    /// The grid of the patch.
    pub fn grid(&self) -> &Grid {
        &self.patch
    }

    /// The components of displacement and traction.
    pub fn components(&self) -> Components {
        self.compliance.components()
    }

    /// The compliance for pressures alone: the displacement downwards.
    pub fn normal(&self) -> &Arc<Convolution> {
        &self.normal
    }

    /// E* of the body, in stress; of two bodies 1/(1/E₁* + 1/E₂*).
    pub fn contact_modulus(&self) -> f64 {
        self.contact_modulus
    }

    /// Smallest and largest stiffness of the waves of a periodic cell of the size of the patch, in stress/length.
    pub fn stiffness_range(&self) -> [f64; 2] {
        self.stiffness_range
    }
}

/// The transforms of a [`FreeFullCompliance`], with their memory and a counter.
///
/// # Panics
/// Every method panics if a field does not have the size of the patch times the number of components.
#[derive(Debug)]
pub struct FreeFullTransforms {
    response: Arc<FreeFullCompliance>,
    workspace: Workspace,
    /// Traction and displacement on the padded grid.
    padded: [Vec<f64>; 2],
    pairs: u64,
}

impl FreeFullTransforms {
    /// Memory for transforms on the grid of `response`; none is counted yet.
    pub fn of(response: &Arc<FreeFullCompliance>) -> Self {
        let FreeFullCompliance { compliance, .. } = &**response;
        let size = compliance.components().len() * compliance.grid().len();
        let padded = [vec![0.0; size], vec![0.0; size]];
        Self { response: Arc::clone(response), workspace: compliance.workspace(), padded, pairs: 0 }
    }

    /// Displacement ← G traction, both on the patch.
    pub fn compliance(&mut self, traction: &[f64], displacement: &mut [f64]) {
        let Self { response, workspace, padded: [around, moved], pairs } = self;
        let FreeFullCompliance { patch, compliance, .. } = &**response;
        *pairs += compliance.components().len() as u64;
        let ([nx, ny], [_, wide], all) = (patch.points(), compliance.grid().points(), compliance.grid().len());
        for (field, values) in around.chunks_exact_mut(all).zip(traction.chunks_exact(nx * ny)) {
            let rows = field.chunks_exact_mut(wide).zip(values.chunks_exact(ny));
            rows.for_each(|(row, values)| row[..ny].copy_from_slice(values));
        }
        fits(compliance.apply(around, moved, workspace));
        for (field, values) in moved.chunks_exact(all).zip(displacement.chunks_exact_mut(nx * ny)) {
            let rows = field.chunks_exact(wide).zip(values.chunks_exact_mut(ny));
            rows.for_each(|(row, values)| values.copy_from_slice(&row[..ny]));
        }
    }

    /// Forward and inverse transforms of one component so far, in pairs, of padded fields.
    pub fn pairs(&self) -> f64 {
        self.pairs as f64
    }
}

#[cfg(test)]
mod tests {
    use gfmd_green::Material;

    use super::*;
    use crate::{FullResponse, FullTransforms};

    /// Far from the ends of a wide cell it does not matter what surrounds the patch, if the tractions have neither force nor
    /// moment. A periodic surface sees bands of waves in place of cells, which differ little for smooth tractions.
    #[test]
    fn smooth_tractions_without_force_move_a_patch_as_a_wide_periodic_surface() {
        let (n, wide) = (40, 240);
        let material = Material::from_young(1.0, 0.1).unwrap();
        for body in [
            Body::half_space(material),
            Body::half_space(material).against(Body::half_space(Material::from_young(3.0, 0.45).unwrap())),
        ] {
            let [patch, cell] = [n, wide].map(|n| Grid::new([n, n], [n as f64, 1.2 * n as f64]).unwrap());
            let mut free = FreeFullTransforms::of(&FreeFullCompliance::new(patch, &body).unwrap().into());
            let mut periodic = FullTransforms::of(&FullResponse::new(cell, &body).into());
            // The fourth difference of a bump along x, and the second along y.
            let bump = |i: f64, j: f64| (-(i * i + j * j) / 16.0).exp();
            let traction = |i: f64, j: f64| {
                let along = |j: f64| bump(i - 6.0, j) - 2.0 * bump(i, j) + bump(i + 6.0, j);
                along(j - 6.0) - 2.0 * along(j) + along(j + 6.0)
            };
            for loaded in 0..3 {
                let field = |n: usize| {
                    let middle = |i: usize| i as f64 - n as f64 / 2.0;
                    let mut all = vec![0.0; 3 * n * n];
                    for (at, value) in all[loaded * n * n..][..n * n].iter_mut().enumerate() {
                        *value = traction(middle(at / n), middle(at % n));
                    }
                    all
                };
                let (mut found, mut wanted) = (vec![0.0; 3 * n * n], vec![0.0; 3 * wide * wide]);
                free.compliance(&field(n), &mut found);
                periodic.compliance(&field(wide), &mut wanted);
                let largest = wanted.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
                for component in 0..3 {
                    for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                        let [i_wide, j_wide] = [i, j].map(|k| k + wide / 2 - n / 2);
                        let u = found[(component * n + i) * n + j];
                        let v = wanted[(component * wide + i_wide) * wide + j_wide];
                        assert!((u - v).abs() < 0.02 * largest, "{loaded} {component} {i} {j}: {u} {v}");
                    }
                }
            }
        }
    }

    #[test]
    fn the_matrix_is_symmetric_and_a_line_is_refused() {
        let material = Material::from_young(2.0, 0.2).unwrap();
        let body = Body::half_space(material);
        let grid = Grid::new([5, 4], [1.0, 0.7]).unwrap();
        let response = Arc::new(FreeFullCompliance::new(grid, &body).unwrap());
        let size = 3 * grid.len();
        let matrix: Vec<Vec<f64>> = (0..size).map(|k| column_of(&response, k)).collect();
        for (i, j) in (0..size).flat_map(|i| (0..i).map(move |j| (i, j))) {
            assert!((matrix[i][j] - matrix[j][i]).abs() < 1e-14, "{i} {j}");
        }
        // At the centre of a square cell G_xx is (1 − ν/2)/(1 − ν) of G_zz.
        let square = FreeFullCompliance::new(Grid::square(3, 1.0).unwrap(), &body).unwrap().into();
        let [xx, zz] = [4, 2 * 9 + 4].map(|k| column_of(&square, k)[k]);
        assert!((xx / zz - 0.9 / 0.8).abs() < 1e-14);
        let line = Grid::line(8, 1.0).unwrap();
        assert_eq!(FreeFullCompliance::new(line, &body).err(), Some(GreenError::LineShear));
    }

    fn column_of(response: &Arc<FreeFullCompliance>, k: usize) -> Vec<f64> {
        let size = 3 * response.grid().len();
        let (mut unit, mut out) = (vec![0.0; size], vec![0.0; size]);
        unit[k] = 1.0;
        FreeFullTransforms::of(response).compliance(&unit, &mut out);
        out
    }
}
