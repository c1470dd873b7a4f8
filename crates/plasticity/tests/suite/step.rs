//! Steps of loading: limits, certificate, threads, bad input.

use std::ops::ControlFlow;

use gfmd_contact::{Equilibrium, MemoryCheckpoint, Progress, Resumable, Visit, Watch};
use gfmd_plasticity::ndarray::Array2;
use gfmd_plasticity::{
    Body, Budget, Cells, Contact, Fields, Grid, Hardening, Load, Material, PlasticState, PlasticityError, Refusal,
    SolveError, Why, YieldingContact,
};

use crate::reference::{cases, contact, load};

fn material() -> Material {
    Material::from_young(1.0, 0.3).unwrap()
}

fn rough(points: usize) -> (Grid, Array2<f64>) {
    let grid = Grid::square(points, 1.0).unwrap();
    let surface = gfmd_surface::SelfAffine {
        hurst: 0.8,
        longest_wavelength: 0.5,
        shortest_wavelength: 0.125,
        ..gfmd_surface::SelfAffine::with_rms_gradient(0.1)
    };
    let heights = surface.heights(&grid, 3).unwrap();
    (grid, heights)
}

fn yielding(points: usize, yield_stress: f64) -> YieldingContact {
    let (grid, heights) = rough(points);
    let steel = Hardening::new(yield_stress).unwrap().isotropic(0.02).unwrap();
    YieldingContact::new(&Body::half_space(material()), &grid, &heights, &[Some(steel)], &Cells::default()).unwrap()
}

const TIGHT: Budget = Budget { tolerance: 1e-11, max_iterations: 2000 };

#[test]
fn without_yield_every_problem_is_the_elastic_contact() {
    for case in cases() {
        let mut problem = case["problem"].clone();
        for key in ["hardening_curve", "layer_yield"] {
            if problem.get(key).is_some() {
                problem[key] = if key == "layer_yield" { 0.05.into() } else { serde_json::Value::Null };
            }
        }
        problem.as_object_mut().unwrap().retain(|_, value| !value.is_null());
        problem["yield"] = 0.099.into();
        let contact = contact(&problem);
        // So small a part of the first load that nothing yields.
        let load = match load(&problem["path"][0]) {
            Load::MeanPressure(mean) => Load::MeanPressure(0.005 * mean),
            Load::Approach(approach) => Load::Approach(0.01 * approach),
        };
        let state = contact.step(&contact.rest().unwrap(), load, &TIGHT, &mut ()).unwrap();
        assert_eq!(state.plastic.points(), 0, "{problem}");
        let elastic = contact.contact().press(load).budget(TIGHT).solve().unwrap();
        let close = |a: &Array2<f64>, b: &Array2<f64>| {
            let largest = b.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-10 * largest)
        };
        assert!(close(&state.solution.pressure, &elastic.pressure));
        assert!(close(&state.solution.displacement, &elastic.displacement));
        let energy = elastic.summary().elastic_energy;
        assert!((state.elastic_energy - energy).abs() < 1e-10 * energy && state.dissipated == 0.0);
        assert!(state.operators <= 2);
    }
}

#[test]
fn unloading_is_elastic_and_leaves_residual_stress_and_an_imprint() {
    let contact = yielding(64, 0.03);
    let budget = Budget::default();
    let pressed = contact.step(&contact.rest().unwrap(), Load::MeanPressure(0.01), &budget, &mut ()).unwrap();
    let released = contact.step(&pressed, Load::MeanPressure(0.0005), &budget, &mut ()).unwrap();
    assert!(released.operators <= 2 && released.dissipated == 0.0);
    assert_eq!(released.plastic, pressed.plastic);
    assert!(released.plastic_displacement_measures().min < 0.0);
    // The same load again gives the same state.
    let again = contact.step(&released, Load::MeanPressure(0.01), &budget, &mut ()).unwrap();
    assert!((again.approach() - pressed.approach()).abs() < 1e-7 * pressed.approach());
    // With the state before as a candidate: W' + D − W ≤ p (δ' − δ).
    let work = 0.01 * (pressed.approach() - 0.0);
    assert!(pressed.elastic_energy + pressed.hardening_energy + pressed.dissipated <= work * (1.0 + 1e-12));
}

