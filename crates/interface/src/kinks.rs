//! Wall that gives way below a law: a hardness bounds its repulsion, and springs act in series with it.
//!
//! The repulsion of a point is r = min(r_max, −a/k) for a < 0 and 0 for a > 0, with the distance a from the elastic up
//! to the rigid surface and the compliance k of the spring. The hardness P bounds the pressure that the body feels,
//! r − T(0) ≤ P, so that r_max = P + T(0), with the attraction T(0) of the law. The potential of the point is Φ(a) for
//! a ≥ 0 and Φ(0) + T(0) a + ∫ r da below. Without a spring it has a kink at a = 0, where −T(0) ≤ p ≤ P. The surfaces
//! are pressed into each other by −a − k r_max where this is positive (theory.md, section 8.2).

use gfmd_contact::Load;
use gfmd_law::Opening;
use gfmd_relax::Upper;
use gfmd_vector::{Share, for_each};
use ndarray::{ArrayRef2, Axis};

use crate::State;
use crate::frame::Frame;
use crate::numbers::{reduce, sum, total};

/// Compliance of a spring times the largest stiffness of the body below which the spring is a wall for the search: it
/// changes the displacement by a smaller part than the tightest tolerance.
const RIGID: f64 = 1e-10;

/// Largest relative difference between the repulsion and its bound at a point of given fields that counts as pressed
/// into the other surface.
const NEAR: f64 = 1e-6;

/// Mean below which a held mean is restored, in rms heights, if rounds no longer improve it.
const RESTORED: f64 = 1e-12;

/// Maximum number of rounds to restore a mean; a few suffice.
const ROUNDS: usize = 50;

/// Returns true if a spring on a body with the largest stiffness `stiffest` is a wall for the search.
pub(crate) fn is_rigid(compliance: f64, stiffest: f64) -> bool {
    compliance * stiffest <= RIGID
}

/// Piece of the potential of a point on which it is smooth, and on which the point stays during one step of a search.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Piece {
    /// The law alone acts, at a ≥ 0.
    Open,
    /// The point is held at the kink a = 0.
    Held,
    /// The spring is shortened, −k r_max ≤ a ≤ 0.
    Spring,
    /// The repulsion has its largest value, at a ≤ −k r_max.
    Pressed,
}

/// Wall that gives way, at the points of a frame. The inset of a point is max(−a, 0). It is kept beside the position,
/// since the difference of two heights would not resolve the short springs of a small wear step.
pub(crate) struct Kinks {
    /// Heights of the rigid surface.
    bound: Vec<f64>,
    /// Largest repulsion r_max, infinite without a hardness.
    most: Vec<f64>,
    /// Compliance k.
    springs: Vec<f64>,
    /// Law at a closed gap.
    pub(crate) touch: Opening,
    /// Stiffness of a wave of middle length.
    stiffness: f64,
    share: Share,
}

impl Kinks {
    /// Creates the wall from the hardness and the springs of the inside points, the law at a closed gap, and the range
    /// of stiffnesses of the body.
    pub(crate) fn new(
        frame: &Frame,
        hardness: Option<&Upper>,
        given: Option<&[f64]>,
        touch: Opening,
        [softest, stiffest]: [f64; 2],
    ) -> Self {
        let inside = 0..frame.inside();
        let most = hardness.map_or_else(
            || vec![f64::INFINITY; frame.points()],
            |hardness| {
                let ceiling = hardness.ceiling();
                let most = |i: usize| (ceiling.at(i) + touch.traction).max(0.0);
                frame.placed(inside.map(most), f64::INFINITY)
            },
        );
        let springs = given.map_or_else(
            || vec![0.0; frame.points()],
            |given| {
                let soft = given.iter().map(|k| if is_rigid(*k, stiffest) { 0.0 } else { *k });
                frame.placed(soft, 0.0)
            },
        );
        let (bound, share, stiffness) = (frame.wall().collect(), frame.share.clone(), (softest * stiffest).sqrt());
        Self { bound, most, springs, touch, stiffness, share }
    }

    /// Returns the height of the rigid surface at point `i`.
    pub(crate) fn bound(&self, i: usize) -> f64 {
        self.bound[i]
    }

    /// Returns the largest repulsion of point `i`.
    pub(crate) fn most(&self, i: usize) -> f64 {
        self.most[i]
    }

    /// Returns true if a repulsion of point `i` is its largest one, to the accuracy of stored fields.
    pub(crate) fn is_at_most(&self, i: usize, repulsion: f64) -> bool {
        repulsion >= (1.0 - NEAR) * self.most[i]
    }

    /// Returns the compliance of the spring of point `i`.
    pub(crate) fn spring(&self, i: usize) -> f64 {
        self.springs[i]
    }

