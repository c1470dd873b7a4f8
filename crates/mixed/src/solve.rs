use gfmd_relax::{Budget, Ending, Factors, Watch, Why};
use ndarray::Array3;

use crate::surface::Surface;
use crate::{Method, MixedError, MixedProblem, MixedSolution, conjugate_gradients, dynamics};

impl MixedProblem {
    /// Computes the state of a traction, with its residual, by fresh transforms. The effort counts only these.
    ///
    /// # Errors
    /// A traction that differs in shape from the prescribed values.
    pub fn certify(&self, traction: &Array3<f64>) -> Result<MixedSolution, MixedError> {
        let shape = self.prescribed.shape();
        let found = traction.dim().into();
        if found != shape {
            return Err(MixedError::Shape { what: "traction", found, expected: shape });
        }
        let mut surface = Surface::new(self);
        surface.traction = traction.iter().copied().collect();
        surface.certify();
        Ok(self.solution(surface, 0))
    }

    fn solution(&self, surface: Surface, iterations: u64) -> MixedSolution {
        let field = |values| {
            Array3::from_shape_vec(self.prescribed.shape(), values).expect("one value for each entry of the shape")
        };
        MixedSolution {
            residual: surface.residual(),
            iterations,
            transform_pairs: surface.transforms.pairs(),
            displacement: field(surface.displacement),
            traction: field(surface.traction),
        }
    }

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
            Method::VerletCritical => {
                dynamics::damped(&mut surface, Method::TIME_STEP, Factors::Softest(1.0), budget, watch)?
            }
            Method::Damped { time_step, damping } => dynamics::damped(&mut surface, time_step, damping, budget, watch)?,
            Method::VerletModes { time_step } => dynamics::verlet_modes(&mut surface, time_step, budget, watch)?,
            Method::Fire => dynamics::fire(&mut surface, budget, watch)?,
        };
        let most = budget.tolerance / f64::EPSILON * self.response.stiffness_range()[0] * surface.scale;
        let solution = self.solution(surface, iterations);
        // The rounding error of the displacement follows from the softest wave, even if most of the traction deforms
        // the body less. The residual does not show this error, since its transforms round in the same way.
        let is_rounded = solution.traction.iter().any(|t| t.abs() > most);
        let ending = if ending == Ending::Converged && is_rounded { Ending::GaveUp(Why::Rounding) } else { ending };
        match ending {
            Ending::Converged => Ok(solution),
            Ending::Interrupted => Err(MixedError::Interrupted { solution: Box::new(solution) }),
            Ending::GaveUp(why) => {
                Err(MixedError::NotConverged { solution: Box::new(solution), asked: budget.tolerance, why })
            }
        }
    }
}
