use gfmd_contact::Load;
use gfmd_relax::{Variables, Visit};
use gfmd_response::power_of_two;
use gfmd_vector::{add, for_each};

use super::pieces::Pieces;
use super::reaction::Reaction;
use super::trust_region::{Model, Number, TrustRegion, Vectors};
use super::wall::Wall;
use super::weight_of;
use crate::frame::Frame;
use crate::numbers::{higher, higher_each, mean_where, reduce, sum};
use crate::{Interface, State};

/// Maximum number of halvings of a step.
const HALVINGS: u32 = 14;
/// Smallest energy decrease relative to the prediction of the slope (Armijo).
const SHARE: f64 = 1e-4;
/// Rounding error of an energy relative to the magnitude of its terms.
pub(super) const ROUNDING_OF_ENERGY: f64 = 1e-14;
/// Energy rise, relative to the magnitude of its terms, that may be rounding error alone. Chosen value.
const HIDDEN: f64 = 100.0 * ROUNDING_OF_ENERGY;

/// Stepwise search for a minimum of the energy ½⟨w, K w⟩ + Σ Φ(Δ(w)) − push Σ w_z.
pub(super) struct Descent<'a, M: Model> {
    pub(super) interface: &'a Interface,
    pub(super) frame: &'a Frame<'a>,
    wall: Wall,
    /// Wall that gives way, in place of `wall`.
    pub(super) pieces: Option<Pieces>,
    pub(super) model: M,
    /// Current position.
    pub(super) here: Placed,
    /// Position after the trial step.
    pub(super) trial: Placed,
    /// T − K w + push: the force on a free point.
    pub(super) force: Vec<f64>,
    /// Mean force subtracted from each component by [`release`](Self::release), stress.
    pub(super) multipliers: Vec<f64>,
    pub(super) region: TrustRegion<M::Value>,
    /// Lowest curvature in the last search for a direction, relative to the preconditioner.
    pub(super) lowest: f64,
    /// True if any search, or the way to the start, met a negative curvature.
    pub(super) met_negative: bool,
}

/// A displacement w, its elastic traction K w, and the reaction of the law.
pub(super) struct Placed {
    pub(super) w: Vec<f64>,
    /// Insets at a wall that gives way, else empty.
    pub(super) inset: Vec<f64>,
    pub(super) elastic: Vec<f64>,
    pub(super) reaction: Reaction,
    /// Energy Φ of each point, per area.
    energy: Vec<f64>,
}

impl Placed {
    fn at(w: Vec<f64>, frame: &Frame) -> Self {
        let (components, points) = (frame.components(), frame.points());
        let reaction = Reaction::new(components, points);
        Self { elastic: vec![0.0; w.len()], w, inset: Vec::new(), reaction, energy: vec![0.0; points] }
    }

    /// Returns the step of value `k` from another position; between insets their difference, which has all digits.
    fn step_from(&self, from: &Self, k: usize) -> f64 {
        let (to, before) = (self.inset.get(k), from.inset.get(k));
        match to.zip(before) {
            Some((to, before)) if *to > 0.0 || *before > 0.0 => to - before,
            _ => self.w[k] - from.w[k],
        }
    }

    /// Computes the reaction of the law and of a wall that gives way.
    fn react(&mut self, interface: &Interface, frame: &Frame, pieces: Option<&Pieces>) {
        let Self { w, inset, reaction, energy, .. } = self;
        match pieces {
            None => reaction.update(interface.law.as_ref(), frame, w, energy),
            Some(pieces) => pieces.react(interface.law.as_ref(), frame, [w, inset], (reaction, energy)),
        }
    }
}

/// Energy change from the current position to the trial.
pub(super) struct Change {
    pub(super) energy: f64,
    /// Decrease predicted by the slope at the current position.
    promised: f64,
    /// Decrease predicted by the slope at the trial for one more step; negative beyond the minimum.
    ahead: f64,
    /// Magnitude of the terms in `energy`.
    pub(super) size: f64,
}

