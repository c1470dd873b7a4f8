//! Iterations and transform pairs of contacts with a law, to a tolerance of 1e-8, to compare two versions: the table of
//! docs/solvers.md. `cargo run --release -p gfmd-interface --example law_pairs -- 256`
//!
//! Arguments: the number of points along an axis, then parts of case names (default: all cases), and `states` to print
//! a line for every load.
#![allow(clippy::print_stdout, reason = "the example prints a table")]

use gfmd_contact::{Boundary, Equilibrium, Fields, Load, SolveError};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Interface, State};
use gfmd_law::{Law, LawKind};
use gfmd_surface::{Discretisation, SelfAffine};

/// Test case with E* = 1 and rms gradient 1, so that loads are reduced pressures.
struct Case {
    name: &'static str,
    hurst: f64,
    law: Box<dyn Law>,
    boundary: Boundary,
    slab: Option<f64>,
    loads: Vec<Load>,
    /// True if every load starts from the last state, false if each has no start.
    follows: bool,
}

type Failure = Box<dyn std::error::Error>;

fn law(kind: LawKind, parameters: &[(&str, f64)]) -> Result<Box<dyn Law>, Failure> {
    Ok(kind.with(parameters)?)
}

fn pressures(values: &[f64]) -> Vec<Load> {
    values.iter().map(|p| Load::MeanPressure(*p)).collect()
}

/// Returns approaches given in units of `range`.
fn approaches(values: &[f64], range: f64) -> Vec<Load> {
    values.iter().map(|d| Load::Approach(d * range)).collect()
}

/// Loading and unloading in nine loads.
const LOOP: [f64; 9] = [0.002, 0.004, 0.006, 0.008, 0.01, 0.0075, 0.005, 0.0025, 0.0];
/// Loads from first touch to nearly full contact.
const COLD: [f64; 6] = [1e-4, 1e-3, 0.01, 0.1, 0.5, 1.5];

fn cases(n: usize) -> Result<Vec<Case>, Failure> {
    let work = 2e-5;
    // The steepness of `exponential(1.0)` is 0.48 times the stiffness of the shortest wave.
    let corner = 0.5 * std::f64::consts::TAU * (n as f64 / 2.0) * std::f64::consts::SQRT_2;
    let range = (work / (0.48 * corner)).sqrt();
    let exponential = |factor: f64| law(LawKind::Exponential, &[("gamma", work * factor), ("range", range * factor)]);
    let case = |name, hurst, law, loads, follows| Case {
        name,
        hurst,
        law,
        boundary: Boundary::Periodic,
        slab: None,
        loads,
        follows,
    };
    let jumps = [-30.0, -20.0, -12.0, -6.0, -3.0, 0.0, 4.0, 0.0, -4.0, -8.0, -14.0, -24.0];
    let morse = law(LawKind::Morse, &[("gamma", work), ("range", range)])?;
    let cosine = law(LawKind::HarmonicCosine, &[("gamma", work), ("curvature", 0.4 * corner)])?;
    let dugdale = law(LawKind::Dugdale, &[("gamma", work), ("range", 2.0 * range)])?;
    Ok(vec![
        case("loop-short-0.8", 0.8, exponential(1.0)?, pressures(&LOOP), true),
        case("loop-short-0.3", 0.3, exponential(1.0)?, pressures(&LOOP), true),
        case("loop-long-0.8", 0.8, exponential(4.0)?, pressures(&LOOP), true),
        case("loop-long-0.3", 0.3, exponential(4.0)?, pressures(&LOOP), true),
        case("cold-short-0.8", 0.8, exponential(1.0)?, pressures(&COLD), false),
        case("cold-long-0.3", 0.3, exponential(4.0)?, pressures(&COLD), false),
        case("jump-approach-0.8", 0.8, exponential(2.0)?, approaches(&jumps, 2.0 * range), true),
        Case {
            slab: Some(0.3),
            ..case("slab-approach-0.3", 0.3, exponential(2.0)?, approaches(&jumps, 2.0 * range), true)
        },
        case("morse-0.8", 0.8, morse, pressures(&LOOP), true),
        case("cosine-0.8", 0.8, cosine, pressures(&COLD), false),
        case("dugdale-0.8", 0.8, dugdale, pressures(&[0.002, 0.01, 0.1]), false),
        Case {
            boundary: Boundary::Free,
            ..case("free-0.8", 0.8, exponential(1.0)?, pressures(&[0.002, 0.01, 0.1, 0.01]), true)
        },
    ])
}

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let n = arguments.iter().find_map(|argument| argument.parse::<usize>().ok()).unwrap_or(256);
    let shows_states = arguments.iter().any(|argument| argument == "states");
    let names: Vec<&String> =
        arguments.iter().filter(|argument| argument.parse::<usize>().is_err() && *argument != "states").collect();
    let grid = Grid::square(n, 1.0)?;
    println!("{:<20} loads  iterations  pairs", "case");
    for case in cases(n)? {
        if !names.is_empty() && !names.iter().any(|name| case.name.contains(name.as_str())) {
            continue;
        }
        let numbers = Discretisation { eps_t_inv: 5.0, eps_f_inv: n as f64 / 40.0, eps_c_inv: 8.0 };
        let heights = numbers
            .self_affine(1.0, SelfAffine { hurst: case.hurst, ..SelfAffine::with_rms_gradient(1.0) })
            .heights(&grid, 1)?;
        let body = match case.slab {
            None => Body::half_space(Material::from_contact_modulus(1.0, 0.0)?),
            Some(height) => Body::slab(Material::from_contact_modulus(1.0, 0.3)?, height)?,
        };
        let interface = Interface::with_boundary(case.boundary, &body, &grid, &heights, case.law)?;
        let (mut last, mut iterations, mut pairs): (Option<State>, u64, f64) = (None, 0, 0.0);
        for load in &case.loads {
            let start = last.as_ref().filter(|_| case.follows);
            let state = match interface.press(*load).starting_from(start).solve() {
                Ok(state) => state,
                Err(SolveError::Detached { .. }) => {
                    println!("{load:?}: apart");
                    continue;
                }
                Err(error) => return Err(error.into()),
            };
            iterations += state.effort.iterations;
            pairs += state.effort.transform_pairs;
            if shows_states {
                print_state(*load, &state);
            }
            last = Some(state);
        }
        println!("{:<20} {:5}  {iterations:10}  {pairs:5}", case.name, case.loads.len());
    }
    Ok(())
}

fn print_state(load: Load, state: &State) {
    let energy = state.elastic_energy + state.interface_energy;
    let gap = state.gap().mean().unwrap_or(f64::NAN);
    println!(
        "  {load:?}: {} iterations {} pairs; area {:.6} pressure {:.8e} approach {:.8e} energy {energy:.8e} gap \
         {gap:.8e}; curvature {:.3}{}",
        state.effort.iterations,
        state.effort.transform_pairs,
        state.contact_fraction,
        state.mean_pressure,
        state.approach,
        state.lowest_curvature,
        if state.passed_instability { ", unstable on the way" } else { "" },
    );
}
