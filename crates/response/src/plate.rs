use std::sync::Arc;

use gfmd_field::{Grid, Share, Transform, Workspace};
use gfmd_green::{Plate, PlateCompliance};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::elastic::fits;

/// Number of modes in a task of one thread.
const CHUNK: usize = 4096;

/// Response of a plate to pressures on both faces, on one grid: planned transforms, and compliance and stiffness of
/// every mode. A field on both faces is one slice, the upper face first; indentations are positive into the plate on
/// both faces.
#[derive(Debug)]
pub struct PlateResponse {
    transform: Transform,
    /// Rows of this process, of one face.
    share: Share,
    compliance: Vec<Symmetric>,
    stiffness: Vec<Symmetric>,
    following: Vec<f64>,
    uniform_compliance: f64,
    stiffness_range: [f64; 2],
    softest_squeezing: f64,
    contact_modulus: f64,
}

/// Symmetric matrix that acts on half sum and half difference of the faces.
#[derive(Clone, Copy, Debug)]
struct Symmetric {
    sum: f64,
    difference: f64,
    mixed: f64,
}

impl Symmetric {
    const ZERO: Self = Self { sum: 0.0, difference: 0.0, mixed: 0.0 };

    fn inverse(self) -> Self {
        let Self { sum, difference, mixed } = self;
        // Divides by the pivots first: the determinant of a thin plate may overflow where the inverse does not.
        let sum_inverse = 1.0 / (sum - mixed * (mixed / difference));
        let difference_inverse = 1.0 / (difference - mixed * (mixed / sum));
        Self { sum: sum_inverse, difference: difference_inverse, mixed: -(mixed / difference) * sum_inverse }
    }

    /// Returns the eigenvalues, in any order.
    fn eigenvalues(self) -> [f64; 2] {
        let Self { sum, difference, mixed } = self;
        let large = 0.5 * (sum + difference) + (0.5 * (sum - difference)).hypot(mixed);
        [sum * (difference / large) - mixed * (mixed / large), large]
    }
}

impl PlateResponse {
    /// Tabulates the response of `plate` on `grid`.
    pub fn new(grid: Grid, plate: &Plate) -> Self {
        Self::distributed(grid, plate, &grid.whole())
    }

    /// Tabulates the response of `plate` on `grid` for the `share` of rows of this process on both faces. Each process
    /// has the modes of its own lanes, and all make the same calls.
    pub fn distributed(grid: Grid, plate: &Plate, share: &Share) -> Self {
        let transform = Transform::distributed(grid, share);
        let ([_, positions], lanes) = (grid.spectrum_shape(), transform.lanes());
        let (start, has_uniform) = (lanes.start * positions, lanes.contains(&0));
        let of_mode = |index: usize| {
            let mode = grid.mode_at(start + index);
            // The uniform mode is identified by its numbers, never by a small wavenumber.
            if mode.is_uniform() {
                return Symmetric::ZERO;
            }
            let PlateCompliance { squeezing, bending, mixed } = plate.compliance(mode.wavenumber());
            Symmetric { sum: squeezing, difference: bending, mixed }
        };
        let compliance: Vec<Symmetric> =
            (0..lanes.len() * positions).into_par_iter().with_min_len(CHUNK).map(of_mode).collect();
        let mut range = [f64::INFINITY, 0.0_f64];
        let mut softest_squeezing = f64::INFINITY;
        for matrix in &compliance[usize::from(has_uniform)..] {
            softest_squeezing = softest_squeezing.min(1.0 / matrix.sum);
            for compliance in matrix.eigenvalues() {
                range = [range[0].min(1.0 / compliance), range[1].max(1.0 / compliance)];
            }
        }
        let all = share.each([range[0], range[1], softest_squeezing]).into_iter();
        let [least, most, softest_squeezing] = all.fold([f64::INFINITY, 0.0, f64::INFINITY], |ends, own| {
            [ends[0].min(own[0]), ends[1].max(own[1]), ends[2].min(own[2])]
        });
        let mut stiffness: Vec<Symmetric> = compliance.par_iter().with_min_len(CHUNK).map(|m| m.inverse()).collect();
        let following = |m: &Symmetric| ((m.difference - m.sum) / (m.difference + m.sum)).max(0.0);
        let mut following: Vec<f64> = compliance.iter().map(following).collect();
        if has_uniform {
            (stiffness[0], following[0]) = (Symmetric::ZERO, 1.0);
        }
        Self {
            transform,
            share: share.clone(),
            compliance,
            stiffness,
            following,
            uniform_compliance: plate.compliance(0.0).squeezing,
            stiffness_range: [least, most],
            softest_squeezing,
            contact_modulus: plate.contact_modulus(),
        }
    }

    /// Returns the grid of the faces.
    pub fn grid(&self) -> &Grid {
        self.transform.grid()
    }

    /// Returns the rows of this process, of one face; a single process has all rows.
    pub fn share(&self) -> &Share {
        &self.share
    }

    /// Returns the compliance of the uniform mode in length/stress: half of the plate compression due to a uniform
    /// pressure on both faces.
    pub fn uniform_compliance(&self) -> f64 {
        self.uniform_compliance
    }

