//! Laws at both faces of a plate between two rough rigid surfaces (theory.md, section 8.4).
//!
//! Both faces are one contact with twice the points: the fields of the lower face, seen from outside the plate, follow
//! the fields of the upper one. Half of the approach acts on each face, and the shift of the plate as a whole is one
//! more unknown, with no stiffness of its own.

use std::sync::Arc;

use gfmd_contact::{
    Drive, Effort, Equilibrium, Fields, Hardness, Heights, Load, Refusal, Resumable, RigidSurface, SolveError, Solver,
    SqueezedContact, SqueezedSolution, Stiffness, Visit,
};
use gfmd_field::{Grid, Share};
use gfmd_measure::{Scales, Summary};
use gfmd_relax::{Budget, Watch};
use gfmd_vector::contiguous;
use ndarray::{Array2, ArrayRef2, ArrayView2, Axis, CowArray, Ix2, Zip, concatenate, s};

use crate::quasistatic::{Parts, QuasistaticContact, QuasistaticState, StiffnessError};
use crate::{Interface, Loss, Quasistatic, Reading, State, StoredFields, Trapping};

/// Slab, or stack of layers, between two rigid surfaces, with one law at both faces. Nothing else holds the slab: the
/// mean pressures on its two faces are equal. Clones share the data.
#[derive(Clone, Debug)]
pub struct Squeezed {
    contact: QuasistaticContact,
    surfaces: [Arc<RigidSurface>; 2],
}

/// State of a [`Squeezed`] contact. Each face has its fields, its mean pressure and its part of the approach.
/// Displacements are measured from the level at which the mean displacements of the two faces are opposite, positive
/// out of the plate. In both faces, energies, losses, residuals and effort belong to the whole plate.
#[derive(Clone, Debug)]
pub struct SqueezedState {
    /// Both faces as one.
    both: QuasistaticState,
    /// Contact with the upper surface.
    pub upper: QuasistaticState,
    /// Contact with the lower surface, seen from below.
    pub lower: QuasistaticState,
    /// Approach of the two rigid surfaces to each other beyond the distance at which both touch the undeformed slab.
    pub approach: f64,
}

/// Computes the stiffness d(mean pressure)/d(approach) of a slab between two hard walls, in stress/length, to a
/// relative error, as [`Interface::stiffness`]. The points in contact stay in contact, and points at the hardness keep
/// their pressure.
///
/// # Errors
/// Returns the reason why there is none.
pub fn stiffness_between_walls(
    contact: &SqueezedContact,
    state: &SqueezedSolution,
    tolerance: f64,
) -> Result<Stiffness, StiffnessError> {
    let (units, [upper, lower]) = (contact.units(), contact.surfaces_in_units());
    let walls = Interface::at_wall(Arc::clone(contact.response()), RigidSurface::stacked(upper, lower)?.into());
    let hardness = contact.hardness().map(|hardness| of_both(&hardness.times(1.0 / units.stress()), upper));
    let walls = match hardness.transpose()? {
        Some(hardness) => walls.with_hardness(hardness)?,
        None => walls,
    };
    let faces = [&state.upper, &state.lower];
    let [upper, lower] = faces.map(|face| face.pressure.mapv(|p| p / units.stress()));
    let wall_pressure = stacked(&upper, &lower);
    let [upper, lower] = faces.map(|face| face.gap.mapv(|gap| gap / units.length()));
    let closed = |gap: &f64, p: &f64| if *p > 0.0 { 0.0 } else { *gap };
    let gap = Zip::from(&stacked(&upper, &lower)).and(&wall_pressure).map_collect(closed);
    let blank = walls.blank(Load::MeanPressure(0.0).into())?;
    let traction = -wall_pressure.clone().insert_axis(Axis(0));
    let found = walls.stiffness(&State { traction, gap, wall_pressure, approach: 0.0, ..blank }, tolerance)?;
    Ok(Stiffness { value: 0.5 * found.value * units.stiffness(), ..found })
}

