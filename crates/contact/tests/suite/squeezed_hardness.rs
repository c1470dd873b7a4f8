//! Slab between two rough surfaces with a hardness: a dense compliance, limits, identities, and refusals.

use std::f64::consts::TAU;

use gfmd_contact::{Contact, Equilibrium, Fields, Hardness, Load, MemoryCheckpoint, Refusal, Resumable, SolveError};
use gfmd_contact::{SqueezedContact, SqueezedSolution};
use gfmd_field::Grid;
use gfmd_green::{Base, Body, Material, Plate};
use gfmd_surface::{Discretisation, SelfAffine};
use ndarray::Array2;

const N: usize = 32;

fn heights(seed: u64) -> Array2<f64> {
    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: 4.0, eps_c_inv: 4.0 };
    let family = SelfAffine { hurst: 0.8, ..SelfAffine::with_rms_gradient(0.1) };
    numbers.self_affine(1.0, family).heights(&Grid::square(N, 1.0).unwrap(), seed).unwrap()
}

fn slab(poisson: f64, height: f64) -> Body {
    Body::slab(Material::from_contact_modulus(1.0, poisson).unwrap(), height).unwrap()
}

fn squeezed(body: &Body, upper: &Array2<f64>, lower: &Array2<f64>) -> SqueezedContact {
    SqueezedContact::new(body, &Grid::square(N, 1.0).unwrap(), upper, lower).unwrap()
}

fn solve(contact: &SqueezedContact, load: Load) -> SqueezedSolution {
    contact.press(load).tolerance(1e-11).solve().unwrap_or_else(|error| panic!("{load:?}: {error}"))
}

/// Returns the largest difference of two fields divided by the largest value of the second.
fn apart(found: &Array2<f64>, wanted: &Array2<f64>) -> f64 {
    let scale = wanted.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    found.iter().zip(wanted).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) / scale
}

/// Returns grains in stripes, the softest a tenth as hard as the hardest.
fn grains(hardness: f64) -> Array2<f64> {
    Array2::from_shape_fn((N, N), |(i, j)| hardness * [1.0, 0.1, 0.4][(i / 5 + j / 7) % 3])
}

fn highest(pressure: &Array2<f64>) -> f64 {
    pressure.iter().copied().fold(0.0, f64::max)
}

/// Compliance of both faces of a plate on a line as a matrix, by sums over waves.
fn dense(plate: &Plate, n: usize, length: f64) -> Vec<Vec<f64>> {
    let entry = |a: usize, b: usize| {
        let (face, other) = (a / n, b / n);
        let distance = (a % n) as f64 - (b % n) as f64;
        let waves = (0..n).map(|m| {
            let period = m.min(n - m);
            if m == 0 {
                let compliance = plate.compliance(0.0).squeezing;
                return 0.5 * compliance;
            }
            let found = plate.compliance(TAU * period as f64 / length);
            let sign = if face == 0 { 1.0 } else { -1.0 };
            let own = 0.5 * (found.squeezing + found.bending) + sign * found.mixed;
            let across = 0.5 * (found.squeezing - found.bending);
            (if face == other { own } else { across }) * (TAU * m as f64 * distance / n as f64).cos()
        });
        waves.sum::<f64>() / n as f64
    };
    (0..2 * n).map(|a| (0..2 * n).map(|b| entry(a, b)).collect()).collect()
}

