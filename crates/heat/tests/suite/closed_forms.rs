//! Comparison with exact temperatures: a strip and a square, at rest and moving.

use std::f64::consts::{PI, TAU};

use approx::assert_relative_eq;
use gfmd_field::Grid;
use gfmd_heat::{Budget, Flash, HeatError, Thermal};
use ndarray::Array2;

use crate::{heat, patches, thermal};

/// Computes e^z K₀(z) and e^z K₁(z) by the trapezoidal rule; the integrands decay doubly exponentially.
fn bessel(z: f64) -> [f64; 2] {
    let step = 0.25 / (z + 16.0).sqrt();
    let mut sums = [0.5, 0.5];
    for k in 1.. {
        let cosh = (step * f64::from(k)).cosh();
        let value = (-z * (cosh - 1.0)).exp();
        if value * cosh < 1e-18 {
            break;
        }
        sums = [sums[0] + value, sums[1] + value * cosh];
    }
    sums.map(|sum| step * sum)
}

/// Computes ∫ e^{−u} K₀(|u|) du from 0 to z.
fn before(z: f64) -> f64 {
    let [k0, k1] = if z == 0.0 { return 0.0 } else { bessel(z.abs()) };
    if z > 0.0 { z * (-2.0 * z).exp() * (k0 - k1) + 1.0 } else { 1.0 + z * (k0 + k1) }
}

/// Hurwitz zeta function.
fn zeta(s: f64, a: f64) -> f64 {
    let n = 40;
    let end = f64::from(n) + a;
    (0..n).map(|k| (f64::from(k) + a).powf(-s)).sum::<f64>()
        + end.powf(1.0 - s) / (s - 1.0)
        + 0.5 * end.powf(-s)
        + s / 12.0 * end.powf(-s - 1.0)
}

/// Jaeger's (1942) temperature of a strip of half width 1 and flux 1 on a body of conductivity 1, at distance x from
/// its middle.
fn strip(x: f64, beta: f64) -> f64 {
    (before(beta * (x + 1.0)) - before(beta * (x - 1.0))) / (PI * beta)
}

/// Temperature of a strip in a cell of length L, relative to the mean: the trails of the strips in front pass over it.
fn strip_in_cell(x: f64, beta: f64, length: f64) -> f64 {
    let near = 100;
    let images: f64 = (-near..=near).map(|n| strip(x - f64::from(n) * length, beta)).sum();
    // Far behind, a strip acts as a line source with heat 2: (2/k) √(α/(πvξ)) (1 − 1/(8βξ)), v/α = 2β.
    let sum = |s: f64| length.powf(-s) * zeta(s, f64::from(near) + 1.0 - x / length);
    images + 2.0 / (TAU * beta).sqrt() * (sum(0.5) - sum(1.5) / (8.0 * beta))
}

#[test]
fn a_moving_strip_has_jaegers_temperature() {
    let length = 16.0;
    for peclet in [0.5, 5.0, 50.0] {
        let errors = [512, 1024, 2048].map(|n| {
            let grid = Grid::line(n, length).unwrap();
            let place = |i: usize| (i as f64 + 0.5) * length / n as f64 - 0.5 * length;
            let flux = Array2::from_shape_fn((n, 1), |(i, _)| if place(i).abs() < 1.0 { 1.0 } else { 0.0 });
            // v l/(2α) = Pe.
            let flash = Flash::new(grid, [0.6, 0.0], thermal(1.0, 0.3 / peclet), None).unwrap();
            let state = heat(&flash, &flux, 1e-8);
            let highest = strip(-1.0, peclet).max(strip(-0.5, peclet));
            // Excludes the steps of the flux at the ends of the strip, which the grid does not resolve.
            let is_inside = |x: &f64| (x.abs() - 1.0).abs() > 0.25;
            let worst = (0..n)
                .filter(|i| is_inside(&place(*i)))
                .map(|i| (state.temperature[[i, 0]] - strip_in_cell(place(i), peclet, length)).abs());
            worst.fold(0.0, f64::max) / highest
        });
        let order = 0.5 * (errors[0] / errors[2]).log2();
        assert!(errors[2] < 2e-4 && order > 1.7, "Pe = {peclet}: order {order}, {errors:?}");
    }
}

