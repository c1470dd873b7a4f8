//! Linear step of the Newton search: generalised minimal residuals (Saad and Schultz, SIAM J. Sci. Stat. Comput. 7
//! (1986) 856) on the free points, in single precision.

use gfmd_relax::Ceiling;
use gfmd_response::ComplexTransforms;
use gfmd_vector::{dot, for_each, sum};
use num_complex::{Complex32, Complex64};
use rayon::prelude::*;

use crate::pull_push::{Edges, Known, PullPush};
use crate::{Contact, Load};

/// Largest residual of a linear step divided by its right side.
const REDUCTION: f64 = 0.1;
/// Largest number of vectors of a linear step.
const VECTORS: usize = 10;

/// Compliance restricted to the free points, its preconditioner, and the vectors of a step.
pub(super) struct Krylov {
    transforms: ComplexTransforms<f32>,
    /// Complex compliance of each mode divided by `unit`.
    compliance: Vec<Complex32>,
    /// Complex stiffness of each mode times `unit`.
    stiffness: Vec<Complex32>,
    unit: f64,
    extension: PullPush,
    /// True if the mean pressure is prescribed: steps have no mean.
    floating: bool,
    columns: usize,
    /// Orthonormal vectors.
    vectors: Vec<Vec<f32>>,
    /// Preconditioned vectors.
    steps: Vec<Vec<f32>>,
    /// Displacement of each step at all points, divided by `unit`.
    images: Vec<Vec<f32>>,
    extended: Vec<f32>,
}

/// Linear step of the pressure as a sum of vectors.
pub(super) struct LinearStep<'a> {
    coefficients: Vec<f64>,
    steps: &'a [Vec<f32>],
    images: &'a [Vec<f32>],
    /// Unit of the images divided by the unit of the steps.
    unit: f64,
}

impl LinearStep<'_> {
    /// Returns the number of vectors.
    pub(super) fn vectors(&self) -> usize {
        self.coefficients.len()
    }

    /// Adds the step times `factor` to a pressure and to its displacement.
    pub(super) fn add(&self, factor: f64, pressure: &mut [f64], displacement: &mut [f64]) {
        for ((coefficient, step), image) in self.coefficients.iter().zip(self.steps).zip(self.images) {
            let (of_step, of_image) = (factor * coefficient / self.unit, factor * coefficient);
            let vectors = (&mut pressure[..], &mut displacement[..], &step[..], &image[..]);
            for_each(vectors, &|_, (pressure, displacement, step, image)| {
                pressure.iter_mut().zip(step).for_each(|(p, z)| *p += of_step * f64::from(*z));
                displacement.iter_mut().zip(image).for_each(|(u, g)| *u += of_image * f64::from(*g));
            });
        }
    }
}

impl Krylov {
    /// Makes the operators of a contact under `load` from the complex compliance of its modes; `uniform` has compliance
    /// and stiffness of the uniform mode, if it takes part.
    pub(super) fn new(contact: &Contact, load: Load, compliance: &[Complex64], uniform: Option<[f64; 2]>) -> Self {
        let (grid, softest) = (*contact.response.grid(), contact.response.stiffness_range()[0]);
        let unit = 1.0 / softest;
        let floating = matches!(load, Load::MeanPressure(_));
        let narrow = |value: Complex64| Complex32::new(value.re as f32, value.im as f32);
        let inverse = |g: Complex64| if g == Complex64::ZERO { g } else { 1.0 / g };
        let mut stiffness: Vec<Complex32> = compliance.par_iter().map(|g| narrow(inverse(*g) * unit)).collect();
        let compliance: Vec<Complex32> = compliance.par_iter().map(|g| narrow(*g / unit)).collect();
        if let Some([_, level]) = uniform {
            stiffness[0] = Complex32::from((level * unit) as f32);
        }
        Self {
            transforms: ComplexTransforms::new(grid),
            compliance,
            stiffness,
            unit,
            extension: PullPush::new(grid.points(), floating, Edges::Joined, contact.stiffness_of_waves()),
            floating,
            columns: grid.rows()[1],
            vectors: Vec::new(),
            steps: Vec::new(),
            images: Vec::new(),
            extended: vec![0.0; grid.len()],
        }
    }

    /// Returns the number of transform pairs so far.
    pub(super) fn pairs(&self) -> f64 {
        self.transforms.pairs()
    }

