use std::sync::Arc;

use gfmd_contact::{Boundary, Heights, Refusal, RigidSurface, Units};
use gfmd_field::{Grid, Share};
use gfmd_green::{Body, GreenError, Plate};
use gfmd_law::{HardWall, InUnits, Law};
use gfmd_relax::Upper;
use gfmd_response::{Elastic, FullResponse, NormalResponse, PlateResponse};
use ndarray::ArrayRef2;

use crate::patch::Patch;

/// Warning: a law too steep for the grid. Single points jump where the contact edge of a continuous surface would move
/// smoothly.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "lattice trapping: the steepness of the attraction is {steepness:.3e}; it should be below half of {stiffness:.3e}, \
     the stiffness (stress/length) of the shortest wave on this grid: refine the grid or increase the range"
)]
pub struct Trapping {
    /// [`Law::steepness`].
    pub steepness: f64,
    /// Stiffness of the body at the corner of the spectrum.
    pub stiffness: f64,
}

/// A rigid rough surface above an elastic one, with an interface law between them. A clone shares the data.
#[derive(Clone, Debug)]
pub struct Interface {
    /// Response of the body, law and rigid surface, in `units`.
    pub(crate) elastic: Elastic,
    /// Rows of this process, of the cell of a patch and of both faces of a plate.
    pub(crate) share: Share,
    pub(crate) law: Arc<dyn Law>,
    /// Largest pressure that the body feels at each inside point, in `units`.
    pub(crate) hardness: Option<Upper>,
    /// Compliance of the springs of all inside points, in `units`; `None` without springs.
    pub(crate) springs: Option<Arc<[f64]>>,
    /// Lateral displacement of the surface without traction, component by component on the grid of `elastic`, in
    /// `units`; `None` if it is zero.
    pub(crate) sideways: Option<Arc<[f64]>>,
    pub(crate) surface: Arc<RigidSurface>,
    /// Patch inside the cell of `elastic`, with free boundaries.
    pub(crate) patch: Option<Patch>,
    /// Rigid surface as given.
    pub(crate) given: Arc<RigidSurface>,
    /// E* as given.
    pub(crate) contact_modulus: f64,
    pub(crate) units: Units,
}

