//! Contacts made of several parts in limits where some of the parts have no effect, or a known one.

use approx::assert_relative_eq;
use gfmd_contact::{Boundary, Budget, Contact, Drive, Equilibrium as _, Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Parts, Path, QuasistaticContact, QuasistaticState, Refinement, Wear};
use gfmd_law::Limit;
use gfmd_medium::{Prony, Relaxes};
use ndarray::Array2;

use crate::{material, rough};

const HARDNESS: f64 = 0.2;

fn follow(parts: &Parts, drives: &[Drive]) -> Vec<QuasistaticState> {
    let contact = QuasistaticContact::new(parts).unwrap();
    let mut states: Vec<QuasistaticState> = Vec::new();
    for drive in drives {
        states.push(contact.press(*drive).tolerance(1e-10).starting_from(states.last()).solve().unwrap());
    }
    states
}

/// Returns the largest difference of the pressures, divided by the largest pressure.
fn apart(a: &QuasistaticState, b: &QuasistaticState) -> f64 {
    let (a, b) = (a.pressure(), b.pressure());
    let most = b.iter().fold(0.0, |most: f64, p| most.max(p.abs()));
    a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / most
}

fn problem() -> (Body, Grid, Array2<f64>) {
    // On an even grid, Nyquist modes have another stiffness with all components.
    let grid = Grid::square(15, 1.0).unwrap();
    let heights = rough(&grid, 2);
    (Body::half_space(material(0.3)), grid, heights)
}

/// Returns drives that load, hold and unload, while the surfaces slide on.
fn drives() -> Vec<Drive> {
    [(0.01, 0.0), (0.04, 0.5), (0.04, 3.0), (0.01, 3.5), (0.03, 10.0)]
        .map(|(mean, time)| Drive::from(Load::MeanPressure(mean)).at(time).after(0.1 * time))
        .to_vec()
}

#[test]
fn a_hardness_limits_the_pressure_of_a_body_that_relaxes() {
    let (body, grid, heights) = problem();
    let prony = Prony::from_fractions(&[(1.3, 0.6)]).unwrap();
    for boundary in Boundary::ALL {
        let plain = Parts { boundary, ..Parts::new(&body, &grid, &heights) };
        let parts =
            Parts { hardness: Some(HARDNESS.into()), relaxation: Some((&prony, Relaxes::Both)), ..plain.clone() };
        let states = follow(&parts, &drives());
        for pair in states.windows(2) {
            let [before, after] = [0, 1].map(|k| pair[k].plastic_depth().unwrap());
            assert!(pair[1].pressure().iter().all(|p| *p <= HARDNESS * (1.0 + 1e-9)), "{boundary}");
            assert!(before.iter().zip(after).all(|(before, after)| after >= before), "{boundary}");
            assert!(pair[1].losses.relaxation > 0.0 && pair[1].losses.plastic >= 0.0, "{boundary}");
        }
        assert!(states[1].losses.plastic > 0.0 && states[1].plastic_fraction > 0.0, "{boundary}");
        // At once the body has its instantaneous moduli, larger by 1/(1 − 0.6).
        let stiff = Body::half_space(Material::from_young(5.0, 0.3).unwrap());
        let at_once = [Load::MeanPressure(0.04).into()];
        let [found] = &follow(&parts, &at_once)[..] else { panic!() };
        let expected =
            Contact::with_boundary(boundary, &stiff, &grid, &heights).unwrap().with_hardness(HARDNESS).unwrap();
        let expected = expected.press(Load::MeanPressure(0.04)).tolerance(1e-10).solve().unwrap();
        let worst = found.pressure().iter().zip(&expected.pressure).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst <= 1e-7 * HARDNESS, "{boundary}: {worst:e}");
        assert_relative_eq!(found.plastic_volume().unwrap(), expected.plastic.unwrap().volume, max_relative = 1e-6);
    }
}

/// Branches without weight and limits out of reach change nothing.
#[test]
fn parts_without_an_effect_leave_the_others_as_they_are() {
    let (body, grid, heights) = problem();
    let elastic = Prony::from_fractions(&[(1.3, 1e-12)]).unwrap();
    let plain = Parts::new(&body, &grid, &heights);
    let wear = Some(Wear { by_distance: 0.3, by_slip: 0.0 });
    for parts in [
        Parts { hardness: Some(HARDNESS.into()), ..plain.clone() },
        Parts { wear, ..plain.clone() },
        Parts { hardness: Some(HARDNESS.into()), wear, ..plain.clone() },
        Parts { shear: Some(Limit::Coulomb(0.3).into()), ..plain.clone() },
    ] {
        let expected = follow(&parts, &drives());
        let relaxes = Parts { relaxation: Some((&elastic, Relaxes::Both)), ..parts.clone() };
        let mut others = vec![("branches", follow(&relaxes, &drives()))];
        if parts.hardness.is_none() {
            others.push(("hardness", follow(&Parts { hardness: Some(1e3.into()), ..parts.clone() }, &drives())));
        }
        if parts.shear.is_none() {
            let shear = Some(Limit::Coulomb(0.0).into());
            others.push(("friction", follow(&Parts { shear, ..parts.clone() }, &drives())));
        }
        for (name, states) in others {
            for (found, expected) in states.iter().zip(&expected) {
                assert!(apart(found, expected) < 1e-6, "{name}: {:e}", apart(found, expected));
                let lost = [found, expected].map(|state| state.losses.total());
                assert!((lost[0] - lost[1]).abs() <= 1e-6 * expected.elastic_energy(), "{name}: {lost:?}");
            }
        }
    }
}