impl Change {
    /// Returns true if the energy falls enough. If rounding errors hide its change, the slopes at both ends decide (the
    /// approximate Wolfe condition, Hager and Zhang 2005).
    fn falls(&self) -> bool {
        let enough = -SHARE * self.promised;
        let is_hidden = self.energy <= HIDDEN * self.size;
        let falls = self.energy <= enough || (is_hidden && -0.5 * (self.promised + self.ahead) <= enough);
        self.promised > 0.0 && self.energy.is_finite() && falls
    }
}

impl<'a, M: Model> Descent<'a, M> {
    pub(super) fn new(
        interface: &'a Interface,
        frame: &'a Frame<'a>,
        model: M,
        (start, crossed): (Option<&State>, bool),
    ) -> Self {
        let size = frame.components() * frame.points();
        let mut pieces = interface.kinks(frame).map(|kinks| Pieces::new(kinks, interface.length_scale()));
        let mut here = Placed::at(vec![0.0; size], frame);
        let mut trial = Placed::at(frame.starting_position(&interface.elastic, start), frame);
        if let Some(pieces) = &mut pieces {
            here.inset = vec![0.0; size];
            trial.inset = pieces.start(frame, start, &mut trial.w);
        }
        let mut descent = Self {
            interface,
            frame,
            wall: Wall::new(frame, interface.law.has_wall() && pieces.is_none(), interface.length_scale()),
            pieces,
            model,
            here,
            trial,
            force: vec![0.0; size],
            multipliers: vec![0.0; frame.components()],
            region: TrustRegion::new(size),
            lowest: f64::NAN,
            met_negative: crossed,
        };
        descent.place_trial();
        descent.accept();
        descent
    }

    /// Returns position, insets and number of transform pairs.
    pub(super) fn into_position_and_pairs(self) -> (Vec<f64>, Vec<f64>, f64) {
        (self.here.w, self.here.inset, self.model.pairs())
    }

    /// Projects the trial on the allowed displacements and computes its traction and reaction. Returns false if a held
    /// mean cannot be restored.
    fn place_trial(&mut self) -> bool {
        let Self { interface, trial, wall, pieces, frame, model, .. } = self;
        let is_possible = match pieces {
            None => {
                wall.project_keeping_mean(&mut trial.w);
                true
            }
            Some(pieces) => !frame.held[0] || pieces.restore_mean(&mut trial.w, &mut trial.inset),
        };
        model.elastic(&trial.w, &mut trial.elastic);
        trial.react(interface, frame, pieces.as_ref());
        is_possible
    }

    /// Accepts the trial as the current position.
    pub(super) fn accept(&mut self) {
        std::mem::swap(&mut self.here, &mut self.trial);
        self.balance();
    }

    /// Computes reaction and forces after the displacement and its elastic traction were restored.
    pub(super) fn restored(&mut self) {
        if let Some(pieces) = &mut self.pieces {
            pieces.classify(&self.here.inset);
        }
        self.here.react(self.interface, self.frame, self.pieces.as_ref());
        self.balance();
    }

    /// Computes the forces at the current position.
    fn balance(&mut self) {
        let Self { frame, here: Placed { elastic, reaction, .. }, force, .. } = self;
        let points = frame.points();
        for (c, force) in force.chunks_exact_mut(points).enumerate() {
            let (traction, elastic) = (reaction.traction(c), &elastic[c * points..][..points]);
            let push = frame.push_on(c);
            let net = |start: usize, [force]: [&mut [f64]; 1]| {
                for ((f, t), k) in force.iter_mut().zip(&traction[start..]).zip(&elastic[start..]) {
                    *f = t - k + push;
                }
            };
            for_each([force], &net);
        }
    }

