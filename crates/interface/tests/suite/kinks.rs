//! A wall that gives way below a law: hardness and springs.

use std::ops::ControlFlow;

use gfmd_contact::{
    Boundary, Budget, Contact, Cotangents, Equilibrium, Fields as _, GradientError, Hardness, Load, MemoryCheckpoint,
    Progress, Refusal, Resumable, SolveError, Solver, Visit, Watch,
};
use gfmd_field::Grid;
use gfmd_green::{Body, Height, Material};
use gfmd_interface::{Interface, State, StoredFields};
use gfmd_law::{Exponential, HardWall, Law, Morse};
use ndarray::Array2;

const N: usize = 16;

fn body() -> Body {
    Body::half_space(Material::from_contact_modulus(1.0, 0.3).unwrap())
}

fn grid() -> Grid {
    Grid::square(N, 1.0).unwrap()
}

/// Heights of the reference values below, at the centres of the cells.
fn waves(n: usize) -> Array2<f64> {
    let turn = std::f64::consts::TAU;
    Array2::from_shape_fn((n, n), |(i, j)| {
        let [x, y] = [i, j].map(|k| turn * (k as f64 + 0.5) / n as f64);
        0.02 * (x + 0.3).cos() * (y - 0.7).cos() + 0.008 * (2.0 * x + y + 1.1).cos() + 0.004 * (x - 3.0 * y + 2.0).cos()
    })
}

fn exponential() -> Exponential {
    Exponential::new(2e-4, 0.01).unwrap()
}

fn periodic(law: impl Law + 'static) -> Interface {
    Interface::new(&body(), &grid(), &waves(N), law).unwrap()
}

fn solve(interface: &Interface, load: Load, start: Option<&State>) -> State {
    let budget = Budget { tolerance: 1e-10, max_iterations: 400 };
    let solved = interface.press(load).budget(budget).starting_from(start).solve();
    solved.unwrap_or_else(|error| panic!("{load:?}: {error}"))
}

/// Numbers of a reference state: mean pressure, approach, points in contact, largest repulsion, largest and least
/// pressure, elastic energy, energy of the law, mean worn or pressed depth, its work.
type Reference = [f64; 10];

fn compare(name: &str, found: Reference, expected: Reference) {
    // Relative to the size of each number along the path.
    let scales = [0.02, 0.03, 1e-300, 0.17, 0.15, 0.15, 1.3e-4, 1.7e-4, 2e-3, 5e-5];
    for (k, ((found, expected), scale)) in found.into_iter().zip(expected).zip(scales).enumerate() {
        let error = (found - expected).abs() / scale;
        assert!(error <= 2e-7, "{name}, number {k}: {found:e} instead of {expected:e}, error {error:e}");
    }
}

/// Loads of the reference paths, and sliding distances.
const PATH: [[f64; 2]; 4] = [[0.01, 0.02], [0.02, 0.05], [0.02, 0.09], [0.012, 0.1]];

/// Follows the reference path with a hardness and a wear coefficient, if any; the depth is added to the clearance after
/// each step. Returns the numbers of each state.
fn follow(law: impl Law + 'static, hardness: Option<f64>, coefficient: f64) -> Vec<Reference> {
    let virgin = periodic(law);
    let mut depth = Array2::zeros((N, N));
    let mut start: Option<State> = None;
    let mut slid = 0.0;
    let mut numbers = Vec::new();
    for [load, distance] in PATH {
        let compliance = coefficient * (distance - slid);
        slid = distance;
        let mut interface = virgin.with_indentation(&depth).unwrap().with_springs(compliance).unwrap();
        if let Some(hardness) = hardness {
            interface = interface.with_hardness(hardness).unwrap();
        }
        let state = solve(&interface, Load::MeanPressure(load), start.as_ref());
        let mut growth = compliance * &state.wall_pressure;
        if let Some(pressed) = &state.pressed_in {
            growth += pressed;
        }
        depth += &growth;
        let pressure = state.pressure().into_owned();
        let most = |field: &Array2<f64>| field.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        numbers.push([
            state.mean_pressure,
            state.approach,
            state.contact_fraction * (N * N) as f64,
            most(&state.wall_pressure),
            most(&pressure),
            -most(&-&pressure),
            state.elastic_energy,
            state.interface_energy,
            depth.mean().unwrap(),
            (&pressure * &growth).mean().unwrap(),
        ]);
        assert!(state.residual.worst() <= 1e-10 && state.gap.iter().all(|gap| *gap >= 0.0), "{:?}", state.residual);
        start = Some(state);
    }
    numbers
}

