//! Stability of an equilibrium state, and the step away from a saddle.

use gfmd_vector::for_each;

use super::descent::{Change, Descent, ROUNDING_OF_ENERGY};
use super::trust_region::{Model, Number};

/// Accuracy of a search for negative curvature only.
const PROBE: f64 = 1e-3;
/// First step away from a saddle, in rms heights, and the maximum number of its doublings.
const FIRST_SHIFT: f64 = 1e-9;
const DOUBLINGS: u32 = 36;

impl<M: Model> Descent<'_, M> {
    /// Returns true if an equilibrium state is a saddle; the direction then has negative curvature. Conjugate gradients
    /// start from noise, which has a component along every direction; the small residual force may have none, for
    /// symmetry.
    pub(super) fn is_unstable(&mut self) -> bool {
        if self.interface.law.stiffness_bound(f64::NEG_INFINITY) == 0.0 {
            // Without a law the energy is convex.
            self.lowest = 1.0;
            return false;
        }
        // Points of each component and face count from the first one of all processes.
        let share = self.frame.share;
        let (start_of_own, faces) = (share.own().start, share.faces());
        let (points, others) = (share.own().len() / faces, (share.total() - share.own().len()) / faces);
        let noise = |start: usize, [noise]: [&mut [M::Value]; 1]| {
            for (k, noise) in noise.iter_mut().enumerate() {
                // Multiples of the golden ratio are spread evenly and favour no wave.
                let i = start + k;
                let i = start_of_own + i + i / points * others;
                let spread = 0.618_033_988_749_895 * (i + 1) as f64 * (i % 7 + 1) as f64;
                *noise = M::Value::of(spread.fract() - 0.5);
            }
        };
        for_each([&mut self.region.vectors.residual[..]], &noise);
        let lowest = self.region.probe(&mut self.model, &self.here.reaction, PROBE);
        self.note(lowest);
        lowest <= 0.0
    }

    /// Steps away from a saddle along the direction, just far enough for an energy decrease beyond rounding errors.
    pub(super) fn leave(&mut self) -> bool {
        let longest = self.region.longest(self.frame.share);
        let downhill = if self.slope() > 0.0 { -1.0 } else { 1.0 };
        let mut share = downhill * FIRST_SHIFT * self.interface.length_scale() / longest;
        for _ in 0..DOUBLINGS {
            let Change { energy, size, .. } = self.try_step(share);
            if energy < -10.0 * ROUNDING_OF_ENERGY * size {
                self.accept();
                // The radius from before the saddle is not valid beyond it.
                self.region.radius = f64::INFINITY;
                return true;
            }
            share *= 2.0;
        }
        false
    }
}
