use std::sync::Arc;

use gfmd_field::{Convolution, CosineWorkspace, Cosines, Grid, Rows, Share, Split};
use gfmd_green::{Body, Conductor, GreenError, has_level, patch_compliance, patch_resistance};
use gfmd_vector::for_each;

use crate::elastic::fits;
use crate::units::power_of_two;

/// Compliance of a non-periodic patch. The pressure is constant on the cell around every grid point and zero outside
/// the patch. The displacement refers to the grid points. It is zero far away, or for a profile on a half-space one
/// patch length away ([`patch_compliance`]; theory.md, section 3.1). Built once and shared between problems and
/// threads. Each process convolves its own rows.
///
/// The inverse, a stiffness, is approximated: it is diagonal in cosine waves, with the inverse of the mean compliance
/// of each wave on the patch, multiplied on both sides by weights that increase towards the edges, where the pressure
/// for a given displacement is largest.
#[derive(Debug)]
pub struct FreeCompliance {
    convolution: Convolution,
    /// Convolution divided by the unit, in single precision.
    rounded: Convolution<f32>,
    unit: f64,
    cosines: Cosines<f32>,
    /// Stiffness of each cosine wave times the unit.
    stiffness: Vec<f32>,
    /// Weight of each row, and of each point of a row.
    weights: [Vec<f32>; 2],
    /// Pressure for a uniform displacement, divided by its sum.
    uniform: Vec<f32>,
    has_level: bool,
}

/// Excess of the weight one cell from the edge, and the exponent of its decay with distance. The eigenvalues of the
/// approximate stiffness times the compliance, without [`FACTOR`], are then between 0.7 and 1.4 on 256² points (without
/// weights 0.47 and 1.3). The lowest falls with the logarithm of the number of points.
const EDGE: (f64, f64) = (0.1, -0.5);

/// Factor that makes the approximate stiffness about as large as the exact one, or larger, for most displacements.
const FACTOR: f64 = 1.3;

impl FreeCompliance {
    /// Tabulates the compliance of `body` on `grid`.
    ///
    /// # Errors
    /// Returns an error if the body has no level far away, or if layers are too thin ([`patch_compliance`]).
    pub fn new(grid: Grid, body: &Body) -> Result<Self, GreenError> {
        Self::distributed(grid, body, &grid.whole())
    }

    /// Tabulates the compliance of `body` on `grid` for the `share` of rows of this process.
    ///
    /// # Errors
    /// Returns an error as [`new`](Self::new).
    pub fn distributed(grid: Grid, body: &Body, share: &Share) -> Result<Self, GreenError> {
        Ok(Self::tabulated(grid, share, patch_compliance(body, &grid)?, true))
    }

    /// Tabulates the resistance of a conductor on `grid`: potential for displacement, current density for pressure.
    ///
    /// # Errors
    /// Returns an error if an electrode is not deep enough ([`patch_resistance`]).
    pub fn of_conductor(grid: Grid, conductor: &Conductor) -> Result<Self, GreenError> {
        let has_level = has_level(conductor.body(), &grid);
        Ok(Self::tabulated(grid, &grid.whole(), patch_resistance(conductor, &grid)?, has_level))
    }

    fn tabulated(grid: Grid, share: &Share, compliance: impl Fn([usize; 2]) -> f64 + Sync, has_level: bool) -> Self {
        let quotients = Cosines::<f64>::distributed(grid, share).quotients(&compliance);
        Self::of(Convolution::distributed(grid, share, &compliance), &quotients, has_level)
    }

