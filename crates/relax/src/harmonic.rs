use crate::{Landscape, worst};

/// Harmonic landscape U = ½ u·K u without bounds, for a linear operator K.
///
/// ```
/// use gfmd_relax::{Damping, Harmonic, Method, Verlet};
///
/// // Two masses with springs of stiffness 1 and 4, the first critically damped.
/// let product = |u: &[f64], out: &mut [f64]| (out[0], out[1]) = (u[0], 4.0 * u[1]);
/// let mut springs = Harmonic::new(2, product);
/// let damping = Damping::critical(1.0, 0.1);
/// let verlet = Verlet::new(damping, 4.0)?;
/// let mut state = verlet.start(&mut springs, vec![1.0, 1.0])?;
/// for _ in 0..20 {
///     verlet.step(&mut springs, &mut state)?;
/// }
/// assert!((state.u[0] - damping.amplitude(1.0, 20)).abs() < 1e-14);
/// # Ok::<(), gfmd_relax::RelaxError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Harmonic<F> {
    len: usize,
    product: F,
}

impl<F: FnMut(&[f64], &mut [f64])> Harmonic<F> {
    /// Creates the landscape of `len` variables; `product` writes K u for a given u.
    pub fn new(len: usize, product: F) -> Self {
        Self { len, product }
    }
}

impl<F: FnMut(&[f64], &mut [f64])> Landscape for Harmonic<F> {
    fn len(&self) -> usize {
        self.len
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        (self.product)(u, force);
        force.iter_mut().for_each(|f| *f = -*f);
        -0.5 * gfmd_vector::dot(u, force)
    }

    /// Returns the largest |u|, since the minimum is at zero.
    fn residual(&self, u: &[f64], _: &[f64]) -> f64 {
        worst(u.iter().map(|u| u.abs()))
    }
}
