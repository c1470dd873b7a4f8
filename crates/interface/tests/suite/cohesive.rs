//! Laws in all components.

use std::f64::consts::TAU;

use std::sync::Arc;

use gfmd_contact::{Drive, Equilibrium, Load, Refusal, SolveError, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Interface, State};
use gfmd_law::{CoupledExponential, Exponential, Law, Morse, Npb, Npc, Separation, XuNeedleman};
use gfmd_response::{FullResponse, NormalResponse};
use ndarray::Array2;

const EQUAL: Separation =
    Separation { normal_work: 5e-4, tangential_work: 5e-4, normal_length: 0.02, tangential_length: 0.02 };

fn slab(points: [usize; 2]) -> Arc<FullResponse> {
    let body = Body::slab(Material::from_young(1.0, 0.3).unwrap(), 0.5).unwrap();
    FullResponse::new(Grid::new(points, [1.0, 1.0]).unwrap(), &body).into()
}

fn bumps(points: [usize; 2]) -> Array2<f64> {
    let wave = |i: usize, n: usize, k: f64| (TAU * k * i as f64 / n as f64 + k).cos();
    Array2::from_shape_fn((points[0], points[1]), |(i, j)| {
        0.01 * (wave(i, points[0], 1.0) * wave(j, points[1], 1.0) + 0.4 * wave(i, points[0], 2.0))
    })
}

fn solve(
    interface: &Interface,
    drive: impl Into<Drive>,
    solver: Solver,
    start: Option<&State>,
) -> Result<State, SolveError<State>> {
    interface.press(drive).solver(solver).starting_from(start).solve()
}

fn far(a: &State, b: &State) -> f64 {
    a.displacement.iter().zip(&b.displacement).fold(0.0, |worst, (a, b)| worst.max((a - b).abs()))
}

#[test]
fn newton_and_dynamics_find_the_same_states() {
    for points in [[32, 1], [16, 15]] {
        let response = slab(points);
        let heights = bumps(points);
        let laws = [XuNeedleman::new(EQUAL, 0.5).unwrap().into_shared(), Npc::new(EQUAL).unwrap().into_shared()];
        for law in laws {
            let interface = Interface::with_response(response.clone(), &heights, law.clone()).unwrap();
            assert_eq!(interface.trapping(), None);
            for (load, lateral) in [
                (Load::Approach(0.004), [0.003, 0.0]),
                (Load::Approach(-0.01), [0.0, 0.002]),
                (Load::MeanPressure(0.01), [-0.002, 0.001]),
            ] {
                let drive = Drive { load, lateral, time: 0.0, distance: 0.0 };
                let a = solve(&interface, drive, Solver::Newton, None).unwrap();
                let dynamics = [Solver::Fire, Solver::Fire2].map(|version| {
                    let b = solve(&interface, drive, version, None).unwrap();
                    assert!(far(&a, &b) < 1e-7, "{law:?} {drive:?} {version}: {}", far(&a, &b));
                    assert!(a.lowest_curvature > 0.0 && a.effort.transform_pairs < b.effort.transform_pairs);
                    b.effort.iterations
                });
                // The two versions are different methods.
                assert_ne!(dynamics[0], dynamics[1]);
            }
        }
    }
}

#[test]
fn dynamics_agrees_behind_a_wall_and_on_a_half_space() {
    let points = [24, 20];
    let body = Body::half_space(Material::from_young(1.0, 0.3).unwrap());
    let response = Arc::new(NormalResponse::new(Grid::new(points, [1.0, 1.0]).unwrap(), &body));
    let heights = bumps(points);
    let laws: [(Arc<dyn Law>, Load); 3] = [
        (Arc::new(Exponential::new(3e-4, 8e-3).unwrap()), Load::MeanPressure(0.01)),
        (Arc::new(Morse::new(3e-4, 8e-3).unwrap()), Load::Approach(0.002)),
        (Arc::new(Morse::new(3e-4, 8e-3).unwrap()), Load::MeanPressure(-0.002)),
    ];
    for (law, drive) in laws {
        let interface = Interface::with_response(response.clone(), &heights, law.clone()).unwrap();
        let a = solve(&interface, drive, Solver::Newton, None).unwrap();
        let b = solve(&interface, drive, Solver::Fire2, None).unwrap();
        assert!(far(&a, &b) < 1e-7, "{law:?} {drive:?}: {}", far(&a, &b));
    }
    let wall = Exponential::new(3e-4, 8e-3).unwrap();
    let interface = Interface::with_response(response.clone(), &heights, wall).unwrap();
    let refused = solve(&interface, Load::Approach(0.002), Solver::Fire2, None);
    assert!(matches!(refused, Err(SolveError::Refused(Refusal::NoDynamics))));
}

#[test]
fn laws_without_energy_come_to_rest_by_dynamics() {
    let points = [16, 16];
    let response = slab(points);
    let heights = bumps(points);
    let unequal = Separation { tangential_work: 2e-4, ..EQUAL };
    let laws = [CoupledExponential::new(unequal).unwrap().into_shared(), Npb::new(unequal).unwrap().into_shared()];
    for law in laws {
        let interface = Interface::with_response(response.clone(), &heights, law.clone()).unwrap();
        let drive = Drive { load: Load::Approach(0.005), lateral: [0.004, 0.002], time: 0.0, distance: 0.0 };
        assert!(matches!(solve(&interface, drive, Solver::Newton, None), Err(SolveError::Refused(Refusal::NoEnergy))));
        let state = solve(&interface, drive, Solver::Auto, None).unwrap();
        assert!(state.residual.worst() <= 1e-8 && state.mean_shear[0] > state.mean_shear[1]);
        assert!(state.mean_shear[1] > 0.0, "the rigid surface drags the elastic one along");
    }
}

