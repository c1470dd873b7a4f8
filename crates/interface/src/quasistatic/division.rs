//! Dependence of an increment on its division. Within an increment the surfaces stick, or slip against the shear at its
//! end. This is exact where the limits of the shear and its direction are constant. Where they change, above all at
//! points that come into contact, the error is of first order in the length of the increment.

use gfmd_contact::Fields as _;
use gfmd_vector::{add, contiguous};

use super::shear::{AT_LIMIT, limits_of};
use super::{QuasistaticContact, QuasistaticState, Shear};

/// Shear relative to its limits that counts as zero: rounding errors and errors within the solver tolerance.
const NO_SHEAR: f64 = 1e-6;

/// Sums, over the points, of the shear and its limits at both ends of an increment.
struct Changes {
    /// Larger of the two limits.
    largest: f64,
    /// Magnitudes of the shear at both ends.
    sheared: f64,
    /// Changes of the limit and of the direction of a shear at its limit.
    changed: f64,
}

/// Shear of a state and its limits, point by point.
struct Sheared<'a> {
    limits: Vec<f64>,
    traction: &'a [f64],
}

impl Sheared<'_> {
    fn point(&self, i: usize) -> (f64, [f64; 2]) {
        let points = self.limits.len();
        (self.limits[i], std::array::from_fn(|c| self.traction.get(c * points + i).copied().unwrap_or(0.0)))
    }
}

impl QuasistaticContact {
    /// Returns true if the limits or directions of the shear change so much in an increment from `start`, or from the
    /// undeformed surface, to `end` that division may change the shear by more than `tolerance` (see
    /// [`distance`](Self::distance)).
    pub(super) fn may_change(&self, start: Option<&QuasistaticState>, end: &QuasistaticState, tolerance: f64) -> bool {
        let Some(Changes { largest, sheared, changed }) = self.changes(start, end) else { return false };
        sheared > NO_SHEAR * largest && changed > tolerance.sqrt() * largest
    }

    /// Returns the relative energy of the difference of two states under one drive, both reached from `start` or from
    /// the undeformed surface. The reference is the energy of the path-dependent shear: the elastic energy of `b` times
    /// the squared ratio of its mean limit to its mean repulsion (about the energy of a shear at its limit everywhere)
    /// times the fraction of the limits that changes between `start` and `b`. With this measure, the error energies of
    /// many short steps add up to the error energy of a long one.
    pub(super) fn distance(&self, start: Option<&QuasistaticState>, a: &QuasistaticState, b: &QuasistaticState) -> f64 {
        let Some(((shear, of_a), of_b)) = self.shear.as_ref().zip(a.sheared.as_ref()).zip(b.sheared.as_ref()) else {
            return 0.0;
        };
        let (share, own, all) = (self.share(), self.points(), self.all_points());
        let sum = |of: &(dyn Fn(usize) -> f64 + Sync)| share.sum(&|range| range.map(of).sum());
        let components = of_a.traction.len() / own;
        let lateral: f64 = (0..components)
            .map(|c| {
                let at = |i: usize| c * own + i;
                sum(&|i| {
                    (of_a.traction[at(i)] - of_b.traction[at(i)])
                        * (of_a.displacement[at(i)] - of_b.displacement[at(i)])
                })
            })
            .sum();
        let (p, q) = (a.pressure(), b.pressure());
        let (p, q) = (contiguous(&p), contiguous(&q));
        let (u, v) = (a.displacement_z(), b.displacement_z());
        let (u, v) = (contiguous(&u), contiguous(&v));
        let energy = 0.5 * (lateral - sum(&|i| (p[i] - q[i]) * (u[i] - v[i]))) / all;
        let limits = self.limits(shear, b);
        let limits = sum(&|i| limits[i]) / all;
        let Some(Changes { largest, changed, .. }) = self.changes(start, b) else { return 0.0 };
        let repulsion = b.repulsion();
        let repulsion = contiguous(&repulsion);
        let repulsion = sum(&|i| repulsion[i]) / all;
        let scale = (limits / repulsion).powi(2) * changed / largest * b.elastic_energy();
        if scale > 0.0 { energy.abs() / scale } else { 0.0 }
    }

    /// Computes the changes in an increment from `start`, or from the undeformed surface, to `end`.
    fn changes(&self, start: Option<&QuasistaticState>, end: &QuasistaticState) -> Option<Changes> {
        let shear = self.shear.as_ref()?;
        let of = |state: &'_ QuasistaticState| state.sheared.as_ref().map(|_| self.limits(shear, state));
        let end_limits = of(end)?;
        let at_end = Sheared { limits: end_limits, traction: &end.sheared.as_ref()?.traction };
        let at_start = match start {
            Some(start) => Some(Sheared { limits: of(start)?, traction: &start.sheared.as_ref()?.traction }),
            None => None,
        };
        let of_point = |i: usize| {
            let (before, from) = at_start.as_ref().map_or((0.0, [0.0; 2]), |start| start.point(i));
            let (after, to) = at_end.point(i);
            let magnitudes = [from[0].hypot(from[1]), to[0].hypot(to[1])];
            let mut changed = (after - before).abs();
            let slips = |limit: f64, shear: f64| limit > 0.0 && shear >= limit * (1.0 - AT_LIMIT);
            if slips(before, magnitudes[0]) && slips(after, magnitudes[1]) {
                // A reversal of slip passes through stick and is exact.
                changed += (from[0] * to[1] - from[1] * to[0]).abs() / magnitudes[0].max(magnitudes[1]);
            }
            [before.max(after), magnitudes[0] + magnitudes[1], changed]
        };
        let sums = |range: std::ops::Range<usize>| range.fold([0.0; 3], |sums, i| add(sums, of_point(i)));
        let [largest, sheared, changed] = self.share().reduce(&sums, &add);
        Some(Changes { largest, sheared, changed })
    }

    /// Returns the limits of the shear in a state, in the units of the input.
    fn limits(&self, shear: &Shear, state: &QuasistaticState) -> Vec<f64> {
        let shear = Shear { limit: shear.limit.in_units(1.0 / self.units.stress()), ..*shear };
        limits_of(&shear, 1.0, &state.normal)
    }
}
