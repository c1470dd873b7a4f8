use std::ops::{ControlFlow, Range};

use gfmd_response::{FullResponse, Operator, Workspace};
use gfmd_vector::{for_each, reduce};
use ndarray::Array3;

use crate::{MixedError, MixedSolution, Prescribed, conjugate_gradients, dynamics};

/// The methods. All find the same state; they differ in cost. (docs/solvers.md)
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Method {
    /// Conjugate gradients on the traction of what is held, preconditioned by the stiffness restricted to it.
    #[default]
    ConjugateGradients,
    /// Damped position Verlet of the free displacement, with the scalar damping and time step that suit the range of
    /// stiffnesses best.
    Verlet,
    /// Damped position Verlet with the softest mode critically damped and a quarter of the stable time step, as in the
    /// original method.
    VerletCritical,
    /// The fast inertial relaxation engine (Bitzek et al. 2006).
    Fire,
}

/// How to solve, and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The method.
    pub method: Method,
    /// [`MixedSolution::residual`] must fall to this.
    pub tolerance: f64,
    /// Iterations, or time steps, after which the search is given up.
    pub max_iterations: u64,
}

impl Default for Settings {
    /// [`Method::ConjugateGradients`] to 1e-8.
    fn default() -> Self {
        Self { method: Method::default(), tolerance: 1e-8, max_iterations: 100_000 }
    }
}

/// Where a running solver stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Iterations, or time steps, done.
    pub iteration: u64,
    /// The solver's own estimate of the distance from the solution, comparable with the tolerance.
    pub residual: f64,
}

/// Sees every iteration; may ask to stop.
pub type Watch<'a> = &'a mut dyn FnMut(&Progress) -> ControlFlow<()>;

/// An elastic body with its surface held here and loaded there.
#[derive(Debug)]
pub struct MixedProblem<'a> {
    pub(crate) response: &'a FullResponse,
    pub(crate) prescribed: Prescribed,
}

impl<'a> MixedProblem<'a> {
    /// Poses the problem.
    ///
    /// # Errors
    /// What is prescribed does not fit the grid, holds nothing, or leaves a mean traction undetermined.
    pub fn new(response: &'a FullResponse, prescribed: Prescribed) -> Result<Self, MixedError> {
        let [nx, ny] = response.grid().points();
        let (found, expected) = (prescribed.shape(), [response.components().len(), nx, ny]);
        if found != expected {
            return Err(MixedError::Shape { what: "prescribed values", found, expected });
        }
        let problem = Self { response, prescribed };
        if !problem.prescribed.held().contains(&true) {
            return Err(MixedError::NothingHeld);
        }
        let points = response.grid().len();
        for (component, held) in problem.prescribed.held().chunks_exact(points).enumerate() {
            if problem.floats(component) && !held.contains(&false) {
                return Err(MixedError::Undetermined { component });
            }
        }
        Ok(problem)
    }

    /// What is prescribed.
    pub fn prescribed(&self) -> &Prescribed {
        &self.prescribed
    }

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
            Method::Verlet | Method::VerletCritical | Method::Fire => dynamics::solve(&mut surface, settings, watch),
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

    /// Whether the mean displacement of a component does not answer to its mean traction.
    pub(crate) fn floats(&self, component: usize) -> bool {
        self.response.uniform_compliance()[self.response.components().axes()[component]] == 0.0
    }
}

pub(crate) struct Ended {
    pub(crate) iterations: u64,
    pub(crate) end: End,
}

pub(crate) enum End {
    Converged,
    Interrupted,
    GaveUp(String),
}

/// What every solver works on: a traction that is the given one where the surface is free, and what it does.
pub(crate) struct Surface<'a> {
    pub(crate) problem: &'a MixedProblem<'a>,
    pub(crate) traction: Vec<f64>,
    /// G t, as of the last [`certify`](Self::certify).
    pub(crate) displacement: Vec<f64>,
    /// Prescribed less found displacement where it is held, zero elsewhere; as of the last certify.
    pub(crate) misfit: Vec<f64>,
    /// The largest misfit with no traction where the surface is held.
    pub(crate) scale: f64,
    pub(crate) elastic: Elastic<'a>,
}

/// The operators of the body, with their workspace and a count of their use.
pub(crate) struct Elastic<'a> {
    response: &'a FullResponse,
    workspace: Workspace,
    applications: u64,
}

impl Elastic<'_> {
    /// `out` ← K `field`.
    pub(crate) fn stiffness(&mut self, field: &[f64], out: &mut [f64]) {
        self.apply(self.response.stiffness(), field, out);
    }

    /// `out` ← G `field`.
    pub(crate) fn compliance(&mut self, field: &[f64], out: &mut [f64]) {
        self.apply(self.response.compliance(), field, out);
    }

    fn apply(&mut self, operator: &Operator, field: &[f64], out: &mut [f64]) {
        self.applications += 1;
        operator.apply(field, out, &mut self.workspace).expect("every field has the size of the grid");
    }
}

impl<'a> Surface<'a> {
    fn new(problem: &'a MixedProblem<'a>) -> Self {
        let Prescribed { held, values, .. } = &problem.prescribed;
        let traction: Vec<f64> =
            held.iter().zip(values).map(|(held, value)| if *held { 0.0 } else { *value }).collect();
        let mut surface = Self {
            problem,
            displacement: vec![0.0; traction.len()],
            misfit: vec![0.0; traction.len()],
            traction,
            scale: 1.0,
            elastic: Elastic { response: problem.response, workspace: problem.response.workspace(), applications: 0 },
        };
        surface.certify();
        surface.scale = largest(&surface.misfit);
        surface
    }

    /// Recomputes displacement and misfit from the traction.
    pub(crate) fn certify(&mut self) {
        self.elastic.compliance(&self.traction, &mut self.displacement);
        let (displacement, Prescribed { held, values, .. }) = (&self.displacement, &self.problem.prescribed);
        for_each([&mut self.misfit], &|start, [misfit]| {
            let known = held[start..].iter().zip(&values[start..]);
            for ((misfit, u), (held, value)) in misfit.iter_mut().zip(&displacement[start..]).zip(known) {
                *misfit = if *held { value - u } else { 0.0 };
            }
        });
    }

    /// [`MixedSolution::residual`], as of the last certify.
    pub(crate) fn residual(&self) -> f64 {
        self.relative(largest(&self.misfit))
    }

    /// A misfit over the scale; with no scale there is nothing to solve.
    pub(crate) fn relative(&self, misfit: f64) -> f64 {
        if misfit == 0.0 { 0.0 } else { misfit / self.scale }
    }
}

/// The largest magnitude; NaN if any is.
pub(crate) fn largest(field: &[f64]) -> f64 {
    // Bit patterns of positive numbers are ordered as the numbers are, and NaN comes last.
    let leaf = |range: Range<usize>| field[range].iter().fold(0, |most, value| u64::max(most, value.abs().to_bits()));
    f64::from_bits(reduce(field.len(), &leaf, &u64::max))
}
