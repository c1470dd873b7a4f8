use gfmd_relax::{Variables, Visit};
use gfmd_response::Transforms;
use gfmd_vector::{add, dot, for_each, reduce};

use super::reaction::Reaction;
use super::trust_region::{Model, TrustRegion};
use super::wall::Wall;
use crate::frame::Frame;
use crate::numbers::{higher, higher_each, mean_where};
use crate::{Interface, State};

/// The largest number of halvings of a step.
const HALVINGS: u32 = 14;
/// The least decrease of the energy over that predicted by the slope (Armijo).
const SHARE: f64 = 1e-4;
/// The rounding error of an energy over the magnitude of its terms.
pub(super) const ROUNDING: f64 = 1e-14;

/// A search for a minimum of the energy ½⟨w, K w⟩ + Σ Φ(Δ(w)) − push Σ w_z, step by step.
pub(crate) struct Descent<'a> {
    pub(super) interface: &'a Interface,
    pub(super) frame: &'a Frame<'a>,
    wall: Wall,
    pub(super) curvature: Curvature<'a>,
    /// The present position.
    here: Placed,
    /// The position after the step that is tried.
    trial: Placed,
    /// T − K w + push: the force on a free point.
    pub(super) force: Vec<f64>,
    pub(super) region: TrustRegion,
    /// Lowest curvature that the last search for a direction met, relative to the preconditioner.
    pub(super) lowest: f64,
    /// True if any search met a negative curvature.
    pub(super) met_negative: bool,
}

/// A displacement w and its elastic traction K w.
struct Placed {
    w: Vec<f64>,
    elastic: Vec<f64>,
}

/// The change of the energy from here to the trial.
pub(super) struct Change {
    pub(super) energy: f64,
    /// The decrease that the slope predicts.
    promised: f64,
    /// Magnitude of the terms that make up `energy`.
    pub(super) size: f64,
}

impl Change {
    /// Returns true if the energy falls enough.
    fn falls(&self) -> bool {
        self.promised > 0.0 && self.energy.is_finite() && self.energy <= -SHARE * self.promised + ROUNDING * self.size
    }
}

impl<'a> Descent<'a> {
    pub(super) fn new(interface: &'a Interface, frame: &'a Frame<'a>, start: Option<&State>) -> Self {
        let size = frame.components() * frame.points();
        let zeros = || vec![0.0; size];
        let mut descent = Self {
            interface,
            frame,
            wall: Wall::new(frame, interface.law.has_wall(), interface.length_scale()),
            curvature: Curvature::new(interface, frame),
            here: Placed { w: zeros(), elastic: zeros() },
            trial: Placed { w: frame.starting_position(&interface.elastic, start), elastic: zeros() },
            force: zeros(),
            region: TrustRegion::new(size),
            lowest: f64::NAN,
            met_negative: false,
        };
        descent.place_trial();
        descent.accept();
        descent
    }

    pub(super) fn into_position_and_pairs(self) -> (Vec<f64>, f64) {
        (self.here.w, self.curvature.transforms.pairs())
    }

    /// Projects the trial on the allowed displacements and computes its elastic traction.
    fn place_trial(&mut self) {
        let Self { trial, wall, frame, curvature, .. } = self;
        wall.project_keeping_mean(&mut trial.w);
        curvature.transforms.stiffness(&trial.w, &frame.uniform_stiffness, &mut trial.elastic);
    }

    /// Moves to the trial.
    pub(super) fn accept(&mut self) {
        std::mem::swap(&mut self.here, &mut self.trial);
        self.balance();
    }

    /// Computes the tractions of the law and the forces at the present position.
    pub(super) fn balance(&mut self) {
        let Self { interface, frame, here, curvature, force, .. } = self;
        let reaction = &mut curvature.reaction;
        reaction.update(interface.law.as_ref(), frame, &here.w);
        let points = frame.points();
        for (c, force) in force.chunks_exact_mut(points).enumerate() {
            let (traction, elastic) = (reaction.traction(c), &here.elastic[c * points..][..points]);
            let push = frame.push_on(c);
            let net = |start: usize, [force]: [&mut [f64]; 1]| {
                for ((f, t), k) in force.iter_mut().zip(&traction[start..]).zip(&elastic[start..]) {
                    *f = t - k + push;
                }
            };
            for_each([force], &net);
        }
    }

