//! Laws on a patch with free boundaries: identities, independence of the margin, Maugis's sphere, and refused input.

use std::f64::consts::PI;

use gfmd_contact::{
    Boundary, Contact, Drive, Equilibrium, Fields, Load, MemoryCheckpoint, Refusal, Resumable, SolveError, Solver,
};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Interface, State, StoredFields};
use gfmd_law::{Dugdale, Exponential, HardWall, Law, Limit, Morse};
use gfmd_measure::theory::AdhesiveSphere;
use ndarray::{Array2, s};

fn half_space() -> Body {
    Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap())
}

/// Returns a rough surface that is not periodic.
fn rough([nx, ny]: [usize; 2]) -> Array2<f64> {
    Array2::from_shape_fn((nx, ny), |(i, j)| {
        let [x, y] = [i as f64 / nx as f64, j as f64 / ny as f64];
        0.02 * (5.3 * x + 1.0).sin() * (4.1 * y).cos() + 0.005 * (31.0 * x - 17.0 * y).sin() + 0.01 * x
    })
}

fn on_patch(grid: &Grid, heights: &Array2<f64>, law: impl Law + 'static) -> Interface {
    Interface::with_boundary(Boundary::Free, &half_space(), grid, heights, law).unwrap()
}

fn solve(interface: &Interface, load: Load, start: Option<&State>) -> State {
    interface.press(load).starting_from(start).tolerance(1e-10).solve().unwrap()
}

fn assert_equal_fields(found: &Array2<f64>, wanted: &Array2<f64>, tolerance: f64) {
    let scale = wanted.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    let off = found.iter().zip(wanted).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    assert!(off <= tolerance * scale, "{off:e} of {scale:e}");
}

#[test]
fn a_wall_alone_is_the_contact_of_the_dual_solver() {
    for points in [[24, 24], [17, 30], [40, 1]] {
        let grid = Grid::new(points, [1.0, 1.3]).unwrap();
        let heights = rough(points);
        let contact = Contact::with_boundary(Boundary::Free, &half_space(), &grid, &heights).unwrap();
        let interface = on_patch(&grid, &heights, HardWall);
        assert_eq!((interface.boundary(), interface.surface()), (Boundary::Free, contact.surface()));
        for mean in [1e-3, 0.02] {
            let wanted = contact.press(Load::MeanPressure(mean)).tolerance(1e-11).solve().unwrap();
            let mut loads = vec![Load::MeanPressure(mean)];
            if !grid.is_line() {
                loads.push(Load::Approach(wanted.approach));
            }
            for load in loads {
                let found = solve(&interface, load, None);
                assert_equal_fields(&found.pressure().to_owned(), &wanted.pressure, 1e-7);
                assert_equal_fields(&found.displacement_z().to_owned(), &wanted.displacement, 1e-8);
                assert!((found.mean_pressure / mean - 1.0).abs() < 1e-8);
                assert!((found.approach / wanted.approach - 1.0).abs() < 1e-8, "{points:?} {load:?}");
                let energies = [&found.summary(), &wanted.summary()].map(|summary| summary.elastic_energy);
                assert!((energies[0] / energies[1] - 1.0).abs() < 1e-7, "{energies:?}");
            }
        }
    }
}

/// A margin out of reach of the law changes nothing, wherever the patch ends.
#[test]
fn a_margin_may_be_cut_off() {
    let (grid, law) = (Grid::square(40, 1.0).unwrap(), Exponential::new(2e-4, 3e-3).unwrap());
    let bump = Array2::from_shape_fn((40, 40), |(i, j)| {
        -((i as f64 - 17.2).powi(2) + 1.3 * (j as f64 - 15.0).powi(2)) / 600.0
    });
    let part = Grid::new([36, 30], [0.9, 0.75]).unwrap();
    let inside = bump.slice(s![..36, ..30]).to_owned();
    for approach in [0.004, 0.0, -0.003] {
        let whole = solve(&on_patch(&grid, &bump, law), Load::Approach(approach), None);
        let cut = solve(&on_patch(&part, &inside, law), Load::Approach(approach), None);
        assert_equal_fields(&cut.pressure().to_owned(), &whole.pressure().slice(s![..36, ..30]).to_owned(), 1e-7);
        let forces = [whole.mean_pressure, cut.mean_pressure * 0.9 * 0.75];
        assert!((forces[0] - forces[1]).abs() < 1e-8 * forces[0].abs().max(1e-4), "{forces:?}");
        let energies = [whole.interface_energy, cut.interface_energy * 0.9 * 0.75];
        assert!((energies[0] / energies[1] - 1.0).abs() < 1e-6, "{energies:?}");
    }
}

