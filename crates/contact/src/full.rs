//! Contact with all components of the surface displacement, as in the thesis (theory.md, section 0). The lateral
//! traction is zero, and u_x and u_y are unknown (theory.md, section 3, frictionless).

use std::sync::Arc;

use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_relax::{
    Bounds, Budget, Damping, Factors, Fire, Landscape, Method, ModeDamped, State, Variables as _, Verlet, Visit, Watch,
    damped_by_parts, relax_until, worst,
};
use gfmd_response::{FullResponse, FullTransforms, Hermitian};
use gfmd_vector::{pass, total, with_contiguous};
use ndarray::{Array2, ArrayRef2};

use crate::layer::STIFFNESS_LENGTH;
use crate::solution::{Conditions, field};
use crate::{
    Drive, Dynamics, Effort, Equilibrium, Fields as _, Load, Refusal, Resumable, RigidSurface, Solution, SolveError,
    Solved, Solver, judge,
};

/// Rigid rough surface above an elastic one with all components of the displacement, without friction or adhesion (hard
/// wall), under a prescribed mean pressure. Its u_z equals u_z of [`Contact`](crate::Contact), except in the Nyquist
/// modes of an even grid (theory.md, sections 3 and 0). The cost is three times as high.
#[derive(Clone, Debug)]
pub struct FullContact {
    response: Arc<FullResponse>,
    surface: Arc<RigidSurface>,
    dynamics: Dynamics,
}

/// Equilibrated contact with all components of the displacement.
#[derive(Clone, Debug, PartialEq)]
pub struct FullSolution {
    /// Pressure, gap, u_z, residuals and effort.
    pub normal: Solution,
    /// u_x and u_y, or u_x on a line, in length: the response to the pressure.
    pub lateral: Vec<Array2<f64>>,
    /// Largest remaining lateral traction of the dynamics, relative to the largest pressure.
    pub lateral_traction: f64,
}

impl FullContact {
    /// Solvers of the contact.
    pub const SOLVERS: &[Solver] =
        &[Solver::Auto, Solver::Verlet, Solver::VerletCritical, Solver::VerletModes, Solver::Fire];

    /// Makes the contact of `body` with a rigid profile `heights` on `grid`, in length, with peaks towards the body. A
    /// constant in the heights has no effect.
    ///
    /// # Errors
    /// Heights that differ in shape from the grid, are not finite, or are all equal.
    pub fn new(body: &Body, grid: &Grid, heights: &ArrayRef2<f64>) -> Result<Self, Refusal> {
        Self::with_response(FullResponse::new(*grid, body), heights)
    }

    /// Makes the contact as [`new`](Self::new), with an existing response.
    ///
    /// # Errors
    /// Heights that differ in shape from the grid, are not finite, or are all equal.
    pub fn with_response(response: impl Into<Arc<FullResponse>>, heights: &ArrayRef2<f64>) -> Result<Self, Refusal> {
        let response = response.into();
        let surface = RigidSurface::new(response.grid(), heights)?;
        if surface.rms_height() == 0.0 {
            return Err(Refusal::Flat);
        }
        Ok(Self { response, surface: surface.into(), dynamics: Dynamics::default() })
    }

    /// Sets time step and damping of the damped dynamics. Values out of range are refused at the start of a solve.
    #[must_use]
    pub fn with_dynamics(self, dynamics: Dynamics) -> Self {
        Self { dynamics, ..self }
    }

    /// Computes the state of `pressure` under a mean pressure `load`, from fresh transforms. The lateral traction of
    /// the dynamics does not follow from the pressure and is set to zero.
    ///
    /// # Errors
    /// A pressure that differs in shape from the grid; a load other than a mean pressure.
    pub fn certify(&self, pressure: &ArrayRef2<f64>, load: Load) -> Result<FullSolution, Refusal> {
        let Load::MeanPressure(push) = load else { return Err(Refusal::NoApproach) };
        let [found, expected] = [pressure.dim().into(), self.response.grid().points()];
        if found != expected {
            return Err(Refusal::Shape { found, expected });
        }
        Ok(self.of_pressure(pressure.iter().copied().collect(), push, 0.0))
    }

    /// Returns the rigid surface.
    pub fn surface(&self) -> &RigidSurface {
        &self.surface
    }

