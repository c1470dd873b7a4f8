//! Wall that gives way below a law: a hardness bounds its repulsion, and springs act in series with it.
//!
//! With a the gap that the elastic surface leaves to the rigid one, the repulsion of a point is r = min(r_max, −a/k) for
//! a < 0 and 0 for a > 0, with the compliance k of the spring. The hardness P bounds the pressure that the body feels,
//! r − T(0) ≤ P, so that r_max = P + T(0), with the attraction T(0) of the law. The potential of the point is Φ(a) for
//! a ≥ 0 and Φ(0) + T(0) a + ∫ r da below. Without a spring it has a kink at a = 0, where −T(0) ≤ p ≤ P. The surfaces
//! are pressed into each other by −a − k r_max where this is positive (theory.md, sections 7.2 and 7.10).

use std::sync::Arc;

use gfmd_contact::{Hardness, Load, Refusal, Springs};
use gfmd_law::Opening;
use gfmd_relax::Upper;
use gfmd_vector::{for_each, reduce, sum, total};
use ndarray::Array2;

use crate::frame::Frame;
use crate::{Interface, State};

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

/// Reason why a [`Refusal`] names all components.
const ALL_COMPONENTS: &str = "all components of the displacement";
/// Reason why a [`Refusal`] names the law.
const NO_WALL: &str = "a law without a hard wall";

impl Interface {
    /// Sets the `hardness`, the largest pressure that the body feels, in stress: a number or a field `[x, y]`. Beside a
    /// law, the repulsion of the wall may exceed it by the attraction in contact. Where it is reached, the surfaces are
    /// [pressed into each other](State::pressed_in). A repulsive law is not bounded.
    ///
    /// # Errors
    /// Returns an error for a hardness that is not positive and finite or differs in shape from the heights, for a law
    /// without a hard wall, and for an interface in all components.
    pub fn with_hardness(self, hardness: impl Into<Hardness>) -> Result<Self, Refusal> {
        self.check_wall("a hardness is")?;
        let hardness = Some(hardness.into().in_units(&self.given, &self.units)?);
        Ok(Self { hardness, ..self })
    }

    /// Sets the compliance of `springs` in series with the wall, in length/stress, a number or a field `[x, y]`: in
    /// contact, the surfaces overlap by the compliance times the repulsion of the wall. At a compliance of 0 the wall is
    /// hard. Archard's law in one step of sliding is such a compliance, the coefficient times the distance.
    ///
    /// # Errors
    /// Returns an error for a compliance that is negative or not finite or differs in shape from the heights, for a law
    /// without a hard wall, and for an interface in all components.
    pub fn with_springs(self, springs: impl Into<Springs>) -> Result<Self, Refusal> {
        self.check_wall("a compliance of springs is")?;
        let [nx, ny] = self.given.grid().points();
        let check = |found: f64| {
            if found >= 0.0 && found.is_finite() { Ok(found) } else { Err(Refusal::Springs { found }) }
        };
        let values: Vec<f64> = match springs.into() {
            Springs::Uniform(compliance) => vec![check(compliance)?; nx * ny],
            Springs::Field(field) => {
                let (found, expected) = (field.dim().into(), [nx, ny]);
                if found != expected {
                    return Err(Refusal::SpringsShape { found, expected });
                }
                field.iter().map(|compliance| check(*compliance)).collect::<Result<_, _>>()?
            }
        };
        let unit = self.units.stiffness();
        let is_rigid = values.iter().all(|compliance| *compliance == 0.0);
        let springs = (!is_rigid).then(|| values.iter().map(|compliance| compliance * unit).collect());
        Ok(Self { springs, ..self })
    }

    /// Returns the hardness, in stress.
    pub fn hardness(&self) -> Option<Hardness> {
        self.hardness_in(self.units.stress())
    }

    /// Returns the hardness multiplied by `unit`.
    pub(crate) fn hardness_in(&self, unit: f64) -> Option<Hardness> {
        Some(match self.hardness.as_ref()?.times(unit) {
            Upper::All(hardness) => Hardness::Uniform(hardness),
            Upper::Each(values) => {
                let [_, ny] = self.given.grid().points();
                Hardness::Field(Array2::from_shape_fn(self.given.grid().points(), |(i, j)| values[i * ny + j]))
            }
        })
    }

    fn check_wall(&self, part: &'static str) -> Result<(), Refusal> {
        match (self.elastic.components(), self.law.has_wall()) {
            (1, true) => Ok(()),
            (1, false) => Err(Refusal::NoWall { part, with: NO_WALL }),
            _ => Err(Refusal::NoWall { part, with: ALL_COMPONENTS }),
        }
    }