#[test]
fn load_and_approach_solvers_and_certificates_agree() {
    let grid = Grid::new([30, 22], [1.0, 0.8]).unwrap();
    for law in [Exponential::new(1e-4, 2e-3).unwrap().into_shared(), Morse::new(1e-4, 4e-3).unwrap().into_shared()] {
        let interface = on_patch(&grid, &rough([30, 22]), law);
        for load in [Load::MeanPressure(0.01), Load::MeanPressure(-2e-4), Load::Approach(0.01)] {
            let state = solve(&interface, load, None);
            let other = if let Load::Approach(_) = load {
                Load::MeanPressure(state.mean_pressure)
            } else {
                Load::Approach(state.approach)
            };
            let pressure = state.pressure().to_owned();
            for found in [
                solve(&interface, other, Some(&state)),
                interface
                    .press(load)
                    .solver(Solver::Fire2)
                    .tolerance(1e-10)
                    .starting_from(Some(&state))
                    .solve()
                    .unwrap_or_else(|error| {
                        assert!(matches!(error, SolveError::Refused(Refusal::NoDynamics)), "{error}");
                        state.clone()
                    }),
                interface.certify(&state.gap, &pressure, load.into()).unwrap(),
            ] {
                assert_equal_fields(&found.pressure().to_owned(), &pressure, 1e-6);
                assert!(found.residual.worst() < 1e-8, "{:?}", found.residual);
                assert!((found.approach - state.approach).abs() < 1e-7, "{load:?}");
            }
        }
    }
}

/// On an unbounded half-space Maugis's curves also hold for the approach, which has no meaning on a periodic one.
#[test]
fn a_sphere_with_a_dugdale_zone_follows_the_curves_of_maugis() {
    let theory = AdhesiveSphere { modulus: 1.0, curvature_radius: 1.0, work: 2.17e-4 };
    let (work, strength) = (theory.work, theory.strength(1.0));
    let branch: Vec<_> = (1..4000).map(|i| theory.maugis(1.0, 1.0 + 1e-3 * f64::from(i))).collect();
    let side = 0.6;
    let errors: Vec<[f64; 2]> = [40, 80, 160]
        .into_iter()
        .map(|n| {
            let at = |i: usize| (side * (i as f64 / n as f64 - 0.5)).powi(2);
            let sphere = Array2::from_shape_fn((n, n), |(i, j)| -0.5 * (at(i) + at(j)));
            let law = Dugdale::new(work, work / strength).unwrap();
            let interface = on_patch(&Grid::square(n, side).unwrap(), &sphere, law);
            let mut last: Option<State> = None;
            let mut worst = [0.0_f64; 2];
            for step in 0..16 {
                let load = Load::Approach(0.010 - 0.0005 * f64::from(step));
                let state = interface.press(load).starting_from(last.as_ref()).solve().unwrap();
                let a = (state.contact_fraction * side * side / PI).sqrt();
                let off = |x: &gfmd_measure::theory::AdhesiveContact| (x.approach - state.approach).abs();
                let stable = branch.iter().filter(|x| x.radius > theory.radius_unit());
                let wanted = stable.min_by(|x, y| off(x).total_cmp(&off(y))).unwrap();
                worst[0] = worst[0].max((wanted.force - state.mean_pressure * side * side).abs() / theory.force_unit());
                worst[1] = worst[1].max((wanted.radius - a).abs() / theory.radius_unit());
                last = Some(state);
            }
            worst
        })
        .collect();
    assert!(errors[2].iter().all(|error| *error < 0.05), "{errors:?}");
    assert!(errors.windows(2).all(|pair| pair[1][0] < 0.7 * pair[0][0]), "{errors:?}");
}

#[test]
fn a_state_that_is_kept_or_recalled_leads_to_the_same_bits() {
    let grid = Grid::new([20, 26], [1.0, 1.1]).unwrap();
    let interface = on_patch(&grid, &rough([20, 26]), Exponential::new(1e-4, 2e-3).unwrap());
    for (first, then) in [(0.01, 0.004), (0.01, -1e-4)].map(|(a, b)| (Load::MeanPressure(a), Load::MeanPressure(b))) {
        let mut state = solve(&interface, first, None);
        let next = solve(&interface, then, Some(&state));
        let kept = StoredFields {
            pressure: &state.pressure().to_owned(),
            displacement_z: &state.displacement_z().to_owned(),
            gap: &state.gap.clone(),
            approach: state.approach,
        };
        assert_eq!(solve(&interface, then, Some(&interface.recall(kept).unwrap())), next);
        let mut checkpoint = MemoryCheckpoint::default();
        interface.keep(&mut state, &mut checkpoint);
        checkpoint.rewind();
        let restored = interface.restore(first.into(), &mut checkpoint).unwrap();
        assert_eq!(solve(&interface, then, Some(&restored)), next);
    }
}

