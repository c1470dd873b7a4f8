//! The contact with every component of the surface moving, as the source of the method poses it: nothing is known of
//! u_x and u_y but that no traction acts on them (theory.md, section 3, frictionless).

use gfmd_relax::{Bounds, Landscape, Method, Outcome, RelaxError, State, Stop, Verlet, relax};
use gfmd_response::{FullResponse, Workspace};
use gfmd_vector::{pass, sum};
use ndarray::{Array2, ArrayView2};

use crate::dynamics::{FITS, SETTLED, STIFFNESS_LENGTH};
use crate::wall::Wall;
use crate::{ContactError, Control, Progress, Solution, Watch};

/// A rigid rough surface above an elastic one that moves in all its components, without friction or adhesion (hard wall).
///
/// Its u_z is that of [`Contact`](crate::Contact), but for the Nyquist modes of an even grid (theory.md, section 0).
pub struct FullContact<'a> {
    response: &'a FullResponse,
    wall: Wall,
}

/// An equilibrated contact with all components of the displacement.
#[derive(Clone, Debug, PartialEq)]
pub struct FullSolution {
    /// Pressure, gap, residuals and what else concerns u_z. Its transform pairs are those of one component.
    pub normal: Solution,
    /// u_x and u_y, or u_x of a line, in length: what the pressure alone does to them.
    pub lateral: Vec<Array2<f64>>,
    /// Largest lateral traction that the dynamics left, over the largest pressure.
    pub lateral_traction: f64,
}

impl<'a> FullContact<'a> {
    /// `heights` is the rigid profile, peaks pointing at the body, in length; only differences matter.
    ///
    /// # Errors
    /// Heights of another shape than the grid, not finite, or all equal.
    pub fn new(response: &'a FullResponse, heights: ArrayView2<f64>) -> Result<Self, ContactError> {
        Ok(Self { response, wall: Wall::new(response.grid().points(), heights)? })
    }

    /// Presses with `mean_pressure`, by damped dynamics of all components with the best scalar damping, until the
    /// residuals and the lateral tractions have fallen to `tolerance`.
    ///
    /// # Errors
    /// An unusable load or tolerance; or [`ContactError::NotConverged`] after `max_steps` and
    /// [`ContactError::Interrupted`], which carry the state reached.
    pub fn press(
        &self,
        mean_pressure: f64,
        tolerance: f64,
        max_steps: u64,
        watch: Watch,
    ) -> Result<FullSolution, ContactError> {
        if !(1e-15..=0.1).contains(&tolerance) {
            return Err(ContactError::Tolerance { found: tolerance });
        }
        if !(mean_pressure > 0.0 && mean_pressure.is_finite()) {
            return Err(ContactError::MeanPressure { found: mean_pressure });
        }
        let mut layer = Layer::new(self, mean_pressure);
        let [softest, stiffest] = self.response.stiffness_range();
        let rigid = mean_pressure / (STIFFNESS_LENGTH * self.wall.rms_height);
        let unusable = |error: RelaxError| ContactError::Start { reason: error.to_string() };
        let verlet = Verlet::optimal(softest.min(rigid), stiffest).map_err(unusable)?;
        let start = vec![0.0; layer.len()];
        let mut state = verlet.start(&mut layer, start).map_err(unusable)?;
        let mut observe = |now: &gfmd_relax::Progress, _: &_| {
            Ok::<_, std::io::Error>(watch(&Progress { iteration: now.step, residual: now.residual }))
        };
        let mut stop = Stop { residual: tolerance, settled: SETTLED, max_steps };
        loop {
            let outcome = relax(&mut layer, &verlet, &mut state, &stop, &mut observe);
            let mut solution = self.certify(&layer, &state)?;
            solution.normal.iterations = state.step;
            let pairs = (state.evaluations * self.response.components().len() as u64) as f64;
            solution.normal.transform_pairs += pairs;
            let worst = gfmd_relax::worst([solution.normal.residual.worst(), solution.lateral_traction]);
            match outcome {
                Ok(Outcome::Converged(_)) if worst <= tolerance => return Ok(solution),
                Ok(Outcome::Converged(now)) => {
                    stop.residual = now.residual * (0.5 * tolerance / worst).clamp(1e-3, 0.5);
                }
                Ok(Outcome::Interrupted(_)) => {
                    return Err(ContactError::Interrupted { solution: Box::new(solution.normal) });
                }
                Err(error) => {
                    let (solution, reason) = (Box::new(solution.normal), error.to_string());
                    return Err(ContactError::NotConverged { solution, asked: tolerance, reason });
                }
            }
        }
    }

    /// From the force on the wall alone, with a fresh transform.
    fn certify<Memory>(&self, layer: &Layer, state: &State<Memory>) -> Result<FullSolution, ContactError> {
        let points = self.wall.clearance.len();
        let lateral = state.u.len() - points;
        let mut pressure: Vec<f64> = (lateral..state.u.len())
            .map(|i| if state.u[i] >= layer.wall[i] { state.force[i].max(0.0) } else { 0.0 })
            .collect();
        let total = sum(points, &|range| pressure[range].iter().sum());
        if total > 0.0 {
            let factor = layer.push * points as f64 / total;
            pressure.iter_mut().for_each(|p| *p *= factor);
        }
        let mut traction = vec![0.0; state.u.len()];
        traction[lateral..].iter_mut().zip(&pressure).for_each(|(t, p)| *t = -p);
        let mut displacement = vec![0.0; state.u.len()];
        self.response.compliance().apply(&traction, &mut displacement, &mut self.response.workspace())?;
        let normal = displacement.split_off(lateral);
        let peak = pressure.iter().copied().fold(0.0, f64::max);
        let left = gfmd_relax::worst(state.force[..lateral].iter().map(|f| f.abs()));
        let field = |values: &[f64]| {
            let [nx, ny] = self.wall.points;
            Array2::from_shape_fn((nx, ny), |(i, j)| values[i * ny + j])
        };
        let lateral = displacement.chunks_exact(points).map(field).collect();
        let mut normal = self.wall.certify(pressure, normal, Control::MeanPressure(layer.push))?;
        normal.transform_pairs = self.response.components().len() as f64;
        Ok(FullSolution { normal, lateral, lateral_traction: left / peak })
    }
}

/// The elastic surface layer below a rigid wall, which bounds u_z only.
struct Layer<'a> {
    response: &'a FullResponse,
    wall: Vec<f64>,
    /// Uniform force per area that pushes the body up.
    push: f64,
    /// K_zz(0), which the push does not have to overcome: only the body's base would feel it.
    uniform: f64,
    length_scale: f64,
    workspace: Workspace,
}

impl<'a> Layer<'a> {
    fn new(contact: &FullContact<'a>, push: f64) -> Self {
        let FullContact { response, wall } = contact;
        let points = wall.clearance.len();
        let mut bounds = vec![f64::INFINITY; (response.components().len() - 1) * points];
        bounds.extend(&wall.clearance);
        // By index, never by value: the uniform mode is the first.
        let uniform = response.stiffness().matrices()[0].zz;
        let workspace = response.workspace();
        Self { response, wall: bounds, push, uniform, length_scale: wall.rms_height, workspace }
    }
}

impl Landscape for Layer<'_> {
    fn len(&self) -> usize {
        self.wall.len()
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        self.response.stiffness().apply(u, force, &mut self.workspace).expect(FITS);
        let points = self.response.grid().len();
        let first = u.len() - points;
        let mean = sum(points, &|range| u[first..][range].iter().sum()) / points as f64;
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
        self.bounds().natural_residual(u, force, self.push, self.length_scale)
    }
}
