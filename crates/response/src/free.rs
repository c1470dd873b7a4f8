use std::sync::Arc;

use gfmd_field::{Convolution, CosineWorkspace, Cosines, Grid};
use gfmd_green::{Body, GreenError, patch_compliance};
use gfmd_vector::for_each;

use crate::elastic::fits;

/// The compliance of a patch of a half-space that does not repeat: the pressure is constant on the cell around every point
/// of the grid and zero outside of the patch, and the displacement is that of the points, zero far away (theory.md,
/// section 3.1). It is built once and shared between problems and threads.
///
/// Its inverse, the stiffness, is known approximately: in cosine waves, whose stiffness is the inverse of the mean compliance
/// of the wave on the patch, between weights that raise the stiffness towards the edges, where the pressure of a given
/// displacement is largest.
#[derive(Debug)]
pub struct FreeCompliance {
    convolution: Convolution,
    cosines: Cosines,
    /// One value for each cosine wave.
    stiffness: Vec<f64>,
    /// For each row, and for each point of a row.
    weights: [Vec<f64>; 2],
    /// The pressure of a uniform displacement over its sum.
    uniform: Vec<f64>,
}

/// The excess of the weight one cell from the edge, and the power with which it falls with the distance. The eigenvalues of
/// the approximate stiffness times the compliance, before the [`FACTOR`], are then between 0.7 and 1.4 on 256² points (without
/// weights 0.47 and 1.3). The lowest falls with the logarithm of the number of points.
const EDGE: (f64, f64) = (0.1, -0.5);

/// Factor that makes the approximate stiffness about as large as the exact one, or larger, for most displacements.
const FACTOR: f64 = 1.3;

impl FreeCompliance {
    /// Tabulates the compliance of `body` on `grid`.
    ///
    /// # Errors
    /// A body other than a half-space.
    pub fn new(grid: Grid, body: &Body) -> Result<Self, GreenError> {
        let compliance = patch_compliance(body, &grid)?;
        let cosines = Cosines::new(grid);
        let mut stiffness = cosines.quotients(&compliance);
        stiffness.iter_mut().for_each(|k| *k = FACTOR / *k);
        let convolution = Convolution::new(grid, compliance);
        let weights = grid.points().map(|points| (0..points).map(|i| weight(i, points)).collect());
        let weights = if grid.is_line() { swapped(weights) } else { weights };
        let mut uniform = vec![0.0; grid.len()];
        let free = Self { convolution, cosines, stiffness, weights, uniform: Vec::new() };
        free.weighted(|_, row| row.fill(1.0), &mut uniform, &mut free.cosines.workspace());
        let sum = total(&uniform);
        uniform.iter_mut().for_each(|p| *p /= sum);
        Ok(Self { uniform, ..free })
    }

    /// The grid of the patch.
    pub fn grid(&self) -> &Grid {
        self.convolution.grid()
    }

    /// `out` ← the approximate stiffness times the displacement whose rows `source(i, row)` fills.
    fn weighted(&self, source: impl Fn(usize, &mut [f64]) + Sync, out: &mut [f64], ws: &mut CosineWorkspace) {
        let [along_x, along_y] = &self.weights;
        let weigh = |i: usize, row: &mut [f64]| {
            row.iter_mut().zip(along_y).for_each(|(value, weight)| *value *= along_x[i] * weight);
        };
        let weighted = |i: usize, row: &mut [f64]| {
            source(i, row);
            weigh(i, row);
        };
        fits(self.cosines.apply(&self.stiffness, weighted, out, weigh, ws));
    }
}

/// The weight of a row or column, which is 1 if it is the only one.
fn weight(i: usize, points: usize) -> f64 {
    let distance = i.min(points - 1 - i) as f64 + 0.5;
    let (excess, power) = EDGE;
    if points == 1 { 1.0 } else { 1.0 + excess * distance.powf(power) }
}

fn swapped<T>([x, y]: [T; 2]) -> [T; 2] {
    [y, x]
}

fn total(field: &[f64]) -> f64 {
    gfmd_vector::sum(field.len(), &|range| field[range].iter().sum())
}

/// The transforms of a [`FreeCompliance`], with their memory and a counter.
///
/// # Panics
/// Every method panics if a field does not have the size of the grid.
#[derive(Debug)]
pub struct FreeTransforms {
    compliance: Arc<FreeCompliance>,
    workspace: gfmd_field::Workspace,
    cosines: CosineWorkspace,
    /// Number of single transforms.
    singles: u64,
}

impl FreeTransforms {
    /// Memory for transforms on the grid of `compliance`; none is counted yet.
    pub fn of(compliance: &Arc<FreeCompliance>) -> Self {
        let (workspace, cosines) = (compliance.convolution.workspace(), compliance.cosines.workspace());
        Self { compliance: Arc::clone(compliance), workspace, cosines, singles: 0 }
    }

    /// `out` ← G `pressure`, the displacement downwards.
    pub fn apply(&mut self, pressure: &[f64], out: &mut [f64]) {
        self.singles += 2;
        fits(self.compliance.convolution.apply(pressure, out, &mut self.workspace));
    }

    /// ⟨p, G p⟩, summed over the points, from one transform.
    pub fn quadratic_form(&mut self, pressure: &[f64]) -> f64 {
        self.singles += 1;
        fits(self.compliance.convolution.quadratic_form(pressure, &mut self.workspace))
    }

    /// `out` ← about K u, for the displacement u, downwards, whose rows `source(i, row)` fills. If the surface is `floating`,
    /// it may also move as a whole, so that the pressure has no sum: it is that of u and of the uniform displacement that
    /// goes with it.
    pub fn stiffness(&mut self, floating: bool, source: impl Fn(usize, &mut [f64]) + Sync, out: &mut [f64]) {
        self.singles += 2;
        let Self { compliance, cosines, .. } = self;
        compliance.weighted(source, out, cosines);
        if floating {
            let sum = total(out);
            for_each([out], &|start, [out]| {
                out.iter_mut().zip(&compliance.uniform[start..]).for_each(|(p, uniform)| *p -= sum * uniform);
            });
        }
    }

    /// Forward and inverse transforms so far, in pairs, whether of padded fields or of cosines.
    pub fn pairs(&self) -> f64 {
        self.singles as f64 / 2.0
    }

    /// The counter of single transforms, for a solve that continues an earlier one.
    pub fn counter(&mut self) -> &mut u64 {
        &mut self.singles
    }
}
