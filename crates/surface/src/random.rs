use std::f64::consts::TAU;

use rand::Rng;
use rand_pcg::Pcg64;

/// Increment of the SplitMix64 sequence: 2⁶⁴ divided by the golden ratio.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Stream of every generator here, the default of PCG64.
const STREAM: u128 = 0x0a02_bdbf_7bb3_c0a7_ac28_fa16_a64a_bf96;

/// Returns the generator of `seed` and two integers, as documented at [`crate::SelfAffine::spectrum`]. The state is
/// mixed so that neighbouring modes and seeds share no bits. All platforms give the same stream (integer arithmetic).
pub(crate) fn keyed(seed: u64, [m, n]: [i64; 2]) -> Pcg64 {
    let low = mix(mix(mix(seed) ^ m as u64) ^ n as u64);
    Pcg64::new(u128::from(mix(low)) << 64 | u128::from(low), STREAM)
}

/// Returns two uniform multiples of 2⁻⁵³, the first in (0, 1] (its logarithm is finite), the second in \[0, 1).
pub(crate) fn uniform_pair(generator: &mut Pcg64) -> [f64; 2] {
    const UNIT: f64 = 1.0 / (1_u64 << 53) as f64;
    let first = (generator.next_u64() >> 11) + 1;
    let second = generator.next_u64() >> 11;
    [first as f64 * UNIT, second as f64 * UNIT]
}

/// Stream of independent normal numbers of variance 1, by the Box–Muller transform of pairs of uniform numbers.
pub(crate) struct Normal {
    generator: Pcg64,
    spare: Option<f64>,
}

impl Normal {
    /// Starts the stream of `seed`.
    pub(crate) fn new(seed: u64) -> Self {
        Self { generator: keyed(seed, [0, 0]), spare: None }
    }

    /// Returns the next number.
    pub(crate) fn next(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let [u1, u2] = uniform_pair(&mut self.generator);
        let (radius, (sin, cos)) = ((-2.0 * u1.ln()).sqrt(), (TAU * u2).sin_cos());
        self.spare = Some(radius * sin);
        radius * cos
    }
}

/// Returns the output of SplitMix64 after one step from `state`: a bijection of 64-bit words in which each input bit
/// affects every output bit.
fn mix(state: u64) -> u64 {
    let z = state.wrapping_add(GOLDEN);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares with the published first outputs of SplitMix64 from state 1234567.
    #[test]
    fn mix_is_splitmix64() {
        let published: [u64; 3] = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        for (step, expected) in published.into_iter().enumerate() {
            assert_eq!(mix(1_234_567_u64.wrapping_add(GOLDEN.wrapping_mul(step as u64))), expected);
        }
    }

    #[test]
    fn normal_numbers_have_the_moments_of_the_normal_law() {
        let (count, mut normal) = (200_000, Normal::new(7));
        let mut moments = [0.0; 4];
        for _ in 0..count {
            let x = normal.next();
            for (power, moment) in moments.iter_mut().enumerate() {
                *moment += x.powi(power as i32 + 1) / f64::from(count);
            }
        }
        // Four standard errors: variances of x, x², x³, x⁴ are 1, 2, 15, 96.
        for ((found, expected), variance) in moments.into_iter().zip([0.0, 1.0, 0.0, 3.0]).zip([1.0, 2.0, 15.0, 96.0]) {
            assert!((found - expected).abs() < 4.0 * f64::sqrt(variance / f64::from(count)), "{found} for {expected}");
        }
    }

    #[test]
    fn keys_that_differ_in_one_number_share_nothing() {
        let first = |seed, number| uniform_pair(&mut keyed(seed, number));
        let base = first(1, [3, 5]);
        for other in [first(2, [3, 5]), first(1, [5, 3]), first(1, [-3, 5]), first(1, [3, 6]), first(0, [3, 5])] {
            assert!((base[0] - other[0]).abs() > 1e-6 && (base[1] - other[1]).abs() > 1e-6);
        }
    }
}