    /// Builds the compliance from the convolution and the mean compliance of each cosine wave on the patch.
    fn of(convolution: Convolution, quotients: &[f64], has_level: bool) -> Self {
        let (grid, share) = (*convolution.grid(), convolution.share().clone());
        let unit = power_of_two(convolution.largest());
        let rounded = convolution.rounded(1.0 / unit);
        let stiffness = quotients.iter().map(|quotient| (FACTOR * unit / quotient) as f32).collect();
        let cosines = Cosines::distributed(grid, &share);
        let weights = grid.points().map(|points| (0..points).map(|i| weight(i, points) as f32).collect());
        let weights = if grid.is_line() { swapped(weights) } else { weights };
        let mut uniform = vec![0.0; share.own().len()];
        let free = Self { convolution, rounded, unit, cosines, stiffness, weights, uniform: Vec::new(), has_level };
        free.weighted(|_, row| row.fill(1.0), &mut uniform, &mut free.cosines.workspace());
        let sum = share.total_of(&uniform);
        uniform.iter_mut().for_each(|p| *p = (f64::from(*p) / sum) as f32);
        Self { uniform, ..free }
    }

    /// Returns the compliance of the patch below point springs with this `compliance` in length/stress.
    #[must_use]
    pub fn softened(&self, compliance: f64) -> Self {
        let quotients: Vec<f64> =
            self.stiffness.iter().map(|stiffness| FACTOR * self.unit / f64::from(*stiffness) + compliance).collect();
        Self::of(self.convolution.with_own(compliance), &quotients, self.has_level)
    }

    /// Returns the grid of the patch.
    pub fn grid(&self) -> &Grid {
        self.convolution.grid()
    }

    /// Returns true if displacements have a reference level; false for the potential of a profile over a half-space,
    /// which is known up to a constant.
    pub fn has_level(&self) -> bool {
        self.has_level
    }

    /// Computes the approximate stiffness, times the unit, of a displacement; `source(i, row)` fills its rows.
    fn weighted(&self, source: impl Fn(usize, &mut [f32]) + Sync, out: &mut [f32], ws: &mut CosineWorkspace<f32>) {
        let ([along_x, along_y], first) = (&self.weights, self.convolution.share().rows().start);
        let weigh = |i: usize, row: &mut [f32]| {
            row.iter_mut().zip(along_y).for_each(|(value, weight)| *value *= along_x[first + i] * weight);
        };
        let source = |i: usize, (): (), row: &mut [f32]| {
            source(i, row);
            weigh(i, row);
        };
        let sink = |i: usize, row: &mut [f32], Rows(out, _): Rows<&mut [f32]>| {
            weigh(i, row);
            out.copy_from_slice(row);
        };
        fits(self.cosines.apply(&self.stiffness, (), source, Rows(out, self.grid().rows()[1]), sink, ws));
    }
}

/// Returns the weight of a row or column, which is 1 if it is the only one.
fn weight(i: usize, points: usize) -> f64 {
    let distance = i.min(points - 1 - i) as f64 + 0.5;
    let (excess, power) = EDGE;
    if points == 1 { 1.0 } else { 1.0 + excess * distance.powf(power) }
}

fn swapped<T>([x, y]: [T; 2]) -> [T; 2] {
    [y, x]
}

/// Transforms of a [`FreeCompliance`], with their memory and a counter.
///
/// # Panics
/// Every method panics if a field does not have the size of the grid.
#[derive(Debug)]
pub struct FreeTransforms {
    compliance: Arc<FreeCompliance>,
    workspace: gfmd_field::Workspace,
    /// Number of single transforms.
    singles: u64,
}

impl FreeTransforms {
    /// Allocates memory for transforms on the grid of `compliance`, with the counter at zero.
    pub fn of(compliance: &Arc<FreeCompliance>) -> Self {
        let workspace = compliance.convolution.workspace();
        Self { compliance: Arc::clone(compliance), workspace, singles: 0 }
    }

    /// Computes `out` = G `pressure`, the downward displacement.
    pub fn apply(&mut self, pressure: &[f64], out: &mut [f64]) {
        self.singles += 2;
        fits(self.compliance.convolution.apply(pressure, out, &mut self.workspace));
    }

    /// Applies G row by row: `source` generates the pressure from the rows of `input`, and `sink` gets the displacement
    /// with the rows of `output`.
    pub fn apply_rows<I: Split, O: Split>(
        &mut self,
        input: I,
        source: impl Fn(usize, I, &mut [f64]) + Sync,
        output: O,
        sink: impl Fn(usize, &mut [f64], O) + Sync,
    ) {
        self.singles += 2;
        let Self { compliance, workspace, .. } = self;
        fits(compliance.convolution.apply_ahead(input, source, workspace));
        fits(compliance.convolution.apply_back(output, sink, workspace));
    }

