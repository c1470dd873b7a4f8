use std::ops::ControlFlow;

use gfmd_field::Workspace;
use gfmd_response::NormalResponse;
use gfmd_vector::{add, pass, reduce};
use ndarray::{Array2, ArrayView2};

use crate::{ContactError, Residual, Solution, Solver, dual, dynamics};

/// What presses the bodies together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Control {
    /// Mean pressure over the whole surface, in stress.
    MeanPressure(f64),
    /// Rigid approach beyond first touch, in length. On a half-space it is measured against the mean level of the elastic
    /// surface, on a slab against its rigid base.
    Approach(f64),
}

/// How to solve, and how well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The method.
    pub solver: Solver,
    /// Every part of [`Residual`] must fall to this.
    pub tolerance: f64,
    /// Iterations, or time steps, after which the search is given up.
    pub max_iterations: u64,
}

impl Default for Settings {
    /// [`Solver::Auto`] to 1e-8.
    fn default() -> Self {
        Self { solver: Solver::Auto, tolerance: 1e-8, max_iterations: 100_000 }
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

/// A rigid rough surface above an elastic one, without friction or adhesion (hard wall).
pub struct Contact<'a> {
    pub(crate) response: &'a NormalResponse,
    /// Distance from the highest point of the rigid surface down to it: max h − h ≥ 0.
    pub(crate) clearance: Vec<f64>,
    pub(crate) mean_clearance: f64,
    pub(crate) rms_height: f64,
}

impl<'a> Contact<'a> {
    /// `heights` is the rigid profile, peaks pointing at the body, in length; only differences matter.
    ///
    /// # Errors
    /// Heights of another shape than the grid, not finite, or all equal.
    pub fn new(response: &'a NormalResponse, heights: ArrayView2<f64>) -> Result<Self, ContactError> {
        let expected = response.grid().points();
        let found = heights.dim().into();
        if found != expected {
            return Err(ContactError::Shape { found, expected });
        }
        if let Some(((i, j), &value)) = heights.indexed_iter().find(|(_, h)| !h.is_finite()) {
            return Err(ContactError::Height { index: [i, j], value });
        }
        let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let clearance: Vec<f64> = heights.iter().map(|h| highest - h).collect();
        let n = clearance.len() as f64;
        let mean_clearance = gfmd_vector::sum(clearance.len(), &|range| clearance[range].iter().sum()) / n;
        let squares = gfmd_vector::sum(clearance.len(), &|range| {
            clearance[range].iter().map(|c| (c - mean_clearance).powi(2)).sum()
        });
        let rms_height = (squares / n).sqrt();
        if rms_height == 0.0 {
            return Err(ContactError::Flat { value: highest });
        }
        Ok(Self { response, clearance, mean_clearance, rms_height })
    }

    /// Root mean square of the heights about their mean.
    pub fn rms_height(&self) -> f64 {
        self.rms_height
    }

    /// Equilibrates the contact. `start` is a pressure to start from, such as that of a smaller load (it is scaled to
    /// the asked one); without it the start is uniform.
    ///
    /// # Errors
    /// Unusable control, settings or start; or [`ContactError::NotConverged`] and [`ContactError::Interrupted`], which
    /// carry the state reached.
    pub fn solve(
        &self,
        control: Control,
        settings: &Settings,
        start: Option<ArrayView2<f64>>,
        watch: Watch,
    ) -> Result<Solution, ContactError> {
        self.check(control, settings)?;
        let start = start.map(|start| self.check_start(start)).transpose()?;
        let ended = match settings.solver {
            Solver::Auto | Solver::PreconditionedCg | Solver::ProjectedCg | Solver::PolonskyKeer => {
                dual::solve(self, control, settings, start, watch)?
            }
            Solver::Verlet | Solver::VerletCritical | Solver::Fire | Solver::Fire2 | Solver::AugmentedLagrangian => {
                dynamics::solve(self, control, settings, start, watch)?
            }
        };
        let mut solution = self.certify(ended.pressure, control)?;
        solution.iterations = ended.iterations;
        solution.transform_pairs += ended.transform_pairs;
        let solution = Box::new(solution);
        match ended.end {
            End::Interrupted => Err(ContactError::Interrupted { solution }),
            _ if solution.residual.worst() <= settings.tolerance => Ok(*solution),
            End::Converged => {
                let reason = "the recomputed residuals are larger than the solver's".into();
                Err(ContactError::NotConverged { solution, asked: settings.tolerance, reason })
            }
            End::GaveUp(reason) => Err(ContactError::NotConverged { solution, asked: settings.tolerance, reason }),
        }
    }

