//! Number of transform pairs to a tolerance of 1e-8 on bodies of all kinds, without a start: a table of
//! docs/solvers.md. `cargo run --release -p gfmd-contact --example body_pairs -- 512`; methods are selected by name,
//! bodies by the beginning of theirs: `... -- 256 PreconditionedCg Verlet free`.
//!
//! Heights are in units of the cell length; the longest wave is half a cell long. "over" means that 3000 iterations are
//! not enough.
#![allow(clippy::print_stdout, reason = "the example prints a table")]

use std::sync::Arc;

use gfmd_contact::{Budget, Contact, Equilibrium, Load, Solver};
use gfmd_field::Grid;
use gfmd_green::{Base, Body, Material};
use gfmd_response::NormalResponse;
use gfmd_surface::{Discretisation, SelfAffine};

fn bodies() -> Result<Vec<(&'static str, Body)>, Box<dyn std::error::Error>> {
    let material = |young, poisson| Material::from_young(young, poisson);
    let slab = |height, base| Body::slab(material(1.0, 0.3)?, height)?.on(base);
    let coat = |young, height| {
        let substrate = Base::Elastic(Body::half_space(material(1.0, 0.3)?).into());
        Body::slab(material(young, 0.3)?, height)?.on(substrate)
    };
    let rubber = Body::slab(material(1.0, 0.5)?, 0.1)?;
    let half_space = Body::half_space(material(1.0, 0.3)?);
    let layers = [(material(1.0, 0.3)?, 0.02), (material(10.0, 0.2)?, 0.05), (material(0.1, 0.45)?, 0.1)];
    Ok(vec![
        ("half-space", half_space.clone()),
        ("bonded, 1", slab(1.0, Base::BONDED)?),
        ("bonded, 0.1", slab(0.1, Base::BONDED)?),
        ("bonded, 0.01", slab(0.01, Base::BONDED)?),
        ("bonded, 0.1, nu = 1/2", rubber.clone()),
        ("sliding, 1", slab(1.0, Base::SLIDING)?),
        ("sliding, 0.1", slab(0.1, Base::SLIDING)?),
        ("sliding, 0.01", slab(0.01, Base::SLIDING)?),
        ("free, 1", slab(1.0, Base::FREE)?),
        ("free, 0.3", slab(0.3, Base::FREE)?),
        ("free, 0.1", slab(0.1, Base::FREE)?),
        ("free, 0.03", slab(0.03, Base::FREE)?),
        ("coating E = 10, 0.02", coat(10.0, 0.02)?),
        ("coating E = 1000, 0.02", coat(1000.0, 0.02)?),
        ("coating E = 0.1, 0.02", coat(0.1, 0.02)?),
        ("coating E = 0.001, 0.02", coat(0.001, 0.02)?),
        ("three layers, bonded", Body::stack(&layers, Base::BONDED)?),
        ("three layers, free", Body::stack(&layers, Base::FREE)?),
        ("half-space against a slab", half_space.against(rubber)),
    ])
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut sizes, mut solvers, mut names) = (Vec::new(), Vec::new(), Vec::new());
    for argument in std::env::args().skip(1) {
        let named = Solver::ALL.into_iter().find(|solver| format!("{solver:?}") == argument);
        match (named, argument.parse::<usize>()) {
            (Some(solver), _) => solvers.push(solver),
            (None, Ok(size)) => sizes.push(size),
            (None, Err(_)) => names.push(argument),
        }
    }
    if solvers.is_empty() {
        solvers.extend([Solver::Auto, Solver::ProjectedCg, Solver::PolonskyKeer]);
    }
    println!("pairs of {solvers:?} at H = 0, 0.8; columns p* = 0.01, 0.05, 0.2");
    for n in if sizes.is_empty() { vec![512] } else { sizes } {
        let grid = Grid::square(n, 1.0)?;
        for (name, body) in bodies()? {
            if !(names.is_empty() || names.iter().any(|start| name.starts_with(start.as_str()))) {
                continue;
            }
            let response = Arc::new(NormalResponse::new(grid, &body));
            print!("{n} {name:<26}");
            for &solver in &solvers {
                for reduced_pressure in [0.01, 0.05, 0.2] {
                    for hurst in [0.0, 0.8] {
                        let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: n as f64 / 8.0, eps_c_inv: 4.0 };
                        let spectrum = SelfAffine { hurst, ..SelfAffine::with_rms_gradient(0.1) };
                        let heights = numbers.self_affine(1.0, spectrum).heights(&grid, 1)?;
                        let contact = Contact::with_response(Arc::clone(&response), &heights)?;
                        let load = Load::MeanPressure(reduced_pressure * contact.reduced_pressure_unit());
                        match contact
                            .press(load)
                            .solver(solver)
                            .budget(Budget { max_iterations: 3000, ..Budget::default() })
                            .solve()
                        {
                            Ok(solution) => print!(" {:5.0}", solution.effort.transform_pairs),
                            Err(_) => print!("  over"),
                        }
                    }
                    print!(";");
                }
                print!(" | ");
            }
            println!();
        }
    }
    Ok(())
}
