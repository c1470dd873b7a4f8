//! Dependence of an increment on its division. Within an increment the surfaces stick, or slip against the shear at its
//! end. This is exact where the limits of the shear and its direction are constant. Where they change, above all at
//! points that come into contact, the error is of first order in the length of the increment.

use gfmd_law::Limit;
use ndarray::Axis;

use super::{FrictionState, FrictionalContact};

/// Shear relative to its limits that counts as zero: rounding errors and errors within the solver tolerance.
const NO_SHEAR: f64 = 1e-6;
/// Relative distance to the limit within which a point slips.
const AT_LIMIT: f64 = 1e-9;

/// Sums, over the points, of the shear and its limits at both ends of an increment.
#[derive(Default)]
struct Changes {
    /// Larger of the two limits.
    largest: f64,
    /// Magnitudes of the shear at both ends.
    sheared: f64,
    /// Changes of the limit and of the direction of a shear at its limit.
    changed: f64,
}

impl FrictionalContact {
    /// Returns true if the limits or directions of the shear change so much in an increment from `start`, or from the
    /// undeformed surface, to `end` that division may change the shear by more than `tolerance` (see
    /// [`distance`](Self::distance)).
    pub(crate) fn depends_on_division(
        &self,
        start: Option<&FrictionState>,
        end: &FrictionState,
        tolerance: f64,
    ) -> bool {
        let Changes { largest, sheared, changed } = self.changes(start, end);
        sheared > NO_SHEAR * largest && changed > tolerance.sqrt() * largest
    }

    /// Returns the relative energy of the difference of two states under one drive, both reached from `start` or from
    /// the undeformed surface. The reference is the energy of the path-dependent shear: the elastic energy of `b` times
    /// the squared ratio of its mean limit to its mean pressure (about the energy of a shear at its limit everywhere)
    /// times the fraction of the limits that changes between `start` and `b`. With this measure, the error energies of
    /// many short steps add up to the error energy of a long one.
    pub(crate) fn distance(&self, start: Option<&FrictionState>, a: &FrictionState, b: &FrictionState) -> f64 {
        let points = b.gap.len() as f64;
        let apart = |(((t, u), s), v): (((&f64, &f64), &f64), &f64)| (t - s) * (u - v);
        let of_a = a.traction.iter().zip(&a.displacement);
        let energy: f64 = 0.5 * of_a.zip(&b.traction).zip(&b.displacement).map(apart).sum::<f64>() / points;
        let limits = (0..b.gap.len()).map(|i| self.point(b, i).0).sum::<f64>() / points;
        let Changes { largest, changed, .. } = self.changes(start, b);
        let scale = (limits / b.mean_pressure).powi(2) * changed / largest * b.elastic_energy;
        if scale > 0.0 { energy.abs() / scale } else { 0.0 }
    }

    /// Computes the changes in an increment from `start`, or from the undeformed surface, to `end`.
    fn changes(&self, start: Option<&FrictionState>, end: &FrictionState) -> Changes {
        let at_start = |i: usize| start.map_or((0.0, [0.0; 2]), |start| self.point(start, i));
        let mut changes = Changes::default();
        for i in 0..end.gap.len() {
            let ((before, from), (after, to)) = (at_start(i), self.point(end, i));
            let magnitudes = [from[0].hypot(from[1]), to[0].hypot(to[1])];
            changes.largest += before.max(after);
            changes.sheared += magnitudes[0] + magnitudes[1];
            changes.changed += (after - before).abs();
            let slips = |limit: f64, shear: f64| limit > 0.0 && shear >= limit * (1.0 - AT_LIMIT);
            if slips(before, magnitudes[0]) && slips(after, magnitudes[1]) {
                // A reversal of slip passes through stick and is exact.
                changes.changed += (from[0] * to[1] - from[1] * to[0]).abs() / magnitudes[0].max(magnitudes[1]);
            }
        }
        changes
    }

    /// Returns the shear limit and the shear at a point of a state.
    fn point(&self, state: &FrictionState, i: usize) -> (f64, [f64; 2]) {
        let [nx, ny] = self.response.grid().points();
        let at = [i / ny, i % ny];
        debug_assert!(at[0] < nx);
        let z = state.traction.len_of(Axis(0)) - 1;
        let pressure = -state.traction[[z, at[0], at[1]]];
        let limit = match self.limit {
            Limit::Coulomb(coefficient) => Limit::Coulomb(coefficient),
            Limit::Tresca(strength) => Limit::Tresca(strength * self.units.stress()),
        };
        let shear = std::array::from_fn(|c| if c < z { state.traction[[c, at[0], at[1]]] } else { 0.0 });
        (if pressure > 0.0 { limit.at(pressure) } else { 0.0 }, shear)
    }
}
