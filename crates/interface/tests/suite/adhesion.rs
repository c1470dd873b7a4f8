//! Adhesive contact compared with closed forms.

use std::f64::consts::{PI, TAU};

use std::ops::ControlFlow;

use gfmd_contact::{Boundary, Contact, Drive, Equilibrium, Fields, Load, Progress, Refusal, SolveError, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Interface, State, StoredFields};
use gfmd_law::{Dugdale, Exponential, HardWall, HarmonicCosine, Law, Morse, Npc, Separation, Tabulated};
use gfmd_measure::theory::AdhesiveSphere;
use ndarray::Array2;

fn half_space() -> Body {
    Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap())
}

fn solve(interface: &Interface, load: Load, start: Option<&State>) -> Result<State, SolveError<State>> {
    interface.press(load).starting_from(start).solve()
}

fn wave(n: usize, amplitude: f64) -> Array2<f64> {
    Array2::from_shape_fn((n, 1), |(i, _)| amplitude * (TAU * i as f64 / n as f64).cos())
}

fn sphere(n: usize) -> Array2<f64> {
    let at = |i: usize| (i as f64 / n as f64 - 0.5).powi(2);
    Array2::from_shape_fn((n, n), |(i, j)| -0.5 * (at(i) + at(j)))
}

#[test]
fn a_sphere_with_a_dugdale_zone_follows_the_curve_of_maugis() {
    let sphere_of_maugis = AdhesiveSphere { modulus: 1.0, curvature_radius: 1.0, work: 2.17e-4 };
    let (work, strength) = (sphere_of_maugis.work, sphere_of_maugis.strength(1.0));
    let branch: Vec<_> = (1..4000).map(|i| sphere_of_maugis.maugis(1.0, 1.0 + 1e-3 * f64::from(i))).collect();
    let radius = sphere_of_maugis.radius_unit();
    let errors: Vec<f64> = [64, 128, 256]
        .into_iter()
        .map(|n| {
            let law = Dugdale::new(work, work / strength).unwrap();
            let interface = Interface::new(&half_space(), &Grid::square(n, 1.0).unwrap(), &sphere(n), law).unwrap();
            let mut last: Option<State> = None;
            let mut worst = 0.0_f64;
            for step in 0..24 {
                let approach = 0.010 - 0.0005 * f64::from(step);
                let state = solve(&interface, Load::Approach(approach), last.as_ref()).unwrap();
                let a = (state.contact_fraction / PI).sqrt();
                // The branch is followed from large a; the force is a function of a.
                let nearest = |of: &&gfmd_measure::theory::AdhesiveContact| (of.radius - a).abs();
                let of_a = branch.iter().min_by(|x, y| nearest(x).total_cmp(&nearest(y))).unwrap();
                if a > radius {
                    worst = worst.max((of_a.force - state.mean_pressure).abs() / sphere_of_maugis.force_unit());
                }
                last = Some(state);
            }
            worst
        })
        .collect();
    // The contact edge jumps from point to point, which is a first-order error.
    assert!(errors[2] < 0.15, "{errors:?}");
    assert!(errors.windows(2).all(|pair| pair[1] < 0.7 * pair[0]), "{errors:?}");
}

/// Returns the pull-off load of a sphere divided by π w, on a free patch of side 0.6 with n² points; R = 1, E* = 1.
fn pull_off(n: usize, work: f64, law: impl Law + 'static) -> f64 {
    let side = 0.6;
    let grid = Grid::square(n, side).unwrap();
    let interface =
        Interface::with_boundary(Boundary::Free, &half_space(), &grid, &(side * side * sphere(n)), law).unwrap();
    let (mut last, mut lowest): (Option<State>, f64) = (None, 0.0);
    for step in 0..80 {
        let press = interface.press(Load::Approach(1.5e-3 - 2.5e-4 * f64::from(step)));
        let state = press.starting_from(last.as_ref()).tolerance(1e-6).solve().unwrap();
        let force = state.mean_pressure * side * side;
        if lowest < 0.0 && force > 0.6 * lowest {
            break;
        }
        lowest = lowest.min(force);
        last = Some(state);
    }
    -lowest / (PI * work)
}