    /// Returns ⟨p, G p⟩, summed over the points of all processes, from one transform.
    pub fn quadratic_form(&mut self, pressure: &[f64]) -> f64 {
        self.singles += 1;
        fits(self.compliance.convolution.quadratic_form(pressure, &mut self.workspace))
    }

    /// Returns the number of pairs of forward and inverse transforms of padded fields so far.
    pub fn pairs(&self) -> f64 {
        self.singles as f64 / 2.0
    }

    /// Returns the counter of single transforms, for a solve that continues an earlier one.
    pub fn counter(&mut self) -> &mut u64 {
        &mut self.singles
    }
}

/// Transforms of a [`FreeCompliance`] and its approximate stiffness in single precision; the counterpart of
/// [`RoundedTransforms`](crate::RoundedTransforms).
///
/// # Panics
/// Every method panics if a field does not have the size of the grid.
#[derive(Debug)]
pub struct FreeRounded {
    compliance: Arc<FreeCompliance>,
    workspace: gfmd_field::Workspace<f32>,
    cosines: CosineWorkspace<f32>,
    /// Number of single transforms.
    singles: u64,
}

impl FreeRounded {
    /// Allocates memory for transforms on the grid of `compliance`, with the counter at zero.
    pub fn of(compliance: &Arc<FreeCompliance>) -> Self {
        let (workspace, cosines) = (compliance.rounded.workspace(), compliance.cosines.workspace());
        Self { compliance: Arc::clone(compliance), workspace, cosines, singles: 0 }
    }

    /// Returns the unit of compliances, a power of two, in length/stress.
    pub fn unit(&self) -> f64 {
        self.compliance.unit
    }

    /// Computes G v divided by the unit; `source` generates the rows of v from the rows of `input`.
    pub fn compliance<I: Split>(&mut self, input: I, source: impl Fn(usize, I, &mut [f32]) + Sync) {
        self.singles += 1;
        fits(self.compliance.rounded.apply_ahead(input, source, &mut self.workspace));
    }

    /// Passes the rows of the result of [`compliance`](Self::compliance) to `sink`.
    pub fn rows<O: Split>(&mut self, output: O, sink: impl Fn(usize, &mut [f32], O) + Sync) {
        self.singles += 1;
        fits(self.compliance.rounded.apply_back(output, sink, &mut self.workspace));
    }

    /// Approximates `out` = K u times the unit; `source(i, row)` fills the rows of the downward displacement u. A
    /// `floating` surface may also move as a whole: a uniform displacement is added to u such that the total pressure
    /// is zero.
    pub fn stiffness(&mut self, floating: bool, source: impl Fn(usize, &mut [f32]) + Sync, out: &mut [f32]) {
        self.singles += 2;
        let Self { compliance, cosines, .. } = self;
        compliance.weighted(source, out, cosines);
        if floating {
            let sum = compliance.convolution.share().total_of(out) as f32;
            for_each((out, &compliance.uniform[..]), &|_, (out, uniform)| {
                out.iter_mut().zip(uniform).for_each(|(p, uniform)| *p -= sum * uniform);
            });
        }
    }

    /// Returns Σ_r v G v divided by the unit, from one transform.
    pub fn quadratic_form(&mut self, field: &[f32]) -> f64 {
        self.singles += 1;
        fits(self.compliance.rounded.quadratic_form(field, &mut self.workspace))
    }

    /// Returns the number of pairs of forward and inverse transforms so far, of padded fields and of cosines.
    pub fn pairs(&self) -> f64 {
        self.singles as f64 / 2.0
    }

    /// Returns the counter of single transforms, for a solve that continues an earlier one.
    pub fn counter(&mut self) -> &mut u64 {
        &mut self.singles
    }
}