    /// Finds the points held by the wall, subtracts the mean force of components with a held mean, and returns the
    /// residual.
    pub(super) fn release(&mut self) -> f64 {
        let Self { interface, frame, wall, model, here: Placed { w, reaction, .. }, force, multipliers, .. } = self;
        let points = frame.points();
        let stiffness = interface.elastic.stiffness_range();
        // Soft points make longer steps, which may leave a branch early (measured: steps back in the approach). Under a
        // load, rounds with the attraction held come before.
        let is_near = matches!(frame.drive.load, Load::MeanPressure(_)) && interface.patch.is_none();
        let least = if is_near && frame.components() == 1 { f64::NEG_INFINITY } else { 0.0 };
        let (mut unbalanced, mut largest) = (0.0_f64, interface.stress_scale(frame.drive.load));
        for (c, subtracted) in multipliers.iter_mut().enumerate() {
            let range = c * points..(c + 1) * points;
            let (force, w) = (&mut force[range.clone()], &w[range.clone()]);
            let (traction, curvature) = (reaction.traction(c), reaction.diagonal(c));
            let bound = wall.bound(c);
            let touches = |i: usize| bound.is_some_and(|bound| w[i] >= bound[i]);
            let multiplier = if frame.held[c] { mean_where(frame.share, force, |i| !touches(i)) } else { 0.0 };
            *subtracted = multiplier;
            let weigh = |start: usize, (force, weight): (&mut [f64], &mut [M::Value])| {
                let mut worst = [0.0_f64; 2];
                for (k, (f, weight)) in force.iter_mut().zip(weight).enumerate() {
                    let i = start + k;
                    *f -= multiplier;
                    let held = touches(i) && *f > 0.0;
                    *weight = M::Value::of(if held { 0.0 } else { weight_of(curvature[i].max(least), stiffness) });
                    let free = if held { 0.0 } else { f.abs() };
                    worst = higher_each(worst, [free, (traction[i] - *f).abs()]);
                }
                worst
            };
            let [free, stress] = frame.share.pass((force, &mut model.weight()[range]), &weigh, &higher_each);
            unbalanced = higher(unbalanced, free);
            largest = higher(largest, stress);
        }
        unbalanced / largest.max(f64::MIN_POSITIVE)
    }

    /// Returns true if the surface is pulled and no point attracts it any more, or no point of one face of a plate.
    pub(super) fn is_apart(&mut self) -> bool {
        let Self { interface, frame, model, here: Placed { reaction, .. }, .. } = self;
        let (traction, weight) = (reaction.traction(frame.z()), &model.weight()[frame.z() * frame.points()..]);
        let apart = |i: usize| weight[i].into() > 0.0 && traction[i].abs() < 1e-3 * frame.push.abs();
        let all = |start: usize, count: usize| {
            reduce(&frame.share.face(), count, &|range| range.map(|i| start + i).all(apart), &|a, b| a && b)
        };
        let face = frame.points() / interface.elastic.faces();
        frame.push < 0.0 && (0..interface.elastic.faces()).any(|index| all(index * face, face))
    }

    /// Finds the direction of the next step, with the given `accuracy` relative to the force.
    pub(super) fn seek(&mut self, accuracy: f64) {
        let stress = self.hand_over_force();
        let lowest = self.region.step(&mut self.model, &self.here.reaction, stress, accuracy);
        self.note(lowest);
    }

    /// Writes the force into the residual of the region, divided by a unit of stress, and returns this unit: a power of
    /// two that keeps the numbers of the search of order 1.
    fn hand_over_force(&mut self) -> f64 {
        let force = &self.force;
        let largest = |range: std::ops::Range<usize>| force[range].iter().fold(0.0, |most: f64, f| most.max(f.abs()));
        let stress = power_of_two(reduce(self.frame.share, force.len(), &largest, &f64::max));
        let scaled = |start: usize, [residual]: [&mut [M::Value]; 1]| {
            residual.iter_mut().zip(&force[start..]).for_each(|(r, f)| *r = M::Value::of(f / stress));
        };
        for_each([&mut self.region.vectors.residual[..]], &scaled);
        stress
    }

    /// Records the lowest curvature of a search.
    pub(super) fn note(&mut self, lowest: f64) {
        self.lowest = lowest;
        self.met_negative |= lowest <= 0.0;
    }