/// Returns the pull-off load divided by π w R of Maugis (1992) for his parameter λ: the lowest force over all ratios m
/// of zone to contact radius. The work of the zone determines the contact radius a. a in (π w R²/K)^⅓, forces in π w R.
fn maugis_pull_off(lambda: f64) -> f64 {
    let terms = |m: f64| ((m * m - 1.0).sqrt(), (1.0 / m).acos());
    let work = |a: f64, m: f64| {
        let (root, arc) = terms(m);
        let of_gap = 0.5 * lambda * a * a * (root + (m * m - 2.0) * arc);
        of_gap + 4.0 / 3.0 * lambda * lambda * a * (root * arc - m + 1.0)
    };
    let mut lowest = 0.0_f64;
    for k in 1..4000 {
        let m = 1.0 + 1e-3 * 1.003_f64.powi(k);
        let (mut low, mut high) = (0.0, 50.0);
        if work(high, m) < 1.0 {
            continue;
        }
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if work(middle, m) < 1.0 { low = middle } else { high = middle }
        }
        let (root, arc) = terms(m);
        lowest = lowest.min(low.powi(3) - lambda * low * low * (root + m * m * arc));
    }
    -lowest
}

#[test]
fn a_sphere_is_pulled_off_a_table_of_a_law_as_off_the_law() {
    let (work, range) = (2.17e-4, 9e-3);
    let wanted = pull_off(32, work, Exponential::new(work, range).unwrap());
    let found = [12, 24, 48].map(|rows| {
        let law = Exponential::new(work, range).unwrap();
        let mut table: Vec<[f64; 2]> = (0..=rows)
            .map(|k| 12.0 * range * f64::from(k) / f64::from(rows))
            .map(|gap| [gap, law.opening(gap).traction])
            .collect();
        table[rows as usize][1] = 0.0;
        (pull_off(32, work, Tabulated::new(&table).unwrap()) / wanted - 1.0).abs()
    });
    assert!(found[2] < 1e-3, "{found:?}");
    assert!(found.windows(2).all(|pair| pair[1] < 0.25 * pair[0]), "{found:?}");
}

#[test]
fn a_law_finds_its_pull_off_with_the_points_that_it_needs_in_its_process_zone() {
    let work = 2.17e-4;
    // (π/4) E*/steepness divided by the grid step.
    let points = |law: &dyn Law, n: usize| 0.25 * PI / law.steepness() / (0.6 / n as f64);
    // K = 4/3 E*, λ = 2 σ (R/(π w K²))^⅓.
    let exact = |range: f64| maugis_pull_off(2.0 * work / range * (9.0 / (16.0 * PI * work)).cbrt());
    let dugdale = |range: f64, n: usize| {
        let law = Dugdale::new(work, range).unwrap();
        (points(&law, n) / law.resolving_points(), pull_off(n, work, law) / exact(range) - 1.0)
    };
    let (share, error) = dugdale(6.44e-3, 128);
    assert!(share >= 1.0 && error.abs() < 0.025, "{share} {error}");
    // Two points resolve a smooth law, but not one with a jump in the traction.
    let (share, error) = dugdale(2.28e-3, 64);
    assert!(share < 0.1 && error > 0.1, "{share} {error}");

    let separation = |length: f64| Separation {
        normal_work: work,
        tangential_work: work,
        normal_length: length,
        tangential_length: length,
    };
    let smooth: [&dyn Fn(f64) -> Box<dyn Law>; 4] = [
        &|length| Box::new(Exponential::new(work, length).unwrap()),
        &|length| Box::new(Morse::new(work, length).unwrap()),
        &|length| Box::new(HarmonicCosine::new(work, work / length / length).unwrap()),
        &|length| Box::new(Npc::new(separation(length)).unwrap()),
    ];
    for law in smooth {
        // Length at which the process zone has as many points on 32² as the law needs: steepness ∝ 1/length².
        let unit = law(1e-3);
        let law = |n: usize| {
            let law = law(1e-3 * (1.001 * unit.resolving_points() / points(&unit, 32)).sqrt());
            assert!((points(&law, n) / law.resolving_points() - 1.001 * n as f64 / 32.0).abs() < 1e-9, "{law:?}");
            pull_off(n, work, law)
        };
        let (found, finer) = (law(32), law(64));
        assert!((found / finer - 1.0).abs() < 0.025, "{unit:?}: {found} {finer}");
    }
}