#[test]
fn surfaces_of_any_body_wear_in_proportion_to_load_and_distance() {
    let (body, grid, heights) = problem();
    let prony = Prony::from_fractions(&[(1.3, 0.6)]).unwrap();
    let wear = Some(Wear { by_distance: 0.3, by_slip: 0.0 });
    let plain = Parts { wear, ..Parts::new(&body, &grid, &heights) };
    let relaxes = Parts { relaxation: Some((&prony, Relaxes::Both)), ..plain.clone() };
    let all = Parts { hardness: Some(HARDNESS.into()), shear: Some(Limit::Coulomb(0.3).into()), ..relaxes.clone() };
    for parts in [relaxes, Parts { hardness: Some(HARDNESS.into()), ..plain }, all] {
        let mut volume = 0.0;
        let mut distance = 0.0;
        for (state, drive) in follow(&parts, &drives()).iter().zip(drives()) {
            let Load::MeanPressure(mean) = drive.load else { panic!() };
            volume += 0.3 * mean * (drive.distance - distance);
            distance = drive.distance;
            let (found, deepest) = state.wear_volume_and_depth().unwrap();
            assert_relative_eq!(found, volume, max_relative = 1e-9);
            assert!(deepest >= found);
            assert!(state.losses.wear > 0.0 || distance == 0.0);
        }
    }
}

/// Fretting: the depth is the coefficient times the pressure times the slip of each point.
#[test]
fn points_that_stick_do_not_wear() {
    let (body, grid, heights) = problem();
    let wear = Some(Wear { by_distance: 0.0, by_slip: 0.5 });
    let shear = Some(Limit::Coulomb(0.3).into());
    let parts = Parts { wear, shear, ..Parts::new(&body, &grid, &heights) };
    let pressed = Drive::from(Load::MeanPressure(0.03));
    let states = follow(&parts, &[pressed, Drive { lateral: [2e-3, 0.0], ..pressed }]);
    let [before, state] = &states[..] else { panic!() };
    assert!(state.stick_fraction().unwrap() > 0.0);
    let worn = state.wear_depth().unwrap() - before.wear_depth().unwrap();
    let (x, y, pressure) = (state.slip(0).unwrap(), state.slip(1).unwrap(), state.pressure());
    let most = worn.iter().copied().fold(0.0, f64::max);
    assert!(most > 0.0);
    for ((i, j), worn) in worn.indexed_iter() {
        let expected = 0.5 * pressure[[i, j]] * x[[i, j]].hypot(y[[i, j]]);
        assert!((worn - expected).abs() <= 1e-6 * most, "{worn} {expected}");
    }
}

/// Slip and yield lose energy in a step of no time and no distance: its loss depends on its increments.
#[test]
fn a_loss_in_no_time_has_an_error_unless_nothing_slips_or_yields() {
    let (body, grid, heights) = problem();
    let prony = Prony::from_fractions(&[(1.3, 0.6)]).unwrap();
    let plain = Parts { relaxation: Some((&prony, Relaxes::Both)), ..Parts::new(&body, &grid, &heights) };
    let sheared = Parts { shear: Some(Limit::Coulomb(0.3).into()), ..plain.clone() };
    let flattened = Parts { hardness: Some(HARDNESS.into()), ..plain.clone() };
    let pressed = Drive::from(Load::MeanPressure(0.03));
    let drives = [pressed, Drive { lateral: [2e-3, 0.0], ..pressed }];
    for (parts, is_lossless) in [(&plain, true), (&flattened, false), (&sheared, false)] {
        let contact = QuasistaticContact::new(parts).unwrap();
        let drives = if parts.shear.is_some() { &drives[..] } else { &drives[..1] };
        let follow = |solves_per_step, tolerance| {
            let mut path = Path::new(&contact, Budget::default(), Refinement { solves_per_step, tolerance });
            let steps = drives.iter().map(|drive| path.step(*drive, &mut ()).unwrap());
            let steps: Vec<_> = steps.map(|step| (step.dissipated.unwrap(), step.dissipated_error)).collect();
            steps
        };
        let [once, halved] = [0, 8].map(|solves| follow(solves, 1e-3));
        for ((lost, none), (fine, error)) in once.into_iter().zip(halved) {
            if is_lossless {
                assert_eq!((lost, none, fine, error), (0.0, Some(0.0), 0.0, Some(0.0)));
                continue;
            }
            assert_eq!(none, None, "one increment has no error");
            let error = error.unwrap();
            assert!(lost > 0.0 && error > 0.0, "{lost} {fine} {error}");
        }
        // The finest path is close enough to the limit that errors can be compared with it.
        let [coarse, fine] = [(8, 1e-2), (200, 1e-5)].map(|(solves, tolerance)| follow(solves, tolerance));
        for ((lost, error), (limit, _)) in coarse.into_iter().zip(fine) {
            let error = error.unwrap();
            assert!((lost - limit).abs() <= error, "{lost} +- {error}, limit {limit}");
        }
    }
}