/// Compares a path with the values of a dense semismooth Newton method for all unknowns at once on the same discrete
/// problem, which is independent of this crate; its residuals are below 1e-14.
fn meets(law: impl Law + 'static, hardness: Option<f64>, coefficient: f64, expected: [Reference; 4]) {
    for (k, (found, expected)) in follow(law, hardness, coefficient).into_iter().zip(expected).enumerate() {
        compare(&format!("step {k}"), found, expected);
    }
}

#[test]
fn a_hard_surface_below_a_law_meets_the_dense_reference() {
    let expected = [
        [
            0.01,
            0.0239033141456,
            96.0,
            0.11,
            0.09,
            -0.019958932806,
            8.15910083674e-05,
            -0.000133469497551,
            0.000250542497827,
            2.25488248044e-05,
        ],
        [
            0.02,
            0.0267766670521,
            127.0,
            0.11,
            0.09,
            -0.0198832426681,
            0.000123810458603,
            -0.000157972980877,
            0.000524924213438,
            2.4694354405e-05,
        ],
        [
            0.02,
            0.0267766670521,
            127.0,
            0.11,
            0.09,
            -0.0198832426681,
            0.000123810458603,
            -0.000157972980877,
            0.000524924213438,
            0.0,
        ],
        [
            0.012,
            0.0251046537958,
            105.0,
            0.0979122672451,
            0.0779122672451,
            -0.0199120410537,
            8.12513054005e-05,
            -0.000141773279335,
            0.000524924213438,
            0.0,
        ],
    ];
    meets(exponential(), Some(0.09), 0.0, expected);
}

#[test]
fn a_worn_surface_below_a_law_meets_the_dense_reference() {
    let expected = [
        [
            0.01,
            0.024180171356,
            99.0,
            0.171814115637,
            0.151814115637,
            -0.0198217623632,
            9.50502797098e-05,
            -0.000135856052291,
            0.00028302726275,
            1.88644881081e-05,
        ],
        [
            0.02,
            0.0276384387489,
            146.0,
            0.174659455104,
            0.154659455104,
            -0.0199200506187,
            0.000133846744342,
            -0.000163098171844,
            0.000936603972068,
            4.4509244623e-05,
        ],
        [
            0.02,
            0.029065552144,
            166.0,
            0.157900998491,
            0.137900998491,
            -0.0198980421584,
            0.00011451435753,
            -0.000169161031321,
            0.00182259044724,
            5.23592984235e-05,
        ],
        [
            0.012,
            0.0284405128195,
            142.0,
            0.142954371399,
            0.122954371399,
            -0.019991246718,
            8.67395065323e-05,
            -0.000161144768775,
            0.0019912773085,
            8.78903407387e-06,
        ],
    ];
    meets(exponential(), None, 0.6, expected);
}

#[test]
fn a_hard_worn_surface_meets_the_dense_reference() {
    let expected = [
        [0.01, 0.0211586293621, 55.0, 0.09, 0.09, 0.0, 4.47429788812e-05, 0.0, 0.000249464360892, 1.97395631019e-05],
        [
            0.02,
            0.02533836812,
            99.0,
            0.09,
            0.09,
            -9.59483985552e-18,
            7.5049766331e-05,
            0.0,
            0.000721199478923,
            3.36951779237e-05,
        ],
        [
            0.02,
            0.0264104305164,
            109.0,
            0.0856563374594,
            0.0856563374594,
            0.0,
            6.71102498544e-05,
            0.0,
            0.00120119947892,
            2.87192083308e-05,
        ],
        [
            0.012,
            0.0248654803395,
            88.0,
            0.0709812965197,
            0.0709812965197,
            -1.56197119379e-18,
            3.84303532758e-05,
            0.0,
            0.00127319947892,
            3.59866820291e-06,
        ],
    ];
    meets(HardWall, Some(0.09), 0.6, expected);
}

fn largest(field: &Array2<f64>) -> f64 {
    field.iter().fold(0.0, |most: f64, value| most.max(value.abs()))
}