    /// Computes the state of the pressure on the wall, from fresh transforms.
    fn certified<Memory>(&self, layer: &Layer, state: &State<Memory>) -> FullSolution {
        let points = self.surface.clearance().len();
        let lateral = state.u.len() - points;
        let mut pressure: Vec<f64> = (lateral..state.u.len())
            .map(|i| if state.u[i] >= layer.wall[i] { state.force[i].max(0.0) } else { 0.0 })
            .collect();
        let sum = total(&pressure);
        if sum > 0.0 {
            let factor = layer.push * points as f64 / sum;
            pressure.iter_mut().for_each(|p| *p *= factor);
        }
        let left = worst(state.force[..lateral].iter().map(|f| f.abs()));
        let mut solution = self.of_pressure(pressure, layer.push, left);
        solution.normal.effort.iterations = state.step;
        solution
    }

    /// Computes the state of a pressure; the dynamics leave a lateral traction of up to `left`.
    fn of_pressure(&self, pressure: Vec<f64>, push: f64, left: f64) -> FullSolution {
        let points = pressure.len();
        let lateral = (self.response.components().len() - 1) * points;
        let mut traction = vec![0.0; lateral + points];
        traction[lateral..].iter_mut().zip(&pressure).for_each(|(t, p)| *t = -p);
        let mut displacement = vec![0.0; lateral + points];
        let mut transforms = FullTransforms::of(&self.response);
        transforms.compliance(&traction, &mut displacement);
        let normal = displacement.split_off(lateral);
        let peak = pressure.iter().copied().fold(0.0, f64::max);
        let lateral = displacement.chunks_exact(points).map(|u| field(&self.surface, u.to_vec())).collect();
        let load = Load::MeanPressure(push);
        let modulus = self.response.contact_modulus();
        let length_scale = self.surface.length_scale(load);
        let conditions = Conditions { sinking: 0.0, load, length_scale, extent: 0.0, hardness: None };
        let mut normal = Solution::of(&self.surface, modulus, pressure, normal, conditions);
        normal.effort = Effort { iterations: 0, transform_pairs: transforms.pairs() };
        FullSolution { normal, lateral, lateral_traction: left / peak }
    }

    /// Returns the start coordinates: the displacement of `start` in the frame of the rigid surface.
    fn starting_position(&self, start: Option<&FullSolution>) -> Result<Vec<f64>, Refusal> {
        let expected = self.response.components().len() * self.response.grid().len();
        let Some(FullSolution { normal, lateral, .. }) = start else { return Ok(vec![0.0; expected]) };
        let mut u: Vec<f64> = lateral.iter().flatten().copied().collect();
        u.extend(normal.displacement.iter().map(|u| u + normal.approach));
        if u.len() == expected { Ok(u) } else { Err(Refusal::Start { found: u.len(), expected }) }
    }
}

impl Equilibrium for FullContact {
    type State = FullSolution;

    fn solvers(&self) -> &'static [Solver] {
        Self::SOLVERS
    }

    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        drive.check()?;
        match drive.load {
            Load::MeanPressure(found) if found > 0.0 => Ok(()),
            Load::MeanPressure(found) => Err(Refusal::MeanPressure { found }),
            Load::Approach(_) => Err(Refusal::NoApproach),
        }
    }

    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        let [softest, _] = self.response.stiffness_range();
        self.surface.check_resolution(drive.load, softest, tolerance)
    }

    /// Relaxes all components by damped dynamics, by default with optimal scalar damping.
    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&FullSolution>,
        watch: &mut dyn Watch,
    ) -> Result<FullSolution, SolveError<FullSolution>> {
        budget.check()?;
        self.check(drive)?;
        self.check_resolution(drive, budget.tolerance)?;
        if !self.solvers().contains(&solver) {
            return Err(Refusal::Solver { found: solver, allowed: self.solvers() }.into());
        }
        let Load::MeanPressure(mean_pressure) = drive.load else { return Err(Refusal::NoApproach.into()) };
        let [softest, stiffest] = self.response.stiffness_range();
        let rigid = mean_pressure / (STIFFNESS_LENGTH * self.surface.rms_height());
        let softest = softest.min(rigid);
        let run = Run { contact: self, mean_pressure, budget, start, watch, pairs_of_damping: 0.0 };
        match solver {
            Solver::Fire => run.relax(&Fire::bitzek(Fire::largest_dt(stiffest))),
            Solver::VerletCritical => {
                let dt = self.dynamics.step(stiffest)?;
                match self.dynamics.damping {
                    Factors::Softest(factor) => {
                        run.relax(&Verlet::new(Damping::times_critical(factor, softest, stiffest, dt)?, stiffest)?)
                    }
                    Factors::Components(factors) => {
                        let axes = self.response.components().axes();
                        let along = |numbers: [f64; 3]| axes.iter().map(|axis| numbers[*axis]).collect::<Vec<_>>();
                        let stiffnesses = along(self.response.uniform_stiffness());
                        run.relax(&damped_by_parts(&along(factors), &stiffnesses, stiffest, dt)?)
                    }
                }
            }
            Solver::VerletModes => {
                let dt = self.dynamics.step_of_modes([softest, stiffest])?;
                let beta = |k: f64| Damping::critical(k, dt).beta;
                let retained = self.response.stiffness().map(|mode, matrix| {
                    if mode.is_uniform() {
                        // The push moves the body as a whole against the contact; along x and y a half-space has no
                        // stiffness.
                        Hermitian::diagonal([matrix.xx.max(softest), matrix.yy.max(softest), rigid].map(beta))
                    } else {
                        matrix.function(beta)
                    }
                });
                let pairs_of_damping = self.response.components().len() as f64;
                let method = ModeDamped::critical(dt * dt, retained.in_place());
                Run { pairs_of_damping, ..run }.relax(&method)
            }
            _ => run.relax(&Verlet::optimal(softest, stiffest)?),
        }
    }
}

