//! Damped motion of a single mode of stiffness k: eigenvalues, regimes, and optimal parameters.

use std::f64::consts::LN_10;

use crate::RelaxError;

/// Parameters of the damped scheme u₊ = u + β (u − u₋) + τ f (theory.md, section 6.1, scheme A).
///
/// For f = −k u, the error of a mode obeys λ² − (1 + β − τ k) λ + β = 0. All stiffnesses are per mass, in 1/time².
///
/// ```
/// use gfmd_relax::{Damping, Motion};
///
/// let damping = Damping::critical(0.01, 1.0);
/// assert!((damping.beta - 0.81).abs() < 1e-15);
/// assert!(matches!(damping.motion(0.01), Motion::Critical { eigenvalue } if (eigenvalue - 0.9).abs() < 1e-9));
/// assert!(matches!(damping.motion(0.02), Motion::UnderDamped { .. }));
/// assert!(matches!(damping.motion(0.005), Motion::OverDamped { .. }));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping {
    /// Momentum β = 1 − η Δt²: the fraction of a step that is repeated in the next one. 0 is gradient descent, 1 is
    /// undamped.
    pub beta: f64,
    /// τ = Δt²/m, in displacement per force.
    pub tau: f64,
}

/// Damping coefficients η relative to critical damping.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Factors {
    /// One η for all entries, divided by the critical η of the softest mode (thesis, eq. 4.8).
    Softest(f64),
    /// One η for each component x, y, z, divided by the critical η of the uniform mode of the component, 2√κ_i/Δt − κ_i
    /// with κ = C44/z_m, C44/z_m, C11/z_m on a bonded slab (thesis, eq. 4.5).
    Components([f64; 3]),
}

/// Evolution of the error of one mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Motion {
    /// Two complex eigenvalues: the mode oscillates.
    UnderDamped {
        /// |λ| = √β.
        modulus: f64,
        /// Phase advance per step, in radians.
        angle: f64,
    },
    /// A double eigenvalue: the mode decays as fast as possible without oscillation.
    Critical {
        /// λ = (1 + β − τ k) / 2.
        eigenvalue: f64,
    },
    /// Two real eigenvalues. If positive, the mode decays monotonically. If negative, the step is too long and the mode
    /// changes sign in every step.
    OverDamped {
        /// Eigenvalue of larger magnitude.
        slow: f64,
        /// Eigenvalue of smaller magnitude.
        fast: f64,
    },
}

impl Damping {
    /// Returns the critical damping of a mode of stiffness `k` at time step `dt` and unit mass: β = (1 − √k Δt)², that
    /// is, η = 2√k/Δt − k (theory.md, section 6.1).
    pub fn critical(k: f64, dt: f64) -> Self {
        Self { beta: (1.0 - k.sqrt() * dt).powi(2), tau: dt * dt }
    }

    /// Returns `factor` times the critical η of a mode of stiffness `k` at time step `dt`, if modes up to `k_max` are
    /// stable.
    ///
    /// # Errors
    /// Returns an error if the factor is not positive or too large for the time step.
    pub fn times_critical(factor: f64, k: f64, k_max: f64, dt: f64) -> Result<Self, RelaxError> {
        let tau = dt * dt;
        let critical = Self::critical(k, dt);
        // A factor of one gives exactly the critical damping.
        let damping = Self { beta: critical.beta - (factor - 1.0) * critical.eta() * tau, tau };
        let stable = damping.beta.abs() < 1.0 && k_max < damping.stiffness_limit();
        let allowed = "positive, and small enough for stability with this time step";
        RelaxError::check_parameter("the damping divided by the critical damping", factor, stable, allowed)?;
        Ok(damping)
    }

