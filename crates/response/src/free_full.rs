use std::sync::Arc;

use gfmd_field::{Convolution, Grid, Share, Transform};
use gfmd_green::{Body, GreenError, PatchMatrix, patch_compliance, patch_matrix, stiffness_range};

use crate::elastic::fits;
use crate::patch_table::Parity::{Even, Odd};
use crate::patch_table::PatchTable;
use crate::{Components, FullResponse, Hermitian, Operator, Workspace};

/// Compliance of a non-periodic patch for all components of its surface; the counterpart of
/// [`FreeCompliance`](crate::FreeCompliance) (theory.md, section 3.1). Built once and shared between problems and
/// threads. Each process has its own rows of all fields.
#[derive(Debug)]
pub struct FreeFullCompliance {
    patch: Grid,
    /// Compliance on the padded grid, for fields on the patch.
    compliance: Operator,
    normal: Arc<Convolution>,
    stiffness_range: [f64; 2],
    body: Body,
}

impl FreeFullCompliance {
    /// Tabulates the compliance of `body` on the two-dimensional grid of the `patch`.
    ///
    /// # Errors
    /// Returns an error of [`patch_matrix`], or if the doubled patch has more points than memory can address.
    pub fn new(patch: Grid, body: &Body) -> Result<Self, GreenError> {
        Self::distributed(patch, body, &patch.whole())
    }

    /// Tabulates the compliance of `body` on the grid of the `patch` for the `share` of rows of this process.
    ///
    /// # Errors
    /// Returns an error as [`new`](Self::new), and if the processes cannot share the doubled patch.
    pub fn distributed(patch: Grid, body: &Body, share: &Share) -> Result<Self, GreenError> {
        let (.., matrices) = padded_compliance(2, share, &patch, body)?;
        let compliance = Operator::of_matrices(Transform::padded(2, &patch, share)?, share, matrices);
        let range = stiffness_range(body, &patch).map_or([0.0; 2], |range| [range.softest, range.stiffest]);
        let normal = Convolution::distributed(patch, share, patch_compliance(body, &patch)?).into();
        Ok(Self { patch, compliance, normal, stiffness_range: range, body: body.clone() })
    }

    /// Returns the grid of the patch.
    pub fn grid(&self) -> &Grid {
        &self.patch
    }

    /// Returns the components of displacement and traction.
    pub fn components(&self) -> Components {
        self.compliance.components()
    }

    /// Returns the compliance for pressures alone, which gives the downward displacement.
    pub fn normal(&self) -> &Arc<Convolution> {
        &self.normal
    }

    /// Returns E* of the body, in stress; 1/(1/E₁* + 1/E₂*) for two bodies.
    pub fn contact_modulus(&self) -> f64 {
        self.body.contact_modulus()
    }

    /// Tabulates the response of the cell of this patch ([`FullResponse::of_patch_over`]), with a stiffness, for the
    /// `share` of rows of this process.
    ///
    /// # Errors
    /// Returns an error if a mode of the cell is not positive definite.
    pub fn cell(&self, share: &Share) -> Result<FullResponse, GreenError> {
        FullResponse::of_patch_over(share, &self.patch, &self.body)
    }

    /// Returns the smallest and largest stiffness in a periodic cell of the size of the patch, in stress/length.
    pub fn stiffness_range(&self) -> [f64; 2] {
        self.stiffness_range
    }
}

/// Tabulates the compliance of `body` on a padded grid with `times` the points of a `patch`, exact between points of
/// the patch, for the modes of this process. Returns the transforms of the padded grid and its rows of this process,
/// too.
///
/// # Errors
/// Returns an error as [`FreeFullCompliance::new`].
pub(crate) fn padded_compliance(
    times: usize,
    share: &Share,
    patch: &Grid,
    body: &Body,
) -> Result<(Transform, Share, Vec<Hermitian>), GreenError> {
    let table = PatchTable::padded_to(times, patch, share, patch_matrix(body, patch)?)?;
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
    let matrices = (0..xx.len()).map(of_mode).collect();
    Ok((table.transform, table.share, matrices))
}

/// Transforms of a [`FreeFullCompliance`], with their memory and a counter.
///
/// # Panics
/// Every method panics if a field does not have the size of the patch times the number of its components.
#[derive(Debug)]
pub struct FreeFullTransforms {
    response: Arc<FreeFullCompliance>,
    workspace: Workspace,
    pairs: u64,
}

impl FreeFullTransforms {
    /// Allocates memory for transforms on the grid of `response`, with the counter at zero.
    pub fn of(response: &Arc<FreeFullCompliance>) -> Self {
        Self { response: Arc::clone(response), workspace: response.compliance.workspace(), pairs: 0 }
    }

    /// Computes displacement = G traction, both on the patch.
    pub fn compliance(&mut self, traction: &[f64], displacement: &mut [f64]) {
        self.pairs += self.response.components().len() as u64;
        fits(self.response.compliance.apply(traction, displacement, &mut self.workspace));
    }

    /// Computes the lateral displacement caused by a lateral traction: u_x, u_y from t_x, t_y, both on the patch.
    pub fn lateral_compliance(&mut self, traction: &[f64], displacement: &mut [f64]) {
        self.pairs += self.response.components().len() as u64 - 1;
        fits(self.response.compliance.apply_laterally(traction, displacement, &mut self.workspace));
    }

    /// Returns the number of pairs of forward and inverse transforms of one padded component so far.
    pub fn pairs(&self) -> f64 {
        self.pairs as f64
    }
}
