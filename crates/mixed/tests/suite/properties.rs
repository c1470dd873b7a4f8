//! Properties for any body, any held points and any values: manufactured solutions, energy, superposition, reciprocity.

use std::ops::ControlFlow;
use std::sync::Arc;

use approx::assert_relative_eq;
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_mixed::{Method, MixedError, MixedProblem, MixedSolution, Prescribed};
use gfmd_relax::{Budget, Progress};
use gfmd_response::FullResponse;
use ndarray::{Array2, Array3, Axis, Zip};
use proptest::prelude::*;

/// Returns repeatable numbers, evenly spread between −1/2 and 1/2.
fn noise(shape: [usize; 3], seed: u64) -> Array3<f64> {
    let mut i = 0.0;
    Array3::from_shape_simple_fn(shape, || {
        i += 1.0;
        (i * (0.618_033_988 + 1e-3 * seed as f64)).fract() - 0.5
    })
}

fn bodies() -> [Body; 4] {
    let material = |poisson| Material::from_young(3.0, poisson).unwrap();
    [
        Body::half_space(material(0.3)),
        Body::slab(material(0.45), 0.3).unwrap(),
        Body::slab(material(0.5), 0.1).unwrap(),
        Body::slab(material(-0.4), 2.0).unwrap(),
    ]
}

fn grids() -> [Grid; 4] {
    [
        Grid::new([8, 10], [1.0, 1.3]).unwrap(),
        Grid::new([7, 9], [1.0, 1.1]).unwrap(),
        Grid::line(24, 1.0).unwrap(),
        Grid::line(15, 1.0).unwrap(),
    ]
}

fn shape(response: &FullResponse) -> [usize; 3] {
    let [nx, ny] = response.grid().points();
    [response.components().len(), nx, ny]
}

/// Returns the displacement u = G t.
fn displacement(response: &FullResponse, traction: &Array3<f64>) -> Array3<f64> {
    let mut out = Array3::zeros(traction.dim());
    let (t, u) = (traction.as_slice().unwrap(), out.as_slice_mut().unwrap());
    response.compliance().apply(t, u, &mut response.workspace()).unwrap();
    out
}

fn solve(
    response: &Arc<FullResponse>,
    prescribed: Prescribed,
    method: Method,
    budget: Budget,
) -> Result<MixedSolution, MixedError> {
    MixedProblem::with_response(Arc::clone(response), prescribed)?.solve(method, &budget, &mut ())
}

fn to(tolerance: f64) -> Budget {
    Budget { tolerance, ..Budget::default() }
}

/// Solves to 1e-12 by the default method.
fn exact(response: &Arc<FullResponse>, held: &Array3<bool>, values: &Array3<f64>) -> MixedSolution {
    let prescribed = Prescribed::new(held.view(), values.view()).unwrap();
    solve(response, prescribed, Method::default(), to(1e-12)).unwrap()
}

fn largest(field: &Array3<f64>) -> f64 {
    field.iter().fold(0.0, |most, value| most.max(value.abs()))
}

/// Returns the mean ⟨a·b⟩.
fn work(a: &Array3<f64>, b: &Array3<f64>) -> f64 {
    (a * b).sum() / (a.len() / a.len_of(Axis(0))) as f64
}

