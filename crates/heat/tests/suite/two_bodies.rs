//! Heat shared between two bodies.

use std::ops::ControlFlow;

use approx::assert_relative_eq;
use gfmd_field::Grid;
use gfmd_heat::{Budget, Flash, HeatError, Watch};
use ndarray::Array2;

use crate::{heat, patches, thermal};

#[test]
fn equal_bodies_at_rest_share_the_heat_equally() {
    let grid = Grid::square(32, 1.0).unwrap();
    let body = thermal(2.0, 0.3);
    let state = heat(&Flash::new(grid, [0.0, 0.0], body, Some(body)).unwrap(), &patches(&grid, 0), 1e-12);
    assert_relative_eq!(state.fraction, 0.5, max_relative = 1e-10);
}

#[test]
fn both_bodies_have_one_temperature_where_they_touch() {
    let grid = Grid::new([48, 40], [1.0, 0.8]).unwrap();
    let flux = patches(&grid, 1);
    for (speed, conductivity) in [(0.01, 0.6), (3.0, 0.6), (300.0, 1e-3), (300.0, 1e3), (1e5, 0.6)] {
        let flash =
            Flash::new(grid, [speed, 0.4 * speed], thermal(1.5, 0.08), Some(thermal(conductivity, 0.3))).unwrap();
        let state = heat(&flash, &flux, 1e-10);
        assert!(state.residual <= 1e-10 && (&flux * &state.temperature).sum() > 0.0);
        assert!(state.iterations < 80, "{} iterations at {speed}, {conductivity}", state.iterations);
        // A better conductor takes more of the heat, and so does a moving surface.
        match conductivity {
            1e-3 => assert!(state.fraction > 0.999),
            1e3 => assert!(state.fraction < 0.1),
            _ => assert!((0.7..1.01).contains(&state.fraction), "{}", state.fraction),
        }
        let again = flash.certify(&flux, &state.into_body).unwrap();
        assert_eq!((again.temperature, again.residual), (state.temperature, state.residual));
        // A different flux does not give equal temperatures, nor does heat that flows across the gap.
        let mut other = state.into_body.clone();
        let place = flux.iter().position(|q| *q == 0.0).unwrap();
        other[[place / 40, place % 40]] = 1.0;
        assert!(flash.certify(&flux, &other).unwrap().residual > 0.1);
        assert!(flash.certify(&flux, &(&state.into_body * 1.001)).unwrap().residual > 1e-7);
    }
}

#[test]
fn the_number_of_iterations_hardly_grows_with_the_grid() {
    let counts = [32, 128].map(|n| {
        let grid = Grid::square(n, 1.0).unwrap();
        let flash = Flash::new(grid, [4.0, 1.0], thermal(1.5, 0.08), Some(thermal(0.6, 0.3))).unwrap();
        heat(&flash, &patches(&grid, 3), 1e-8).iterations
    });
    assert!(counts[1] < 2 * counts[0], "{counts:?}");
}

#[test]
fn every_tolerance_is_met() {
    // The rise is unknown when the search begins, and its first estimate may be far too large.
    for case in 0..60 {
        let grid = Grid::square(16, 1.0).unwrap();
        let flash =
            Flash::new(grid, [f64::from(case), 1.0], thermal(1.0, 0.1), Some(thermal(0.1 * f64::from(case + 1), 0.2)));
        for tolerance in [1e-3, 1e-8, 1e-12] {
            assert!(heat(flash.as_ref().unwrap(), &patches(&grid, case as u64), tolerance).residual <= tolerance);
        }
    }
}

#[test]
fn full_contact_leaves_the_mean_of_the_flux_open() {
    let grid = Grid::square(16, 1.0).unwrap();
    let flux = patches(&grid, 0) + 0.1;
    let flash = Flash::new(grid, [4.0, 1.0], thermal(1.5, 0.08), Some(thermal(0.6, 0.3))).unwrap();
    let state = heat(&flash, &flux, 1e-12);
    assert!(state.fraction.is_nan());
    assert!(state.max_rise > 0.0);
    assert!(state.into_body.sum().abs() < 1e-10);
}

#[test]
fn no_heat_is_a_state_without_rises() {
    let grid = Grid::square(8, 1.0).unwrap();
    for indenter in [None, Some(thermal(0.6, 0.3))] {
        let flash = Flash::new(grid, [4.0, 1.0], thermal(1.5, 0.08), indenter).unwrap();
        let state = heat(&flash, &Array2::zeros((8, 8)), 1e-8);
        assert_eq!((state.mean_flux, state.residual, state.iterations), (0.0, 0.0, 0));
        assert!(state.max_rise.is_nan() && state.temperature.iter().all(|t| *t == 0.0));
    }
}

#[test]
fn a_search_that_ends_early_carries_its_state() {
    let grid = Grid::square(32, 1.0).unwrap();
    let flash = Flash::new(grid, [4.0, 1.0], thermal(1.5, 0.08), Some(thermal(0.6, 0.3))).unwrap();
    let flux = patches(&grid, 3);
    let of = |budget: Budget, watch: &mut dyn Watch| flash.heat(&flux, &budget, watch).unwrap_err();
    let error = of(Budget { max_iterations: 2, ..Budget::default() }, &mut ());
    assert!(error.to_string().contains("the iteration limit"), "{error}");
    assert_eq!(error.into_state().unwrap().iterations, 2);
    let mut stop = |now: &gfmd_relax::Progress| match now.iteration {
        3 => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    let error = of(Budget::default(), &mut stop);
    assert!(matches!(error, HeatError::Interrupted { .. }) && error.into_state().unwrap().residual > 1e-8);
    // Rounding is reported as a failure, after searches from recomputed residuals, which stop when they are told to.
    let tight = Budget { tolerance: 1e-15, ..Budget::default() };
    let stopped_at = |last: usize| {
        let mut seen = 0;
        let error = of(tight, &mut |_: &gfmd_relax::Progress| {
            seen += 1;
            if seen == last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        (error, seen)
    };
    let (error, all) = stopped_at(usize::MAX);
    assert!(matches!(error, HeatError::NotConverged { .. }), "{error}");
    for last in 1..=all {
        let (error, _) = stopped_at(last);
        assert!(matches!(error, HeatError::Interrupted { .. }), "{last} of {all}: {error}");
    }
}

#[test]
fn the_bits_are_those_of_one_thread() {
    let grid = Grid::square(64, 1.0).unwrap();
    let flash = Flash::new(grid, [4.0, 1.0], thermal(1.5, 0.08), Some(thermal(0.6, 0.3))).unwrap();
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| heat(&flash, &patches(&grid, 3), 1e-9).temperature)
    };
    assert_eq!(of(1), of(3));
}
