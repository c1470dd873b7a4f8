//! The stability of a state at rest, and the step away from a saddle.

use gfmd_vector::for_each;

use super::descent::{Change, Descent, ROUNDING};
use super::trust_region::{Model, Number};

/// The accuracy of a search that only looks for negative curvature.
const PROBE: f64 = 1e-3;
/// The first step away from a saddle, in rms heights, and the largest number of times that it is doubled.
const FIRST_SHIFT: f64 = 1e-9;
const DOUBLINGS: u32 = 36;

impl<M: Model> Descent<'_, M> {
    /// Returns true if a state at rest is a saddle; the direction then has negative curvature. Conjugate gradients
    /// start from noise, which has a component along every direction; the small force at rest may have none, for
    /// symmetry.
    pub(super) fn is_unstable(&mut self) -> bool {
        if self.interface.law.stiffness_bound(f64::NEG_INFINITY) == 0.0 {
            // Without a law the energy is convex.
            self.lowest = 1.0;
            return false;
        }
        let noise = |start: usize, [noise]: [&mut [M::Value]; 1]| {
            for (k, noise) in noise.iter_mut().enumerate() {
                // Multiples of the golden ratio are spread evenly and favour no wave.
                let spread = 0.618_033_988_749_895 * (start + k + 1) as f64 * ((start + k) % 7 + 1) as f64;
                *noise = M::Value::of(spread.fract() - 0.5);
            }
        };
        for_each([&mut self.region.vectors.residual[..]], &noise);
        let lowest = self.region.probe(&mut self.model, &self.here.reaction, PROBE);
        self.note(lowest);
        lowest <= 0.0
    }

    /// Steps away from a saddle along the direction, just far enough that the energy falls by more than rounding
    /// errors.
    pub(super) fn leave(&mut self) -> bool {
        let longest = self.region.longest();
        let downhill = if self.slope() > 0.0 { -1.0 } else { 1.0 };
        let mut share = downhill * FIRST_SHIFT * self.interface.length_scale() / longest;
        for _ in 0..DOUBLINGS {
            let Change { energy, size, .. } = self.try_step(share);
            if energy < -10.0 * ROUNDING * size {
                self.accept();
                // The radius that was found before the saddle is not valid beyond it.
                self.region.radius = f64::INFINITY;
                return true;
            }
            share *= 2.0;
        }
        false
    }
}
