use std::ops::ControlFlow;

use gfmd_field::Grid;
use gfmd_law::{HardWall, Law};
use gfmd_response::{FullResponse, NormalResponse};
use ndarray::ArrayView2;

use crate::certify::certify;
use crate::dynamics;
use crate::elastic::{Elastic, mean};
use crate::newton::{self, End};
use crate::{InterfaceError, State};

/// What moves the rigid surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drive {
    /// Towards the body.
    pub normal: Normal,
    /// Along x and y: displacement of the rigid surface, length. Counts in problems with all components; on a half-space
    /// it is measured against the mean of the elastic surface, on a slab against its base.
    pub lateral: [f64; 2],
}

/// What presses the surfaces together, or pulls them apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Normal {
    /// Mean pressure over the whole surface, stress; negative pulls.
    MeanPressure(f64),
    /// Rigid approach beyond first touch of the undeformed surfaces, length; negative apart. On a half-space it is measured
    /// against the mean level of the elastic surface, on a slab against its rigid base.
    Approach(f64),
}

impl Drive {
    /// Without lateral displacement.
    pub fn mean_pressure(pressure: f64) -> Self {
        Self { normal: Normal::MeanPressure(pressure), lateral: [0.0; 2] }
    }

    /// Without lateral displacement.
    pub fn approach(approach: f64) -> Self {
        Self { normal: Normal::Approach(approach), lateral: [0.0; 2] }
    }

    pub(crate) fn check(&self) -> Result<(), InterfaceError> {
        let normal = match self.normal {
            Normal::MeanPressure(found) => ("mean pressure", found),
            Normal::Approach(found) => ("approach", found),
        };
        let all = [normal, ("lateral displacement", self.lateral[0]), ("lateral displacement", self.lateral[1])];
        match all.into_iter().find(|(_, found)| !found.is_finite()) {
            Some((what, found)) => Err(InterfaceError::Drive { what, found }),
            None => Ok(()),
        }
    }
}

/// How to look for a state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// [`Newton`](Self::Newton) where there is an energy, [`Dynamics`](Self::Dynamics) else.
    #[default]
    Auto,
    /// Newton steps downhill in energy.
    Newton,
    /// Damped dynamics (FIRE): for laws without an energy, and as an independent check. Not with a wall under prescribed
    /// approach on a half-space.
    Dynamics,
}

/// How well to solve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// The method.
    pub method: Method,
    /// Every part of [`Residual`](crate::Residual) must fall to this.
    pub tolerance: f64,
    /// Steps, or time steps, after which the search is given up.
    pub max_iterations: u64,
}

impl Default for Settings {
    /// To 1e-8.
    fn default() -> Self {
        Self { method: Method::Auto, tolerance: 1e-8, max_iterations: 100_000 }
    }
}

impl Settings {
    pub(crate) fn check(&self) -> Result<(), InterfaceError> {
        let found = self.tolerance;
        if (1e-14..=0.1).contains(&found) { Ok(()) } else { Err(InterfaceError::Tolerance { found }) }
    }
}

/// Where a running solver stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Steps done.
    pub iteration: u64,
    /// The solver's own estimate of the residual.
    pub residual: f64,
}

/// Sees every step; may ask to stop.
pub type Watch<'a> = &'a mut dyn FnMut(&Progress) -> ControlFlow<()>;

/// A law steeper than the grid can follow: nodes snap one by one where a continuous surface would peel or heal.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "lattice trapping: the attraction falls off with {steepness:.3e}, more than half of {stiffness:.3e}, the stiffness \
     (stress/length) of the shortest wave on this grid; refine the grid or take a longer range"
)]
pub struct Trapping {
    /// [`Law::steepness`].
    pub steepness: f64,
    /// Stiffness of the body at the corner of the spectrum.
    pub stiffness: f64,
}

/// A rigid rough surface above an elastic one, with a law that acts between them.
pub struct Interface<'a> {
    pub(crate) elastic: Elastic<'a>,
    pub(crate) law: &'a dyn Law,
    /// Distance from the highest point of the rigid surface down to it: max h − h ≥ 0.
    pub(crate) clearance: Vec<f64>,
    pub(crate) rms_height: f64,
}

impl<'a> Interface<'a> {
    /// In u_z alone, free to slide: `heights` is the rigid profile, peaks pointing at the body, length; only differences
    /// matter.
    ///
    /// # Errors
    /// Heights of another shape than the grid, or not finite.
    pub fn normal(
        response: &'a NormalResponse,
        heights: ArrayView2<f64>,
        law: &'a dyn Law,
    ) -> Result<Self, InterfaceError> {
        Self::new(Elastic::Normal(response), heights, law)
    }