    /// Returns `fraction` times the stability limit 2/√`k_max` of the time step without damping.
    ///
    /// # Errors
    /// Returns an error if the fraction is not between 0 and 1.
    pub fn time_step(fraction: f64, k_max: f64) -> Result<f64, RelaxError> {
        let within = fraction > 0.0 && fraction < 1.0;
        let name = "the time step divided by the stability limit";
        RelaxError::check_parameter(name, fraction, within, "above 0 and below 1")?;
        Ok(fraction * 2.0 / k_max.sqrt())
    }

    /// Returns the largest time step for which the stiffest mode is stable with [`Damping::critical`] of the softest
    /// mode: Δt < 2 / (√k_min + √(k_max − k_min)), where τ k_max = 2 (1 + β).
    pub fn critical_dt_limit(k_min: f64, k_max: f64) -> f64 {
        2.0 / (k_min.sqrt() + (k_max - k_min).sqrt())
    }

    /// Returns the optimal damping and time step for all stiffnesses in [`k_min`, `k_max`]: √τ = 2 / (√k_min + √k_max),
    /// √β = (√κ − 1) / (√κ + 1) with κ = k_max / k_min (theory.md, section 6.2). The softest and the stiffest mode are
    /// both critically damped.
    pub fn optimal(k_min: f64, k_max: f64) -> Self {
        let (soft, stiff) = (k_min.sqrt(), k_max.sqrt());
        Self { beta: ((stiff - soft) / (stiff + soft)).powi(2), tau: (2.0 / (soft + stiff)).powi(2) }
    }

    /// Returns the optimal gradient descent (β = 0) for stiffnesses in [`k_min`, `k_max`], τ = 2 / (k_min + k_max), for
    /// comparison.
    pub fn plain_descent(k_min: f64, k_max: f64) -> Self {
        Self { beta: 0.0, tau: 2.0 / (k_min + k_max) }
    }

    /// Returns the scheme with a centred damping force −γ (u₊ − u₋) / 2Δt at unit mass (theory.md, section 6.1).
    pub fn central(gamma: f64, dt: f64) -> Self {
        let x = 0.5 * gamma * dt;
        Self { beta: (1.0 - x) / (1.0 + x), tau: dt * dt / (1.0 + x) }
    }

    /// Returns the critical γ of a mode of stiffness `k` in [`Damping::central`], 2 √(k (1 − k Δt²/4)), in 1/time.
    pub fn central_critical(k: f64, dt: f64) -> f64 {
        2.0 * (k * (1.0 - 0.25 * k * dt * dt)).sqrt()
    }

    /// Returns η = (1 − β)/Δt² at unit mass, in 1/time². It multiplies a displacement increment; the viscous
    /// coefficient is γ = η Δt.
    pub fn eta(&self) -> f64 {
        (1.0 - self.beta) / self.tau
    }

    /// Returns the stiffness below which every mode is stable if |β| < 1, 2 (1 + β)/τ (theory.md, section 6.1).
    pub fn stiffness_limit(&self) -> f64 {
        2.0 * (1.0 + self.beta) / self.tau
    }

    /// Returns the eigenvalues of a mode of stiffness `k`. A double eigenvalue is recognised up to rounding.
    pub fn motion(&self, k: f64) -> Motion {
        let (beta, kappa) = (self.beta, self.tau * k);
        let trace = 1.0 + beta - kappa;
        // As a product, the discriminant trace² − 4β has no cancellation near its zeros, the critical stiffnesses.
        let discriminant = if beta >= 0.0 {
            let root = beta.sqrt();
            (distance(1.0 - root, kappa)) * (distance(1.0 + root, kappa))
        } else {
            trace * trace - 4.0 * beta
        };
        if discriminant == 0.0 {
            Motion::Critical { eigenvalue: 0.5 * trace }
        } else if discriminant < 0.0 {
            Motion::UnderDamped { modulus: beta.sqrt(), angle: (-discriminant).sqrt().atan2(trace) }
        } else {
            let slow = 0.5 * (trace + discriminant.sqrt().copysign(trace));
            Motion::OverDamped { slow, fast: beta / slow }
        }
    }