/// The problem is convex, so that these conditions, with a dense compliance, hold for its solution alone.
#[test]
fn both_faces_meet_the_conditions_with_a_dense_compliance() {
    let n = 24;
    let line = Grid::line(n, 1.0).unwrap();
    let wave = |periods: f64, phase: f64| {
        Array2::from_shape_fn((n, 1), |(i, _)| {
            let x = TAU * i as f64 / n as f64;
            0.02 * (periods * x + phase).cos() + 0.004 * (5.0 * x).sin()
        })
    };
    let (upper, lower) = (wave(1.0, 0.0), wave(2.0, 1.0));
    let soft = Body::stack(
        &[(Material::from_young(1.0, 0.3).unwrap(), 0.1), (Material::from_young(3.0, 0.45).unwrap(), 0.1)],
        Base::BONDED,
    )
    .unwrap();
    let stripes = Array2::from_shape_fn((n, 1), |(i, _)| if i % 3 == 0 { 0.04 } else { 0.1 });
    for (body, hardness) in [
        (slab(0.3, 0.2), Hardness::Uniform(0.05)),
        (soft, Hardness::Uniform(0.08)),
        (slab(0.5, 0.4), Hardness::Field(stripes)),
    ] {
        let values: Vec<f64> = match &hardness {
            Hardness::Uniform(hardness) => vec![*hardness; 2 * n],
            Hardness::Field(field) => field.iter().chain(field).copied().collect(),
        };
        let contact = SqueezedContact::new(&body, &line, &upper, &lower).unwrap().with_hardness(hardness).unwrap();
        let plate = Plate::of(&body).unwrap();
        let matrix = dense(&plate, n, 1.0);
        let clearance: Vec<f64> = contact.surfaces().iter().flat_map(|surface| surface.clearance().to_vec()).collect();
        let [mut open, mut elastic, mut full] = [0; 3];
        for load in [Load::MeanPressure(0.01), Load::MeanPressure(0.035), Load::Approach(0.03)] {
            let found = solve(&contact, load);
            let faces = [&found.upper, &found.lower];
            let pressure: Vec<f64> = faces.iter().flat_map(|face| face.pressure.iter().copied()).collect();
            for i in 0..2 * n {
                let (face, at) = (faces[i / n], [i % n, 0]);
                let indentation: f64 = matrix[i].iter().zip(&pressure).map(|(c, p)| c * p).sum();
                let gap = clearance[i] + indentation - face.approach;
                let depth = face.plastic.as_ref().unwrap().depth[at];
                assert!((face.gap[at] - depth - gap).abs() < 1e-12, "{load:?} {i}: {gap}");
                if pressure[i] == 0.0 {
                    open += 1;
                    assert!(gap > -1e-11, "{load:?} {i}: {gap}");
                } else if pressure[i] < values[i] * (1.0 - 1e-14) {
                    elastic += 1;
                    assert!(pressure[i] > 0.0 && gap.abs() < 1e-9, "{load:?} {i}: {gap}");
                } else {
                    full += 1;
                    assert!(pressure[i] <= values[i] * (1.0 + 1e-14) && gap < 1e-11, "{load:?} {i}: {gap}");
                }
            }
            let means = [0, n].map(|start| pressure[start..start + n].iter().sum::<f64>() / n as f64);
            assert!(
                (means[0] - means[1]).abs() < 1e-12
                    && (found.approach - faces[0].approach - faces[1].approach).abs() < 1e-13
            );
            match load {
                Load::MeanPressure(mean) => assert!((means[0] - mean).abs() < 1e-12),
                Load::Approach(approach) => assert_eq!(found.approach, approach),
            }
        }
        assert!(open > 0 && elastic > 0 && full > 0, "{open} {elastic} {full}");
    }
}

#[test]
fn every_load_up_to_the_hardness_converges() {
    for (body, most) in [(slab(0.3, 0.06), 400), (slab(0.5, 0.2), 120), (slab(0.0, 2.0), 60)] {
        for hardness in [0.002, 0.05, 0.5].map(Hardness::Uniform).into_iter().chain([Hardness::Field(grains(0.05))]) {
            let mean = hardness.mean();
            let contact = squeezed(&body, &heights(1), &heights(2)).with_hardness(hardness.clone()).unwrap();
            for share in [0.01, 0.1, 0.5, 0.9, 0.99] {
                let state = contact.press(Load::MeanPressure(share * mean)).solve();
                let state = state.unwrap_or_else(|error| panic!("{mean} {share}: {error}"));
                assert!(state.worst() <= 1e-8);
                assert!(state.effort.iterations <= most, "{mean} {share}: {}", state.effort);
                for face in [&state.upper, &state.lower] {
                    let plastic = face.plastic.as_ref().unwrap();
                    let carried = face.pressure.indexed_iter().all(|(at, p)| match &hardness {
                        Hardness::Uniform(hardness) => p <= hardness,
                        Hardness::Field(field) => *p <= field[at],
                    });
                    assert!(
                        carried && (plastic.depth.mean().unwrap() - plastic.volume).abs() <= 1e-13 * plastic.volume
                    );
                }
            }
        }
    }
}

