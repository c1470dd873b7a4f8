//! Linear problem of small changes of an equilibrium state, (K + J) v + μ = b on the points not held by the wall, in
//! u_z alone or in all components.

use gfmd_vector::for_each;

use super::all_components::AllComponents;
use super::reaction::Reaction;
use super::trust_region::{Model, TrustRegion};
use super::weight_of;
use crate::Interface;
use crate::frame::Frame;
use crate::numbers::{dot, total};

/// Best accuracy of one search; the next one starts with the residual from fresh transforms.
const ACCURACY: f64 = 1e-9;

/// Accuracy of one search relative to the tolerance.
const OF_TOLERANCE: f64 = 0.3;

/// Largest accuracy of one search for an energy, so that it finds the lowest curvature.
const OF_FIRST: f64 = 0.1;

/// Maximum number of searches, of up to 200 iterations each.
const SEARCHES: u64 = 12;

/// Solution of the linear problem.
pub(crate) struct Adjoint {
    /// v, 0 at the points held by the wall.
    pub(crate) values: Vec<f64>,
    /// μ; 0 if the mean is not held.
    pub(crate) level: f64,
    /// Residual divided by the first residual.
    pub(crate) error: f64,
    /// Lowest curvature found by a search, relative to the preconditioner; at most 0 if the problem has no solution.
    pub(crate) lowest: f64,
    /// Number of searches and number of transform pairs.
    pub(crate) effort: (u64, f64),
}

/// Least energy of a displacement.
pub(crate) struct Energy {
    /// Twice the energy.
    pub(crate) value: f64,
    /// Estimated excess of the energy over the least one, relative.
    pub(crate) error: f64,
    /// Lowest curvature found, as of an [`Adjoint`].
    pub(crate) lowest: f64,
    /// Number of searches and number of transform pairs.
    pub(crate) effort: (u64, f64),
}

/// Bond of a point to the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Bond {
    /// The law alone acts.
    Free,
    /// The wall holds the point.
    Held,
    /// A spring of this compliance holds the point.
    Spring(f64),
    /// The point keeps its pressure, at the hardness.
    Pressed,
}

/// Lateral motion of the surfaces where all components move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Sides {
    /// The law alone holds them, by its shear.
    Law,
    /// They stick to each other at the points held or pressed by the wall, and the law has no shear.
    Stick,
}

/// Linear problem at one position. Fields are component by component, z last.
pub(crate) struct Linear<'a> {
    model: AllComponents<'a>,
    frame: &'a Frame<'a>,
    reaction: Reaction,
    /// 1 at the points not held, 0 elsewhere.
    free: Vec<f64>,
}

impl<'a> Linear<'a> {
    /// Creates the problem at `position`, with the `bond` of each point to the wall.
    pub(crate) fn at(
        interface: &Interface,
        frame: &'a Frame<'a>,
        position: &[f64],
        sides: Sides,
        bond: impl Fn(usize) -> Bond,
    ) -> Self {
        let (points, components, z) = (frame.points(), frame.components(), frame.z());
        let [softest, stiffest] = interface.elastic.stiffness_range();
        let mut reaction = Reaction::new(components, points);
        match sides {
            Sides::Law => reaction.update(interface.law.as_ref(), frame, position, &mut vec![0.0; points]),
            Sides::Stick => reaction.set_normal_slope(|i| {
                let (normal, _) = frame.separation(position, i);
                interface.law.opening(normal).slope
            }),
        }
        for (i, slope) in reaction.normal_slope_mut().iter_mut().enumerate() {
            match bond(i) {
                Bond::Pressed => *slope = 0.0,
                Bond::Spring(compliance) => *slope = compliance.recip(),
                Bond::Free | Bond::Held => {}
            }
        }
        let mut model =
            AllComponents::new(interface.elastic.transforms(), frame, super::uniform_compliance(interface, frame));
        let reference = (softest * stiffest).sqrt();
        for (c, weights) in model.weight().chunks_exact_mut(points).enumerate() {
            for (i, (weight, slope)) in weights.iter_mut().zip(reaction.diagonal(c)).enumerate() {
                let is_held =
                    if c == z { bond(i) == Bond::Held } else { sides == Sides::Stick && bond(i) != Bond::Free };
                *weight = if is_held { 0.0 } else { weight_of(*slope, [softest, stiffest]) };
            }
        }
        let free: Vec<f64> = model.weight().iter().map(|weight| f64::from(u8::from(*weight > 0.0))).collect();
        // Points at springs stiffer than the body hardly move.
        let share = |(i, free): (usize, &f64)| match bond(i) {
            Bond::Spring(compliance) => free / (1.0 + (compliance * reference).recip()),
            _ => *free,
        };
        if frame.share.any((0..points).any(|i| matches!(bond(i), Bond::Spring(_)))) {
            model.restore_mean_by(free.iter().enumerate().map(share).collect());
        }
        Self { model, frame, reaction, free }
    }

    /// Returns 1 at the points not held, 0 elsewhere.
    pub(crate) fn free(&self) -> &[f64] {
        &self.free
    }

    /// Returns the slope of the law along z at each point, dT/dg, stress/length.
    pub(crate) fn slope(&self) -> &[f64] {
        self.reaction.diagonal(self.frame.z())
    }