fn rough(points: [usize; 2]) -> Array2<f64> {
    // Waves without a common symmetry, so that nothing cancels.
    let waves = [(1.0, 2.0, 0.3), (3.0, -1.0, 1.1), (-2.0, 3.0, 2.0), (4.0, 4.0, 0.7), (5.0, 0.0, 4.0)];
    Array2::from_shape_fn((points[0], points[1]), |(i, j)| {
        let [x, y] = [i as f64 / points[0] as f64, j as f64 / points[1] as f64];
        waves.iter().map(|(m, n, phase)| 0.004 * (TAU * (m * x + n * y) + phase).cos()).sum()
    })
}

#[test]
fn a_wall_alone_is_the_contact_of_the_dual_solver() {
    let material = Material::from_young(1.0, 0.3).unwrap();
    for (body, points) in [
        (Body::half_space(material), [48, 48]),
        (Body::slab(material, 0.4).unwrap(), [45, 32]),
        (Body::half_space(material), [256, 1]),
    ] {
        let grid = Grid::new(points, [1.0, 1.0]).unwrap();
        let heights = rough(points);
        let interface = Interface::new(&body, &grid, &heights, HardWall).unwrap();
        let contact = Contact::new(&body, &grid, &heights).unwrap();
        for load in [Load::MeanPressure(0.02), Load::Approach(0.008)] {
            let wanted = contact.press(load).tolerance(1e-11).solve().unwrap();
            let found = interface.press(load).tolerance(1e-11).solve().unwrap();
            let error = (&found.wall_pressure - &wanted.pressure).iter().fold(0.0_f64, |worst, e| worst.max(e.abs()));
            assert!(error < 1e-8 * wanted.mean_pressure, "{points:?} {load:?}: {error}");
            assert!((found.approach - wanted.approach).abs() < 1e-10 && found.effort.iterations < 40);
            assert!((found.mean_pressure - wanted.mean_pressure).abs() < 1e-10);
            let (a, b) = (found.summary(), wanted.summary());
            assert_eq!((a.contact_nodes, a.boundary_links), (b.contact_nodes, b.boundary_links));
            assert!((a.kappa - b.kappa).abs() < 1e-8 && (a.elastic_energy / b.elastic_energy - 1.0).abs() < 1e-8);
        }
    }
}

#[test]
fn without_shear_all_components_find_what_u_z_alone_finds() {
    // Odd, so that no component is missing at Nyquist.
    let points = [33, 31];
    let body = Body::slab(Material::from_young(1.0, 0.3).unwrap(), 0.3).unwrap();
    let grid = Grid::new(points, [1.0, 1.0]).unwrap();
    let heights = rough(points);
    for law in [Exponential::new(2e-4, 4e-3).unwrap().into_shared(), Morse::new(2e-4, 4e-3).unwrap().into_shared()] {
        let one = Interface::new(&body, &grid, &heights, law.clone()).unwrap();
        let all = Interface::in_all_components(&body, &grid, &heights, law.clone()).unwrap();
        for load in [Load::MeanPressure(0.01), Load::Approach(0.006), Load::Approach(-0.002)] {
            let (a, b) = (solve(&one, load, None).unwrap(), solve(&all, load, None).unwrap());
            let error = (&a.gap - &b.gap).iter().fold(0.0_f64, |worst, e| worst.max(e.abs()));
            assert!(error < 1e-8, "{law:?} {load:?}: {error}");
            assert!((a.elastic_energy - b.elastic_energy).abs() < 1e-8 * a.elastic_energy);
        }
    }
}