#[test]
fn a_hardness_that_is_not_reached_changes_nothing_but_rounding() {
    let contact = squeezed(&slab(0.3, 0.1), &heights(3), &heights(4));
    for load in [Load::MeanPressure(0.01), Load::Approach(0.02)] {
        let wall = solve(&contact, load);
        let above = 1.5 * highest(&wall.upper.pressure).max(highest(&wall.lower.pressure));
        let hard = solve(&contact.clone().with_hardness(above).unwrap(), load);
        for (face, wall) in [(&hard.upper, &wall.upper), (&hard.lower, &wall.lower)] {
            assert!(apart(&face.pressure, &wall.pressure) < 1e-8);
            let plastic = face.plastic.as_ref().unwrap();
            assert_eq!((plastic.fraction, plastic.volume, plastic.saturation), (0.0, 0.0, 0.0));
        }
    }
}

/// The mid-plane is a mirror: it does not move and bears no shear.
#[test]
fn mirror_images_are_one_surface_on_a_sliding_base_of_half_the_height() {
    let surface = heights(1);
    for (poisson, height) in [(0.3, 0.08), (0.5, 0.5)] {
        let body = slab(poisson, 0.5 * height).on(Base::SLIDING).unwrap();
        for hardness in [Hardness::Uniform(0.1), Hardness::Field(grains(0.2))] {
            let both = squeezed(&slab(poisson, height), &surface, &surface).with_hardness(hardness.clone()).unwrap();
            let one = Contact::new(&body, &Grid::square(N, 1.0).unwrap(), &surface).unwrap();
            let one = one.with_hardness(hardness).unwrap();
            for load in [Load::MeanPressure(0.003), Load::MeanPressure(0.03)] {
                let found = solve(&both, load);
                let wanted = one.press(load).tolerance(1e-11).solve().unwrap();
                let plastic = wanted.plastic.as_ref().unwrap();
                for face in [&found.upper, &found.lower] {
                    assert!(apart(&face.pressure, &wanted.pressure) < 1e-8);
                    assert!(apart(&face.gap, &wanted.gap) < 1e-8);
                    let found = face.plastic.as_ref().unwrap();
                    assert_eq!(found.fraction, plastic.fraction);
                    assert!((found.volume - plastic.volume).abs() < 1e-9 * wanted.approach);
                }
                assert!((found.approach - 2.0 * wanted.approach).abs() < 1e-8 * wanted.approach);
                let again = solve(&both, Load::Approach(found.approach));
                assert!(apart(&again.lower.pressure, &wanted.pressure) < 1e-7);
            }
        }
    }
}

#[test]
fn residuals_are_those_of_the_fields() {
    let contact = squeezed(&slab(0.3, 0.1), &heights(3), &heights(4)).with_hardness(0.05).unwrap();
    for load in [Load::MeanPressure(0.02), Load::Approach(0.03)] {
        let mut state = solve(&contact, load);
        let again = contact.certify([&state.upper.pressure, &state.lower.pressure], load).unwrap();
        assert_eq!((&again.upper.plastic, &again.lower.plastic), (&state.upper.plastic, &state.lower.plastic));
        assert_eq!(again.residuals(), state.residuals());
        assert!(state.residuals().iter().any(|(name, _)| *name == "saturation"));
        for (face, surface) in [(&state.upper, heights(3)), (&state.lower, heights(4))] {
            let top = highest(&surface);
            let distance = surface.mapv(|h| top - h) - &face.displacement - face.approach;
            let depth = &face.plastic.as_ref().unwrap().depth;
            assert!(highest(depth) > 0.0 && apart(&(&face.gap - depth), &distance) < 1e-9);
        }
        // A pressure beyond the hardness on one face alone is not certified.
        let beyond = &state.lower.pressure * 1.01;
        assert!(contact.certify([&state.upper.pressure, &beyond], load).unwrap().worst() > 0.009);
        // The pressures keep the state.
        let mut kept = MemoryCheckpoint::default();
        contact.keep(&mut state, &mut kept);
        kept.rewind();
        let restored = contact.restore(load.into(), &mut kept).unwrap();
        assert_eq!((restored.upper.plastic, restored.lower.plastic), (state.upper.plastic, state.lower.plastic));
    }
}

