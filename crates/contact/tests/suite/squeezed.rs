//! Slab between two rough surfaces: limits that are contacts of one surface, exact identities, and refusals.

use gfmd_contact::{
    Budget, Contact, Equilibrium, Fields, Load, MemoryCheckpoint, Refusal, Resumable, SolveError, Solver,
    SqueezedContact, SqueezedSolution,
};
use gfmd_field::Grid;
use gfmd_green::{Base, Body, Material};
use gfmd_surface::{Discretisation, SelfAffine};
use ndarray::Array2;

const N: usize = 32;

fn grid() -> Grid {
    Grid::square(N, 1.0).unwrap()
}

fn heights(seed: u64) -> Array2<f64> {
    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: 4.0, eps_c_inv: 4.0 };
    numbers
        .self_affine(1.0, SelfAffine { hurst: 0.8, ..SelfAffine::with_rms_gradient(0.1) })
        .heights(&grid(), seed)
        .unwrap()
}

fn slab(poisson: f64, height: f64) -> Body {
    Body::slab(Material::from_contact_modulus(1.0, poisson).unwrap(), height).unwrap()
}

fn squeezed(body: &Body, upper: &Array2<f64>, lower: &Array2<f64>) -> SqueezedContact {
    SqueezedContact::new(body, &grid(), upper, lower).unwrap()
}

fn solve(contact: &SqueezedContact, load: Load) -> SqueezedSolution {
    contact.press(load).tolerance(1e-11).solve().unwrap()
}

/// Returns the largest difference of two fields divided by the largest value of the second.
fn apart(found: &Array2<f64>, wanted: &Array2<f64>) -> f64 {
    let scale = wanted.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    found.iter().zip(wanted).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / scale
}

fn assert_near(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance * wanted.abs(), "{found} {wanted}");
}

/// The mid-plane is a mirror: it does not move and bears no shear.
#[test]
fn mirror_images_are_one_surface_on_a_sliding_base_of_half_the_height() {
    let surface = heights(1);
    for (poisson, height) in [(0.3, 0.08), (0.5, 0.5)] {
        let both = squeezed(&slab(poisson, height), &surface, &surface);
        let body = slab(poisson, 0.5 * height).on(Base::SLIDING).unwrap();
        let one = Contact::new(&body, &grid(), &surface).unwrap();
        for load in [Load::MeanPressure(0.003), Load::MeanPressure(0.03)] {
            let found = solve(&both, load);
            let wanted = one.press(load).tolerance(1e-11).solve().unwrap();
            for face in [&found.upper, &found.lower] {
                assert!(apart(&face.pressure, &wanted.pressure) < 1e-8);
                assert!(apart(&face.gap, &wanted.gap) < 1e-8);
                assert!(apart(&face.displacement, &wanted.displacement) < 1e-8);
                assert_near(face.approach, wanted.approach, 1e-9);
            }
            assert_near(found.approach, 2.0 * wanted.approach, 1e-9);
            let again = solve(&both, Load::Approach(found.approach));
            assert!(apart(&again.upper.pressure, &wanted.pressure) < 1e-7);
        }
    }
}

/// A flat surface stays in contact with a slab that is thick enough, and acts as a sliding base.
#[test]
fn a_flat_surface_is_a_sliding_base() {
    let (surface, flat) = (heights(2), Array2::zeros((N, N)));
    let both = squeezed(&slab(0.2, 0.6), &surface, &flat);
    let body = slab(0.2, 0.6).on(Base::SLIDING).unwrap();
    let one = Contact::new(&body, &grid(), &surface).unwrap();
    let load = Load::MeanPressure(0.02);
    let (found, wanted) = (solve(&both, load), one.press(load).tolerance(1e-11).solve().unwrap());
    assert!(found.lower.pressure.iter().all(|p| *p > 0.0));
    assert!(apart(&found.upper.pressure, &wanted.pressure) < 1e-8);
    assert!(apart(&found.upper.gap, &wanted.gap) < 1e-8);
    assert_near(found.approach, wanted.approach, 1e-9);
    // Nothing but the two surfaces holds the slab, so that its base does not matter, and it may lie the other way
    // round.
    let turned = solve(&squeezed(&body, &flat, &surface), load);
    assert!(apart(&turned.lower.pressure, &found.upper.pressure) < 1e-8);
    assert_near(turned.approach, found.approach, 1e-9);
}

