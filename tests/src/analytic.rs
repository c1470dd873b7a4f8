//! Contacts with closed forms. The error must fall with the grid spacing at an order that is measured here.

use std::f64::consts::{PI, TAU};

use gfmd_contact::{Load, Solution, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Height, Material};
use gfmd_measure::theory::{
    Persson, Westergaard, hertz_line, hertz_point, johnson_area_at_low_load, johnson_area_near_full_contact,
    johnson_full_contact_pressure,
};
use gfmd_measure::{Boundary, contact_area, pressure_statistics};
use gfmd_response::NormalResponse;
use gfmd_surface::{Discretisation, SelfAffine};
use ndarray::Array2;

use crate::check::{Worst, order};
use crate::{Check, Reference, ValidationError, press, press_on_half_space, unit_half_space};

const TOLERANCE: f64 = 1e-11;

type Solved = Result<Solution, ValidationError>;

pub(crate) fn checks(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let mut checks = westergaard()?;
    checks.extend(hertz()?);
    checks.extend(flat_punch(reference)?);
    checks.extend(johnson(reference)?);
    checks.extend(persson_slab(reference)?);
    checks.push(full_contact()?);
    Ok(checks)
}

fn line(profile: impl Fn(f64) -> f64, n: usize, mean_pressure: f64) -> Solved {
    let response = NormalResponse::new(Grid::line(n, 1.0)?, &unit_half_space()).into();
    let heights = Array2::from_shape_fn((n, 1), |(i, _)| profile(i as f64 / n as f64));
    Ok(press(&response, &heights, Load::MeanPressure(mean_pressure), Solver::Auto, TOLERANCE)?)
}

fn plane(profile: impl Fn(f64, f64) -> f64, n: usize, mean_pressure: f64) -> Solved {
    let heights = Array2::from_shape_fn((n, n), |(i, j)| profile(i as f64 / n as f64, j as f64 / n as f64));
    press_on_half_space(&heights, mean_pressure, TOLERANCE)
}

fn peak(solution: &Solution) -> f64 {
    solution.pressure.iter().copied().fold(0.0, f64::max)
}

fn mean_gap(solution: &Solution) -> f64 {
    solution.gap.mean().unwrap_or(f64::NAN)
}

/// Returns the errors on one grid, as root mean square over contacts that are shifted by fractions of the spacing. The
/// error of a single contact would jump with the position of its edge between two points.
fn shifted<const K: usize>(
    n: usize,
    errors: impl Fn(f64) -> Result<[f64; K], ValidationError>,
) -> Result<[f64; K], ValidationError> {
    const SHIFTS: usize = 5;
    let all = (0..SHIFTS).map(|k| errors(k as f64 / SHIFTS as f64 / n as f64)).collect::<Result<Vec<_>, _>>()?;
    Ok(std::array::from_fn(|k| (all.iter().map(|e| e[k].powi(2)).sum::<f64>() / SHIFTS as f64).sqrt()))
}

/// Returns the order at which the errors fall over all grids.
fn convergence<const K: usize>(
    grids: &[usize],
    errors: impl Fn(usize) -> Result<[f64; K], ValidationError>,
) -> Result<[f64; K], ValidationError> {
    let errors = grids.iter().map(|&n| Ok((n, errors(n)?))).collect::<Result<Vec<_>, ValidationError>>()?;
    Ok(order(&errors))
}

/// Returns the root mean square deviation of the pressure from `exact`, divided by the root mean square of `exact`.
fn deviation(solution: &Solution, exact: impl Fn(f64, f64) -> f64) -> f64 {
    let (nx, ny) = solution.pressure.dim();
    let sums = solution.pressure.indexed_iter().fold([0.0; 2], |sums, ((i, j), p)| {
        let exact = exact(i as f64 / nx as f64, j as f64 / ny as f64);
        [sums[0] + (p - exact).powi(2), sums[1] + exact.powi(2)]
    });
    (sums[0] / sums[1]).sqrt()
}

fn area(solution: &Solution) -> f64 {
    contact_area(solution.pressure.view(), Boundary::Periodic).fraction
}

fn westergaard() -> Result<Vec<Check>, ValidationError> {
    const WAVE: &str = "Westergaard 1939";
    let wave = Westergaard { modulus: 1.0, amplitude: 0.01, period: 1.0 };
    let mut checks = Vec::new();
    let mut edges = Worst::new();
    for load in [0.1, 0.3, 0.7] {
        let mean = load * wave.full_contact_pressure();
        let solve = |n: usize, shift: f64| line(|x| 0.01 * (TAU * (x - shift)).cos(), n, mean);
        let [gap, pressure] = convergence(&[128, 256, 512, 1024, 2048], |n| {
            shifted(n, |shift| {
                let solution = solve(n, shift)?;
                let gap = mean_gap(&solution) / wave.mean_gap(mean) - 1.0;
                Ok([gap, deviation(&solution, |x, _| wave.pressure(mean, x - shift))])
            })
        })?;
        edges.compare_to(area(&solve(1024, 0.0)?), wave.area(mean), 1.0 / 1024.0);
        // The pressure ends in a square root, and its error stems from one or two points at the edge: order 1. The mean
        // gap integrates a 3/2 power over the same stretch.
        checks.push(Check::at_least(format!("wave at {load} of full contact: order of the mean gap"), WAVE, gap, 1.5));
        checks.push(Check::at_least(
            format!("wave at {load} of full contact: order of the pressure"),
            WAVE,
            pressure,
            0.8,
        ));
    }
    // The position of each of the two edges is known only to the spacing.
    checks.push(edges.check("wave, 1024 points: contact width, in spacings", WAVE, 2.0));
    Ok(checks)
}