    /// Finds a step of the pressure that closes `residual` at the points where `free` is 1; elsewhere it is 0. The
    /// residual is a gap of norm 1, without a mean under a prescribed load.
    pub(super) fn step(&mut self, free: &[f64], residual: Vec<f32>) -> LinearStep<'_> {
        let count = free.iter().sum::<f64>();
        self.vectors = vec![residual];
        let mut rotated = Rotated::default();
        for k in 0..VECTORS {
            self.grow(k);
            self.precondition(free, count, k);
            let mut next = self.image(free, count, k);
            let mut column = Vec::with_capacity(k + 2);
            for vector in &self.vectors {
                let part = dot(&next, vector);
                column.push(part);
                gfmd_vector::add_times(&mut next, -part as f32, vector);
            }
            let length = dot(&next, &next).sqrt();
            column.push(length);
            let left = rotated.push(column);
            let is_done = left <= REDUCTION || length <= 0.0 || length.is_nan();
            if is_done {
                break;
            }
            let scale = (1.0 / length) as f32;
            for_each(&mut next[..], &|_, next: &mut [f32]| next.iter_mut().for_each(|next| *next *= scale));
            self.vectors.push(next);
        }
        let coefficients = rotated.solve();
        LinearStep { coefficients, steps: &self.steps, images: &self.images, unit: self.unit }
    }

    /// Allocates the vectors with number k.
    fn grow(&mut self, k: usize) {
        for vectors in [&mut self.steps, &mut self.images] {
            if vectors.len() <= k {
                vectors.push(vec![0.0; self.extended.len()]);
            }
        }
    }

    /// Computes the step with number k: P Eᵀ S E of the vector with this number.
    fn precondition(&mut self, free: &[f64], count: f64, k: usize) {
        let Self { transforms, stiffness, extension, floating, columns, vectors, steps, extended, .. } = self;
        let known = Known { x: free, gradient: &vectors[k], level: 0.0, upper: Ceiling::All(f64::INFINITY) };
        extension.prepare(known);
        extended.par_chunks_mut(*columns).enumerate().for_each(|(i, row)| extension.row(known, i, row));
        let step = &mut steps[k];
        transforms.convolve(stiffness, extended, step);
        extension.transpose(known, step);
        project(free, count, *floating, step);
    }

    /// Computes the image of the step with number k, and returns it on the free points.
    fn image(&mut self, free: &[f64], count: f64, k: usize) -> Vec<f32> {
        self.transforms.convolve(&self.compliance, &self.steps[k], &mut self.images[k]);
        let mut image = self.images[k].clone();
        project(free, count, self.floating, &mut image);
        image
    }
}

/// Sets a field to zero outside the free points; if `floating`, also its mean over them.
fn project(free: &[f64], count: f64, floating: bool, field: &mut [f32]) {
    let mean = match floating {
        true => sum(field.len(), &|range| range.map(|i| free[i] * f64::from(field[i])).sum()) / count,
        false => 0.0,
    } as f32;
    for_each((field, free), &|_, (field, free)| {
        field.iter_mut().zip(free).for_each(|(value, free)| *value = *free as f32 * (*value - mean));
    });
}

/// Least-squares problem of the images, whose matrix is made triangular by rotations.
#[derive(Default)]
struct Rotated {
    columns: Vec<Vec<f64>>,
    rotations: Vec<[f64; 2]>,
    right: Vec<f64>,
}

impl Rotated {
    /// Adds a column, with one entry more than the last one. Returns the residual that is left.
    fn push(&mut self, mut column: Vec<f64>) -> f64 {
        if self.right.is_empty() {
            self.right.push(1.0);
        }
        for (i, [c, s]) in self.rotations.iter().enumerate() {
            let [a, b] = [column[i], column[i + 1]];
            (column[i], column[i + 1]) = (c * a + s * b, c * b - s * a);
        }
        let last = self.rotations.len();
        let length = column[last].hypot(column[last + 1]);
        let [c, s] = if length > 0.0 { [column[last] / length, column[last + 1] / length] } else { [1.0, 0.0] };
        column[last] = length;
        column.truncate(last + 1);
        let right = self.right[last];
        self.right[last] = c * right;
        self.right.push(-s * right);
        self.rotations.push([c, s]);
        self.columns.push(column);
        self.right[last + 1].abs()
    }

    /// Returns the coefficients with the least residual; a column of zeros has none.
    fn solve(&self) -> Vec<f64> {
        let mut solution = self.right[..self.columns.len()].to_vec();
        for k in (0..self.columns.len()).rev() {
            let pivot = self.columns[k][k];
            solution[k] = if pivot > 0.0 { solution[k] / pivot } else { 0.0 };
            let value = solution[k];
            for (row, entry) in self.columns[k][..k].iter().enumerate() {
                solution[row] -= entry * value;
            }
        }
        solution
    }
}