#[test]
fn without_a_load_the_imprint_is_left_and_the_surfaces_touch() {
    let contact = yielding(32, 0.02);
    let budget = Budget::default();
    let pressed = contact.step(&contact.rest().unwrap(), Load::MeanPressure(0.01), &budget, &mut ()).unwrap();
    let unloaded = contact.step(&pressed, Load::MeanPressure(0.0), &budget, &mut ()).unwrap();
    assert!(unloaded.mean_pressure() == 0.0 && unloaded.worst() <= budget.tolerance);
    assert!(unloaded.solution.pressure.iter().all(|p| *p == 0.0));
    assert_eq!(unloaded.displacement_z(), unloaded.plastic_displacement);
    let lowest = unloaded.gap().iter().copied().fold(f64::INFINITY, f64::min);
    assert!(lowest.abs() <= 1e-15 && unloaded.approach() > 0.0, "{lowest:e}");
    // A light load gives the same imprint, and nearly the same approach.
    let light = contact.step(&pressed, Load::MeanPressure(1e-9), &budget, &mut ()).unwrap();
    assert_eq!(light.plastic, unloaded.plastic);
    approx::assert_relative_eq!(light.approach(), unloaded.approach(), max_relative = 1e-3);
    assert!(unloaded.elastic_energy > 0.0 && unloaded.elastic_energy < light.elastic_energy);
    let certified = contact.certify(&pressed, &unloaded.solution.pressure, &unloaded.plastic, Load::MeanPressure(0.0));
    let certified = certified.unwrap();
    assert!(certified.worst() <= 1e-8, "{:?}", certified.residuals());
    approx::assert_relative_eq!(certified.approach(), unloaded.approach(), max_relative = 1e-12);
    // Loaded again it is the first load.
    let again = contact.step(&unloaded, Load::MeanPressure(0.01), &budget, &mut ()).unwrap();
    approx::assert_relative_eq!(again.approach(), pressed.approach(), max_relative = 1e-7);
    // A body that has not yielded touches at one point.
    let rest = contact.step(&contact.rest().unwrap(), Load::MeanPressure(0.0), &budget, &mut ()).unwrap();
    assert!(rest.approach() == 0.0 && rest.operators == 1);
}

#[test]
fn an_approach_above_the_imprint_has_no_contact() {
    let contact = yielding(32, 0.02);
    let budget = Budget::default();
    let pressed = contact.step(&contact.rest().unwrap(), Load::MeanPressure(0.01), &budget, &mut ()).unwrap();
    let apart = contact.step(&pressed, Load::Approach(1e-5), &budget, &mut ()).unwrap();
    assert!(apart.mean_pressure() == 0.0 && apart.worst() <= budget.tolerance && apart.elastic_energy > 0.0);
}

#[test]
fn the_certificate_recomputes_a_state_and_finds_changes() {
    let contact = yielding(64, 0.03);
    let (rest, load) = (contact.rest().unwrap(), Load::MeanPressure(0.01));
    let state = contact.step(&rest, load, &Budget::default(), &mut ()).unwrap();
    let cells = 0..contact.cells().len();
    let strains: Vec<_> = cells.clone().map(|cell| state.plastic_strain(cell)).collect();
    let mut equivalents: Vec<_> = cells.map(|cell| state.equivalent_plastic_strain(cell)).collect();
    let plastic = contact.plastic_strain(&strains, &equivalents).unwrap();
    assert_eq!(plastic, state.plastic);
    let certified = contact.certify(&rest, &state.solution.pressure, &plastic, load).unwrap();
    assert!(certified.worst() <= 1e-8, "{:?}", certified.residuals());
    let relative = |a: f64, b: f64| (a - b).abs() / b.abs();
    assert!(relative(certified.elastic_energy, state.elastic_energy) < 1e-12);
    assert!(relative(certified.dissipated, state.dissipated) < 1e-12);
    assert!(relative(certified.approach(), state.approach()) < 1e-12);
    let wrong_pressure = state.solution.pressure.mapv(|p| 1.001 * p);
    let wrong = contact.certify(&rest, &wrong_pressure, &plastic, load).unwrap();
    assert!(wrong.solution.residual.load > 1e-4 && wrong.residual.yielding > 1e-5);
    equivalents[3].mapv_inplace(|k| 1.01 * k);
    let plastic = contact.plastic_strain(&strains, &equivalents).unwrap();
    let wrong = contact.certify(&rest, &state.solution.pressure, &plastic, load).unwrap();
    assert!(wrong.residual.flow > 1e-4);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let contact = yielding(128, 0.03);
    let solve = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let rest = contact.rest().unwrap();
            let budget = Budget { tolerance: 1e-6, ..Budget::default() };
            contact.step(&rest, Load::MeanPressure(0.005), &budget, &mut ()).unwrap()
        })
    };
    let one = solve(1);
    assert!(one.plastic.points() > 1000);
    for threads in [2, 4] {
        assert!(solve(threads) == one, "{threads} threads");
    }
}