    /// Returns J times a field.
    fn of_law(&self, field: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; field.len()];
        self.reaction.add_product(field, &mut out);
        out
    }

    /// Returns K times a field.
    pub(crate) fn elastic(&mut self, field: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; field.len()];
        self.model.elastic(field, &mut out);
        out
    }

    /// Computes `out` = b − (K + J) v on the free points, in u_z alone; if the mean is held, subtracts the mean and
    /// returns it.
    fn residual(&mut self, source: &[f64], values: &[f64], out: &mut [f64]) -> f64 {
        self.model.elastic(values, out);
        self.reaction.add_product(values, out);
        let Self { model, free, .. } = &*self;
        let rest = |start: usize, [out]: [&mut [f64]; 1]| {
            let of = source[start..].iter().zip(&free[start..]);
            out.iter_mut().zip(of).for_each(|(out, (source, free))| *out = free * (source - *out));
        };
        for_each([&mut *out], &rest);
        if !self.frame.held[0] {
            return 0.0;
        }
        let level = model.mean_of(0, out);
        for_each([out], &|start, [out]| {
            out.iter_mut().zip(&free[start..]).for_each(|(out, free)| *out -= level * free);
        });
        level
    }

    /// Returns the least energy ½⟨v, K v⟩ + ½⟨v − e, J (v − e)⟩, twice and as a sum over the points, of a displacement
    /// v that is e at the points held and has no mean where the mean is held; `followed` is e. Its excess ⟨r, A⁻¹ r⟩
    /// with the residual r and the matrix A of the problem is estimated by the preconditioner and the lowest
    /// curvature that the search finds.
    pub(crate) fn least_energy(&mut self, followed: &[f64], tolerance: f64) -> Energy {
        let (points, frame) = (self.frame.points(), self.frame);
        let mut values = vec![0.0; followed.len()];
        for (c, held) in frame.held.iter().enumerate() {
            let of = c * points..(c + 1) * points;
            let count = total(frame.share, &self.free[of.clone()]);
            let start = if *held && count > 0.0 { -total(frame.share, &followed[of.clone()]) / count } else { 0.0 };
            values[of.clone()].iter_mut().zip(&self.free[of]).for_each(|(v, free)| *v = start * free);
        }
        let mut region = TrustRegion::new(values.len());
        let mut whole = vec![0.0; values.len()];
        let mut image = vec![0.0; values.len()];
        let (mut lowest, mut last, mut searches) = (f64::INFINITY, f64::INFINITY, 0);
        loop {
            for_each([&mut whole[..]], &|start, [whole]| {
                let both = values[start..].iter().zip(&followed[start..]);
                whole.iter_mut().zip(both).for_each(|(whole, (v, e))| *whole = v + e);
            });
            self.model.elastic(&whole, &mut image);
            let of_law = self.of_law(&values);
            let value = dot(frame.share, &whole, &image) + dot(frame.share, &values, &of_law);
            for_each([&mut region.vectors.residual[..]], &|start, [residual]| {
                let of = image[start..].iter().zip(&of_law[start..]).zip(&self.free[start..]);
                residual.iter_mut().zip(of).for_each(|(r, ((k, j), free))| *r = -free * (k + j));
            });
            let slope = region.slope(&mut self.model);
            // The curvature is known after the first search.
            let error = if slope == 0.0 { 0.0 } else { slope / lowest.min(1.0) / value.abs() };
            let is_exact = error <= tolerance && (searches > 0 || slope == 0.0);
            if is_exact || searches == SEARCHES || lowest.is_nan() || lowest <= 0.0 || slope >= 0.25 * last {
                return Energy { value, error, lowest, effort: (searches, self.model.pairs()) };
            }
            last = slope;
            let accuracy = (OF_TOLERANCE * tolerance * value.abs() / slope).sqrt().clamp(ACCURACY, OF_FIRST);
            lowest = lowest.min(region.probe(&mut self.model, &self.reaction, accuracy));
            searches += 1;
            let step = (region.unit, &region.vectors.direction);
            for_each([&mut values[..]], &|start, [values]| {
                values.iter_mut().zip(&step.1[start..]).for_each(|(v, d)| *v += step.0 * d);
            });
        }
    }

    /// Solves the problem in u_z alone to a residual of `tolerance` relative to the first one; if the mean is held,
    /// `sum` is the sum of v.
    pub(crate) fn solve(&mut self, source: &[f64], sum: f64, tolerance: f64) -> Adjoint {
        let accuracy = (OF_TOLERANCE * tolerance).max(ACCURACY);
        let share = self.model.share().unwrap_or(&self.free);
        let count = total(self.frame.share, share);
        let start = if self.frame.held[0] && count > 0.0 { sum / count } else { 0.0 };
        let mut values: Vec<f64> = share.iter().map(|share| start * share).collect();
        let mut region = TrustRegion::new(values.len());
        let mut residual = vec![0.0; values.len()];
        let mut level = self.residual(source, &values, &mut residual);
        let first = dot(self.frame.share, &residual, &residual).sqrt();
        let (mut error, mut searches, mut lowest) = (if first > 0.0 { 1.0 } else { 0.0 }, 0, f64::INFINITY);
        while error > tolerance && searches < SEARCHES {
            region.vectors.residual.copy_from_slice(&residual);
            lowest = lowest.min(region.probe(&mut self.model, &self.reaction, accuracy));
            searches += 1;
            if lowest <= 0.0 || lowest.is_nan() {
                break;
            }
            let step = (region.unit, &region.vectors.direction);
            for_each([&mut values[..]], &|start, [values]| {
                values.iter_mut().zip(&step.1[start..]).for_each(|(v, d)| *v += step.0 * d);
            });
            level = self.residual(source, &values, &mut residual);
            let now = dot(self.frame.share, &residual, &residual).sqrt() / first;
            // Only rounding errors remain.
            let has_ended = now >= 0.5 * error;
            error = now;
            if has_ended {
                break;
            }
        }
        Adjoint { values, level, error, lowest, effort: (searches, self.model.pairs()) }
    }
}
