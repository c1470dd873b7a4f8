//! Closed forms: the error must fall with the grid spacing, at an order that is measured here.

use std::f64::consts::{PI, TAU};

use approx::assert_relative_eq;
use gfmd_contact::{Contact, Control, Settings, Solution};
use gfmd_field::Grid;
use gfmd_measure::theory::{
    Westergaard, hertz_line, hertz_point, johnson_area_at_low_load, johnson_area_near_full_contact,
    johnson_full_contact_pressure, persson_area,
};
use gfmd_measure::{contact_area, pressure_statistics};
use gfmd_response::NormalResponse;
use gfmd_surface::Discretisation;
use gfmd_tests::{number, press, press_on_half_space, reference, unit_half_space};
use ndarray::Array2;

const TOLERANCE: f64 = 1e-11;

fn line(profile: impl Fn(f64) -> f64, n: usize, mean_pressure: f64) -> Solution {
    let response = NormalResponse::new(Grid::line(n, 1.0).unwrap(), &unit_half_space());
    let heights = Array2::from_shape_fn((n, 1), |(i, _)| profile(i as f64 / n as f64));
    let settings = Settings { tolerance: TOLERANCE, ..Settings::default() };
    press(&response, heights.view(), Control::MeanPressure(mean_pressure), &settings).unwrap()
}

fn plane(profile: impl Fn(f64, f64) -> f64, n: usize, mean_pressure: f64) -> Solution {
    let heights = Array2::from_shape_fn((n, n), |(i, j)| profile(i as f64 / n as f64, j as f64 / n as f64));
    press_on_half_space(heights.view(), mean_pressure, TOLERANCE)
}

fn peak(solution: &Solution) -> f64 {
    solution.pressure.iter().copied().fold(0.0, f64::max)
}

/// Errors at one grid: root mean square over contacts that are shifted by parts of the spacing, because a single one
/// jumps with the place of its edge between two points.
fn shifted<const K: usize>(n: usize, errors: impl Fn(f64) -> [f64; K]) -> [f64; K] {
    const SHIFTS: usize = 5;
    let all: Vec<[f64; K]> = (0..SHIFTS).map(|k| errors(k as f64 / SHIFTS as f64 / n as f64)).collect();
    std::array::from_fn(|k| (all.iter().map(|e| e[k].powi(2)).sum::<f64>() / SHIFTS as f64).sqrt())
}

/// Order at which the errors fall, by least squares over all grids.
fn order<const K: usize>(grids: &[usize], errors: impl Fn(usize) -> [f64; K]) -> [f64; K] {
    let points: Vec<(f64, [f64; K])> = grids.iter().map(|&n| ((n as f64).ln(), errors(n).map(|e| -e.ln()))).collect();
    let count = points.len() as f64;
    let x = points.iter().map(|p| p.0).sum::<f64>() / count;
    let squares: f64 = points.iter().map(|p| (p.0 - x).powi(2)).sum();
    std::array::from_fn(|k| points.iter().map(|p| (p.0 - x) * p.1[k]).sum::<f64>() / squares)
}

/// Root mean square deviation of the pressure from `exact`, over the root mean square of `exact`.
fn deviation(solution: &Solution, exact: impl Fn(f64, f64) -> f64) -> f64 {
    let (nx, ny) = solution.pressure.dim();
    let sums = solution.pressure.indexed_iter().fold([0.0; 2], |sums, ((i, j), p)| {
        let exact = exact(i as f64 / nx as f64, j as f64 / ny as f64);
        [sums[0] + (p - exact).powi(2), sums[1] + exact.powi(2)]
    });
    (sums[0] / sums[1]).sqrt()
}

#[test]
fn westergaards_wave_converges_with_the_grid() {
    let wave = Westergaard { modulus: 1.0, amplitude: 0.01, period: 1.0 };
    for load in [0.1, 0.3, 0.7] {
        let mean = load * wave.full_contact_pressure();
        let [gap, pressure] = order(&[128, 256, 512, 1024, 2048], |n| {
            shifted(n, |shift| {
                let solution = line(|x| 0.01 * (TAU * (x - shift)).cos(), n, mean);
                // Each of the two edges is known to the spacing, no better.
                let area = contact_area(solution.pressure.view()).fraction - wave.area(mean);
                assert!(area.abs() < 2.0 / n as f64, "load {load}, n {n}: the area is off by {area:.1e}");
                [
                    solution.gap.mean().unwrap() / wave.mean_gap(mean) - 1.0,
                    deviation(&solution, |x, _| wave.pressure(mean, x - shift)),
                ]
            })
        });
        // The pressure ends in a square root, its error is that of a point or two at the edge: order 1. The mean gap
        // integrates a 3/2 power over that stretch.
        assert!(gap > 1.5, "load {load}: the mean gap converges with order {gap:.2}");
        assert!(pressure > 0.8, "load {load}: the pressure converges with order {pressure:.2}");
    }
}

