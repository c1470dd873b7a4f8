//! Shear of a step: the tractions in the plane that keep the surfaces from slipping, within their limits.

pub(super) mod adjoint;

use gfmd_contact::{Drive, Refusal};
use gfmd_medium::Affine;
use gfmd_relax::{Anderson, Budget, Descended, Ending, SpectralProjectedGradient, Watch};
use gfmd_vector::{Share, add};

use super::normal::NormalState;
use super::parts::LimitingPressure;
use super::response::{Response, Transforms};
use super::tangential::{Limits, TangentialProblem};
use super::{QuasistaticContact, QuasistaticState, Shear};
use crate::numbers::higher;

/// Relative distance to the limit within which a point slips. Beside a law, the repulsion that sets the limit has the
/// error of the tolerance.
pub(super) const AT_LIMIT: f64 = 1e-7;
/// Number of rounds that are mixed.
const DEPTH: usize = 5;

/// Shear of a step during its solution. Tractions are divided by the common stiffening of the step.
pub(super) struct ShearStep {
    shear: Shear,
    /// Points of this process.
    share: Share,
    factor: f64,
    transforms: Transforms,
    /// Stiffness of the longest and the shortest wave.
    pub(super) softest: f64,
    stiffest: f64,
    /// Lateral displacement of the elastic surface without slip.
    stuck: Vec<f64>,
    /// Residual indentation of the body along the lateral components; empty for an elastic body.
    base: Vec<f64>,
    /// Limits of the shear at the start, not divided.
    limits_before: Vec<f64>,
    /// Shear traction, with a normal component of zero.
    traction: Vec<f64>,
    /// Displacement caused by the shear.
    displacement: Vec<f64>,
    /// Displacement along z caused by the shear, as the next normal contact assumes it.
    lift: Vec<f64>,
    /// Length of the slip of each point, as the next normal contact assumes it; empty unless the surfaces wear by slip.
    pub(super) slipped: Vec<f64>,
    mixing: Anderson,
}

/// Effect of the shear on the normal contact.
#[derive(Clone, Copy)]
pub(super) enum Effect {
    /// Effect that the next normal contact assumes, a mixture of those in earlier rounds.
    Assumed,
    /// Effect of the present shear.
    Present,
}

/// Fields and numbers of the shear that a step has reached. Tractions are divided by the common stiffening of the step.
pub(super) struct Sheared {
    /// Lateral displacement, component by component.
    pub(super) displacement: Vec<f64>,
    pub(super) traction: Vec<f64>,
    pub(super) slip: Vec<f64>,
    /// Number of sticking points of all processes.
    pub(super) sticking: f64,
    /// Sum of the work lost at all points of all processes; not divided.
    pub(super) lost: f64,
    /// Residuals: distance of the shear from its law, and excess over its limit.
    pub(super) friction: f64,
    pub(super) excess: f64,
}

impl ShearStep {
    pub(super) fn new(
        contact: &QuasistaticContact,
        response: &Response,
        drive: Drive,
        start: Option<&QuasistaticState>,
        affine: &Affine,
    ) -> Result<Self, Refusal> {
        let (shear, factor) = (contact.shear.ok_or(Refusal::OtherKind)?, affine.factor());
        let points = contact.points();
        let lateral = (response.components().len() - 1) * points;
        let mut traction = vec![0.0; lateral + points];
        let mut stuck: Vec<f64> = (0..lateral).map(|k| drive.lateral[k / points]).collect();
        let mut limits_before = vec![0.0; points];
        if let Some(state) = start {
            let sheared = state.sheared.as_ref().ok_or(Refusal::OtherKind)?;
            traction.iter_mut().zip(&sheared.traction).for_each(|(shear, t)| *shear = t / factor);
            for (k, (stuck, u)) in stuck.iter_mut().zip(&sheared.displacement).enumerate() {
                *stuck += u - state.lateral[k / points];
            }
            limits_before = limits_of(&shear, 1.0, &state.normal);
        }
        let base = match contact.medium {
            Some(_) => affine.residual_indentation[..lateral].to_vec(),
            None => Vec::new(),
        };
        let mut transforms = response.transforms();
        let mut displacement = vec![0.0; traction.len()];
        transforms.compliance(&traction, &mut displacement);
        let lift = displacement[lateral..].to_vec();
        let wears = contact.wear.is_some_and(|wear| wear.by_slip > 0.0);
        let slipped = vec![0.0; if wears { points } else { 0 }];
        let [softest, stiffest] = response.stiffness_range();
        Ok(Self {
            shear,
            share: contact.share().clone(),
            factor,
            transforms,
            softest,
            stiffest,
            stuck,
            base,
            limits_before,
            traction,
            displacement,
            lift,
            slipped,
            mixing: Anderson::new(DEPTH),
        })
    }

