//! Adhesive contact against closed forms.

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use gfmd_contact::{Contact, Equilibrium, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Drive, Interface, InterfaceError, Settings, State};
use gfmd_law::{Dugdale, Exponential, HardWall, Law, Morse};
use gfmd_response::{FullResponse, NormalResponse};
use ndarray::Array2;

fn half_space(grid: Grid) -> NormalResponse {
    NormalResponse::new(grid, &Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap()))
}

fn solve(interface: &Interface, drive: Drive, start: Option<&State>) -> Result<State, InterfaceError> {
    interface.solve(drive, &Settings::default(), start, &mut |_| ControlFlow::Continue(()))
}

fn wave(n: usize, amplitude: f64) -> Array2<f64> {
    Array2::from_shape_fn((n, 1), |(i, _)| amplitude * (TAU * i as f64 / n as f64).cos())
}

/// Johnson (1995): mean pressure of an adhesive wavy surface of unit wavelength in contact over the share `a` of it, E* = 1.
fn johnson(a: f64, amplitude: f64, work: f64) -> f64 {
    let angle = 0.5 * PI * a;
    PI * amplitude * angle.sin().powi(2) - (2.0 * work * angle.tan()).sqrt()
}

#[test]
fn an_adhesive_wave_comes_near_the_closed_form_as_the_range_falls() {
    let (amplitude, work) = (0.01, 5e-5);
    let errors: Vec<f64> = [(512, 1.2e-3), (1024, 6e-4), (2048, 3e-4)]
        .into_iter()
        .map(|(n, range)| {
            let response = half_space(Grid::line(n, 1.0).unwrap());
            let law = Exponential::new(work, range).unwrap();
            let heights = wave(n, amplitude);
            let interface = Interface::normal(&response, heights.view(), &law).unwrap();
            assert_eq!(interface.trapping(), None);
            let pressed = solve(&interface, Drive::approach(0.004), None).unwrap();
            let mut worst = 0.0_f64;
            for approach in [0.002, 0.0, -0.002] {
                let state = solve(&interface, Drive::approach(approach), Some(&pressed)).unwrap();
                assert!(state.lowest_curvature > 0.0);
                let error = (state.mean_pressure - johnson(state.contact_fraction, amplitude, work)).abs();
                worst = worst.max(error / (PI * amplitude));
            }
            worst
        })
        .collect();
    assert!(errors[2] < 0.003, "{errors:?}");
    assert!(errors.windows(2).all(|pair| pair[1] < 0.45 * pair[0]), "{errors:?}");
}

/// Maugis (1992): radius of contact a and load P of an adhesive sphere with a Dugdale zone out to m a, in units
/// (π w R²/K)^⅓ and π w R.
fn maugis(lambda: f64, m: f64) -> [f64; 2] {
    let (root, arc) = ((m * m - 1.0).sqrt(), (1.0 / m).acos());
    let b = 0.5 * lambda * (root + (m * m - 2.0) * arc);
    let c = 4.0 / 3.0 * lambda * lambda * (root * arc - m + 1.0);
    // b a² + c a = 1, with c < 0 or above.
    let a = (-c + (c * c + 4.0 * b).sqrt()) / (2.0 * b);
    [a, a.powi(3) - lambda * a * a * (root + m * m * arc)]
}

fn sphere(n: usize) -> Array2<f64> {
    let at = |i: usize| (i as f64 / n as f64 - 0.5).powi(2);
    Array2::from_shape_fn((n, n), |(i, j)| -0.5 * (at(i) + at(j)))
}

#[test]
fn a_sphere_with_a_dugdale_zone_is_that_of_maugis() {
    // R = 1, E* = 1, K = 4/3; λ = 2 σ₀ (R/π w K²)^⅓ = 1.
    let (work, modulus, lambda) = (2.17e-4, 4.0 / 3.0, 1.0);
    let strength = 0.5 * lambda * (PI * work * modulus * modulus).cbrt();
    let law = Dugdale::new(work, work / strength).unwrap();
    let radius = (PI * work / modulus).cbrt();
    let branch: Vec<[f64; 2]> = (1..4000).map(|i| maugis(lambda, 1.0 + 1e-3 * f64::from(i))).collect();
    let pull_off = branch.iter().map(|[_, load]| *load).fold(f64::INFINITY, f64::min);
    let errors: Vec<[f64; 2]> = [64, 128, 256]
        .into_iter()
        .map(|n| {
            let response = half_space(Grid::square(n, 1.0).unwrap());
            let heights = sphere(n);
            let interface = Interface::normal(&response, heights.view(), &law).unwrap();
            let mut last: Option<State> = None;
            let (mut lowest, mut worst) = (0.0_f64, 0.0_f64);
            for step in 0..26 {
                let approach = 0.010 - 0.0005 * f64::from(step);
                let state = solve(&interface, Drive::approach(approach), last.as_ref()).unwrap();
                let load = state.mean_pressure / (PI * work);
                lowest = lowest.min(load);
                let a = (state.contact_fraction / PI).sqrt() / radius;
                // The branch is passed from large a; P(a) is single-valued.
                let of_a = branch.iter().min_by(|x, y| (x[0] - a).abs().total_cmp(&(y[0] - a).abs())).unwrap();
                if a > 1.0 {
                    worst = worst.max((of_a[1] - load).abs());
                }
                last = Some(state);
            }
            [(lowest - pull_off).abs() / pull_off.abs(), worst]
        })
        .collect();
    // The edge snaps from node to node, so that pull-off comes late by an error of first order.
    assert!(errors[2][0] < 0.04 && errors[2][1] < 0.15, "{errors:?}");
    assert!(errors.windows(2).all(|pair| pair[1][0] < 0.7 * pair[0][0] && pair[1][1] < 0.7 * pair[0][1]), "{errors:?}");
}