    /// Returns the largest |λ| of a mode of stiffness `k`, the asymptotic decay factor of its error per step.
    pub fn spectral_radius(&self, k: f64) -> f64 {
        match self.motion(k) {
            Motion::UnderDamped { modulus, .. } => modulus,
            Motion::Critical { eigenvalue } => eigenvalue.abs(),
            Motion::OverDamped { slow, .. } => slow.abs(),
        }
    }

    /// Predicts the number of steps per decimal digit for stiffnesses in [`k_min`, `k_max`]; infinite if unstable. The
    /// slowest mode is at one end of the interval.
    ///
    /// With bounds, convergence is at least as fast, since fixing entries keeps the spectrum in the interval
    /// (theory.md, section 6.5).
    pub fn steps_per_decade(&self, k_min: f64, k_max: f64) -> f64 {
        let radius = self.spectral_radius(k_min).max(self.spectral_radius(k_max));
        if radius < 1.0 { -LN_10 / radius.ln() } else { f64::INFINITY }
    }

    /// Returns the error of a mode of stiffness `k` after `step` steps, if released at rest at 1.
    pub fn amplitude(&self, k: f64, step: u32) -> f64 {
        let n = f64::from(step);
        let power = |base: f64| if step == 0 { 1.0 } else { base.signum().powf(n) * base.abs().powf(n) };
        match self.motion(k) {
            Motion::UnderDamped { modulus, angle } => {
                power(modulus) * ((n * angle).cos() + self.swing(k, modulus, angle) * (n * angle).sin())
            }
            // λ² = β: u₁ = 1 − τ k = 2 λ − β.
            Motion::Critical { eigenvalue } => power(eigenvalue) * (1.0 + n * (1.0 - eigenvalue)),
            Motion::OverDamped { slow, fast } => {
                let part = (1.0 - self.tau * k - fast) / (slow - fast);
                part * power(slow) + (1.0 - part) * power(fast)
            }
        }
    }

    /// Returns the number of steps after which the error of a mode of stiffness `k`, released at rest at 1, stays
    /// within `tolerance`; `None` if it never does.
    pub fn steps_to(&self, k: f64, tolerance: f64) -> Option<u32> {
        let envelope = |step: u32| match self.motion(k) {
            Motion::UnderDamped { modulus, angle } => {
                // Near critical damping, the coefficient of sin nθ is large, but |sin nθ| ≤ n sin θ.
                let swing = self.swing(k, modulus, angle).abs();
                let n = f64::from(step);
                modulus.powf(n) * 1.0f64.hypot(swing).min(1.0 + swing * n * angle.sin())
            }
            _ => self.amplitude(k, step).abs(),
        };
        let stable = self.spectral_radius(k) < 1.0 && tolerance > 0.0;
        // The last step outside the tolerance is below the first power of two after which all steps are inside.
        let mut high = 1u32;
        while stable && (envelope(high) > tolerance || envelope(2 * high) > tolerance) {
            high = high.checked_mul(2).filter(|high| *high < u32::MAX / 2)?;
        }
        let mut low = 0;
        while low < high {
            let middle = low + (high - low) / 2;
            if envelope(middle) > tolerance { low = middle + 1 } else { high = middle }
        }
        stable.then_some(high)
    }

    /// Returns the ratio of the coefficients of sin nθ and cos nθ in the oscillation of a mode released at rest.
    fn swing(&self, k: f64, modulus: f64, angle: f64) -> f64 {
        ((1.0 - self.tau * k) / modulus - angle.cos()) / angle.sin()
    }
}

/// Returns root² − κ, or zero if it is within the rounding error of both.
fn distance(root: f64, kappa: f64) -> f64 {
    let distance = root * root - kappa;
    // √β and β have an absolute error of the order of ε, and so does 1 ∓ √β.
    let rounding = 8.0 * f64::EPSILON * (root.abs() + kappa);
    if distance.abs() <= rounding { 0.0 } else { distance }
}