fn hertz() -> Result<Vec<Check>, ValidationError> {
    const HERTZ: &str = "Hertz 1882";
    let profile = |d: f64, edge: f64| (1.0 - (d / edge).powi(2)).max(0.0).sqrt();
    let half_width = 0.004;
    let force = PI * half_width * half_width / 4.0;
    let (edge, top) = hertz_line(1.0, 1.0, force);
    let of_line = convergence(&[1024, 2048, 4096, 8192], |n| {
        shifted(n, |shift| {
            let solution = line(|x| -(x - 0.5 - shift).powi(2) / 2.0, n, force)?;
            let pressure = deviation(&solution, |x, _| top * profile(x - 0.5 - shift, edge));
            Ok([pressure, area(&solution) / (2.0 * edge) - 1.0])
        })
    })?;
    let force = 4.0 * 0.05_f64.powi(3) / 3.0;
    let exact = hertz_point(1.0, 1.0, force);
    let of_point = convergence(&[64, 96, 128, 192, 256], |n| {
        shifted(n, |shift| {
            let distance = |x: f64, y: f64| (x - 0.5 - shift).hypot(y - 0.5 - 0.37 * shift);
            let solution = plane(|x, y| -distance(x, y).powi(2) / 2.0, n, force)?;
            let pressure = deviation(&solution, |x, y| exact.peak_pressure * profile(distance(x, y), exact.radius));
            let fraction = area(&solution) / (PI * exact.radius.powi(2)) - 1.0;
            Ok([pressure, peak(&solution) / exact.peak_pressure - 1.0, fraction])
        })
    })?;
    Ok(vec![
        Check::at_least("cylinder: order of the pressure", HERTZ, of_line[0], 0.8),
        Check::at_least("cylinder: order of the contact width", HERTZ, of_line[1], 0.8),
        Check::at_least("sphere: order of the pressure", HERTZ, of_point[0], 0.8),
        Check::at_least("sphere: order of the largest pressure", HERTZ, of_point[1], 1.2),
        Check::at_least("sphere: order of the contact area", HERTZ, of_point[2], 0.8),
    ])
}

/// Checks a row of flat punches with singular edges: m points act like a punch of nearly m spacings.
fn flat_punch(reference: &Reference) -> Result<[Check; 2], ValidationError> {
    const PUNCH: &str = "closed form of a row of flat punches";
    let file = reference.json("theory_curves.json")?;
    let (mut slowest, mut width) = (None, Worst::new());
    for row in file["flat_punch_periodic_line"].as_array().into_iter().flatten() {
        let [fraction, wanted] = [0, 1].map(|column| row[column].as_f64().unwrap_or(f64::NAN));
        let depth = |n: usize| -> Result<f64, ValidationError> {
            let (edge, mean) = (fraction - 0.5 / n as f64, 1e-3);
            Ok(line(|x| if x < edge { 0.0 } else { -1.0 }, n, mean)?.approach / mean)
        };
        let [order] = convergence(&[160, 320, 640, 1280], |n| Ok([(depth(n)? - wanted).abs()]))?;
        slowest = Some(slowest.map_or(order, |slowest: f64| slowest.min(order)));
        // The depth of a punch of width w is (2/π) ln(1/sin(π w/2)), in units of p L/E*.
        let acts_like = 2.0 / PI * (-0.5 * PI * depth(1280)?).exp().asin();
        width.compare_to(acts_like, fraction, 1.0 / 1280.0);
    }
    Ok([
        Check::at_least("flat strip punches: slowest order of the depth", PUNCH, slowest.unwrap_or(f64::NAN), 0.9),
        width.check("flat strip punches: width they act like, in spacings", PUNCH, 0.5),
    ])
}