/// Faces without lateral displacement have the same symmetry; the plane between them bears no shear.
#[test]
fn held_mirror_images_are_one_held_surface_on_a_sliding_base_of_half_the_height() {
    let surface = heights(1);
    for (poisson, height) in [(0.3, 0.08), (0.5, 0.5)] {
        let both = SqueezedContact::held_sideways(&slab(poisson, height), &grid(), &surface, &surface).unwrap();
        let body = slab(poisson, 0.5 * height).on(Base::SLIDING).unwrap();
        let one = Contact::held_sideways(&body, &grid(), &surface).unwrap();
        for load in [Load::MeanPressure(0.003), Load::MeanPressure(0.03)] {
            let found = solve(&both, load);
            let wanted = one.press(load).tolerance(1e-11).solve().unwrap();
            for face in [&found.upper, &found.lower] {
                assert!(apart(&face.pressure, &wanted.pressure) < 1e-8);
                assert!(apart(&face.gap, &wanted.gap) < 1e-8);
            }
            assert_near(found.approach, 2.0 * wanted.approach, 1e-9);
            let again = solve(&both, Load::Approach(found.approach));
            assert!(apart(&again.upper.pressure, &wanted.pressure) < 1e-7);
        }
    }
}

/// Held faces of a thick slab are two half-spaces that are held; a stiffer face has less contact.
#[test]
fn a_thick_slab_that_is_held_has_two_held_contacts() {
    let surfaces = [heights(1), heights(2)];
    let material = Material::from_contact_modulus(1.0, 0.1).unwrap();
    let load = Load::MeanPressure(0.01);
    let squeezed = SqueezedContact::held_sideways(&slab(0.1, 4.0), &grid(), &surfaces[0], &surfaces[1]).unwrap();
    let found = solve(&squeezed, load);
    for (face, surface) in [(&found.upper, &surfaces[0]), (&found.lower, &surfaces[1])] {
        let alone = Contact::held_sideways(&Body::half_space(material), &grid(), surface).unwrap();
        let alone = alone.press(load).tolerance(1e-11).solve().unwrap();
        assert!(apart(&face.pressure, &alone.pressure) < 1e-8);
    }
}

/// The faces of a slab higher than its cell interact only by e^(−q height).
#[test]
fn a_thick_slab_has_two_contacts_of_half_spaces() {
    let surfaces = [heights(1), heights(2)];
    let half_space = Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap());
    let load = Load::MeanPressure(0.01);
    let alone = surfaces.each_ref().map(|surface| {
        Contact::new(&half_space, &grid(), surface).unwrap().press(load).tolerance(1e-11).solve().unwrap()
    });
    let difference = |height: f64| {
        let found = solve(&squeezed(&slab(0.0, height), &surfaces[0], &surfaces[1]), load);
        let [upper, lower] = [(&found.upper, &alone[0]), (&found.lower, &alone[1])]
            .map(|(face, alone)| apart(&face.pressure, &alone.pressure));
        upper.max(lower)
    };
    let [thin, middle, thick] = [0.4, 0.8, 4.0].map(difference);
    assert!(thick < 1e-8, "{thick:e}");
    // The longest wave has q = 2π.
    let rate = (thin / middle).ln() / 0.4;
    assert!((0.5..1.5).contains(&(rate / std::f64::consts::TAU)), "{rate} from {thin:e} {middle:e}");
}

