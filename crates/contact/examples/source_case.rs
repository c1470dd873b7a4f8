//! Cost of the case of the thesis in three components: a rough surface (H = 0, rms gradient 0.01) on a slab as high as
//! the cell with nu = 0.33, p* = 0.01, to residuals of 1e-8. The dynamics moves all components, as the thesis does; the
//! default seeks the pressure, which determines all components. `cargo run --release -p gfmd-contact --example
//! source_case -- 256 512`
#![allow(clippy::print_stdout, reason = "the example prints a table")]

use std::time::Instant;

use gfmd_contact::{Contact, Equilibrium, Load, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_surface::{Discretisation, SelfAffine};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let body = Body::slab(Material::from_contact_modulus(1.0, 0.33)?, 1.0)?;
    println!("{:>5} {:>16} {:>7} {:>8} {:>8}", "n", "solver", "steps", "pairs", "seconds");
    for size in std::env::args().skip(1) {
        let n: usize = size.parse()?;
        let grid = Grid::square(n, 1.0)?;
        let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: n as f64 / 8.0, eps_c_inv: 4.0 };
        let rough = numbers.self_affine(1.0, SelfAffine { hurst: 0.0, ..SelfAffine::with_rms_gradient(0.01) });
        let heights = rough.heights(&grid, 1)?;
        let load = Load::MeanPressure(0.01 * 0.01);
        let begin = Instant::now();
        let found = Contact::new(&body, &grid, &heights)?.press(load).solve()?;
        let seconds = begin.elapsed().as_secs_f64();
        println!(
            "{n:5} {:>16} {:7} {:8} {seconds:8.1}",
            "default, u_z", found.effort.iterations, found.effort.transform_pairs
        );
        let full = Contact::in_all_components(&body, &grid, &heights)?;
        for solver in [Solver::Verlet, Solver::VerletCritical, Solver::Fire] {
            let begin = Instant::now();
            let found = full.press(load).solver(solver).solve()?;
            let (seconds, effort) = (begin.elapsed().as_secs_f64(), found.effort);
            println!("{n:5} {:>16} {:7} {:8} {seconds:8.1}", solver.name(), effort.iterations, effort.transform_pairs);
        }
    }
    Ok(())
}
