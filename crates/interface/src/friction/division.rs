//! The dependence of an increment on its division. Within an increment the surfaces stick, or slip against the shear at
//! its end, which is exact where the limits of the shear and its direction stay. Where they change on the way, above
//! all at points that come into contact, it is an error of first order in the length of the increment.

use gfmd_law::Limit;
use ndarray::Axis;

use super::{FrictionState, FrictionalContact};

/// The shear below which there is none, over its limits: rounding, and what the tolerance of the solver leaves.
const NO_SHEAR: f64 = 1e-6;
/// How near to its limit the shear of a point is that slips, relative to the limit.
const AT_LIMIT: f64 = 1e-9;

/// Sums over the points of the shear and its limits at both ends of an increment.
#[derive(Default)]
struct Changes {
    /// The larger limit.
    largest: f64,
    /// The magnitudes of the shear at both ends.
    sheared: f64,
    /// The change of the limit, and that of the direction of a shear at its limit.
    changed: f64,
}

impl FrictionalContact {
    /// Returns true if limits or directions of the shear change so much in an increment from `start`, or from the
    /// undeformed surface, to `end` that its division may change the shear by more than `tolerance` (see
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

    /// The elastic energy of the difference of two states under one drive, both reached from `start`, or from the
    /// undeformed surface, over the energy of the shear that depends on the way: the elastic energy of `b` times the
    /// square of the ratio of its mean limit to its mean pressure, about the energy of a shear at its limit everywhere,
    /// times the fraction of the limits that changes between `start` and `b`. So measured, the energies of the errors
    /// of many short steps sum to that of a long one.
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

    /// The changes in an increment from `start`, or from the undeformed surface, to `end`.
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
                // A slip that turns about goes through stick and is exact.
                changes.changed += (from[0] * to[1] - from[1] * to[0]).abs() / magnitudes[0].max(magnitudes[1]);
            }
        }
        changes
    }

    /// The limit of the shear at a point of a state, and the shear there.
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
