//! Benchmark of the equilibration of a rough surface by each solver: 2048² points, H = 0.8, p* = 0.05, tolerance 1e-8.
//!
//! `cargo bench -p gfmd-contact` runs the conjugate gradients. The dynamics take minutes per sample and run only if
//! named, `cargo bench -p gfmd-contact -- Verlet`. For a smaller grid: `GFMD_BENCH_POINTS=512 cargo bench -p
//! gfmd-contact`.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use gfmd_contact::{Contact, Equilibrium, Load, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_surface::{Discretisation, SelfAffine};

const SOLVERS: [(Solver, bool); 8] = [
    (Solver::PreconditionedCg, true),
    (Solver::ProjectedCg, true),
    (Solver::PolonskyKeer, true),
    (Solver::AugmentedLagrangian, true),
    (Solver::Verlet, false),
    (Solver::VerletCritical, false),
    (Solver::Fire, false),
    (Solver::Fire2, false),
];

fn equilibration(criterion: &mut Criterion) {
    let n: usize = std::env::var("GFMD_BENCH_POINTS").ok().and_then(|n| n.parse().ok()).unwrap_or(2048);
    let named = std::env::args().skip(1).any(|argument| !argument.starts_with('-'));
    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: n as f64 / 8.0, eps_c_inv: 4.0 };
    let grid = Grid::square(n, 1.0).expect("a grid");
    let heights = numbers
        .self_affine(1.0, SelfAffine { hurst: 0.8, ..SelfAffine::with_rms_gradient(0.1) })
        .heights(&grid, 1)
        .expect("a surface");
    let material = Material::from_contact_modulus(1.0, 0.0).expect("a material");
    let contact = Contact::new(&Body::half_space(material), &grid, &heights).expect("a contact");
    let mut group = criterion.benchmark_group(format!("equilibration_{n}"));
    group.sample_size(10).sampling_mode(SamplingMode::Flat).warm_up_time(Duration::from_millis(1));
    for (solver, fast) in SOLVERS {
        if !fast && !named && n > 512 {
            continue;
        }
        group.bench_function(format!("{solver:?}"), |bencher| {
            bencher.iter(|| {
                black_box(contact.press(Load::MeanPressure(0.05 * 0.1)).solver(solver).solve().expect("converges"))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, equilibration);
criterion_main!(benches);