    /// Moves along the direction, projected on the wall, and halves the step until the energy falls. Returns false if
    /// it does not fall.
    pub(super) fn advance(&mut self) -> bool {
        let mut share = 1.0;
        for _ in 0..HALVINGS {
            if self.try_step(share).falls() {
                let TrustRegion { radius, length, .. } = &mut self.region;
                *radius = if share == 1.0 { radius.max(2.0 * *length) } else { share * *length };
                self.accept();
                return true;
            }
            share *= 0.5;
        }
        self.region.radius = share * self.region.length;
        false
    }

    /// Moves along the negative gradient, where a sufficiently short step lowers the energy, with or without a wall.
    pub(super) fn slide_downhill(&mut self) -> bool {
        self.region.unit = self.hand_over_force();
        let Vectors { direction, residual, .. } = &mut self.region.vectors;
        std::mem::swap(direction, residual);
        self.model.project(direction);
        let [_, stiffest] = self.interface.elastic.stiffness_range();
        let mut share = 1.0 / stiffest;
        for _ in 0..2 * HALVINGS {
            if self.try_step(share).falls() {
                self.accept();
                return true;
            }
            share *= 0.25;
        }
        false
    }

    /// Moves the trial by `share` of the direction.
    pub(super) fn try_step(&mut self, share: f64) -> Change {
        let share = share * self.region.unit;
        let Self { here, trial, region, pieces, .. } = self;
        let direction = &region.vectors.direction[..];
        if let Some(pieces) = pieces {
            pieces.step([&here.w, &here.inset], share, direction, [&mut trial.w, &mut trial.inset]);
        } else {
            let along = |start: usize, [trial]: [&mut [f64]; 1]| {
                let from = here.w[start..].iter().zip(&direction[start..]);
                trial.iter_mut().zip(from).for_each(|(trial, (w, d))| *trial = w + share * (*d).into());
            };
            for_each([&mut trial.w[..]], &along);
        }
        if !self.place_trial() {
            return Change { energy: f64::NAN, promised: 0.0, ahead: 0.0, size: 0.0 };
        }
        // A held mean has rounding errors; their work is not part of the energy.
        let Self { frame, here, trial, force, multipliers, .. } = self;
        let points = frame.points();
        let traction = trial.reaction.tractions();
        let [change, promised, ahead, size] = reduce(
            frame.share,
            here.w.len(),
            &|range| {
                range.fold([0.0; 4], |sums, k| {
                    let step = trial.step_from(here, k);
                    let uniform = frame.push_on(k / points) - multipliers[k / points];
                    let work = step * (0.5 * (here.elastic[k] + trial.elastic[k]) - uniform);
                    let next = traction[k] - trial.elastic[k] + uniform;
                    add(sums, [work, step * force[k], step * next, work.abs()])
                })
            },
            &add,
        );
        let [law, law_size] = reduce(
            frame.share,
            points,
            &|range| {
                let both = here.energy[range.clone()].iter().zip(&trial.energy[range]);
                both.fold([0.0; 2], |sums, (before, after)| add(sums, [after - before, before.abs()]))
            },
            &add,
        );
        Change { energy: change + law, promised, ahead, size: size + law_size }
    }

    /// Returns the slope of the energy along the direction, negative downhill.
    pub(super) fn slope(&self) -> f64 {
        let (direction, force) = (&self.region.vectors.direction, &self.force);
        let along = |range: std::ops::Range<usize>| {
            direction[range.clone()].iter().zip(&force[range]).map(|(d, f)| (*d).into() * f).sum()
        };
        -self.region.unit * sum(self.frame.share, force.len(), &along)
    }
}

/// The other fields follow from these or are overwritten in each iteration.
impl<M: Model> Variables for Descent<'_, M> {
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let Self { here, region, lowest, met_negative, model, frame, .. } = self;
        visitor.rows(frame.share, &mut here.w);
        if !here.inset.is_empty() {
            visitor.rows(frame.share, &mut here.inset);
        }
        visitor.rows(frame.share, &mut here.elastic);
        visitor.number(&mut region.radius);
        visitor.number(&mut region.length);
        visitor.number(lowest);
        visitor.flag(met_negative);
        model.count(visitor);
    }
}