/// Generates a body on a grid with some entries held: at least one held and one free in every component.
fn problems() -> impl Strategy<Value = (Arc<FullResponse>, Array3<bool>)> {
    (0..4_usize, 0..4_usize, 0.05..0.95_f64, 0..1000_u64).prop_map(|(body, grid, part, seed)| {
        let response = Arc::new(FullResponse::new(grids()[grid], &bodies()[body]));
        let mut held = noise(shape(&response), seed).mapv(|x| x + 0.5 < part);
        for component in 0..held.len_of(Axis(0)) {
            held[[component, 0, 0]] = true;
            held[[component, 1, 0]] = false;
        }
        (response, held)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_known_state_is_found_from_what_is_prescribed_of_it((response, held) in problems(), seed in 0..1000_u64) {
        let t = noise(shape(&response), seed);
        let u = displacement(&response, &t);
        let values = Zip::from(&held).and(&u).and(&t).map_collect(|held, u, t| if *held { *u } else { *t });
        let solution = exact(&response, &held, &values);
        prop_assert!(solution.residual <= 1e-12);
        for ((found, expected), held) in solution.traction.iter().zip(&t).zip(&held) {
            prop_assert!((found - expected).abs() <= if *held { 1e-8 } else { 0.0 }, "{} {}", found, expected);
        }
        // The residual, at most 1e-12, is relative to the displacement that the free traction alone leaves at held
        // entries: in the case that is kept 249 times the displacement, and the error 1e-12 of it.
        let free = Zip::from(&held).and(&t).map_collect(|held, t| if *held { 0.0 } else { *t });
        let left = Zip::from(&held).and(&u).and(&displacement(&response, &free)).map_collect(|held, u, alone| {
            if *held { u - alone } else { 0.0 }
        });
        let scale = largest(&u).max(largest(&left));
        for (found, expected) in solution.displacement.iter().zip(&u) {
            prop_assert!((found - expected).abs() <= 1e-11 * scale, "{} {} {}", found, expected, scale);
        }
    }

    #[test]
    fn the_work_of_the_tractions_is_the_elastic_energy((response, held) in problems(), seed in 0..1000_u64) {
        let solution = exact(&response, &held, &noise(shape(&response), seed));
        let mut ws = response.workspace();
        let stored = response.stiffness().quadratic_form(solution.displacement.as_slice().unwrap(), &mut ws).unwrap();
        assert_relative_eq!(solution.elastic_energy(), 0.5 * stored, max_relative = 1e-9);
    }

    #[test]
    fn states_add((response, held) in problems(), seed in 0..1000_u64, factor in -2.0..2.0_f64) {
        let [a, b] = [seed, seed + 7].map(|seed| noise(shape(&response), seed));
        let [one, other] = [&a, &b].map(|values| exact(&response, &held, values));
        let both = exact(&response, &held, &(&a + &(factor * &b)));
        let expected = &one.displacement + &(factor * &other.displacement);
        let scale = largest(&one.displacement) + largest(&other.displacement);
        for (found, expected) in both.displacement.iter().zip(&expected) {
            prop_assert!((found - expected).abs() <= 1e-9 * scale);
        }
    }

    #[test]
    fn two_states_do_the_same_work_on_each_other((response, held) in problems(), seed in 0..1000_u64) {
        let one = exact(&response, &held, &noise(shape(&response), seed));
        let others = held.mapv(|held| !held);
        let other = exact(&response, &others, &noise(shape(&response), seed + 3));
        let scale = largest(&one.traction) * largest(&other.displacement)
            + largest(&other.traction) * largest(&one.displacement);
        let difference = work(&one.traction, &other.displacement) - work(&other.traction, &one.displacement);
        prop_assert!(difference.abs() <= 1e-10 * scale, "{} of {}", difference, scale);
    }

    #[test]
    fn dynamics_finds_what_is_prescribed((response, held) in problems(), seed in 0..1000_u64) {
        let values = noise(shape(&response), seed);
        let expected = exact(&response, &held, &values).displacement;
        let prescribed = Prescribed::new(held.view(), values.view()).unwrap();
        for method in [Method::Verlet, Method::VerletCritical, Method::Fire] {
            let found = solve(&response, prescribed.clone(), method, to(1e-11)).unwrap();
            for (found, value) in found.displacement.iter().zip(&expected) {
                prop_assert!((found - value).abs() <= 1e-8 * largest(&expected), "{:?}", method);
            }
        }
    }
}

#[test]
fn where_the_mean_does_not_answer_the_level_is_the_mean() {
    let grid = Grid::square(12, 1.0).unwrap();
    let [half_space, _, rubber, _] = bodies();
    for (body, axes) in [(half_space, vec![0, 1, 2]), (rubber, vec![2])] {
        let response = Arc::new(FullResponse::new(grid, &body));
        let mut held = Array3::from_elem(shape(&response), false);
        held.slice_mut(ndarray::s![.., 4..8, 4..8]).fill(true);
        let solution = exact(&response, &held, &noise(shape(&response), 1));
        for axis in axes {
            let mean = solution.displacement.index_axis(Axis(0), axis).mean().unwrap();
            assert!(mean.abs() < 1e-14 && solution.mean_traction()[axis].abs() > 1e-3);
        }
    }
}

#[test]
fn same_bits_for_any_thread_count() {
    let on = |threads: usize, method: Method| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let grid = Grid::square(72, 1.0).unwrap();
            let response = Arc::new(FullResponse::new(grid, &bodies()[0]));
            let points = Array2::from_shape_fn((72, 72), |(i, j)| (20..40).contains(&i) && (30..50).contains(&j));
            let held = Prescribed::sticking(&grid, points.view(), [0.1, 0.0, -1.0]).unwrap();
            solve(&response, held, method, to(1e-4)).unwrap()
        })
    };
    for method in [Method::ConjugateGradients, Method::Verlet] {
        assert!(on(1, method) == on(3, method));
    }
}

#[test]
fn nothing_moves_where_nothing_is_asked() {
    let response = Arc::new(FullResponse::new(grids()[0], &bodies()[1]));
    let points = Array2::from_shape_fn((8, 10), |(i, _)| i < 3);
    for method in [Method::ConjugateGradients, Method::Verlet, Method::Fire] {
        let held = Prescribed::sticking(response.grid(), points.view(), [0.0; 3]).unwrap();
        let solution = solve(&response, held, method, Budget::default()).unwrap();
        assert_eq!((solution.residual, solution.iterations), (0.0, 0));
        assert!(solution.displacement.iter().chain(&solution.traction).all(|value| *value == 0.0));
    }
}