#[test]
fn surfaces_jump_into_contact_and_out_of_it_at_different_distances() {
    let n = 256;
    let law = Exponential::new(4e-4, 3e-3).unwrap();
    let heights = wave(n, 0.01);
    let interface = Interface::new(&half_space(), &Grid::line(n, 1.0).unwrap(), &heights, law).unwrap();
    let approaches: Vec<f64> = (0..60).map(|i| -0.025 + 0.0005 * f64::from(i)).collect();
    let mut last: Option<State> = None;
    let mut branch = |approaches: &mut dyn Iterator<Item = f64>| -> Vec<State> {
        approaches
            .map(|approach| {
                let state = solve(&interface, Load::Approach(approach), last.as_ref()).unwrap();
                last = Some(state.clone());
                state
            })
            .collect()
    };
    let loading = branch(&mut approaches.iter().copied());
    let mut unloading = branch(&mut approaches.iter().rev().copied());
    unloading.reverse();
    let touches = |states: &[State]| states.iter().position(|state| state.contact_fraction > 0.0).unwrap();
    let (jump_in, jump_out) = (touches(&loading), touches(&unloading));
    assert!(jump_out + 4 < jump_in, "{jump_in} {jump_out}");
    assert!(loading[jump_in].passed_instability && loading[jump_in].contact_fraction > 0.1);
    assert!(unloading[jump_out - 1].passed_instability);
    // The loop dissipates energy: attraction is stronger during unloading, except where both paths have the same state.
    for (a, b) in loading.iter().zip(&unloading) {
        assert!(b.mean_pressure <= a.mean_pressure + 1e-9, "{} {}", a.mean_pressure, b.mean_pressure);
        assert!(a.lowest_curvature > 0.0 && b.lowest_curvature > 0.0);
        // Both are states of one energy; after each jump the state has the lower energy.
        assert!((a.gap[[n / 2, 0]] >= 0.0) && (b.gap[[0, 0]] >= 0.0));
    }
    let total = |state: &State| state.elastic_energy + state.interface_energy;
    assert!(total(&loading[jump_in]) <= total(&unloading[jump_in]) + 1e-12);
}

#[test]
fn one_large_step_of_the_load_ends_where_small_steps_do() {
    // The first part of a large step is a jump towards another contact; it must stay on the branch that it comes from.
    let n = 256;
    let law = Exponential::new(4e-4, 3e-3).unwrap();
    let interface = Interface::new(&half_space(), &Grid::line(n, 1.0).unwrap(), &wave(n, 0.04), law).unwrap();
    let pressed = solve(&interface, Load::MeanPressure(0.03), None).unwrap();
    for pressure in [0.02, 0.005, 0.0, -0.002] {
        let step = |k: u8| Load::MeanPressure(0.03 + (pressure - 0.03) * f64::from(k) / 30.0);
        let small = (1..=30).fold(pressed.clone(), |last, k| solve(&interface, step(k), Some(&last)).unwrap());
        let large = solve(&interface, Load::MeanPressure(pressure), Some(&pressed)).unwrap();
        assert!(large.contact_fraction > 0.02 && large.contact_fraction < 0.9, "{pressure} {}", large.contact_fraction);
        assert_eq!(large.contact_fraction, small.contact_fraction, "{pressure}");
        assert!((large.approach - small.approach).abs() <= 1e-7 * 0.04, "{} {}", large.approach, small.approach);
    }
}

#[test]
fn a_load_that_hardly_changes_the_attraction_passes_no_instability() {
    let n = 128;
    let law = Exponential::new(4e-4, 3e-3).unwrap();
    let interface = Interface::new(&half_space(), &Grid::line(n, 1.0).unwrap(), &wave(n, 0.04), law).unwrap();
    for pressure in [0.02, 0.5] {
        let load = Load::MeanPressure(pressure);
        let first = solve(&interface, load, None).unwrap();
        let again = solve(&interface, load, Some(&first)).unwrap();
        let more = solve(&interface, Load::MeanPressure(1.001 * pressure), Some(&first)).unwrap();
        assert_eq!(first.contact_fraction == 1.0, pressure == 0.5);
        assert!(!again.passed_instability && !more.passed_instability, "{pressure}");
    }
}