    /// Returns the smallest and largest stiffness of the modes q ≠ 0, in stress/length.
    pub fn stiffness_range(&self) -> [f64; 2] {
        self.stiffness_range
    }

    /// Returns the smallest stiffness of the modes q ≠ 0 against equal pressures on both faces, in stress/length.
    pub fn softest_squeezing(&self) -> f64 {
        self.softest_squeezing
    }

    /// Returns the displacement of the unloaded face as a fraction of the indentation of the loaded face: one at long
    /// waves, where the plate bends, and zero at short ones. Laid out as [`Grid::modes`].
    pub fn following(&self) -> &[f64] {
        &self.following
    }

    /// Returns E* of the material at the upper face, in stress.
    pub fn contact_modulus(&self) -> f64 {
        self.contact_modulus
    }
}

/// Transforms of a [`PlateResponse`], with their memory and a counter.
///
/// # Panics
/// Every method panics if a field does not have the size of the grid, or of both faces.
#[derive(Debug)]
pub struct PlateTransforms {
    response: Arc<PlateResponse>,
    workspace: Workspace,
    spectra: [Vec<Complex64>; 2],
    /// Number of single transforms of one face.
    singles: u64,
}

impl PlateTransforms {
    /// Allocates memory for transforms on the grid of `response`, with the counter at zero.
    pub fn of(response: &Arc<PlateResponse>) -> Self {
        let modes = response.compliance.len();
        Self {
            response: Arc::clone(response),
            workspace: response.transform.workspace(),
            spectra: [vec![Complex64::ZERO; modes], vec![Complex64::ZERO; modes]],
            singles: 0,
        }
    }

    /// Returns the response.
    pub fn response(&self) -> &PlateResponse {
        &self.response
    }

    /// Computes indentation = C `pressure`, with the compliance `uniform` for the half sum at q = 0. The half
    /// difference at q = 0 is zero: the plate as a whole has no support.
    pub fn compliance(&mut self, uniform: f64, pressure: &[f64], indentation: &mut [f64]) {
        self.compliance_with([uniform, 0.0], pressure, indentation);
    }

    /// Computes indentation = C `pressure`, with the compliances `uniform` for half sum and half difference at q = 0.
    pub fn compliance_with(&mut self, uniform: [f64; 2], pressure: &[f64], indentation: &mut [f64]) {
        let response = Arc::clone(&self.response);
        self.apply(&response.compliance, uniform, pressure, indentation);
    }

    /// Computes pressure = C⁻¹ `indentation`, with the stiffness `uniform` for the half sum at q = 0, and zero pressure
    /// for the half difference at q = 0.
    pub fn stiffness(&mut self, uniform: f64, indentation: &[f64], pressure: &mut [f64]) {
        self.stiffness_with([uniform, 0.0], indentation, pressure);
    }

    /// Computes pressure = C⁻¹ `indentation`, with the stiffnesses `uniform` for half sum and half difference at q = 0.
    pub fn stiffness_with(&mut self, uniform: [f64; 2], indentation: &[f64], pressure: &mut [f64]) {
        let response = Arc::clone(&self.response);
        self.apply(&response.stiffness, uniform, indentation, pressure);
    }

    /// Computes the part of the `field` on one face that the other face [follows](PlateResponse::following).
    pub fn follow(&mut self, field: &[f64], out: &mut [f64]) {
        self.singles += 2;
        fits(self.response.transform.convolve(&self.response.following, field, out, &mut self.workspace));
    }

    fn apply(&mut self, table: &[Symmetric], uniform: [f64; 2], field: &[f64], out: &mut [f64]) {
        self.singles += 4;
        let Self { response, workspace, spectra: [upper, lower], .. } = self;
        let (transform, points) = (&response.transform, response.share.own().len());
        let has_uniform = transform.lanes().contains(&0);
        fits(transform.forward(&field[..points], upper, workspace));
        fits(transform.forward(&field[points..], lower, workspace));
        let means = has_uniform.then(|| [0.5 * (upper[0] + lower[0]), 0.5 * (upper[0] - lower[0])]);
        (&mut *upper, &mut *lower, table).into_par_iter().with_min_len(CHUNK).for_each(|(upper, lower, m)| {
            let (sum, difference) = (0.5 * (*upper + *lower), 0.5 * (*upper - *lower));
            let (in_sum, in_difference) =
                (sum * m.sum + difference * m.mixed, sum * m.mixed + difference * m.difference);
            (*upper, *lower) = (in_sum + in_difference, in_sum - in_difference);
        });
        if let Some([sum, difference]) = means {
            let (level, shift) = (uniform[0] * sum, uniform[1] * difference);
            (upper[0], lower[0]) = if uniform[1] == 0.0 { (level, level) } else { (level + shift, level - shift) };
        }
        let (first, second) = out.split_at_mut(points);
        fits(transform.inverse(upper, first, workspace));
        fits(transform.inverse(lower, second, workspace));
    }

    /// Returns the number of pairs of forward and inverse transforms of one face so far.
    pub fn pairs(&self) -> f64 {
        self.singles as f64 / 2.0
    }

    /// Returns the counter of single transforms, for a solve that continues an earlier one.
    pub fn counter(&mut self) -> &mut u64 {
        &mut self.singles
    }
}
