use std::sync::Arc;

use gfmd_contact::{
    Budget, Contact, Drive, Effort, Equilibrium, Heights, Load, Refusal, RigidSurface, Solution, SolveError, Solver,
    Stiffness,
};
use gfmd_field::{Grid, Share};
use gfmd_green::Body;
use gfmd_relax::Why;
use gfmd_response::NormalResponse;
use gfmd_vector::contiguous;
use ndarray::{Array2, Array3, ArrayRef2};
use rayon::prelude::*;

use crate::cells::Cells;
use crate::lane::Selection;
use crate::operator::{CellFields, Operator};
use crate::plastic::{Yielded, scatter};
use crate::state::FlowResidual;
use crate::volume::{COMPONENTS, Volume};
use crate::{Cell, Hardening, PlasticState, PlasticStrain, PlasticityError};

/// Contact of a rigid rough surface with a body that yields below its surface, without friction or adhesion.
///
/// Small strains, J2 flow with isotropic and linear kinematic hardening. The plastic strain is constant in depth in
/// each of the [`Cells`]; the compliance of the contact is exact for the body, so that a contact that does not yield is
/// the [`Contact`] of the elastic body. Each step is one convex minimisation (backward Euler).
#[derive(Clone, Debug)]
pub struct YieldingContact {
    contact: Contact,
    pub(crate) response: Arc<NormalResponse>,
    pub(crate) volume: Arc<Volume>,
    /// Largest mean pressure divided by the pressure at which the whole half-space yields; none on rigid ground.
    limit: Option<f64>,
}

/// Elastic contact at a given plastic strain.
pub(crate) struct Evaluation {
    /// Contact, with the plastic displacement in the clearance and not in its displacement.
    pub(crate) solution: Solution,
    /// Normal displacement by plastic strain alone.
    pub(crate) plastic_displacement: Vec<f64>,
    /// Deviatoric strain of the cells that may yield.
    pub(crate) strain: CellFields<f64>,
    /// Unbalanced forces on nodes divided by the forces on them.
    pub(crate) unbalanced: f64,
}

/// Energies of a state, per area.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Energies {
    pub(crate) elastic: f64,
    pub(crate) hardening: f64,
    pub(crate) dissipated: f64,
}

/// Returns the approach at which a contact touches at one point.
fn first_touch(contact: &Contact) -> f64 {
    let lowest = contact.surface().clearance().iter().fold(f64::INFINITY, gfmd_vector::lower);
    contact.surface().share().each(lowest).into_iter().fold(f64::INFINITY, gfmd_vector::lower)
}

/// Part of the pressure of uniform yield that a half-space carries.
const UNIFORM_YIELD: f64 = 0.95;