#[test]
fn an_approach_beyond_full_contact_saturates_both_faces() {
    // Of an incompressible slab the mean gap is fixed: beyond it all points yield.
    let contact = squeezed(&slab(0.5, 0.1), &heights(1), &heights(2));
    let full: f64 = contact.surfaces().iter().map(|surface| surface.mean_clearance()).sum();
    assert!(contact.press(Load::Approach(1.1 * full)).solve().is_err());
    let contact = contact.with_hardness(0.05).unwrap();
    let state = contact.press(Load::Approach(3.0 * full)).solve().unwrap();
    for face in [&state.upper, &state.lower] {
        assert!(face.pressure.iter().all(|p| *p == 0.05), "{:?}", face.residual);
    }
    assert!((state.upper.mean_pressure - 0.05).abs() < 1e-12);
}

#[test]
fn units_threads_and_starts_change_nothing() {
    let (upper, lower) = (heights(7), heights(8));
    let contact = squeezed(&slab(0.3, 0.1), &upper, &lower).with_hardness(grains(0.2)).unwrap();
    let one = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| contact.press(Load::MeanPressure(0.01)).solve().unwrap())
    };
    let state = one(1);
    assert_eq!(state, one(3));
    let (length, stress) = (2.0_f64.powi(-110), 2.0_f64.powi(120));
    let body = Body::slab(Material::from_contact_modulus(stress, 0.3).unwrap(), 0.1 * length).unwrap();
    let grid = Grid::square(N, length).unwrap();
    let small = SqueezedContact::new(&body, &grid, &(&upper * length), &(&lower * length)).unwrap();
    let small = small.with_hardness(grains(0.2 * stress)).unwrap();
    assert_eq!(small.hardness(), Some(Hardness::Field(grains(0.2 * stress))));
    let scaled = small.press(Load::MeanPressure(0.01 * stress)).solve().unwrap();
    assert!(apart(&(&scaled.lower.pressure / stress), &state.lower.pressure) < 1e-7);
    let [found, wanted] = [&scaled, &state].map(|state| state.lower.plastic.as_ref().unwrap());
    assert_eq!(found.fraction, wanted.fraction);
    assert!((found.volume / length - wanted.volume).abs() < 1e-6 * wanted.volume);
    // A start of another load, without or with lower hardness.
    let wall = squeezed(&slab(0.3, 0.1), &upper, &lower).press(Load::MeanPressure(0.02)).solve().unwrap();
    for load in [Load::MeanPressure(0.01), Load::Approach(state.approach)] {
        let further = contact.press(load).tolerance(1e-11).starting_from(Some(&wall)).solve().unwrap();
        let fresh = contact.press(load).tolerance(1e-11).solve().unwrap();
        assert!(apart(&further.upper.pressure, &fresh.upper.pressure) < 1e-7);
    }
}

#[test]
fn what_cannot_be_done_is_refused() {
    let contact = squeezed(&slab(0.3, 0.1), &heights(1), &heights(2));
    for hardness in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(contact.clone().with_hardness(hardness), Err(Refusal::Hardness { .. })), "{hardness}");
    }
    let wrong = contact.clone().with_hardness(Array2::from_elem((4, 4), 1.0));
    assert!(matches!(wrong, Err(Refusal::HardnessShape { .. })));
    let contact = contact.with_hardness(0.1).unwrap();
    let error = contact.press(Load::MeanPressure(0.1)).solve().unwrap_err();
    assert!(matches!(error, SolveError::Refused(Refusal::BeyondHardness { .. })), "{error}");
}