/// Fretting: the depth depends on the length of the increments, as slip counts from their start.
#[test]
fn the_error_of_the_worn_depth_encloses_its_distance_from_a_finer_path() {
    let (body, grid, heights) = problem();
    let wear = Some(Wear { by_distance: 0.0, by_slip: 0.5 });
    let shear = Some(Limit::Coulomb(0.3).into());
    let parts = Parts { wear, shear, ..Parts::new(&body, &grid, &heights) };
    let pressed = Drive::from(Load::MeanPressure(0.03));
    let turns = [2e-3, -2e-3, 2e-3].map(|x| Drive { lateral: [x, 0.0], ..pressed });
    let drives: Vec<Drive> = std::iter::once(pressed).chain(turns).collect();
    let contact = QuasistaticContact::new(&parts).unwrap();
    let follow = |solves_per_step, tolerance| {
        let mut path = Path::new(&contact, Budget::default(), Refinement { solves_per_step, tolerance });
        let steps = drives.iter().map(|drive| {
            let error = path.step(*drive, &mut ()).unwrap().worn_error;
            (path.state().unwrap().wear_volume_and_depth().unwrap().0, error)
        });
        steps.collect::<Vec<_>>()
    };
    let [coarse, fine] = [(16, 1e-2), (400, 1e-5)].map(|(solves, tolerance)| follow(solves, tolerance));
    for ((worn, error), (limit, _)) in coarse.into_iter().zip(fine).skip(1) {
        let [upper, lower] = error.unwrap();
        assert!((worn - limit).abs() <= upper && upper < 0.5 * worn, "{worn} +- {upper}, limit {limit}");
        assert_eq!(lower, 0.0, "there is one surface");
    }
    assert!(follow(0, 1e-2).iter().all(|(_, error)| error.is_none()), "without extra solves there is no other path");
}

/// A hard wall that is lifted off touches without pressure, at the limit of small loads, and touches again as before.
#[test]
fn a_contact_is_unloaded_completely_and_loaded_again() {
    let (body, grid, heights) = problem();
    let prony = Prony::from_fractions(&[(1.3, 0.6)]).unwrap();
    for boundary in Boundary::ALL {
        let plain = Parts { boundary, ..Parts::new(&body, &grid, &heights) };
        let hardness = Some(HARDNESS.into());
        let shear = Some(Limit::Coulomb(0.3).into());
        let wear = Some(Wear { by_distance: 0.3, by_slip: 0.0 });
        let relaxation = Some((&prony, Relaxes::Both));
        for (name, parts) in [
            ("elastic", plain.clone()),
            ("hardness", Parts { hardness: hardness.clone(), ..plain.clone() }),
            ("friction", Parts { shear, ..plain.clone() }),
            ("wear", Parts { wear, ..plain.clone() }),
            ("relaxation", Parts { relaxation, ..plain.clone() }),
            ("all", Parts { hardness, shear, wear, relaxation, ..plain.clone() }),
        ] {
            let at = |load: Load, time: f64| {
                let lateral = if parts.shear.is_some() { [1e-3 * time, 0.0] } else { [0.0; 2] };
                Drive { lateral, ..Drive::from(load).at(time).after(0.1 * time) }
            };
            let loaded = at(Load::MeanPressure(0.04), 1.0);
            let unloaded = |load: Load| follow(&parts, &[loaded, at(load, 1.5), at(Load::MeanPressure(0.04), 2.0)]);
            let [free, light] = [0.0, 1e-9].map(|mean| unloaded(Load::MeanPressure(mean)));
            let touch = free[1].approach();
            let lifted = unloaded(Load::Approach(touch.min(0.0) - 0.01));
            for (states, gap) in [(&free, 0.0), (&lifted, touch - touch.min(0.0) + 0.01)] {
                let state = &states[1];
                assert!(state.pressure().iter().all(|p| *p == 0.0), "{name}, {boundary}");
                assert_eq!(state.mean_shear, [0.0; 2], "{name}, {boundary}");
                let least = state.gap().iter().copied().fold(f64::INFINITY, f64::min);
                assert!((least - gap).abs() <= 1e-12, "{name}, {boundary}: {least:e} instead of {gap:e}");
                assert!(state.worst() <= 1e-10 && state.elastic_energy().is_finite(), "{name}, {boundary}");
            }
            let expected = light[1].approach();
            assert!((touch - expected).abs() <= 1e-6, "{name}, {boundary}: touches at {touch}, almost {expected}");
            for states in [&free, &lifted] {
                assert!(apart(&states[2], &light[2]) < 1e-5, "{name}, {boundary}: {:e}", apart(&states[2], &light[2]));
            }
        }
    }
}