    /// Finds the points that the wall holds, subtracts the mean force of components whose mean is held, and returns the
    /// residual.
    pub(super) fn release(&mut self) -> f64 {
        let Self { interface, frame, wall, curvature: Curvature { reaction, weight, .. }, here, force, .. } = self;
        let points = frame.points();
        let [softest, stiffest] = interface.elastic.stiffness_range();
        let reference = (softest * stiffest).sqrt();
        let (mut unbalanced, mut largest) = (0.0_f64, softest * interface.surface.rms_height());
        for c in 0..frame.components() {
            let range = c * points..(c + 1) * points;
            let (force, w) = (&mut force[range.clone()], &here.w[range.clone()]);
            let (traction, curvature) = (reaction.traction(c), reaction.diagonal(c));
            let bound = wall.bound(c);
            let touches = |i: usize| bound.is_some_and(|bound| w[i] >= bound[i]);
            let multiplier = if frame.held[c] { mean_where(force, |i| !touches(i)) } else { 0.0 };
            let weigh = |start: usize, [force, weight]: [&mut [f64]; 2]| {
                let mut worst = [0.0_f64; 2];
                for (k, (f, weight)) in force.iter_mut().zip(weight).enumerate() {
                    let i = start + k;
                    *f -= multiplier;
                    let held = touches(i) && *f > 0.0;
                    *weight = if held { 0.0 } else { (1.0 + curvature[i].max(0.0) / reference).sqrt().recip() };
                    let free = if held { 0.0 } else { f.abs() };
                    worst = higher_each(worst, [free, (traction[i] - *f).abs()]);
                }
                worst
            };
            let [free, stress] = gfmd_vector::pass([force, &mut weight[range]], &weigh, &higher_each);
            unbalanced = higher(unbalanced, free);
            largest = higher(largest, stress);
        }
        unbalanced / largest.max(f64::MIN_POSITIVE)
    }

    /// Returns true if the surface is pulled and no point attracts it any more.
    pub(super) fn is_apart(&self) -> bool {
        let Self { frame, curvature: Curvature { reaction, weight, .. }, .. } = self;
        let (traction, weight) = (reaction.traction(frame.z()), &weight[frame.z() * frame.points()..]);
        let apart = |i: usize| weight[i] > 0.0 && traction[i].abs() < 1e-3 * frame.push.abs();
        frame.push < 0.0 && reduce(frame.points(), &|mut range| range.all(apart), &|a, b| a && b)
    }

    /// Finds the direction of the next step, to the accuracy `accuracy` relative to the force.
    pub(super) fn seek(&mut self, accuracy: f64) {
        self.region.residual.copy_from_slice(&self.force);
        let lowest = self.region.step(&mut self.curvature, accuracy);
        self.note(lowest);
    }

    /// Records the lowest curvature of a search.
    pub(super) fn note(&mut self, lowest: f64) {
        self.lowest = lowest;
        self.met_negative |= lowest <= 0.0;
    }

    /// Moves along the direction, projected on the wall, and halves the step until the energy falls. Returns false if it does
    /// not fall.
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

