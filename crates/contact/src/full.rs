//! Contact with all components of the surface displacement, as in the thesis (theory.md, section 0): damped dynamics
//! move u_x, u_y and u_z, without lateral traction (theory.md, section 3, frictionless).

use std::sync::Arc;

use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_relax::{
    Bounds, Budget, Damping, Factors, Fire, Landscape, Method, ModeDamped, State, Verlet, Visit, Watch,
    damped_by_parts, relax_until, worst,
};
use gfmd_response::{FullResponse, FullTransforms, Hermitian, NormalResponse};
use gfmd_vector::{pass, total};
use ndarray::Array2;

use crate::layer::STIFFNESS_LENGTH;
use crate::{Contact, Fields as _, Heights, Lateral, Load, Refusal, Solution, SolveError, Solver, judge};

impl Contact {
    /// Solvers of a contact [in all components](Self::in_all_components): the dynamics.
    pub const ALL_COMPONENTS_SOLVERS: [Solver; 5] =
        [Solver::Auto, Solver::Verlet, Solver::VerletCritical, Solver::VerletModes, Solver::Fire];

    /// Makes the contact as [`new`](Self::new), under a prescribed mean pressure, with all components of the
    /// displacement as unknowns of the dynamics. Its u_z equals u_z of [`new`](Self::new), except in the Nyquist modes
    /// of an even grid (theory.md, sections 3 and 0). The cost is three times as high.
    ///
    /// # Errors
    /// Heights that differ in shape from the grid, are not finite, or are all equal.
    pub fn in_all_components<'a>(body: &Body, grid: &Grid, heights: impl Into<Heights<'a>>) -> Result<Self, Refusal> {
        Self::with_full_response(FullResponse::new(*grid, body), heights)
    }

    /// Makes the contact as [`in_all_components`](Self::in_all_components), with an existing response.
    ///
    /// # Errors
    /// Heights that differ in shape from the grid, are not finite, or are all equal.
    pub fn with_full_response<'a>(
        response: impl Into<Arc<FullResponse>>,
        heights: impl Into<Heights<'a>>,
    ) -> Result<Self, Refusal> {
        let response = response.into();
        let mut contact = Self::with_response(NormalResponse::of_all_components(&response), heights)?;
        contact.all_components = Some(response);
        Ok(contact)
    }
}

/// Computes the lateral displacement by a pressure, and the number of transform pairs that this takes.
pub(crate) fn lateral_by(pressure: &Array2<f64>, response: &Arc<FullResponse>) -> (Lateral, f64) {
    let (shape, points) = (pressure.raw_dim(), pressure.len());
    let lateral = response.components().normal() * points;
    let mut traction = vec![0.0; lateral + points];
    traction[lateral..].iter_mut().zip(pressure).for_each(|(t, p)| *t = -p);
    let mut displacement = vec![0.0; lateral + points];
    let mut transforms = FullTransforms::of(response);
    transforms.compliance(&traction, &mut displacement);
    let along = displacement[..lateral].chunks_exact(points);
    let displacement = along.map(|u| Array2::from_shape_fn(shape, |(i, j)| u[i * shape[1] + j])).collect();
    (Lateral { displacement, traction: 0.0 }, transforms.pairs())
}

/// Moves all components by damped dynamics under a mean pressure, by default with optimal scalar damping.
pub(crate) fn solve(
    contact: &Contact,
    response: &Arc<FullResponse>,
    (mean_pressure, solver): (f64, Solver),
    budget: &Budget,
    start: Option<&Solution>,
    watch: &mut dyn Watch,
) -> Result<Solution, SolveError<Solution>> {
    let [softest, stiffest] = response.stiffness_range();
    let rigid = mean_pressure / (STIFFNESS_LENGTH * contact.scaled.rms_height());
    let softest = softest.min(rigid);
    let run = Run { contact, response, mean_pressure, budget, start, watch, pairs_of_damping: 0.0 };
    match solver {
        Solver::Fire => run.relax(&Fire::bitzek(Fire::largest_dt(stiffest))),
        Solver::VerletCritical => {
            let dt = contact.dynamics.step(stiffest)?;
            match contact.dynamics.damping {
                Factors::Softest(factor) => {
                    run.relax(&Verlet::new(Damping::times_critical(factor, softest, stiffest, dt)?, stiffest)?)
                }
                Factors::Components(factors) => {
                    let axes = response.components().axes();
                    let along = |numbers: [f64; 3]| axes.iter().map(|axis| numbers[*axis]).collect::<Vec<_>>();
                    let stiffnesses = along(response.uniform_stiffness());
                    run.relax(&damped_by_parts(&along(factors), &stiffnesses, stiffest, dt)?)
                }
            }
        }
        Solver::VerletModes => {
            let dt = contact.dynamics.step_of_modes([softest, stiffest])?;
            let beta = |k: f64| Damping::critical(k, dt).beta;
            let retained = response.stiffness().map(|mode, matrix| {
                if mode.is_uniform() {
                    // The push moves the body as a whole against the contact; along x and y a half-space has no
                    // stiffness.
                    Hermitian::diagonal([matrix.xx.max(softest), matrix.yy.max(softest), rigid].map(beta))
                } else {
                    matrix.function(beta)
                }
            });
            let pairs_of_damping = response.components().len() as f64;
            let method = ModeDamped::critical(dt * dt, retained.in_place());
            Run { pairs_of_damping, ..run }.relax(&method)
        }
        _ => run.relax(&Verlet::optimal(softest, stiffest)?),
    }
}

