use gfmd_relax::{Budget, Ending, Watch};
use ndarray::Array3;

use crate::surface::Surface;
use crate::{Method, MixedError, MixedProblem, MixedSolution, conjugate_gradients, dynamics};

impl MixedProblem {
    /// Finds displacement and traction of the whole surface.
    ///
    /// # Errors
    /// A tolerance out of range; or [`MixedError::NotConverged`] and [`MixedError::Interrupted`], which carry the state
    /// reached.
    pub fn solve(&self, method: Method, budget: &Budget, watch: &mut dyn Watch) -> Result<MixedSolution, MixedError> {
        budget.check()?;
        let mut surface = Surface::new(self);
        let (iterations, ending) = match method {
            Method::ConjugateGradients => conjugate_gradients::solve(&mut surface, budget, watch),
            Method::Verlet => dynamics::verlet(&mut surface, budget, watch)?,
            Method::VerletCritical => dynamics::verlet_critical(&mut surface, budget, watch)?,
            Method::Fire => dynamics::fire(&mut surface, budget, watch)?,
        };
        let shape = self.prescribed.shape();
        let field = |values| Array3::from_shape_vec(shape, values).expect("one value for each entry of the shape");
        let solution = MixedSolution {
            residual: surface.residual(),
            displacement: field(surface.displacement),
            traction: field(surface.traction),
            iterations,
            transform_pairs: surface.transforms.pairs(),
        };
        match ending {
            Ending::Converged => Ok(solution),
            Ending::Interrupted => Err(MixedError::Interrupted { solution: Box::new(solution) }),
            Ending::GaveUp(why) => {
                Err(MixedError::NotConverged { solution: Box::new(solution), asked: budget.tolerance, why })
            }
        }
    }
}