impl Interface {
    /// Creates an interface in u_z alone, without lateral traction. `heights` is the rigid profile on `grid`, peaks
    /// towards the body, in length; only differences matter.
    ///
    /// # Errors
    /// Returns an error if the heights do not match the grid or are not finite.
    pub fn new<'a>(
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
        law: impl Law + 'static,
    ) -> Result<Self, Refusal> {
        Self::in_own_units(body, grid, heights.into(), law, NormalResponse::new)
    }

    /// Creates an interface as [`new`](Self::new), solved by the processes of a `share`
    /// ([`Contact::share`](gfmd_contact::Contact::share)). Each process gives and gets only its rows of all fields
    /// (heights, hardness, states), and all make the same calls. Fields and numbers have the bits of a single process.
    /// The solver is Newton's method.
    ///
    /// # Errors
    /// Returns an error as [`new`](Self::new), on all processes.
    pub fn distributed<'a>(
        share: &Share,
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
        law: impl Law + 'static,
    ) -> Result<Self, Refusal> {
        Self::over(share, body, grid, heights.into(), law, NormalResponse::distributed)
    }

    /// Creates an interface as [`held_sideways`](Self::held_sideways), solved by several processes as
    /// [`distributed`](Self::distributed).
    ///
    /// # Errors
    /// Returns an error as [`new`](Self::new), on all processes.
    pub fn held_sideways_over<'a>(
        share: &Share,
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
        law: impl Law + 'static,
    ) -> Result<Self, Refusal> {
        Self::over(share, body, grid, heights.into(), law, NormalResponse::held_sideways_over)
    }

    /// Creates an interface as [`new`](Self::new), with the given boundary. With [`Boundary::Free`] an approach is
    /// relative to points far away, a mean pressure is the force divided by Lx Ly, and the problem is solved in a cell
    /// with twice the points along each axis (theory.md, section 8.1).
    ///
    /// # Errors
    /// Returns an error as [`new`](Self::new) and, with free boundaries, for a body without a level far away.
    pub fn with_boundary<'a>(
        boundary: Boundary,
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
        law: impl Law + 'static,
    ) -> Result<Self, Refusal> {
        Self::with_boundary_over(&grid.whole(), boundary, body, grid, heights, law)
    }

    /// Creates an interface as [`with_boundary`](Self::with_boundary), solved by several processes as
    /// [`distributed`](Self::distributed).
    ///
    /// # Errors
    /// Returns an error as [`with_boundary`](Self::with_boundary), on all processes.
    pub fn with_boundary_over<'a>(
        share: &Share,
        boundary: Boundary,
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
        law: impl Law + 'static,
    ) -> Result<Self, Refusal> {
        match boundary {
            Boundary::Periodic => Self::distributed(share, body, grid, heights, law),
            Boundary::Free => Self::on_patch(share, body, grid, heights.into(), law, NormalResponse::of_patch_over),
        }
    }

    /// Creates an interface as [`new`](Self::new), in all components: with lateral displacement and shear.
    ///
    /// # Errors
    /// Returns an error if the heights do not match the grid or are not finite.
    pub fn in_all_components<'a>(
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
        law: impl Law + 'static,
    ) -> Result<Self, Refusal> {
        Self::in_own_units(body, grid, heights.into(), law, FullResponse::new)
    }

    /// Creates an interface as [`in_all_components`](Self::in_all_components), solved by several processes as
    /// [`distributed`](Self::distributed).
    ///
    /// # Errors
    /// Returns an error as [`new`](Self::new), on all processes.
    pub fn in_all_components_over<'a>(
        share: &Share,
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
        law: impl Law + 'static,
    ) -> Result<Self, Refusal> {
        Self::over(share, body, grid, heights.into(), law, FullResponse::distributed)
    }

    /// Creates an interface as [`in_all_components`](Self::in_all_components), with the given boundary. With
    /// [`Boundary::Free`] the lateral displacement, too, is relative to points far away; the rest is as for
    /// [`with_boundary`](Self::with_boundary).
    ///
    /// # Errors
    /// Returns an error as [`in_all_components`](Self::in_all_components) and, with free boundaries, for a profile and
    /// for a body without lateral support ([`FullResponse::of_patch`]).
    pub fn in_all_components_with_boundary<'a>(
        boundary: Boundary,
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
        law: impl Law + 'static,
    ) -> Result<Self, Refusal> {
        Self::in_all_components_with_boundary_over(&grid.whole(), boundary, body, grid, heights, law)
    }

    /// Creates an interface as [`in_all_components_with_boundary`](Self::in_all_components_with_boundary), solved by
    /// several processes as [`distributed`](Self::distributed).
    ///
    /// # Errors
    /// Returns an error as [`in_all_components_with_boundary`](Self::in_all_components_with_boundary), on all
    /// processes.
    pub fn in_all_components_with_boundary_over<'a>(
        share: &Share,
        boundary: Boundary,
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
        law: impl Law + 'static,
    ) -> Result<Self, Refusal> {
        match boundary {
            Boundary::Periodic => Self::in_all_components_over(share, body, grid, heights, law),
            Boundary::Free => Self::on_patch(share, body, grid, heights.into(), law, FullResponse::of_patch_over),
        }
    }

    /// Creates an interface as [`new`](Self::new), in u_z of a surface without lateral displacement
    /// ([`NormalResponse::held_sideways`]).
    ///
    /// # Errors
    /// Returns an error if the heights do not match the grid or are not finite.
    pub fn held_sideways<'a>(
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
        law: impl Law + 'static,
    ) -> Result<Self, Refusal> {
        Self::in_own_units(body, grid, heights.into(), law, NormalResponse::held_sideways)
    }

    /// Creates the interfaces of both faces of a plate as one, with the fields of the lower face after the fields of
    /// the upper one; `plate` makes the plate from the body. Its approach is half of the approach of the two surfaces
    /// to each other, its mean pressure the mean over both faces, and its energies per area are half the energies of
    /// the plate (theory.md, section 8.4).
    pub(crate) fn of_plate(
        plate: impl FnOnce(&Body) -> Result<Plate, GreenError>,
        body: &Body,
        given: &Arc<RigidSurface>,
        law: impl Law + 'static,
    ) -> Result<Self, Refusal> {
        Self::with_surface(body, Arc::clone(given), law, |surface, body| {
            let ([nx, ny], lengths) = (surface.grid().points(), surface.grid().lengths());
            let Ok(grid) = Grid::new([nx / 2, ny], lengths) else {
                return Err(Refusal::Start { found: nx, expected: 2 });
            };
            Ok((PlateResponse::distributed(grid, &plate(body)?, &surface.share().face()).into(), None))
        })
    }

    /// Creates an interface as [`new`](Self::new) or [`in_all_components`](Self::in_all_components), on an existing
    /// response, for example a shared one. The problem is solved in the units of the response, whatever its size.
    ///
    /// # Errors
    /// Returns an error if the heights do not match the grid or are not finite.
    pub fn with_response<'a>(
        elastic: impl Into<Elastic>,
        heights: impl Into<Heights<'a>>,
        law: impl Law + 'static,
    ) -> Result<Self, Refusal> {
        let elastic = elastic.into();
        let share = elastic.share();
        let surface = Arc::new(RigidSurface::distributed(&share, elastic.grid(), heights)?);
        let (given, contact_modulus) = (Arc::clone(&surface), elastic.contact_modulus());
        let (law, patch, units) = (law.into_shared(), None, Units::ONE);
        let (hardness, springs, sideways) = (None, None, None);
        Ok(Self { elastic, share, law, hardness, springs, sideways, surface, patch, given, contact_modulus, units })
    }

    /// Creates the hard wall `surface` on an existing response, in the units of both.
    pub(crate) fn at_wall(elastic: impl Into<Elastic>, surface: Arc<RigidSurface>) -> Self {
        let elastic = elastic.into();
        let contact_modulus = elastic.contact_modulus();
        let (share, law, given) = (elastic.share(), HardWall.into_shared(), Arc::clone(&surface));
        let (hardness, springs, sideways, patch, units) = (None, None, None, None, Units::ONE);
        Self { elastic, share, law, hardness, springs, sideways, surface, patch, given, contact_modulus, units }
    }

    /// Returns this interface with a response in all components of the same body.
    pub(crate) fn in_components_of(&self, response: &Arc<FullResponse>) -> Self {
        Self { elastic: Elastic::Full(Arc::clone(response)), ..self.clone() }
    }

    /// Returns this interface of a patch with the response in all components of a cell around the patch.
    pub(crate) fn in_components_of_cell(&self, response: FullResponse) -> Self {
        let share = response.share().clone();
        let patch = Some(Patch::of(&self.surface, response.grid(), &share));
        Self { elastic: response.into(), share, patch, ..self.clone() }
    }

    /// Returns this interface with `depth` `[x, y]`, in length, added to the clearance. The approach is still measured
    /// from first touch of the given surfaces; the rms height and gradient do not change.
    ///
    /// # Errors
    /// Returns an error if the depth is not finite or its shape differs from the heights.
    pub fn with_indentation(&self, depth: &ArrayRef2<f64>) -> Result<Self, Refusal> {
        let given = Arc::new(self.given.with_indentation(depth)?);
        let surface = self.units.surface(&given);
        let patch = self.patch.as_ref().map(|_| Patch::of(&surface, self.elastic.grid(), &self.share));
        Ok(Self { surface, given, patch, ..self.clone() })
    }

    /// Returns this interface in all components above a surface that is displaced sideways without traction, by
    /// `displacement` `[x, y]` in length, component by component. The displacement of a state does not contain it.
    ///
    /// # Errors
    /// Returns an error if the number of values is not the number of points times the number of lateral components.
    pub fn displaced_sideways(&self, displacement: &[f64]) -> Result<Self, Refusal> {
        let expected = (self.elastic.components() - 1) * self.surface.clearance().len();
        if displacement.len() != expected {
            return Err(Refusal::Start { found: displacement.len(), expected });
        }
        let values = displacement.iter().map(|u| u / self.units.length());
        let sideways: Vec<f64> = match &self.patch {
            Some(patch) => {
                let mut cell = vec![0.0; (self.elastic.components() - 1) * self.share.own().len()];
                patch.place(values, &mut cell);
                cell
            }
            None => values.collect(),
        };
        Ok(Self { sideways: Some(sideways.into()), ..self.clone() })
    }

    /// Returns this interface with the tractions of its law, its hardness and the stiffness of its springs divided by
    /// `factor`. It has the displacements of this interface on a body stiffer by `factor`, with all tractions divided
    /// by `factor`.
    #[must_use]
    pub fn weakened(&self, factor: f64) -> Self {
        Self {
            law: InUnits::new(Arc::clone(&self.law), factor, 1.0).into_shared(),
            hardness: self.hardness.as_ref().map(|hardness| hardness.times(factor.recip())),
            springs: self.springs.as_ref().map(|springs| springs.iter().map(|k| k * factor).collect()),
            ..self.clone()
        }
    }

    /// Returns this interface with the stiffness of each wave multiplied by `factors`, laid out as the
    /// [modes](Grid::modes) of this process, the uniform mode first. The boundary is periodic.
    ///
    /// # Errors
    /// Returns an error for an interface in all components.
    pub fn stiffened(&self, factors: &[f64]) -> Result<Self, Refusal> {
        match &self.elastic {
            Elastic::Normal(response) => Ok(Self { elastic: response.stiffened(factors).into(), ..self.clone() }),
            Elastic::Full(_) | Elastic::Plate(_) => Err(Refusal::AllComponents),
        }
    }

    /// Creates the interface of a patch with the `response` of its cell.
    fn on_patch<E: Into<Elastic>>(
        share: &Share,
        body: &Body,
        grid: &Grid,
        heights: Heights,
        law: impl Law + 'static,
        response: impl FnOnce(&Share, &Grid, &Body) -> Result<E, GreenError>,
    ) -> Result<Self, Refusal> {
        let given = RigidSurface::distributed(share, grid, heights)?.alone();
        let of_cell = |surface: &RigidSurface, body: &Body| {
            let elastic: Elastic = response(share, surface.grid(), body)?.into();
            let patch = Patch::of(surface, elastic.grid(), &elastic.share());
            Ok((elastic, Some(patch)))
        };
        Self::with_surface(body, given.into(), law, of_cell)
    }

    fn over<E: Into<Elastic>>(
        share: &Share,
        body: &Body,
        grid: &Grid,
        heights: Heights,
        law: impl Law + 'static,
        response: impl FnOnce(Grid, &Body, &Share) -> E,
    ) -> Result<Self, Refusal> {
        let given = RigidSurface::distributed(share, grid, heights)?.into();
        Self::with_surface(body, given, law, |surface, body| Ok((response(*surface.grid(), body, share).into(), None)))
    }

    fn in_own_units<E: Into<Elastic>>(
        body: &Body,
        grid: &Grid,
        heights: Heights,
        law: impl Law + 'static,
        response: impl FnOnce(Grid, &Body) -> E,
    ) -> Result<Self, Refusal> {
        let given = RigidSurface::new(grid, heights)?.into();
        Self::with_surface(body, given, law, |surface, body| Ok((response(*surface.grid(), body).into(), None)))
    }

    /// Creates the interface of a `given` surface in its own units; `response` gets surface and body in these units.
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
        let (hardness, springs, sideways, contact_modulus) = (None, None, None, body.contact_modulus());
        let share = elastic.share();
        Ok(Self { elastic, share, law, hardness, springs, sideways, surface, patch, given, contact_modulus, units })
    }

    /// Returns the boundary of the surface.
    pub fn boundary(&self) -> Boundary {
        if self.patch.is_some() { Boundary::Free } else { Boundary::Periodic }
    }

    /// Returns the rigid surface.
    #[allow(clippy::misnamed_getters, reason = "`surface` is the one in the units of the solve")]
    pub fn surface(&self) -> &Arc<RigidSurface> {
        &self.given
    }

    /// Returns the response of the body in the units of the solve: the input units unless they are far from 1.
    pub fn elastic(&self) -> &Elastic {
        &self.elastic
    }

    /// Returns the unit of the reduced pressure p*: E* times the spectral rms gradient of the surface, in stress
    /// (theory.md, section 10).
    pub fn reduced_pressure_unit(&self) -> f64 {
        self.contact_modulus * self.given.rms_gradient()
    }

    /// Returns true if the law has an energy for the moving components. For u_z alone every law has one.
    pub fn has_energy(&self) -> bool {
        self.elastic.components() == 1 || self.law.energy(0.0, 0.0).is_some()
    }

    /// Returns true if the law acts beyond touching: a hard wall alone does not.
    pub(crate) fn attracts(&self) -> bool {
        !self.law.has_wall() || self.law.opening_energy(0.0) != 0.0 || self.law.stiffness_bound(0.0) != 0.0
    }

    /// Returns a warning if the law is too steep for the grid (theory.md, section 8). It is not an error, since the
    /// states are correct for the discrete surface.
    pub fn trapping(&self) -> Option<Trapping> {
        let [_, stiffness] = self.elastic.stiffness_range();
        let steepness = self.law.steepness();
        let unit = self.units.stiffness();
        (steepness > 0.5 * stiffness).then_some(Trapping { steepness: steepness * unit, stiffness: stiffness * unit })
    }

    /// Returns the unit of length in residuals: the rms height, or 1 for a flat surface.
    pub(crate) fn length_scale(&self) -> f64 {
        let rms_height = self.surface.rms_height();
        if rms_height > 0.0 { rms_height } else { 1.0 }
    }

    /// Returns the energy Φ per area, for u_z alone the opening energy. NaN if the law has none.
    pub(crate) fn energy(&self, (normal, [x, y]): (f64, [f64; 2])) -> f64 {
        match self.elastic {
            Elastic::Normal(_) | Elastic::Plate(_) => self.law.opening_energy(normal),
            Elastic::Full(_) => self.law.energy(normal, x.hypot(y)).unwrap_or(f64::NAN),
        }
    }
}