/// Returns the largest difference of pressures and gaps, relative to the largest values, and of the approaches.
fn difference(a: &State, b: &State) -> f64 {
    let pressures = [a, b].map(|state| state.pressure().into_owned());
    let pressure = largest(&(&pressures[0] - &pressures[1])) / largest(&pressures[1]);
    let gap = largest(&(&a.gap - &b.gap)) / largest(&b.gap);
    let repulsion = largest(&(&a.wall_pressure - &b.wall_pressure)) / largest(&b.wall_pressure).max(1e-300);
    [pressure, gap, repulsion, (a.approach - b.approach).abs() / largest(&b.gap)].into_iter().fold(0.0, f64::max)
}

/// Returns interfaces on a half-space, on a slab, and on a patch with free boundaries.
fn interfaces(law: impl Law + Clone + 'static) -> [(&'static str, Interface); 3] {
    let slab = Body::new(Material::from_young(1.0, 0.3).unwrap(), Height::Finite(0.4)).unwrap();
    let free = Interface::with_boundary(Boundary::Free, &body(), &grid(), &waves(N), law.clone()).unwrap();
    let slab = Interface::new(&slab, &grid(), &waves(N), law.clone()).unwrap();
    [("half-space", periodic(law)), ("slab", slab), ("patch", free)]
}

/// Returns contacts of a wall alone, as [`interfaces`].
fn contacts() -> [Contact; 3] {
    let slab = Body::new(Material::from_young(1.0, 0.3).unwrap(), Height::Finite(0.4)).unwrap();
    [
        Contact::new(&body(), &grid(), &waves(N)).unwrap(),
        Contact::new(&slab, &grid(), &waves(N)).unwrap(),
        Contact::with_boundary(Boundary::Free, &body(), &grid(), &waves(N)).unwrap(),
    ]
}

const LOADS: [Load; 4] =
    [Load::MeanPressure(0.004), Load::MeanPressure(0.02), Load::Approach(0.01), Load::Approach(0.022)];

/// Returns a field without symmetry, from 0 to 1.
fn uneven() -> Array2<f64> {
    Array2::from_shape_fn((N, N), |(i, j)| (0.618_033_988_75 * (7 * i + 3 * j + i * j) as f64).fract())
}

#[test]
fn a_wall_that_hardly_gives_way_is_a_wall() {
    for (name, law) in interfaces(exponential()) {
        let hard = law.clone().with_hardness(1e4).unwrap();
        let none = law.clone().with_springs(0.0).unwrap();
        let rigid = law.clone().with_springs(1e-13).unwrap();
        let stiff = law.clone().with_springs(1e-10).unwrap();
        let partly = law.clone().with_springs(uneven().mapv(|x| if x > 0.5 { 1e-10 } else { 0.0 })).unwrap();
        for load in LOADS {
            let expected = solve(&law, load, None);
            assert_eq!(solve(&none, load, None), expected, "{name}, {load:?}");
            assert_eq!(solve(&rigid, load, None), expected, "{name}, {load:?}");
            let found = solve(&hard, load, None);
            assert!(difference(&found, &expected) <= 1e-9, "{name}, {load:?}: {:e}", difference(&found, &expected));
            assert_eq!(largest(found.pressed_in.as_ref().unwrap()), 0.0);
            assert!((found.interface_energy / expected.interface_energy - 1.0).abs() < 1e-9);
            for stiff in [&stiff, &partly] {
                let found = solve(stiff, load, None);
                assert!(difference(&found, &expected) <= 2e-8, "{name}, {load:?}: {:e}", difference(&found, &expected));
            }
        }
    }
}

#[test]
fn springs_act_linearly_where_they_are_stiff() {
    let law = periodic(exponential());
    let wall = solve(&law, Load::MeanPressure(0.02), None);
    // Half the compliance changes the approach by half as much, and the small differences are resolved.
    let moved = |compliance: f64| {
        let state = solve(&law.clone().with_springs(compliance).unwrap(), Load::MeanPressure(0.02), None);
        (state.approach - wall.approach) / compliance
    };
    let (whole, half) = (moved(1e-6), moved(5e-7));
    assert!(whole > 0.0 && (half / whole - 1.0).abs() < 1e-3, "{whole} and {half}");
}