#[test]
fn a_sphere_of_short_range_pulls_off_at_the_load_of_jkr() {
    let (work, n) = (4e-4, 256);
    let response = half_space(Grid::square(n, 1.0).unwrap());
    let heights = sphere(n);
    for (range, tolerance) in [(4e-3, 0.1), (1.6e-3, 0.04)] {
        let law = Exponential::new(work, range).unwrap();
        let interface = Interface::normal(&response, heights.view(), &law).unwrap();
        let mut last: Option<State> = None;
        let mut lowest = 0.0_f64;
        for step in 0..14 {
            let approach = 0.002 - 0.001 * f64::from(step);
            let state = solve(&interface, Drive::approach(approach), last.as_ref()).unwrap();
            lowest = lowest.min(state.mean_pressure);
            last = Some(state);
        }
        let ratio = lowest / (-1.5 * PI * work);
        assert_eq!(interface.trapping(), None);
        assert!((ratio - 1.0).abs() < tolerance, "{ratio}");
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
        let response = NormalResponse::new(grid, &body);
        let heights = rough(points);
        let interface = Interface::normal(&response, heights.view(), &HardWall).unwrap();
        let contact = Contact::new(&body, &grid, &heights).unwrap();
        for (drive, control) in
            [(Drive::mean_pressure(0.02), Load::MeanPressure(0.02)), (Drive::approach(0.008), Load::Approach(0.008))]
        {
            let wanted = contact.press(control).tolerance(1e-11).solve().unwrap();
            let settings = Settings { tolerance: 1e-11, ..Settings::default() };
            let found = interface.solve(drive, &settings, None, &mut |_| ControlFlow::Continue(())).unwrap();
            let error = (&found.wall_pressure - &wanted.pressure).iter().fold(0.0_f64, |worst, e| worst.max(e.abs()));
            assert!(error < 1e-8 * wanted.mean_pressure, "{points:?} {drive:?}: {error}");
            assert!((found.approach - wanted.approach).abs() < 1e-10 && found.iterations < 40, "{}", found.iterations);
            assert!((found.mean_pressure - wanted.mean_pressure).abs() < 1e-10);
        }
    }
}

#[test]
fn without_shear_all_components_find_what_u_z_alone_finds() {
    // Odd, so that no component is missing at Nyquist.
    let points = [33, 31];
    let body = Body::slab(Material::from_young(1.0, 0.3).unwrap(), 0.3).unwrap();
    let grid = Grid::new(points, [1.0, 1.0]).unwrap();
    let (normal, full) = (NormalResponse::new(grid, &body), FullResponse::new(grid, &body));
    let heights = rough(points);
    for law in [&Exponential::new(2e-4, 4e-3).unwrap() as &dyn Law, &Morse::new(2e-4, 4e-3).unwrap()] {
        let one = Interface::normal(&normal, heights.view(), law).unwrap();
        let all = Interface::full(&full, heights.view(), law).unwrap();
        for drive in [Drive::mean_pressure(0.01), Drive::approach(0.006), Drive::approach(-0.002)] {
            let (a, b) = (solve(&one, drive, None).unwrap(), solve(&all, drive, None).unwrap());
            let error = (&a.gap - &b.gap).iter().fold(0.0_f64, |worst, e| worst.max(e.abs()));
            assert!(error < 1e-8, "{law:?} {drive:?}: {error}");
            assert!((a.elastic_energy - b.elastic_energy).abs() < 1e-8 * a.elastic_energy);
        }
    }
}