    /// In all components.
    ///
    /// # Errors
    /// As [`normal`](Self::normal).
    pub fn full(
        response: &'a FullResponse,
        heights: ArrayView2<f64>,
        law: &'a dyn Law,
    ) -> Result<Self, InterfaceError> {
        Self::new(Elastic::Full(response), heights, law)
    }

    fn new(elastic: Elastic<'a>, heights: ArrayView2<f64>, law: &'a dyn Law) -> Result<Self, InterfaceError> {
        let (clearance, rms_height) = heights_to_clearance(heights, elastic.grid())?;
        Ok(Self { elastic, law, clearance, rms_height })
    }

    /// Whether law and components have an energy: without sliding, every law has one.
    pub fn has_energy(&self) -> bool {
        self.elastic.components() == 1 || self.law.energy(0.0, 0.0).is_some()
    }

    /// Whether the law is too steep for the grid (theory.md, section 8). A warning, not an error: the states are right
    /// for the discrete surface.
    pub fn trapping(&self) -> Option<Trapping> {
        let [_, stiffness] = self.elastic.stiffness_range();
        let steepness = self.law.steepness();
        (steepness > 0.5 * stiffness).then_some(Trapping { steepness, stiffness })
    }

    /// Goes downhill from `start` to a stable state. Without one, from the contact with a hard wall alone if the drive
    /// presses, else from the undeformed surface.
    ///
    /// # Errors
    /// Unusable drive, settings or start; or an error that carries the state reached.
    pub fn solve(
        &self,
        drive: Drive,
        settings: &Settings,
        start: Option<&State>,
        watch: Watch,
    ) -> Result<State, InterfaceError> {
        settings.check()?;
        self.check(drive)?;
        let expected = self.elastic.components() * self.clearance.len();
        if let Some(found) = start.map(|state| state.displacement.len()).filter(|found| *found != expected) {
            return Err(InterfaceError::Start { found, expected });
        }
        let pressed = match drive.normal {
            Normal::MeanPressure(found) | Normal::Approach(found) => found > 0.0,
        };
        if start.is_none() && pressed && !self.is_wall_alone() {
            return self.solve(drive, settings, Some(&self.without_attraction(drive, settings, watch)?), watch);
        }
        let has_energy = self.has_energy();
        let ended = match settings.method {
            Method::Newton if !has_energy => return Err(InterfaceError::NoEnergy),
            Method::Dynamics if self.law.has_wall() && self.frame(drive).held.last() == Some(&true) => {
                return Err(InterfaceError::NoDynamics);
            }
            Method::Dynamics => dynamics::relax_to_rest(self, drive, settings, start, watch),
            Method::Auto if !has_energy => dynamics::relax_to_rest(self, drive, settings, start, watch),
            Method::Auto | Method::Newton => newton::descend(self, drive, settings, start, watch),
        };
        let mut state = certify(self, drive, &ended.position);
        state.iterations = ended.iterations;
        state.transform_pairs += ended.transform_pairs;
        state.passed_instability = ended.passed_instability;
        state.lowest_curvature = ended.lowest_curvature;
        let state = Box::new(state);
        let not_converged = |state, reason| InterfaceError::NotConverged { state, asked: settings.tolerance, reason };
        match (ended.end, drive.normal) {
            (End::Interrupted, _) => Err(InterfaceError::Interrupted { state }),
            (End::Detached, Normal::MeanPressure(mean_pressure)) => {
                Err(InterfaceError::Detached { mean_pressure, state })
            }
            _ if state.residual.worst() <= settings.tolerance => Ok(*state),
            (End::GaveUp(reason), _) => Err(not_converged(state, reason)),
            _ => Err(not_converged(state, "the recomputed residuals are larger than the solver's")),
        }
    }

    /// Whether a drive can be posed.
    ///
    /// # Errors
    /// Numbers that are not finite, or an approach beyond full contact.
    pub fn check(&self, drive: Drive) -> Result<(), InterfaceError> {
        drive.check()?;
        if let Normal::Approach(found) = drive.normal {
            let limit = mean(&self.clearance);
            let held = self.frame(drive).held;
            if self.law.has_wall() && held[held.len() - 1] && found >= limit {
                return Err(InterfaceError::Approach { found, limit });
            }
        }
        Ok(())
    }

    /// Root mean square of the heights about their mean.
    pub fn rms_height(&self) -> f64 {
        self.rms_height
    }

    fn is_wall_alone(&self) -> bool {
        self.law.has_wall() && self.law.stiffness_bound(0.0) == 0.0 && self.law.steepness() == 0.0
    }

