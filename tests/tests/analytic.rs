//! Closed forms: the error must fall with the grid spacing, at an order that is measured here.

use std::f64::consts::{PI, TAU};

use approx::assert_relative_eq;
use gfmd_contact::{Contact, Control, Settings, Solution, SurfaceResponse};
use gfmd_field::Grid;
use gfmd_measure::theory::{
    Westergaard, hertz_line, hertz_point, johnson_area_at_low_load, johnson_area_near_full_contact,
    johnson_full_contact_pressure, persson_area,
};
use gfmd_measure::{contact_area, pressure_statistics};
use gfmd_surface::Discretisation;
use gfmd_tests::{number, press, press_on_half_space, reference, unit_half_space};
use ndarray::Array2;

const TOLERANCE: f64 = 1e-11;

fn line(profile: impl Fn(f64) -> f64, n: usize, mean_pressure: f64) -> Solution {
    let response = SurfaceResponse::new(Grid::line(n, 1.0).unwrap(), &unit_half_space());
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

/// Order at which the errors fall, by least squares over all grids: single errors jump with the place of the contact
/// edge between two points.
fn order(grids: &[usize], error: impl Fn(usize) -> f64) -> f64 {
    let points: Vec<[f64; 2]> = grids.iter().map(|&n| [(n as f64).ln(), -error(n).ln()]).collect();
    let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64;
    let [x, y] = [mean(0), mean(1)];
    let slope: f64 = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum();
    slope / points.iter().map(|p| (p[0] - x).powi(2)).sum::<f64>()
}

#[test]
fn westergaard() {
    let wave = Westergaard { modulus: 1.0, amplitude: 0.01, period: 1.0 };
    let grids = [64, 96, 128, 192, 256, 384, 512, 768, 1024, 1536, 2048, 3072, 4096];
    for load in [0.1, 0.3, 0.7] {
        let mean = load * wave.full_contact_pressure();
        let solve = |n: usize| line(|x| 0.01 * (TAU * x).cos(), n, mean);
        let gap = order(&grids, |n| (solve(n).gap.mean().unwrap() - wave.mean_gap(mean)).abs() / 0.01);
        let top = order(&grids, |n| (peak(&solve(n)) / wave.pressure(mean, 0.0) - 1.0).abs());
        let rms = order(&grids, |n| {
            let solution = solve(n);
            let error = |(i, p): (usize, &f64)| (p - wave.pressure(mean, i as f64 / n as f64)).powi(2);
            (solution.pressure.iter().enumerate().map(error).sum::<f64>() / n as f64).sqrt() / mean
        });
        let area = order(&grids, |n| {
            (contact_area(solve(n).pressure.view()).fraction - wave.area(mean)).abs() + 0.1 / n as f64
        });
        println!("load {load}: order gap {gap:.2} peak {top:.2} rms pressure {rms:.2} area {area:.2}");
        let s = solve(4096);
        println!("  4096: gap {:.1e} peak {:.1e}", (s.gap.mean().unwrap() - wave.mean_gap(mean)).abs() / 0.01, (peak(&s) / wave.pressure(mean, 0.0) - 1.0).abs());
    }
}

#[test]
fn hertz() {
    let (radius, width) = (1.0, 0.004);
    let force = PI * width * width / (4.0 * radius);
    let (half_width, top) = hertz_line(1.0, radius, force);
    let solve = |n: usize| line(|x| -(x - 0.5).powi(2) / (2.0 * radius), n, force);
    for n in [1024, 2048, 4096, 8192, 16384, 32768] {
        let s = solve(n);
        println!("line {n} {:.2e} area {:.2e}", peak(&s) / top - 1.0, contact_area(s.pressure.view()).fraction/(2.0*half_width) - 1.0);
    }
    let a: f64 = 0.04;
    let force = 4.0 * a.powi(3) / 3.0;
    let exact = hertz_point(1.0, 1.0, force);
    for n in [64, 96, 128, 192, 256, 384, 512, 768, 1024] {
        let s = plane(|x, y| -((x - 0.5).powi(2) + (y - 0.5).powi(2)) / 2.0, n, force);
        let ar = contact_area(s.pressure.view());
        println!("point {n} {:.2e} area {:.2e} corrected {:.2e}", peak(&s) / exact.peak_pressure - 1.0, ar.fraction/(PI*a*a)-1.0, ar.corrected_fraction/(PI*a*a)-1.0);
    }
}
