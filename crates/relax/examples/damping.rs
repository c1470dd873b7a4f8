//! Damped relaxation, predicted and measured: springs of stiffness 1 to 400 are displaced and released with several
//! dampings, relative to the critical damping of the softest spring.
//!
//! The softest mode determines the time. With its critical damping, all stiffer modes oscillate, but decay at the same
//! rate. Half or twice this damping is slower (theory.md, sections 6.1 and 6.2).
//!
//! ```text
//! cargo run --release -p gfmd-relax --example damping
//! ```

#![expect(clippy::print_stdout, reason = "an example")]

use gfmd_relax::{Damping, Harmonic, Method, Motion, RelaxError, Verlet};

/// Time step divided by the stability limit without damping.
const TIME_STEP: f64 = 0.25;

/// Number of steps for measuring a rate; in the second half the amplitude decays by some decades.
const STEPS: u32 = 1000;

fn main() -> Result<(), RelaxError> {
    let springs: Vec<f64> = (1..=20).map(|i| f64::from(i * i)).collect();
    let (softest, stiffest) = (springs[0], springs[19]);
    let dt = Damping::time_step(TIME_STEP, stiffest)?;
    println!(
        "{:>7} {:>14} {:>12} {:>10} {:>10} {:>8}",
        "factor", "softest mode", "oscillating", "predicted", "found", "to 1e-8"
    );
    for factor in [0.2, 0.5, 1.0, 2.0, 5.0] {
        let damping = Damping::times_critical(factor, softest, stiffest, dt)?;
        let verlet = Verlet::new(damping, stiffest)?;
        let product = |u: &[f64], out: &mut [f64]| {
            out.iter_mut().zip(u).zip(&springs).for_each(|((out, u), spring)| *out = spring * u);
        };
        let mut landscape = Harmonic::new(springs.len(), product);
        let mut state = verlet.start(&mut landscape, vec![1.0; springs.len()])?;
        let mut history = Vec::new();
        for _ in 0..STEPS {
            verlet.step(&mut landscape, &mut state)?;
            history.push(state.u[0].abs());
        }
        // Largest amplitudes of the second and the last quarter, half of the steps apart.
        let quarter = history.len() / 4;
        let largest = |part: &[f64]| part.iter().fold(0.0_f64, |most, u| most.max(*u));
        let ratio = largest(&history[3 * quarter..]) / largest(&history[quarter..2 * quarter]);
        let regime = match damping.motion(softest) {
            Motion::UnderDamped { .. } => "under-damped",
            Motion::Critical { .. } => "critical",
            Motion::OverDamped { .. } => "over-damped",
        };
        let oscillates = |spring: &&f64| matches!(damping.motion(**spring), Motion::UnderDamped { .. });
        println!(
            "{factor:>7} {regime:>14} {:>11.0}% {:>10.6} {:>10.6} {:>8}",
            100.0 * springs.iter().filter(oscillates).count() as f64 / springs.len() as f64,
            damping.spectral_radius(softest),
            ratio.powf(1.0 / (2 * quarter) as f64),
            damping.steps_to(softest, 1e-8).map_or_else(|| "never".into(), |steps| steps.to_string()),
        );
    }
    Ok(())
}