/// One solve.
struct Run<'a> {
    contact: &'a Contact,
    response: &'a Arc<FullResponse>,
    mean_pressure: f64,
    budget: &'a Budget,
    start: Option<&'a Solution>,
    watch: &'a mut dyn Watch,
    /// Number of transform pairs for the damping of one step.
    pairs_of_damping: f64,
}

impl Run<'_> {
    fn relax<M: Method>(self, method: &M) -> Result<Solution, SolveError<Solution>> {
        let start = self.starting_position()?;
        let Self { contact, response, mean_pressure, budget, watch, pairs_of_damping, .. } = self;
        let mut layer = Layer::new(contact, response, mean_pressure);
        let mut state = method.start(&mut layer, start)?;
        let mut certify = |layer: &mut Layer, state: &State<_>| {
            let solution = layer.certified(state);
            layer.certified += solution.effort.transform_pairs;
            solution.worst()
        };
        let ending = relax_until(&mut layer, method, &mut state, budget, &mut certify, watch)?;
        let mut solution = layer.certified(&state);
        let damping = pairs_of_damping * state.step as f64;
        solution.effort.transform_pairs += layer.certified + layer.transforms.pairs() + damping;
        judge(solution, ending, budget.tolerance)
    }

    /// Returns the start coordinates: the displacement of the start in the frame of the rigid surface.
    fn starting_position(&self) -> Result<Vec<f64>, Refusal> {
        let expected = self.response.components().len() * self.response.grid().len();
        let Some(start) = self.start else { return Ok(vec![0.0; expected]) };
        self.contact.check_size(start.pressure.view())?;
        let lateral = start.lateral.clone().unwrap_or_else(|| lateral_by(&start.pressure, self.response).0);
        let mut u: Vec<f64> = lateral.displacement.into_iter().flatten().collect();
        u.extend(start.displacement.iter().map(|u| u + start.approach));
        if u.len() == expected { Ok(u) } else { Err(Refusal::Start { found: u.len(), expected }) }
    }
}

/// Elastic surface layer below a rigid wall, which bounds u_z only.
struct Layer<'a> {
    contact: &'a Contact,
    wall: Vec<f64>,
    /// Uniform force per area that pushes the body up.
    push: f64,
    /// K_zz(0), which is subtracted from the elastic force, since the push also acts on the base of the body.
    uniform: f64,
    transforms: FullTransforms,
    /// Number of transform pairs for certificates.
    certified: f64,
}

impl<'a> Layer<'a> {
    fn new(contact: &'a Contact, response: &Arc<FullResponse>, push: f64) -> Self {
        let mut wall = vec![f64::INFINITY; response.components().normal() * response.grid().len()];
        wall.extend(contact.scaled.clearance().iter());
        // The uniform mode is recognised by its index, the first, never by a small wavenumber.
        let uniform = response.stiffness().matrices()[0].zz;
        Self { contact, wall, push, uniform, transforms: FullTransforms::of(response), certified: 0.0 }
    }

    /// Computes the state of the pressure on the wall, from fresh transforms.
    fn certified<Memory>(&self, state: &State<Memory>) -> Solution {
        let points = self.contact.scaled.clearance().len();
        let lateral = state.u.len() - points;
        let mut pressure: Vec<f64> = (lateral..state.u.len())
            .map(|i| if state.u[i] >= self.wall[i] { state.force[i].max(0.0) } else { 0.0 })
            .collect();
        let sum = total(&pressure);
        if sum > 0.0 {
            let factor = self.push * points as f64 / sum;
            pressure.iter_mut().for_each(|p| *p *= factor);
        }
        let left = worst(state.force[..lateral].iter().map(|f| f.abs()));
        let peak = pressure.iter().copied().fold(0.0, f64::max);
        let mut solution = self.contact.certified(pressure, Load::MeanPressure(self.push));
        if let Some(lateral) = &mut solution.lateral {
            lateral.traction = left / peak;
        }
        solution.effort.iterations = state.step;
        solution
    }
}

impl Landscape for Layer<'_> {
    fn len(&self) -> usize {
        self.wall.len()
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        self.transforms.stiffness(u, force);
        let points = self.contact.scaled.clearance().len();
        let first = u.len() - points;
        let mean = total(&u[first..]) / points as f64;
        let lift = self.uniform * mean;
        pass(
            [force],
            &|start, [force]| {
                let mut energy = 0.0;
                for (i, (f, u)) in (start..).zip(force.iter_mut().zip(&u[start..])) {
                    let (lift, push) = if i >= first { (lift, self.push) } else { (0.0, 0.0) };
                    let elastic = *f - lift;
                    energy += u * (0.5 * elastic - push);
                    *f = push - elastic;
                }
                energy
            },
            &|a, b| a + b,
        )
    }

    fn bounds(&self) -> Bounds<'_> {
        Bounds::Upper(&self.wall)
    }

    fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
        self.bounds().natural_residual(u, force, self.push, self.contact.scaled.rms_height())
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.count(self.transforms.counter());
        visitor.number(&mut self.certified);
    }
}
