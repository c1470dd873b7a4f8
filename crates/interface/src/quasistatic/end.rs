//! State at the end of a step: histories, energies and losses.

use gfmd_contact::{Fields as _, Hardness, Load, Losses, Refusal, Solution};
use gfmd_field::Share;
use gfmd_medium::Energies;
use gfmd_vector::contiguous;
use ndarray::Array2;

use super::QuasistaticContact;
use super::normal::{Normal, NormalState};
use super::shear::Sheared;
use super::state::{QuasistaticState, ShearFields};
use super::step::{Reached, Step};
use crate::numbers::{dot, total};

/// Error of a pressure divided by the pressure that would close the largest gap left in contact; the depth contains the
/// gaps of earlier states.
const OF_A_GAP: f64 = 10.0;
/// Largest relative difference between pressure and hardness at a point that counts as plastic.
const NEAR: f64 = 1e-3;
/// Largest relative difference between net pressure and hardness at a point that counts as plastic beside a law.
const NEAR_BESIDE_A_LAW: f64 = 1e-6;

impl QuasistaticContact {
    /// Returns the state at the end of a step.
    pub(super) fn end(&self, step: &Step, reached: Reached) -> Result<QuasistaticState, Refusal> {
        let Reached { normal, touch, unpressed, sheared, worn } = reached;
        let (factor, points) = (step.affine.factor(), self.points());
        let (share, all) = (self.share(), self.all_points());
        let (memory, energies) = match (&self.medium, &step.memory) {
            (Some(medium), Some(memory)) => {
                let mut indentation: Vec<f64> =
                    sheared.iter().flat_map(|sheared| &sheared.displacement).map(|u| -u).collect();
                let mut pressure: Vec<f64> = sheared.iter().flat_map(|sheared| &sheared.traction).map(|t| -t).collect();
                if let (NormalState::Law(state), true) = (&normal, self.all_components) {
                    let lateral = state.displacement.len() - points;
                    let moved = state.displacement.iter().zip(&step.sideways);
                    indentation.extend(moved.map(|(u, own)| -(u + own)));
                    pressure.extend(state.traction.iter().take(lateral).map(|t| -t));
                }
                let displacement = normal.fields().displacement_z();
                match &unpressed {
                    Some(depth) => indentation.extend(depth.iter().zip(displacement).map(|(depth, u)| depth - u)),
                    None => indentation.extend(displacement.iter().map(|u| -u)),
                }
                pressure.extend(normal.pressure().iter());
                let (memory, energies) = medium.end(memory, &step.affine, indentation, &pressure)?;
                (Some(memory), Some(energies))
            }
            _ => (None, None),
        };
        let mut normal = normal.of_step(factor, (unpressed.as_ref(), &step.sideways), touch);
        if let Load::Approach(asked) = step.drive.load {
            *normal.approach() = asked;
        }
        let stored = match (energies, &sheared) {
            (Some(Energies { stored, .. }), _) => stored,
            (None, Some(sheared)) => {
                let both = sheared.traction.chunks_exact(points).zip(sheared.displacement.chunks_exact(points));
                let lateral: f64 = both.map(|(t, u)| dot(share, t, u)).sum();
                let pressed =
                    dot(share, &contiguous(&normal.pressure()), &contiguous(&normal.fields().displacement_z()));
                0.5 * (lateral - pressed) / all
            }
            (None, None) => normal.elastic_energy(),
        };
        let mut losses = Losses { relaxation: energies.map_or(0.0, |energies| energies.lost), ..Losses::default() };
        let before = |of: fn(&QuasistaticState) -> Option<&Array2<f64>>| {
            step.start.and_then(of).cloned().unwrap_or_else(|| self.field(vec![0.0; points]))
        };
        let pressure = normal.pressure();
        let worn = worn.map(|worn| {
            losses.wear = dot(share, &contiguous(&pressure), &contiguous(&worn)) / all;
            before(QuasistaticState::wear_depth) + worn
        });
        let pressed_in = self.hardness.as_ref().map(|_| {
            let mut depth = before(QuasistaticState::plastic_depth);
            if let Some(growth) = normal.pressed_in() {
                losses.plastic = dot(share, &contiguous(&pressure), &contiguous(growth)) / all;
                depth += growth;
            }
            depth
        });
        drop(pressure);
        let plastic_fraction = self.hardness.as_ref().map_or(0.0, |hardness| self.saturated(&normal, hardness));
        let mut mean_shear = [0.0; 2];
        if let NormalState::Law(state) = &normal {
            mean_shear = state.mean_shear;
        }
        let sheared = sheared.map(|Sheared { displacement, mut traction, slip, sticking, lost, friction, excess }| {
            losses.friction = lost / all;
            traction.iter_mut().for_each(|t| *t *= factor);
            let components = mean_shear.iter_mut().zip(traction.chunks_exact(points));
            components.for_each(|(shear, field)| *shear = total(share, field) / all);
            let stick_fraction = sticking / all;
            ShearFields { displacement, traction, slip, stick_fraction, friction, excess }
        });
        let mut state = QuasistaticState {
            normal,
            sheared,
            mean_shear,
            lateral: step.drive.lateral,
            time: step.drive.time,
            distance: step.drive.distance,
            memory,
            worn,
            pressed_in,
            plastic_fraction,
            stored: Some(stored),
            losses,
            work_imbalance: 0.0,
        };
        self.balance(step, &mut state);
        Ok(state)
    }

