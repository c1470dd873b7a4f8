//! Benchmark of the equilibration of rough surfaces of 2048² points by each solver, to a tolerance of 1e-8: on a
//! half-space (H = 0.8, p* = 0.05), and the case of the thesis, a slab as high as the cell is wide (ν = 0.33, H = 0,
//! p* = 0.01).
//!
//! `cargo bench -p gfmd-contact` runs the conjugate gradients. The dynamics take minutes per sample and run only if
//! named: `cargo bench -p gfmd-contact -- Verlet`. A smaller grid: `GFMD_BENCH_POINTS=512 cargo bench -p gfmd-contact`.

use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use gfmd_contact::{Contact, Equilibrium, Load, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_surface::{Discretisation, SelfAffine};

const SOLVERS: [(Solver, bool); 9] = [
    (Solver::Auto, true),
    (Solver::PreconditionedCg, true),
    (Solver::ProjectedCg, true),
    (Solver::PolonskyKeer, true),
    (Solver::AugmentedLagrangian, true),
    (Solver::Verlet, false),
    (Solver::VerletCritical, false),
    (Solver::Fire, false),
    (Solver::Fire2, false),
];

const RMS_GRADIENT: f64 = 0.1;

fn equilibration(criterion: &mut Criterion) {
    let material = |poisson| Material::from_contact_modulus(1.0, poisson).expect("a material");
    press(criterion, "half_space", &Body::half_space(material(0.0)), 0.8, 0.05);
    press(criterion, "slab", &Body::slab(material(0.33), 1.0).expect("a slab"), 0.0, 0.01);
}

fn press(criterion: &mut Criterion, name: &str, body: &Body, hurst: f64, reduced_pressure: f64) {
    let n: usize = std::env::var("GFMD_BENCH_POINTS").ok().and_then(|n| n.parse().ok()).unwrap_or(2048);
    let named = std::env::args().skip(1).any(|argument| !argument.starts_with('-'));
    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: n as f64 / 8.0, eps_c_inv: 4.0 };
    let grid = Grid::square(n, 1.0).expect("a grid");
    let heights = numbers
        .self_affine(1.0, SelfAffine { hurst, ..SelfAffine::with_rms_gradient(RMS_GRADIENT) })
        .heights(&grid, 1)
        .expect("a surface");
    let contact = Contact::new(body, &grid, &heights).expect("a contact");
    let mut group = criterion.benchmark_group(format!("equilibration_{name}_{n}"));
    group.sample_size(10).sampling_mode(SamplingMode::Flat).warm_up_time(Duration::from_millis(1));
    for (solver, fast) in SOLVERS {
        if !fast && !named && n > 512 {
            continue;
        }
        group.bench_function(format!("{solver:?}"), |bencher| {
            let load = Load::MeanPressure(reduced_pressure * RMS_GRADIENT);
            bencher.iter(|| black_box(contact.press(load).solver(solver).solve().expect("converges")));
        });
    }
    group.finish();
}

criterion_group!(benches, equilibration);
criterion_main!(benches);