    /// Returns the number of transform pairs so far.
    pub(super) fn pairs(&self) -> f64 {
        self.transforms.pairs()
    }

    /// Returns the largest component of the shear traction, over all processes.
    pub(super) fn largest(&self) -> f64 {
        let own = self.traction.iter().fold(0.0, |most: f64, shear| most.max(shear.abs()));
        self.share.each(own).into_iter().fold(0.0, f64::max)
    }

    /// Returns the displacement along z caused by the shear.
    pub(super) fn lift(&self, effect: Effect) -> &[f64] {
        match effect {
            Effect::Assumed => &self.lift,
            Effect::Present => &self.displacement[self.stuck.len()..],
        }
    }

    /// Computes the length of the slip of each point with the present shear and the pressure of `state`; empty unless
    /// the surfaces wear by slip.
    pub(super) fn slipped_by(&mut self, state: &NormalState) -> Vec<f64> {
        if self.slipped.is_empty() {
            return Vec::new();
        }
        let traction = Self::traction(&self.traction[..self.stuck.len()], state);
        let mut displacement = vec![0.0; traction.len()];
        self.transforms.compliance(&traction, &mut displacement);
        let limits = limits_of(&self.shear, self.factor, state);
        self.wearing_slip(&self.slip(&displacement), &limits).collect()
    }

