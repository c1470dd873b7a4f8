//! Choice of the pieces on which the points move in the next step, at a wall that gives way.

use gfmd_vector::{Share, for_each};

use super::descent::{Descent, Placed};
use super::pieces::Pieces;
use super::trust_region::{Model, Number};
use super::weight_of;
use crate::kinks::{Kinks, Piece};
use crate::numbers::{higher, higher_each, mean_where, reduce};

/// Least share in a shift of all points with which a point restores a held mean: at stiffer springs, points hardly
/// move. A share is the square of a weight in the preconditioner.
const SOFT: f64 = 0.01;

impl<M: Model> Descent<'_, M> {
    /// Chooses the piece of each point for the next step, subtracts the mean force if the mean is held, and returns the
    /// residual, as [`release`](Self::release) for a wall that gives way.
    pub(super) fn release_pieces(&mut self) -> f64 {
        let Self { interface, frame, pieces, model, here, force, multipliers, .. } = self;
        let Some(Pieces { kinks, of, .. }) = pieces else { return f64::NAN };
        let Placed { w, inset, elastic, reaction, .. } = here;
        let (w, inset, elastic, push) = (&w[..], &inset[..], &elastic[..], frame.push_on(0));
        let stiffness = interface.elastic.stiffness_range();
        // The force depends on the position alone, not on the pieces of the step before.
        for_each([&mut force[..]], &|start, [force]| {
            for (k, force) in force.iter_mut().enumerate().filter(|(k, _)| kinks.touches(start + k, w[start + k])) {
                let i = start + k;
                *force = kinks.touch.traction - kinks.repulsion(i, inset[i]) - elastic[i] + push;
            }
        });
        let multiplier = if frame.held[0] { held_level(frame.share, kinks, force, [w, inset]) } else { 0.0 };
        multipliers[0] = multiplier;
        let [traction, slope] = reaction.normal_mut();
        let choose = |start: usize, ([force, traction, slope], pieces, weight): Chosen<'_, M::Value>| {
            let mut worst = [0.0_f64; 2];
            for (k, (force, piece)) in force.iter_mut().zip(pieces).enumerate() {
                let i = start + k;
                *force -= multiplier;
                *piece = Piece::Open;
                if kinks.touches(i, w[i]) {
                    let alone = *force + kinks.repulsion(i, inset[i]);
                    *piece = kinks.release(i, inset[i], alone);
                    let act = kinks.act(i, *piece, inset[i]);
                    (traction[k], slope[k]) = (act.traction, act.slope);
                    *force = alone - kinks.repulsion_on(i, *piece, inset[i]);
                }
                let is_held = *piece == Piece::Held;
                // Weights above 1 let rounds of pressure and friction beside a law alternate between two states.
                weight[k] = M::Value::of(if is_held { 0.0 } else { weight_of(slope[k].max(0.0), stiffness) });
                let free = if is_held { 0.0 } else { force.abs() };
                worst = higher_each(worst, [free, (traction[k] - *force).abs()]);
            }
            worst
        };
        let [unbalanced, stress] =
            frame.share.pass(([&mut force[..], traction, slope], &mut of[..], model.weight()), &choose, &higher_each);
        model.hold_mean_above(SOFT.sqrt());
        let largest = higher(interface.stress_scale(frame.drive.load), stress);
        unbalanced / largest.max(f64::MIN_POSITIVE)
    }
}

type Chosen<'a, T> = ([&'a mut [f64]; 3], &'a mut [Piece], &'a mut [T]);

/// Returns the mean force of the points that are not at a kink, without stiff springs unless there are only these; if
/// all points are at kinks, the force that a held mean balances.
fn held_level(share: &Share, kinks: &Kinks, force: &[f64], [w, inset]: [&[f64]; 2]) -> f64 {
    let is_free = |i: usize| !kinks.is_at_kink(i, w[i], inset[i]);
    let is_soft = |i: usize| is_free(i) && kinks.share(i, kinks.piece(i, inset[i])) > SOFT;
    let any =
        |is: &(dyn Fn(usize) -> bool + Sync)| reduce(share, force.len(), &|mut range| range.any(is), &|a, b| a || b);
    if any(&is_soft) {
        mean_where(share, force, is_soft)
    } else if any(&is_free) {
        mean_where(share, force, is_free)
    } else {
        kinks.level(force, None)
    }
}