#[test]
fn what_cannot_hold_parts_and_says_so() {
    let n = 128;
    let law = Exponential::new(1e-4, 3e-3).unwrap();
    let heights = wave(n, 0.01);
    let interface = Interface::new(&half_space(), &Grid::line(n, 1.0).unwrap(), &heights, law).unwrap();
    let touching = solve(&interface, Load::MeanPressure(0.001), None).unwrap();
    let held = solve(&interface, Load::MeanPressure(-0.001), Some(&touching)).unwrap();
    assert!((held.mean_pressure + 0.001).abs() < 1e-9);
    match solve(&interface, Load::MeanPressure(-0.01), Some(&held)) {
        Err(SolveError::Detached { mean_pressure, state }) => {
            assert!(mean_pressure == -0.01 && state.contact_fraction == 0.0);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn bad_input_is_refused_with_what_was_found() {
    let grid = Grid::square(8, 1.0).unwrap();
    let heights = rough([8, 8]);
    let interface = Interface::new(&half_space(), &grid, &heights, HardWall).unwrap();
    let message = |drive: Drive, tolerance: f64| {
        let error = interface.press(drive).tolerance(tolerance).solve().unwrap_err();
        assert!(matches!(error, SolveError::Refused(_)) && error.state().is_none());
        error.to_string()
    };
    assert_eq!(message(Load::MeanPressure(f64::NAN).into(), 1e-8), "the mean pressure is NaN; it must be finite");
    assert_eq!(message(Load::Approach(0.01).into(), 0.0), "the tolerance is 0e0; it must be between 1e-15 and 0.1");
    assert!(message(Load::Approach(1.0).into(), 1e-8).starts_with("the approach is 1; it must be less than the mean"));
    let lateral = Drive { load: Load::Approach(0.001), lateral: [0.0, f64::INFINITY], time: 0.0, distance: 0.0 };
    assert_eq!(message(lateral, 1e-8), "the lateral displacement is inf; it must be finite");
    let refused = |heights: &Array2<f64>| Interface::new(&half_space(), &grid, heights, HardWall).unwrap_err();
    assert!(matches!(refused(&rough([9, 8])), Refusal::Shape { found: [9, 8], .. }));
    let mut holed = heights.clone();
    holed[[3, 4]] = f64::NAN;
    assert!(matches!(refused(&holed), Refusal::Height { index: [3, 4], .. }));
    let gradients = interface.press(Load::MeanPressure(0.01)).solver(Solver::PolonskyKeer).solve().unwrap_err();
    assert_eq!(gradients.to_string(), "the solver is cg; it must be auto, newton, fire or fire2");
    let steep = Exponential::new(1.0, 1e-3).unwrap();
    let steep = Interface::new(&half_space(), &grid, &heights, steep).unwrap();
    assert!(steep.trapping().unwrap().to_string().starts_with("lattice trapping"));
    let stopped = interface.press(Load::MeanPressure(0.01)).max_iterations(1).solve();
    assert!(matches!(stopped, Err(SolveError::NotConverged { .. })));
    let mut at_once = |_: &Progress| ControlFlow::Break(());
    let broken = interface.press(Load::MeanPressure(0.01)).watch(&mut at_once).solve();
    assert!(matches!(broken, Err(SolveError::Interrupted { .. })));
}

#[test]
fn the_tightest_tolerance_is_that_of_every_contact() {
    let heights = wave(32, 0.01);
    let interface = Interface::new(&half_space(), &Grid::line(32, 1.0).unwrap(), &heights, HardWall).unwrap();
    // Rounding errors may prevent convergence to this tolerance, but it is not refused.
    let ended = interface.press(Load::MeanPressure(0.001)).tolerance(1e-15).solve();
    assert!(!matches!(ended, Err(SolveError::Refused(_))), "{ended:?}");
}

#[test]
fn contacts_are_owned_and_go_to_other_threads() {
    fn goes_anywhere<T: Send + Sync + 'static>(_: &T) {}
    let law: Box<dyn Law> = Box::new(Morse::new(1e-4, 1e-2).unwrap());
    let interface = Interface::new(&half_space(), &Grid::line(32, 1.0).unwrap(), &wave(32, 0.01), law).unwrap();
    goes_anywhere(&interface);
    let elsewhere = interface.clone();
    let there = std::thread::spawn(move || elsewhere.press(Load::Approach(0.001)).solve().unwrap()).join().unwrap();
    assert_eq!(there, interface.press(Load::Approach(0.001)).solve().unwrap());
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let law = Exponential::new(2e-4, 2e-3).unwrap();
    let interface = Interface::new(&half_space(), &Grid::square(96, 1.0).unwrap(), &rough([96, 96]), law).unwrap();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve(&interface, Load::MeanPressure(0.005), None).unwrap())
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn a_law_without_a_wall_can_be_pressed_beyond_full_contact() {
    let (n, amplitude) = (64, 0.01);
    let heights = wave(n, amplitude);
    let grid = Grid::line(n, 1.0).unwrap();
    let soft = Interface::new(&half_space(), &grid, &heights, Morse::new(1e-3, 0.01).unwrap()).unwrap();
    // The mean clearance is the amplitude, where a hard wall would be in full contact.
    let state = solve(&soft, Load::Approach(1.2 * amplitude), None).unwrap();
    assert!(state.residual.worst() <= 1e-8 && state.mean_pressure > 0.0, "{:?}", state.residual);
    let hard = Interface::new(&half_space(), &grid, &heights, HardWall).unwrap();
    let refused = solve(&hard, Load::Approach(1.2 * amplitude), None);
    assert!(matches!(refused, Err(SolveError::Refused(Refusal::Approach { .. }))));
}

#[test]
fn a_search_from_kept_fields_takes_the_steps_of_one_from_the_state() {
    let n = 32;
    let grid = Grid::new([n, n], [1.0, 1.0]).unwrap();
    let slab = Body::new(Material::from_young(1.0, 0.3).unwrap(), gfmd_green::Height::Finite(0.4)).unwrap();
    let laws: [(bool, std::sync::Arc<dyn Law>); 3] = [
        (true, Exponential::new(1e-4, 0.02).unwrap().into_shared()),
        (true, Dugdale::new(1e-4, 0.02).unwrap().into_shared()),
        (false, Morse::new(1e-4, 0.02).unwrap().into_shared()),
    ];
    for (body, (has_wall, law)) in
        [half_space(), slab].into_iter().flat_map(|body| laws.clone().map(|law| (body.clone(), law)))
    {
        let interface = Interface::new(&body, &grid, &sphere(n), law).unwrap();
        for [first, second] in [[0.004, 0.006], [0.004, -0.001]] {
            for load in [Load::Approach, Load::MeanPressure] {
                let scale = if matches!(load(1.0), Load::MeanPressure(_)) { 0.1 } else { 1.0 };
                let reached = solve(&interface, load(scale * first), None).unwrap();
                assert!(!has_wall || reached.wall_pressure.iter().any(|p| *p > 0.0), "the wall must take part");
                let pressure = reached.pressure().into_owned();
                let (displacement_z, gap) = (reached.displacement_z().to_owned(), reached.gap().to_owned());
                let kept = StoredFields {
                    pressure: &pressure,
                    displacement_z: &displacement_z,
                    gap: &gap,
                    approach: reached.approach,
                };
                let recalled = interface.recall(kept).unwrap();
                assert_eq!(recalled.wall_pressure, reached.wall_pressure);
                assert!((recalled.mean_pressure / reached.mean_pressure - 1.0).abs() < 1e-6);
                assert!(recalled.residual.worst() <= 1e-7, "{:?}", recalled.residual);
                let wanted = solve(&interface, load(scale * second), Some(&reached)).map_err(|error| error.to_string());
                let found = solve(&interface, load(scale * second), Some(&recalled)).map_err(|error| error.to_string());
                assert_eq!(found, wanted);
            }
        }
    }
}

#[test]
fn fields_of_another_problem_are_no_state() {
    let interface =
        Interface::new(&half_space(), &Grid::line(8, 1.0).unwrap(), &wave(8, 0.1), Morse::new(1e-4, 0.02).unwrap())
            .unwrap();
    let (right, wrong, infinite) =
        (Array2::zeros((8, 1)), Array2::zeros((4, 1)), Array2::from_elem((8, 1), f64::INFINITY));
    let recall =
        |pressure, displacement_z, gap| interface.recall(StoredFields { pressure, displacement_z, gap, approach: 0.0 });
    assert!(recall(&right, &right, &right).is_ok());
    assert!(matches!(recall(&wrong, &right, &right), Err(Refusal::Start { found: 4, expected: 8 })));
    assert!(matches!(recall(&right, &infinite, &right), Err(Refusal::NotFinite { .. })));
    assert!(matches!(recall(&infinite, &right, &right), Err(Refusal::NotFinite { .. })));
}

#[test]
fn a_gap_that_is_not_a_number_is_not_free_of_penetration() {
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap());
    let grid = Grid::line(8, 1.0).unwrap();
    let heights = Array2::from_shape_fn((8, 1), |(i, _)| (i as f64).sin());
    let (gap, pressure) = (Array2::from_elem((8, 1), f64::NAN), Array2::zeros((8, 1)));
    for law in [HardWall.into_shared(), Exponential::new(1e-3, 0.1).unwrap().into_shared()] {
        let interface = Interface::new(&body, &grid, &heights, law).unwrap();
        for load in [Load::MeanPressure(0.1), Load::Approach(0.1)] {
            let residual = interface.certify(&gap, &pressure, load.into()).unwrap().residual;
            assert!(residual.penetration.is_nan(), "{residual:?}");
            assert!(residual.worst().is_nan(), "{residual:?}");
        }
    }
}