    /// Sets the imbalance of work and energy in a step, and the loss in its jumps.
    fn balance(&self, step: &Step, state: &mut QuasistaticState) {
        let interface_energy = state.interface_energy();
        let (mut energy, mut forces, mut places) = (0.0, [0.0; 3], [0.0; 3]);
        if let Some(start) = step.start {
            energy = start.elastic_energy() + start.interface_energy();
            (forces, places) = start.forces_and_places();
        }
        let (forces_now, places_now) = state.forces_and_places();
        let (mut work, mut spread) = (0.0, 0.0);
        for k in 0..3 {
            let moved = places_now[k] - places[k];
            work += 0.5 * (forces[k] + forces_now[k]) * moved;
            // Largest error of the work if the forces change monotonically, jumps included.
            spread += 0.5 * ((forces_now[k] - forces[k]) * moved).abs();
        }
        let missing = work - (state.elastic_energy() + interface_energy - energy) - state.losses.total();
        let is_at_once =
            (self.medium.is_none() || step.affine.duration == 0.0) && (self.wear.is_none() || step.moved == 0.0);
        let flows = self.shear.is_some() || self.hardness.is_some();
        state.work_imbalance = match (step.start, state.law()) {
            // The path on which attracting surfaces came together is unknown.
            (None, Some(_)) if self.attracts() => 0.0,
            (Some(start), Some(law)) if self.may_jump() => {
                let attracts = start.interface_energy().abs() + interface_energy.abs() > 0.0;
                // The energy balance gives the loss of a jump, whatever the curvature: a law may end in a step. Slip
                // and yield may leave as much, where the increments are long.
                let is_jump = if flows {
                    law.passed_instability && missing > 0.0
                } else {
                    missing > spread || law.passed_instability
                };
                match attracts && is_jump {
                    true => {
                        state.losses.jumps = missing;
                        spread
                    }
                    false if is_at_once && !flows => 0.0,
                    false => missing.abs(),
                }
            }
            _ if is_at_once && !flows => 0.0,
            _ => missing.abs(),
        };
    }

    /// Returns true if the loss by jumps follows from the balance of an increment, because energy is lost otherwise,
    /// too.
    pub(super) fn may_jump(&self) -> bool {
        self.loses() && self.attracts()
    }

    /// Returns true if energy is lost otherwise than by jumps.
    pub(super) fn loses(&self) -> bool {
        self.medium.is_some() || self.shear.is_some() || self.wear.is_some() || self.hardness.is_some()
    }