/// Contribution of the periodic images to the temperature at the middle of a moving square of side 2, relative to the
/// mean: the sum of e^{−β(r+x)}/r, averaged over y in a square, minus its mean. Image n lies in front, so that its
/// trail passes over the middle; far behind, r + x is y²/(2|x|).
fn images(beta: f64, length: f64) -> f64 {
    let rows = 20_000;
    let mut sum = 2.0 * (1..9).map(|m| (-beta * f64::from(m) * length).exp() / (f64::from(m) * length)).sum::<f64>();
    for n in 1..=rows {
        let x = f64::from(n) * length;
        let scale = (beta / (2.0 * x)).sqrt();
        let part = |m: i32| {
            let [low, high] = [-1.0, 1.0].map(|end| libm::erf(scale * (f64::from(m) * length + end)));
            0.25 * PI.sqrt() * (high - low) / (scale * x)
        };
        let most = (6.0 / (scale * length)).ceil() as i32;
        sum += part(0) + 2.0 * (1..=most).map(part).sum::<f64>();
    }
    // The mean, ∫∫ e^{−β(r+x)}/r dx dy = ∫ 2 e^{−βx} K₀(β|x|) dx, up to the middle between two rows.
    let end = (f64::from(rows) + 0.5) * length;
    let mean = 2.0 * (1.0 - before(-beta * end)) / beta;
    4.0 / TAU * (sum - mean / (length * length))
}

#[test]
fn a_square_has_its_temperature_at_rest_and_that_of_tian_and_kennedy_when_it_moves() {
    let (n, length) = (512, 32.0);
    let grid = Grid::square(n, length).unwrap();
    let place = |i: usize| (i as f64 + 0.5) * length / n as f64 - 0.5 * length;
    let inside = |i: usize| place(i).abs() < 1.0;
    let flux = Array2::from_shape_fn((n, n), |(i, j)| if inside(i) && inside(j) { 1.0 } else { 0.0 });
    let rest = heat(&Flash::new(grid, [0.0, 0.0], thermal(1.0, 1.0), None).unwrap(), &flux, 1e-8);
    let exact = 4.0 / PI * (1.0 + 2.0_f64.sqrt()).ln();
    // The images and the mean, by the Madelung sum of a square lattice.
    let found = rest.max_rise + 3.90026 * 4.0 / (TAU * length);
    assert_relative_eq!(found, exact, max_relative = 3e-3);
    for peclet in [1.0, 10.0, 100.0] {
        let flash = Flash::new(grid, [2.0 * peclet, 0.0], thermal(1.0, 1.0), None).unwrap();
        let found = heat(&flash, &flux, 1e-8).max_rise - images(peclet, length);
        let fit = 2.0 / (PI * (1.011 + peclet)).sqrt();
        assert!((found / fit - 1.0).abs() < 0.02, "Pe = {peclet}: {found} {fit}");
    }
}

#[test]
fn the_heat_warms_the_points_at_which_it_flows() {
    for (seed, velocity) in [[0.0, 0.0], [3.0, 0.0], [-40.0, 25.0], [0.0, 1e6]].into_iter().enumerate() {
        for grid in [Grid::square(24, 1.0).unwrap(), Grid::new([15, 8], [1.0, 2.0]).unwrap()] {
            let flux = patches(&grid, seed as u64);
            let state = heat(&Flash::new(grid, velocity, thermal(2.0, 0.1), None).unwrap(), &flux, 1e-8);
            assert!((&flux * &state.temperature).sum() > 0.0);
            assert!(state.temperature.sum().abs() < 1e-12 * state.max_rise * flux.len() as f64);
        }
    }
}

#[test]
fn a_source_that_turns_back_leaves_its_trail_on_the_other_side() {
    let grid = Grid::new([32, 20], [1.0, 0.7]).unwrap();
    let mirrored = |field: &Array2<f64>| Array2::from_shape_fn((32, 20), |(i, j)| field[[(32 - i) % 32, j]]);
    let flux = patches(&grid, 2);
    let of = |speed: f64, flux: &Array2<f64>| {
        heat(&Flash::new(grid, [speed, 0.3], thermal(2.0, 0.1), None).unwrap(), flux, 1e-8).temperature
    };
    let (there, back) = (of(5.0, &flux), mirrored(&of(-5.0, &mirrored(&flux))));
    assert!(there.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-13));
}

#[test]
fn unusable_input_is_refused() {
    for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(Thermal::new(value, 1.0).unwrap_err().to_string().starts_with("the conductivity is"));
        assert!(Thermal::new(1.0, value).unwrap_err().to_string().starts_with("the diffusivity is"));
    }
    let grid = Grid::square(8, 1.0).unwrap();
    let made = |v: f64| Flash::new(grid, [v, 0.0], thermal(1.0, 1.0), None);
    assert!(matches!(made(f64::NAN), Err(HeatError::Velocity(_))));
    let refused = |flux: &Array2<f64>| made(1.0).unwrap().heat(flux, &Budget::default(), &mut ()).unwrap_err();
    assert!(matches!(refused(&Array2::zeros((8, 7))), HeatError::Points { found: 56, expected: 64 }));
    for value in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(&Array2::from_elem((8, 8), value)), HeatError::Flux(_)));
    }
    let budget = Budget { tolerance: 0.0, ..Budget::default() };
    let error = made(1.0).unwrap().heat(&Array2::zeros((8, 8)), &budget, &mut ()).unwrap_err();
    assert!(matches!(error, HeatError::Tolerance(_)));
}