/// Checks the variance of the full-contact pressure of a slab relative to a half-space, for continuous spectra.
fn persson_slab(reference: &Reference) -> Result<[Check; 2], ValidationError> {
    const QUADRATURE: &str = "independent quadrature";
    let file = reference.json("theory_curves.json")?;
    let (mut variance, mut area) = (Worst::new(), Worst::new());
    for row in file["persson_slab"].as_array().into_iter().flatten() {
        let column = |index: usize| row[index].as_f64().unwrap_or(f64::NAN);
        let [poisson, height, low, high, hurst, gradient] = [0, 1, 2, 3, 4, 5].map(column);
        let material = Material::from_young(1.0, poisson)?;
        let body = Body::new(material, Height::Finite(height))?;
        let modulus = material.contact_modulus();
        // Self-affine between the wavenumbers low and high, in equal steps of the logarithm.
        let count = 20_000;
        let step = (high / low).ln() / f64::from(count);
        let power = |q: f64| q.powf(-2.0 * hurst);
        let nodes = (0..count).map(|k| low * (step * (f64::from(k) + 0.5)).exp());
        let unit: f64 = nodes.clone().map(|q| power(q) * q * q).sum();
        let waves: Vec<(f64, f64)> = nodes.map(|q| (q, gradient * gradient * power(q) / unit)).collect();
        let theory = |stiffness: &dyn Fn(f64) -> f64| Persson::new(waves.iter().copied(), stiffness);
        let theories = (theory(&|q| body.normal_stiffness(q)), theory(&|q| 0.5 * modulus * q));
        let (Some(slab), Some(half_space)) = theories else {
            variance.compare(f64::NAN, column(6));
            continue;
        };
        variance.compare(slab.variance(f64::INFINITY) / half_space.variance(f64::INFINITY), column(6));
        area.compare(slab.area(0.05 * modulus * gradient, f64::INFINITY), column(8));
    }
    Ok([
        variance.check("Persson on slabs: variance of the pressure in full contact", QUADRATURE, 1e-4),
        area.check("Persson on slabs: contact area", QUADRATURE, 1e-4),
    ])
}

fn johnson(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    const NUMERICAL: &str = "Polonsky-Keer, three grids";
    const ASYMPTOTE: &str = "Johnson, Greenwood, Higginson 1985";
    let full = johnson_full_contact_pressure(1.0, 0.01, 1.0);
    let wavy = |x: f64, y: f64| 0.01 * (TAU * x).cos() * (TAU * y).cos();
    let [mut area_error, mut gap_error, mut peak_error] = [Worst::new(); 3];
    let file = reference.json("analytic/jgh_numeric.json")?;
    for row in file["rows"].as_array().into_iter().flatten() {
        for n in [128, 256] {
            let get = |key: &str| row[format!("n{n}")][key].as_f64().unwrap_or(f64::NAN);
            let solution = plane(wavy, n, row["pbar_over_pstar"].as_f64().unwrap_or(f64::NAN) * full)?;
            area_error.compare_to(area(&solution), get("nodal_area_fraction"), 1.0);
            gap_error.compare_to(mean_gap(&solution) / 0.01, get("mean_gap_over_Delta"), 1.0);
            peak_error.compare(peak(&solution) / full, get("p_max_over_pstar"));
        }
    }
    // The asymptotes hold only near zero and near full load.
    let low = contact_area(plane(wavy, 384, 0.002 * full)?.pressure.view(), Boundary::Periodic).corrected_fraction;
    let high = 1.0 - area(&plane(wavy, 384, 0.98 * full)?);
    let [mut at_low, mut at_high] = [Worst::new(); 2];
    at_low.compare(low, johnson_area_at_low_load(0.002));
    at_high.compare(high, 1.0 - johnson_area_near_full_contact(0.98));
    Ok(vec![
        area_error.check("doubly wavy surface: area, first touch to full contact", NUMERICAL, 1e-12),
        gap_error.check("doubly wavy surface: mean gap over amplitude", NUMERICAL, 1e-9),
        peak_error.check("doubly wavy surface: largest pressure", NUMERICAL, 1e-8),
        at_low.check("doubly wavy surface at 0.002 of full contact: area", ASYMPTOTE, 0.04),
        at_high.check("doubly wavy surface at 0.98 of full contact: gap area", ASYMPTOTE, 0.05),
    ])
}

/// Checks that the pressure at full contact is Persson's Gaussian: its variance is (E* g/2)², exactly.
fn full_contact() -> Result<Check, ValidationError> {
    let gradient = 0.1;
    let numbers = Discretisation { eps_t_inv: 4.0, eps_f_inv: 8.0, eps_c_inv: 4.0 };
    let grid = Grid::square(numbers.points()?, 1.0)?;
    let heights = numbers
        .self_affine(1.0, SelfAffine { hurst: 0.5, ..SelfAffine::with_rms_gradient(gradient) })
        .heights(&grid, 5)?;
    let mut worst = Worst::new();
    for p_star in [4.0, 8.0] {
        let solution = press_on_half_space(&heights, p_star * gradient, TOLERANCE)?;
        worst.compare(area(&solution), 1.0);
        let pressure = pressure_statistics(solution.pressure.view());
        worst.compare(pressure.moments[0] - pressure.mean.powi(2), (gradient / 2.0).powi(2));
    }
    Ok(worst.check("rough surface in full contact: variance of the pressure", "Persson 2001", 1e-9))
}
