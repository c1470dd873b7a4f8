//! Number of transform pairs to a tolerance of 1e-8 for each conjugate-gradient method, without a start, for rough
//! surfaces on a half-space: the table of docs/solvers.md. `cargo run --release -p gfmd-contact --example pairs -- 512
//! 1024`
//!
//! The dynamics take longer and run only if requested by name, all or some:
//! `cargo run --release -p gfmd-contact --example pairs -- dynamics 512`, `... -- Verlet AugmentedLagrangian 2048`. The
//! number of steps is the number of pairs minus the few that check the result.
//!
//! The number in brackets is the time of the whole solution in units of the time of one pair. The excess over the
//! number of pairs is the cost of the sweeps over vectors and of memory. It is only as reproducible as the load on the
//! machine.
#![allow(clippy::print_stdout, reason = "the example prints a table")]

use std::sync::Arc;
use std::time::Instant;

use gfmd_contact::{Contact, Equilibrium, Load, Solver};
use gfmd_field::{Grid, Transform};
use gfmd_green::{Body, Material};
use gfmd_response::NormalResponse;
use gfmd_surface::{Discretisation, SelfAffine};

const GRADIENTS: [Solver; 4] = [Solver::Auto, Solver::PreconditionedCg, Solver::ProjectedCg, Solver::PolonskyKeer];
const DYNAMICS: [Solver; 5] =
    [Solver::VerletCritical, Solver::Verlet, Solver::Fire, Solver::Fire2, Solver::AugmentedLagrangian];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut sizes, mut solvers) = (Vec::new(), Vec::new());
    for argument in std::env::args().skip(1) {
        let named = GRADIENTS.iter().chain(&DYNAMICS).find(|solver| format!("{solver:?}") == argument);
        match (argument.as_str(), named) {
            ("dynamics", _) => solvers.extend(DYNAMICS),
            (_, Some(solver)) => solvers.push(*solver),
            (size, None) => sizes.push(size.parse::<usize>()?),
        }
    }
    if solvers.is_empty() {
        solvers.extend(GRADIENTS);
    }
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0)?);
    println!("{:>5} {:>4} {:>6}  pairs (time of the solution in pairs), {solvers:?}", "n", "H", "p*");
    for n in if sizes.is_empty() { vec![512] } else { sizes } {
        let grid = Grid::square(n, 1.0)?;
        let response = Arc::new(NormalResponse::new(grid, &body));
        let pair = time_of_a_pair(grid)?;
        println!("{n:5}: {:.1} ms for a pair", 1e3 * pair);
        for hurst in [0.0, 0.3, 0.8] {
            let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: n as f64 / 8.0, eps_c_inv: 4.0 };
            let heights = numbers
                .self_affine(1.0, SelfAffine { hurst, ..SelfAffine::with_rms_gradient(0.1) })
                .heights(&grid, 1)?;
            let contact = Contact::with_response(Arc::clone(&response), &heights)?;
            for reduced_pressure in [1e-4, 1e-3, 0.01, 0.05, 0.2, 0.6] {
                print!("{n:5} {hurst:4} {reduced_pressure:6} ");
                for &solver in &solvers {
                    let load = Load::MeanPressure(reduced_pressure * 0.1);
                    let begin = Instant::now();
                    let solution = contact.press(load).solver(solver).solve()?;
                    let time = begin.elapsed().as_secs_f64() / pair;
                    print!("{:7} ({time:4.0})", solution.effort.transform_pairs);
                }
                println!();
            }
        }
    }
    Ok(())
}

/// Returns the smallest of several measured times of a transform pair.
fn time_of_a_pair(grid: Grid) -> Result<f64, Box<dyn std::error::Error>> {
    let transform = Transform::new(grid);
    let mut workspace = transform.workspace();
    let kernel = vec![1.0; grid.spectrum_len()];
    let field: Vec<f64> = (0..grid.len()).map(|i| (0.618_034 * i as f64).fract()).collect();
    let mut out = vec![0.0; grid.len()];
    let mut fastest = f64::INFINITY;
    for _ in 0..10 {
        let begin = Instant::now();
        transform.convolve(&kernel, &field, &mut out, &mut workspace)?;
        fastest = fastest.min(begin.elapsed().as_secs_f64());
    }
    Ok(fastest)
}
