use std::borrow::Cow;
use std::sync::Arc;

use gfmd_field::{Grid, Rows};
use gfmd_green::{Body, Conductor};
use gfmd_relax::Upper;
use gfmd_response::{FreeCompliance, FullResponse, NormalResponse};
use gfmd_vector::{Ranks, Share, for_each};
use ndarray::{Array2, ArrayRef2, ArrayView2};

use crate::compliance::Compliance;
use crate::full;
use crate::pull_push::PullPush;
use crate::solution::{Conditions, field};
use crate::springs::{Springs, SpringsInUnits};
use crate::{Boundary, Dynamics, Hardness, Heights, Load, Refusal, RigidSurface, Solution, Units};

/// Rigid rough surface above an elastic one, without friction or adhesion (hard wall). Clones share the data.
#[derive(Clone, Debug)]
pub struct Contact {
    /// Response of the body to periodic pressures, in `units`. With free boundaries it is an approximation for the
    /// preconditioner.
    pub(crate) response: Arc<NormalResponse>,
    /// Compliance of the body with free boundaries, in `units`.
    pub(crate) free: Option<Arc<FreeCompliance>>,
    /// Response of all components, which the dynamics move.
    pub(crate) all_components: Option<Arc<FullResponse>>,
    /// Largest pressure, in `units`.
    pub(crate) hardness: Option<Upper>,
    /// Compliance of the spring at each point beyond the one that the response contains, in `units`.
    pub(crate) springs: Option<Arc<[f64]>>,
    /// Rows solved by this process.
    pub(crate) share: Share,
    /// Time step and damping of the damped dynamics.
    pub(crate) dynamics: Dynamics,
    /// Difference between the largest and the smallest depth lost by the surfaces, in `units`.
    worn: f64,
    /// True if springs that act point by point are part of the body.
    is_softened: bool,
    /// Rigid surface, in `units`.
    pub(crate) scaled: Arc<RigidSurface>,
    /// Rigid surface, in the units of the input.
    surface: Arc<RigidSurface>,
    /// E* of the body, in the units of the input.
    contact_modulus: f64,
    units: Units,
}

/// Stiffness of the uniform mode in preconditioners, relative to the softest wave, if the approach is prescribed and
/// the body has no uniform stiffness of its own: on a half-space with a fixed mean level and on an incompressible slab
/// between two surfaces. The effective stiffness then depends on the contact area. Chosen; the sensitivity was not
/// measured.
pub(crate) const LEVEL: f64 = 4.0;