impl Interface {
    /// Returns a face, 0 for the upper one, of the state of both faces of a plate, which is in this unit of `length`.
    pub(crate) fn face_of(&self, both: &State, face: usize, surface: &Arc<RigidSurface>, length: f64) -> State {
        let rows = both.gap.nrows() / 2;
        let part = |field: &Array2<f64>| field.slice(s![face * rows..(face + 1) * rows, ..]).to_owned();
        let share = surface.share();
        let means = |field: &ndarray::Array3<f64>| {
            let (points, field) = (field.len() / 2, contiguous(field));
            [0, 1].map(|face| share.total_of(&field[face * points..(face + 1) * points]) / share.total() as f64)
        };
        let [above, below] = means(&both.displacement);
        let shift = if face == 0 { 0.5 * (above - below) } else { 0.5 * (below - above) };
        let tractions = means(&both.traction);
        let vectors = |field: &ndarray::Array3<f64>| field.slice(s![.., face * rows..(face + 1) * rows, ..]).to_owned();
        let (gap, wall_pressure) = (part(&both.gap), part(&both.wall_pressure));
        let touching = match self.law.has_wall() {
            true => wall_pressure.iter().filter(|pressure| **pressure > 0.0).count(),
            false => gap.iter().filter(|gap| self.law.traction(**gap / length, [0.0; 2])[2] < 0.0).count(),
        };
        State {
            displacement: vectors(&both.displacement) - shift,
            traction: vectors(&both.traction),
            contact_fraction: share.each(touching).into_iter().sum::<usize>() as f64 / share.total() as f64,
            gap,
            wall_pressure,
            pressed_in: both.pressed_in.as_ref().map(part),
            mean_pressure: both.mean_pressure + 0.5 * (tractions[1 - face] - tractions[face]),
            approach: both.approach + shift,
            elastic_energy: 2.0 * both.elastic_energy,
            interface_energy: 2.0 * both.interface_energy,
            surface: Arc::clone(surface),
            ..both.clone()
        }
    }
}

/// Returns the surfaces of both faces.
fn surfaces(share: &Share, grid: &Grid, faces: [Heights; 2]) -> Result<[Arc<RigidSurface>; 2], Refusal> {
    let surface = |heights: Heights| RigidSurface::distributed(share, grid, heights).map(Arc::new);
    Ok([surface(faces[0])?, surface(faces[1])?])
}

/// Returns the hardness of both faces.
fn of_both(hardness: &Hardness, surface: &RigidSurface) -> Result<Hardness, Refusal> {
    let Hardness::Field(field) = hardness else { return Ok(hardness.clone()) };
    let (found, expected) = (field.dim().into(), surface.shape());
    if surface.share().any(found != expected) {
        return Err(Refusal::HardnessShape { found, expected });
    }
    Ok(Hardness::Field(stacked(field, field)))
}

fn stacked(upper: &ArrayRef2<f64>, lower: &ArrayRef2<f64>) -> Array2<f64> {
    concatenate(Axis(0), &[upper.view(), lower.view()]).expect("the fields of both faces have one shape")
}

impl Squeezed {
    /// Creates the contact of the layers of a body, without its base, with two rigid profiles: the heights of `parts`
    /// above the slab and the lower ones below it. Points with the same indices lie above each other. Without a law,
    /// both are hard walls, solved as laws; a hardness has the points of one face.
    ///
    /// # Errors
    /// Returns an error as [`QuasistaticContact::new`]; without a lower surface; for a body that is no slab and no
    /// stack of layers; and for shear, wear by slip, a body that relaxes in shear alone, and free boundaries.
    pub fn new(parts: &Parts) -> Result<Self, Refusal> {
        let lower = parts.lower.ok_or(Refusal::Faces { found: 1, expected: 2 })?;
        let surfaces = surfaces(&parts.share(), parts.grid, [parts.heights, lower])?;
        let hardness = parts.hardness.as_ref().map(|hardness| of_both(hardness, &surfaces[0])).transpose()?;
        let contact = QuasistaticContact::squeezed(&Parts { hardness, ..parts.clone() }, &surfaces)?;
        Ok(Self { contact, surfaces })
    }

    /// Returns the rigid surfaces: the upper, then the lower.
    pub fn surfaces(&self) -> [&RigidSurface; 2] {
        self.surfaces.each_ref().map(|surface| &**surface)
    }

    /// Returns a warning if the law is too steep for the grid ([`Interface::trapping`]).
    pub fn trapping(&self) -> Option<Trapping> {
        self.contact.trapping()
    }