    /// Returns the inset beyond which the repulsion of point `i` is constant.
    pub(crate) fn limit(&self, i: usize) -> f64 {
        if self.springs[i] > 0.0 { self.springs[i] * self.most[i] } else { 0.0 }
    }

    /// Returns the repulsion of point `i` at an inset; 0 at a kink.
    pub(crate) fn repulsion(&self, i: usize, inset: f64) -> f64 {
        if inset < self.limit(i) {
            inset / self.springs[i]
        } else if inset > 0.0 {
            self.most[i]
        } else {
            0.0
        }
    }

    /// Returns the depth by which the surfaces are pressed into each other at point `i`.
    pub(crate) fn pressed_in(&self, i: usize, inset: f64) -> f64 {
        (inset - self.limit(i)).max(0.0)
    }

    /// Returns true if point `i` is in contact; it may be without repulsion.
    pub(crate) fn touches(&self, i: usize, w: f64) -> bool {
        w >= self.bound[i]
    }

    /// Returns true if point `i` is at a kink, where its repulsion may have any value up to the largest one.
    pub(crate) fn is_at_kink(&self, i: usize, w: f64, inset: f64) -> bool {
        self.touches(i, w) && inset == 0.0 && self.springs[i] == 0.0
    }

    /// Returns the piece of point `i` at an inset; [`Piece::Open`] without one.
    pub(crate) fn piece(&self, i: usize, inset: f64) -> Piece {
        if inset <= 0.0 {
            Piece::Open
        } else if inset < self.limit(i) {
            Piece::Spring
        } else {
            Piece::Pressed
        }
    }

    /// Returns energy, traction and slope of point `i` in contact, on a piece, at an inset.
    pub(crate) fn act(&self, i: usize, piece: Piece, inset: f64) -> Opening {
        let Opening { energy, traction, .. } = self.touch;
        let closed = energy - traction * inset;
        let repulsion = self.repulsion_on(i, piece, inset);
        let traction = traction - repulsion;
        match piece {
            Piece::Open | Piece::Held => self.touch,
            Piece::Spring => {
                Opening { energy: closed + 0.5 * repulsion * inset, traction, slope: self.springs[i].recip() }
            }
            Piece::Pressed => {
                Opening { energy: closed + repulsion * (inset - 0.5 * self.limit(i)), traction, slope: 0.0 }
            }
        }
    }

    /// Returns the repulsion of point `i` on a piece, at an inset.
    pub(crate) fn repulsion_on(&self, i: usize, piece: Piece, inset: f64) -> f64 {
        match piece {
            Piece::Open | Piece::Held => 0.0,
            Piece::Spring => inset / self.springs[i],
            Piece::Pressed => self.most[i],
        }
    }

    /// Chooses the piece on which point `i` in contact moves under a `force` without its repulsion; returns the piece.
    /// Only at the ends of a piece is there a choice.
    pub(crate) fn release(&self, i: usize, inset: f64, force: f64) -> Piece {
        let (limit, most) = (self.limit(i), self.most[i]);
        match () {
            () if inset == 0.0 && force <= 0.0 => Piece::Open,
            () if inset < limit => Piece::Spring,
            () if inset == limit && force > most => Piece::Pressed,
            () if inset == 0.0 => Piece::Held,
            () if inset == limit => Piece::Spring,
            () => Piece::Pressed,
        }
    }

    /// Returns position and inset of point `i` after a `step`, which ends where its piece ends.
    pub(crate) fn moved(&self, i: usize, piece: Piece, [w, inset]: [f64; 2], step: f64) -> [f64; 2] {
        let bound = self.bound[i];
        let at = |inset: f64| [bound + inset, inset];
        match piece {
            Piece::Open => {
                let w = w + step;
                // A point within rounding of the wall would cut off the next steps.
                let is_apart = w + 4.0 * f64::EPSILON * w.abs() < bound;
                if is_apart { [w, 0.0] } else { [bound, 0.0] }
            }
            Piece::Held => [bound, 0.0],
            Piece::Spring => at((inset + step).max(0.0).min(self.limit(i))),
            Piece::Pressed => at((inset + step).max(self.limit(i))),
        }
    }

    /// Returns true if point `i` can move on its piece in one direction, up or down.
    fn can_move(&self, i: usize, piece: Piece, inset: f64, up: bool, w: f64) -> bool {
        match piece {
            Piece::Open => !up || w < self.bound[i],
            Piece::Held => false,
            Piece::Spring if up => inset < self.limit(i),
            Piece::Spring => inset > 0.0,
            Piece::Pressed => up || inset > self.limit(i),
        }
    }

    /// Returns the share of point `i` in a shift of all points: 1, or less at a spring, stiffer than the body.
    pub(crate) fn share(&self, i: usize, piece: Piece) -> f64 {
        let relative = self.springs[i] * self.stiffness;
        if piece == Piece::Spring { relative / (1.0 + relative) } else { 1.0 }
    }