/// One solve.
struct Run<'a> {
    contact: &'a FullContact,
    mean_pressure: f64,
    budget: &'a Budget,
    start: Option<&'a FullSolution>,
    watch: &'a mut dyn Watch,
    /// Number of transform pairs for the damping of one step.
    pairs_of_damping: f64,
}

impl Run<'_> {
    fn relax<M: Method>(self, method: &M) -> Result<FullSolution, SolveError<FullSolution>> {
        let Self { contact, mean_pressure, budget, start, watch, pairs_of_damping } = self;
        let mut layer = Layer::new(contact, mean_pressure);
        let mut state = method.start(&mut layer, contact.starting_position(start)?)?;
        let mut certify = |layer: &mut Layer, state: &State<_>| {
            let solution = contact.certified(layer, state);
            layer.certified += solution.effort().transform_pairs;
            solution.worst()
        };
        let ending = relax_until(&mut layer, method, &mut state, budget, &mut certify, watch)?;
        let mut solution = contact.certified(&layer, &state);
        let damping = pairs_of_damping * state.step as f64;
        solution.normal.effort.transform_pairs += layer.certified + layer.transforms.pairs() + damping;
        judge(solution, ending, budget.tolerance)
    }
}

/// The state follows from its pressure, except for the lateral traction left by the dynamics.
impl Resumable for FullContact {
    fn keep(&self, state: &mut FullSolution, visitor: &mut dyn Visit) {
        with_contiguous(&mut state.normal.pressure, |pressure| visitor.field(pressure));
        visitor.number(&mut state.lateral_traction);
        state.normal.effort.visit(visitor);
    }

    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<FullSolution, Refusal> {
        self.check(drive)?;
        let Load::MeanPressure(push) = drive.load else { return Err(Refusal::NoApproach) };
        let mut pressure = vec![0.0; self.surface.clearance().len()];
        visitor.field(&mut pressure);
        let mut state = self.of_pressure(pressure, push, 0.0);
        visitor.number(&mut state.lateral_traction);
        state.normal.effort.visit(visitor);
        Ok(state)
    }
}

impl Solved for FullSolution {
    type Inner = Solution;

    fn solution(&self) -> &Solution {
        &self.normal
    }

    fn further_residual(&self) -> Option<(&'static str, f64)> {
        Some(("lateral_traction", self.lateral_traction))
    }
}

/// Elastic surface layer below a rigid wall, which bounds u_z only.
struct Layer<'a> {
    contact: &'a FullContact,
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
    fn new(contact: &'a FullContact, push: f64) -> Self {
        let FullContact { response, surface, .. } = contact;
        let mut wall = vec![f64::INFINITY; (response.components().len() - 1) * response.grid().len()];
        wall.extend(surface.clearance());
        // The uniform mode is recognised by its index, the first, never by a small wavenumber.
        let uniform = response.stiffness().matrices()[0].zz;
        Self { contact, wall, push, uniform, transforms: FullTransforms::of(response), certified: 0.0 }
    }
}

impl Landscape for Layer<'_> {
    fn len(&self) -> usize {
        self.wall.len()
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        self.transforms.stiffness(u, force);
        let points = self.contact.surface.clearance().len();
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
        self.bounds().natural_residual(u, force, self.push, self.contact.surface.rms_height())
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.count(self.transforms.counter());
        visitor.number(&mut self.certified);
    }
}