#[test]
fn forces_balance_and_residuals_are_those_of_the_fields() {
    let (upper, lower) = (heights(3), heights(4));
    let body = Body::stack(
        &[(Material::from_young(1.0, 0.3).unwrap(), 0.05), (Material::from_young(3.0, 0.45).unwrap(), 0.04)],
        Base::BONDED,
    )
    .unwrap();
    let contact = squeezed(&body, &upper, &lower);
    for load in [Load::MeanPressure(0.002), Load::MeanPressure(0.05), Load::Approach(0.03)] {
        let state = solve(&contact, load);
        let again = contact.certify([&state.upper.pressure, &state.lower.pressure], load).unwrap();
        assert_eq!(again.residual(), state.residual());
        assert_eq!((&again.upper.gap, &again.lower.gap), (&state.upper.gap, &state.lower.gap));
        assert!(state.worst() <= 1e-11, "{}", state.worst());
        assert_near(state.lower.mean_pressure, state.upper.mean_pressure, 1e-12);
        assert_near(state.upper.approach + state.lower.approach, state.approach, 1e-14);
        // Displacements are measured from the level at which their means are opposite.
        let [u, v] = [&state.upper, &state.lower].map(|face| face.displacement.mean().unwrap());
        assert_near(u, v, 1e-9);
        // gap = clearance - approach - u on either face, each as seen from its own side.
        for (face, surface) in [(&state.upper, &upper), (&state.lower, &lower)] {
            let highest = surface.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let gap = surface.mapv(|h| highest - h) - &face.displacement - face.approach;
            assert!(apart(&face.gap, &gap) < 1e-9);
        }
        // A larger pressure on one face alone breaks the equilibrium.
        let mut wrong = state.upper.pressure.clone();
        wrong *= 1.001;
        let judged = contact.certify([&wrong, &state.lower.pressure], load).unwrap();
        assert!(judged.residual().load > 5e-4, "{:?}", judged.residual());
    }
}

#[test]
fn the_approach_of_a_load_gives_the_load() {
    for (poisson, height) in [(0.0, 0.05), (0.5, 0.2), (0.3, 3.0)] {
        let contact = squeezed(&slab(poisson, height), &heights(5), &heights(6));
        for mean in [1e-4, 1e-2] {
            let pressed = solve(&contact, Load::MeanPressure(mean));
            let approached = solve(&contact, Load::Approach(pressed.approach));
            assert_near(approached.upper.mean_pressure, mean, 1e-6);
            assert_near(approached.lower.mean_pressure, approached.upper.mean_pressure, 1e-12);
        }
    }
}

/// The number of iterations is low unless the slab is very thin.
#[test]
fn thin_and_thick_slabs_take_few_iterations() {
    for (height, most) in [(1.0 / 32.0, 400), (0.125, 60), (0.5, 25), (10.0, 20)] {
        let contact = squeezed(&slab(0.3, height), &heights(1), &heights(2));
        for p_star in [0.001, 0.05, 0.5] {
            let state = contact.press(Load::MeanPressure(0.1 * p_star)).solve().unwrap();
            assert!(state.effort.iterations <= most, "{height}, {p_star}: {}", state.effort);
            let surfaces = [heights(1), heights(2)];
            let held = SqueezedContact::held_sideways(&slab(0.3, height), &grid(), &surfaces[0], &surfaces[1]);
            let state = held.unwrap().press(Load::MeanPressure(0.1 * p_star)).solve().unwrap();
            assert!(state.effort.iterations <= most, "held {height}, {p_star}: {}", state.effort);
        }
    }
}

#[test]
fn profiles_and_grids_that_are_not_square_are_solved() {
    let line = Grid::line(60, 2.0).unwrap();
    let wave = |periods: f64, phase: f64| {
        Array2::from_shape_fn((60, 1), |(i, _)| {
            let x = std::f64::consts::TAU * i as f64 / 60.0;
            0.02 * (periods * x + phase).cos() + 0.004 * (7.0 * x).sin()
        })
    };
    let contact = SqueezedContact::new(&slab(0.3, 0.1), &line, &wave(2.0, 0.0), &wave(3.0, 1.0)).unwrap();
    assert!(solve(&contact, Load::MeanPressure(0.01)).worst() <= 1e-11);
    let odd = Grid::new([15, 20], [1.0, 1.7]).unwrap();
    let bumps = |k: usize| Array2::from_shape_fn((15, 20), |(i, j)| 0.01 * ((k * i * i + 3 * j) % 11) as f64);
    let contact = SqueezedContact::new(&slab(0.3, 0.1), &odd, &bumps(1), &bumps(2)).unwrap();
    assert!(solve(&contact, Load::Approach(0.05)).worst() <= 1e-11);
}

