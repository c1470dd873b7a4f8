//! Contacts with a complex stiffness of each wave: certificate, threads, input.

use gfmd_contact::{Body, Boundary, Budget, Contact, Equilibrium as _, Fields as _, Grid, Hardness, Load, Material};
use gfmd_contact::{Refusal, SolveError, SteadyContact};
use ndarray::Array2;
use num_complex::Complex64;

fn contact(n: usize) -> Contact {
    let grid = Grid::square(n, 1.0).unwrap();
    let wave = |k: usize, i: usize| (std::f64::consts::TAU * (k * i) as f64 / n as f64 + 0.3 * k as f64).cos();
    let heights = Array2::from_shape_fn((n, n), |(i, j)| {
        (1..6).map(|k| 0.01 / k as f64 * (wave(k, i) + wave(k + 1, j) + wave(k, i + 2 * j))).sum::<f64>()
    });
    Contact::new(&Body::half_space(Material::from_young(1.0, 0.3).unwrap()), &grid, &heights).unwrap()
}

/// Returns the factors of a loss angle that all waves along x have.
fn lossy(contact: &Contact, degrees: f64) -> Vec<Complex64> {
    let of = |mode: gfmd_field::Mode| {
        let lead = if mode.nyquist[0] { 0.0 } else { mode.wavevector[0].signum() * f64::from(mode.number[0] != 0) };
        Complex64::from_polar(2.0, -lead * degrees.to_radians())
    };
    contact.surface().grid().modes().map(of).collect()
}

#[test]
fn the_state_is_certified_and_the_same_for_any_number_of_threads() {
    let contact = contact(64);
    let solve = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let steady = SteadyContact::new(&contact, lossy(&contact, 60.0)).unwrap();
            steady.equilibrate(Load::MeanPressure(0.01), &Budget::default(), None, &mut ()).unwrap()
        })
    };
    let [one, three] = [1, 3].map(solve);
    assert!(one.worst() <= 1e-8);
    assert_eq!(one, three);
}

#[test]
fn without_a_loss_it_is_the_contact_of_a_stiffer_body() {
    let contact = contact(32);
    let steady = SteadyContact::new(&contact, lossy(&contact, 0.0)).unwrap();
    let budget = Budget { tolerance: 1e-11, ..Budget::default() };
    let state = steady.equilibrate(Load::MeanPressure(0.02), &budget, None, &mut ()).unwrap();
    let fixed = contact.press(Load::MeanPressure(0.01)).tolerance(1e-11).solve().unwrap();
    approx::assert_relative_eq!(state.approach, fixed.approach, max_relative = 1e-9);
    let apart = (&state.pressure - &(2.0 * &fixed.pressure)).iter().fold(0.0_f64, |most, p| most.max(p.abs()));
    assert!(apart < 1e-8, "{apart:e}");
}

#[test]
fn unusable_input_is_refused() {
    let contact = contact(8);
    let refused = SteadyContact::new(&contact, lossy(&contact, 91.0)).unwrap_err();
    assert!(refused.to_string().contains("leads its displacement by 91.0 degrees; it must lead by less than 90"));
    assert!(matches!(SteadyContact::new(&contact, vec![Complex64::ONE; 3]), Err(Refusal::Start { .. })));
    let steady = SteadyContact::new(&contact, lossy(&contact, 10.0)).unwrap();
    let none = steady.equilibrate(Load::MeanPressure(-1.0), &Budget::default(), None, &mut ());
    assert!(matches!(none, Err(SolveError::Refused(Refusal::MeanPressure { .. }))));
    let few = Budget { max_iterations: 1, ..Budget::default() };
    let state = steady.equilibrate(Load::MeanPressure(0.01), &few, None, &mut ()).unwrap_err();
    assert!(matches!(state, SolveError::NotConverged { .. }));
    let free = Contact::with_boundary(
        Boundary::Free,
        &Body::half_space(Material::from_young(1.0, 0.3).unwrap()),
        contact.surface().grid(),
        &Array2::from_shape_fn((8, 8), |(i, j)| (i * j) as f64),
    );
    assert!(matches!(SteadyContact::new(&free.unwrap(), Vec::new()), Err(Refusal::OtherKind)));
}

/// At a hardness the pressure is bounded; far above the largest pressure it has no effect.
#[test]
fn a_hardness_bounds_the_pressure() {
    let contact = contact(32);
    let load = Load::MeanPressure(0.01);
    let solve = |contact: &Contact| {
        let steady = SteadyContact::new(contact, lossy(contact, 50.0)).unwrap();
        steady.equilibrate(load, &Budget::default(), None, &mut ()).unwrap()
    };
    let wall = solve(&contact);
    let most = wall.pressure.iter().copied().fold(0.0, f64::max);
    for part in [0.1, 0.3, 0.7, 2.0] {
        let hardness = (part * most).max(0.0101);
        let state = solve(&contact.clone().with_hardness(Hardness::Uniform(hardness)).unwrap());
        let plastic = state.plastic.as_ref().unwrap();
        assert!(state.worst() <= 1e-8 && state.pressure.iter().all(|p| *p <= hardness), "{part}");
        assert_eq!(plastic.fraction > 0.0, part < 1.0, "{part}");
        if part > 1.0 {
            approx::assert_relative_eq!(state.approach, wall.approach, max_relative = 1e-7);
        }
    }
}