    /// Moves along the negative gradient, where a short enough step lowers the energy, with or without a wall.
    pub(super) fn slide_downhill(&mut self) -> bool {
        self.region.direction.copy_from_slice(&self.force);
        self.curvature.project(&mut self.region.direction);
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

    /// Puts the trial at `share` of the direction.
    pub(super) fn try_step(&mut self, share: f64) -> Change {
        let along = |start: usize, [trial]: [&mut [f64]; 1]| {
            let from = self.here.w[start..].iter().zip(&self.region.direction[start..]);
            trial.iter_mut().zip(from).for_each(|(trial, (w, d))| *trial = w + share * d);
        };
        for_each([&mut self.trial.w[..]], &along);
        self.place_trial();
        let Self { interface, frame, here, trial, force, .. } = self;
        let points = frame.points();
        let [change, promised, size] = reduce(
            here.w.len(),
            &|range| {
                range.fold([0.0; 3], |sums, k| {
                    let step = trial.w[k] - here.w[k];
                    let work = step * (0.5 * (here.elastic[k] + trial.elastic[k]) - frame.push_on(k / points));
                    add(sums, [work, step * force[k], work.abs()])
                })
            },
            &add,
        );
        let [law, law_size] = reduce(
            points,
            &|range| {
                range.fold([0.0; 2], |sums, i| {
                    let before = interface.energy(frame.separation(&here.w, i));
                    let after = interface.energy(frame.separation(&trial.w, i));
                    add(sums, [after - before, before.abs()])
                })
            },
            &add,
        );
        Change { energy: change + law, promised, size: size + law_size }
    }

    /// The slope of the energy along the direction, negative downhill.
    pub(super) fn slope(&self) -> f64 {
        -dot(&self.region.direction, &self.force)
    }
}

/// All else follows from these, or is overwritten in an iteration.
impl Variables for Descent<'_> {
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let Self { here, region, lowest, met_negative, curvature, .. } = self;
        visitor.field(&mut here.w);
        visitor.field(&mut here.elastic);
        visitor.number(&mut region.radius);
        visitor.number(&mut region.length);
        visitor.number(lowest);
        visitor.flag(met_negative);
        visitor.count(curvature.transforms.counter());
    }
}

/// The matrix K + J on the points that the wall does not hold. The preconditioner is the compliance, with a smaller weight at
/// points where the law is stiff.
pub(super) struct Curvature<'a> {
    transforms: Transforms,
    frame: &'a Frame<'a>,
    reaction: Reaction,
    /// Weight of each point in the preconditioner; 0 for points that the wall holds.
    weight: Vec<f64>,
    /// Compliance of the uniform mode in the preconditioner.
    uniform_compliance: Vec<f64>,
}

impl<'a> Curvature<'a> {
    fn new(interface: &'a Interface, frame: &'a Frame<'a>) -> Self {
        let [softest, _] = interface.elastic.stiffness_range();
        let resists = |stiffness: &f64| if *stiffness > 0.0 { *stiffness } else { softest };
        Self {
            transforms: interface.elastic.transforms(),
            frame,
            reaction: Reaction::new(frame.components(), frame.points()),
            weight: vec![0.0; frame.components() * frame.points()],
            uniform_compliance: frame.uniform_stiffness.iter().map(|stiffness| 1.0 / resists(stiffness)).collect(),
        }
    }
}

impl Model for Curvature<'_> {
    fn apply(&mut self, vector: &[f64], out: &mut [f64]) {
        self.transforms.stiffness(vector, &self.frame.uniform_stiffness, out);
        self.reaction.add_product(vector, out);
    }

    fn precondition(&mut self, residual: &[f64], scratch: &mut [f64], out: &mut [f64]) {
        let Self { transforms, weight, uniform_compliance, .. } = self;
        let weigh = |start: usize, [weighted]: [&mut [f64]; 1]| {
            let factors = residual[start..].iter().zip(&weight[start..]);
            weighted.iter_mut().zip(factors).for_each(|(weighted, (r, w))| *weighted = r * w);
        };
        for_each([&mut *scratch], &weigh);
        transforms.compliance(scratch, uniform_compliance, out);
        for_each([&mut *out], &|start, [out]| {
            out.iter_mut().zip(&weight[start..]).for_each(|(out, w)| *out *= w);
        });
        self.project(out);
    }

    /// Sets the values to 0 on the points that the wall holds, and the mean over the free points to 0 in components whose
    /// mean is held.
    fn project(&self, vector: &mut [f64]) {
        let points = self.frame.points();
        for (c, (field, held)) in vector.chunks_exact_mut(points).zip(&self.frame.held).enumerate() {
            let weight = &self.weight[c * points..][..points];
            let mean = if *held { mean_where(field, |i| weight[i] > 0.0) } else { 0.0 };
            let keep = |start: usize, [field]: [&mut [f64]; 1]| {
                for (v, weight) in field.iter_mut().zip(&weight[start..]) {
                    *v = if *weight > 0.0 { *v - mean } else { 0.0 };
                }
            };
            for_each([field], &keep);
        }
    }
}
