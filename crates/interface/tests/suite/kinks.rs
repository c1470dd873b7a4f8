//! A wall that gives way below a law: hardness and springs.

use gfmd_contact::{Boundary, Budget, Contact, Equilibrium, Fields as _, Load, Refusal, SolveError};
use gfmd_field::Grid;
use gfmd_green::{Body, Height, Material};
use gfmd_interface::{Interface, State};
use gfmd_law::{Dugdale, Exponential, HardWall, Law, Morse};
use ndarray::Array2;

const N: usize = 16;

fn body() -> Body {
    Body::half_space(Material::from_contact_modulus(1.0, 0.3).unwrap())
}

fn grid() -> Grid {
    Grid::square(N, 1.0).unwrap()
}

/// Heights of the reference values below, at the centres of the cells.
fn waves(n: usize) -> Array2<f64> {
    let turn = std::f64::consts::TAU;
    Array2::from_shape_fn((n, n), |(i, j)| {
        let [x, y] = [i, j].map(|k| turn * (k as f64 + 0.5) / n as f64);
        0.02 * (x + 0.3).cos() * (y - 0.7).cos() + 0.008 * (2.0 * x + y + 1.1).cos() + 0.004 * (x - 3.0 * y + 2.0).cos()
    })
}

fn exponential() -> Exponential {
    Exponential::new(2e-4, 0.01).unwrap()
}

fn periodic(law: impl Law + 'static) -> Interface {
    Interface::new(&body(), &grid(), &waves(N), law).unwrap()
}

fn solve(interface: &Interface, load: Load, start: Option<&State>) -> State {
    let budget = Budget { tolerance: 1e-10, max_iterations: 400 };
    let solved = interface.press(load).budget(budget).starting_from(start).solve();
    solved.unwrap_or_else(|error| panic!("{load:?}: {error}"))
}

/// Numbers of a reference state: mean pressure, approach, points in contact, largest repulsion, largest and least
/// pressure, elastic energy, energy of the law, mean worn or pressed depth, its work.
type Reference = [f64; 10];

fn compare(name: &str, found: Reference, expected: Reference) {
    // Relative to the size of each number along the path.
    let scales = [0.02, 0.03, 1e-300, 0.17, 0.15, 0.15, 1.3e-4, 1.7e-4, 2e-3, 5e-5];
    for (k, ((found, expected), scale)) in found.into_iter().zip(expected).zip(scales).enumerate() {
        let error = (found - expected).abs() / scale;
        assert!(error <= 2e-7, "{name}, number {k}: {found:e} instead of {expected:e}, error {error:e}");
    }
}

/// Loads of the reference paths, and sliding distances.
const PATH: [[f64; 2]; 4] = [[0.01, 0.02], [0.02, 0.05], [0.02, 0.09], [0.012, 0.1]];

/// Follows the reference path with a hardness and a wear coefficient, if any; the depth is added to the clearance after
/// each step. Returns the numbers of each state.
fn follow(law: impl Law + 'static, hardness: Option<f64>, coefficient: f64) -> Vec<Reference> {
    let virgin = periodic(law);
    let mut depth = Array2::zeros((N, N));
    let mut start: Option<State> = None;
    let mut slid = 0.0;
    let mut numbers = Vec::new();
    for [load, distance] in PATH {
        let compliance = coefficient * (distance - slid);
        slid = distance;
        let mut interface = virgin.with_indentation(&depth).unwrap().with_springs(compliance).unwrap();
        if let Some(hardness) = hardness {
            interface = interface.with_hardness(hardness).unwrap();
        }
        let state = solve(&interface, Load::MeanPressure(load), start.as_ref());
        let mut growth = compliance * &state.wall_pressure;
        if let Some(pressed) = &state.pressed_in {
            growth += pressed;
        }
        depth += &growth;
        let pressure = state.pressure().into_owned();
        let most = |field: &Array2<f64>| field.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        numbers.push([
            state.mean_pressure,
            state.approach,
            state.contact_fraction * (N * N) as f64,
            most(&state.wall_pressure),
            most(&pressure),
            -most(&-&pressure),
            state.elastic_energy,
            state.interface_energy,
            depth.mean().unwrap(),
            (&pressure * &growth).mean().unwrap(),
        ]);
        assert!(state.residual.worst() <= 1e-10 && state.gap.iter().all(|gap| *gap >= 0.0), "{:?}", state.residual);
        start = Some(state);
    }
    numbers
}

/// Values of a dense semismooth Newton method for all unknowns at once on the same discrete problem, which is
/// independent of this crate; residuals below 1e-14.
#[test]
fn a_hard_surface_below_a_law_meets_the_dense_reference() {
    let expected = [
        [
            0.01,
            0.023903314145596377,
            96.0,
            0.11,
            0.09,
            -0.019958932805976482,
            8.159100836744871e-05,
            -0.00013346949755141963,
            0.00025054249782690175,
            2.2548824804421155e-05,
        ],
        [
            0.02,
            0.026776667052114067,
            127.0,
            0.11,
            0.09,
            -0.019883242668054853,
            0.0001238104586032021,
            -0.00015797298087667693,
            0.0005249242134379655,
            2.469435440499574e-05,
        ],
        [
            0.02,
            0.026776667052114067,
            127.0,
            0.11,
            0.09,
            -0.019883242668054853,
            0.0001238104586032021,
            -0.00015797298087667693,
            0.0005249242134379655,
            0.0,
        ],
        [
            0.012,
            0.025104653795842126,
            105.0,
            0.09791226724513578,
            0.07791226724513578,
            -0.01991204105368291,
            8.125130540053026e-05,
            -0.0001417732793346841,
            0.0005249242134379655,
            0.0,
        ],
    ];
    for (k, (found, expected)) in follow(exponential(), Some(0.09), 0.0).into_iter().zip(expected).enumerate() {
        compare(&format!("step {k}"), found, expected);
    }
}

/// Values of the dense method, as above.
#[test]
fn a_worn_surface_below_a_law_meets_the_dense_reference() {
    let expected = [
        [
            0.01,
            0.024180171356014513,
            99.0,
            0.17181411563662197,
            0.15181411563662198,
            -0.01982176236318879,
            9.505027970979128e-05,
            -0.00013585605229144278,
            0.00028302726274973135,
            1.8864488108100814e-05,
        ],
        [
            0.02,
            0.027638438748894288,
            146.0,
            0.17465945510402114,
            0.15465945510402113,
            -0.019920050618687037,
            0.0001338467443418364,
            -0.00016309817184363728,
            0.0009366039720682786,
            4.450924462301393e-05,
        ],
        [
            0.02,
            0.029065552144044354,
            166.0,
            0.1579009984906812,
            0.13790099849068121,
            -0.01989804215840424,
            0.00011451435753027822,
            -0.0001691610313214344,
            0.001822590447239721,
            5.235929842348891e-05,
        ],
        [
            0.012,
            0.028440512819547646,
            142.0,
            0.14295437139885855,
            0.12295437139885856,
            -0.01999124216804958,
            8.673950653226154e-05,
            -0.00016114476877512635,
            0.001991277308504797,
            8.789034073867871e-06,
        ],
    ];
    let mut expected = expected;
    expected[3][5] = -0.01999124671804958;
    for (k, (found, expected)) in follow(exponential(), None, 0.6).into_iter().zip(expected).enumerate() {
        compare(&format!("step {k}"), found, expected);
    }
}
