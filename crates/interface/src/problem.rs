use std::sync::Arc;

use gfmd_contact::{Boundary, Refusal, RigidSurface, Units};
use gfmd_field::Grid;
use gfmd_green::{Body, has_level};
use gfmd_law::{InUnits, Law};
use gfmd_response::{Elastic, FullResponse, NormalResponse};
use ndarray::ArrayRef2;

use crate::patch::Patch;

/// A law that is too steep for the grid: single points jump where the contact edge of a continuous surface would move
/// smoothly.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "lattice trapping: the steepness of the attraction is {steepness:.3e}; it should be below half of {stiffness:.3e}, \
     the stiffness (stress/length) of the shortest wave on this grid: refine the grid or take a longer range"
)]
pub struct Trapping {
    /// [`Law::steepness`].
    pub steepness: f64,
    /// Stiffness of the body at the corner of the spectrum.
    pub stiffness: f64,
}

/// A rigid rough surface above an elastic one, with a law that acts between them. A clone shares the data.
#[derive(Clone, Debug)]
pub struct Interface {
    /// The response of the body, the law and the rigid surface, in `units`.
    pub(crate) elastic: Elastic,
    pub(crate) law: Arc<dyn Law>,
    pub(crate) surface: Arc<RigidSurface>,
    /// The patch inside the cell of `elastic`, with free boundaries.
    pub(crate) patch: Option<Patch>,
    /// The rigid surface as given.
    pub(crate) given: Arc<RigidSurface>,
    /// E* as given.
    pub(crate) contact_modulus: f64,
    pub(crate) units: Units,
}

impl Interface {
    /// Makes an interface that acts on u_z alone, without lateral traction. `heights` is the rigid profile on `grid`,
    /// peaks pointing at the body, in length; only differences matter.
    ///
    /// # Errors
    /// Heights of another shape than the grid, or not finite.
    pub fn new(body: &Body, grid: &Grid, heights: &ArrayRef2<f64>, law: impl Law + 'static) -> Result<Self, Refusal> {
        Self::in_own_units(body, grid, heights, law, NormalResponse::new)
    }

    /// As [`new`](Self::new), with the boundary of the surface. With [`Boundary::Free`] an approach is that against
    /// points far away, a mean pressure is the force over Lx Ly, and the problem is solved in a cell of twice the
    /// points along each axis (theory.md, section 8.1).
    ///
    /// # Errors
    /// As [`new`](Self::new); and with free boundaries a body without a level far away.
    pub fn bounded(
        boundary: Boundary,
        body: &Body,
        grid: &Grid,
        heights: &ArrayRef2<f64>,
        law: impl Law + 'static,
    ) -> Result<Self, Refusal> {
        if boundary == Boundary::Periodic {
            return Self::new(body, grid, heights, law);
        }
        let given = RigidSurface::new(grid, heights)?.alone();
        let on_patch = |surface: &RigidSurface, body: &Body| {
            let response = NormalResponse::of_patch(surface.grid(), body)?;
            let patch = Patch::of(surface, response.grid(), has_level(body, surface.grid()));
            Ok((response.into(), Some(patch)))
        };
        Self::with_surface(body, given.into(), law, on_patch)
    }

    /// As [`new`](Self::new), in all components: with lateral displacement and shear.
    ///
    /// # Errors
    /// Heights of another shape than the grid, or not finite.
    pub fn in_all_components(
        body: &Body,
        grid: &Grid,
        heights: &ArrayRef2<f64>,
        law: impl Law + 'static,
    ) -> Result<Self, Refusal> {
        Self::in_own_units(body, grid, heights, law, FullResponse::new)
    }

    /// As [`new`](Self::new) or [`in_all_components`](Self::in_all_components), on an existing response, such as one
    /// that many surfaces on one body share. The problem is solved in the units of the response, whatever its size.
    ///
    /// # Errors
    /// Heights of another shape than the grid, or not finite.
    pub fn on(elastic: impl Into<Elastic>, heights: &ArrayRef2<f64>, law: impl Law + 'static) -> Result<Self, Refusal> {
        let elastic = elastic.into();
        let surface = Arc::new(RigidSurface::new(elastic.grid(), heights)?);
        let (given, contact_modulus) = (Arc::clone(&surface), elastic.contact_modulus());
        let (law, patch, units) = (law.into_shared(), None, Units::ONE);
        Ok(Self { elastic, law, surface, patch, given, contact_modulus, units })
    }