#[test]
fn hertzian_contacts_converge() {
    let half_width = 0.004;
    let force = PI * half_width * half_width / 4.0;
    let (edge, top) = hertz_line(1.0, 1.0, force);
    let hertz = |d: f64, edge: f64| (1.0 - (d / edge).powi(2)).max(0.0).sqrt();
    let [pressure, area] = order(&[1024, 2048, 4096, 8192], |n| {
        shifted(n, |shift| {
            let solution = line(|x| -(x - 0.5 - shift).powi(2) / 2.0, n, force);
            let area = contact_area(solution.pressure.view()).fraction;
            [deviation(&solution, |x, _| top * hertz(x - 0.5 - shift, edge)), area / (2.0 * edge) - 1.0]
        })
    });
    assert!(pressure > 0.8 && area > 0.8, "line: pressure order {pressure:.2}, area order {area:.2}");

    let force = 4.0 * 0.05_f64.powi(3) / 3.0;
    let exact = hertz_point(1.0, 1.0, force);
    let [pressure, top, area] = order(&[64, 96, 128, 192, 256], |n| {
        shifted(n, |shift| {
            let centre = [0.5 + shift, 0.5 + 0.37 * shift];
            let distance = |x: f64, y: f64| (x - centre[0]).hypot(y - centre[1]);
            let solution = plane(|x, y| -distance(x, y).powi(2) / 2.0, n, force);
            let area = contact_area(solution.pressure.view());
            [
                deviation(&solution, |x, y| exact.peak_pressure * hertz(distance(x, y), exact.radius)),
                peak(&solution) / exact.peak_pressure - 1.0,
                area.fraction / (PI * exact.radius.powi(2)) - 1.0,
            ]
        })
    });
    assert!(pressure > 0.8, "point: the pressure converges with order {pressure:.2}");
    assert!(top > 1.2, "point: the peak converges with order {top:.2}");
    assert!(area > 0.8, "point: the area converges with order {area:.2}");
}

#[test]
fn johnsons_wavy_surface_from_first_touch_to_full_contact() {
    let full = johnson_full_contact_pressure(1.0, 0.01, 1.0);
    let wavy = |x: f64, y: f64| 0.01 * (TAU * x).cos() * (TAU * y).cos();
    let area = |load: f64, n: usize| {
        let solution = plane(wavy, n, load * full);
        contact_area(solution.pressure.view())
    };
    // The asymptotes hold at the ends only; between them the published curve is met point by point.
    let low = area(0.002, 384).corrected_fraction;
    assert_relative_eq!(low, johnson_area_at_low_load(0.002), max_relative = 0.04);
    let high = area(0.98, 384).fraction;
    assert_relative_eq!(1.0 - high, 1.0 - johnson_area_near_full_contact(0.98), max_relative = 0.05);
    for row in reference("analytic/jgh_numeric.json")["rows"].as_array().unwrap() {
        let load = number(row, "pbar_over_pstar");
        for n in [128, 256] {
            let expected = &row[format!("n{n}")];
            let solution = plane(wavy, n, load * full);
            let fraction = contact_area(solution.pressure.view()).fraction;
            assert_relative_eq!(fraction, number(expected, "nodal_area_fraction"), epsilon = 1e-12);
            let gap = solution.gap.mean().unwrap() / 0.01;
            assert_relative_eq!(gap, number(expected, "mean_gap_over_Delta"), epsilon = 1e-9);
            assert_relative_eq!(peak(&solution) / full, number(expected, "p_max_over_pstar"), max_relative = 1e-8);
        }
    }
}

#[test]
fn at_full_contact_the_pressure_is_perssons_gaussian() {
    // Its variance is (E* g/2)², exactly; the area of the theory is that of the part above zero.
    let numbers = Discretisation { eps_t_inv: 4.0, eps_f_inv: 8.0, eps_c_inv: 4.0 };
    let grid = Grid::square(numbers.points().unwrap(), 1.0).unwrap();
    let heights = numbers.self_affine(1.0, 0.5, 0.1).heights(&grid, 5).unwrap();
    let response = NormalResponse::new(grid, &unit_half_space());
    let settings = Settings { tolerance: TOLERANCE, ..Settings::default() };
    for p_star in [4.0, 8.0] {
        let load = Control::MeanPressure(p_star * 0.1);
        let solution = press(&response, heights.view(), load, &settings).unwrap();
        let pressure = pressure_statistics(solution.pressure.view());
        assert_eq!(contact_area(solution.pressure.view()).fraction, 1.0);
        let variance = pressure.moments[0] - pressure.mean.powi(2);
        assert_relative_eq!(variance, (0.1_f64 / 2.0).powi(2), max_relative = 1e-9);
    }
    assert_relative_eq!(persson_area(4.0), 1.0, epsilon = 1e-12);
}

#[test]
fn a_higher_load_started_from_a_lower_one_is_the_same_contact() {
    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: 16.0, eps_c_inv: 4.0 };
    let grid = Grid::square(numbers.points().unwrap(), 1.0).unwrap();
    let heights = numbers.self_affine(1.0, 0.8, 0.1).heights(&grid, 11).unwrap();
    let response = NormalResponse::new(grid, &unit_half_space());
    let contact = Contact::new(&response, heights.view()).unwrap();
    let settings = Settings { tolerance: 1e-12, ..Settings::default() };
    let mut watch = |_: &_| std::ops::ControlFlow::Continue(());
    let mut solve = |p: f64, start: Option<&Solution>| {
        let start = start.map(|s| s.pressure.view());
        contact.solve(Control::MeanPressure(p), &settings, start, &mut watch).unwrap()
    };
    let low = solve(0.002, None);
    let [warm, cold] = [solve(0.01, Some(&low)), solve(0.01, None)];
    assert_eq!(contact_area(warm.pressure.view()), contact_area(cold.pressure.view()));
    assert_relative_eq!(warm.approach, cold.approach, max_relative = 1e-10);
}