#[test]
fn units_and_threads_change_nothing() {
    let (upper, lower) = (heights(7), heights(8));
    let contact = squeezed(&slab(0.3, 0.07), &upper, &lower);
    let one = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| contact.press(Load::MeanPressure(0.01)).solve().unwrap())
    };
    let state = one(1);
    assert_eq!(state, one(3));
    // Powers of two beyond the ordinary sizes.
    let (length, stress) = (2.0_f64.powi(-110), 2.0_f64.powi(120));
    let grid = Grid::square(N, length).unwrap();
    let material = Material::from_contact_modulus(stress, 0.3).unwrap();
    let body = Body::slab(material, 0.07 * length).unwrap();
    let small = SqueezedContact::new(&body, &grid, &(&upper * length), &(&lower * length)).unwrap();
    let scaled = small.press(Load::MeanPressure(0.01 * stress)).solve().unwrap();
    assert!(apart(&(&scaled.upper.pressure / stress), &state.upper.pressure) < 1e-7);
    assert_near(scaled.approach / length, state.approach, 1e-7);
}

#[test]
fn a_state_is_kept_and_restored_and_is_a_start() {
    let contact = squeezed(&slab(0.3, 0.05), &heights(1), &heights(3));
    let load = Load::MeanPressure(0.01);
    let mut state = contact.press(load).solve().unwrap();
    let mut checkpoint = MemoryCheckpoint::default();
    contact.keep(&mut state, &mut checkpoint);
    checkpoint.rewind();
    let restored = contact.restore(load.into(), &mut checkpoint).unwrap();
    assert!(restored.upper.pressure == state.upper.pressure && restored.lower.pressure == state.lower.pressure);
    assert_eq!((restored.effort, restored.approach), (state.effort, state.approach));
    let further = contact.press(Load::MeanPressure(0.011)).starting_from(Some(&state)).solve().unwrap();
    let fresh = contact.press(Load::MeanPressure(0.011)).solve().unwrap();
    assert!(apart(&further.upper.pressure, &fresh.upper.pressure) < 1e-5);
}

#[test]
fn unusable_input_is_refused() {
    let (upper, flat) = (heights(1), Array2::zeros((N, N)));
    let refused = |body: &Body, upper: &Array2<f64>, lower: &Array2<f64>| {
        SqueezedContact::new(body, &grid(), upper, lower).unwrap_err()
    };
    let material = Material::from_young(1.0, 0.3).unwrap();
    assert!(matches!(refused(&Body::half_space(material), &upper, &upper), Refusal::Body(_)));
    assert!(matches!(refused(&slab(0.3, 0.1), &flat, &flat), Refusal::Flat));
    assert!(matches!(refused(&slab(0.3, 0.1), &upper, &Array2::zeros((4, 4))), Refusal::Shape { .. }));
    let mut hole = upper.clone();
    hole[[3, 4]] = f64::NAN;
    assert!(matches!(refused(&slab(0.3, 0.1), &upper, &hole), Refusal::Height { index: [3, 4], .. }));

    let contact = squeezed(&slab(0.5, 0.1), &upper, &heights(2));
    let solve = |load: Load| contact.press(load).solve().unwrap_err();
    for load in [0.0, -1.0, f64::NAN] {
        assert!(matches!(solve(Load::MeanPressure(load)), SolveError::Refused(Refusal::MeanPressure { .. })), "{load}");
        assert!(matches!(solve(Load::Approach(load)), SolveError::Refused(Refusal::Approach { .. })), "{load}");
    }
    // Full contact on both faces of an incompressible slab.
    let full: f64 = contact.surfaces().iter().map(|surface| surface.mean_clearance()).sum();
    assert!(matches!(solve(Load::Approach(full)), SolveError::Refused(Refusal::Approach { limit: Some(_), .. })));
    assert!(contact.press(Load::Approach(0.9 * full)).solve().is_ok());
    assert!(matches!(solve(Load::MeanPressure(1e30)), SolveError::Refused(Refusal::Rounding { .. })));
    let other = contact.press(Load::MeanPressure(0.01)).solver(Solver::Verlet).solve().unwrap_err();
    assert!(matches!(other, SolveError::Refused(Refusal::Solver { .. })));
    let few = Budget { tolerance: 1e-12, max_iterations: 3 };
    let unmet = contact.press(Load::MeanPressure(0.01)).budget(few).solve().unwrap_err();
    assert!(
        matches!(&unmet, SolveError::NotConverged { .. }) && unmet.state().is_some_and(|state| state.worst() > 1e-12)
    );
}
