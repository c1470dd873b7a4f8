//! Tests of eigenvalues, regimes and optimal parameters.

use approx::assert_relative_eq;
use gfmd_relax::{Damping, Method, ModeDamped, Motion, Nesterov, RelaxError, Verlet};

use crate::support::Chain;

#[test]
fn eigenvalues_solve_the_characteristic_equation() {
    for i in 0..2000 {
        let spread = |step: f64| (step * f64::from(i) + 0.31).fract();
        let damping = Damping { beta: 2.0 * spread(0.618_034) - 1.0, tau: 3.0 * spread(0.414_214) + 1e-3 };
        let k = 1.5 * spread(0.732_051) + 1e-3;
        let trace = 1.0 + damping.beta - damping.tau * k;
        let (sum, product) = match damping.motion(k) {
            Motion::UnderDamped { modulus, angle } => (2.0 * modulus * angle.cos(), modulus * modulus),
            Motion::Critical { eigenvalue } => (2.0 * eigenvalue, eigenvalue * eigenvalue),
            Motion::OverDamped { slow, fast } => {
                assert!(slow.abs() >= fast.abs());
                (slow + fast, slow * fast)
            }
        };
        assert_relative_eq!(sum, trace, epsilon = 1e-14, max_relative = 1e-12);
        assert_relative_eq!(product, damping.beta, epsilon = 1e-14, max_relative = 1e-12);
        // Stability ends exactly at the limit.
        assert_eq!(damping.spectral_radius(k) < 1.0, k < damping.stiffness_limit(), "{damping:?} {k}");
    }
}

/// Compares the closed form of the history, and the resulting number of steps, with the iteration.
#[test]
fn predicted_history_and_steps_agree_with_the_iteration() {
    let critical = Damping::critical(0.04, 0.7);
    let faster = Damping::critical(0.04, 0.999_9 * 0.7);
    for (damping, k) in [
        (critical, 0.04),
        (critical, 0.01),
        (critical, 1.3),
        (faster, 0.040_01),
        (Damping { beta: 0.3, tau: 1.0 }, 2.4),
        (Damping { beta: -0.4, tau: 1.0 }, 0.5),
        (Damping { beta: 0.0, tau: 1.0 }, 1.0),
        (Damping { beta: 0.0, tau: 1.0 }, 0.8),
    ] {
        let (mut u, mut previous) = (1.0, 1.0);
        let mut history = Vec::new();
        for step in 0..2000 {
            history.push(u);
            assert_relative_eq!(damping.amplitude(k, step), u, epsilon = 1e-12, max_relative = 1e-6);
            (u, previous) = (u + damping.beta * (u - previous) - damping.tau * k * u, u);
        }
        for tolerance in [0.5, 1e-3, 1e-9] {
            let outside = history.iter().rposition(|u: &f64| u.abs() > tolerance).map_or(0, |last| last + 1);
            let predicted = damping.steps_to(k, tolerance).unwrap() as usize;
            // An oscillation may be within the tolerance slightly before its envelope.
            assert!(
                (outside..=outside + 1 + outside / 5).contains(&predicted),
                "{damping:?} {k}: {predicted} {outside}"
            );
        }
    }
    assert_eq!(Damping { beta: 0.9, tau: 1.0 }.steps_to(3.9, 1e-3), None);
    assert_eq!(critical.steps_to(0.04, 0.0), None);
}

#[test]
fn regimes_change_at_the_critical_stiffness() {
    for (k, dt) in [(0.7, 0.25), (1e-4, 0.9), (3e-9, 0.5), (2.0, 0.6)] {
        let damping = Damping::critical(k, dt);
        assert!(matches!(damping.motion(k), Motion::Critical { .. }));
        assert!(matches!(damping.motion(1.001 * k), Motion::UnderDamped { .. }));
        assert!(matches!(damping.motion(0.999 * k), Motion::OverDamped { slow, fast } if slow > fast && fast > 0.0));
        // √k Δt above 1 flips the sign in every step; damping is critical again at the upper end of the oscillating
        // band.
        let stiff = (1.0 + damping.beta.sqrt()).powi(2) / damping.tau;
        assert!(matches!(damping.motion(stiff), Motion::Critical { eigenvalue } if eigenvalue < 0.0));
        assert!(matches!(damping.motion(1.001 * stiff), Motion::OverDamped { slow, .. } if slow < 0.0));
    }
    // For k Δt² = 1 the method converges in one step, theory.md, section 6.1.
    assert_eq!(Damping::critical(16.0, 0.25).motion(16.0), Motion::Critical { eigenvalue: 0.0 });
}

#[test]
fn a_central_damping_force_is_critical_at_its_own_coefficient() {
    for (k, dt) in [(0.7, 0.25), (0.01, 1.0), (2.5, 0.9)] {
        let gamma = Damping::central_critical(k, dt);
        let radius = |factor: f64| Damping::central(factor * gamma, dt).spectral_radius(k);
        assert!(radius(1.0) < radius(0.99) && radius(1.0) < radius(1.01));
        // The continuum limit is γ → 2 √k.
        assert_relative_eq!(Damping::central_critical(k, 1e-5), 2.0 * k.sqrt(), max_relative = 1e-9);
        assert_relative_eq!(Damping::critical(k, 1e-5).eta() * 1e-5, 2.0 * k.sqrt(), max_relative = 1e-4);
    }
}

