use std::sync::Arc;

use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_response::{NormalResponse, NormalTransforms};
use gfmd_vector::for_each;
use ndarray::{ArrayRef2, ArrayView2};

use crate::{Load, Refusal, RigidSurface, Solution, Units};

/// A rigid rough surface above an elastic one, without friction or adhesion (hard wall). Clones share the data.
#[derive(Clone, Debug)]
pub struct Contact {
    /// The response of the body, in `units`.
    pub(crate) response: Arc<NormalResponse>,
    /// The rigid surface, in `units`.
    pub(crate) scaled: Arc<RigidSurface>,
    /// The rigid surface.
    surface: Arc<RigidSurface>,
    /// E* of the body as given.
    contact_modulus: f64,
    units: Units,
}

impl Contact {
    /// The contact of `body` with a rigid profile `heights` on `grid`, whose peaks point at the body, in length. A
    /// constant in the heights has no effect.
    ///
    /// # Errors
    /// Heights of another shape than the grid, not finite, or all equal; E* h_rms / L too large or small for a number.
    pub fn new(body: &Body, grid: &Grid, heights: &ArrayRef2<f64>) -> Result<Self, Refusal> {
        let surface = Self::rough(grid, heights)?;
        let units = Units::of(body, &surface)?;
        let response = NormalResponse::new(units.grid(grid), &units.body(body)).into();
        let scaled = units.surface(&surface);
        Ok(Self { response, scaled, surface, contact_modulus: body.material().contact_modulus(), units })
    }

    /// As [`new`](Self::new), with an existing response: one that is shared by many surfaces on one body, or one
    /// without lateral displacement of the surface. The problem is solved in the units of the response, whatever its
    /// size.
    ///
    /// # Errors
    /// Heights of another shape than the grid, not finite, or all equal.
    pub fn on(response: impl Into<Arc<NormalResponse>>, heights: &ArrayRef2<f64>) -> Result<Self, Refusal> {
        let response = response.into();
        let surface = Self::rough(response.grid(), heights)?;
        let (scaled, contact_modulus) = (Arc::clone(&surface), response.contact_modulus());
        Ok(Self { response, scaled, surface, contact_modulus, units: Units::ONE })
    }

    fn rough(grid: &Grid, heights: &ArrayRef2<f64>) -> Result<Arc<RigidSurface>, Refusal> {
        let surface = RigidSurface::new(grid, heights)?;
        if surface.rms_height() > 0.0 { Ok(surface.into()) } else { Err(Refusal::Flat) }
    }

    /// The rigid surface.
    #[allow(clippy::misnamed_getters, reason = "`surface` is the one in the units of the solve")]
    pub fn surface(&self) -> &RigidSurface {
        &self.surface
    }

    /// The units in which the contact is solved.
    pub fn units(&self) -> &Units {
        &self.units
    }

    /// The response of the body, in [`units`](Self::units).
    pub fn response(&self) -> &Arc<NormalResponse> {
        &self.response
    }

    /// E* times the spectral rms gradient of the surface, in stress: the unit of the reduced pressure p*
    /// (theory.md, section 10).
    pub fn reduced_pressure_unit(&self) -> f64 {
        self.contact_modulus * self.surface.rms_gradient()
    }

    /// The state of `pressure` under `load` with its residuals, from fresh transforms.
    ///
    /// # Errors
    /// A pressure of another shape than the grid.
    pub fn certify(&self, pressure: &ArrayRef2<f64>, load: Load) -> Result<Solution, Refusal> {
        self.check_size(pressure.view())?;
        let stress = self.units.stress();
        let load = self.units.drive(load.into()).load;
        Ok(self.given_units(self.certified(pressure.iter().map(|p| p / stress).collect(), load)))
    }

    /// Converts a solution to the units of the input.
    pub(crate) fn given_units(&self, solution: Solution) -> Solution {
        if self.units.are_one() {
            return solution;
        }
        solution.out_of(&self.units, &self.surface, self.contact_modulus)
    }

    /// As [`certify`](Self::certify), for a pressure with the size of the grid, all in [`units`](Self::units).
    pub(crate) fn certified(&self, pressure: Vec<f64>, load: Load) -> Solution {
        let response = &self.response;
        let n = pressure.len();
        let mut transforms = NormalTransforms::of(response);
        let mut displacement = vec![0.0; n];
        transforms.convolve(response.compliance(), &pressure, &mut displacement);
        let uniform =
            response.uniform_compliance() * gfmd_vector::sum(n, &|range| pressure[range].iter().sum()) / n as f64;
        // u_z = −G p.
        for_each([&mut displacement], &|_, [u]| u.iter_mut().for_each(|u| *u = -*u));
        let mut solution =
            Solution::of(&self.scaled, response.contact_modulus(), pressure, displacement, uniform, load);
        solution.effort.transform_pairs = transforms.pairs();
        solution
    }

    /// Checks that the contact can carry `load`.
    pub(crate) fn check_load(&self, load: Load) -> Result<(), Refusal> {
        match load {
            Load::MeanPressure(found) if !(found > 0.0 && found.is_finite()) => Err(Refusal::MeanPressure { found }),
            Load::Approach(found) => {
                let limit = (self.response.uniform_compliance() == 0.0).then_some(self.surface.mean_clearance());
                let reachable = found > 0.0 && found < limit.unwrap_or(f64::INFINITY);
                if reachable { Ok(()) } else { Err(Refusal::Approach { found, limit }) }
            }
            Load::MeanPressure(found) => Units::check_pressure(found),
        }
    }

    /// The start pressure in [`units`](Self::units), if it is valid.
    pub(crate) fn check_start(&self, start: ArrayView2<f64>) -> Result<Vec<f64>, Refusal> {
        self.check_size(start)?;
        if let Some(((i, j), &value)) = start.indexed_iter().find(|(_, p)| !(p.is_finite() && **p >= 0.0)) {
            return Err(Refusal::StartPressure { index: [i, j], value });
        }
        if start.iter().all(|p| *p == 0.0) {
            return Err(Refusal::StartApart);
        }
        let stress = self.units.stress();
        Ok(start.iter().map(|p| p / stress).collect())
    }

    fn check_size(&self, pressure: ArrayView2<f64>) -> Result<(), Refusal> {
        let grid = self.response.grid();
        if <[usize; 2]>::from(pressure.dim()) == grid.points() {
            Ok(())
        } else {
            Err(Refusal::Start { found: pressure.len(), expected: grid.len() })
        }
    }
}
