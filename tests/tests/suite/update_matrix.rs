//! Dynamics of a free surface against the eigenvalues of the update matrix of every mode, all components at once
//! (theory.md, sections 6.1 and 6.2).

use std::sync::Mutex;

use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_relax::{Damping, Harmonic, Landscape, Method, ModeDamped, State, Verlet};
use gfmd_response::{FullResponse, Operator};

/// Returns the operator with `f` of the stiffness of every mode.
fn function(stiffness: &Operator, f: impl Fn(f64) -> f64 + Sync) -> Operator {
    stiffness.beside(|mode| stiffness.matrices()[stiffness.grid().index_of(mode.number).unwrap()].function(&f))
}

fn after<M: Method>(method: &M, free: &mut impl Landscape, start: &[f64], steps: u32) -> Vec<f64> {
    let mut state: State<M::Memory> = method.start(free, start.to_vec()).unwrap();
    for _ in 0..steps {
        method.step(free, &mut state).unwrap();
    }
    state.u
}

#[test]
fn every_mode_moves_as_the_eigenvalues_of_its_update_matrix_say() {
    // Odd and even, in the plane and in space.
    for grid in [Grid::line(17, 1.0).unwrap(), Grid::line(12, 1.0).unwrap(), Grid::new([9, 8], [1.0, 1.3]).unwrap()] {
        let body = Body::slab(Material::from_young(1.0, 0.4).unwrap(), 0.3).unwrap();
        let response = FullResponse::new(grid, &body);
        let stiffness = response.stiffness();
        let [softest, stiffest] = response.stiffness_range();
        let mut workspace = response.workspace();
        let product = |u: &[f64], out: &mut [f64]| stiffness.apply(u, out, &mut workspace).unwrap();
        let mut free = Harmonic::new(response.components().len() * grid.len(), product);
        let start: Vec<f64> = (0..free.len()).map(|i| (0.618_034 * (i * i) as f64).fract() - 0.5).collect();
        let expected = |history: &(dyn Fn(f64) -> f64 + Sync)| {
            let mut u = vec![0.0; start.len()];
            function(stiffness, history).apply(&start, &mut u, &mut response.workspace()).unwrap();
            u
        };
        let worst = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        let dt = 0.9 / stiffest.sqrt();
        let critical = Damping::critical(softest, dt);
        for steps in [1, 10, 60] {
            for factor in [0.3, 1.0, 2.5] {
                let damping = Damping { beta: 1.0 - factor * critical.eta() * critical.tau, ..critical };
                let found = after(&Verlet::new(damping, stiffest).unwrap(), &mut free, &start, steps);
                let predicted = expected(&|k| damping.amplitude(k, steps));
                assert!(worst(&found, &predicted) < 1e-11, "{factor}, {steps}: {:e}", worst(&found, &predicted));
            }
            // Mode-dependent damping, critical for each mode.
            let retain = function(stiffness, |k| Damping::critical(k, dt).beta);
            let scratch = Mutex::new((response.workspace(), vec![0.0; start.len()]));
            let retain = |motion: &mut [f64]| {
                let (workspace, before) = &mut *scratch.lock().unwrap();
                before.copy_from_slice(motion);
                retain.apply(before, motion, workspace).unwrap();
            };
            let found = after(&ModeDamped::critical(dt * dt, retain), &mut free, &start, steps);
            let predicted = expected(&|k| Damping::critical(k, dt).amplitude(k, steps));
            assert!(worst(&found, &predicted) < 1e-11, "{steps}: {:e}", worst(&found, &predicted));
        }
    }
}
