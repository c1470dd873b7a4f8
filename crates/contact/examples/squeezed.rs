//! Iterations of slabs between two rough surfaces, for thicknesses and reduced pressures:
//! `squeezed [POINTS] [HEIGHT,..]`.

use std::error::Error;

use gfmd_contact::{Equilibrium, Fields, Load, SqueezedContact};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_surface::{Discretisation, SelfAffine};

const P_STAR: [f64; 4] = [0.001, 0.01, 0.1, 0.5];

#[allow(clippy::print_stdout, reason = "an example")]
fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let n: usize = arguments.next().map_or(Ok(128), |text| text.parse())?;
    let heights = arguments.next().unwrap_or_else(|| "0.03125,0.0625,0.125,0.5,2,10".into());
    let grid = Grid::square(n, 1.0)?;
    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: n as f64 / 8.0, eps_c_inv: 4.0 };
    let surface = SelfAffine { hurst: 0.8, ..SelfAffine::with_rms_gradient(0.1) };
    let [upper, lower] = [1, 2].map(|seed| numbers.self_affine(1.0, surface).heights(&grid, seed));
    let (upper, lower) = (upper?, lower?);
    println!("iterations (with the approach prescribed), {n} x {n} points, p* = {P_STAR:?}");
    for height in heights.split(',') {
        let body = Body::slab(Material::from_contact_modulus(1.0, 0.3)?, height.parse()?)?;
        let contact = SqueezedContact::new(&body, &grid, &upper, &lower)?;
        print!("height {height:>8}:");
        for p_star in P_STAR {
            let state = contact.press(Load::MeanPressure(0.1 * p_star)).solve()?;
            let again = contact.press(Load::Approach(state.approach)).solve()?;
            print!(" {:>5} ({})", state.effort().iterations, again.effort().iterations);
        }
        println!();
    }
    Ok(())
}
