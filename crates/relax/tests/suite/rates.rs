//! Tests of convergence rates against theory.md, sections 6.1 and 6.2.

use approx::assert_relative_eq;
use gfmd_relax::{Damping, Landscape, Method, OnRise, Outcome, RelaxError, Stop, Verlet, relax};

use crate::support::{Chain, distance, scattered};

/// Measures the asymptotic factor per step of the largest error. Maxima over windows with equal numbers of steps are
/// compared, so that oscillations have no effect.
fn measured(verlet: Verlet, modes: &[f64], steps: usize) -> f64 {
    let mut problem = Chain::modes(modes);
    let n = problem.len();
    let mut state = verlet.start(&mut problem, scattered(n)).unwrap();
    let errors: Vec<f64> = (0..2 * steps)
        .map(|_| {
            verlet.step(&mut problem, &mut state).unwrap();
            distance(&state.u, &vec![0.0; n])
        })
        .collect();
    let window = steps / 4;
    let largest = |end: usize| errors[end - window..end].iter().copied().fold(0.0, f64::max);
    (largest(2 * steps) / largest(steps)).powf(1.0 / steps as f64)
}

fn unchecked(damping: Damping) -> Verlet {
    Verlet { damping, on_rise: OnRise::Continue }
}

/// Asserts that the decay exponents agree within 5 %. A double eigenvalue decays as n λⁿ and needs many steps.
fn assert_rate(verlet: Verlet, modes: &[f64], steps: usize) {
    let predicted = modes.iter().map(|&k| verlet.damping.spectral_radius(k)).fold(0.0, f64::max);
    let found = measured(verlet, modes, steps);
    assert_relative_eq!(found.ln(), predicted.ln(), max_relative = 0.05);
    // The planning functions predict the same number.
    let (k_min, k_max) = (modes[0], modes[modes.len() - 1]);
    let decade = verlet.damping.steps_per_decade(k_min, k_max);
    assert_relative_eq!(-f64::ln(10.0) / found.ln(), decade, max_relative = 0.06);
}

const MODES: [f64; 6] = [0.01, 0.03, 0.2, 0.7, 1.9, 4.0];

#[test]
fn critical_damping_of_the_softest_mode() {
    for dt in [0.25, 0.5, 0.9] {
        let verlet = Verlet::critical(0.01, 4.0, dt).unwrap();
        assert_relative_eq!(verlet.damping.spectral_radius(0.01), 1.0 - 0.1 * dt, max_relative = 1e-12);
        assert_rate(verlet, &MODES, 1200);
    }
}

#[test]
fn optimal_damping() {
    let verlet = Verlet::optimal(0.01, 4.0).unwrap();
    assert_relative_eq!(verlet.damping.spectral_radius(0.01), 19.0 / 21.0, max_relative = 1e-12);
    assert_rate(verlet, &MODES, 1200);
}

#[test]
fn too_much_and_too_little_damping() {
    let critical = Damping::critical(0.01, 0.8);
    for factor in [0.2, 0.5, 1.3, 3.0] {
        let damping = Damping { beta: 1.0 - factor * critical.eta() * critical.tau, ..critical };
        assert_rate(unchecked(damping), &MODES, 800);
        assert!(damping.spectral_radius(0.01) > critical.spectral_radius(0.01));
    }
}

#[test]
fn plain_descent_is_far_slower() {
    let plain = Damping::plain_descent(0.01, 4.0);
    assert_rate(unchecked(plain), &MODES, 4000);
    let (plain, optimal) = (plain.steps_per_decade(0.01, 4.0), Damping::optimal(0.01, 4.0).steps_per_decade(0.01, 4.0));
    // The predictions are κ/2 ln 10 and √κ/2 ln 10.
    assert!(plain > 19.0 * optimal, "{plain} {optimal}");
}

/// The oscillation has the angle of the eigenvalue: with Δu ∝ βⁿᐟ² cos(nθ + φ), zero crossings come every π/θ steps.
#[test]
fn an_underdamped_mode_oscillates_at_the_predicted_angle() {
    let damping = Damping { beta: 0.98, tau: 0.3 };
    let gfmd_relax::Motion::UnderDamped { angle, .. } = damping.motion(0.05) else { panic!("not underdamped") };
    let mut problem = Chain::modes(&[0.05, 0.05]);
    let verlet = unchecked(damping);
    let mut state = verlet.start(&mut problem, vec![1.0; 2]).unwrap();
    let (steps, mut crossings, mut last) = (5000, 0, 1.0);
    for _ in 0..steps {
        verlet.step(&mut problem, &mut state).unwrap();
        if state.u[0] * last < 0.0 {
            crossings += 1;
        }
        last = state.u[0];
    }
    let expected = f64::from(steps) * angle / std::f64::consts::PI;
    assert!((f64::from(crossings) - expected).abs() < 1.5, "{crossings} {expected}");
}