    /// Returns the length of the slip at each point, 0 at points that stick: their slip is an error of the search, and
    /// the sum of its lengths over all increments of a path grows with their number.
    fn wearing_slip<'a>(&'a self, slip: &'a [f64], limits: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        let (points, shear) = (self.points(), &self.traction[..self.stuck.len()]);
        let sticks = |i: usize, shear: f64| shear < limits[i] * (1.0 - AT_LIMIT);
        let both = lengths(slip, points).zip(lengths(shear, points)).enumerate();
        both.map(move |(i, (slip, shear))| if sticks(i, shear) { 0.0 } else { slip })
    }

    /// Returns the number of points.
    fn points(&self) -> usize {
        self.lift.len()
    }

    /// Returns the lateral displacement by a traction at the whole surface less the displacement without slip.
    fn slip(&self, displacement: &[f64]) -> Vec<f64> {
        let mut slip: Vec<f64> = displacement.iter().zip(&self.stuck).map(|(u, stuck)| u - stuck).collect();
        slip.iter_mut().zip(&self.base).for_each(|(slip, base)| *slip -= base);
        slip
    }

    /// Returns the traction of the pressure of a state together with the lateral components `shear`.
    fn traction(shear: &[f64], state: &NormalState) -> Vec<f64> {
        shear.iter().copied().chain(state.pressure().iter().map(|p| -p)).collect()
    }

    /// Finds the shear for the pressure of `state`, and mixes its lift and slip with those of earlier rounds for the
    /// next normal contact. `length` is the unit of slip.
    pub(super) fn slide(
        &mut self,
        state: &NormalState,
        length: f64,
        budget: &Budget,
        watch: &mut dyn Watch,
    ) -> Descended {
        let (points, lateral) = (self.points(), self.stuck.len());
        let share = &self.share.clone();
        let limits = Limits::new(limits_of(&self.shear, self.factor, state), share, length);
        limits.project(&mut self.traction[..lateral]);
        let traction = Self::traction(&self.traction[..lateral], state);
        self.transforms.compliance(&traction, &mut self.displacement);
        let mut slip = self.slip(&self.displacement);
        let mut descended = Descended { steps: 0, ending: Ending::Converged };
        if limits.strongest > 0.0 {
            let Self { transforms, traction: shear, stiffest, .. } = self;
            let mut problem = TangentialProblem { transforms, limits: &limits };
            // The first step is a stiffness: the stiffness of the shortest wave.
            let method = SpectralProjectedGradient { first_step: *stiffest };
            descended = method.minimise(&mut problem, &mut shear[..lateral], &mut slip, budget, watch);
        }
        self.transforms.compliance(&self.traction, &mut self.displacement);
        let slipped = self.wearing_slip(&slip, &limits.values).take(self.slipped.len());
        let image: Vec<f64> = self.displacement[lateral..].iter().copied().chain(slipped).collect();
        let mut mixed: Vec<f64> = self.lift.iter().chain(&self.slipped).copied().collect();
        let product = |a: &[f64], b: &[f64]| {
            share.reduce_components(a.len() / points, &|range| range.map(|i| a[i] * b[i]).sum(), &|a, b| a + b)
        };
        self.mixing.advance_by(&mut mixed, &image, &product);
        self.lift.copy_from_slice(&mixed[..points]);
        // A mixture of lengths may be negative.
        self.slipped.iter_mut().zip(&mixed[points..]).for_each(|(slipped, mixed)| *slipped = mixed.max(0.0));
        descended
    }

    /// Computes fields and residuals of the present shear with the pressure of `state`, from fresh transforms. `length`
    /// is the unit of slip.
    pub(super) fn certify(&mut self, state: &NormalState, length: f64) -> Sheared {
        let (points, lateral) = (self.points(), self.stuck.len());
        let share = &self.share.clone();
        let limits = Limits::new(limits_of(&self.shear, self.factor, state), share, length);
        let traction = Self::traction(&self.traction[..lateral], state);
        let mut displacement = vec![0.0; traction.len()];
        self.transforms.compliance(&traction, &mut displacement);
        let slip = self.slip(&displacement);
        displacement.truncate(lateral);
        displacement.iter_mut().zip(&self.base).for_each(|(u, base)| *u -= base);
        let traction = traction[..lateral].to_vec();
        let magnitude = |i: usize| traction.chunks_exact(points).map(|t| t[i] * t[i]).sum::<f64>().sqrt();
        let before = &self.limits_before;
        let [sticking, lost] = share.reduce(
            &|range| {
                range.fold([0.0; 2], |sums, i| {
                    let limit = limits.values[i];
                    let sticks = limit > 0.0 && magnitude(i) < limit * (1.0 - AT_LIMIT);
                    // The shear is at its limit while a point slips, and the limit changes during the increment.
                    let limit = self.factor * limit;
                    let mean = 0.5 * (before[i] + limit) / limit;
                    let both = traction.chunks_exact(points).zip(slip.chunks_exact(points));
                    let work: f64 = both.map(|(t, s)| -t[i] * s[i]).sum();
                    let work = if limit > 0.0 { mean * self.factor * work } else { 0.0 };
                    add(sums, [f64::from(sticks), work])
                })
            },
            &add,
        );
        let beyond = |i: usize| magnitude(i) - limits.values[i];
        let excess = share.reduce(&|range| range.fold(0.0, |worst, i| higher(worst, beyond(i))), &higher);
        let friction = limits.mismatch(&traction, &slip);
        let excess = if limits.strongest > 0.0 { excess / limits.strongest } else { 0.0 };
        Sheared { displacement, traction, slip, sticking, lost, friction, excess }
    }
}

/// Returns the length of a lateral vector at each point.
fn lengths(vector: &[f64], points: usize) -> impl Iterator<Item = f64> {
    (0..points).map(move |i| vector.chunks_exact(points).map(|x| x[i] * x[i]).sum::<f64>().sqrt())
}

/// Returns the limit of the shear at each point, divided by `factor`, for a state with tractions divided by it.
pub(super) fn limits_of(shear: &Shear, factor: f64, state: &NormalState) -> Vec<f64> {
    let repulsion = state.repulsion();
    let limit = |pressure: f64| shear.limit.at(factor * pressure) / factor;
    match shear.pressure {
        LimitingPressure::Repulsion => repulsion.iter().map(|r| if *r > 0.0 { limit(*r) } else { 0.0 }).collect(),
        LimitingPressure::Net => {
            let of = |(r, p): (&f64, &f64)| if *r > 0.0 { limit(p.max(0.0)) } else { 0.0 };
            repulsion.iter().zip(&state.pressure()).map(of).collect()
        }
    }
}
