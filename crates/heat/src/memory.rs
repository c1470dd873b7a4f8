use gfmd_field::{Transform, Workspace};
use gfmd_vector::for_each;
use num_complex::Complex64;

/// Returns the larger of two numbers; NaN if either is NaN.
pub(crate) fn higher(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// Field, its spectrum, and the memory of their transforms.
pub(crate) struct Memory<'a> {
    transform: &'a Transform,
    workspace: Workspace,
    spectrum: Vec<Complex64>,
    pub(crate) field: Vec<f64>,
}

impl<'a> Memory<'a> {
    pub(crate) fn new(transform: &'a Transform) -> Self {
        let grid = transform.grid();
        Self {
            workspace: transform.workspace(),
            spectrum: vec![Complex64::ZERO; grid.spectrum_len()],
            field: vec![0.0; grid.len()],
            transform,
        }
    }

    /// Multiplies each mode of the field by its factor.
    pub(crate) fn apply(&mut self, factor: &(impl Fn(usize) -> Complex64 + Sync)) {
        const FITS: &str = "field and spectrum have the size of the grid";
        self.transform.forward(&self.field, &mut self.spectrum, &mut self.workspace).expect(FITS);
        for_each([&mut self.spectrum[..]], &|start, [spectrum]| {
            spectrum.iter_mut().enumerate().for_each(|(i, mode)| *mode *= factor(start + i));
        });
        self.transform.inverse(&self.spectrum, &mut self.field, &mut self.workspace).expect(FITS);
    }
}