#[test]
fn a_wall_without_attraction_is_a_contact_with_hardness_and_springs() {
    let weak = Exponential::new(1e-12, 0.01).unwrap();
    for (law, tolerance) in [(HardWall.into_shared(), 1e-8), (weak.into_shared(), 1e-7)] {
        for ((name, interface), contact) in interfaces(law).into_iter().zip(contacts()) {
            for (hardness, compliance) in [(0.09, 0.0), (0.045, 0.0), (1e3, 0.3), (0.09, 0.3), (0.03, 2.0)] {
                let interface = interface.clone().with_hardness(hardness).unwrap().with_springs(compliance).unwrap();
                let contact = if compliance > 0.0 { contact.softened(compliance).unwrap() } else { contact.clone() };
                let contact = contact.with_hardness(hardness).unwrap();
                // The last two close nearly all gaps: nearly all points carry the hardness.
                let near = [0.95, 0.999].map(|part| Load::MeanPressure(part * hardness));
                let near = near.into_iter().filter(|_| hardness < 0.1);
                let deep = [0.05, 0.3].map(Load::Approach).into_iter().filter(|_| name == "half-space");
                for load in LOADS.into_iter().chain(near).chain(deep) {
                    let budget = Budget { tolerance: 1e-10, max_iterations: 20_000 };
                    let expected = contact.press(load).budget(budget).solve().unwrap();
                    let found = solve(&interface, load, None);
                    let case = format!("{name}, {hardness}, {compliance}, {load:?}");
                    let pressure = largest(&(&found.wall_pressure - &expected.pressure)) / largest(&expected.pressure);
                    let extent = largest(&expected.gap).max(0.01);
                    let gap = largest(&(&found.gap - &expected.gap.mapv(|g| g.max(0.0)))) / extent;
                    let depth = found.pressed_in.as_ref().unwrap() - &expected.plastic.as_ref().unwrap().depth;
                    let approach = (found.approach - expected.approach).abs() / extent;
                    let worst = [pressure, gap, largest(&depth) / extent, approach].into_iter().fold(0.0, f64::max);
                    assert!(worst <= tolerance, "{case}: {pressure:e}, {gap:e}, {:e}, {approach:e}", largest(&depth));
                    assert!(found.residual.saturation.is_some());
                }
            }
        }
    }
}

/// Returns interfaces with hardness, springs and both, as numbers or fields.
fn kinked(law: &Interface) -> [Interface; 4] {
    let hardness = uneven().mapv(|x| 0.05 + 0.1 * x);
    let springs = uneven().mapv(|x| (x - 0.3).max(0.0));
    [
        law.clone().with_hardness(0.09).unwrap(),
        law.clone().with_springs(0.05).unwrap(),
        law.clone().with_hardness(0.06).unwrap().with_springs(springs.clone()).unwrap(),
        law.clone().with_springs(springs).unwrap().with_hardness(hardness).unwrap(),
    ]
}

#[test]
fn loads_near_the_hardness_take_few_iterations() {
    let (n, grid) = (64, Grid::square(64, 1.0).unwrap());
    let heights = waves(n) + waves(n).mapv(|h| 0.1 * (200.0 * h).sin());
    for law in [HardWall.into_shared(), exponential().into_shared()] {
        let interface = Interface::new(&body(), &grid, &heights, law).unwrap().with_hardness(0.02).unwrap();
        for part in [0.9, 0.99, 0.999] {
            let state = solve(&interface, Load::MeanPressure(part * 0.02), None);
            let pressed = state.pressed_in.as_ref().unwrap().iter().filter(|depth| **depth > 0.0).count();
            assert!(pressed as f64 > (part - 0.15) * (n * n) as f64, "{part}: {pressed}");
            assert!(state.effort.iterations < 60, "{part}: {}", state.effort.iterations);
        }
    }
}

#[test]
fn a_uniform_field_is_a_number() {
    for (name, law) in interfaces(exponential()) {
        let number = law.clone().with_hardness(0.06).unwrap().with_springs(0.05).unwrap();
        let field = |value: f64| Array2::from_elem((N, N), value);
        let fields = law.with_hardness(field(0.06)).unwrap().with_springs(field(0.05)).unwrap();
        assert_eq!(number.hardness(), Some(Hardness::Uniform(0.06)));
        assert_eq!(fields.hardness(), Some(Hardness::Field(field(0.06))));
        for load in LOADS {
            assert_eq!(solve(&number, load, None), solve(&fields, load, None), "{name}, {load:?}");
        }
    }
}