/// theory.md, section 6.1: v₊ = (1 − η Δt²) v + f Δt, u₊ = u + (Δt − η Δt³) v + f Δt².
#[test]
fn the_velocity_form_is_the_same_scheme() {
    let n = 30;
    let mut problem = Chain::springs(n, 0.05, |i| (i as f64).sin());
    let (k_min, k_max) = problem.band();
    let verlet = Verlet::critical(k_min, k_max, 0.6).unwrap();
    let (dt, eta) = (0.6f64, verlet.damping.eta());
    let mut state = verlet.start(&mut problem, scattered(n)).unwrap();
    let (mut u, mut v, mut f) = (scattered(n), vec![0.0; n], vec![0.0; n]);
    for _ in 0..400 {
        problem.force(&u, &mut f);
        for ((u, v), f) in u.iter_mut().zip(&mut v).zip(&f) {
            *u += (dt - eta * dt.powi(3)) * *v + f * dt * dt;
            *v = (1.0 - eta * dt * dt) * *v + f * dt;
        }
        verlet.step(&mut problem, &mut state).unwrap();
        assert!(distance(&u, &state.u) < 1e-12);
        let velocity: Vec<f64> = state.u.iter().zip(&state.memory.previous).map(|(u, w)| (u - w) / dt).collect();
        assert!(distance(&v, &velocity) < 1e-11);
    }
}

/// The energy of the accepted points never increases; far from critical damping the guard also saves steps.
#[test]
fn guarded_steps_never_rise() {
    let mut problem = Chain::springs(40, 0.01, |_| 0.1);
    let k_max = problem.band().1;
    let guarded = unchecked(Damping { beta: 0.995, tau: 1.6 / k_max }).guarded(k_max).unwrap();
    let mut state = guarded.start(&mut problem, scattered(40)).unwrap();
    let mut before = state.energy;
    for _ in 0..3000 {
        guarded.step(&mut problem, &mut state).unwrap();
        assert!(state.energy <= before + 1e-12 * state.energy_scale.max(before.abs()));
        before = state.energy;
    }
    let back = state.evaluations - state.step - 1;
    assert!(back > 3 && back < 500, "the test needs rises, found {back}");
    // This run is strongly underdamped, √β = 0.9975 per step; without a guard, it has not yet converged.
    let error = problem.residual(&state.u, &state.force);
    let free = unchecked(guarded.damping);
    let mut state = free.start(&mut problem, scattered(40)).unwrap();
    for _ in 0..3000 {
        free.step(&mut problem, &mut state).unwrap();
    }
    let free_error = problem.residual(&state.u, &state.force);
    assert!(error < 0.1 * free_error, "{error:e} {free_error:e}");
}

/// Landscape with a lowest energy of zero by cancellation, so that every increase near the end is due to rounding.
struct Lifted {
    chain: Chain,
    by: f64,
}

impl Landscape for Lifted {
    fn len(&self) -> usize {
        self.chain.len()
    }
    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        self.chain.force(u, force) + self.by
    }
    fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
        self.chain.residual(u, force)
    }
}

#[test]
fn rounding_does_not_hold_the_guard_up() {
    let chain = Chain::springs(40, 0.01, |_| 10.0);
    let (k_min, k_max) = chain.band();
    let lowest = -0.5 * chain.solution().iter().zip(&chain.load).map(|(u, b)| u * b).sum::<f64>();
    let mut problem = Lifted { chain, by: -lowest };
    let free = Verlet::critical(k_min, k_max, 0.6).unwrap();
    let stop = Stop { residual: 1e-10, settled: 0, max_steps: 2000 };
    let [free, guarded] = [free, free.guarded(k_max).unwrap()].map(|method| {
        let mut state = method.start(&mut problem, scattered(40)).unwrap();
        match relax(&mut problem, &method, &mut state, &stop, &mut ()) {
            Ok(Outcome::Converged(reached)) => reached.evaluations,
            other => panic!("{other:?}"),
        }
    });
    assert!(guarded < free * 5 / 4, "{guarded} evaluations, {free} without the guard");

    // Close to the minimum, rounding dominates the energy from the first step on; convergence is slow, but not lost.
    let guarded = Verlet::critical(k_min, k_max, 0.6).unwrap().guarded(k_max).unwrap();
    let near = problem.chain.solution().iter().zip(scattered(40)).map(|(u, s)| u + 1e-6 * s).collect();
    let mut state = guarded.start(&mut problem, near).unwrap();
    assert!(state.energy_scale < 1e-8, "{}", state.energy_scale);
    let stop = Stop { max_steps: 20_000, ..stop };
    assert!(matches!(relax(&mut problem, &guarded, &mut state, &stop, &mut ()), Ok(Outcome::Converged(_))));
}

/// The guard must step back: resting at the end of the step instead, u₋ ← u, lets a mode with 1 < τ k < 2 grow.
#[test]
fn resting_after_the_rise_is_no_safeguard() {
    let (beta, kappa) = (0.95, 1.4f64);
    assert!(Damping { beta, tau: kappa }.spectral_radius(1.0) < 1.0, "stable without the safeguard");
    let (mut u, mut previous) = (1.0f64, 1.0f64);
    for _ in 0..200 {
        let next = u + beta * (u - previous) - kappa * u;
        previous = if next.abs() > u.abs() { next } else { u };
        u = next;
    }
    assert!(u.abs() > 1e6, "{u}");
}

#[test]
fn the_guard_needs_a_short_time_step() {
    let k_max = 4.0;
    let optimal = Verlet::optimal(0.01, k_max).unwrap();
    match optimal.guarded(k_max) {
        Err(RelaxError::TimeStep { found, allowed }) => {
            assert_eq!(found, optimal.damping.tau.sqrt());
            assert_relative_eq!(allowed * allowed * k_max, 2.0, max_relative = 1e-14);
        }
        other => panic!("{other:?}"),
    }
    let short = Verlet::critical(0.01, k_max, 0.7).unwrap().guarded(k_max).unwrap();
    assert_eq!(short.on_rise, OnRise::StepBack);
}
