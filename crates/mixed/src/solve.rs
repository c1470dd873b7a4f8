use ndarray::Array3;

use crate::surface::{End, Ended, Surface};
use crate::{Method, MixedError, MixedProblem, MixedSolution, Settings, Watch, conjugate_gradients, dynamics};

impl MixedProblem<'_> {
    /// Finds displacement and traction of the whole surface.
    ///
    /// # Errors
    /// Unusable settings; or [`MixedError::NotConverged`] and [`MixedError::Interrupted`], which carry the state reached.
    pub fn solve(&self, settings: &Settings, watch: Watch) -> Result<MixedSolution, MixedError> {
        if !(1e-15..=0.1).contains(&settings.tolerance) {
            return Err(MixedError::Tolerance { found: settings.tolerance });
        }
        let mut surface = Surface::new(self);
        let Ended { iterations, end } = match settings.method {
            Method::ConjugateGradients => conjugate_gradients::solve(&mut surface, settings, watch),
            Method::Verlet => dynamics::verlet(&mut surface, settings, watch),
            Method::VerletCritical => dynamics::verlet_critical(&mut surface, settings, watch),
            Method::Fire => dynamics::fire(&mut surface, settings, watch),
        };
        let shape = self.prescribed.shape();
        let field = |values| Array3::from_shape_vec(shape, values).expect("one value for each entry of the shape");
        let solution = MixedSolution {
            residual: surface.residual(),
            displacement: field(surface.displacement),
            traction: field(surface.traction),
            iterations,
            transform_pairs: surface.elastic.applications * shape[0] as u64,
        };
        match end {
            End::Converged => Ok(solution),
            End::Interrupted => Err(MixedError::Interrupted { solution: Box::new(solution) }),
            End::GaveUp(reason) => {
                Err(MixedError::NotConverged { solution: Box::new(solution), asked: settings.tolerance, reason })
            }
        }
    }
}