#[test]
fn the_fields_determine_a_state() {
    for (name, law) in interfaces(exponential()) {
        for (k, interface) in kinked(&law).iter().enumerate() {
            let mut start = None;
            for load in LOADS.into_iter().chain([Load::MeanPressure(-0.001), Load::MeanPressure(0.01)]) {
                let case = format!("{name} {k}, {load:?}");
                let state = solve(interface, load, start.as_ref());
                let pressure = state.pressure().into_owned();
                let again = interface
                    .certify_pressed_in(&state.gap, &pressure, state.pressed_in.as_deref(), load.into())
                    .unwrap();
                assert!(again.residual.worst() <= 1e-8, "{case}: {:?}", again.residual);
                assert!(difference(&again, &state) <= 1e-8, "{case}: {:e}", difference(&again, &state));
                assert!((again.elastic_energy / state.elastic_energy - 1.0).abs() < 1e-7, "{case}");
                assert_eq!(again.contact_fraction, state.contact_fraction);
                // The depth that is left out leaves the pressure unbalanced.
                let hidden = interface.certify(&state.gap, &pressure, load.into()).unwrap().residual.worst();
                let is_pressed = state.pressed_in.as_ref().is_some_and(|depth| largest(depth) > 0.0);
                assert!(if is_pressed { hidden > 1e-4 } else { hidden <= 1e-8 }, "{case}: {hidden:e}");
                // A gap below zero is seen even where the surfaces may overlap.
                let mut wrong = state.gap.clone();
                let place = state.wall_pressure.indexed_iter().max_by(|a, b| a.1.total_cmp(b.1)).unwrap().0;
                wrong[place] = -0.001;
                assert!(interface.certify(&wrong, &pressure, load.into()).unwrap().residual.penetration > 0.01);

                let (displacement_z, gap) = (state.displacement_z().to_owned(), state.gap().to_owned());
                let approach = state.approach;
                let stored = StoredFields { pressure: &pressure, displacement_z: &displacement_z, gap: &gap, approach };
                let recalled = interface.recall(stored).unwrap();
                assert!(difference(&recalled, &state) <= 1e-8, "{case}: {:e}", difference(&recalled, &state));
                let next = Load::MeanPressure(0.013);
                assert_eq!(solve(interface, next, Some(&recalled)), solve(interface, next, Some(&state)), "{case}");
                start = Some(state);
            }
        }
    }
}

#[test]
fn a_state_is_kept_and_restored() {
    for interface in kinked(&periodic(exponential())) {
        let load = Load::MeanPressure(0.02);
        let state = solve(&interface, load, None);
        let mut checkpoint = MemoryCheckpoint::default();
        interface.keep(&mut state.clone(), &mut checkpoint);
        checkpoint.rewind();
        assert_eq!(interface.restore(load.into(), &mut checkpoint).unwrap(), state);
        assert!(checkpoint.is_at_end());
        assert_eq!(state.pressed_in.is_some(), interface.hardness().is_some());
        let has_saturation = state.residuals().iter().any(|(name, _)| *name == "saturation");
        assert_eq!(has_saturation, interface.hardness().is_some());
    }
}

/// Watcher that saves a checkpoint at one of its calls, or continues from it.
#[derive(Default)]
struct Keeper {
    at: Option<usize>,
    calls: usize,
    kept: MemoryCheckpoint,
    resumes: bool,
}

impl Watch for Keeper {
    fn see(&mut self, _: &Progress) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        if self.at == Some(self.calls) {
            variables(&mut self.kept);
        }
        self.calls += 1;
    }

    fn recall(&mut self) -> Option<&mut dyn Visit> {
        (self.resumes && !self.kept.is_at_end()).then_some(&mut self.kept)
    }
}

#[test]
fn a_search_continues_bit_for_bit() {
    for interface in kinked(&periodic(exponential())) {
        for load in [Load::MeanPressure(0.02), Load::Approach(0.024)] {
            let solve = |keeper: &mut Keeper| interface.press(load).tolerance(1e-9).watch(keeper).solve().unwrap();
            let mut whole = Keeper::default();
            let expected = solve(&mut whole);
            for at in 0..whole.calls {
                let mut first = Keeper { at: Some(at), ..Keeper::default() };
                solve(&mut first);
                first.kept.rewind();
                let mut second = Keeper { kept: first.kept, resumes: true, ..Keeper::default() };
                assert_eq!(solve(&mut second), expected, "{load:?}, checkpoint {at} of {}", whole.calls);
            }
        }
    }
}