#[test]
fn problems_that_cannot_be_posed_are_refused() {
    let grid = grids()[0];
    let [half_space, slab, rubber, _] = bodies().map(|body| Arc::new(FullResponse::new(grid, &body)));
    let all = Array2::from_elem((8, 10), true);
    let error = |response: &Arc<FullResponse>, prescribed: Result<Prescribed, MixedError>| {
        let outcome = prescribed.and_then(|prescribed| solve(response, prescribed, Method::default(), to(1e-8)));
        outcome.unwrap_err().to_string()
    };
    let none = Prescribed::sticking(&grid, all.mapv(|_| false).view(), [0.0; 3]);
    assert!(error(&slab, none).contains("no displacement is prescribed"));
    for (response, component) in [(&half_space, "component 0"), (&rubber, "component 2")] {
        assert!(error(response, Prescribed::sticking(&grid, all.view(), [0.0, 0.0, 1.0])).contains(component));
    }
    // A slab can be compressed as a whole, with the stiffness C11/height.
    for method in [Method::ConjugateGradients, Method::Verlet] {
        let uniform = Prescribed::sticking(&grid, all.view(), [0.0, 0.0, -0.01]).unwrap();
        let solution = solve(&slab, uniform, method, Budget::default()).unwrap();
        let expected = 3.0 * 0.55 / (1.45 * 0.1) * 0.01 / 0.3;
        assert_relative_eq!(-solution.mean_traction()[2], expected, max_relative = 1e-8);
    }

    let wrong = Array2::from_elem((10, 8), true);
    let text = error(&slab, Prescribed::sticking(&grid, wrong.view(), [0.0; 3]));
    assert_eq!(text, "the shape [component, x, y] of the points is [3, 10, 8]; it must be [3, 8, 10]");
    let line = grids()[2];
    let text = error(&slab, Prescribed::frictionless(&line, Array2::from_elem((24, 1), true).view(), 1.0));
    assert!(text.contains("[2, 24, 1]") && text.contains("[3, 8, 10]"), "{text}");
    let mut traction = Array3::zeros([3, 8, 10]);
    traction[[1, 2, 3]] = f64::NAN;
    let held = Prescribed::frictionless(&grid, all.view(), 1.0).and_then(|held| held.with_traction(traction.view()));
    assert!(error(&slab, held).contains("[1, 2, 3] is NaN"));
}

#[test]
fn what_was_reached_is_kept() {
    let response = Arc::new(FullResponse::new(Grid::square(32, 1.0).unwrap(), &bodies()[1]));
    let points = Array2::from_shape_fn((32, 32), |(i, j)| i < 8 && j < 8);
    let held = Prescribed::sticking(response.grid(), points.view(), [0.0, 0.0, -1.0]).unwrap();
    for method in [Method::ConjugateGradients, Method::Verlet, Method::VerletCritical, Method::Fire] {
        let few = Budget { max_iterations: 3, ..Budget::default() };
        let Err(MixedError::NotConverged { solution, .. }) = solve(&response, held.clone(), method, few) else {
            panic!("{method:?}")
        };
        assert!(solution.iterations == 3);
        assert!(solution.residual > 1e-8);
        assert!(solution.residual < 1.0);
        let problem = MixedProblem::with_response(Arc::clone(&response), held.clone()).unwrap();
        let mut seen = 0;
        let mut watch = |_: &Progress| {
            seen += 1;
            if seen > 2 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let stopped = problem.solve(method, &Budget::default(), &mut watch);
        assert!(matches!(stopped, Err(MixedError::Interrupted { solution }) if solution.iterations == 2), "{method:?}");
    }
    for tolerance in [0.0, -1.0, 1.0, f64::NAN] {
        let refused = solve(&response, held.clone(), Method::default(), to(tolerance));
        assert!(matches!(refused, Err(MixedError::Tolerance { .. })));
    }
}

#[test]
fn a_tolerance_below_rounding_is_not_chased_for_ever() {
    let grid = Grid::square(48, 1.0).unwrap();
    let response = Arc::new(FullResponse::new(grid, &bodies()[0]));
    // The only free point must rise by 2303 to keep the mean level, and its rounding error acts on all held points.
    let points = Array2::from_shape_fn((48, 48), |at| at != (7, 9));
    for method in [Method::ConjugateGradients, Method::Verlet] {
        let held = Prescribed::frictionless(&grid, points.view(), -1.0).unwrap();
        let error = solve(&response, held, method, to(1e-15)).unwrap_err();
        assert!(error.to_string().contains("rounding"), "{error}");
    }
}
