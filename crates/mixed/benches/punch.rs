//! Flat square punch that sticks to a slab, 512² points, to 1e-8: conjugate gradients against damped dynamics.
//!
//! `cargo bench -p gfmd-mixed` times conjugate gradients and the best damping, and prints iterations and transform
//! pairs. The slower methods take a minute for each sample and run only if they are named:
//! `cargo bench -p gfmd-mixed -- Fire`. `GFMD_BENCH_POINTS=128 cargo bench -p gfmd-mixed` uses a smaller grid.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_mixed::{Edge, FlatPunch, Method, MixedProblem, Prescribed};
use gfmd_relax::Budget;

const METHODS: [(Method, bool); 4] = [
    (Method::ConjugateGradients, true),
    (Method::Verlet, true),
    (Method::VerletCritical, false),
    (Method::Fire, false),
];

fn punch(criterion: &mut Criterion) {
    let n: usize = std::env::var("GFMD_BENCH_POINTS").ok().and_then(|n| n.parse().ok()).unwrap_or(512);
    let named = std::env::args().skip(1).any(|argument| !argument.starts_with('-'));
    let grid = Grid::square(n, 1.27).expect("a grid");
    let body = Material::from_young(70.0, 0.33).and_then(|material| Body::slab(material, 1.27)).expect("a body");
    let points = FlatPunch::new(0.25, Edge::Inclusive).expect("a punch").points(&grid);
    let held = Prescribed::sticking(&grid, points.view(), [0.0, 0.0, -0.005]).expect("points of the grid");
    let problem = MixedProblem::new(&body, &grid, held).expect("a problem");
    let mut group = criterion.benchmark_group(format!("sticking_punch_{n}"));
    group.sample_size(10).sampling_mode(SamplingMode::Flat).warm_up_time(Duration::from_millis(1));
    for (method, fast) in METHODS {
        if !fast && !named && n > 256 {
            continue;
        }
        let mut cost = None;
        group.bench_function(format!("{method:?}"), |bencher| {
            bencher.iter(|| {
                let solution = problem.solve(method, &Budget::default(), &mut ()).expect("converges");
                cost = Some((solution.iterations, solution.transform_pairs / 3.0));
                black_box(solution)
            });
        });
        if let Some((iterations, pairs)) = cost {
            #[expect(clippy::print_stderr, reason = "beside what criterion prints")]
            {
                eprintln!("{method:?}: {iterations} iterations, {pairs} transform pairs for each component");
            }
        }
    }
    group.finish();
}

criterion_group!(benches, punch);
criterion_main!(benches);