#[test]
fn the_same_bits_for_any_number_of_threads() {
    let (n, grid) = (96, Grid::square(96, 1.0).unwrap());
    let heights = waves(n) + waves(n).mapv(|h| 0.1 * (200.0 * h).sin());
    let springs = heights.mapv(|h| h.max(0.0));
    let interface = Interface::new(&body(), &grid, &heights, exponential()).unwrap();
    let interface = interface.with_hardness(0.08).unwrap().with_springs(springs).unwrap();
    for load in [Load::MeanPressure(0.02), Load::Approach(0.04)] {
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| solve(&interface, load, None))
        };
        assert_eq!(with(1), with(3));
    }
}

#[test]
fn a_weakened_interface_has_the_displacements_on_a_stiffer_body() {
    let stiff = Body::half_space(Material::from_contact_modulus(2.5, 0.3).unwrap());
    for ((expected, interface), load) in kinked(&Interface::new(&stiff, &grid(), &waves(N), exponential()).unwrap())
        .into_iter()
        .zip(kinked(&periodic(exponential())))
        .zip([0.02, 0.02, 0.02, 0.01])
    {
        let expected = solve(&expected, Load::MeanPressure(load), None);
        let found = solve(&interface.weakened(2.5), Load::MeanPressure(load / 2.5), None).times(1.0, 2.5);
        assert!(difference(&found, &expected) <= 1e-8, "{:e}", difference(&found, &expected));
    }
}

#[test]
fn tiny_surfaces_in_other_units_have_the_same_states() {
    let (stress, length) = (2.0_f64.powi(37), 2.0_f64.powi(-40));
    let small = Body::half_space(Material::from_contact_modulus(stress, 0.3).unwrap());
    let heights = waves(N).mapv(|h| h * length);
    let law = Exponential::new(2e-4 * stress * length, 0.01 * length).unwrap();
    let grid = Grid::square(N, length).unwrap();
    let springs = uneven().mapv(|x| (x - 0.3).max(0.0));
    for boundary in [Boundary::Periodic, Boundary::Free] {
        let one = Interface::with_boundary(boundary, &body(), &self::grid(), &waves(N), exponential()).unwrap();
        let one = one.with_hardness(0.06).unwrap().with_springs(springs.clone()).unwrap();
        let other = Interface::with_boundary(boundary, &small, &grid, &heights, law).unwrap();
        let other = other.with_hardness(0.06 * stress).unwrap();
        let other = other.with_springs(springs.mapv(|k| k * length / stress)).unwrap();
        assert_eq!(other.hardness(), Some(Hardness::Uniform(0.06 * stress)));
        let expected = solve(&one, Load::MeanPressure(0.02), None);
        let found = solve(&other, Load::MeanPressure(0.02 * stress), None).times(1.0 / length, 1.0 / stress);
        assert!(difference(&found, &expected) <= 1e-9, "{:e}", difference(&found, &expected));
    }
}

#[test]
fn work_is_stored_or_lost() {
    // Loaded and unloaded in small steps, with the depth added to the clearance after each step.
    for (hardness, coefficient) in [(Some(0.06), 0.0), (None, 1.0), (Some(0.09), 0.5)] {
        let balance = |steps: i32| {
            let virgin = periodic(exponential());
            let mut depth = Array2::zeros((N, N));
            let mut last = solve(&virgin, Load::Approach(-0.01), None);
            let (mut missing, mut size) = (0.0, 0.0);
            for k in 1..=steps {
                let approach = -0.01 + 0.032 * (f64::from(k) / f64::from(steps) * 1.3).min(1.0);
                let springs = coefficient / f64::from(steps);
                let mut interface = virgin.with_indentation(&depth).unwrap().with_springs(springs).unwrap();
                if let Some(hardness) = hardness {
                    interface = interface.with_hardness(hardness).unwrap();
                }
                let state = solve(&interface, Load::Approach(approach), Some(&last));
                let mut growth = springs * &state.wall_pressure;
                if let Some(pressed) = &state.pressed_in {
                    growth += pressed;
                }
                let work = 0.5 * (state.mean_pressure + last.mean_pressure) * (state.approach - last.approach);
                let stored = [&state, &last].map(|state| state.elastic_energy + state.interface_energy);
                let lost = (&state.pressure() * &growth).mean().unwrap();
                missing += work - (stored[0] - stored[1]) - lost;
                size += work.abs();
                depth += &growth;
                last = state;
            }
            (missing / size).abs()
        };
        let [coarse, fine] = [24, 96].map(balance);
        assert!(fine < 0.02 && fine < 0.5 * coarse, "{hardness:?}, {coefficient}: {coarse:e}, then {fine:e}");
    }
}

