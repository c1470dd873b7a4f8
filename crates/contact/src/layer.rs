//! Elastic surface layer below a rigid wall, as a landscape for the dynamics.

use std::borrow::Cow;
use std::sync::{Mutex, PoisonError};

use gfmd_relax::{AugmentedLagrangian, Bounds, Damping, Landscape, Proximal, Visit};
use gfmd_response::NormalTransforms;
use gfmd_vector::{add, for_each, pass};

use crate::{Contact, Load};

/// Length in the stiffness of a rough contact, in rms heights: the stiffness is about the mean pressure divided by this
/// length (Akarapu, Sharp and Robbins 2011; Campañá, Persson and Müser 2011 find 0.4 to 0.5). It only sets the damping
/// of the rigid motion, and thus the speed of convergence.
pub(crate) const STIFFNESS_LENGTH: f64 = 0.45;

/// Elastic surface layer below a rigid wall.
pub(crate) struct Layer<'a> {
    contact: &'a Contact,
    stiffness: Cow<'a, [f64]>,
    wall: Vec<f64>,
    /// Uniform force per area that pushes the body up.
    push: f64,
    force_scale: f64,
    /// Length scale of the residual.
    length_scale: f64,
    transforms: NormalTransforms,
    /// Number of transform pairs for certificates.
    certified: f64,
}

impl Landscape for Layer<'_> {
    fn len(&self) -> usize {
        self.wall.len()
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        self.transforms.convolve(&self.stiffness, u, force);
        pass(
            [force],
            &|start, [force]| {
                let mut energy = 0.0;
                for (f, u) in force.iter_mut().zip(&u[start..]) {
                    energy += u * (0.5 * *f - self.push);
                    *f = self.push - *f;
                }
                energy
            },
            &|a, b| a + b,
        )
    }

    fn bounds(&self) -> Bounds<'_> {
        Bounds::Upper(&self.wall)
    }

    fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
        self.bounds().natural_residual(u, force, self.force_scale, self.length_scale)
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.count(self.transforms.counter());
        visitor.number(&mut self.certified);
    }
}

impl<'a> Layer<'a> {
    pub(crate) fn new(contact: &'a Contact, load: Load, length_scale: f64) -> Self {
        let Contact { response, scaled: surface, .. } = contact;
        let [softest, _] = response.stiffness_range();
        let (stiffness, wall, push, force_scale) = match load {
            Load::MeanPressure(mean) => (Cow::from(response.stiffness()), surface.clearance(), mean, mean),
            Load::Approach(approach) => {
                let mut stiffness = response.stiffness().to_vec();
                stiffness[0] = 1.0 / response.uniform_compliance();
                (Cow::from(stiffness), surface.clearance().after(approach), 0.0, softest * length_scale)
            }
        };
        let transforms = NormalTransforms::of(response);
        Self { contact, stiffness, wall: wall.to_vec(), push, force_scale, length_scale, transforms, certified: 0.0 }
    }

    /// Returns the stiffness against a uniform displacement: of the contact, or of the slab.
    fn rigid(&self) -> f64 {
        if self.push > 0.0 {
            self.push / (STIFFNESS_LENGTH * self.contact.scaled.rms_height())
        } else {
            self.stiffness[0]
        }
    }

    /// Returns the stiffness of the softest and of the stiffest mode.
    pub(crate) fn band(&self) -> [f64; 2] {
        let [softest, stiffest] = self.contact.response.stiffness_range();
        let rigid = self.rigid();
        [softest.min(rigid), stiffest.max(rigid)]
    }

    /// Returns the function d ← B d on a motion, with every mode critically damped at the time step `dt`. A call takes
    /// one transform pair.
    pub(crate) fn critically_damped(&self, dt: f64) -> impl Fn(&mut [f64]) + use<> {
        let mut retained: Vec<f64> = self.stiffness.iter().map(|k| Damping::critical(*k, dt).beta).collect();
        retained[0] = Damping::critical(self.rigid(), dt).beta;
        let scratch = Mutex::new((NormalTransforms::of(&self.contact.response), vec![0.0; self.len()]));
        move |motion| {
            let (transforms, before) = &mut *scratch.lock().unwrap_or_else(PoisonError::into_inner);
            before.copy_from_slice(motion);
            transforms.convolve(&retained, before, motion);
        }
    }

    /// Returns the number of transform pairs so far.
    pub(crate) fn pairs(&self) -> f64 {
        self.certified + self.transforms.pairs()
    }

    /// Counts the transform pairs of a certificate.
    pub(crate) fn count_certificate(&mut self, pairs: f64) {
        self.certified += pairs;
    }

    /// Computes the displacement of the surface under `pressure`.
    pub(crate) fn displacement(&mut self, pressure: &[f64]) -> Vec<f64> {
        let mut u = vec![0.0; pressure.len()];
        let Contact { response, scaled: surface, .. } = self.contact;
        self.transforms.convolve(response.compliance(), pressure, &mut u);
        let clearance = surface.clearance();
        let sums = gfmd_vector::reduce(
            u.len(),
            &|range| {
                range.fold([0.0; 3], |sums, i| {
                    let touching = f64::from(pressure[i] > 0.0);
                    add(sums, [pressure[i], touching, touching * (clearance.at(i) + u[i])])
                })
            },
            &add,
        );
        // Under a prescribed load the body moves instead of the rigid surface.
        let rise =
            if self.push > 0.0 { sums[2] / sums[1] } else { -response.uniform_compliance() * sums[0] / u.len() as f64 };
        u.iter_mut().for_each(|u| *u = rise - *u);
        u
    }