impl Contact {
    /// Makes the contact of `body` with a rigid profile `heights` on `grid`, in length, with peaks towards the body. A
    /// constant in the heights has no effect.
    ///
    /// # Errors
    /// Heights that differ in shape from the grid, are not finite, or are all equal; E* h_rms / L out of range.
    pub fn new<'a>(body: &Body, grid: &Grid, heights: impl Into<Heights<'a>>) -> Result<Self, Refusal> {
        Self::distributed(&grid.whole(), body, grid, heights)
    }

    /// Makes the contact as [`new`](Self::new), without lateral displacement of the surface (theory.md, section 3,
    /// restricted lateral displacement).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn held_sideways<'a>(body: &Body, grid: &Grid, heights: impl Into<Heights<'a>>) -> Result<Self, Refusal> {
        Self::held_sideways_over(&grid.whole(), body, grid, heights)
    }

    /// Returns the rows of a grid that this process, one of several, solves for ([`distributed`](Self::distributed)).
    ///
    /// # Errors
    /// More processes than can share the rows.
    pub fn share(ranks: Arc<dyn Ranks>, grid: &Grid) -> Result<Share, Refusal> {
        Ok(Share::among(ranks, grid.rows(), PullPush::shared_levels(grid.rows()))?)
    }

    /// Makes the contact as [`new`](Self::new), solved by the processes of a [`share`](Self::share). Each process gives
    /// and gets only its rows of all fields (heights, hardness, start), and all make the same calls. Fields and numbers
    /// have the bits of a single process. The methods are [`FREE_SOLVERS`](Self::FREE_SOLVERS). The
    /// [`Watch`](gfmd_relax::Watch) of any process may stop the search, and keeps checkpoints together with the others.
    ///
    /// # Errors
    /// As [`new`](Self::new), on all processes.
    pub fn distributed<'a>(
        share: &Share,
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
    ) -> Result<Self, Refusal> {
        Self::responding(NormalResponse::recent, share, body, grid, heights.into())
    }

    /// Makes the contact as [`distributed`](Self::distributed), without lateral displacement of the surface.
    ///
    /// # Errors
    /// As [`new`](Self::new), on all processes.
    pub fn held_sideways_over<'a>(
        share: &Share,
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
    ) -> Result<Self, Refusal> {
        let held = |grid, body: &_, share: &_| NormalResponse::held_sideways_over(grid, body, share).into();
        Self::responding(held, share, body, grid, heights.into())
    }

    fn responding(
        response: fn(Grid, &Body, &Share) -> Arc<NormalResponse>,
        share: &Share,
        body: &Body,
        grid: &Grid,
        heights: Heights,
    ) -> Result<Self, Refusal> {
        let surface = Self::rough(share, grid, heights)?;
        let units = Units::of(body, &surface)?;
        let contact = Self {
            response: response(units.grid(grid), &units.body(body), share),
            free: None,
            all_components: None,
            hardness: None,
            springs: None,
            share: share.clone(),
            dynamics: Dynamics::default(),
            worn: 0.0,
            is_softened: false,
            scaled: units.surface(&surface),
            surface,
            contact_modulus: body.contact_modulus(),
            units,
        };
        Ok(contact)
    }

    /// Makes the contact as [`new`](Self::new), with the given boundary. With [`Boundary::Free`] the approach is
    /// measured against points far away, and the mean pressure is the force divided by Lx Ly.
    ///
    /// # Errors
    /// As [`new`](Self::new); with free boundaries also a body without a level far away, or with layers that are too
    /// thin.
    pub fn with_boundary<'a>(
        boundary: Boundary,
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
    ) -> Result<Self, Refusal> {
        Self::with_boundary_over(&grid.whole(), boundary, body, grid, heights)
    }

    /// Makes the contact as [`with_boundary`](Self::with_boundary), solved by several processes as
    /// [`distributed`](Self::distributed).
    ///
    /// # Errors
    /// As [`with_boundary`](Self::with_boundary), on all processes.
    pub fn with_boundary_over<'a>(
        share: &Share,
        boundary: Boundary,
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
    ) -> Result<Self, Refusal> {
        let mut contact = Self::distributed(share, body, grid, heights)?;
        if boundary == Boundary::Free {
            let Self { units, surface, scaled, free, .. } = &mut contact;
            *free = Some(FreeCompliance::distributed(units.grid(grid), &units.body(body), share)?.into());
            *surface = Arc::new(RigidSurface::clone(surface).alone());
            *scaled = units.surface(surface);
        }
        Ok(contact)
    }

    /// Makes the problem of two conductors on a `grid`, one with unit conductivity and the other without resistance:
    /// potential for displacement, current density for pressure. The surface is flat, which matters only under a load.
    ///
    /// # Errors
    /// With free boundaries an electrode that is not deep enough.
    pub(crate) fn of_conductor(boundary: Boundary, conductor: &Conductor, grid: &Grid) -> Result<Self, Refusal> {
        let units = Units::of_grid(grid);
        let (grid, conductor) = (units.grid(grid), conductor.in_units(units.lateral()));
        let free = match boundary {
            Boundary::Periodic => None,
            Boundary::Free => Some(FreeCompliance::of_conductor(grid, &conductor)?.into()),
        };
        let surface = Arc::new(RigidSurface::new(&grid, &Array2::zeros(grid.points()))?);
        Ok(Self {
            response: NormalResponse::of_conductor(grid, &conductor).into(),
            free,
            all_components: None,
            hardness: None,
            springs: None,
            share: grid.whole(),
            dynamics: Dynamics::default(),
            worn: 0.0,
            is_softened: false,
            scaled: Arc::clone(&surface),
            surface,
            contact_modulus: conductor.body().contact_modulus(),
            units,
        })
    }

    /// Makes the contact as [`new`](Self::new), with an existing response, which may be shared by many surfaces on one
    /// body or exclude lateral displacement of the surface. The problem is solved in the units of the response,
    /// whatever its size.
    ///
    /// # Errors
    /// Heights that differ in shape from the grid, are not finite, or are all equal.
    pub fn with_response<'a>(
        response: impl Into<Arc<NormalResponse>>,
        heights: impl Into<Heights<'a>>,
    ) -> Result<Self, Refusal> {
        let response = response.into();
        let share = response.share().clone();
        let surface = Self::rough(&share, response.grid(), heights.into())?;
        let (scaled, contact_modulus) = (Arc::clone(&surface), response.contact_modulus());
        let (free, hardness, dynamics, units) = (None, None, Dynamics::default(), Units::ONE);
        let (worn, is_softened) = (0.0, false);
        Ok(Self {
            response,
            free,
            all_components: None,
            hardness,
            springs: None,
            share,
            dynamics,
            worn,
            is_softened,
            scaled,
            surface,
            contact_modulus,
            units,
        })
    }

    /// Sets time step and damping of the damped dynamics. Values out of range are refused at the start of a solve.
    #[must_use]
    pub fn with_dynamics(self, dynamics: Dynamics) -> Self {
        Self { dynamics, ..self }
    }

    /// Sets the `hardness`, the largest pressure that the surfaces can carry, in stress: a number or a field `[x, y]`.
    /// Where the pressure reaches it, the surfaces are pressed into each other by the [plastic depth](crate::Plastic).
    ///
    /// # Errors
    /// A hardness that is not positive and finite, or differs in shape from the heights; a contact in all components.
    pub fn with_hardness(self, hardness: impl Into<Hardness>) -> Result<Self, Refusal> {
        self.check_normal("a hardness")?;
        let hardness = Some(hardness.into().in_units(&self.surface, &self.units)?);
        Ok(Self { hardness, ..self })
    }

    /// Returns this contact after the surfaces were pressed into each other by a plastic `depth` `[x, y]`, in length,
    /// which is added to the clearance. The approach is still measured from first touch of the undeformed surfaces, and
    /// the rms height and gradient do not change.
    ///
    /// # Errors
    /// A depth that differs in shape from the heights, or is not finite.
    pub fn with_indentation(&self, depth: &ArrayRef2<f64>) -> Result<Self, Refusal> {
        let surface = Arc::new(self.surface.with_indentation(depth)?);
        Ok(Self { scaled: self.units.surface(&surface), surface, ..self.clone() })
    }

    /// Returns this contact after a loss of `depth` `[x, y]`, in length: as
    /// [`with_indentation`](Self::with_indentation), with residuals relative to the extent of the depth if it exceeds
    /// the extent of the displacement.
    ///
    /// # Errors
    /// A depth that differs in shape from the heights, or is not finite.
    pub fn with_wear_depth(&self, depth: &ArrayRef2<f64>) -> Result<Self, Refusal> {
        let wider = |[least, most]: [f64; 2], [low, high]: [f64; 2]| [low.min(least), high.max(most)];
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let own = depth.iter().fold(none, |range, depth| wider(range, [*depth; 2]));
        let [least, most] = self.share.each(own).into_iter().fold(none, wider);
        Ok(Self { worn: (most - least).max(0.0) / self.units.length(), ..self.with_indentation(depth)? })
    }

    /// Returns this contact on a body below `springs` that act point by point, with a compliance in length/stress: a
    /// number, by which G(q) is larger for every wave and for the uniform mode, or a field `[x, y]`. The displacement
    /// of a solution includes the springs. Springs below springs act in series.
    ///
    /// # Errors
    /// A compliance that is negative or not finite, or differs in shape from the heights; a contact of several
    /// processes, or in all components.
    pub fn softened(&self, springs: impl Into<Springs>) -> Result<Self, Refusal> {
        self.check_normal("springs")?;
        let SpringsInUnits { common, rest } = springs.into().in_units(&self.surface, &self.units)?;
        let free = self.free.as_ref().map(|free| free.softened(common).into());
        let springs = match (&self.springs, rest) {
            (Some(own), Some(rest)) => Some(own.iter().zip(&rest[..]).map(|(own, rest)| own + rest).collect()),
            (own, rest) => rest.or_else(|| own.clone()),
        };
        Ok(Self { response: self.response.softened(common).into(), free, springs, is_softened: true, ..self.clone() })
    }

    /// Returns this contact on a body with waves that are stiffer by `factors`, laid out as the
    /// [modes](gfmd_field::Grid::modes) of this process, the uniform one first. The boundary is periodic, and u_z is
    /// the only unknown.
    #[must_use]
    pub fn stiffened(&self, factors: &[f64]) -> Self {
        Self { response: self.response.stiffened(factors).into(), all_components: None, ..self.clone() }
    }

    /// Checks that u_z is the only unknown.
    fn check_normal(&self, with: &'static str) -> Result<(), Refusal> {
        if self.all_components.is_some() { Err(Refusal::NotNormal { with }) } else { Ok(()) }
    }

    /// Returns the hardness, in stress.
    pub fn hardness(&self) -> Option<Hardness> {
        let hardness = self.hardness.as_ref()?.times(self.units.stress());
        Some(match hardness {
            Upper::All(hardness) => Hardness::Uniform(hardness),
            Upper::Each(values) => Hardness::Field(field(&self.surface, values.to_vec())),
        })
    }

    /// Returns the upper bounds of the pressure, in [`units`](Self::units); infinite without a hardness.
    pub(crate) fn upper(&self) -> Upper {
        self.hardness.clone().unwrap_or(Upper::All(f64::INFINITY))
    }

    fn rough(share: &Share, grid: &Grid, heights: Heights) -> Result<Arc<RigidSurface>, Refusal> {
        let surface = RigidSurface::distributed(share, grid, heights)?;
        if surface.rms_height() > 0.0 { Ok(surface.into()) } else { Err(Refusal::Flat) }
    }

    /// Returns the rigid surface.
    #[allow(clippy::misnamed_getters, reason = "`surface` is the one in the units of the solve")]
    pub fn surface(&self) -> &Arc<RigidSurface> {
        &self.surface
    }

    /// Returns the units in which the contact is solved.
    pub fn units(&self) -> &Units {
        &self.units
    }

    /// Returns the boundary of the surface.
    pub fn boundary(&self) -> Boundary {
        if self.free.is_some() { Boundary::Free } else { Boundary::Periodic }
    }

    /// Returns the smallest and largest stiffness of the surface waves, in stress/length, in [`units`](Self::units).
    /// With free boundaries these are approximately the values of the periodic cell of this size.
    pub fn stiffness_range(&self) -> [f64; 2] {
        self.response.stiffness_range()
    }

    /// Returns E* times the rms gradient of the surface, in stress: the unit of the reduced pressure p* (theory.md,
    /// section 10).
    pub fn reduced_pressure_unit(&self) -> f64 {
        self.contact_modulus * self.surface.rms_gradient()
    }

    /// Computes the state of `pressure` under `load` with its residuals, from fresh transforms.
    ///
    /// # Errors
    /// A pressure that differs in shape from the grid.
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

    /// Computes the state as [`certify`](Self::certify), from the rows of this process, in [`units`](Self::units).
    pub(crate) fn certified(&self, pressure: Vec<f64>, load: Load) -> Solution {
        let response = &self.response;
        let mut compliance = Compliance::of(self);
        let mut displacement = vec![0.0; pressure.len()];
        let columns = response.grid().rows()[1];
        let source = |_: usize, Rows(p, _): Rows<&[f64]>, row: &mut [f64]| row.copy_from_slice(p);
        // u_z = −G p, less the shortening of the springs that the response does not contain.
        let sink = |_: usize, row: &mut [f64], Rows(u, _): Rows<&mut [f64]>| {
            u.iter_mut().zip(row).for_each(|(u, g)| *u = -*g);
        };
        let (input, output) = (Rows(&pressure[..], columns), Rows(&mut displacement[..], columns));
        compliance.apply_rows(response.compliance(), (input, source), (output, sink));
        if let Some(springs) = &self.springs {
            for_each((&mut displacement[..], &pressure[..], &springs[..]), &|_, (u, p, k)| {
                u.iter_mut().zip(p.iter().zip(k)).for_each(|(u, (p, k))| *u -= k * p);
            });
        }
        // The gap of the solution needs the memory.
        compliance.release();
        let sinking = self.sinking(&pressure);
        let mut solution = self.state_of((pressure, displacement), sinking, load);
        solution.effort.transform_pairs = compliance.pairs();
        if let Some(response) = &self.all_components {
            let (lateral, pairs) = full::lateral_by(&solution.pressure, response);
            solution.lateral = Some(lateral);
            solution.effort.transform_pairs += pairs;
        }
        solution
    }

    /// Returns the uniform downward displacement of the body under a pressure that [`Compliance`] does not contain.
    pub(crate) fn sinking(&self, pressure: &[f64]) -> f64 {
        match self.uniform_compliance() {
            0.0 => 0.0,
            compliance => compliance * self.share.total_of(pressure) / self.share.total() as f64,
        }
    }

    /// Returns the state of a pressure and of the displacement u_z that follows from it, with the residuals, in
    /// [`units`](Self::units). The displacement does not contain the uniform `sinking`.
    pub(crate) fn state_of(
        &self,
        (pressure, displacement): (Vec<f64>, Vec<f64>),
        sinking: f64,
        load: Load,
    ) -> Solution {
        let (length_scale, hardness) = (self.length_scale(load), self.hardness.as_ref());
        let conditions = Conditions { sinking, load, length_scale, extent: self.worn, hardness };
        Solution::of(&self.scaled, self.response.contact_modulus(), pressure, displacement, conditions)
    }

    /// Returns the length scale of the residuals before the displacement is known, in [`units`](Self::units). Worn
    /// surfaces may touch at an approach that is very small beside the depth lost.
    pub(crate) fn length_scale(&self, load: Load) -> f64 {
        let scale = self.scaled.length_scale(load);
        if self.worn > 0.0 { scale.max(RigidSurface::finer_scale(self.scaled.rms_height(), self.worn)) } else { scale }
    }

    /// Returns the compliance of the uniform mode and its stiffness in preconditioners, if the mode takes part in the
    /// search: if the approach of a periodic surface is prescribed.
    pub(crate) fn level_under(&self, load: Load) -> Option<[f64; 2]> {
        let takes_part = self.free.is_none() && matches!(load, Load::Approach(_));
        takes_part.then(|| {
            let compliance = self.response.uniform_compliance();
            let level = LEVEL * self.response.stiffness_range()[0];
            let stiffness = match (1.0 / compliance, self.is_softened) {
                // Springs on a body with a fixed mean level may have hardly any compliance.
                (own, true) => own.min(level),
                (own, false) if compliance > 0.0 => own,
                _ => level,
            };
            [compliance, stiffness]
        })
    }

    /// Returns the stiffness of a wave as a function of its number of periods along the longer side.
    pub(crate) fn stiffness_of_waves(&self) -> impl Fn(usize) -> f64 {
        let points = self.response.grid().points();
        let stride = if points[0] >= points[1] { 1 } else { points[0] };
        move |periods| 1.0 / self.response.compliance_at(periods * stride)
    }

    /// Returns G of the periodic modes of this process, with the compliance of the `uniform` mode if it is given.
    pub(crate) fn table(&self, uniform: Option<f64>) -> Cow<'_, [f64]> {
        let mut table = Cow::from(self.response.compliance());
        if let (Some(uniform), true) = (uniform, self.response.has_uniform()) {
            table.to_mut()[0] = uniform;
        }
        table
    }

    /// Returns the compliance of the uniform mode that [`Compliance`] does not contain.
    pub(crate) fn uniform_compliance(&self) -> f64 {
        if self.free.is_some() { 0.0 } else { self.response.uniform_compliance() }
    }

    /// Returns true if no pressure moves the mean level of the whole surface.
    pub(crate) fn has_fixed_mean(&self) -> bool {
        self.free.is_none() && self.springs.is_none() && self.response.uniform_compliance() == 0.0
    }

    /// Returns false if the potential of a conductor is known up to a constant.
    pub(crate) fn has_level(&self) -> bool {
        self.free.as_ref().is_none_or(|free| free.has_level())
    }

    /// Checks that the contact can carry `load`.
    pub(crate) fn check_load(&self, load: Load) -> Result<(), Refusal> {
        match load {
            Load::Approach(_) if self.all_components.is_some() => Err(Refusal::NoApproach),
            Load::MeanPressure(found) if !(found > 0.0 && found.is_finite()) => Err(Refusal::MeanPressure { found }),
            Load::Approach(found) => {
                // With a hardness points yield, and any approach has a state.
                let is_fixed = self.hardness.is_none() && self.has_fixed_mean();
                let limit = is_fixed.then_some(self.surface.mean_clearance());
                let reachable = found > 0.0 && found < limit.unwrap_or(f64::INFINITY);
                if reachable { Ok(()) } else { Err(Refusal::Approach { found, limit }) }
            }
            Load::MeanPressure(found) => {
                let hardness = self.upper().mean_over(&self.share) * self.units.stress();
                if found < hardness {
                    return Units::check_pressure(found);
                }
                let what = if let Some(Upper::Each(_)) = self.hardness { "mean hardness" } else { "hardness" };
                Err(Refusal::BeyondHardness { found, what, hardness })
            }
        }
    }

    /// Returns the start pressure in [`units`](Self::units), if it is valid.
    pub(crate) fn check_start(&self, start: ArrayView2<f64>) -> Result<Vec<f64>, Refusal> {
        self.check_size(start)?;
        let wrong = start.indexed_iter().find(|(_, p)| !(p.is_finite() && **p >= 0.0));
        let first = if self.share.is_whole() { 0 } else { self.share.rows().start };
        if let Some((index, value)) = self.share.first(wrong.map(|((i, j), value)| ([first + i, j], *value))) {
            return Err(Refusal::StartPressure { index, value });
        }
        if !self.share.any(start.iter().any(|p| *p > 0.0)) {
            return Err(Refusal::StartApart);
        }
        let stress = self.units.stress();
        Ok(start.iter().map(|p| p / stress).collect())
    }

    pub(crate) fn check_size(&self, pressure: ArrayView2<f64>) -> Result<(), Refusal> {
        let expected = self.surface.shape();
        if self.share.any(<[usize; 2]>::from(pressure.dim()) != expected) {
            return Err(Refusal::Start { found: pressure.len(), expected: expected.iter().product() });
        }
        Ok(())
    }
}