    /// Returns true if the surfaces attract each other: both faces of a plate may have a wall that is solved as a law.
    pub(super) fn attracts(&self) -> bool {
        matches!(&self.normal, Normal::Law(interface) if interface.attracts())
    }

    /// Returns the fraction of points with a pressure equal to the hardness, to the accuracy of the state. At a wall,
    /// the gaps in contact show it: a pressure counts if it is lower by at most ten times the pressure that would close
    /// the largest one, or by a thousandth of the hardness, whichever is less. Reloaded to its largest load, a contact
    /// then has the hardness at all points that it had flattened, within the residuals of both states.
    pub(super) fn saturated(&self, state: &NormalState, hardness: &Hardness) -> f64 {
        let [_, stiffest] = self.normal.stiffness_range();
        let pressure = state.pressure();
        let accuracy = match state {
            NormalState::Wall(Solution { pressure, gap, .. }) => {
                let touching = pressure.iter().zip(gap).filter(|(p, _)| **p > 0.0);
                let largest = touching.fold(0.0, |most: f64, (_, gap)| most.max(gap.abs()));
                OF_A_GAP * stiffest * self.share().each(largest).into_iter().fold(0.0, f64::max)
            }
            NormalState::Law(_) => f64::INFINITY,
        };
        let near = if let NormalState::Wall(_) = state { NEAR } else { NEAR_BESIDE_A_LAW };
        let has = |p: f64, hardness: f64| p >= hardness - accuracy.min(near * hardness);
        let count = match hardness {
            Hardness::Uniform(hardness) => pressure.iter().filter(|p| has(**p, *hardness)).count(),
            Hardness::Field(field) => pressure.iter().zip(field).filter(|(p, hardness)| has(**p, **hardness)).count(),
        };
        self.share().each(count).into_iter().sum::<usize>() as f64 / self.all_points()
    }
}

impl QuasistaticState {
    /// Returns the mean pressure and shear tractions, and the approach and lateral displacements that they work on.
    pub(super) fn forces_and_places(&self) -> ([f64; 3], [f64; 3]) {
        let ([shear_x, shear_y], [x, y]) = (self.mean_shear, self.lateral);
        ([self.mean_pressure(), shear_x, shear_y], [self.approach(), x, y])
    }

    /// Returns the mean depth worn off so far over the whole surface, and the largest depth, length.
    pub fn wear_volume_and_depth(&self) -> Option<(f64, f64)> {
        let depth = self.wear_depth()?;
        let deepest = depth.iter().fold(0.0, |most: f64, w| most.max(*w));
        let deepest = self.share().each(deepest).into_iter().fold(0.0, f64::max);
        Some((self.wear_volume(), deepest))
    }

    /// Returns the mean depth worn off so far over the whole surface, length; 0 if the surfaces do not wear.
    pub(crate) fn wear_volume(&self) -> f64 {
        self.wear_depth().map_or(0.0, |depth| self.mean_of(depth))
    }

    /// Returns the mean [plastic depth](Self::plastic_depth) over the whole surface, length.
    pub fn plastic_volume(&self) -> Option<f64> {
        match (&self.pressed_in, &self.normal) {
            (None, NormalState::Wall(solution)) => solution.plastic.as_ref().map(|plastic| plastic.volume),
            _ => self.plastic_depth().map(|depth| self.mean_of(depth)),
        }
    }

    /// Returns the points of this process.
    pub(super) fn share(&self) -> &Share {
        match &self.normal {
            NormalState::Wall(solution) => solution.share(),
            NormalState::Law(state) => state.surface.share(),
        }
    }

    /// Returns the mean of a field over all processes.
    fn mean_of(&self, field: &Array2<f64>) -> f64 {
        let points = if self.share().is_whole() { field.len() } else { self.share().total() };
        total(self.share(), &contiguous(field)) / points as f64
    }
}