    /// Scales the pressure so that the wall carries the prescribed load.
    fn carry(&self, mut pressure: Vec<f64>) -> Vec<f64> {
        let sum = gfmd_vector::total(&pressure);
        if self.push > 0.0 && sum > 0.0 {
            let factor = self.push * pressure.len() as f64 / sum;
            pressure.iter_mut().for_each(|p| *p *= factor);
        }
        pressure
    }
}

/// Layer pressed against the wall, which acts as a bound or by a force.
pub(crate) trait Pressed<'a>: Landscape {
    fn layer(&mut self) -> &mut Layer<'a>;

    /// Returns the start coordinates for the displacement `u` and the `pressure`.
    fn begin(&self, u: Vec<f64>, pressure: Option<&[f64]>) -> Vec<f64>;

    /// Returns true if the coordinates are not the displacement.
    fn is_shifted(&self) -> bool;

    /// Returns the pressure on the wall; remaining forces on free points are ignored.
    fn pressure(&self, u: &[f64], force: &[f64]) -> Vec<f64>;
}

impl<'a> Pressed<'a> for Layer<'a> {
    fn layer(&mut self) -> &mut Layer<'a> {
        self
    }

    fn begin(&self, u: Vec<f64>, _: Option<&[f64]>) -> Vec<f64> {
        u
    }

    fn is_shifted(&self) -> bool {
        false
    }

    fn pressure(&self, u: &[f64], force: &[f64]) -> Vec<f64> {
        let touching = |i: usize| u[i] >= self.wall[i];
        self.carry((force.iter().enumerate()).map(|(i, f)| if touching(i) { f.max(0.0) } else { 0.0 }).collect())
    }
}

/// Layer with springs of stiffness ϱ at every point. ϱ is the geometric mean of the softest and the stiffest mode, so
/// that both converge equally fast: (k + ϱ)/k of the one equals (k + ϱ)/ϱ of the other.
pub(crate) struct Sprung<'a> {
    layer: Layer<'a>,
    penalty: f64,
    /// 1/(k + ϱ).
    mobility: Vec<f64>,
    /// b + ϱ anchor.
    pull: Vec<f64>,
}

impl<'a> Sprung<'a> {
    pub(crate) fn new(layer: Layer<'a>) -> Self {
        let [softest, stiffest] = layer.contact.response.stiffness_range();
        let penalty = (softest * stiffest).sqrt();
        let mobility = layer.stiffness.iter().map(|k| 1.0 / (k + penalty)).collect();
        let pull = vec![0.0; layer.len()];
        Self { layer, penalty, mobility, pull }
    }
}

impl Proximal for Sprung<'_> {
    fn len(&self) -> usize {
        self.layer.len()
    }

    fn bounds(&self) -> Bounds<'_> {
        self.layer.bounds()
    }

    fn penalty(&self) -> f64 {
        self.penalty
    }

    fn settle(&mut self, anchor: &[f64], u: &mut [f64]) {
        let Self { layer, penalty, mobility, pull } = self;
        let leaf = |start: usize, [pull]: [&mut [f64]; 1]| {
            pull.iter_mut().zip(&anchor[start..]).for_each(|(pull, anchor)| *pull = layer.push + *penalty * anchor);
        };
        for_each([&mut pull[..]], &leaf);
        layer.transforms.convolve(mobility, pull, u);
    }

    fn residual(&self, mismatch: &[f64]) -> f64 {
        let largest = |range: std::ops::Range<usize>| mismatch[range].iter().fold(0, |m, x| x.abs().to_bits().max(m));
        // Bit patterns of positive numbers have the order of the numbers, with NaN last.
        f64::from_bits(gfmd_vector::reduce(mismatch.len(), &largest, &u64::max)) / self.layer.length_scale
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        self.layer.visit(visitor);
    }
}

impl<'a> Pressed<'a> for AugmentedLagrangian<Sprung<'a>> {
    fn layer(&mut self) -> &mut Layer<'a> {
        &mut self.problem_mut().layer
    }

    /// Returns the displacement plus λ/ϱ, with the reaction λ.
    fn begin(&self, mut u: Vec<f64>, pressure: Option<&[f64]>) -> Vec<f64> {
        let Sprung { layer, penalty, .. } = self.problem();
        match pressure {
            Some(pressure) => u.iter_mut().zip(pressure).for_each(|(u, p)| *u += p / penalty),
            None => u.iter_mut().for_each(|u| *u += layer.push / penalty),
        }
        u
    }

    fn is_shifted(&self) -> bool {
        true
    }

    fn pressure(&self, v: &[f64], _: &[f64]) -> Vec<f64> {
        self.problem().layer.carry(self.reaction(v))
    }
}
