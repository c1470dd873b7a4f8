//! Steps at a wall that gives way. The potential of each point has smooth pieces, on which it is convex but for the
//! law. Each step keeps the pieces and ends where they end, so that it is a projected step of a smooth energy within
//! bounds (Bertsekas 1982), and steps along the projected gradient lower the energy.

use gfmd_law::Law;
use gfmd_vector::for_each;

use super::reaction::Reaction;
use super::trust_region::Number;
use crate::State;
use crate::frame::Frame;
use crate::kinks::{Kinks, Piece};
use crate::numbers::total;

/// Pieces of all points.
pub(super) struct Pieces {
    pub(super) kinks: Kinks,
    pub(super) of: Vec<Piece>,
    length_scale: f64,
}

impl Pieces {
    pub(super) fn new(kinks: Kinks, length_scale: f64) -> Self {
        Self { kinks, of: Vec::new(), length_scale }
    }

    /// Places the points at the start of a search, with the held mean restored; returns their insets.
    pub(super) fn start(&mut self, frame: &Frame, start: Option<&State>, w: &mut [f64]) -> Vec<f64> {
        let mut insets = self.kinks.start(frame, start, w);
        self.classify(&insets);
        if frame.held[0] {
            let Self { kinks, of, length_scale } = self;
            // If the other points cannot restore the mean, points that touch go the way that does.
            for go in [false, true] {
                let excess = total(frame.share, w);
                let touch = |i: usize, w: &[f64]| insets[i] == 0.0 && kinks.touches(i, w[i]);
                for (i, piece) in of.iter_mut().enumerate().filter(|(i, _)| touch(*i, w)) {
                    *piece = match () {
                        () if go && excess > 0.0 => Piece::Open,
                        () if go && kinks.spring(i) > 0.0 => Piece::Spring,
                        () if go && kinks.most(i).is_finite() => Piece::Pressed,
                        () => Piece::Held,
                    };
                }
                if kinks.restore_mean(of, w, &mut insets, *length_scale) {
                    break;
                }
            }
            self.classify(&insets);
        }
        insets
    }

    /// Sets the pieces of the current insets.
    pub(super) fn classify(&mut self, insets: &[f64]) {
        let Self { kinks, of, .. } = self;
        of.resize(insets.len(), Piece::Open);
        for_each([&mut of[..]], &|start, [of]| {
            of.iter_mut().enumerate().for_each(|(k, piece)| *piece = kinks.piece(start + k, insets[start + k]));
        });
    }

    /// Moves positions and insets of the trial from the positions and insets `here` by `share` of the `direction`.
    pub(super) fn step<T: Number>(&self, here: [&[f64]; 2], share: f64, direction: &[T], trial: [&mut [f64]; 2]) {
        let (Self { kinks, of, .. }, [at, depth]) = (self, here);
        for_each(trial, &|start, [w, inset]| {
            for (k, (w, inset)) in w.iter_mut().zip(inset).enumerate() {
                let i = start + k;
                [*w, *inset] = kinks.moved(i, of[i], [at[i], depth[i]], share * direction[i].into());
            }
        });
    }

    /// Restores the held mean on the pieces; returns false if they do not allow it.
    pub(super) fn restore_mean(&self, w: &mut [f64], insets: &mut [f64]) -> bool {
        self.kinks.restore_mean(&self.of, w, insets, self.length_scale)
    }

    /// Computes the reaction of law and wall on the pieces, at positions and insets.
    pub(super) fn react(
        &self,
        law: &dyn Law,
        frame: &Frame,
        [w, insets]: [&[f64]; 2],
        (reaction, energy): (&mut Reaction, &mut [f64]),
    ) {
        let Self { kinks, of, .. } = self;
        reaction.update_normal(energy, |i| match of[i] {
            Piece::Open => law.opening(frame.separation(w, i).0),
            piece => kinks.act(i, piece, insets[i]),
        });
    }
}