/// No other pair (β, τ) is better over the whole band, theory.md, section 6.2.
#[test]
fn the_heavy_ball_optimum_is_one_in_both_parameters() {
    for (k_min, k_max) in [(1.0, 400.0), (0.01, 4.0), (0.3, 0.9)] {
        let best = Damping::optimal(k_min, k_max);
        let worst = |damping: Damping| damping.spectral_radius(k_min).max(damping.spectral_radius(k_max));
        let inside = |damping: Damping| {
            (0..=200)
                .map(|i| k_min * (k_max / k_min).powf(f64::from(i) / 200.0))
                .map(move |k| damping.spectral_radius(k))
        };
        for i in -20..=20 {
            for j in -20..=20 {
                let other = Damping {
                    beta: best.beta * (1.0 + 0.01 * f64::from(i)),
                    tau: best.tau * (1.0 + 0.01 * f64::from(j)),
                };
                if (i, j) != (0, 0) {
                    assert!(worst(other) > worst(best), "{other:?} beats {best:?}");
                }
                assert!(inside(other).all(|radius| radius <= worst(other) * (1.0 + 1e-12)));
            }
        }
    }
}

#[test]
fn optimal_is_critical_at_the_largest_useful_step() {
    let (k_min, k_max) = (0.02f64, 3.0f64);
    let dt = 2.0 / (k_min.sqrt() + k_max.sqrt());
    let (optimal, critical) = (Damping::optimal(k_min, k_max), Damping::critical(k_min, dt));
    assert_relative_eq!(optimal.beta, critical.beta, max_relative = 1e-14);
    assert_relative_eq!(optimal.tau, critical.tau, max_relative = 1e-14);
    // τ k_max = (1 + √β)².
    assert_relative_eq!(optimal.tau * k_max, (1.0 + optimal.beta.sqrt()).powi(2), max_relative = 1e-14);
    // With a single stiffness, one step suffices for any accuracy.
    assert!(Damping::optimal(3.0, 3.0).steps_per_decade(3.0, 3.0) < 0.1);
}

#[test]
fn unstable_steps_are_refused_with_the_limit() {
    let (k_min, k_max) = (0.05, 3.7);
    let limit = Damping::critical_dt_limit(k_min, k_max);
    assert!(Verlet::critical(k_min, k_max, 0.999_999 * limit).is_ok());
    match Verlet::critical(k_min, k_max, 1.000_001 * limit) {
        Err(RelaxError::TimeStep { found, allowed }) => {
            assert_eq!((found, allowed), (1.000_001 * limit, limit));
        }
        other => panic!("{other:?}"),
    }
    // At the closed-form limit, the stiffest mode becomes unstable under critical damping of the softest mode.
    assert_relative_eq!(Damping::critical(k_min, limit).spectral_radius(k_max), 1.0, max_relative = 1e-12);

    let undamped = Damping { beta: 0.999, tau: 4.0 / k_max };
    match Verlet::new(undamped, k_max) {
        Err(RelaxError::TimeStep { found, allowed }) => {
            assert_relative_eq!(found, undamped.tau.sqrt(), max_relative = 1e-15);
            assert_relative_eq!(allowed * allowed * k_max, 2.0 * 1.999, max_relative = 1e-14);
        }
        other => panic!("{other:?}"),
    }
    for damping in [
        Damping { beta: 1.0, tau: 0.1 },
        Damping { beta: -1.0, tau: 0.1 },
        Damping { beta: f64::NAN, tau: 0.1 },
        Damping { beta: 0.5, tau: 0.0 },
        Damping { beta: 0.5, tau: f64::INFINITY },
    ] {
        assert!(matches!(Verlet::new(damping, 1.0), Err(RelaxError::Parameter { .. })), "{damping:?}");
    }
    for (k_min, k_max) in [(0.0, 1.0), (-1.0, 1.0), (2.0, 1.0), (1.0, f64::NAN), (1.0, f64::INFINITY)] {
        assert!(matches!(Verlet::optimal(k_min, k_max), Err(RelaxError::Parameter { .. })));
        assert!(matches!(Verlet::critical(k_min, k_max, 0.1), Err(RelaxError::Parameter { .. })));
    }
    assert!(matches!(Verlet::critical(1.0, 2.0, -0.1), Err(RelaxError::Parameter { name: "the time step", .. })));
    let mut problem = Chain::modes(&[1.0]);
    for tau in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(Nesterov::new(tau), Err(RelaxError::Parameter { name: "the largest stiffness", .. })));
        let refused = [
            Nesterov { tau }.start(&mut problem, vec![0.0]).err(),
            ModeDamped::critical(tau, |_: &mut [f64]| ()).start(&mut problem, vec![0.0]).err(),
        ];
        for error in refused {
            assert!(matches!(error, Some(RelaxError::Parameter { name: "tau", .. })), "{error:?}");
        }
    }
}
