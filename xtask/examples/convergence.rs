//! Figure of the residual against transform pairs for each solver of the hard-wall contact (docs/solvers.md).
//! `cargo run --release -p gfmd-xtask --example convergence` writes docs/images/convergence.png and .svg.

use std::ops::ControlFlow;
use std::path::Path;

use gfmd_contact::{Contact, Equilibrium, Load, Progress, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_plot::{Axis, Chart, Panel, Series};
use gfmd_surface::{Discretisation, SelfAffine};

const POINTS: usize = 512;
const RMS_GRADIENT: f64 = 0.1;
const REDUCED_PRESSURE: f64 = 0.05;

const SOLVERS: [(Solver, &str); 5] = [
    (Solver::PreconditionedCg, "preconditioned-cg"),
    (Solver::ProjectedCg, "projected-cg"),
    (Solver::PolonskyKeer, "cg (Polonsky, Keer)"),
    (Solver::Verlet, "verlet"),
    (Solver::Fire, "fire"),
];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let grid = Grid::square(POINTS, 1.0)?;
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0)?);
    let mut panels = Vec::new();
    for hurst in [0.0, 0.8] {
        let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: POINTS as f64 / 8.0, eps_c_inv: 4.0 };
        let heights = numbers
            .self_affine(1.0, SelfAffine { hurst, ..SelfAffine::with_rms_gradient(RMS_GRADIENT) })
            .heights(&grid, 1)?;
        let contact = Contact::new(&body, &grid, &heights)?;
        let mut series = Vec::new();
        for (hue, (solver, name)) in SOLVERS.into_iter().enumerate() {
            let mut seen = Vec::new();
            let mut watch = |now: &Progress| {
                seen.push((now.iteration as f64, now.residual));
                ControlFlow::Continue(())
            };
            let load = Load::MeanPressure(REDUCED_PRESSURE * RMS_GRADIENT);
            let solution = contact.press(load).solver(solver).watch(&mut watch).solve()?;
            let pairs = solution.effort.transform_pairs / solution.effort.iterations as f64;
            let history = seen.into_iter().filter(|(k, residual)| *k > 0.0 && *residual > 0.0);
            series.push(Series::line(name, hue, history.map(|(k, residual)| (k * pairs, residual))));
        }
        panels.push(Panel {
            title: format!("H = {hurst}"),
            x: Axis::log("transform pairs"),
            y: Axis::log("residual").over([1e-9, 10.0]),
            series,
            ..Panel::default()
        });
    }
    let images = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/images");
    Chart::new(panels).save(&images.join("convergence"))?;
    Ok(())
}