    /// The contact before the law acts.
    fn without_attraction(&self, drive: Drive, settings: &Settings, watch: Watch) -> Result<State, InterfaceError> {
        let wall = Interface { law: &HardWall, clearance: self.clearance.clone(), ..*self };
        let rough = Settings { method: Method::Newton, tolerance: settings.tolerance.max(1e-3), ..*settings };
        wall.solve(drive, &rough, None, watch)
    }

    /// What counts as a length: the rms height, 1 of a flat surface.
    pub(crate) fn length_scale(&self) -> f64 {
        if self.rms_height > 0.0 { self.rms_height } else { 1.0 }
    }

    /// The frame in which a drive is solved.
    pub(crate) fn frame(&self, drive: Drive) -> Frame {
        let uniform = self.elastic.uniform_compliance();
        let mut stiffness: Vec<f64> = uniform.iter().map(|g| if *g > 0.0 { 1.0 / g } else { 0.0 }).collect();
        let mut held: Vec<bool> = uniform.iter().map(|g| *g == 0.0).collect();
        let z = uniform.len() - 1;
        let (push, approach) = match drive.normal {
            Normal::MeanPressure(mean) => {
                (stiffness[z], held[z]) = (0.0, false);
                (mean, 0.0)
            }
            Normal::Approach(approach) => (0.0, approach),
        };
        Frame { uniform_stiffness: stiffness, held, push, approach, lateral: drive.lateral }
    }

    /// Where a search begins, in the frame of the drive: at `start`, with the points that the wall pressed still on it, or
    /// undeformed but for what would interpenetrate.
    pub(crate) fn starting_position(&self, drive: Drive, start: Option<&State>) -> Vec<f64> {
        let points = self.clearance.len();
        let mut position = vec![0.0; self.elastic.components() * points];
        let z = position.len() - points;
        let approach = if let Normal::Approach(approach) = drive.normal { approach } else { 0.0 };
        let wall = self.clearance.iter().map(|c| c - approach);
        let Some(state) = start else {
            position[z..].iter_mut().zip(wall).for_each(|(w, wall)| *w = wall.min(0.0));
            return position;
        };
        position.iter_mut().zip(&state.displacement).for_each(|(w, u)| *w = *u);
        let rise = if let Normal::MeanPressure(_) = drive.normal { state.approach } else { 0.0 };
        for ((w, wall), pressure) in position[z..].iter_mut().zip(wall).zip(&state.wall_pressure) {
            *w = if *pressure > 0.0 { wall } else { *w + rise };
        }
        position
    }

    /// Φ, energy per area; where u_z alone moves, that of opening. NaN without one.
    pub(crate) fn energy(&self, (normal, [x, y]): (f64, [f64; 2])) -> f64 {
        match self.elastic {
            Elastic::Normal(_) => self.law.opening_energy(normal),
            Elastic::Full(_) => self.law.energy(normal, x.hypot(y)).unwrap_or(f64::NAN),
        }
    }
}

/// Distance from the highest point of a rigid surface down to it, and the rms height.
pub(crate) fn heights_to_clearance(heights: ArrayView2<f64>, grid: &Grid) -> Result<(Vec<f64>, f64), InterfaceError> {
    let expected = grid.points();
    let found = heights.dim().into();
    if found != expected {
        return Err(InterfaceError::Shape { found, expected });
    }
    if let Some(((i, j), &value)) = heights.indexed_iter().find(|(_, h)| !h.is_finite()) {
        return Err(InterfaceError::Height { index: [i, j], value });
    }
    let highest = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let clearance: Vec<f64> = heights.iter().map(|h| highest - h).collect();
    let level = mean(&clearance);
    let squares =
        gfmd_vector::sum(clearance.len(), &|range| clearance[range].iter().map(|c| (c - level).powi(2)).sum());
    let rms_height = (squares / clearance.len() as f64).sqrt();
    Ok((clearance, rms_height))
}

/// How a drive is posed. Under a prescribed load the rigid surface stays at first touch and the body is pushed up with
/// `push`; the stiffness of its uniform motion is then 0 (theory.md, section 6.5).
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    pub(crate) uniform_stiffness: Vec<f64>,
    /// Components whose mean is 0: nothing but the far body holds it.
    pub(crate) held: Vec<bool>,
    pub(crate) push: f64,
    pub(crate) approach: f64,
    pub(crate) lateral: [f64; 2],
}

impl Frame {
    /// Δ_n and Δ_t at a point.
    pub(crate) fn separation(&self, interface: &Interface, position: &[f64], i: usize) -> (f64, [f64; 2]) {
        let points = interface.clearance.len();
        let z = position.len() / points - 1;
        let along = |c: usize| if c < z { self.lateral[c] - position[c * points + i] } else { 0.0 };
        (interface.clearance[i] - self.approach - position[z * points + i], [along(0), along(1)])
    }
}