    /// Shifts points on their pieces until the mean of the positions is 0. A shift may push points to the ends of their
    /// pieces; it is repeated. Returns false if the pieces do not allow it.
    pub(crate) fn restore_mean(&self, pieces: &[Piece], w: &mut [f64], inset: &mut [f64], length_scale: f64) -> bool {
        let points = if self.share.is_whole() { w.len() } else { self.share.total() } as f64;
        let mut last = f64::INFINITY;
        for _ in 0..ROUNDS {
            let now = total(&self.share, w);
            let is_near = now.abs() / points <= RESTORED * length_scale;
            if now.abs() / points <= f64::EPSILON * length_scale || (is_near && now.abs() >= 0.5 * last.abs()) {
                return true;
            }
            last = now;
            let share = |i: usize, w: f64, inset: f64| {
                if self.can_move(i, pieces[i], inset, last < 0.0, w) { self.share(i, pieces[i]) } else { 0.0 }
            };
            let movable = sum(&self.share, w.len(), &|range| range.map(|i| share(i, w[i], inset[i])).sum());
            if movable == 0.0 {
                break;
            }
            let shift = -last / movable;
            for_each([&mut *w, &mut *inset], &|start, [w, inset]| {
                for (k, (w, inset)) in w.iter_mut().zip(inset).enumerate() {
                    let (i, part) = (start + k, share(start + k, *w, *inset));
                    if part > 0.0 {
                        [*w, *inset] = self.moved(i, pieces[i], [*w, *inset], shift * part);
                    }
                }
            });
        }
        last.abs() / points <= RESTORED * length_scale
    }

    /// Returns the force for which a held mean balances points that are all at kinks: of the possible ones the next to
    /// `wanted`, or the middle.
    pub(crate) fn level(&self, force: &[f64], wanted: Option<f64>) -> f64 {
        let ends = |range: std::ops::Range<usize>| {
            range.fold([f64::NEG_INFINITY, f64::INFINITY], |[least, most], i| {
                [least.max(force[i] - self.most[i]), most.min(force[i])]
            })
        };
        let [least, most] = reduce(&self.share, force.len(), &ends, &|a: [f64; 2], b| [a[0].max(b[0]), a[1].min(b[1])]);
        match wanted {
            Some(wanted) if wanted.is_finite() && least <= most => wanted.clamp(least, most),
            _ if least.is_finite() => 0.5 * (least + most),
            _ => most,
        }
    }

    /// Returns the insets of given fields, from the pressure −t_z and the gap at the inside points: `of` returns the
    /// pressure and the geometric inset of a point in contact with this pressure. Where the repulsion has its largest
    /// value, the geometric inset counts, elsewhere the spring under the pressure.
    pub(crate) fn insets(
        &self,
        frame: &Frame,
        [pressure, gap]: [&ArrayRef2<f64>; 2],
        of: impl Fn(usize, f64) -> [f64; 2],
    ) -> Vec<f64> {
        let mut insets = vec![0.0; frame.points()];
        let pressure = frame.placed(pressure.iter().copied(), 0.0);
        let gap = frame.placed(gap.iter().copied(), f64::INFINITY);
        for at in (0..frame.points()).filter(|at| gap[*at] <= 0.0) {
            let [pressure, depth] = of(at, pressure[at]);
            let (repulsion, most) = (pressure + self.touch.traction, self.most[at]);
            insets[at] = if repulsion >= most * (1.0 - NEAR) {
                depth.max(self.limit(at))
            } else {
                self.springs[at] * repulsion.max(0.0)
            };
        }
        insets
    }

    /// Returns the insets at the start of a search, and places the points in contact there.
    pub(crate) fn start(&self, frame: &Frame, start: Option<&State>, position: &mut [f64]) -> Vec<f64> {
        let insets = match start {
            None => vec![0.0; frame.points()],
            Some(state) => {
                let rise = if let Load::MeanPressure(_) = frame.drive.load { state.approach } else { 0.0 };
                let w = frame.placed(state.displacement.iter().map(|u| u + rise), 0.0);
                let pressure = state.traction.index_axis(Axis(0), 0).mapv(|t| -t);
                self.insets(frame, [&pressure, &state.gap], |at, pressure| [pressure, w[at] - self.bound[at]])
            }
        };
        let place = |start: usize, [w, inset]: [&mut [f64]; 2]| {
            for (k, (w, inset)) in w.iter_mut().zip(inset).enumerate() {
                let bound = self.bound[start + k];
                if *inset > 0.0 || *w >= bound {
                    *w = bound + *inset;
                }
            }
        };
        let mut insets = insets;
        for_each([position, &mut insets[..]], &place);
        insets
    }
}
