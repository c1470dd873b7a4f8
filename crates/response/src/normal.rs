use std::sync::OnceLock;

use gfmd_field::{Grid, Transform};
use gfmd_green::{Body, GreenError, normal_stiffness_table, patch_compliance, restricted_normal_stiffness_table};

use crate::patch_table::{Parity, PatchTable};
use crate::rounded::Rounded;

/// The normal response of a body on one grid: planned transforms, and compliance and stiffness of every mode for
/// problems with u_z and the pressure only. It is built once and shared between problems and threads.
#[derive(Debug)]
pub struct NormalResponse {
    transform: Transform,
    compliance: Vec<f64>,
    /// Tabulated when it is first used, as the contacts with a hard wall do not need it.
    stiffness: OnceLock<Vec<f64>>,
    tabulate: fn(&Body, &Grid, f64) -> Vec<f64>,
    body: Body,
    uniform_compliance: f64,
    stiffness_range: [f64; 2],
    contact_modulus: f64,
    rounded: OnceLock<Rounded>,
}

/// The least entry of the compliance of a patch over the largest.
const LEAST_COMPLIANCE: f64 = 1e-12;

/// A table of stiffnesses with zero for the uniform mode, which is recognised by its index, the first.
fn without_uniform(mut table: Vec<f64>) -> Vec<f64> {
    table[0] = 0.0;
    table
}

impl NormalResponse {
    /// Tabulates the response of `body` on `grid`, with free lateral displacement of the surface.
    pub fn new(grid: Grid, body: &Body) -> Self {
        Self::tabulated(grid, body, normal_stiffness_table)
    }

    /// As [`new`](Self::new), without lateral displacement of the surface: the stiffness is K_N in place of 1/G_zz
    /// (theory.md, section 3, restricted lateral displacement).
    pub fn held_sideways(grid: Grid, body: &Body) -> Self {
        Self::tabulated(grid, body, restricted_normal_stiffness_table)
    }

    fn tabulated(grid: Grid, body: &Body, tabulate: fn(&Body, &Grid, f64) -> Vec<f64>) -> Self {
        let mut compliance = tabulate(body, &grid, 0.0);
        let (softest, stiffest) =
            compliance[1..].iter().fold((f64::INFINITY, 0.0), |(low, high), k| (k.min(low), k.max(high)));
        compliance.iter_mut().for_each(|k| *k = 1.0 / *k);
        // The uniform mode is recognised by its index, the first, never by a small wavenumber.
        compliance[0] = 0.0;
        let [_, uniform] = body.level_compliance();
        Self {
            transform: Transform::new(grid),
            compliance,
            stiffness: OnceLock::new(),
            tabulate,
            body: body.clone(),
            uniform_compliance: uniform,
            stiffness_range: [softest, stiffest],
            contact_modulus: body.contact_modulus(),
            rounded: OnceLock::new(),
        }
    }

    /// The response of a patch that does not repeat (theory.md, section 3.1), on its [padded](Grid::padded) grid: if the traction
    /// vanishes outside of the patch, the displacement inside is that of a surface which is at rest far away. G_zz is the
    /// transform of the compliance between two cells, positive for every mode; the uniform mode has one, too.
    ///
    /// # Errors
    /// A body without a level far away; a patch that cannot be doubled; a table with an entry that is not positive.
    pub fn of_patch(patch: &Grid, body: &Body) -> Result<Self, GreenError> {
        let table = PatchTable::new(patch, patch_compliance(body, patch)?)?;
        let spectrum = table.spectrum(|compliance| *compliance, [Parity::Even; 2]);
        let mut compliance: Vec<f64> = spectrum.iter().map(|mode| mode.re).collect();
        let [softest, stiffest] =
            [f64::max, f64::min].map(|pick| compliance.iter().copied().reduce(pick).unwrap_or(0.0));
        // Below, an entry would be a rounding error of the largest.
        let is_resolved = stiffest > LEAST_COMPLIANCE * softest;
        if !is_resolved {
            return Err(GreenError::PatchStiffness { least: stiffest, largest: softest });
        }
        let stiffness = compliance.iter().map(|g| 1.0 / g).collect();
        let uniform_compliance = std::mem::take(&mut compliance[0]);
        Ok(Self {
            transform: table.transform,
            compliance,
            stiffness: OnceLock::from(without_uniform(stiffness)),
            tabulate: normal_stiffness_table,
            body: body.clone(),
            uniform_compliance,
            stiffness_range: [1.0 / softest, 1.0 / stiffest],
            contact_modulus: body.contact_modulus(),
            rounded: OnceLock::new(),
        })
    }

    /// The grid of the surface.
    pub fn grid(&self) -> &Grid {
        self.transform.grid()
    }

    /// The planned transforms of the grid, used by [`NormalTransforms`](crate::NormalTransforms).
    pub(crate) fn transform(&self) -> &Transform {
        &self.transform
    }

    /// The response in single precision, tabulated when it is first used.
    pub(crate) fn rounded(&self) -> &Rounded {
        let Self { transform, compliance, stiffness_range: [softest, _], rounded, .. } = self;
        rounded.get_or_init(|| Rounded::of(*transform.grid(), compliance, *softest))
    }

    /// G_zz(q) in length/stress, laid out as [`Grid::modes`]; 0 at q = 0, see
    /// [`uniform_compliance`](Self::uniform_compliance).
    pub fn compliance(&self) -> &[f64] {
        &self.compliance
    }

    /// 1/G_zz(q) in stress/length, laid out as [`Grid::modes`]; 0 at q = 0.
    pub fn stiffness(&self) -> &[f64] {
        self.stiffness.get_or_init(|| without_uniform((self.tabulate)(&self.body, self.grid(), 0.0)))
    }

    /// E* of the body, in stress; of two bodies 1/(1/E₁* + 1/E₂*).
    pub fn contact_modulus(&self) -> f64 {
        self.contact_modulus
    }

    /// G_zz(0) in length/stress, against the mean level of what does not hold the body ([`Body::level_compliance`]): height
    /// over P-wave modulus, summed over slabs and layers; 0 for a half-space (whose surface has a fixed mean level,
    /// theory.md, section 7) and for an incompressible slab.
    pub fn uniform_compliance(&self) -> f64 {
        self.uniform_compliance
    }

    /// Smallest and largest stiffness 1/G_zz of the modes q ≠ 0, in stress/length.
    pub fn stiffness_range(&self) -> [f64; 2] {
        self.stiffness_range
    }
}
