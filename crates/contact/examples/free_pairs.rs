//! Number of iterations to a tolerance of 1e-8 with free and with periodic boundaries, without a start, for rough
//! surfaces on a half-space: the table of docs/solvers.md. `cargo run -p gfmd-contact --example free_pairs -- 128`
#![allow(clippy::print_stdout, reason = "the example prints a table")]

use gfmd_contact::{Boundary, Contact, Equilibrium, Load, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_surface::{Discretisation, SelfAffine};
use ndarray::{Array2, s};

/// Surfaces: Hurst exponent, true if cut out of a surface of four times the area, and cells per longest wavelength.
const SURFACES: [(f64, bool, f64); 5] =
    [(0.0, false, 2.0), (0.8, false, 2.0), (0.0, true, 1.0), (0.8, true, 1.0), (0.8, true, 2.0)];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0)?);
    let n: usize = std::env::args().nth(1).map_or(Ok(128), |n| n.parse())?;
    let grid = Grid::square(n, 1.0)?;
    println!("{:>4} {:>5} {:>6}  iterations: free, periodic; free to the same approach", "H", "cut", "p*");
    for (hurst, cut, eps_t_inv) in SURFACES {
        let sides = if cut { 2 } else { 1 };
        let whole = Grid::square(sides * n, sides as f64)?;
        let numbers = Discretisation { eps_t_inv, eps_f_inv: (sides * n) as f64 / (4.0 * eps_t_inv), eps_c_inv: 4.0 };
        let family = SelfAffine { hurst, ..SelfAffine::with_rms_gradient(0.1) };
        let heights = numbers.self_affine(1.0, family).heights(&whole, 1)?;
        let heights: Array2<f64> = heights.slice(s![..n, ..n]).to_owned();
        let [free, periodic] =
            [Boundary::Free, Boundary::Periodic].map(|b| Contact::with_boundary(b, &body, &grid, &heights));
        let (free, periodic) = (free?, periodic?);
        for reduced_pressure in [1e-3, 0.01, 0.05, 0.2, 0.6, 2.0, 10.0] {
            let load = Load::MeanPressure(reduced_pressure * 0.1);
            let solve = |contact: &Contact, load: Load| contact.press(load).solver(Solver::PreconditionedCg).solve();
            let (alone, repeated) = (solve(&free, load)?, solve(&periodic, load)?);
            let again = solve(&free, Load::Approach(alone.approach))?;
            let [alone, repeated, again] = [alone, repeated, again].map(|solution| solution.effort.iterations);
            println!("{hurst:4} {cut:>5} {reduced_pressure:6}  {alone:3} {repeated:3} {again:3}");
        }
    }
    Ok(())
}
