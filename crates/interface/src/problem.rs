use std::ops::ControlFlow;

use gfmd_field::Grid;
use gfmd_law::Law;
use gfmd_response::{FullResponse, NormalResponse};
use ndarray::ArrayView2;

use crate::InterfaceError;
use crate::elastic::Elastic;
use crate::numbers::mean;

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

    /// Root mean square of the heights about their mean, length.
    pub fn rms_height(&self) -> f64 {
        self.rms_height
    }

    /// The unit of length: the rms height, or 1 if the surface is flat.
    pub(crate) fn length_scale(&self) -> f64 {
        if self.rms_height > 0.0 { self.rms_height } else { 1.0 }
    }

    /// Mean distance from the highest point of the rigid surface down to it, length.
    pub(crate) fn mean_clearance(&self) -> f64 {
        mean(&self.clearance)
    }

    /// Φ, energy per area; where u_z alone moves, that of opening. NaN if the law has none.
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