#[test]
fn a_bonded_flat_opens_and_slides_as_one_point() {
    // Uniform: the slab is a spring of stiffness C11/h, C44/h in series with the law.
    let response = slab([8, 8]);
    let heights = Array2::zeros((8, 8));
    let law = XuNeedleman::new(EQUAL, 0.5).unwrap();
    let interface = Interface::with_response(response.clone(), &heights, law).unwrap();
    let drive = Drive { load: Load::Approach(-0.004), lateral: [0.005, -0.003], time: 0.0, distance: 0.0 };
    let state = solve(&interface, drive, Solver::Auto, None).unwrap();
    let [gx, gy, gz] = response.uniform_compliance();
    let u = state.displacement.index_axis(ndarray::Axis(1), 3).index_axis(ndarray::Axis(1), 5).to_vec();
    let traction = law.traction(0.004 - u[2], [0.005 - u[0], -0.003 - u[1]]);
    for ((u, g), t) in u.iter().zip([gx, gy, gz]).zip(traction) {
        assert!((u - g * t).abs() < 1e-12, "{u} {}", g * t);
    }
}

#[test]
fn the_energy_grows_by_the_work_of_the_rigid_surface() {
    // The relation dU = p̄ dδ + τ̄·dX along a smooth path checks energies, pressure and shear together.
    let points = [24, 21];
    let heights = bumps(points);
    let law = XuNeedleman::new(EQUAL, 0.5).unwrap();
    let slab = slab(points);
    let half_space = FullResponse::new(*slab.grid(), &Body::half_space(Material::from_young(1.0, 0.2).unwrap()));
    for response in [slab, half_space.into()] {
        let interface = Interface::with_response(response.clone(), &heights, law).unwrap();
        let at = |d: [f64; 3]| {
            let drive = Drive {
                load: Load::Approach(0.002 + d[2]),
                lateral: [0.003 + d[0], -0.001 + d[1]],
                time: 0.0,
                distance: 0.0,
            };
            interface.press(drive).tolerance(1e-12).solve().unwrap()
        };
        let energy = |d: [f64; 3]| {
            let state = at(d);
            state.elastic_energy + state.interface_energy
        };
        let rest = at([0.0; 3]);
        let h = 1e-5;
        let works = [rest.mean_shear[0], rest.mean_shear[1], rest.mean_pressure];
        for (axis, work) in works.into_iter().enumerate() {
            let step = |h: f64| std::array::from_fn(|c| if c == axis { h } else { 0.0 });
            let slope = (energy(step(h)) - energy(step(-h))) / (2.0 * h);
            assert!((slope - work).abs() < 1e-6 * (1e-3 + work.abs()), "{axis}: {slope} {work}");
        }
    }
}

#[test]
fn flat_surfaces_that_attract_do_not_stay_flat() {
    // The uniform state is in equilibrium at any distance, but unstable if γ/ϱ² e^(−g/ϱ) exceeds the softest stiffness,
    // π E*/L: waves grow. Its force vanishes, so that only a search in all directions finds the instability.
    let n = 64;
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap());
    let response = NormalResponse::new(Grid::line(n, 1.0).unwrap(), &body);
    let heights = Array2::zeros((n, 1));
    let (energy, range) = (1e-3, 0.01);
    let law = Exponential::new(energy, range).unwrap();
    let interface = Interface::with_response(response, &heights, law).unwrap();
    let critical = range * (energy / (range * range) / std::f64::consts::PI).ln();
    let stays = solve(&interface, Load::Approach(-1.05 * critical), Solver::Auto, None).unwrap();
    let spread = |state: &State| state.gap.std(0.0);
    assert!(spread(&stays) < 1e-12);
    assert!(stays.lowest_curvature > 0.0);
    assert!(!stays.passed_instability);
    let ripples = solve(&interface, Load::Approach(-0.95 * critical), Solver::Auto, Some(&stays)).unwrap();
    assert!(ripples.passed_instability && ripples.lowest_curvature > 0.0);
    assert!(spread(&ripples) > 0.1 * range, "{}", spread(&ripples));
    assert!(ripples.residual.worst() <= 1e-8);
}

#[test]
fn a_step_too_long_for_a_short_range_is_shortened_not_lost() {
    // The wall approaches by three ranges in one step: trial steps overflow the repulsion.
    let points = [32, 32];
    let grid = Grid::new(points, [1.0, 1.0]).unwrap();
    let response = NormalResponse::new(grid, &Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap()));
    let heights = bumps(points);
    let law = Morse::new(1e-4, 1e-4).unwrap();
    let interface = Interface::with_response(response, &heights, law).unwrap();
    let mut last = solve(&interface, Load::Approach(0.0005), Solver::Newton, None).unwrap();
    for step in 1..6 {
        last = solve(&interface, Load::Approach(0.0005 + 3e-4 * f64::from(step)), Solver::Newton, Some(&last)).unwrap();
        assert!(last.residual.worst() <= 1e-8 && last.lowest_curvature > 0.0);
    }
}