impl YieldingContact {
    /// Makes the contact of `body` with a rigid profile `heights` on `grid`, in length, with peaks towards the body.
    /// `hardening` has one entry per layer of the body, from the top, `None` for a layer that does not yield. The
    /// second of two bodies is elastic.
    ///
    /// # Errors
    /// The errors of [`Contact::new`]; a yield stress of a tenth of Young's modulus or more, a Poisson's ratio above
    /// 0.495 in a layer with cells, and cells that do not fit the body or the grid.
    pub fn new<'a>(
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
        hardening: &[Option<Hardening>],
        cells: &Cells,
    ) -> Result<Self, PlasticityError> {
        Self::distributed(&grid.whole(), body, grid, heights, hardening, cells)
    }

    /// Makes the contact as [`new`](Self::new), solved by the processes of a [`share`](Contact::share). Each process
    /// gives and gets only its rows of the surface and of the cells, and all make the same calls. Fields and numbers
    /// have the bits of a single process.
    ///
    /// # Errors
    /// The errors of [`new`](Self::new), on all processes.
    pub fn distributed<'a>(
        share: &Share,
        body: &Body,
        grid: &Grid,
        heights: impl Into<Heights<'a>>,
        hardening: &[Option<Hardening>],
        cells: &Cells,
    ) -> Result<Self, PlasticityError> {
        let contact = Contact::distributed(share, body, grid, heights)?;
        let mesh = cells.mesh(body, grid, hardening)?.over(share);
        let limit = mesh.cells.last().filter(|_| mesh.reaches_half_space).and_then(|cell| {
            // A uniform pressure has σ_xx = σ_zz C12/C11, and the equivalent stress p (1 − C12/C11) = 2 p C44/C11.
            let part = 2.0 * cell.shear_modulus / cell.p_wave_modulus;
            cell.hardening.as_ref().map(|hardening| UNIFORM_YIELD * hardening.yield_stress() / part)
        });
        let response = Arc::new(NormalResponse::distributed(*grid, body, share));
        let volume = Arc::new(Volume::new(mesh));
        Ok(Self { contact, response, volume, limit })
    }

    /// Returns the rows of this process on the surface.
    fn share(&self) -> &Share {
        &self.volume.mesh.division.surface
    }

    /// Returns the rigid surface.
    pub fn surface(&self) -> &RigidSurface {
        self.contact.surface()
    }

    /// Returns the elastic contact of the body that has not yielded.
    pub fn contact(&self) -> &Contact {
        &self.contact
    }

    /// Returns the cells, from the surface down.
    pub fn cells(&self) -> &[Cell] {
        &self.volume.mesh.cells
    }

    /// Returns the number of cells on the full grid that would have as many points: the cost of a volume operator is
    /// five transform pairs for each.
    pub fn equivalent_cells(&self) -> f64 {
        self.volume.mesh.equivalent_cells()
    }

    /// Returns the state at first touch of the body that has not yielded.
    ///
    /// # Errors
    /// None in practice: the state of no pressure is valid in every contact.
    pub fn rest(&self) -> Result<PlasticState, Refusal> {
        let shape = self.contact.surface().shape();
        Ok(PlasticState {
            solution: self.contact.certify(&Array2::zeros(shape), Load::Approach(0.0))?,
            plastic_displacement: Array2::zeros(shape),
            plastic: PlasticStrain::none(self.cells().len()),
            plastic_before: PlasticStrain::none(self.cells().len()),
            elastic_energy: 0.0,
            hardening_energy: 0.0,
            dissipated: 0.0,
            work_imbalance: 0.0,
            residual: FlowResidual::default(),
            operators: 0,
            mesh: Arc::clone(&self.volume.mesh),
        })
    }

    /// Makes the plastic strain of a state from fields: ε^p as [`PlasticState::plastic_strain`] gives it for each cell,
    /// and κ as [`PlasticState::equivalent_plastic_strain`].
    ///
    /// # Errors
    /// Fields that differ in number or shape from the cells, or are not finite; a negative κ.
    pub fn plastic_strain(&self, strain: &[Array3<f64>], equivalent: &[Array2<f64>]) -> Result<PlasticStrain, Refusal> {
        PlasticStrain::of_fields(&self.volume.mesh, strain, equivalent)
    }

    /// Checks a load, and that the state before belongs to this contact.
    pub(crate) fn check_step(&self, before: &PlasticState, load: Load, tolerance: f64) -> Result<(), Refusal> {
        if *before.mesh != *self.volume.mesh {
            return Err(Refusal::OtherKind);
        }
        self.check_load(load)?;
        self.check_resolution(load, tolerance)
    }

    /// Checks that the tolerance resolves a load.
    pub(crate) fn check_resolution(&self, load: Load, tolerance: f64) -> Result<(), Refusal> {
        if load.is_lifted() { Ok(()) } else { self.contact.check_resolution(Drive::from(load), tolerance) }
    }

    /// Checks a load.
    pub(crate) fn check_load(&self, load: Load) -> Result<(), Refusal> {
        if load.is_lifted() {
            return Ok(());
        }
        self.contact.check(Drive::from(load))?;
        match (load, self.limit) {
            (Load::MeanPressure(found), Some(limit)) if found >= limit => {
                Err(Refusal::YieldsUniformly { found, limit })
            }
            _ => Ok(()),
        }
    }

    /// Computes the stiffness of a state, d(mean pressure)/d(approach), in stress/length, to a relative `tolerance`.
    /// It is elastic, with the points in contact kept: the stiffness at the beginning of unloading.
    ///
    /// # Errors
    /// The stiffness reached, and the reason, if it is less exact.
    pub fn stiffness(&self, state: &PlasticState, tolerance: f64) -> Result<Stiffness, (Stiffness, Why)> {
        self.contact.stiffness(&state.solution, tolerance)
    }

    /// Computes the elastic contact at a plastic strain.
    pub(crate) fn evaluate(
        &self,
        operator: &mut Operator<f64>,
        plastic: &PlasticStrain,
        load: Load,
        start: &Array2<f64>,
        budget: &Budget,
    ) -> Result<Evaluation, Refusal> {
        let plastic_displacement = self.plastic_displacement(operator, plastic);
        let solution = self.touch(&plastic_displacement, load, start, budget)?;
        let (strain, unbalanced) = self.strain_of(operator, plastic, &solution.pressure);
        Ok(Evaluation { solution, plastic_displacement, strain, unbalanced })
    }

    /// Computes the normal displacement of the surface by plastic strain, and leaves the spectra of the strain in the
    /// operator.
    fn plastic_displacement(&self, operator: &mut Operator<f64>, plastic: &PlasticStrain) -> Vec<f64> {
        let mut displacement = vec![0.0; self.response.share().own().len()];
        let selection = self.selection(plastic);
        operator.analyse(&selection.plastic, |number, component, field| {
            let Yielded { points, strain, .. } = &*plastic.cells[number];
            scatter(field, points.len(), &|k| points[k], &|k| strain[k][component]);
        });
        if selection.plastic.contains(&true) {
            operator.surface_displacement(&selection.plastic, &mut displacement);
        }
        displacement
    }

    fn selection(&self, plastic: &PlasticStrain) -> Selection {
        Selection {
            plastic: plastic.yielded(&self.volume.mesh),
            strain: self.cells().iter().map(|cell| cell.hardening.is_some()).collect(),
        }
    }

    /// Brings the contact with the displaced surface to rest.
    fn touch(
        &self,
        plastic_displacement: &[f64],
        load: Load,
        start: &Array2<f64>,
        budget: &Budget,
    ) -> Result<Solution, Refusal> {
        let points = start.dim();
        let depth = plastic_displacement.iter().map(|u| -u).collect();
        let depth = Array2::from_shape_vec(points, depth).expect("the displacement has the size of the grid");
        let contact = self.contact.with_indentation(&depth)?;
        let is_apart = match load {
            // The imprint of earlier loads may be deeper than the approach.
            Load::Approach(approach) => first_touch(&contact) >= approach,
            Load::MeanPressure(mean) => mean == 0.0,
        };
        if is_apart {
            let mut solution = contact.certify(&Array2::zeros(points), load)?;
            solution.residual.complementarity = 0.0;
            return Ok(solution);
        }
        let is_pressed = self.share().any(start.iter().any(|p| *p > 0.0));
        let start = is_pressed.then(|| contact.certify(start, load)).transpose()?;
        match contact.equilibrate(load.into(), Solver::Auto, budget, start.as_ref(), &mut ()) {
            Ok(solution) => Ok(solution),
            // The residuals of the final state decide.
            Err(SolveError::Refused(refusal)) => Err(refusal),
            Err(
                SolveError::NotConverged { state, .. }
                | SolveError::Interrupted { state }
                | SolveError::Detached { state, .. },
            ) => Ok(*state),
        }
    }

    /// Computes the strain of all cells that yield, from the spectra that [`Self::plastic_displacement`] left, and how
    /// far its stress is from equilibrium.
    fn strain_of(
        &self,
        operator: &mut Operator<f64>,
        plastic: &PlasticStrain,
        pressure: &Array2<f64>,
    ) -> (CellFields<f64>, f64) {
        let selection = self.selection(plastic);
        let unbalanced = operator.strain_in_balance(&contiguous(pressure), &selection);
        (operator.fields(&selection.strain), unbalanced)
    }

    /// Computes the energies of an evaluation (Colonnetti's theorem: the stress by the load and the residual stress do
    /// no work on each other).
    pub(crate) fn energies(
        &self,
        evaluation: &Evaluation,
        plastic: &PlasticStrain,
        before: &PlasticStrain,
    ) -> Energies {
        let Evaluation { solution, plastic_displacement, strain, .. } = evaluation;
        let (pressure, displacement) = (contiguous(&solution.pressure), contiguous(&solution.displacement));
        let (share, n) = (self.share(), self.share().total() as f64);
        let by_load = -0.5 * share.dot(&pressure, &displacement) / n;
        let on_load = share.dot(&pressure, plastic_displacement) / n;
        let (mesh, cells) = (&self.volume.mesh, self.cells());
        let on_plastic = plastic.integral(mesh, |number, place, plastic_strain, _| {
            let fields = &strain[number];
            let (points, i) = (fields.len() / COMPONENTS, plastic.cells[number].points[place] as usize);
            let product = |c: usize| (fields[c * points + i] - plastic_strain[c]) * plastic_strain[c];
            2.0 * cells[number].shear_modulus * (0..COMPONENTS).map(product).sum::<f64>()
        });
        let of_hardening = |number: usize| cells[number].hardening.as_ref();
        let hardening = plastic.integral(mesh, |number, _, strain, equivalent| {
            of_hardening(number).map_or(0.0, |hardening| hardening.stored_energy(strain, equivalent))
        });
        let dissipated = |plastic: &PlasticStrain| {
            plastic.integral(mesh, |number, place, _, equivalent| {
                let point = plastic.cells[number].points[place];
                let increment = equivalent - before.cells[number].at(point).1;
                of_hardening(number).map_or(0.0, |hardening| hardening.yield_stress() * increment)
            })
        };
        Energies { elastic: by_load - 0.5 * (on_plastic + on_load), hardening, dissipated: dissipated(plastic) }
    }

    /// Computes the residuals of yield condition and flow, without equilibrium.
    pub(crate) fn flow_residual(
        &self,
        strain: &CellFields<f64>,
        plastic: &PlasticStrain,
        before: &PlasticStrain,
    ) -> FlowResidual {
        let division = &self.volume.mesh.division;
        let largest = division.largest(plastic.largest());
        let per = if largest > 0.0 { 1.0 / largest } else { 1.0 };
        let none = [0.0; 3];
        let worst = |a: [f64; 3], b: [f64; 3]| std::array::from_fn(|k| if b[k] <= a[k] { a[k] } else { b[k] });
        let mut all = none;
        for (number, cell) in self.cells().iter().enumerate() {
            let Some(hardening) = &cell.hardening else { continue };
            let fields = &strain[number];
            let points = fields.len() / COMPONENTS;
            let (now, then) = (&plastic.cells[number], &before.cells[number]);
            let of_range = |range: std::ops::Range<usize>| {
                let mut place = now.points.partition_point(|point| (*point as usize) < range.start);
                let mut found = none;
                for i in range {
                    let strain: [f64; COMPONENTS] = std::array::from_fn(|c| fields[c * points + i]);
                    let yielded = now.points.get(place).is_some_and(|point| *point as usize == i);
                    let (plastic, equivalent) =
                        if yielded { (now.strain[place], now.equivalent[place]) } else { ([0.0; COMPONENTS], 0.0) };
                    place += usize::from(yielded);
                    let driving = hardening.driving_stress(cell.shear_modulus, &strain, &plastic);
                    let over = hardening.overstress(&driving, equivalent) / hardening.yield_stress();
                    let mut one = [over.max(0.0), 0.0, 0.0];
                    if over.is_nan() {
                        one[0] = over;
                    }
                    if yielded {
                        let (earlier, start) = then.at(i as u32);
                        let increment = equivalent - start;
                        let size = crate::hardening::norm(&driving).max(f64::MIN_POSITIVE);
                        let error: [f64; COMPONENTS] = std::array::from_fn(|c| {
                            plastic[c] - earlier[c] - 1.5_f64.sqrt() * increment * driving[c] / size
                        });
                        one[1] = crate::hardening::norm(&error) * per;
                        one[2] = (increment * -over).max(-increment) * per;
                    }
                    found = worst(found, one);
                }
                found
            };
            all = worst(all, gfmd_vector::reduce(points, &of_range, &worst));
        }
        let mesh = &self.volume.mesh;
        let bottom = mesh.is_fitted && mesh.is_cut && division.surface.any(plastic.yields_in_lowest());
        let bottom = f64::from(bottom);
        let [yielding, flow, flow_complementarity] = division.worst(all, worst);
        FlowResidual { yielding, flow, flow_complementarity, equilibrium: 0.0, bottom }
    }

    /// Makes the state of an evaluation.
    pub(crate) fn state(
        &self,
        evaluation: &Evaluation,
        plastic: PlasticStrain,
        before: &PlasticState,
        effort: Effort,
    ) -> PlasticState {
        let Evaluation { solution, plastic_displacement, strain, unbalanced } = evaluation;
        let Energies { elastic, hardening, dissipated } = self.energies(evaluation, &plastic, &before.plastic);
        let flow = self.flow_residual(strain, &plastic, &before.plastic);
        let residual = FlowResidual { equilibrium: *unbalanced, ..flow };
        let mut solution = solution.clone();
        let displaced = Array2::from_shape_vec(solution.displacement.dim(), plastic_displacement.clone())
            .expect("the displacement has the size of the grid");
        solution.displacement += &displaced;
        solution.effort = effort;
        let mean = 0.5 * (solution.mean_pressure + before.solution.mean_pressure);
        let work = mean * (solution.approach - before.solution.approach);
        let stored = (elastic + hardening) - (before.elastic_energy + before.hardening_energy);
        PlasticState {
            solution,
            plastic_displacement: displaced,
            plastic,
            plastic_before: before.plastic.clone(),
            elastic_energy: elastic,
            hardening_energy: hardening,
            dissipated,
            work_imbalance: (work - stored - dissipated).abs(),
            residual,
            operators: effort.iterations,
            mesh: Arc::clone(&self.volume.mesh),
        }
    }

    /// Computes the state of a `pressure`, a plastic strain and κ under a `load`, after the state `before`, with all
    /// residuals, from one fresh operator in double precision.
    ///
    /// # Errors
    /// A pressure that differs in shape from the grid, or plastic strain of other cells.
    pub fn certify(
        &self,
        before: &PlasticState,
        pressure: &ArrayRef2<f64>,
        plastic: &PlasticStrain,
        load: Load,
    ) -> Result<PlasticState, Refusal> {
        let is_other = plastic.cells.len() != self.cells().len() || *before.mesh != *self.volume.mesh;
        let beyond = |(cell, yielded): (usize, &Arc<Yielded>)| {
            let points = self.volume.mesh.division.points(cell);
            yielded.points.last().is_some_and(|last| *last as usize >= points)
        };
        if self.share().any(is_other || plastic.cells.iter().enumerate().any(beyond)) {
            return Err(Refusal::OtherKind);
        }
        let mut operator = Operator::new(&self.volume);
        let plastic_displacement = self.plastic_displacement(&mut operator, plastic);
        let depth: Vec<f64> = plastic_displacement.iter().map(|u| -u).collect();
        let shape = self.contact.surface().shape();
        let depth = Array2::from_shape_vec(shape, depth).expect("the displacement has the size of the grid");
        let contact = self.contact.with_indentation(&depth)?;
        let mut solution = contact.certify(pressure, load)?;
        let parted = solution.mean_pressure == 0.0 && solution.residual.penetration == 0.0;
        if parted {
            solution.residual.complementarity = 0.0;
        }
        let (strain, unbalanced) = self.strain_of(&mut operator, plastic, &solution.pressure);
        let transform_pairs = operator.pairs() + solution.effort.transform_pairs;
        let effort = Effort { iterations: 1, transform_pairs };
        let evaluation = Evaluation { solution, plastic_displacement, strain, unbalanced };
        Ok(self.state(&evaluation, plastic.clone(), before, effort))
    }

    /// Applies `work` to stretches of the points of a cell, and returns the results in order.
    pub(crate) fn stretches<R: Send>(points: usize, work: impl Fn(std::ops::Range<usize>) -> R + Sync) -> Vec<R> {
        let count = points.div_ceil(gfmd_vector::LEAF);
        let range = |k: usize| k * gfmd_vector::LEAF..((k + 1) * gfmd_vector::LEAF).min(points);
        (0..count).into_par_iter().map(|k| work(range(k))).collect()
    }
}