    /// Returns the names of the fields that [`certify`](Self::certify) needs for a state; empty if it cannot make one,
    /// of a slab that relaxes.
    pub fn basis(&self) -> &'static [&'static str] {
        match self.contact.basis() {
            [] => &[],
            [_, _] => &["gap", "pressure", "lower_gap", "lower_pressure"],
            [_, _, "plastic_depth"] => {
                &["gap", "pressure", "plastic_depth", "lower_gap", "lower_pressure", "lower_plastic_depth"]
            }
            [_, _, _] => &["gap", "pressure", "wear_depth", "lower_gap", "lower_pressure", "lower_wear_depth"],
            _ => &[
                "gap",
                "pressure",
                "plastic_depth",
                "wear_depth",
                "lower_gap",
                "lower_pressure",
                "lower_plastic_depth",
                "lower_wear_depth",
            ],
        }
    }

    /// Computes the state of the [`basis`](Self::basis) fields under a drive, with fresh transforms.
    ///
    /// # Errors
    /// Returns an error if the fields are not the basis or do not fit the grid, or if the drive is invalid.
    pub fn certify(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<SqueezedState, Refusal> {
        let expected = self.basis().len();
        if expected == 0 || fields.len() != expected {
            return Err(Refusal::Basis { found: fields.len(), expected });
        }
        let (upper, lower) = fields.split_at(expected / 2);
        let both = upper.iter().zip(lower).map(|(upper, lower)| self.stack(upper, lower));
        let both = both.collect::<Result<Vec<_>, _>>()?;
        let both: Vec<&ArrayRef2<f64>> = both.iter().map(|field| &**field).collect();
        self.contact.certify(&both, half(drive)).map(|both| self.state(both)).map_err(whole)
    }

    /// Restores a state from the stored fields of both faces, as a start. The approach of the upper ones is the
    /// approach of the two surfaces to each other.
    ///
    /// # Errors
    /// Returns an error for fields that do not fit the grid.
    pub fn recall(&self, upper: StoredFields<'_>, lower: StoredFields<'_>) -> Result<SqueezedState, Refusal> {
        let clearance = self.surfaces[0].clearance();
        let (share, approach) = (self.surfaces[0].share(), 0.5 * upper.approach);
        let pressure = self.stack(upper.pressure, lower.pressure)?;
        let values = upper.gap.iter().zip(upper.displacement_z);
        let above: Vec<f64> = clearance.iter().zip(values).map(|(clearance, (gap, u))| clearance - gap - u).collect();
        let shift = share.total_of(&above) / share.total() as f64 - approach;
        let displacement_z = self.stack(&(upper.displacement_z + shift), &(lower.displacement_z - shift))?;
        let gap = self.stack(upper.gap, lower.gap)?;
        let both = StoredFields { pressure: &pressure, displacement_z: &displacement_z, gap: &gap, approach };
        self.contact.recall(both).map(|both| self.state(both))
    }

    /// Computes the stiffness d(mean pressure)/d(approach) of a state, in stress/length, to a relative error, as
    /// [`Interface::stiffness`].
    ///
    /// # Errors
    /// Returns the reason why there is none.
    pub fn stiffness(&self, state: &SqueezedState, tolerance: f64) -> Result<Stiffness, StiffnessError> {
        let found = self.contact.stiffness(&state.both, tolerance)?;
        Ok(Stiffness { value: 0.5 * found.value, ..found })
    }

    /// Computes the stiffness of the state along a path with these pressures and gaps of the upper and the lower face,
    /// as [`QuasistaticContact::stiffness_of_fields`].
    ///
    /// # Errors
    /// Returns the reason why there is none.
    pub fn stiffness_of_fields(
        &self,
        [upper, lower]: [[&ArrayRef2<f64>; 2]; 2],
        tolerance: f64,
    ) -> Result<Stiffness, StiffnessError> {
        let [pressure, gap] = [self.stack(upper[0], lower[0])?, self.stack(upper[1], lower[1])?];
        let found = self.contact.stiffness_of_fields(&pressure, &gap, tolerance)?;
        Ok(Stiffness { value: 0.5 * found.value, ..found })
    }

    fn stack(&self, upper: &ArrayRef2<f64>, lower: &ArrayRef2<f64>) -> Result<Array2<f64>, Refusal> {
        let (surface, [nx, ny]) = (&self.surfaces[0], self.surfaces[0].shape());
        let wrong = [upper, lower].into_iter().find(|field| field.dim() != (nx, ny)).map(|wrong| wrong.len());
        match surface.share().first(wrong) {
            Some(found) => Err(Refusal::Start { found, expected: nx * ny }),
            None => Ok(stacked(upper, lower)),
        }
    }

    fn state(&self, both: QuasistaticState) -> SqueezedState {
        let [upper, lower] = [0, 1].map(|face| self.contact.face(&both, face, &self.surfaces[face]));
        let approach = 2.0 * both.approach();
        SqueezedState { both, upper, lower, approach }
    }
}

