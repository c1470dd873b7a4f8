use std::sync::Arc;

use gfmd_field::{Grid, Rows, Share, Split, Transform, Workspace};
use rayon::prelude::*;

use crate::NormalResponse;
use crate::elastic::fits;
use crate::units::power_of_two;

/// Normal response in single precision, for solvers that round their steps: compliance divided by a unit, and stiffness
/// times this unit, so that the compliance of the softest wave is about 1.
#[derive(Debug)]
pub(crate) struct Rounded {
    transform: Transform<f32>,
    compliance: Vec<f32>,
    stiffness: Vec<f32>,
    unit: f64,
}

impl Rounded {
    /// Tabulates the response from the compliance of the modes of this process and the smallest stiffness of all modes.
    /// A table that `is_even` in q_x is stored for half of its modes.
    pub(crate) fn of(grid: Grid, share: &Share, compliance: &[f64], softest: f64, is_even: bool) -> Self {
        let unit = power_of_two(1.0 / softest);
        let stiffness = |g: f64| if g == 0.0 { 0.0 } else { (unit / g) as f32 };
        Self {
            transform: Transform::distributed(grid, share),
            compliance: table(&grid, compliance, is_even, |g| (g / unit) as f32),
            stiffness: table(&grid, compliance, is_even, stiffness),
            unit,
        }
    }
}

/// Tabulates a function for modes with q_x ≥ 0 if it `is_even` in q_x; for all modes otherwise, and for a line.
fn table(grid: &Grid, values: &[f64], is_even: bool, of: impl Fn(f64) -> f32 + Sync) -> Vec<f32> {
    let [nx, ny] = grid.points();
    let column = if nx == 1 || ny == 1 { values.len().max(1) } else { nx };
    let kept = if is_even && column == nx && ny > 1 { nx / 2 + 1 } else { column };
    let columns = values.par_chunks(column);
    columns.flat_map_iter(|column| column[..kept].iter().map(|value| of(*value))).collect()
}

/// Transforms of a [`NormalResponse`] in single precision, with their memory and a counter. Steps may have any unit;
/// their images have that unit times [`unit`](Self::unit).
///
/// # Panics
/// Every method panics if a field does not have the size of the grid.
#[derive(Debug)]
pub struct RoundedTransforms {
    response: Arc<NormalResponse>,
    /// Allocated by the first transform.
    workspace: Option<Workspace<f32>>,
    /// Tables with a different uniform mode.
    own: Option<[Vec<f32>; 2]>,
    /// Number of single transforms.
    singles: u64,
}

impl RoundedTransforms {
    /// Creates transforms on the grid of `response`, with compliance and stiffness of the `uniform` mode; both are zero
    /// for `None`.
    pub fn of(response: &Arc<NormalResponse>, uniform: Option<[f64; 2]>) -> Self {
        let rounded = response.rounded();
        let own = uniform.map(|[compliance, stiffness]| {
            let with = |table: &[f32], value: f64| {
                let mut table = table.to_vec();
                if response.has_uniform() {
                    table[0] = value as f32;
                }
                table
            };
            [with(&rounded.compliance, compliance / rounded.unit), with(&rounded.stiffness, stiffness * rounded.unit)]
        });
        Self { response: Arc::clone(response), workspace: None, own, singles: 0 }
    }

    /// Frees the memory until the next transform.
    pub fn release(&mut self) {
        self.workspace = None;
    }

    /// Returns the unit of compliances, a power of two, in length/stress.
    pub fn unit(&self) -> f64 {
        self.response.rounded().unit
    }

    /// Computes G v divided by the unit; `source` generates the rows of v from the rows of `input`
    /// ([`Transform::convolve_ahead`]).
    pub fn compliance<I: Split>(&mut self, input: I, source: impl Fn(usize, I, &mut [f32]) + Sync) {
        self.singles += 1;
        let (transform, [compliance, _], workspace) = self.parts();
        fits(transform.convolve_ahead(compliance, input, source, workspace));
    }

    /// Passes the rows of the result of [`compliance`](Self::compliance) or [`stiffness_ahead`](Self::stiffness_ahead)
    /// to `sink`.
    pub fn rows<O: Split>(&mut self, output: O, sink: impl Fn(usize, &mut [f32], O) + Sync) {
        self.singles += 1;
        let (transform, _, workspace) = self.parts();
        fits(transform.convolve_back(output, sink, workspace));
    }

    /// Computes K u times the unit; `source` generates the rows of u from the rows of `input`, and [`rows`](Self::rows)
    /// passes on the result.
    pub fn stiffness_ahead<I: Split>(&mut self, input: I, source: impl Fn(usize, I, &mut [f32]) + Sync) {
        self.singles += 1;
        let (transform, [_, stiffness], workspace) = self.parts();
        fits(transform.convolve_ahead(stiffness, input, source, workspace));
    }

    /// Computes `out` = K u times the unit; `source(i, row)` fills the rows of u.
    pub fn stiffness(&mut self, source: impl Fn(usize, &mut [f32]) + Sync, out: &mut [f32]) {
        let [_, columns] = self.response.grid().rows();
        self.stiffness_ahead((), |i, (), row| source(i, row));
        self.rows(Rows(out, columns), |_, row, Rows(out, _): Rows<&mut [f32]>| out.copy_from_slice(row));
    }

    /// Returns Σ_r v G v divided by the unit, over all rows, from one transform.
    pub fn quadratic_form(&mut self, field: &[f32]) -> f64 {
        let points = self.response.grid().len() as f64;
        self.singles += 1;
        let (transform, [compliance, _], workspace) = self.parts();
        fits(transform.quadratic_form(compliance, field, workspace)) * points
    }

    /// Returns the plan, compliance and stiffness, and memory.
    fn parts(&mut self) -> (&Transform<f32>, [&[f32]; 2], &mut Workspace<f32>) {
        let Rounded { transform, compliance, stiffness, .. } = self.response.rounded();
        let tables =
            self.own.as_ref().map_or([compliance, stiffness], |[compliance, stiffness]| [compliance, stiffness]);
        (transform, tables.map(Vec::as_slice), self.workspace.get_or_insert_with(|| transform.workspace()))
    }

    /// Returns the number of pairs of forward and inverse transforms so far.
    pub fn pairs(&self) -> f64 {
        self.singles as f64 / 2.0
    }

    /// Returns the counter of single transforms, for a solve that continues an earlier one.
    pub fn counter(&mut self) -> &mut u64 {
        &mut self.singles
    }
}