#[test]
fn wrong_input_is_refused() {
    let law = periodic(exponential());
    let refused = |hardness: f64| law.clone().with_hardness(hardness).unwrap_err().to_string();
    assert_eq!(refused(0.0), "the hardness is 0; it must be positive and finite");
    assert!(refused(f64::NAN).contains("NaN") && refused(f64::INFINITY).contains("inf"));
    let shape = law.clone().with_hardness(Array2::from_elem((3, 4), 0.1)).unwrap_err();
    assert!(matches!(shape, Refusal::HardnessShape { found: [3, 4], expected: [N, N] }));
    for compliance in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(law.clone().with_springs(compliance), Err(Refusal::Springs { .. })));
    }
    let shape = law.clone().with_springs(Array2::zeros((3, 4))).unwrap_err();
    assert!(matches!(shape, Refusal::SpringsShape { found: [3, 4], expected: [N, N] }));
    let no_wall = periodic(Morse::new(2e-4, 0.01).unwrap());
    let message = "a hardness is given; it must be left out with a law without a hard wall";
    assert_eq!(no_wall.clone().with_hardness(0.1).unwrap_err().to_string(), message);
    assert!(matches!(no_wall.with_springs(0.1), Err(Refusal::NoWall { .. })));
    let all = Interface::in_all_components(&body(), &grid(), &waves(N), exponential()).unwrap();
    let message = "a compliance of springs is given; it must be left out with all components of the displacement";
    assert_eq!(all.with_springs(0.1).unwrap_err().to_string(), message);

    let hard = law.clone().with_hardness(0.05).unwrap();
    assert!(matches!(
        hard.check(Load::MeanPressure(0.05).into()),
        Err(Refusal::BeyondHardness { what: "hardness", .. })
    ));
    let field = law.clone().with_hardness(uneven()).unwrap_err();
    assert!(matches!(field, Refusal::Hardness { found: 0.0 }));
    let field = law.clone().with_hardness(uneven().mapv(|x| 0.1 * x + 0.01)).unwrap();
    let beyond = field.check(Load::MeanPressure(0.08).into());
    assert!(matches!(beyond, Err(Refusal::BeyondHardness { what: "mean hardness", .. })));
    assert!(field.check(Load::MeanPressure(0.05).into()).is_ok() && field.check(Load::Approach(0.1).into()).is_ok());
    for wall in [law.clone(), law.clone().with_springs(1e-13).unwrap()] {
        assert!(matches!(wall.check(Load::Approach(0.1).into()), Err(Refusal::Approach { .. })));
    }
    let solved = hard.press(Load::MeanPressure(0.01)).solver(Solver::Fire2).solve();
    assert!(matches!(solved, Err(SolveError::Refused(Refusal::Solver { .. }))));
    let state = solve(&hard, Load::MeanPressure(0.01), None);
    let gradient = hard.gradient(&state, Load::MeanPressure(0.01), &Cotangents::default()).unwrap();
    assert_eq!(gradient.hardness.unwrap().sum(), 0.0);
    let depth = Cotangents { plastic_depth: Some(state.gap.clone()), ..Cotangents::default() };
    let error = law.gradient(&state, Load::MeanPressure(0.01), &depth).unwrap_err();
    assert_eq!(error, GradientError::Absent { name: "plastic depth" });
    let soft = law.with_springs(0.1).unwrap();
    let state = solve(&soft, Load::MeanPressure(0.01), None);
    let of = Cotangents { approach: 1.0, ..Cotangents::default() };
    let by_load = soft.gradient(&state, Load::MeanPressure(0.01), &of).unwrap().load;
    let stiffness = soft.stiffness(&state, 1e-10).unwrap().value;
    assert!((by_load * stiffness - 1.0).abs() < 1e-7, "{by_load} {stiffness}");
}