/// Returns the drive of each face.
fn half(drive: Drive) -> Drive {
    match drive.load {
        Load::Approach(approach) => Drive { load: Load::Approach(0.5 * approach), ..drive },
        Load::MeanPressure(_) => drive,
    }
}

/// Converts the approach of a face in a refusal to the approach of both.
fn whole(refusal: Refusal) -> Refusal {
    if let Refusal::Distance { .. } = refusal { refusal } else { refusal.times(2.0, 1.0) }
}

impl Equilibrium for Squeezed {
    type State = SqueezedState;

    fn solvers(&self) -> &'static [Solver] {
        self.contact.solvers()
    }

    fn check(&self, drive: Drive) -> Result<(), Refusal> {
        self.contact.check(half(drive)).map_err(whole)
    }

    fn check_resolution(&self, drive: Drive, tolerance: f64) -> Result<(), Refusal> {
        self.contact.check_resolution(half(drive), tolerance).map_err(whole)
    }

    fn equilibrate(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        start: Option<&Self::State>,
        watch: &mut dyn Watch,
    ) -> Result<Self::State, SolveError<Self::State>> {
        let solved = self.contact.equilibrate(half(drive), solver, budget, start.map(|start| &start.both), watch);
        solved.map(|both| self.state(both)).map_err(|error| match error {
            SolveError::Refused(refusal) => whole(refusal).into(),
            error => error.map(|both| self.state(both)),
        })
    }
}

impl Quasistatic for Squeezed {
    fn reading(&self, state: &Self::State) -> Reading {
        let reading = self.contact.reading(&state.both);
        let loss = match reading.loss {
            Loss::Balance(stored) => Loss::Balance(2.0 * stored),
            Loss::Known(lost) => Loss::Known(2.0 * lost),
            Loss::Certified { lost, imbalance, stored, flows } => Loss::Certified {
                lost: 2.0 * lost,
                imbalance: 2.0 * imbalance,
                stored: stored.map(|stored| 2.0 * stored),
                flows,
            },
            loss @ (Loss::Conserved | Loss::Unknown) => loss,
        };
        let worn = [&state.upper, &state.lower].map(QuasistaticState::wear_volume);
        Reading { approach: state.approach, losses: reading.losses.times(2.0), loss, worn, ..reading }
    }

    fn depends_on_division(&self, start: Option<&Self::State>, end: &Self::State, tolerance: f64) -> bool {
        self.contact.depends_on_division(start.map(|start| &start.both), &end.both, tolerance)
    }

    fn change(&self, start: Option<&Self::State>, from: &Self::State, to: &Self::State) -> f64 {
        self.contact.change(start.map(|start| &start.both), &from.both, &to.both)
    }

    fn change_of_stick(&self, from: &Self::State, to: &Self::State) -> f64 {
        self.contact.change_of_stick(&from.both, &to.both)
    }
}

/// The faces follow from the state of both.
impl Resumable for Squeezed {
    fn keep(&self, state: &mut Self::State, visitor: &mut dyn Visit) {
        self.contact.keep(&mut state.both, visitor);
    }

    fn restore(&self, drive: Drive, visitor: &mut dyn Visit) -> Result<Self::State, Refusal> {
        self.contact.restore(half(drive), visitor).map(|both| self.state(both)).map_err(whole)
    }
}

impl Fields for SqueezedState {
    fn pressure(&self) -> CowArray<'_, f64, Ix2> {
        self.upper.pressure()
    }

    fn repulsion(&self) -> CowArray<'_, f64, Ix2> {
        self.upper.repulsion()
    }

    fn displacement_z(&self) -> ArrayView2<'_, f64> {
        self.upper.displacement_z()
    }

    fn gap(&self) -> ArrayView2<'_, f64> {
        self.upper.gap()
    }

    fn mean_pressure(&self) -> f64 {
        self.upper.mean_pressure()
    }

    fn approach(&self) -> f64 {
        self.approach
    }

    fn effort(&self) -> Effort {
        self.both.effort()
    }

    fn residuals(&self) -> Vec<(&'static str, f64)> {
        self.both.residuals()
    }

    fn scales(&self) -> Scales {
        self.upper.scales()
    }

    /// Returns the summary of the upper contact, with the elastic energy of the plate.
    fn summary_in(&self, scales: &Scales) -> Summary {
        self.upper.summary_in(scales)
    }
}