#[test]
fn surfaces_jump_into_contact_and_out_of_it_at_different_distances() {
    let n = 256;
    let response = half_space(Grid::line(n, 1.0).unwrap());
    let law = Exponential::new(4e-4, 3e-3).unwrap();
    let heights = wave(n, 0.01);
    let interface = Interface::normal(&response, heights.view(), &law).unwrap();
    let approaches: Vec<f64> = (0..60).map(|i| -0.025 + 0.0005 * f64::from(i)).collect();
    let mut last: Option<State> = None;
    let mut branch = |approaches: &mut dyn Iterator<Item = f64>| -> Vec<State> {
        approaches
            .map(|approach| {
                let state = solve(&interface, Drive::approach(approach), last.as_ref()).unwrap();
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
    // The loop takes work: on the way out the surfaces pull harder. Where they are the same there is no difference.
    for (a, b) in loading.iter().zip(&unloading) {
        assert!(b.mean_pressure <= a.mean_pressure + 1e-9, "{} {}", a.mean_pressure, b.mean_pressure);
        assert!(a.lowest_curvature > 0.0 && b.lowest_curvature > 0.0);
        // Both are states of one energy; the downhill branch of each jump keeps the deeper one after it.
        assert!((a.gap[[n / 2, 0]] >= 0.0) && (b.gap[[0, 0]] >= 0.0));
    }
    let total = |state: &State| state.elastic_energy + state.interface_energy;
    assert!(total(&loading[jump_in]) <= total(&unloading[jump_in]) + 1e-12);
}

#[test]
fn what_cannot_hold_parts_and_says_so() {
    let n = 128;
    let response = half_space(Grid::line(n, 1.0).unwrap());
    let law = Exponential::new(1e-4, 3e-3).unwrap();
    let heights = wave(n, 0.01);
    let interface = Interface::normal(&response, heights.view(), &law).unwrap();
    let touching = solve(&interface, Drive::mean_pressure(0.001), None).unwrap();
    let held = solve(&interface, Drive::mean_pressure(-0.001), Some(&touching)).unwrap();
    assert!((held.mean_pressure + 0.001).abs() < 1e-9);
    match solve(&interface, Drive::mean_pressure(-0.01), Some(&held)) {
        Err(InterfaceError::Detached { mean_pressure, state }) => {
            assert!(mean_pressure == -0.01 && state.contact_fraction == 0.0);
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn bad_input_is_refused_with_what_was_found() {
    let response = half_space(Grid::square(8, 1.0).unwrap());
    let heights = rough([8, 8]);
    let law = HardWall;
    let interface = Interface::normal(&response, heights.view(), &law).unwrap();
    let message = |drive: Drive, tolerance: f64| {
        let settings = Settings { tolerance, ..Settings::default() };
        interface.solve(drive, &settings, None, &mut |_| ControlFlow::Continue(())).unwrap_err().to_string()
    };
    assert_eq!(message(Drive::mean_pressure(f64::NAN), 1e-8), "the mean pressure is NaN; it must be finite");
    assert_eq!(message(Drive::approach(0.01), 0.0), "the tolerance is 0e0; allowed are 1e-14 to 0.1");
    assert!(message(Drive::approach(1.0), 1e-8).contains("the approach is 1; this body would be in full contact at"));
    let lateral = Drive { lateral: [0.0, f64::INFINITY], ..Drive::approach(0.001) };
    assert_eq!(message(lateral, 1e-8), "the lateral displacement is inf; it must be finite");
    let other = rough([9, 8]);
    assert!(matches!(
        Interface::normal(&response, other.view(), &law),
        Err(InterfaceError::Shape { found: [9, 8], .. })
    ));
    let mut holed = heights.clone();
    holed[[3, 4]] = f64::NAN;
    assert!(matches!(
        Interface::normal(&response, holed.view(), &law),
        Err(InterfaceError::Height { index: [3, 4], .. })
    ));
    let steep = Exponential::new(1.0, 1e-3).unwrap();
    let steep = Interface::normal(&response, heights.view(), &steep).unwrap();
    assert!(steep.trapping().unwrap().to_string().starts_with("lattice trapping"));
    let limited = Settings { max_iterations: 1, ..Settings::default() };
    let stopped = interface.solve(Drive::mean_pressure(0.01), &limited, None, &mut |_| ControlFlow::Continue(()));
    assert!(matches!(stopped, Err(InterfaceError::NotConverged { .. })));
    let broken =
        interface.solve(Drive::mean_pressure(0.01), &Settings::default(), None, &mut |_| ControlFlow::Break(()));
    assert!(matches!(broken, Err(InterfaceError::Interrupted { .. })));
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let response = half_space(Grid::square(96, 1.0).unwrap());
    let heights = rough([96, 96]);
    let law = Exponential::new(2e-4, 2e-3).unwrap();
    let interface = Interface::normal(&response, heights.view(), &law).unwrap();
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solve(&interface, Drive::mean_pressure(0.005), None).unwrap())
    };
    assert_eq!(with(1), with(3));
}