    /// This interface after a `depth` `[x, y]`, in length, was added to the clearance. The approach still counts from
    /// first touch of the surfaces as given, and the rms height and gradient are theirs.
    ///
    /// # Errors
    /// A depth of another shape than the heights, or not finite.
    pub fn indented(&self, depth: &ArrayRef2<f64>) -> Result<Self, Refusal> {
        let given = Arc::new(self.given.indented(depth)?);
        let surface = self.units.surface(&given);
        let patch = self.patch.as_ref().map(|patch| Patch::of(&surface, self.elastic.grid(), patch.has_level()));
        Ok(Self { surface, given, patch, ..self.clone() })
    }

    /// This interface with the tractions of its law over `factor`, as on a body that is stiffer by it all its tractions
    /// would be those of this one over `factor`.
    #[must_use]
    pub fn weakened(&self, factor: f64) -> Self {
        Self { law: InUnits::new(Arc::clone(&self.law), factor, 1.0).into_shared(), ..self.clone() }
    }

    /// This interface on a body whose waves have stiffnesses that are larger by these `factors`, laid out as the
    /// [modes](Grid::modes) of the grid, the uniform one first. The boundary is periodic.
    ///
    /// # Errors
    /// An interface in all components.
    pub fn stiffened(&self, factors: &[f64]) -> Result<Self, Refusal> {
        match &self.elastic {
            Elastic::Normal(response) => Ok(Self { elastic: response.stiffened(factors).into(), ..self.clone() }),
            Elastic::Full(_) => Err(Refusal::ViscoelasticComponents),
        }
    }

    fn in_own_units<E: Into<Elastic>>(
        body: &Body,
        grid: &Grid,
        heights: &ArrayRef2<f64>,
        law: impl Law + 'static,
        response: impl FnOnce(Grid, &Body) -> E,
    ) -> Result<Self, Refusal> {
        let given = RigidSurface::new(grid, heights)?.into();
        Self::with_surface(body, given, law, |surface, body| Ok((response(*surface.grid(), body).into(), None)))
    }

    /// The interface of a `given` surface, solved in its own units, with the response of surface and body in these.
    fn with_surface(
        body: &Body,
        given: Arc<RigidSurface>,
        law: impl Law + 'static,
        response: impl FnOnce(&RigidSurface, &Body) -> Result<(Elastic, Option<Patch>), Refusal>,
    ) -> Result<Self, Refusal> {
        let units = Units::of(body, &given)?;
        let law = law.into_shared();
        let law = if units.are_one() { law } else { InUnits::new(law, units.stress(), units.length()).into_shared() };
        let surface = units.surface(&given);
        let (elastic, patch) = response(&surface, &units.body(body))?;
        Ok(Self { elastic, law, surface, patch, given, contact_modulus: body.contact_modulus(), units })
    }

    /// The boundary of the surface.
    pub fn boundary(&self) -> Boundary {
        if self.patch.is_some() { Boundary::Free } else { Boundary::Periodic }
    }

    /// The rigid surface.
    #[allow(clippy::misnamed_getters, reason = "`surface` is the one in the units of the solve")]
    pub fn surface(&self) -> &RigidSurface {
        &self.given
    }

    /// The response of the body, in the units of the solve: those of the input unless they are far from 1.
    pub fn elastic(&self) -> &Elastic {
        &self.elastic
    }

    /// The unit of the reduced pressure p*, E* times the spectral rms gradient of the surface, in stress (theory.md,
    /// section 10).
    pub fn reduced_pressure_unit(&self) -> f64 {
        self.contact_modulus * self.given.rms_gradient()
    }

    /// Returns true if there is an energy of the law for the moving components. For u_z alone every law has one.
    pub fn has_energy(&self) -> bool {
        self.elastic.components() == 1 || self.law.energy(0.0, 0.0).is_some()
    }

    /// Returns a warning if the law is too steep for the grid (theory.md, section 8). It is no error, since the states
    /// are correct for the discrete surface.
    pub fn trapping(&self) -> Option<Trapping> {
        let [_, stiffness] = self.elastic.stiffness_range();
        let steepness = self.law.steepness();
        let unit = self.units.stiffness();
        (steepness > 0.5 * stiffness).then_some(Trapping { steepness: steepness * unit, stiffness: stiffness * unit })
    }

    /// The unit of length in residuals: the rms height, or 1 if the surface is flat.
    pub(crate) fn length_scale(&self) -> f64 {
        let rms_height = self.surface.rms_height();
        if rms_height > 0.0 { rms_height } else { 1.0 }
    }

    /// The energy Φ per area; for u_z alone, that of opening. NaN if the law has none.
    pub(crate) fn energy(&self, (normal, [x, y]): (f64, [f64; 2])) -> f64 {
        match self.elastic {
            Elastic::Normal(_) => self.law.opening_energy(normal),
            Elastic::Full(_) => self.law.energy(normal, x.hypot(y)).unwrap_or(f64::NAN),
        }
    }
}
