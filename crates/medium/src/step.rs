use crate::Branch;

/// Coefficients of one branch in a step of duration Δ with a displacement linear in time (theory.md, section 7.7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Decay {
    /// c, the modulus relative to the long-term modulus.
    pub(crate) weight: f64,
    /// e = exp(−Δ/τ), the remaining fraction of an elongation.
    pub(crate) left: f64,
    /// γ = (1 − e)/(Δ/τ), the fraction of a displacement change taken up by the spring.
    pub(crate) taken: f64,
    /// A, 2 B/a and C/a² with a = Δ/τ: the loss of the branch is c {A ⟨x, Sx⟩ + 2 B/a ⟨x, S Δd⟩ + C/a² ⟨Δd, S Δd⟩}.
    pub(crate) loss: [f64; 3],
}

impl Decay {
    pub(crate) fn new(Branch { time, weight }: Branch, duration: f64) -> Self {
        let a = duration / time;
        if a == 0.0 {
            return Self { weight, left: 1.0, taken: 1.0, loss: [0.0; 3] };
        }
        let (less, twice) = ((-a).exp_m1(), (-2.0 * a).exp_m1());
        let first = -0.5 * twice;
        Self { weight, left: (-a).exp(), taken: -less / a, loss: [first, less * less / a, quadratic(a, less, first)] }
    }
}

/// Returns C/a² = (a + 2 (e^{−a} − 1) − (e^{−2a} − 1)/2)/a², by its series where the closed form cancels.
fn quadratic(a: f64, less: f64, first: f64) -> f64 {
    if a >= 0.5 {
        return (1.0 + (2.0 * less + first) / a) / a;
    }
    // Σ_{k ≥ 2} (−1)^k (2^k − 2)/(k + 1)! a^{k − 1}
    let (mut sum, mut power, mut factorial) = (0.0, a, 6.0);
    for k in 2..22_i32 {
        sum += (2.0_f64.powi(k) - 2.0) / factorial * power;
        power *= -a;
        factorial *= f64::from(k + 2);
    }
    sum
}

/// Returns m = 1 + Σ c γ, the effective modulus in a step divided by the long-term modulus.
pub(crate) fn stiffening(decays: impl Iterator<Item = Decay>) -> f64 {
    1.0 + decays.map(|decay| decay.weight * decay.taken).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    #[test]
    fn a_step_has_known_numbers() {
        let decays =
            [(0.05, 1.2), (0.7, 1.0), (6.0, 0.8)].map(|(time, weight)| Decay::new(Branch { time, weight }, 0.4));
        for (decay, known) in decays.iter().zip([0.12495807, 0.76174329, 0.96739522]) {
            assert_relative_eq!(decay.taken, known, max_relative = 1e-7);
        }
        assert_relative_eq!(stiffening(decays.into_iter()), 2.685609146713, max_relative = 1e-12);
    }

    #[test]
    fn the_loss_is_that_of_the_dashpot() {
        // (1/τ) ∫ x² dt for x = x₀ e^{−t/τ} + Δd (1 − e^{−t/τ})/a, by Simpson's rule.
        let (x, moved) = (0.7, -0.4);
        for a in [1e-9, 1e-3, 0.3, 0.499, 0.5, 0.501, 2.0, 30.0] {
            let decay = Decay::new(Branch { time: 1.0, weight: 1.0 }, a);
            let steps = 10_000;
            let rate = |t: f64| (x * (-t).exp() - moved * (-t).exp_m1() / a).powi(2);
            let h = a / f64::from(steps);
            let simpson: f64 = (0..=steps)
                .map(|k| rate(f64::from(k) * h) * if k == 0 || k == steps { 1.0 } else { f64::from(2 + 2 * (k % 2)) })
                .sum();
            let [square, mixed, moving] = decay.loss;
            let loss = square * x * x + mixed * x * moved + moving * moved * moved;
            assert_relative_eq!(loss, h / 3.0 * simpson, max_relative = 1e-10);
            assert_relative_eq!(
                decay.left * x + decay.taken * moved,
                x * (-a).exp() - moved * (-a).exp_m1() / a,
                max_relative = 1e-14
            );
        }
        let relaxed = Decay::new(Branch { time: 1e-12, weight: 1.0 }, 1.0);
        assert!(relaxed.left == 0.0 && relaxed.loss.iter().all(|part| part.is_finite()));
    }
}