    /// Checks that the mean pressure of a load, in input units, is below the mean hardness.
    pub(crate) fn check_hardness(&self, load: Load) -> Result<(), Refusal> {
        let (Some(hardness), Load::MeanPressure(found)) = (&self.hardness, load) else { return Ok(()) };
        let what = if let Upper::Each(_) = hardness { "mean hardness" } else { "hardness" };
        let hardness = hardness.mean() * self.units.stress();
        if found < hardness { Ok(()) } else { Err(Refusal::BeyondHardness { found, what, hardness }) }
    }

    /// Returns true if the wall gives way at some points, so that a body with a fixed mean level may be pressed beyond
    /// full contact.
    pub(crate) fn gives_way(&self) -> bool {
        self.hardness.is_some() || self.springs.is_some()
    }

    /// Returns the wall in a frame; `None` if it gives way nowhere.
    pub(crate) fn kinks(&self, frame: &Frame) -> Option<Kinks> {
        if !self.gives_way() {
            return None;
        }
        let [softest, stiffest] = self.elastic.stiffness_range();
        let touch = self.law.opening(0.0);
        let (mut most, mut springs) = (vec![f64::INFINITY; frame.points()], vec![0.0; frame.points()]);
        for i in 0..frame.inside() {
            let at = frame.place_of(i);
            if let Some(hardness) = &self.hardness {
                most[at] = (hardness.ceiling().at(i) + touch.traction).max(0.0);
            }
            if let Some(given) = &self.springs {
                springs[at] = if given[i] * stiffest > RIGID { given[i] } else { 0.0 };
            }
        }
        let stiffness = (softest * stiffest).sqrt();
        Some(Kinks { bound: frame.wall().collect(), most, springs, touch, stiffness })
    }
}

/// Returns the compliance of springs whose tractions are divided by `factor`.
pub(crate) fn stiffer(springs: &Option<Arc<[f64]>>, factor: f64) -> Option<Arc<[f64]>> {
    springs.as_ref().map(|springs| springs.iter().map(|compliance| compliance * factor).collect())
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
}

impl Kinks {
    /// Returns the height of the rigid surface at point `i`.
    pub(crate) fn bound(&self, i: usize) -> f64 {
        self.bound[i]
    }

    /// Returns the largest repulsion of point `i`.
    pub(crate) fn most(&self, i: usize) -> f64 {
        self.most[i]
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
        let points = w.len() as f64;
        let mut last = f64::INFINITY;
        for _ in 0..ROUNDS {
            let now = total(w);
            let is_near = now.abs() / points <= RESTORED * length_scale;
            if now.abs() / points <= f64::EPSILON * length_scale || (is_near && now.abs() >= 0.5 * last.abs()) {
                return true;
            }
            last = now;
            let share = |i: usize, w: f64, inset: f64| {
                if self.can_move(i, pieces[i], inset, last < 0.0, w) { self.share(i, pieces[i]) } else { 0.0 }
            };
            let movable = sum(w.len(), &|range| range.map(|i| share(i, w[i], inset[i])).sum());
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

    /// Returns the force for which a held mean balances points that are all at kinks, the middle of the possible ones.
    pub(crate) fn level(&self, force: &[f64]) -> f64 {
        let ends = |range: std::ops::Range<usize>| {
            range.fold([f64::NEG_INFINITY, f64::INFINITY], |[least, most], i| {
                [least.max(force[i] - self.most[i]), most.min(force[i])]
            })
        };
        let [least, most] = reduce(force.len(), &ends, &|a: [f64; 2], b| [a[0].max(b[0]), a[1].min(b[1])]);
        if least.is_finite() { 0.5 * (least + most) } else { most }
    }

    /// Returns the insets of given fields: `of` returns the pressure −t_z and the geometric inset of the inside point
    /// `i` at the place `at` of the cell if it is in contact. Where the repulsion has its largest value, the geometric
    /// inset counts, elsewhere the spring under the pressure.
    pub(crate) fn insets(&self, frame: &Frame, of: impl Fn(usize, usize) -> Option<[f64; 2]>) -> Vec<f64> {
        let mut insets = vec![0.0; frame.points()];
        for i in 0..frame.inside() {
            let at = frame.place_of(i);
            let Some([pressure, depth]) = of(i, at) else { continue };
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
                let fields = state.displacement.iter().zip(&state.traction).zip(&state.gap);
                let fields: Vec<_> = fields.map(|((u, t), gap)| (u + rise, -t, *gap)).collect();
                self.insets(frame, |i, at| {
                    let (w, pressure, gap) = fields[i];
                    (gap <= 0.0).then(|| [pressure, w - self.bound[at]])
                })
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