#[test]
fn searches_that_end_early_give_their_state() {
    let contact = yielding(32, 0.02);
    let rest = contact.rest().unwrap();
    let load = Load::MeanPressure(0.01);
    let few = Budget { max_iterations: 3, ..Budget::default() };
    let unmet = contact.step(&rest, load, &few, &mut ()).unwrap_err();
    assert!(matches!(&unmet, SolveError::NotConverged { state, .. } if state.worst() > 1e-8), "{unmet}");
    let mut stop = |_: &Progress| ControlFlow::Break(());
    let stopped = contact.step(&rest, load, &Budget::default(), &mut stop).unwrap_err();
    assert!(matches!(stopped, SolveError::Interrupted { .. }));
}

#[test]
fn invalid_problems_and_loads_are_refused() {
    let (grid, heights) = rough(32);
    let make = |material: Material, yield_stress: f64| {
        let steel = Some(Hardening::new(yield_stress).unwrap());
        YieldingContact::new(&Body::half_space(material), &grid, &heights, &[steel], &Cells::default())
    };
    let rubber = Material::from_young(1.0, 0.499).unwrap();
    assert!(matches!(make(rubber, 0.01), Err(PlasticityError::Poisson { .. })));
    assert!(matches!(make(material(), 0.1), Err(PlasticityError::YieldStrain { .. })));
    let contact = make(material(), 0.01).unwrap();
    let rest = contact.rest().unwrap();
    let refused = |load: Load| match contact.step(&rest, load, &Budget::default(), &mut ()) {
        Err(SolveError::Refused(refusal)) => refusal.to_string(),
        _ => panic!("{load:?} is not refused"),
    };
    // Y (1 − ν)/(1 − 2ν) = 0.0175, times 0.95.
    let beyond = contact.step(&rest, Load::MeanPressure(0.017), &Budget::default(), &mut ());
    let Err(SolveError::Refused(Refusal::YieldsUniformly { limit, .. })) = beyond else { panic!("not refused") };
    approx::assert_relative_eq!(limit, 0.016625, max_relative = 1e-14);
    assert!(refused(Load::MeanPressure(f64::NAN)).contains("NaN"));
    assert!(refused(Load::MeanPressure(-1.0)).contains("-1"));
    let other = make(material(), 0.02).unwrap().rest().unwrap();
    let mixed = contact.step(&other, Load::MeanPressure(0.001), &Budget::default(), &mut ());
    assert!(matches!(mixed, Err(SolveError::Refused(Refusal::OtherKind))));
    let flat = Array2::zeros((32, 32));
    assert!(Contact::new(&Body::half_space(material()), &grid, &flat).is_err());
}

#[test]
fn strain_below_graded_cells_is_a_failure_with_its_reason() {
    let grid = Grid::square(32, 1.0).unwrap();
    let wave = |i: usize| (std::f64::consts::TAU * i as f64 / 32.0).cos();
    let heights = Array2::from_shape_fn((32, 32), |(i, j)| 0.01 * (wave(i) + wave(j)));
    let body = Body::half_space(material());
    let solve = |cells: &Cells| {
        let steel = Some(Hardening::new(0.0024).unwrap().isotropic(0.01).unwrap());
        let contact = YieldingContact::new(&body, &grid, &heights, &[steel], cells).unwrap();
        contact.step(&contact.rest().unwrap(), Load::MeanPressure(0.0015), &Budget::default(), &mut ())
    };
    let Err(SolveError::NotConverged { state, why: Why::LowestCell, .. }) = solve(&Cells::default()) else {
        panic!("strain below the cells is not a failure")
    };
    assert!(state.yields_at_bottom() && state.residual.bottom == 1.0);
    // Deeper cells hold the strain, and cells that are given may end within it.
    let deep = solve(&Cells::Uniform { count: 24, depth: 1.0 }).unwrap();
    assert!(!deep.yields_at_bottom());
    let shallow = solve(&Cells::Uniform { count: 4, depth: 0.1 }).unwrap();
    assert!(shallow.yields_at_bottom() && shallow.residual.bottom == 0.0);
}