#[test]
fn approaches_of_profiles_are_prescribed_and_found() {
    let line = Grid::line(32, 1.0).unwrap();
    let interface = on_patch(&line, &rough([32, 1]), Exponential::new(1e-4, 2e-3).unwrap());
    let found = interface.press(Load::Approach(0.01)).solve().unwrap();
    let loaded = interface.press(Load::MeanPressure(found.mean_pressure)).solve().unwrap();
    assert!((loaded.approach - 0.01).abs() < 1e-9, "{}", loaded.approach);
    // A profile on a slab has a level far away.
    let slab = Body::slab(Material::from_young(1.0, 0.3).unwrap(), 0.2).unwrap();
    let law = Exponential::new(1e-4, 2e-3).unwrap();
    let interface = Interface::with_boundary(Boundary::Free, &slab, &line, &rough([32, 1]), law).unwrap();
    assert!(interface.press(Load::Approach(0.01)).solve().unwrap().mean_pressure > 0.0);
    // Nothing holds a plate.
    let plate = Body::slab(Material::from_young(1.0, 0.3).unwrap(), 0.2).unwrap().on(gfmd_green::Base::FREE).unwrap();
    let grid = Grid::square(8, 1.0).unwrap();
    let error = Interface::with_boundary(Boundary::Free, &plate, &grid, &rough([8, 8]), HardWall).unwrap_err();
    assert!(matches!(error, Refusal::Body(_)), "{error}");
    let huge = Grid::new([1 << 29, 1 << 29], [1.0; 2]).unwrap();
    assert!(huge.padded().is_err());
}

/// Cattaneo (1938) and Mindlin (1949): a sphere pressed and then moved laterally. For ν = ½ the shear couples weakly to
/// the normal direction, and their solution is exact except for the slip across the direction of motion.
#[test]
fn a_sphere_that_is_moved_sideways_slips_at_the_edge_of_its_contact() {
    let (poisson, friction, side, n) = (0.5, 0.4, 0.5, 80);
    let material = Material::from_contact_modulus(1.0, poisson).unwrap();
    let grid = Grid::square(n, side).unwrap();
    let at = |i: usize| (side * (i as f64 / n as f64 - 0.5)).powi(2);
    let sphere = Array2::from_shape_fn((n, n), |(i, j)| -0.5 * (at(i) + at(j)));
    let body = Body::half_space(material);
    let contact = crate::rubbing(Boundary::Free, &body, &grid, &sphere, Limit::Coulomb(friction));
    let approach = 0.02;
    let mut drive = Drive::from(Load::Approach(approach));
    let pressed = contact.press(drive).solve().unwrap();
    let wanted = Contact::with_boundary(Boundary::Free, &body, &grid, &sphere).unwrap();
    let wanted = wanted.press(Load::Approach(approach)).tolerance(1e-10).solve().unwrap();
    assert!((pressed.mean_pressure() / wanted.mean_pressure - 1.0).abs() < 1e-7);
    let force = pressed.mean_pressure() * side * side;
    // F = (4/3) E* √R δ^(3/2).
    assert!((force / (4.0 / 3.0 * approach.powf(1.5)) - 1.0).abs() < 0.01, "{force}");
    // Displacement of full slip: μ δ E*/(4 G*) with 1/G* = (2 − ν)/(4 G), here μ δ (2 − ν)/(2 (1 − ν)).
    let full = friction * approach * (2.0 - poisson) / (2.0 * (1.0 - poisson));
    for part in [0.3, 0.7] {
        drive.lateral = [part * full, 0.0];
        let state = contact.press(drive).starting_from(Some(&pressed)).solve().unwrap();
        let tangential = state.mean_shear[0] * side * side / (friction * force);
        let wanted = 1.0 - (1.0_f64 - part).powf(1.5);
        assert!((tangential - wanted).abs() < 0.02, "{part}: {tangential} {wanted}");
        let stick = state.stick_fraction().unwrap() / state.summary().area_fraction;
        assert!((stick - (1.0 - part)).abs() < 0.04, "{part}: {stick}");
    }
}