    /// The state that belongs to `pressure`, with its residuals, from fresh transforms.
    ///
    /// # Errors
    /// A pressure of the wrong length.
    pub fn certify(&self, pressure: Vec<f64>, control: Control) -> Result<Solution, ContactError> {
        let response = self.response;
        let n = pressure.len();
        let mut workspace = response.transform().workspace();
        let mut displacement = vec![0.0; n];
        response.transform().convolve(response.compliance(), &pressure, &mut displacement, &mut workspace)?;
        let [sum, touching] = reduce(
            n,
            &|range| pressure[range].iter().fold([0.0; 2], |sums, p| add(sums, [*p, f64::from(*p > 0.0)])),
            &add,
        );
        let mean_pressure = sum / n as f64;
        let uniform = response.uniform_compliance() * mean_pressure;
        // u_z = −G p; then the mean of clearance − u_z over the contact is where the rigid surface must be.
        let contact_sum = pass(
            [&mut displacement],
            &|start, [u]| {
                let mut sum = 0.0;
                for ((u, c), p) in u.iter_mut().zip(&self.clearance[start..]).zip(&pressure[start..]) {
                    *u = -(*u + uniform);
                    if *p > 0.0 {
                        sum += c - *u;
                    }
                }
                sum
            },
            &|a, b| a + b,
        );
        let approach = match control {
            Control::MeanPressure(_) => contact_sum / touching,
            Control::Approach(approach) => approach,
        };
        let mut gap = vec![0.0; n];
        let sums = pass(
            [&mut gap],
            &|start, [gap]| {
                let mut sums = (0.0, f64::INFINITY, f64::INFINITY);
                let others = self.clearance[start..].iter().zip(&displacement[start..]).zip(&pressure[start..]);
                for (gap, ((c, u), p)) in gap.iter_mut().zip(others) {
                    *gap = c - u - approach;
                    sums = (sums.0 + p * *gap, lower(sums.1, *gap), lower(sums.2, *p));
                }
                sums
            },
            &|a, b| (a.0 + b.0, lower(a.1, b.1), lower(a.2, b.2)),
        );
        let residual = Residual {
            complementarity: if sum == 0.0 { 0.0 } else { (sums.0 / (sum * self.rms_height)).abs() },
            penetration: positive(-sums.1) / self.rms_height,
            negative_pressure: if sum == 0.0 { 0.0 } else { positive(-sums.2) / mean_pressure },
            load: match control {
                Control::MeanPressure(asked) => (mean_pressure - asked).abs() / asked,
                Control::Approach(_) => 0.0,
            },
        };
        let shape = response.grid().points();
        let field = |what, values: Vec<f64>| {
            let found = values.len();
            let shape_error = move |_| gfmd_field::ShapeError { what, found, expected: shape[0] * shape[1] };
            Array2::from_shape_vec(shape, values).map_err(shape_error)
        };
        Ok(Solution {
            pressure: field("pressure", pressure)?,
            displacement: field("displacement", displacement)?,
            gap: field("gap", gap)?,
            mean_pressure,
            approach,
            residual,
            iterations: 0,
            transform_pairs: 1.0,
        })
    }

    fn check(&self, control: Control, settings: &Settings) -> Result<(), ContactError> {
        if !(1e-15..=0.1).contains(&settings.tolerance) {
            return Err(ContactError::Tolerance { found: settings.tolerance });
        }
        match control {
            Control::MeanPressure(found) if !(found > 0.0 && found.is_finite()) => {
                Err(ContactError::MeanPressure { found })
            }
            Control::Approach(found) => {
                let limit = (self.response.uniform_compliance() == 0.0).then_some(self.mean_clearance);
                let reachable = found > 0.0 && found < limit.unwrap_or(f64::INFINITY);
                if reachable { Ok(()) } else { Err(ContactError::Approach { found, limit }) }
            }
            Control::MeanPressure(_) => Ok(()),
        }
    }

    fn check_start(&self, start: ArrayView2<f64>) -> Result<Vec<f64>, ContactError> {
        let expected = self.response.grid().points();
        if <[usize; 2]>::from(start.dim()) != expected {
            return Err(ContactError::Start { reason: format!("{:?} points, {expected:?} are needed", start.dim()) });
        }
        if let Some(((i, j), p)) = start.indexed_iter().find(|(_, p)| !(p.is_finite() && **p >= 0.0)) {
            return Err(ContactError::Start {
                reason: format!("{p} at [{i}, {j}]; it must be finite and not negative"),
            });
        }
        if start.iter().all(|p| *p == 0.0) {
            return Err(ContactError::Start { reason: "it is zero everywhere".into() });
        }
        Ok(start.iter().copied().collect())
    }
}

/// What a solver hands back: the pressure speaks for itself, everything else is derived from it.
pub(crate) struct Ended {
    pub(crate) pressure: Vec<f64>,
    pub(crate) iterations: u64,
    pub(crate) transform_pairs: f64,
    pub(crate) end: End,
}

pub(crate) enum End {
    Converged,
    Interrupted,
    GaveUp(String),
}

/// Transforms of one solve: the workspace, and the count of single transforms.
pub(crate) struct Transforms {
    pub(crate) workspace: Workspace,
    pub(crate) singles: u64,
}

impl Transforms {
    pub(crate) fn new(response: &NormalResponse) -> Self {
        Self { workspace: response.transform().workspace(), singles: 0 }
    }

    pub(crate) fn pairs(&self) -> f64 {
        self.singles as f64 / 2.0
    }
}

/// The smaller of two, NaN if either is.
fn lower(a: f64, b: f64) -> f64 {
    if a.is_nan() || a < b { a } else { b }
}

/// The positive part, NaN of NaN.
fn positive(a: f64) -> f64 {
    if a <= 0.0 { 0.0 } else { a }
}