/// Numbers of a state, written and read in order.
#[derive(Default)]
struct Kept {
    numbers: Vec<f64>,
    counts: Vec<u64>,
    reads: bool,
}

impl Visit for Kept {
    fn number(&mut self, x: &mut f64) {
        if self.reads { *x = self.numbers.remove(0) } else { self.numbers.push(*x) }
    }

    fn count(&mut self, n: &mut u64) {
        if self.reads { *n = self.counts.remove(0) } else { self.counts.push(*n) }
    }

    fn field(&mut self, x: &mut [f64]) {
        x.iter_mut().for_each(|x| self.number(x));
    }
}

#[test]
fn a_restored_state_and_the_step_after_it_have_the_same_bits() {
    let contact = yielding(32, 0.02);
    let press = |mean: f64, start: Option<&PlasticState>| {
        contact.press(Load::MeanPressure(mean)).starting_from(start).solve().unwrap()
    };
    let first = press(0.005, None);
    let mut second = press(0.008, Some(&first));
    assert!(second.dissipated > 0.0 && first.plastic.points() < second.plastic.points());
    let mut kept = Kept::default();
    contact.keep(&mut second, &mut kept);
    kept.reads = true;
    let restored = contact.restore(Load::MeanPressure(0.008).into(), &mut kept).unwrap();
    assert_eq!(restored, second);
    assert!(kept.numbers.is_empty() && kept.counts.is_empty());
    assert_eq!(press(0.003, Some(&restored)), press(0.003, Some(&second)));
}

#[test]
fn the_stiffness_is_the_slope_of_unloading() {
    let contact = yielding(32, 0.02);
    let step =
        |mean: f64, before: &PlasticState| contact.step(before, Load::MeanPressure(mean), &TIGHT, &mut ()).unwrap();
    let pressed = step(0.008, &contact.rest().unwrap());
    let released = step(0.008 * (1.0 - 1e-7), &pressed);
    let slope = (pressed.mean_pressure() - released.mean_pressure()) / (pressed.approach() - released.approach());
    let found = contact.stiffness(&pressed, 1e-9).unwrap().value;
    approx::assert_relative_eq!(found, slope, max_relative = 1e-3);
    // Loading is softer, since the body yields.
    let further = step(0.008 * (1.0 + 1e-4), &pressed);
    let softer = (further.mean_pressure() - pressed.mean_pressure()) / (further.approach() - pressed.approach());
    assert!(softer < 0.9 * found, "{softer} {found}");
}

/// Watcher that keeps the checkpoint at one of its calls, or continues from it.
#[derive(Default)]
struct Keeper {
    at: Option<u64>,
    calls: u64,
    kept: MemoryCheckpoint,
    resumes: bool,
    first: Option<u64>,
}

impl Watch for Keeper {
    fn see(&mut self, now: &Progress) -> ControlFlow<()> {
        self.first.get_or_insert(now.iteration);
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
fn a_step_continues_from_its_checkpoint_with_the_same_bits() {
    let contact = yielding(32, 0.02);
    let before = contact.step(&contact.rest().unwrap(), Load::MeanPressure(0.004), &TIGHT, &mut ()).unwrap();
    for (before, load) in [
        (contact.rest().unwrap(), Load::MeanPressure(0.01)),
        (before.clone(), Load::MeanPressure(0.01)),
        (before.clone(), Load::Approach(1.5 * before.approach())),
    ] {
        let step = |keeper: &mut Keeper| contact.step(&before, load, &TIGHT, keeper).unwrap();
        let mut whole = Keeper::default();
        let expected = step(&mut whole);
        assert!(whole.calls >= 4, "{} Newton steps", whole.calls);
        for at in 0..whole.calls {
            let mut first = Keeper { at: Some(at), ..Keeper::default() };
            step(&mut first);
            first.kept.rewind();
            let mut second = Keeper { kept: first.kept, resumes: true, ..Keeper::default() };
            let resumed = step(&mut second);
            assert!(second.kept.is_at_end());
            // It goes on, and does not begin again.
            assert_eq!(second.calls, whole.calls - at - 1);
            assert!(at == 0 || second.first > whole.first);
            assert_eq!(resumed.solution, expected.solution);
            assert_eq!(resumed.plastic, expected.plastic);
            assert_eq!(resumed.operators, expected.operators);
            let bits = |state: &PlasticState| state.solution.pressure.map(|p| p.to_bits());
            assert_eq!(bits(&resumed), bits(&expected));
        }
    }
}
